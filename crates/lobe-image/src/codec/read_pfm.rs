//! Portable float map decoder.

use std::io::Read;

use crate::ImageError;
use crate::codec::decoded::{Decoded, PictureHead, RowStrip, check_size, invalid, io, reserve};
use crate::codec::lookahead::Lookahead;
use crate::pixel::{BLACK, Pixel};

/// The longest header: three numbers and white space.
const MAX_HEADER: usize = 256;

/// The most texels of the rows that are read at a time, but for one row that is longer.
const TEXELS_TOGETHER: usize = if cfg!(fuzzing) { 1 << 5 } else { 1 << 16 };

/// Decodes a portable float map; `name` stands for the file in messages.
pub(crate) fn decode(bytes: &[u8], name: &str, max_texels: usize) -> Result<Decoded, ImageError> {
    let (mut rows, head) = PfmRows::open(bytes, bytes.len() as u64, name, max_texels)?;
    let mut texels: Vec<Pixel> = reserve(head.width * head.height, name)?;
    texels.resize(head.width * head.height, BLACK);
    while let Some(band) = rows.next_strip()? {
        texels[band.first_row * head.width..][..band.texels.len()].copy_from_slice(&band.texels);
    }
    Ok(Decoded { head, texels })
}

/// A portable float map, `PF` in color or `Pf` in gray, whose header is read and whose rows are to come, from the bottom.
///
/// Three words follow the signature, each after white space: columns, rows, and a scale, whose sign gives the byte
/// order (negative: little-endian) and whose magnitude is a factor. One byte of white space ends the header. The
/// bottom row comes first.
pub(crate) struct PfmRows<R> {
    bytes: Lookahead<R>,
    name: String,
    width: usize,
    /// Rows that are to come.
    left: usize,
    channels: usize,
    scale: f32,
}

impl<R: Read> PfmRows<R> {
    /// The rows of a source of `length` bytes, and what its header says.
    pub(crate) fn open(
        source: R,
        length: u64,
        name: &str,
        max_texels: usize,
    ) -> Result<(Self, PictureHead), ImageError> {
        let mut bytes = Lookahead::new(source);
        let header = bytes.parse(|rest, has_ended| {
            (has_ended || rest.len() > MAX_HEADER).then(|| {
                let channels = if rest.starts_with(b"PF") { 3 } else { 1 };
                let header = Header::parse(rest, name)?;
                *rest = &rest[header.length..];
                Ok((header, channels))
            })
        });
        let (header, channels) = header.map_err(|e| io(name, e))?.ok_or_else(|| nothing_after_header(name))??;
        let (width, height) = check_size(header.width, header.height, max_texels, name)?;
        let there = length.saturating_sub(bytes.position());
        // The size passed the check of the limit, which fits a usize; so does four times three times it in a u64.
        let needed = 4 * channels as u64 * width as u64 * height as u64;
        if there < needed {
            let message =
                format!("the file ends early: {width} x {height} texels need {needed} bytes, {there} are there");
            return Err(invalid(name, message));
        }
        let mut head = PictureHead::new(width, height);
        let factor = header.scale.abs();
        if factor != 1.0 {
            head.notes.push(format!("the values are multiplied with the scale {factor} of the header"));
        }
        if there > needed {
            head.notes.push(format!("{} bytes after the picture are ignored", there - needed));
        }
        Ok((Self { bytes, name: name.to_owned(), width, left: height, channels, scale: header.scale }, head))
    }

    /// The next rows, which lie above those before; none at the end.
    pub(crate) fn next_strip(&mut self) -> Result<Option<RowStrip>, ImageError> {
        let count = (TEXELS_TOGETHER / self.width).max(1).min(self.left);
        if count == 0 {
            return Ok(None);
        }
        self.left -= count;
        let (channels, factor) = (self.channels, self.scale.abs());
        let order = if self.scale < 0.0 { f32::from_le_bytes } else { f32::from_be_bytes };
        let mut texels = vec![BLACK; count * self.width];
        for row in texels.chunks_exact_mut(self.width).rev() {
            let bytes = 4 * channels * self.width;
            let read = self.bytes.parse(|rest, _| {
                let values = rest.split_off(..bytes)?.as_chunks::<4>().0;
                for (texel, values) in row.iter_mut().zip(values.chunks_exact(channels)) {
                    *texel = [0, 1, 2].map(|c| order(values[c % channels]) * factor);
                }
                Some(())
            });
            // The length was checked: the file became shorter while it was read.
            let ends = || invalid(&self.name, "the file ends early: rows of the picture are missing".into());
            read.map_err(|e| io(&self.name, e))?.ok_or_else(ends)?;
        }
        Ok(Some(RowStrip { first_row: self.left, texels }))
    }
}

fn nothing_after_header(name: &str) -> ImageError {
    invalid(name, "the file ends early: there is nothing after the header".into())
}

struct Header {
    width: u64,
    height: u64,
    scale: f32,
    /// Bytes of the header with the white space that ends it.
    length: usize,
}

impl Header {
    fn parse(bytes: &[u8], name: &str) -> Result<Self, ImageError> {
        let mut position = 2;
        let mut word = || {
            let start = &bytes[position.min(bytes.len())..bytes.len().min(MAX_HEADER)];
            let skip = start.iter().take_while(|b| b.is_ascii_whitespace()).count();
            let length = start[skip..].iter().take_while(|b| !b.is_ascii_whitespace()).count();
            position += skip + length;
            let word = String::from_utf8_lossy(&start[skip..skip + length]).into_owned();
            (word, position)
        };
        let ((width, _), (height, _), (scale, end)) = (word(), word(), word());
        let bad = |what: &str, found: &str| {
            let found: String = found.chars().take(24).collect();
            invalid(name, format!("damaged portable float map: {what} expected in the header, found {found:?}"))
        };
        let number = |word: &str, what| word.parse().map_err(|_| bad(what, word));
        let (columns, rows) = (number(&width, "the number of columns")?, number(&height, "the number of rows")?);
        let factor: f32 = scale.parse().map_err(|_| bad("the scale", &scale))?;
        if !factor.is_normal() {
            return Err(bad("a scale that is neither 0 nor infinite", &scale));
        }
        match bytes.get(end) {
            Some(b) if b.is_ascii_whitespace() => {
                Ok(Self { width: columns, height: rows, scale: factor, length: end + 1 })
            }
            _ => Err(nothing_after_header(name)),
        }
    }
}
