//! Texel formats as files store them: those of [`TexelFormat`], and channels side by side with or without alpha.
//!
//! ```text
//!   RGB16F, RGB32F      half or float, three channels
//!   RGB8, sRGB8         bytes, three or four channels, red or blue first
//! ```

use std::io::{self, Read};

use half::f16;
use ktx2::Format;

use crate::picture::srgb::srgb_decode;
use crate::pixel::Pixel;
use crate::texture::texel_format::TexelFormat;

/// A texel format and how its channels lie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct StoredFormat {
    pub(crate) format: TexelFormat,
    /// Channels of a texel, alpha among them.
    channels: usize,
    /// Whether blue comes first.
    is_bgr: bool,
}

/// The formats of plain channels with their numbers in Vulkan.
const PLAIN: [(Format, TexelFormat, usize, bool); 10] = [
    (Format::R16G16B16_SFLOAT, TexelFormat::Rgb16F, 3, false),
    (Format::R32G32B32_SFLOAT, TexelFormat::Rgb32F, 3, false),
    (Format::R8G8B8_UNORM, TexelFormat::Rgb8, 3, false),
    (Format::R8G8B8_SRGB, TexelFormat::Srgb8, 3, false),
    (Format::B8G8R8_UNORM, TexelFormat::Rgb8, 3, true),
    (Format::B8G8R8_SRGB, TexelFormat::Srgb8, 3, true),
    (Format::R8G8B8A8_UNORM, TexelFormat::Rgb8, 4, false),
    (Format::R8G8B8A8_SRGB, TexelFormat::Srgb8, 4, false),
    (Format::B8G8R8A8_UNORM, TexelFormat::Rgb8, 4, true),
    (Format::B8G8R8A8_SRGB, TexelFormat::Srgb8, 4, true),
];

impl From<TexelFormat> for StoredFormat {
    fn from(format: TexelFormat) -> Self {
        Self { format, channels: 3, is_bgr: false }
    }
}

impl StoredFormat {
    pub(crate) fn from_vulkan(vulkan: Format) -> Option<Self> {
        let plain = PLAIN.iter().find(|(number, ..)| *number == vulkan);
        let plain = plain.map(|&(_, format, channels, is_bgr)| Self { format, channels, is_bgr });
        plain.or_else(|| TexelFormat::from_vulkan(vulkan).map(Self::from))
    }

    /// Plain channels of a type, as OpenGL names them.
    pub(crate) fn plain(format: TexelFormat, channels: usize, is_bgr: bool) -> Self {
        match (format, channels, is_bgr) {
            (TexelFormat::Rgb16F, 4, false) => TexelFormat::Rgba16F.into(),
            (TexelFormat::Rgb32F, 4, false) => TexelFormat::Rgba32F.into(),
            _ => Self { format, channels, is_bgr },
        }
    }

    /// The same bytes, encoded for displays; none if they are no bytes.
    pub(crate) fn of_srgb(self) -> Option<Self> {
        let is_bytes = matches!(self.format, TexelFormat::Rgb8 | TexelFormat::Srgb8);
        is_bytes.then_some(Self { format: TexelFormat::Srgb8, ..self })
    }

    /// Columns and rows, and bytes, of a storage unit: a texel, or a block.
    fn block(self) -> (usize, usize) {
        match self.format {
            TexelFormat::Rgb16F => (1, 2 * self.channels),
            TexelFormat::Rgb32F => (1, 4 * self.channels),
            TexelFormat::Rgb8 | TexelFormat::Srgb8 => (1, self.channels),
            format => format.block(),
        }
    }

    /// Bytes of a row of texels or blocks, each row at a multiple of `alignment`.
    fn row_bytes(self, width: usize, alignment: usize) -> u64 {
        let (side, bytes) = self.block();
        (width.div_ceil(side) as u64 * bytes as u64).next_multiple_of(alignment as u64)
    }

    /// The bytes of a picture whose rows begin at multiples of `alignment`.
    pub(crate) fn picture_bytes(self, [width, height]: [usize; 2], alignment: usize) -> u64 {
        self.row_bytes(width, alignment) * height.div_ceil(self.block().0) as u64
    }

    /// Reads a picture and appends it to `texels`, one row of texels or blocks at a time: memory is allocated for data
    /// that were read, not for data that are declared.
    pub(crate) fn read_picture(
        self,
        [width, height]: [usize; 2],
        alignment: usize,
        source: &mut dyn Read,
        texels: &mut Vec<Pixel>,
    ) -> io::Result<()> {
        let side = self.block().0;
        let mut row = vec![0; self.row_bytes(width, alignment) as usize];
        let mut light = [0.0; 256];
        let is_srgb = self.format == TexelFormat::Srgb8;
        for (value, light) in light.iter_mut().enumerate() {
            let value = value as f64 / 255.0;
            *light = if is_srgb { srgb_decode(value) as f32 } else { value as f32 };
        }
        for y in (0..height).step_by(side) {
            source.read_exact(&mut row)?;
            match self.format {
                TexelFormat::Rgb16F => {
                    texels.extend(self.plain_row::<2>(&row, width, |c| f16::from_le_bytes(c).into()));
                }
                TexelFormat::Rgb32F => texels.extend(self.plain_row::<4>(&row, width, f32::from_le_bytes)),
                TexelFormat::Rgb8 | TexelFormat::Srgb8 => {
                    texels.extend(self.plain_row::<1>(&row, width, |[c]| light[usize::from(c)]));
                }
                format => format.read_row(&row, width, side.min(height - y), texels),
            }
        }
        Ok(())
    }

    /// The texels of a row of channels of `N` bytes.
    fn plain_row<'a, const N: usize>(
        self,
        row: &'a [u8],
        width: usize,
        value: impl Fn([u8; N]) -> f32 + 'a,
    ) -> impl Iterator<Item = Pixel> + 'a {
        let order = if self.is_bgr { [2, 1, 0] } else { [0, 1, 2] };
        let channels = row.as_chunks::<N>().0;
        channels.chunks_exact(self.channels).take(width).map(move |texel| order.map(|c| value(texel[c])))
    }
}
