//! KTX2 decoder.

use std::io::{self, Read};

use ktx2::{
    ColorPrimaries, Header, KeyValueDataIterator, LevelIndex, ParseError, SupercompressionScheme, TransferFunction,
};

use crate::error::ImageError;
use crate::header::decoded::{invalid, unsupported};
use crate::picture::png::MAPPING_KEY;
use crate::picture::primaries::Primaries;
use crate::pixel::Pixel;
use crate::texture::stored_format::StoredFormat;
use crate::texture::stored_texture::{FACES, OF_AN_ARRAY, OF_BYTES, StoredTexture};

/// The largest compression ratio of Zstandard: a block of one repeated byte stores 128 KiB in four bytes.
const MOST_BYTES_PER_BYTE: u64 = 1 << 15;

/// The offset of the color model in the data format: after the total length and the head of the first block. The bytes
/// of primaries and transfer function follow it.
const DFD_MODEL: usize = 4 + 8;

/// What the headers of a KTX2 file say; `name` stands for the file in messages.
pub(crate) fn header(bytes: &[u8], name: &str, max_texels: usize) -> Result<StoredTexture, ImageError> {
    let header = parsed(bytes, name)?;
    let faces = faces(&header, name)?;
    let format = texel_format(&header, name)?;
    let size = [header.pixel_width, header.pixel_height];
    let mut texture = StoredTexture::new(format, size, faces, header.level_count, max_texels, name)?;
    let index = level_index(bytes, texture.levels, name)?;
    check_places(&header, &index, bytes.len(), name)?;
    tell(&header, bytes, &mut texture, name)?;
    texture.primaries = primaries(&header, bytes);
    Ok(texture)
}

/// Decodes a level, face after face.
pub(crate) fn level(texture: &StoredTexture, bytes: &[u8], k: usize, name: &str) -> Result<Vec<Pixel>, ImageError> {
    let zstd = parsed(bytes, name)?.supercompression_scheme.is_some();
    let level = level_index(bytes, texture.levels, name)?[k];
    let expected = texture.faces as u64 * texture.picture_bytes(k);
    let stored = level.byte_length;
    let most = if zstd { stored.saturating_mul(MOST_BYTES_PER_BYTE) } else { stored };
    if level.uncompressed_byte_length != expected || most < expected || (!zstd && stored != expected) {
        let ([width, height], format) = (texture.level_size(k), texture.format.format);
        let message = format!(
            "level {k}, {width} x {height} {format}, needs {expected} bytes; the file says {} and holds {stored}",
            level.uncompressed_byte_length
        );
        return Err(invalid(name, message));
    }
    // The range was checked.
    let data = &bytes[level.byte_offset as usize..][..stored as usize];
    let mut texels = texture.reserved(k, name)?;
    let mut source = level_source(data, zstd).map_err(|e| damaged(k, &e, name))?;
    for _ in 0..texture.faces {
        texture.read(k, &mut source, &mut texels).map_err(|e| damaged(k, &e, name))?;
    }
    if !matches!(source.read(&mut [0]), Ok(0)) {
        return Err(invalid(name, format!("level {k} holds more than its {expected} bytes")));
    }
    Ok(texels)
}

fn parsed(bytes: &[u8], name: &str) -> Result<Header, ImageError> {
    let Some(start) = bytes.first_chunk() else {
        return Err(invalid(name, "the file ends early: the header is not all there".into()));
    };
    Header::from_bytes(start).map_err(|e| explain(&e, name))
}

/// The number of pictures in a level: 6 of a cube, which an array of six squares is taken for, or 1.
fn faces(header: &Header, name: &str) -> Result<usize, ImageError> {
    let (w, h, d) = (header.pixel_width, header.pixel_height, header.pixel_depth);
    let faces = match (header.face_count, header.layer_count) {
        (6, 0 | 1) => FACES,
        (1, 6) if w == h => FACES,
        (1, 0 | 1) => 1,
        (1 | 6, layers) => {
            return Err(unsupported(name, format!("one picture or cube map expected, found an array of {layers}")));
        }
        (faces, _) => {
            let message = format!("a cube map of 6 faces expected, found a texture of {w} x {h}, {faces} face(s)");
            return Err(invalid(name, message));
        }
    };
    match faces {
        FACES if w != h || d != 0 => {
            Err(invalid(name, format!("the faces of a cube are square and flat, these are {w} x {h} x {d}")))
        }
        1 if d > 1 => Err(unsupported(name, format!("a picture expected, found a volume of {w} x {h} x {d}"))),
        faces => Ok(faces),
    }
}

fn texel_format(header: &Header, name: &str) -> Result<StoredFormat, ImageError> {
    let expected = "RGBA16F, RGBA32F, RGB16F, RGB32F, RGB9E5, R11G11B10F, BC6H, RGB8 or RGBA8 expected";
    let Some(vulkan) = header.format else {
        let message = format!("{expected}, found a universal texture (Basis), which holds no high dynamic range");
        return Err(unsupported(name, message));
    };
    let Some(format) = StoredFormat::from_vulkan(vulkan) else {
        return Err(unsupported(name, format!("{expected}, found the Vulkan format {vulkan:?}")));
    };
    match header.supercompression_scheme {
        None | Some(SupercompressionScheme::Zstandard) => Ok(format),
        Some(other) => {
            Err(unsupported(name, format!("Zstandard or no supercompression expected, found scheme {other:?}")))
        }
    }
}

/// The positions of the levels in the file, the largest level first.
fn level_index(bytes: &[u8], levels: usize, name: &str) -> Result<Vec<LevelIndex>, ImageError> {
    let entries = bytes[Header::LENGTH..].as_chunks::<{ LevelIndex::LENGTH }>().0;
    match entries.get(..levels) {
        Some(entries) => Ok(entries.iter().map(LevelIndex::from_bytes).collect()),
        None => Err(invalid(name, "the file ends early: the index of the levels is not all there".into())),
    }
}

/// Refuses parts of the file that overlap, or lie outside it.
fn check_places(header: &Header, levels: &[LevelIndex], length: usize, name: &str) -> Result<(), ImageError> {
    let part = |what: &str, offset: u64, length: u64| (what.to_owned(), offset..offset.saturating_add(length));
    let index = &header.index;
    let mut parts = vec![
        part("the header", 0, (Header::LENGTH + levels.len() * LevelIndex::LENGTH) as u64),
        part("the data format", index.dfd_byte_offset.into(), index.dfd_byte_length.into()),
        part("the key/value data", index.kvd_byte_offset.into(), index.kvd_byte_length.into()),
        part("the global data", index.sgd_byte_offset, index.sgd_byte_length),
    ];
    parts.extend(levels.iter().enumerate().map(|(k, l)| part(&format!("level {k}"), l.byte_offset, l.byte_length)));
    parts.sort_by_key(|(_, range)| range.start);
    if let Some((what, _)) = parts.iter().find(|(_, range)| range.end > length as u64) {
        return Err(invalid(name, format!("the file ends early: {what} is not all there")));
    }
    parts.retain(|(_, range)| !range.is_empty());
    for pair in parts.windows(2) {
        if pair[0].1.end > pair[1].1.start {
            return Err(invalid(name, format!("{} and {} overlap in the file", pair[0].0, pair[1].0)));
        }
    }
    Ok(())
}

/// A reader of the decompressed bytes of a level.
fn level_source(stored: &[u8], zstd: bool) -> io::Result<Box<dyn Read + '_>> {
    if zstd { Ok(Box::new(zstd::Decoder::with_buffer(stored)?)) } else { Ok(Box::new(stored)) }
}

/// Adds what the keys and the descriptor say; refuses an orientation that would turn the faces of a cube around.
fn tell(header: &Header, bytes: &[u8], texture: &mut StoredTexture, name: &str) -> Result<(), ImageError> {
    let keys = &bytes[header.index.kvd_byte_offset as usize..][..header.index.kvd_byte_length as usize];
    for (key, value) in KeyValueDataIterator::new(keys) {
        let value = String::from_utf8_lossy(value);
        let value = value.trim_end_matches('\0');
        match key {
            "KTXorientation" if value == "ru" && !texture.is_cube() => texture.is_from_bottom = true,
            "KTXorientation" if value != "rd" => {
                let what = if texture.is_cube() { "cube faces" } else { "a picture" };
                let message = format!("{what} with orientation \"rd\" expected, found {value:?}");
                return Err(unsupported(name, message));
            }
            "KTXswizzle" if !value.starts_with("rgb") => {
                let message = format!("channels in the order rgb expected, found KTXswizzle {value:?}");
                return Err(unsupported(name, message));
            }
            MAPPING_KEY => texture.mapping = Some(value.to_owned()),
            _ => {}
        }
    }
    if header.level_count == 0 {
        texture.notes.push("the file asks for smaller levels to be made; it holds one".into());
    }
    if header.face_count == 1 && texture.is_cube() {
        texture.notes.push(OF_AN_ARRAY.into());
    }
    match (TransferFunction::new(described(header, bytes, 2)), texture.format.of_srgb()) {
        (Some(TransferFunction::SRGB), Some(encoded)) => texture.format = encoded,
        (None | Some(TransferFunction::Linear), _) => {}
        (Some(other), _) => {
            let message = format!("linear light expected, found the transfer function {other:?}");
            return Err(unsupported(name, message));
        }
    }
    if texture.format.of_srgb().is_some() {
        texture.notes.push(OF_BYTES.into());
    }
    Ok(())
}

/// A byte of the descriptor of the format, counted from the color model. The format number determines all but the primaries and the transfer
/// function; a file without the descriptor is read all the same.
fn described(header: &Header, bytes: &[u8], at: usize) -> u8 {
    let format = &bytes[header.index.dfd_byte_offset as usize..][..header.index.dfd_byte_length as usize];
    format.get(DFD_MODEL + at).copied().unwrap_or(0)
}

/// The white of daylight, D65.
const D65: [f64; 2] = [0.3127, 0.3290];

/// The white of ACES.
const ACES_WHITE: [f64; 2] = [0.32168, 0.33767];

/// Illuminant C, as NTSC and the Japanese standard of 525 lines have it.
const C: [[f64; 2]; 2] = [[0.310, 0.316], [0.3101, 0.3162]];

/// Primaries other than those of Rec. 709, and their chromaticities, as Khronos' own library of descriptors has them (dfdutils). Those of CIE XYZ are no colors.
fn primaries(header: &Header, bytes: &[u8]) -> Option<(String, Option<Primaries>)> {
    let primaries = ColorPrimaries::new(described(header, bytes, 1)).filter(|p| *p != ColorPrimaries::BT709)?;
    let [red, green, blue, white] = match primaries {
        ColorPrimaries::BT601EBU => [[0.640, 0.330], [0.290, 0.600], [0.150, 0.060], D65],
        ColorPrimaries::BT601SMPTE => [[0.630, 0.340], [0.310, 0.595], [0.155, 0.070], D65],
        ColorPrimaries::BT2020 => [[0.708, 0.292], [0.170, 0.797], [0.131, 0.046], D65],
        ColorPrimaries::ACES => [[0.7347, 0.2653], [0.0, 1.0], [0.0001, -0.0770], ACES_WHITE],
        ColorPrimaries::ACESCC => [[0.713, 0.293], [0.165, 0.830], [0.128, 0.044], ACES_WHITE],
        ColorPrimaries::DISPLAYP3 => [[0.680, 0.320], [0.265, 0.690], [0.150, 0.060], D65],
        ColorPrimaries::AdobeRGB => [[0.640, 0.330], [0.210, 0.710], [0.150, 0.060], D65],
        ColorPrimaries::NTSC1953 => [[0.67, 0.33], [0.21, 0.71], [0.14, 0.08], C[0]],
        ColorPrimaries::PAL525 => [[0.630, 0.340], [0.310, 0.595], [0.155, 0.070], C[1]],
        _ => return Some((format!("{primaries:?}"), None)),
    };
    Some((format!("{primaries:?}"), Primaries::new(red, green, blue, white)))
}

fn damaged(level: usize, error: &io::Error, name: &str) -> ImageError {
    if error.kind() == io::ErrorKind::UnexpectedEof {
        return invalid(name, format!("the file ends early: level {level} is not all there"));
    }
    invalid(name, format!("level {level} is damaged: {error}"))
}

/// Translates an error of the library.
fn explain(error: &ParseError, name: &str) -> ImageError {
    match error {
        ParseError::BadMagic => invalid(name, "damaged KTX2 file: its first twelve bytes are wrong".into()),
        other => invalid(name, format!("damaged KTX2 file: {other}")),
    }
}
