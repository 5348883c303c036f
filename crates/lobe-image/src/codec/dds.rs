//! DDS header fields: 32-bit little-endian numbers.

use crate::TexelFormat;

/// The first four bytes.
pub(crate) const MAGIC: [u8; 4] = *b"DDS ";

/// Bytes up to the end of the first header.
pub(crate) const HEADER: usize = 128;

/// Bytes of the second header, added by Direct3D 10.
pub(crate) const HEADER_DX10: usize = 20;

/// The code that announces the second header.
pub(crate) const DX10: u32 = u32::from_le_bytes(*b"DX10");

/// The codes of Direct3D 9, in place of a four-character code. Files with them need no second header, and more programs
/// take them so (`PlayCanvas`).
pub(crate) const D3D9: [(u32, TexelFormat); 2] = [(113, TexelFormat::Rgba16F), (116, TexelFormat::Rgba32F)];

/// Flag: the format is given by a four-character code.
pub(crate) const FOURCC_FLAG: u32 = 0x4;

/// A cube map with all its faces, in [`Field::Caps2`].
pub(crate) const CUBE_ALL_FACES: u32 = 0xfe00;

/// A cube map, in [`Field::Misc`].
pub(crate) const CUBE_MISC: u32 = 0x4;

/// A number in the headers; the value is its offset in the file.
#[derive(Clone, Copy)]
pub(crate) enum Field {
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
pub(crate) fn field(bytes: &[u8], field: Field) -> Option<u32> {
    bytes[(field as usize).min(bytes.len())..].first_chunk().map(|b| u32::from_le_bytes(*b))
}
