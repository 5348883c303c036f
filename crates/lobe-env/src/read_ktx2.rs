//! KTX2 cube maps.

use std::io::{self, Read};
use std::ops::Range;

use ktx2::{ColorPrimaries, Header, LevelIndex, ParseError, Reader, SupercompressionScheme, TransferFunction};

use crate::cube_mip_chain::{level_count, level_size};
use crate::read::{invalid, reserve, unsupported};
use crate::read_cube::{DecodedCube, check_cube_size};
use crate::{EnvError, TexelFormat};

/// The most bytes that one byte of Zstandard can stand for: a block of one repeated byte stores 128 KiB in four bytes.
const MOST_BYTES_PER_BYTE: u64 = 1 << 15;

/// Decodes a KTX2 cube map; `name` stands for the file in messages.
pub(crate) fn decode(bytes: &[u8], name: &str, max_texels: usize) -> Result<DecodedCube, EnvError> {
    let reader = Reader::new(bytes).map_err(|e| explain(&e, name))?;
    let header = reader.header();
    let size = cube_size(&header, name)?;
    let format = texel_format(&header, name)?;
    check_cube_size(size, max_texels, name)?;
    let size = size as usize;
    let levels = header.level_count.max(1) as usize;
    if levels > level_count(size) {
        let message = format!("a cube map of size {size} has at most {} levels, not {levels}", level_count(size));
        return Err(invalid(name, message));
    }
    let ranges = level_ranges(bytes, levels, name)?;
    check_places(&header, &ranges, bytes.len(), name)?;
    let zstd = header.supercompression_scheme.is_some();
    let mut cube = DecodedCube { format, levels: Vec::with_capacity(levels), notes: notes(&reader, name)? };
    for (k, (range, level)) in ranges.iter().zip(reader.levels()).enumerate() {
        let side = level_size(size, k);
        let expected = 6 * format.face_bytes(side);
        let stored = (range.end - range.start) as u64;
        let most = if zstd { stored.saturating_mul(MOST_BYTES_PER_BYTE) } else { stored };
        if level.uncompressed_byte_length != expected || most < expected || (!zstd && stored != expected) {
            let message = format!(
                "level {k}, {side} x {side} {format}, needs {expected} bytes; the file says {} and holds {stored}",
                level.uncompressed_byte_length
            );
            return Err(invalid(name, message));
        }
        let mut texels = reserve(6 * side * side, name)?;
        let mut source = level_source(level.data, zstd).map_err(|e| damaged(k, &e, name))?;
        for _ in 0..6 {
            format.read_face(side, &mut source, &mut texels).map_err(|e| damaged(k, &e, name))?;
        }
        if !matches!(source.read(&mut [0]), Ok(0)) {
            return Err(invalid(name, format!("level {k} holds more than its {expected} bytes")));
        }
        cube.levels.push((side, texels));
    }
    Ok(cube)
}

/// The size of the faces of a cube map, or why the file is none.
fn cube_size(header: &Header, name: &str) -> Result<u64, EnvError> {
    let (w, h, d) = (header.pixel_width, header.pixel_height, header.pixel_depth);
    if header.face_count != 6 {
        let message =
            format!("a cube map of 6 faces expected, found a texture of {} x {h}, {} face(s)", w, header.face_count);
        return Err(if header.face_count == 1 { unsupported(name, message) } else { invalid(name, message) });
    }
    if w != h || d != 0 {
        return Err(invalid(name, format!("the faces of a cube are square and flat, these are {w} x {h} x {d}")));
    }
    if header.layer_count > 1 {
        let message = format!("one cube map expected, found an array of {}", header.layer_count);
        return Err(unsupported(name, message));
    }
    Ok(w.into())
}

fn texel_format(header: &Header, name: &str) -> Result<TexelFormat, EnvError> {
    let expected = "RGBA16F, RGBA32F, RGB9E5 or BC6H expected";
    let Some(vulkan) = header.format else {
        let message = format!("{expected}, found a universal texture (Basis), which holds no high dynamic range");
        return Err(unsupported(name, message));
    };
    let Some(format) = TexelFormat::from_vulkan(vulkan) else {
        return Err(unsupported(name, format!("{expected}, found the Vulkan format {vulkan:?}")));
    };
    match header.supercompression_scheme {
        None | Some(SupercompressionScheme::Zstandard) => Ok(format),
        Some(other) => {
            Err(unsupported(name, format!("Zstandard or no supercompression expected, found scheme {other:?}")))
        }
    }
}

/// Where the levels lie in the file, the largest level first.
fn level_ranges(bytes: &[u8], levels: usize, name: &str) -> Result<Vec<Range<usize>>, EnvError> {
    let index = bytes[Header::LENGTH..].as_chunks::<{ LevelIndex::LENGTH }>().0;
    let ranges: Option<Vec<_>> = index
        .iter()
        .take(levels)
        .map(|entry| {
            let level = LevelIndex::from_bytes(entry);
            let end = level.byte_offset.checked_add(level.byte_length)?;
            Some(usize::try_from(level.byte_offset).ok()?..usize::try_from(end).ok()?)
        })
        .collect();
    ranges
        .filter(|r| r.len() == levels)
        .ok_or_else(|| invalid(name, "the file ends early: levels of the picture are missing".into()))
}

/// Refuses parts of the file that share bytes, or lie outside it.
fn check_places(header: &Header, levels: &[Range<usize>], length: usize, name: &str) -> Result<(), EnvError> {
    let part = |offset: u64, length: u64| offset as usize..(offset as usize).saturating_add(length as usize);
    let index = &header.index;
    let mut parts = vec![
        ("the header".to_owned(), 0..Header::LENGTH + levels.len() * LevelIndex::LENGTH),
        ("the data format".to_owned(), part(index.dfd_byte_offset.into(), index.dfd_byte_length.into())),
        ("the key/value data".to_owned(), part(index.kvd_byte_offset.into(), index.kvd_byte_length.into())),
        ("the global data".to_owned(), part(index.sgd_byte_offset, index.sgd_byte_length)),
    ];
    parts.extend(levels.iter().enumerate().map(|(k, range)| (format!("level {k}"), range.clone())));
    parts.retain(|(_, range)| !range.is_empty());
    parts.sort_by_key(|(_, range)| range.start);
    for pair in parts.windows(2) {
        if pair[0].1.end > pair[1].1.start {
            return Err(invalid(name, format!("{} and {} overlap in the file", pair[0].0, pair[1].0)));
        }
    }
    match parts.iter().find(|(_, range)| range.end > length) {
        Some((what, _)) => Err(invalid(name, format!("the file ends early: {what} is not all there"))),
        None => Ok(()),
    }
}

/// The bytes of a level as they come out of the supercompression.
fn level_source(stored: &[u8], zstd: bool) -> io::Result<Box<dyn Read + '_>> {
    if zstd { Ok(Box::new(zstd::Decoder::with_buffer(stored)?)) } else { Ok(Box::new(stored)) }
}

/// What a careful user should know; refuses what would turn the picture around.
fn notes(reader: &Reader<&[u8]>, name: &str) -> Result<Vec<String>, EnvError> {
    let mut notes = Vec::new();
    for (key, value) in reader.key_value_data() {
        let value = String::from_utf8_lossy(value);
        let value = value.trim_end_matches('\0');
        match key {
            "KTXorientation" if value != "rd" => {
                let message = format!("cube faces with orientation \"rd\" expected, found {value:?}");
                return Err(unsupported(name, message));
            }
            "KTXswizzle" if !value.starts_with("rgb") => {
                return Err(unsupported(
                    name,
                    format!("channels in the order rgb expected, found KTXswizzle {value:?}"),
                ));
            }
            _ => {}
        }
    }
    if reader.header().level_count == 0 {
        notes.push("the file asks for smaller levels to be made; it holds one".into());
    }
    if let Some(primaries) = reader.color_primaries().filter(|p| *p != ColorPrimaries::BT709) {
        notes.push(format!("the primaries are {primaries:?}; they are not converted"));
    }
    match reader.transfer_function() {
        None | Some(TransferFunction::Linear) => Ok(notes),
        Some(other) => Err(unsupported(name, format!("linear light expected, found the transfer function {other:?}"))),
    }
}

fn damaged(level: usize, error: &io::Error, name: &str) -> EnvError {
    if error.kind() == io::ErrorKind::UnexpectedEof {
        return invalid(name, format!("the file ends early: level {level} is not all there"));
    }
    invalid(name, format!("level {level} is damaged: {error}").replace('\n', " "))
}

/// An error of the library in our words.
fn explain(error: &ParseError, name: &str) -> EnvError {
    match error {
        ParseError::UnexpectedEnd => invalid(name, "the KTX2 file ends early or points outside itself".into()),
        other => invalid(name, format!("damaged KTX2 file: {other}")),
    }
}
