//! Texel formats of cube textures.

use std::fmt;

use half::f16;
use half::slice::HalfFloatSliceExt;
use ktx2::Format;

use crate::pixel::{IntoPixel, Pixel};
use crate::texture::bc6h;
#[cfg(feature = "bc6h")]
use crate::texture::bc6h::encode as encode_bc6h;
#[cfg(not(feature = "bc6h"))]
use crate::texture::bc6h_encode::encode as encode_bc6h;
use crate::texture::packed_float;
use crate::texture::rgb9e5;

/// The largest `half`.
const MAX_HALF: f32 = 65504.0;

/// The texel format of a cube map in `.ktx2`, `.dds` and `.ktx`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum TexelFormat {
    /// Four `half`, alpha 1: 8 bytes, three digits, at most 65504.
    #[default]
    Rgba16F,
    /// Four `float`, alpha 1: 16 bytes, exact.
    Rgba32F,
    /// Nine bits for each color and one exponent for all, 4 bytes: the error is below 0.2 % of the largest channel of
    /// the texel; 0 to 65408.
    Rgb9e5,
    /// Floats without sign of 11, 11 and 10 bits, 4 bytes: the error is below 0.8 % in red and green and 1.6 % in blue; 0 to
    /// 64512. The only format in `.ktx`.
    R11G11B10F,
    /// BC6H without sign, blocks of 4 x 4 texels: 1 byte a texel, 0 to 65504. The feature `bc6h` chooses another encoder,
    /// which is better where edges between colors cross blocks.
    Bc6h,
    /// BC6H with sign; read only.
    Bc6hSigned,
    /// Three `half`; read only.
    Rgb16F,
    /// Three `float`; read only.
    Rgb32F,
    /// Bytes of linear light, white is 1; read only. With alpha or blue first too, as is the next one.
    Rgb8,
    /// Bytes encoded for displays by sRGB, white is 1; read only.
    Srgb8,
}

impl fmt::Display for TexelFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Rgba16F => "RGBA16F",
            Self::Rgba32F => "RGBA32F",
            Self::Rgb9e5 => "RGB9E5",
            Self::R11G11B10F => "R11G11B10F",
            Self::Bc6h => "BC6H",
            Self::Bc6hSigned => "signed BC6H",
            Self::Rgb16F => "RGB16F",
            Self::Rgb32F => "RGB32F",
            Self::Rgb8 => "RGB8",
            Self::Srgb8 => "sRGB8",
        })
    }
}

/// The number of no format in Direct3D.
const DXGI_UNKNOWN: u32 = 0;

/// Every format with its numbers in Vulkan and in Direct3D.
const FORMATS: [(TexelFormat, Format, u32); 10] = [
    (TexelFormat::Rgba16F, Format::R16G16B16A16_SFLOAT, 10),
    (TexelFormat::Rgba32F, Format::R32G32B32A32_SFLOAT, 2),
    (TexelFormat::Rgb9e5, Format::E5B9G9R9_UFLOAT_PACK32, 67),
    (TexelFormat::R11G11B10F, Format::B10G11R11_UFLOAT_PACK32, 26),
    (TexelFormat::Bc6h, Format::BC6H_UFLOAT_BLOCK, 95),
    (TexelFormat::Bc6hSigned, Format::BC6H_SFLOAT_BLOCK, 96),
    (TexelFormat::Rgb16F, Format::R16G16B16_SFLOAT, DXGI_UNKNOWN),
    (TexelFormat::Rgb32F, Format::R32G32B32_SFLOAT, 6),
    (TexelFormat::Rgb8, Format::R8G8B8_UNORM, DXGI_UNKNOWN),
    (TexelFormat::Srgb8, Format::R8G8B8_SRGB, DXGI_UNKNOWN),
];

impl TexelFormat {
    /// The largest number of a channel; infinity where a number of any size is kept.
    #[must_use]
    pub fn largest(self) -> f32 {
        match self {
            Self::Rgba32F | Self::Rgb32F => f32::INFINITY,
            Self::Rgba16F | Self::Rgb16F | Self::Bc6h | Self::Bc6hSigned => MAX_HALF,
            Self::Rgb9e5 => rgb9e5::MAX,
            Self::R11G11B10F => packed_float::MAX,
            Self::Rgb8 | Self::Srgb8 => 1.0,
        }
    }

    fn numbers(self) -> (Format, u32) {
        let Some((_, vulkan, dxgi)) = FORMATS.iter().find(|(format, ..)| *format == self) else {
            unreachable!("the table has every format")
        };
        (*vulkan, *dxgi)
    }

    pub(crate) fn vulkan(self) -> Format {
        self.numbers().0
    }

    /// The number of the format in the header DX10 of a DDS file.
    pub(crate) fn dxgi(self) -> u32 {
        self.numbers().1
    }

    pub(crate) fn from_vulkan(vulkan: Format) -> Option<Self> {
        FORMATS.iter().find(|(_, v, _)| *v == vulkan).map(|(format, ..)| *format)
    }

    pub(crate) fn from_dxgi(dxgi: u32) -> Option<Self> {
        FORMATS.iter().find(|(.., d)| *d == dxgi && *d != DXGI_UNKNOWN).map(|(format, ..)| *format)
    }

    /// Columns and rows, and bytes, of a storage unit: a texel, or a block.
    pub(crate) fn block(self) -> (usize, usize) {
        match self {
            Self::Rgba16F => (1, 8),
            Self::Rgba32F => (1, 16),
            Self::Rgb9e5 | Self::R11G11B10F => (1, 4),
            Self::Rgb16F => (1, 6),
            Self::Rgb32F => (1, 12),
            Self::Rgb8 | Self::Srgb8 => (1, 3),
            Self::Bc6h | Self::Bc6hSigned => (bc6h::BLOCK, bc6h::BLOCK_BYTES),
        }
    }

    /// The bytes of a texel or a block: the alignment of levels in a KTX2 file.
    pub(crate) fn block_bytes(self) -> usize {
        self.block().1
    }

    /// The bytes of a square picture, without gaps between its rows.
    pub(crate) fn face_bytes(self, size: usize) -> u64 {
        let (side, bytes) = self.block();
        let across = size.div_ceil(side) as u64;
        across * across * bytes as u64
    }

    /// Adds a row of texels of `width` columns to `texels`, or of a row of blocks the first `rows`.
    pub(crate) fn read_row(self, row: &[u8], width: usize, rows: usize, texels: &mut Vec<Pixel>) {
        match self {
            Self::Rgba16F => texels.extend(row.as_chunks::<8>().0.iter().map(half_texel)),
            Self::Rgba32F => texels.extend(row.as_chunks::<16>().0.iter().map(float_texel)),
            Self::Rgb9e5 => {
                let words = row.as_chunks::<4>().0.iter();
                texels.extend(words.map(|word| rgb9e5::decode(u32::from_le_bytes(*word))));
            }
            Self::R11G11B10F => {
                let words = row.as_chunks::<4>().0.iter();
                texels.extend(words.map(|word| packed_float::decode(u32::from_le_bytes(*word))));
            }
            Self::Bc6h | Self::Bc6hSigned => {
                bc6h::decode_blocks(row, width, rows, self == Self::Bc6hSigned, texels);
            }
            Self::Rgb16F | Self::Rgb32F | Self::Rgb8 | Self::Srgb8 => {
                unreachable!("channels side by side are read by stored_format")
            }
        }
    }

    /// The bytes of a square picture, and the number of texels clamped to the range of the format.
    ///
    /// NaN stays NaN where the format has it, and becomes 0 elsewhere.
    pub(crate) fn encode_face(self, size: usize, texels: &[impl IntoPixel]) -> Result<(Vec<u8>, usize), String> {
        let high = self.largest();
        let low = match self {
            Self::Rgba32F | Self::Rgba16F => -high,
            Self::Rgb9e5 | Self::R11G11B10F | Self::Bc6h => 0.0,
            Self::Bc6hSigned => return Err("signed BC6H is read, not written; choose BC6H".into()),
            Self::Rgb16F | Self::Rgb32F | Self::Rgb8 | Self::Srgb8 => {
                return Err(format!("{self} is read, not written; choose RGBA16F"));
            }
        };
        let has_nan = matches!(self, Self::Rgba16F | Self::Rgba32F);
        let fits = |c: f32| (low..=high).contains(&c) || (has_nan && c.is_nan());
        // Branch-free, so that it is vectorized.
        let clamped = texels
            .iter()
            .map(|t| (*t).into())
            .map(|t: Pixel| usize::from(!(fits(t[0]) & fits(t[1]) & fits(t[2]))))
            .sum();
        let fit = |texel: Pixel| texel.map(|c| if c.is_nan() && !has_nan { 0.0 } else { c.clamp(low, high) });
        let mut bytes = Vec::with_capacity(self.face_bytes(size) as usize);
        match self {
            Self::Rgba16F => {
                // Convert a row at a time: one instruction converts a vector of numbers.
                let (mut floats, mut halves) = (Vec::with_capacity(size), vec![f16::ZERO; 4 * size]);
                for row in texels.chunks_exact(size) {
                    floats.clear();
                    floats.extend(row.iter().map(|texel| {
                        let [r, g, b] = fit((*texel).into());
                        [r, g, b, 1.0]
                    }));
                    halves.convert_from_f32_slice(floats.as_flattened());
                    let start = bytes.len();
                    bytes.resize(start + halves.len() * size_of::<f16>(), 0);
                    for (out, half) in bytes[start..].as_chunks_mut().0.iter_mut().zip(&halves) {
                        *out = half.to_le_bytes();
                    }
                }
            }
            Self::Rgba32F => {
                for texel in texels {
                    let [r, g, b] = fit((*texel).into());
                    bytes.extend_from_slice([r, g, b, 1.0].map(f32::to_le_bytes).as_flattened());
                }
            }
            Self::Rgb9e5 => {
                for texel in texels {
                    bytes.extend_from_slice(&rgb9e5::encode((*texel).into()).to_le_bytes());
                }
            }
            Self::R11G11B10F => {
                for texel in texels {
                    bytes.extend_from_slice(&packed_float::encode(fit((*texel).into())).to_le_bytes());
                }
            }
            _ => {
                let texels: Vec<Pixel> = texels.iter().map(|t| fit((*t).into())).collect();
                bytes = encode_bc6h(size, &texels);
            }
        }
        Ok((bytes, clamped))
    }
}

fn half_texel(bytes: &[u8; 8]) -> Pixel {
    let half = |i: usize| f16::from_le_bytes([bytes[i], bytes[i + 1]]).to_f32();
    [half(0), half(2), half(4)]
}

fn float_texel(bytes: &[u8; 16]) -> Pixel {
    let [r, g, b, _] = [0, 4, 8, 12].map(|i| f32::from_le_bytes([bytes[i], bytes[i + 1], bytes[i + 2], bytes[i + 3]]));
    [r, g, b]
}
