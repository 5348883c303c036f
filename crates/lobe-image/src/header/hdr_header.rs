//! Header of a Radiance (.hdr) picture.
//!
//! ```text
//!   #?RADIANCE
//!   KEY=value               counts only if it begins in the first column
//!   <tab>KEY=value          history: the header of a picture from which a program made this one
//!   FORMAT=32-bit_rle_rgbe
//!   (an empty line)
//!   -Y 512 +X 1024          the axis along which scan lines follow one another, then that of their texels
//! ```
//!
//! `header.c` and `color.c` of Radiance. Programs that combine pictures have already used what the history says.

use std::collections::BTreeMap;

use crate::error::ImageError;
use crate::header::decoded::{PictureHead, invalid, quoted, unsupported};
use crate::header::orientation::Orientation;
use crate::picture::png::MAPPING_KEY;
use crate::picture::primaries::Primaries;
use crate::pixel::Pixel;

/// The values of `FORMAT` that are read.
const RGBE: &str = "32-bit_rle_rgbe";
const XYZE: &str = "32-bit_rle_xyze";

/// The value of `FORMAT` of pictures with more channels than three, `.hsr`.
const SPECTRA: &str = "Radiance_spectra";

/// Lumens of a watt of white light: colors in XYZ count lumens, those in RGB watts. Radiance defines it as
/// `WHTEFFICACY`.
pub(crate) const WHITE_EFFICACY: f64 = 179.0;

/// The keys that change light or where it comes from.
const KEYS: [&str; 7] = ["FORMAT", "EXPOSURE", "COLORCORR", "PRIMARIES", "PIXASPECT", "GAMMA", "VIEW"];

/// The colors of texels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Colors {
    Rgb,
    Xyz,
}

/// The lines before the texels: `KEY=value` up to an empty line, then the size.
pub(crate) struct HdrHeader {
    /// Texels of a scan line.
    pub(crate) columns: u64,
    /// Scan lines.
    pub(crate) rows: u64,
    pub(crate) orientation: Orientation,
    pub(crate) colors: Colors,
    lines: Vec<(String, String)>,
    /// Whether the lines end with CRLF, as Windows has it.
    pub(crate) has_crlf: bool,
}

pub(crate) fn damaged(name: &str, what: &str) -> ImageError {
    invalid(name, format!("damaged Radiance picture: {what}"))
}

impl HdrHeader {
    /// Reads the header from the start of `bytes`, and removes it from them. A line that is no `KEY=value` is a comment
    /// or the command that made the picture.
    pub(crate) fn parse(bytes: &mut &[u8], name: &str) -> Result<Self, ImageError> {
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
            if !line.starts_with(|first: char| first == '#' || first.is_whitespace())
                && let Some((key, value)) = line.split_once('=')
            {
                lines.push((key.trim_end().to_owned(), value.trim().to_owned()));
            }
        };
        let colors = colors_of(&lines, name)?;
        let size = next_line("the size of the picture")?;
        let ([rows, columns], orientation) = size_of(&size, name)?;
        Ok(Self { columns, rows, orientation, colors, lines, has_crlf })
    }

    /// The factors from stored values to radiance; what else the header says goes to `head`.
    pub(crate) fn tell(&self, name: &str, head: &mut PictureHead) -> Result<Pixel, ImageError> {
        let factors = self.radiance_factors(name, &mut head.notes)?;
        match self.colors {
            Colors::Rgb => self.tell_primaries(head),
            Colors::Xyz => {
                head.notes.push(format!(
                    "colors in XYZ are read as those of Radiance's primaries, of {WHITE_EFFICACY} lumens in a watt"
                ));
                head.primaries = Some(("the primaries of Radiance", Primaries::RADIANCE));
            }
        }
        self.note_ignored(&mut head.notes);
        head.mapping = self.values(MAPPING_KEY).next().map(str::to_owned);
        Ok(factors)
    }

    fn values<'a>(&'a self, key: &'a str) -> impl Iterator<Item = &'a str> {
        self.lines.iter().filter(move |(found, _)| found == key).map(|(_, value)| value.as_str())
    }

    /// The product of all lines of a key, each of `N` numbers. Zeros, which `FreeImage` writes where it knows no
    /// exposure, count as 1; lines that are no such numbers are left out. Both are noted.
    fn product<const N: usize>(&self, key: &str, notes: &mut Vec<String>) -> [f32; N] {
        let mut product = [1.0; N];
        let (mut zero, mut ignored) = (Lines::default(), Lines::default());
        for value in self.values(key) {
            match numbers::<N>(value) {
                Some(zeros) if zeros == [0.0; N] => zero.add(value),
                Some(factors) => product.iter_mut().zip(factors).for_each(|(product, factor)| *product *= factor),
                None => ignored.add(value),
            }
        }
        if zero.count > 0 {
            notes.push(format!("{} of the header is read as 1", zero.named(key)));
        }
        if ignored.count > 0 {
            let expected = if N == 1 { "no number".to_owned() } else { format!("not {N} numbers") };
            notes.push(format!("{} of the header is {expected}, and is ignored", ignored.named(key)));
        }
        product
    }

    /// The factors from stored values to radiance: `1 / (EXPOSURE COLORCORR)`, where all lines of a key are multiplied.
    fn radiance_factors(&self, name: &str, notes: &mut Vec<String>) -> Result<Pixel, ImageError> {
        let [exposure] = self.product::<1>("EXPOSURE", notes);
        let colors = self.product::<3>("COLORCORR", notes);
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

    /// The primaries and the white of the last line; some programs write eight zeros for "unknown".
    fn tell_primaries(&self, head: &mut PictureHead) {
        let Some(value) = self.values("PRIMARIES").last() else { return };
        let numbers = numbers::<8>(value);
        let of = |numbers: [f32; 8]| {
            let [red, green, blue, white] = *numbers.map(f64::from).as_chunks().0 else { return None };
            Primaries::new(red, green, blue, white)
        };
        match numbers.and_then(of) {
            Some(primaries) => head.primaries = Some(("the PRIMARIES of the header", primaries)),
            None if numbers == Some([0.0; 8]) => {}
            None => head.unclear_primaries = Some(format!("PRIMARIES={value} of the header")),
        }
    }

    /// Adds remarks on lines that are ignored, one for each key.
    fn note_ignored(&self, notes: &mut Vec<String>) {
        let mut ignored: BTreeMap<&str, Lines<'_>> = BTreeMap::new();
        for (key, value) in &self.lines {
            let is_neutral = match key.as_str() {
                "PRIMARIES" => self.colors == Colors::Rgb,
                "GAMMA" | "PIXASPECT" => numbers(value) == Some([1.0]),
                "VIEW" => false,
                // A key in other letters is none to Radiance.
                other => KEYS.contains(&other) || !KEYS.iter().any(|key| key.eq_ignore_ascii_case(other)),
            };
            if !is_neutral {
                ignored.entry(key).or_default().add(value);
            }
        }
        notes.extend(ignored.iter().map(|(key, lines)| format!("{} of the header is ignored", lines.named(key))));
    }
}

/// Lines of one key, for a remark.
#[derive(Default)]
struct Lines<'a> {
    first: &'a str,
    count: usize,
}

impl<'a> Lines<'a> {
    fn add(&mut self, value: &'a str) {
        if self.count == 0 {
            self.first = value;
        }
        self.count += 1;
    }

    /// The line, or how many there are.
    fn named(&self, key: &str) -> String {
        if self.count == 1 { format!("{key}={}", quoted(self.first)) } else { format!("{key} ({} lines)", self.count) }
    }
}

/// The colors by the last line of `FORMAT`, as Radiance has it; RGB without one.
fn colors_of(lines: &[(String, String)], name: &str) -> Result<Colors, ImageError> {
    let format = lines.iter().rev().find(|(key, _)| key == "FORMAT");
    match format.map(|(_, value)| value.as_str()) {
        None | Some(RGBE) => Ok(Colors::Rgb),
        Some(XYZE) => Ok(Colors::Xyz),
        Some(found) => {
            let advice = if found == SPECTRA {
                "; convert it with rcomb -C RGB -fc IN.hsr > OUT.hdr of Radiance"
            } else if found.to_ascii_lowercase().contains("xyz") {
                "; convert it with ra_xyze -r IN.hdr OUT.hdr of Radiance"
            } else {
                ""
            };
            let message =
                format!("only pictures of FORMAT={RGBE} and {XYZE} are read, found FORMAT={}{advice}", quoted(found));
            Err(unsupported(name, message))
        }
    }
}

/// Scan lines and the texels of each, and how they lie, by a line as in `-Y 512 +X 1024`.
fn size_of(line: &str, name: &str) -> Result<([u64; 2], Orientation), ImageError> {
    let expected = || damaged(name, &format!("a size as in \"-Y 512 +X 1024\" expected, found {line:?}"));
    let [first, rows, second, columns, ..] = line.split_whitespace().collect::<Vec<_>>()[..] else {
        return Err(expected());
    };
    let orientation = Orientation::of_axes(first, second).ok_or_else(expected)?;
    let number = |text: &str, what: &str| {
        let message = || damaged(name, &format!("the number of {what} expected, found {text:?}"));
        text.parse::<u32>().map(u64::from).map_err(|_| message())
    };
    let [of_first, of_second] = if first.ends_with('Y') { ["rows", "columns"] } else { ["columns", "rows"] };
    Ok(([number(rows, of_first)?, number(columns, of_second)?], orientation))
}

/// The numbers of a value; none if it is anything but `N` numbers.
fn numbers<const N: usize>(value: &str) -> Option<[f32; N]> {
    let numbers: Option<Vec<f32>> = value.split_whitespace().map(|number| number.parse().ok()).collect();
    numbers?.try_into().ok()
}
