//! Radiance (.hdr) decoder: the header; rows are decoded by `rgbe`.

use std::io::Read;

use crate::ImageError;
use crate::codec::decoded::{Decoded, PictureHead, check_size, invalid, io, reserve, unsupported};
use crate::codec::lookahead::Lookahead;
use crate::codec::rgbe::{self, RowError};
use crate::picture::png::MAPPING_KEY;
use crate::picture::primaries::Primaries;
use crate::pixel::Pixel;

/// The value of `FORMAT` that is read.
const RGBE: &str = "32-bit_rle_rgbe";

/// The longest header: a thousand commands that made the picture, line by line.
const MOST_HEADER: usize = 1 << 20;

/// The fault of a file whose line ends were converted, and with them the bytes of texels that look like line ends.
const SENT_AS_TEXT: &str =
    "the file seems to have been sent or saved as text, with line ends of CRLF; take the original";

/// Decodes a Radiance picture; `name` stands for the file in messages.
pub(crate) fn decode(bytes: &[u8], name: &str, max_texels: usize) -> Result<Decoded, ImageError> {
    let (mut rows, head) = HdrRows::open(bytes, bytes.len() as u64, name, max_texels)?;
    let mut texels: Vec<Pixel> = reserve(head.width * head.height, name)?;
    rows.next_rows_into(head.height, &mut texels)?;
    Ok(Decoded { head, texels })
}

/// A Radiance picture whose header is read and whose rows are to come, from the top.
pub(crate) struct HdrRows<R> {
    bytes: Lookahead<R>,
    name: String,
    height: usize,
    /// The row that comes next.
    next_row: usize,
    /// From stored values to radiance.
    factors: Pixel,
    steps: Box<[f32; 256]>,
    row: Vec<[u8; 4]>,
    /// Whether lines end with CRLF, as Windows has it.
    has_crlf: bool,
}

impl<R: Read> HdrRows<R> {
    /// The rows of a source of `length` bytes, and what its header says.
    pub(crate) fn open(
        source: R,
        length: u64,
        name: &str,
        max_texels: usize,
    ) -> Result<(Self, PictureHead), ImageError> {
        let mut bytes = Lookahead::new(source);
        let header = bytes.parse(|rest, has_ended| {
            let length = rest.len();
            let header = Header::parse(rest, name);
            // A header is whole if anything follows.
            if !has_ended && rest.is_empty() && length >= MOST_HEADER {
                return Some(Err(damaged(name, &format!("its header does not end within {MOST_HEADER} bytes"))));
            }
            (has_ended || !rest.is_empty()).then_some(header)
        });
        let cut_off = || invalid(name, "the file ends early: the header is not all there".into());
        let header = header.map_err(|source| io(name, source))?.ok_or_else(cut_off)??;
        let (width, height) = check_size(header.width, header.height, max_texels, name)?;
        let (least, there) = (least_bytes(width, height), length.saturating_sub(bytes.position()));
        if there < least {
            let message = format!(
                "the file ends early: {width} x {height} texels need {least} bytes at the least, {there} are there"
            );
            return Err(invalid(name, message));
        }
        let mut head = PictureHead::new(width, height);
        let factors = header.radiance_factors(name, &mut head.notes)?;
        head.primaries = header.primaries().map(|primaries| ("the PRIMARIES of the header", primaries));
        header.note_ignored(head.primaries.is_some(), &mut head.notes);
        head.mapping = header.lines.iter().find(|(key, _)| key == MAPPING_KEY).map(|(_, value)| value.clone());
        let mut row = reserve(width, name)?;
        row.resize(width, [0; 4]);
        let (steps, has_crlf) = (Box::new(rgbe::steps()), header.has_crlf);
        Ok((Self { bytes, name: name.to_owned(), height, next_row: 0, factors, steps, row, has_crlf }, head))
    }

    /// The row that comes next.
    pub(crate) fn next_row(&self) -> usize {
        self.next_row
    }

    /// Adds the next `count` rows, or all that are left, to `texels`.
    pub(crate) fn next_rows_into(&mut self, count: usize, texels: &mut Vec<Pixel>) -> Result<(), ImageError> {
        let Self { bytes, name, height, next_row, factors, steps, row, has_crlf } = self;
        let ends = || invalid(name, "the file ends early: rows of the picture are missing".into());
        for _ in 0..count.min(*height - *next_row) {
            let read = bytes.parse(|rest, has_ended| match rgbe::read_row(rest, row) {
                Err(RowError::Ends) if !has_ended => None,
                read => Some(read),
            });
            let read = read.map_err(|source| io(name, source))?.ok_or_else(ends)?;
            read.map_err(|error| match error {
                _ if *has_crlf => damaged(name, SENT_AS_TEXT),
                RowError::Ends => ends(),
                RowError::Damaged(what) => damaged(name, &what),
            })?;
            texels.extend(row.iter().map(|texel| {
                let [r, g, b] = rgbe::decode(*texel, steps);
                [r * factors[0], g * factors[1], b * factors[2]]
            }));
            *next_row += 1;
        }
        // Each texel byte that was converted is one byte more.
        if *has_crlf && next_row == height && !bytes.is_at_end().map_err(|source| io(name, source))? {
            return Err(damaged(name, SENT_AS_TEXT));
        }
        Ok(())
    }
}

fn damaged(name: &str, what: &str) -> ImageError {
    invalid(name, format!("damaged Radiance picture: {what}"))
}

/// The lines before the texels: `KEY=value` up to an empty line, then the size.
struct Header {
    width: u64,
    height: u64,
    lines: Vec<(String, String)>,
    /// Whether the lines end with CRLF, as Windows has it.
    has_crlf: bool,
}

impl Header {
    /// Reads the header from the start of `bytes`, and removes it from them. A line that is no `KEY=value` is a comment or the
    /// command that made the picture.
    fn parse(bytes: &mut &[u8], name: &str) -> Result<Self, ImageError> {
        let mut next_line = |missing: &str| {
            if bytes.is_empty() {
                return Err(invalid(name, format!("the file ends early: {missing} is missing")));
            }
            let length = bytes.iter().position(|b| *b == b'\n').unwrap_or(bytes.len());
            let line = String::from_utf8_lossy(&bytes[..length]).into_owned();
            *bytes = &bytes[(length + 1).min(bytes.len())..];
            Ok(line)
        };
        let mut lines = Vec::new();
        let has_crlf = loop {
            let line = next_line("the empty line that ends the header")?;
            if line.is_empty() || line == "\r" {
                break line == "\r";
            }
            if !line.starts_with('#')
                && let Some((key, value)) = line.split_once('=')
            {
                lines.push((key.trim().to_owned(), value.trim().to_owned()));
            }
        };
        let only = "only RGBE pictures with rows from the top and columns from the left (-Y h +X w) are read";
        if let Some((_, found)) = lines.iter().find(|(key, value)| key == "FORMAT" && value != RGBE) {
            let remedy = "convert colors in XYZ with ra_xyze -r IN.hdr OUT.hdr of Radiance";
            return Err(unsupported(name, format!("{only}, found FORMAT={found}; {remedy}")));
        }
        let size = next_line("the size of the picture")?;
        let (width, height) = match size.split_whitespace().collect::<Vec<_>>()[..] {
            ["-Y", height, "+X", width, ..] => (width, height),
            [first, _, second, _, ..] => {
                let remedy = "turn it with oiiotool IN.hdr --reorient -o OUT.hdr of OpenImageIO";
                return Err(unsupported(name, format!("{only}, found {first} {second}; {remedy}")));
            }
            _ => return Err(damaged(name, &format!("a size as in \"-Y 512 +X 1024\" expected, found {size:?}"))),
        };
        let number = |text: &str, what: &str| {
            let message = || damaged(name, &format!("the number of {what} expected, found {text:?}"));
            text.parse::<u32>().map(u64::from).map_err(|_| message())
        };
        Ok(Self { height: number(height, "rows")?, width: number(width, "columns")?, lines, has_crlf })
    }

    /// The numbers of every line of a key.
    fn numbers<'a>(&'a self, key: &'a str) -> impl Iterator<Item = Vec<f32>> + 'a {
        let of_line = |value: &str| value.split_whitespace().map_while(|number| number.parse().ok()).collect();
        self.lines.iter().filter(move |(found, _)| found == key).map(move |(_, value)| of_line(value))
    }

    /// The factors from stored values to radiance: `1 / (EXPOSURE COLORCORR)`, where all lines of a key are multiplied.
    fn radiance_factors(&self, name: &str, notes: &mut Vec<String>) -> Result<Pixel, ImageError> {
        let exposure: f32 = self.numbers("EXPOSURE").filter(|n| n.len() == 1).map(|n| n[0]).product();
        let mut colors = [1.0_f32; 3];
        for line in self.numbers("COLORCORR").filter(|n| n.len() >= 3) {
            colors.iter_mut().zip(line).for_each(|(color, factor)| *color *= factor);
        }
        let ([r, g, b], factors) = (colors, colors.map(|color| 1.0 / (exposure * color)));
        if !factors.iter().all(|f| f.is_normal() && *f > 0.0) {
            let message = format!(
                "EXPOSURE {exposure:?} and COLORCORR {r:?} {g:?} {b:?} must be positive numbers of ordinary size"
            );
            return Err(invalid(name, message));
        }
        if factors != [1.0; 3] {
            notes.push(format!("EXPOSURE {exposure} and COLORCORR {r} {g} {b} of the header are divided out"));
        }
        Ok(factors)
    }

    /// The primaries and the white; some programs write eight zeros for "unknown".
    fn primaries(&self) -> Option<Primaries> {
        let numbers: [f32; 8] = self.numbers("PRIMARIES").last()?.try_into().ok()?;
        let [red, green, blue, white] = *numbers.map(f64::from).as_chunks().0 else { return None };
        Primaries::new(red, green, blue, white)
    }

    /// Adds remarks on lines that are ignored.
    fn note_ignored(&self, has_primaries: bool, notes: &mut Vec<String>) {
        for (key, value) in &self.lines {
            let numbers: Vec<f64> = value.split_whitespace().filter_map(|n| n.parse().ok()).collect();
            let is_neutral = match key.as_str() {
                "PRIMARIES" => has_primaries || numbers.iter().all(|n| *n == 0.0),
                "GAMMA" | "PIXASPECT" => numbers == [1.0],
                _ => true,
            };
            if !is_neutral {
                notes.push(format!("{key}={value} of the header is ignored"));
            }
        }
    }
}

/// The least number of bytes of a picture.
///
/// The densest rows are those of the old encoding: one texel of four bytes, then one repeat count for each digit of
/// `width - 1` in base 256, four bytes each.
fn least_bytes(width: usize, height: usize) -> u64 {
    let digits = (width - 1).checked_ilog(256).map_or(0, |digits| u64::from(digits) + 1);
    4 * (1 + digits) * height as u64
}
