//! Portable float map decoder.

use std::io::Read;

use crate::codec::lookahead::Lookahead;
use crate::error::ImageError;
use crate::header::decoded::{Decoded, PictureHead, RowStrip, check_size, invalid, io, reserve};
use crate::pixel::{BLACK, Pixel};

/// The longest header: three numbers, white space and comments.
const MAX_HEADER: usize = 1024;

/// Numbers behind the header that are looked at where two ends of it are possible.
const LOOKED_AT: usize = 256;

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
/// order (negative: little-endian) and whose magnitude is a factor. One byte of white space ends the header, or, by
/// some programs, CR LF or more ([`separator`]). The bottom row comes first.
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
            (has_ended || rest.len() > MAX_HEADER + 4 * (LOOKED_AT + 1)).then(|| {
                let header = Header::parse(rest, name)?;
                let channels = if rest.starts_with(b"PF") { 3 } else { 1 };
                let (width, height) = check_size(header.width, header.height, max_texels, name)?;
                // The size passed the check of the limit, which fits a usize; so does four times three times it in a
                // u64.
                let needed = 4 * channels as u64 * width as u64 * height as u64;
                let behind = &rest[header.length..];
                let there = length.saturating_sub(header.length as u64);
                let end = separator(behind, there.saturating_sub(needed), header.scale);
                *rest = &behind[end..];
                Ok((header.scale, [width, height, channels], needed))
            })
        });
        let header = header.map_err(|e| io(name, e))?.ok_or_else(|| nothing_after_header(name))?;
        let (scale, [width, height, channels], needed) = header?;
        let there = length.saturating_sub(bytes.position());
        if there < needed {
            let message =
                format!("the file ends early: {width} x {height} texels need {needed} bytes, {there} are there");
            return Err(invalid(name, message));
        }
        let mut head = PictureHead::new(width, height);
        let factor = scale.abs();
        if factor != 1.0 {
            head.notes.push(format!("the values are multiplied with the scale {factor} of the header"));
        }
        if there > needed {
            head.notes.push(format!("{} bytes after the picture are ignored", there - needed));
        }
        Ok((Self { bytes, name: name.to_owned(), width, left: height, channels, scale }, head))
    }

    /// The next rows, which lie above those before; none at the end.
    pub(crate) fn next_strip(&mut self) -> Result<Option<RowStrip>, ImageError> {
        let count = (TEXELS_TOGETHER / self.width).max(1).min(self.left);
        if count == 0 {
            return Ok(None);
        }
        self.left -= count;
        let (channels, factor) = (self.channels, self.scale.abs());
        let order = byte_order(self.scale);
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

/// The number of bytes of white space, at the start of `behind`, between the scale and the texels, if a file is `extra`
/// bytes longer than its words and its texels.
///
/// Most often that is a line end, as Unix or Windows has it, perhaps behind blanks. Where the bytes before the texels
/// are all white space and the texels end with the file, the length of the file tells it; that is needed where the
/// first byte of a texel looks like white space. If bytes may also follow the texels, the numbers that come out decide.
fn separator(behind: &[u8], extra: u64, scale: f32) -> usize {
    let run = behind.iter().take(MAX_HEADER).take_while(|b| b.is_ascii_whitespace()).count();
    let line = behind[..run].iter().position(|b| *b == b'\n').map_or(1, |at| at + 1);
    match usize::try_from(extra) {
        Ok(exact) if (1..=run).contains(&exact) => {
            let usual = |end: usize| usual_numbers(&behind[end..], scale);
            if line != exact && usual(line) > usual(exact) { line } else { exact }
        }
        _ => line,
    }
}

/// How many of the next numbers are 0 or have a usual size. Numbers read from the wrong byte on are so by chance.
fn usual_numbers(bytes: &[u8], scale: f32) -> usize {
    let is_usual = |value: f32| value == 0.0 || (-40.0..40.0).contains(&value.abs().log2());
    let numbers = bytes.as_chunks::<4>().0.iter().take(LOOKED_AT);
    numbers.filter(|number| is_usual(byte_order(scale)(**number))).count()
}

/// From bytes to a number, by the sign of the scale.
fn byte_order(scale: f32) -> fn([u8; 4]) -> f32 {
    if scale < 0.0 { f32::from_le_bytes } else { f32::from_be_bytes }
}

struct Header {
    width: u64,
    height: u64,
    scale: f32,
    /// Bytes of the header without the white space that ends it.
    length: usize,
}

impl Header {
    fn parse(bytes: &[u8], name: &str) -> Result<Self, ImageError> {
        let mut position = 2;
        let mut word = || {
            let start = &bytes[position.min(bytes.len())..bytes.len().min(MAX_HEADER)];
            let skip = before_word(start);
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
            Some(b) if b.is_ascii_whitespace() => Ok(Self { width: columns, height: rows, scale: factor, length: end }),
            _ => Err(nothing_after_header(name)),
        }
    }
}

/// White space, and comments from `#` to the end of a line.
fn before_word(bytes: &[u8]) -> usize {
    let mut is_comment = false;
    let mut is_skipped = |b: &&u8| {
        is_comment = **b == b'#' || (is_comment && !matches!(**b, b'\n' | b'\r'));
        is_comment || b.is_ascii_whitespace()
    };
    bytes.iter().take_while(|b| is_skipped(b)).count()
}
