//! KTX1 decoder: textures of version 1, of either byte order.
//!
//! ```text
//!   identifier                  12 bytes
//!   thirteen numbers            in the byte order that the first one tells
//!   keys and values
//!   levels                      the largest first; in each the bytes of it, or of one face of a cube, then the
//! pictures
//! ```
//!
//! Rows begin at multiples of four bytes. Some programs do not pad them, which the bytes of the level tell.
//!
//! KTX File Format Specification 1.0. The numbers of formats and types are those of OpenGL.

use crate::error::ImageError;
use crate::header::decoded::{invalid, unsupported};
use crate::pixel::Pixel;
use crate::texture::stored_format::StoredFormat;
use crate::texture::stored_texture::{FACES, OF_AN_ARRAY, OF_BYTES, StoredTexture};
use crate::texture::texel_format::TexelFormat;

/// The first number in the order of its writer.
pub(crate) const ENDIANNESS: u32 = 0x0403_0201;

/// `GL_RGB`, `GL_RGBA` and those with blue first.
pub(crate) const RGB: u32 = 0x1907;
const RGBA: u32 = 0x1908;
const BGR: u32 = 0x80e0;
const BGRA: u32 = 0x80e1;

/// `GL_R11F_G11F_B10F` and `GL_RGB9_E5`, whose texels are numbers of four bytes.
pub(crate) const R11F_G11F_B10F: u32 = 0x8c3a;
const RGB9_E5: u32 = 0x8c3d;

/// Formats of `GL_COMPRESSED_RGB_BPTC_*_FLOAT`: without sign, and with.
const BC6H: u32 = 0x8e8f;
const BC6H_SIGNED: u32 = 0x8e8e;

/// `GL_SRGB`, `GL_SRGB8`, `GL_SRGB_ALPHA` and `GL_SRGB8_ALPHA8`.
const SRGB: [u32; 4] = [0x8c40, 0x8c41, 0x8c42, 0x8c43];

/// Types of a channel: `GL_UNSIGNED_BYTE`, `GL_FLOAT`, `GL_HALF_FLOAT` and `GL_HALF_FLOAT_OES`.
const UNSIGNED_BYTE: u32 = 0x1401;
const FLOAT: u32 = 0x1406;
const HALF_FLOAT: [u32; 2] = [0x140b, 0x8d61];

/// The key of nine colors, a line for each, under which Filament's tool and readers have the light of diffuse surfaces.
pub(crate) const SH_KEY: &str = "sh";

/// Rows begin at multiples of as many bytes.
const ALIGNMENT: u64 = 4;

/// The first twelve bytes.
pub(crate) const KTX: [u8; 12] = *b"\xabKTX 11\xbb\r\n\x1a\n";

/// Bytes of the identifier and the numbers.
const HEADER: usize = KTX.len() + 13 * 4;

/// Where the levels lie.
#[derive(Clone, Copy)]
pub(crate) struct Places {
    /// The first byte behind the keys.
    data: usize,
    /// Whether numbers are big-endian.
    is_swapped: bool,
    /// The bytes of a number in texels: those of other sizes have no order.
    type_size: usize,
}

/// The numbers of the header.
struct Numbers {
    numbers: [u32; 13],
    /// Whether they are big-endian.
    is_swapped: bool,
}

impl Numbers {
    fn of(bytes: &[u8], name: &str) -> Result<Self, ImageError> {
        if !bytes.starts_with(&KTX) {
            return Err(invalid(name, "damaged KTX file: its first twelve bytes are wrong".into()));
        }
        let words = bytes.get(KTX.len()..HEADER).ok_or_else(|| short(name))?.as_chunks::<4>().0;
        let is_swapped = match u32::from_le_bytes(words[0]) {
            ENDIANNESS => false,
            other if other.swap_bytes() == ENDIANNESS => true,
            other => return Err(invalid(name, format!("damaged KTX file: {other:#x} tells no byte order"))),
        };
        let mut numbers = [0; 13];
        numbers.iter_mut().zip(words).for_each(|(to, word)| *to = number(word, is_swapped));
        Ok(Self { numbers, is_swapped })
    }
}

fn short(name: &str) -> ImageError {
    invalid(name, "the file ends early: the header is not all there".into())
}

fn number(word: &[u8; 4], is_swapped: bool) -> u32 {
    if is_swapped { u32::from_be_bytes(*word) } else { u32::from_le_bytes(*word) }
}

/// The entries behind the header, each a key, a zero and its value; `length` is that of all of them.
fn entries<'a>(bytes: &'a [u8], length: u32, is_swapped: bool, name: &str) -> Result<Vec<&'a [u8]>, ImageError> {
    let data = HEADER.saturating_add(length as usize);
    let mut left = bytes.get(HEADER..data).ok_or_else(|| short(name))?;
    let mut entries = Vec::new();
    while let Some((length, rest)) = left.split_first_chunk::<4>() {
        let length = number(length, is_swapped) as usize;
        let entry =
            rest.get(..length).ok_or_else(|| invalid(name, "damaged KTX file: a key reaches too far".into()))?;
        entries.push(entry);
        // Spaces are padded to four bytes.
        left = rest.get(length.next_multiple_of(4)..).unwrap_or_default();
    }
    Ok(entries)
}

/// The nine colors of the key `sh`.
pub(crate) fn sh(bytes: &[u8], name: &str) -> Result<Option<[[f64; 3]; 9]>, ImageError> {
    let Numbers { numbers, is_swapped } = Numbers::of(bytes, name)?;
    let key = format!("{SH_KEY}\0");
    let all = entries(bytes, numbers[12], is_swapped, name)?;
    let Some(value) = all.iter().find_map(|entry| entry.strip_prefix(key.as_bytes())) else { return Ok(None) };
    let text = String::from_utf8_lossy(value);
    let found: Option<Vec<f64>> = text
        .trim_end_matches('\0')
        .split_whitespace()
        .map(|word| word.parse().ok().filter(|x: &f64| x.is_finite()))
        .collect();
    match found.as_deref().map(<[f64]>::as_chunks::<3>) {
        Some((colors, [])) if let Ok(sh) = <[[f64; 3]; 9]>::try_from(colors) => Ok(Some(sh)),
        _ => Err(invalid(name, format!("the key {SH_KEY} holds nine colors, but this one something else"))),
    }
}

/// What the headers of a KTX file say, and where its levels lie; `name` stands for the file in messages.
pub(crate) fn header(bytes: &[u8], name: &str, max_texels: usize) -> Result<(StoredTexture, Places), ImageError> {
    let Numbers { numbers, is_swapped } = Numbers::of(bytes, name)?;
    let [_, gl_type, type_size, gl_format, internal, _, width, height, depth, elements, faces, levels, keys] = numbers;
    let format = format_of(gl_type, gl_format, internal).ok_or_else(|| {
        let message = format!(
            "RGB or RGBA of half, float or bytes, R11G11B10F, RGB9E5 or BC6H expected, found the internal format \
             {internal:#x} of type {gl_type:#x}"
        );
        unsupported(name, message)
    })?;
    let is_array_of_faces = faces == 1 && elements == FACES as u32 && width == height;
    let count = match (faces, elements) {
        _ if is_array_of_faces => FACES,
        (6, 0 | 1) => FACES,
        (1, 0 | 1) => 1,
        _ => {
            let message = format!("one picture or cube map expected, found {faces} face(s) of {elements} element(s)");
            return Err(unsupported(name, message));
        }
    };
    if depth > 1 {
        return Err(unsupported(name, format!("a picture or a cube map expected, found a volume {depth} deep")));
    }
    let mut texture = StoredTexture::new(format, [width, height.max(1)], count, levels, max_texels, name)?;
    texture.alignment = ALIGNMENT as usize;
    if is_array_of_faces {
        texture.notes.push(OF_AN_ARRAY.into());
    }
    if levels == 0 {
        texture.notes.push("the file asks for smaller levels to be made; it holds one".into());
    }
    if format.of_srgb().is_some() {
        texture.notes.push(OF_BYTES.into());
    }
    let data = HEADER.saturating_add(keys as usize);
    for entry in entries(bytes, keys, is_swapped, name)? {
        if let Some(value) = entry.strip_prefix(b"KTXorientation\0") {
            texture.is_from_bottom = is_from_bottom(value, texture.is_cube(), name)?;
        }
    }
    Ok((texture, Places { data, is_swapped, type_size: type_size as usize }))
}

/// Whether the lowest row comes first, by an orientation as in `S=r,T=d`; refuses one that would turn the faces of a
/// cube around, or mirror a picture.
fn is_from_bottom(value: &[u8], is_cube: bool, name: &str) -> Result<bool, ImageError> {
    let value = String::from_utf8_lossy(value);
    let value = value.trim_end_matches('\0');
    // The third direction is that of volumes.
    let [s, t] = [0, 1].map(|k| value.split(',').nth(k).unwrap_or_default().trim());
    match (s, t) {
        ("S=r", "T=d") => Ok(false),
        ("S=r", "T=u") if !is_cube => Ok(true),
        _ => {
            let what = if is_cube { "cube faces" } else { "a picture" };
            Err(unsupported(name, format!("{what} with orientation \"S=r,T=d\" expected, found {value:?}")))
        }
    }
}

/// The format of texels; none if it is not read.
fn format_of(gl_type: u32, gl_format: u32, internal: u32) -> Option<StoredFormat> {
    match internal {
        R11F_G11F_B10F if gl_type != FLOAT && !HALF_FLOAT.contains(&gl_type) => {
            return Some(TexelFormat::R11G11B10F.into());
        }
        RGB9_E5 if gl_type != FLOAT && !HALF_FLOAT.contains(&gl_type) => return Some(TexelFormat::Rgb9e5.into()),
        BC6H => return Some(TexelFormat::Bc6h.into()),
        BC6H_SIGNED => return Some(TexelFormat::Bc6hSigned.into()),
        _ => {}
    }
    let (channels, is_bgr) = match gl_format {
        RGB => (3, false),
        RGBA => (4, false),
        BGR => (3, true),
        BGRA => (4, true),
        _ => return None,
    };
    let format = match (gl_type, channels) {
        (UNSIGNED_BYTE, _) if SRGB.contains(&internal) => TexelFormat::Srgb8,
        (UNSIGNED_BYTE, _) => TexelFormat::Rgb8,
        (FLOAT, _) => TexelFormat::Rgb32F,
        (half, _) if HALF_FLOAT.contains(&half) => TexelFormat::Rgb16F,
        _ => return None,
    };
    Some(StoredFormat::plain(format, channels, is_bgr))
}

/// Decodes the first `count` levels, each face after face.
pub(crate) fn levels(
    texture: &StoredTexture,
    places: &Places,
    bytes: &[u8],
    count: usize,
    name: &str,
) -> Result<Vec<Vec<Pixel>>, ImageError> {
    let mut data = bytes.get(places.data..).unwrap_or_default();
    let unpadded = StoredTexture { alignment: 1, ..texture.clone() };
    let mut levels = Vec::with_capacity(count);
    for k in 0..count {
        let ended = |needed: u64| {
            let there = data.len();
            invalid(name, format!("the file ends early: level {k} needs {needed} bytes, {there} are there"))
        };
        let (size, level) = data.split_first_chunk::<4>().ok_or_else(|| ended(4))?;
        let size = if places.is_swapped { u32::from_be_bytes(*size) } else { u32::from_le_bytes(*size) };
        let (texture, of_picture) = [texture, &unpadded]
            .into_iter()
            .find_map(|texture| Some((texture, picture_bytes(texture, k, size.into())?)))
            .ok_or_else(|| {
                let one = texture.picture_bytes(k);
                let faces = if texture.is_cube() { " for each face" } else { "" };
                invalid(name, format!("level {k}: expected {one} bytes{faces}, the file says {size}"))
            })?;
        let needed = (texture.faces as u64 - 1) * of_picture + texture.picture_bytes(k);
        let pictures = level.get(..needed as usize).ok_or_else(|| ended(4 + needed))?.chunks(of_picture as usize);
        let mut texels = texture.reserved(k, name)?;
        for picture in pictures {
            let swapped = places.is_swapped.then(|| in_other_order(picture, places.type_size));
            let mut source = swapped.as_deref().unwrap_or(picture);
            let read = texture.read(k, &mut source, &mut texels);
            read.map_err(|e| invalid(name, format!("the file ends early: {e}")))?;
        }
        levels.push(texels);
        // Levels begin at multiples of four; behind the last one nothing may be there.
        data = level.get(needed.next_multiple_of(ALIGNMENT) as usize..).unwrap_or_default();
    }
    Ok(levels)
}

/// The bytes from one picture of a level to the next, where the level has `size` bytes as the file says; none if it
/// cannot have as many with rows of this alignment. The number is that of one face of a cube, whose faces begin at
/// multiples of four, and of all pictures of an array.
fn picture_bytes(texture: &StoredTexture, level: usize, size: u64) -> Option<u64> {
    let one = texture.picture_bytes(level);
    let (padded, count) = (one.next_multiple_of(ALIGNMENT), texture.faces as u64);
    match size {
        size if size == one || size == padded || size == count * padded => Some(padded),
        size if size == count * one => Some(one),
        _ => None,
    }
}

/// The bytes of numbers of `size` bytes, each turned around.
fn in_other_order(bytes: &[u8], size: usize) -> Vec<u8> {
    let mut turned = bytes.to_vec();
    if size > 1 {
        turned.chunks_exact_mut(size).for_each(<[u8]>::reverse);
    }
    turned
}
