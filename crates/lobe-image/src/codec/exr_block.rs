//! Blocks of an OpenEXR picture: how they are decoded, and where they lie in the picture.

use exr::block::chunk::Chunk;
use exr::block::{BlockIndex, UncompressedBlock};
use exr::error::Error as ExrError;
use exr::meta::MetaData;
use exr::meta::attribute::{ChannelDescription, SampleType};
use exr::meta::header::Header;
use half::f16;
use half::slice::HalfFloatSliceExt as _;

use crate::error::{ImageError, ReadOption};
use crate::header::decoded::{RowStrip, check_size, invalid, io, unsupported};
use crate::pixel::{BLACK, Pixel};

/// The most bytes of a block for each texel of the limit: four channels of `float`.
const BLOCK_BYTES_PER_TEXEL: u64 = 16;

/// The most texels of a display window for each of the data window: more is damage, or a waste of memory.
const MOST_BLACK: u64 = 4096;

/// A display window of up to this many texels is accepted with any data window.
const ANY_BLACK: u64 = 1 << 20;

/// The data window relative to the display window, which becomes the map.
#[derive(Clone, Copy)]
pub(crate) struct Windows {
    pub(crate) width: usize,
    pub(crate) height: usize,
    /// Position of the data window relative to the display window.
    pub(crate) offset: (i64, i64),
    pub(crate) data_size: (usize, usize),
}

impl Windows {
    pub(crate) fn of(header: &Header, max_texels: usize, name: &str) -> Result<Self, ImageError> {
        let display = header.shared_attributes.display_window;
        let data = header.data_window();
        let (width, height) = check_size(display.size.0 as u64, display.size.1 as u64, max_texels, name)?;
        // A data window may be larger than the display, and a block larger than both: bound the memory of decoding.
        let block = header.max_block_pixel_size();
        let block_area = (block.0.min(data.size.0) as u64).saturating_mul(block.1.min(data.size.1) as u64);
        let block_bytes = block_area.saturating_mul(header.channels.bytes_per_pixel as u64);
        let limit = max_texels as u64;
        let refused = |message| ImageError::Refused { place: name.into(), message, option: ReadOption::MaxTexels };
        if (data.size.0 as u64).saturating_mul(data.size.1 as u64) > limit {
            let (w, h) = (data.size.0, data.size.1);
            return Err(refused(format!("the data window is {w} x {h}, more than the limit of {limit} texels")));
        }
        if block_bytes > limit.saturating_mul(BLOCK_BYTES_PER_TEXEL) {
            let message = format!(
                "a block holds {block_bytes} bytes, more than {BLOCK_BYTES_PER_TEXEL} for each of {limit} texels"
            );
            return Err(refused(message));
        }
        let (shown, there) = ((width * height) as u64, (data.size.0 * data.size.1) as u64);
        if shown > MOST_BLACK.saturating_mul(there).max(ANY_BLACK) {
            let message = format!(
                "the display window is {width} x {height}, and the data window only {} x {}: the rest would be black",
                data.size.0, data.size.1
            );
            return Err(invalid(name, message));
        }
        let offset = (
            i64::from(data.position.0) - i64::from(display.position.0),
            i64::from(data.position.1) - i64::from(display.position.1),
        );
        Ok(Self { width, height, offset, data_size: (data.size.0, data.size.1) })
    }

    /// Whether a block is of a part's largest level and shows in the picture.
    pub(crate) fn want(&self, block: &BlockIndex, part: usize) -> bool {
        block.layer == part && block.level.0 == 0 && block.level.1 == 0 && self.shows(block)
    }

    /// Whether any texel of a block lies in the display window.
    fn shows(&self, block: &BlockIndex) -> bool {
        let overlaps = |offset: i64, start: usize, size: usize, limit: usize| {
            offset + (start as i64) < limit as i64 && offset + ((start + size) as i64) > 0
        };
        overlaps(self.offset.0, block.pixel_position.0, block.pixel_size.0, self.width)
            && overlaps(self.offset.1, block.pixel_position.1, block.pixel_size.1, self.height)
    }

    /// Copies the part of some blocks inside the display window; rows are added as needed.
    pub(crate) fn blit(&self, blocks: &[Block], texels: &mut Vec<Pixel>) {
        for block in blocks {
            let left = self.offset.0 + block.x as i64;
            let skip = (-left).max(0) as usize;
            let x = left.max(0) as usize;
            for (k, line) in block.texels.chunks_exact(block.width).enumerate() {
                let y = self.offset.1 + (block.y + k) as i64;
                if (0..self.height as i64).contains(&y) && skip < block.width && x < self.width {
                    let (start, end) = (y as usize * self.width, (y as usize + 1) * self.width);
                    texels.resize(end.max(texels.len()), BLACK);
                    let count = (block.width - skip).min(self.width - x);
                    texels[start + x..][..count].copy_from_slice(&line[skip..][..count]);
                }
            }
        }
    }

    /// The rows of the picture that a block of whole rows of the data window has.
    pub(crate) fn band(&self, block: Block) -> RowStrip {
        let top = self.offset.1 + block.y as i64;
        if self.offset.0 == 0 && block.width == self.width && top >= 0 {
            let mut texels = block.texels;
            texels.truncate((self.height - top as usize) * self.width);
            return RowStrip { first_row: top as usize, texels };
        }
        let mut texels = Vec::new();
        let first_row = top.max(0);
        let offset = (self.offset.0, self.offset.1 - first_row);
        Self { offset, height: self.height - first_row as usize, ..*self }.blit(&[block], &mut texels);
        RowStrip { first_row: first_row as usize, texels }
    }

    pub(crate) fn is_data_equal_to_display(&self) -> bool {
        self.offset == (0, 0) && self.data_size == (self.width, self.height)
    }
}

/// A decoded block: the colors of a rectangle of the data window.
pub(crate) struct Block {
    x: usize,
    y: usize,
    width: usize,
    texels: Vec<Pixel>,
}

impl Block {
    /// The colors of a block, whose channels of red, green and blue have these places in the list of channels.
    pub(crate) fn decode(chunk: Chunk, meta: &MetaData, rgb: [usize; 3]) -> Result<Self, ExrError> {
        let header = &meta.headers[chunk.layer_index];
        let block = UncompressedBlock::decompress_chunk(chunk, meta, false)?;
        let (position, size) = (block.index.pixel_position, block.index.pixel_size);
        // Rows follow each other, in each the channels: none is subsampled.
        let list = &header.channels.list;
        let bytes_of = |channel: &ChannelDescription| size.0 * channel.sample_type.bytes_per_sample();
        let bytes_of_row: usize = list.iter().map(bytes_of).sum();
        let lines = rgb.map(|c| {
            let start: usize = list[..c].iter().map(bytes_of).sum();
            (start..start + bytes_of(&list[c]), list[c].sample_type)
        });
        let mut texels = Vec::with_capacity(size.area());
        if lines.iter().all(|(_, sample_type)| *sample_type == SampleType::F32) {
            for row in block.data.chunks_exact(bytes_of_row) {
                extend_by_floats(&mut texels, lines.each_ref().map(|(line, _)| &row[line.clone()]));
            }
            return Ok(Self { x: position.0, y: position.1, width: size.0, texels });
        }
        let mut numbers = [(); 3].map(|()| vec![0.0; size.0]);
        for row in block.data.chunks_exact(bytes_of_row) {
            for ((line, sample_type), numbers) in lines.iter().zip(&mut numbers) {
                read_samples(&row[line.clone()], *sample_type, numbers);
            }
            let [r, g, b] = &numbers;
            texels.extend(r.iter().zip(g).zip(b).map(|((r, g), b)| [*r, *g, *b]));
        }
        Ok(Self { x: position.0, y: position.1, width: size.0, texels })
    }
}

/// Appends the texels of a row whose three lines are floats, in native byte order, at once.
fn extend_by_floats(texels: &mut Vec<Pixel>, lines: [&[u8]; 3]) {
    let [r, g, b] = lines.map(|line| line.as_chunks().0.iter().map(|bytes| f32::from_ne_bytes(*bytes)));
    texels.extend(r.zip(g).zip(b).map(|((r, g), b)| [r, g, b]));
}

/// The numbers of a line of samples, which the library gives in native byte order.
fn read_samples(line: &[u8], sample_type: SampleType, numbers: &mut [f32]) {
    match sample_type {
        SampleType::F16 => {
            const TOGETHER: usize = 64;
            let halves = line.as_chunks::<2>().0;
            for (halves, numbers) in halves.chunks(TOGETHER).zip(numbers.chunks_mut(TOGETHER)) {
                let mut together = [f16::ZERO; TOGETHER];
                together.iter_mut().zip(halves).for_each(|(half, b)| *half = f16::from_ne_bytes(*b));
                together[..halves.len()].convert_to_f32_slice(&mut numbers[..halves.len()]);
            }
        }
        SampleType::F32 => {
            numbers.iter_mut().zip(line.as_chunks().0).for_each(|(number, b)| *number = f32::from_ne_bytes(*b));
        }
        // Integer channels were refused.
        SampleType::U32 => {}
    }
}

/// Translates an error of the library.
pub(crate) fn explain(error: ExrError, name: &str) -> ImageError {
    match error {
        ExrError::Io(error) => io(name, error),
        ExrError::NotSupported(what) => unsupported(name, format!("this kind of OpenEXR file is not read: {what}")),
        ExrError::Invalid(what) if what.contains("missing bytes") => {
            invalid(name, "the file ends early: parts of the picture are missing".into())
        }
        ExrError::Invalid(what) => invalid(name, format!("damaged OpenEXR picture: {what}")),
        other => invalid(name, format!("damaged OpenEXR picture: {other}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn floats_at_once_are_those_line_by_line() {
        let numbers: Vec<f32> = (0..51).map(|k| (k as f32 - 7.3) * 1e3_f32.powi(k % 5 - 2)).collect();
        let bytes: Vec<u8> = numbers.iter().flat_map(|x| x.to_ne_bytes()).collect();
        let lines: [&[u8]; 3] = std::array::from_fn(|c| &bytes[c * 68..][..68]);
        let mut at_once = Vec::new();
        extend_by_floats(&mut at_once, lines);
        let by_line = lines.map(|line| {
            let mut numbers = vec![0.0; 17];
            read_samples(line, SampleType::F32, &mut numbers);
            numbers
        });
        let expected: Vec<Pixel> = (0..17).map(|x| by_line.each_ref().map(|numbers| numbers[x])).collect();
        assert_eq!(at_once, expected, "red, green and blue of 17 texels");
    }
}
