//! DDS cube map writer, with the header of Direct3D 10.

use crate::TexelFormat;
use crate::codec::dds::{CUBE_ALL_FACES, CUBE_MISC, D3D9, DX10, FOURCC_FLAG, Field, HEADER, HEADER_DX10, MAGIC};
use crate::codec::decoded::mip_level_size;

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
    bytes[..MAGIC.len()].copy_from_slice(&MAGIC);
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
