//! DDS textures: the headers, whose fields are little-endian numbers of 32 bits, the decoder and the writer.
//!
//! Programming Guide for DDS, Microsoft. What Direct3D 9 has no code for is written with the second header, of Direct3D 10.

use crate::error::ImageError;
use crate::header::decoded::{invalid, unsupported};
use crate::pixel::Pixel;
use crate::texture::cube_texture::mip_level_size;
use crate::texture::stored_texture::{FACES, OF_AN_ARRAY, StoredTexture};
use crate::texture::texel_format::TexelFormat;

/// Bytes up to the end of the first header.
const HEADER: usize = 128;

/// Bytes of the second header, added by Direct3D 10.
const HEADER_DX10: usize = 20;

/// The code that announces the second header.
const DX10: u32 = u32::from_le_bytes(*b"DX10");

/// The codes of Direct3D 9, in place of a four-character code. Files with them need no second header, and more programs
/// take them so (`PlayCanvas`).
const D3D9: [(u32, TexelFormat); 2] = [(113, TexelFormat::Rgba16F), (116, TexelFormat::Rgba32F)];

/// Flag: the format is given by a four-character code.
const FOURCC_FLAG: u32 = 0x4;

/// A cube map with all its faces, in [`Field::Caps2`].
const CUBE_ALL_FACES: u32 = 0xfe00;

/// A volume, in [`Field::Caps2`].
const VOLUME: u32 = 0x20_0000;

/// A cube map, in [`Field::Misc`].
const CUBE_MISC: u32 = 0x4;

/// A number in the headers; the value is its offset in the file.
#[derive(Clone, Copy)]
enum Field {
    Size = 4,
    Flags = 8,
    Height = 12,
    Width = 16,
    PitchOrLinearSize = 20,
    MipMapCount = 28,
    PixelFormatSize = 76,
    PixelFormatFlags = 80,
    FourCc = 84,
    Caps = 108,
    Caps2 = 112,
    DxgiFormat = 128,
    Dimension = 132,
    Misc = 136,
    ArraySize = 140,
    AlphaMode = 144,
}

/// The value of a field, if the file is long enough.
fn field(bytes: &[u8], field: Field) -> Option<u32> {
    bytes[(field as usize).min(bytes.len())..].first_chunk().map(|b| u32::from_le_bytes(*b))
}

/// What the headers of a DDS file say, and where its texels begin; `name` stands for the file in messages.
pub(crate) fn header(bytes: &[u8], name: &str, max_texels: usize) -> Result<(StoredTexture, usize), ImageError> {
    let short = || invalid(name, "the file ends early: the header is not all there".into());
    let get = |f: Field| field(bytes, f).ok_or_else(short);
    if get(Field::Size)? != 124 || get(Field::PixelFormatSize)? != 32 {
        return Err(invalid(name, "damaged DDS file: a header of 124 bytes with a format of 32 expected".into()));
    }
    let four_cc = get(Field::FourCc)?;
    let has_code = get(Field::PixelFormatFlags)? & FOURCC_FLAG != 0;
    let (size, caps2) = ([get(Field::Width)?, get(Field::Height)?], get(Field::Caps2)?);
    let has_all_faces = caps2 & CUBE_ALL_FACES == CUBE_ALL_FACES;
    let (mut notes, mut cubes) = (Vec::new(), 1);
    let (format, is_cube, data) = if has_code && four_cc == DX10 {
        let dxgi = get(Field::DxgiFormat)?;
        let format = TexelFormat::from_dxgi(dxgi).ok_or_else(|| format!("the DXGI format {dxgi}"));
        let (is_cube, count) = (get(Field::Misc)? & CUBE_MISC != 0, get(Field::ArraySize)?);
        let is_array_of_faces = !is_cube && count == FACES as u32 && size[0] == size[1];
        cubes = if is_cube && count == FACES as u32 { FACES } else { 1 };
        if count != 1 && !is_array_of_faces && cubes == 1 {
            return Err(of_an_array(count as usize, name));
        }
        if is_array_of_faces {
            notes.push(OF_AN_ARRAY.to_owned());
        } else if !is_cube && has_all_faces {
            notes.push("it is a cube map by its first header, and not by that of Direct3D 10".to_owned());
        }
        (format, is_cube || is_array_of_faces || has_all_faces, HEADER + HEADER_DX10)
    } else {
        let known = D3D9.iter().find(|(code, _)| has_code && *code == four_cc).map(|(_, format)| *format);
        let format = known.ok_or_else(|| format!("the code \"{}\"", four_cc.to_le_bytes().escape_ascii()));
        (format, has_all_faces, HEADER)
    };
    if !is_cube && caps2 & (CUBE_ALL_FACES | VOLUME) != 0 {
        let [width, height] = size;
        let what = if caps2 & VOLUME == 0 { "some faces of a cube" } else { "a volume" };
        let message = format!("a picture or a cube map of 6 faces expected, found {what} of {width} x {height}");
        return Err(unsupported(name, message));
    }
    let format = format.map_err(|found| {
        unsupported(name, format!("RGBA16F, RGBA32F, RGB32F, RGB9E5, R11G11B10F or BC6H expected, found {found}"))
    })?;
    let levels = get(Field::MipMapCount)?;
    let faces = if is_cube { FACES } else { 1 };
    let mut texture = StoredTexture::new(format.into(), size, faces, levels, max_texels, name)?;
    texture.notes = notes;
    if cubes > 1 {
        // Some writers count the faces of one cube; then the file ends before a second one.
        let cube: u64 = (0..texture.levels).map(|k| FACES as u64 * texture.picture_bytes(k)).sum();
        if (bytes.len() - data.min(bytes.len())) as u64 >= 2 * cube {
            return Err(of_an_array(cubes, name));
        }
        texture.notes.push("its header tells of 6 cube maps, and it holds one; 6 is taken for its faces".to_owned());
    }
    Ok((texture, data))
}

fn of_an_array(count: usize, name: &str) -> ImageError {
    unsupported(name, format!("one picture or cube map expected, found an array of {count}"))
}

/// Decodes the first `levels` levels of picture after picture, each of which has all its levels.
pub(crate) fn levels(
    texture: &mut StoredTexture,
    data: &[u8],
    levels: usize,
    name: &str,
) -> Result<Vec<Vec<Pixel>>, ImageError> {
    let (faces, [width, height]) = (texture.faces as u64, texture.size);
    let picture: u64 = (0..texture.levels).map(|k| texture.picture_bytes(k)).sum();
    let there = data.len() as u64;
    if there < faces * picture {
        let message = format!(
            "the file ends early: {faces} picture(s) of {width} x {height} {} in {} level(s) need {} bytes, \
             {there} are there",
            texture.format.format,
            texture.levels,
            faces * picture
        );
        return Err(invalid(name, message));
    }
    if there > faces * picture {
        texture.notes.push(format!("{} bytes after the picture are ignored", there - faces * picture));
    }
    let mut decoded = Vec::with_capacity(levels);
    for k in 0..levels {
        decoded.push(texture.reserved(k, name)?);
    }
    for picture in data.chunks_exact(picture as usize).take(texture.faces) {
        let mut source = picture;
        for (k, texels) in decoded.iter_mut().enumerate() {
            let read = texture.read(k, &mut source, texels);
            read.map_err(|e| invalid(name, format!("the file ends early: {e}")))?;
        }
    }
    Ok(decoded)
}

/// Flags of the fields that are set: capabilities, height, width, format, number of levels.
const FLAGS: u32 = 0x1 | 0x2 | 0x4 | 0x1000 | 0x2_0000;

/// Flag: the pitch of a row is given.
const FLAG_PITCH: u32 = 0x8;

/// Flag: the bytes of the first face are given instead, as blocks have no rows.
const FLAG_LINEAR_SIZE: u32 = 0x8_0000;

/// Capabilities: a texture of several surfaces with levels.
const CAPS: u32 = 0x8 | 0x1000 | 0x40_0000;

/// A texture of two dimensions.
const DIMENSION_2D: u32 = 3;

/// Alpha is opaque.
const ALPHA_OPAQUE: u32 = 3;

/// The pieces of the file in order, from the encoded faces of all levels, the largest first.
pub(crate) fn pieces(size: usize, format: TexelFormat, mut levels: Vec<[Vec<u8>; 6]>) -> Vec<Vec<u8>> {
    let is_block = matches!(format, TexelFormat::Bc6h | TexelFormat::Bc6hSigned);
    let (flag, pitch) = if is_block {
        (FLAG_LINEAR_SIZE, format.face_bytes(size))
    } else {
        (FLAG_PITCH, (size * format.block_bytes()) as u64)
    };
    let old = D3D9.iter().find(|(_, of_code)| *of_code == format).map(|(code, _)| *code);
    let mut bytes = vec![0; HEADER + HEADER_DX10];
    bytes[..4].copy_from_slice(b"DDS ");
    for (field, value) in [
        (Field::Size, 124),
        (Field::Flags, FLAGS | flag),
        (Field::Height, size as u32),
        (Field::Width, size as u32),
        (Field::PitchOrLinearSize, pitch as u32),
        (Field::MipMapCount, levels.len() as u32),
        (Field::PixelFormatSize, 32),
        (Field::PixelFormatFlags, FOURCC_FLAG),
        (Field::FourCc, old.unwrap_or(DX10)),
        (Field::Caps, CAPS),
        (Field::Caps2, CUBE_ALL_FACES),
        (Field::DxgiFormat, format.dxgi()),
        (Field::Dimension, DIMENSION_2D),
        (Field::Misc, CUBE_MISC),
        (Field::ArraySize, 1),
        (Field::AlphaMode, ALPHA_OPAQUE),
    ] {
        bytes[field as usize..][..4].copy_from_slice(&value.to_le_bytes());
    }
    if old.is_some() {
        bytes.truncate(HEADER);
    }
    let mut pieces = vec![bytes];
    for face in 0..6 {
        for (k, level) in levels.iter_mut().enumerate() {
            debug_assert_eq!(level[face].len() as u64, format.face_bytes(mip_level_size(size, k)), "level {k}");
            pieces.push(std::mem::take(&mut level[face]));
        }
    }
    pieces
}
