//! DDS cube map decoder.

use crate::codec::dds::{CUBE_ALL_FACES, CUBE_MISC, D3D9, DX10, FOURCC_FLAG, Field, HEADER, HEADER_DX10, field};
use crate::codec::decoded::{CubeTexture, check_cube_size};
use crate::codec::decoded::{invalid, reserve, unsupported};
use crate::codec::decoded::{mip_level_count, mip_level_size};
use crate::{ImageError, TexelFormat};

/// Decodes a DDS cube map; `name` stands for the file in messages.
pub(crate) fn decode(bytes: &[u8], name: &str, max_texels: usize) -> Result<CubeTexture, ImageError> {
    let short = || invalid(name, "the file ends early: the header is not all there".into());
    let get = |f: Field| field(bytes, f).ok_or_else(short);
    if get(Field::Size)? != 124 || get(Field::PixelFormatSize)? != 32 {
        return Err(invalid(name, "damaged DDS file: a header of 124 bytes with a format of 32 expected".into()));
    }
    let four_cc = get(Field::FourCc)?;
    let has_code = get(Field::PixelFormatFlags)? & FOURCC_FLAG != 0;
    let dx10 = has_code && four_cc == DX10;
    let (format, is_cube, data) = if dx10 {
        let dxgi = get(Field::DxgiFormat)?;
        let format = TexelFormat::from_dxgi(dxgi).ok_or_else(|| format!("the DXGI format {dxgi}"));
        let (misc, count) = (get(Field::Misc)?, get(Field::ArraySize)?);
        if count != 1 {
            return Err(unsupported(name, format!("one cube map expected, found an array of {count}")));
        }
        (format, misc & CUBE_MISC != 0, HEADER + HEADER_DX10)
    } else {
        let known = D3D9.iter().find(|(code, _)| has_code && *code == four_cc).map(|(_, format)| *format);
        let format = known.ok_or_else(|| format!("the code \"{}\"", four_cc.to_le_bytes().escape_ascii()));
        (format, get(Field::Caps2)? & CUBE_ALL_FACES == CUBE_ALL_FACES, HEADER)
    };
    let (width, height) = (get(Field::Width)?, get(Field::Height)?);
    if !is_cube {
        let message = format!("a cube map of 6 faces expected, found a texture of {width} x {height}");
        return Err(unsupported(name, message));
    }
    let format = format.map_err(|found| {
        unsupported(name, format!("RGBA16F, RGBA32F, RGB9E5, R11G11B10F or BC6H expected, found {found}"))
    })?;
    if width != height {
        return Err(invalid(name, format!("the faces of a cube are square, these are {width} x {height}")));
    }
    check_cube_size(width.into(), max_texels, name)?;
    let levels = get(Field::MipMapCount)?.max(1) as usize;
    faces(bytes.get(data..).ok_or_else(short)?, width as usize, levels, format, name)
}

/// Decodes face after face, each with all its levels.
fn faces(data: &[u8], size: usize, levels: usize, format: TexelFormat, name: &str) -> Result<CubeTexture, ImageError> {
    if levels > mip_level_count(size) {
        let message = format!("a cube map of size {size} has at most {} levels, not {levels}", mip_level_count(size));
        return Err(invalid(name, message));
    }
    let face: u64 = (0..levels).map(|k| format.face_bytes(mip_level_size(size, k))).sum();
    if (data.len() as u64) < 6 * face {
        let message = format!(
            "the file ends early: 6 faces of {size} x {size} {format} in {levels} level(s) need {} bytes, {} are there",
            6 * face,
            data.len()
        );
        return Err(invalid(name, message));
    }
    let mut notes = Vec::new();
    if data.len() as u64 > 6 * face {
        notes.push(format!("{} bytes after the picture are ignored", data.len() as u64 - 6 * face));
    }
    let mut decoded = Vec::with_capacity(levels);
    for k in 0..levels {
        let side = mip_level_size(size, k);
        decoded.push((side, reserve(6 * side * side, name)?));
    }
    let mut source = data;
    for _ in 0..6 {
        for (side, texels) in &mut decoded {
            let read = format.read_face(*side, &mut source, texels);
            read.map_err(|e| invalid(name, format!("the file ends early: {e}")))?;
        }
    }
    Ok(CubeTexture { format, levels: decoded, notes })
}
