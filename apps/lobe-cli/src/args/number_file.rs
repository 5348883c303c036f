//! Coefficients of other libraries as files: `.npy`, JSON and text.

use std::fmt::Write as _;
use std::fs::File;
use std::io::Read as _;
use std::path::Path;

use anyhow::{anyhow, bail};
use lobe::io::IoError;
use lobe::sh::convention::{ArrayNumbers, CoefficientArray, Harmonics, NamedConvention};
use serde_json::Value;

use crate::args::npy::{MAGIC, npy_bytes, read_npy};
use crate::args::output::has_extension;

/// No array of order 256 needs more bytes, in any kind of file.
const MOST_BYTES: u64 = 64 << 20;

/// A kind of file to write.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Kind {
    Npy,
    Json,
    Text,
}

impl Kind {
    /// By the ending of a name.
    pub(crate) fn of(path: &Path) -> anyhow::Result<Self> {
        if path.to_string_lossy().to_ascii_lowercase().ends_with(".sh.json") {
            bail!("-o: {}: --to writes the numbers of a library; name it .npy, .json or .txt", path.display());
        }
        let kinds = [("npy", Self::Npy), ("json", Self::Json), ("txt", Self::Text)];
        let found = kinds.into_iter().find(|(ending, _)| has_extension(path, ending));
        found
            .map(|(_, kind)| kind)
            .ok_or_else(|| anyhow!("-o: expected a name that ends in .npy, .json or .txt, found {}", path.display()))
    }

    /// The bytes of a file.
    pub(crate) fn bytes(self, array: &CoefficientArray, convention: &NamedConvention) -> Vec<u8> {
        match self {
            Self::Npy => npy_bytes(array),
            Self::Json => json(array).into_bytes(),
            Self::Text => text(array, convention).into_bytes(),
        }
    }
}

/// The bytes of a file, or of stdin for `-`.
pub(crate) fn bytes_of(path: &Path, name: &str) -> anyhow::Result<Vec<u8>> {
    let bytes = if path == Path::new("-") {
        let mut bytes = Vec::new();
        let read = std::io::stdin().lock().take(MOST_BYTES + 1).read_to_end(&mut bytes);
        read.map_err(|source| IoError::Io { place: name.to_owned(), source })?;
        bytes
    } else {
        let of_place = |source| IoError::Io { place: name.to_owned(), source };
        let file = File::open(path).map_err(of_place)?;
        let mut bytes = Vec::new();
        file.take(MOST_BYTES + 1).read_to_end(&mut bytes).map_err(of_place)?;
        bytes
    };
    if bytes.len() as u64 > MOST_BYTES {
        bail!("{name}: no coefficients of order 256 or less take more than {MOST_BYTES} bytes");
    }
    Ok(bytes)
}

/// The array that a file holds, in the shape of the convention.
pub(crate) fn array_of(bytes: &[u8], convention: &NamedConvention) -> anyhow::Result<CoefficientArray> {
    if bytes.starts_with(MAGIC) {
        return read_npy(bytes);
    }
    let Ok(text) = str::from_utf8(bytes) else {
        bail!("expected a .npy, JSON or text with numbers, found other bytes")
    };
    let text = text.trim_start_matches('\u{feff}');
    match text.trim_start().chars().next() {
        None => bail!("expected numbers, found an empty file"),
        Some('[') => of_json(text, convention),
        Some('{') => {
            bail!("expected numbers or lists of them in JSON, found an object; an expansion of Lobe goes with --to")
        }
        Some(_) => of_text(text, convention),
    }
}

/// Nested lists; a complex number is a list of two.
fn of_json(text: &str, convention: &NamedConvention) -> anyhow::Result<CoefficientArray> {
    let value: Value = serde_json::from_str(text).map_err(|e| {
        let has_nan = text.contains("NaN") || text.contains("Infinity");
        anyhow!("not valid JSON: {e}{}", if has_nan { "; JSON has no NaN and no infinity" } else { "" })
    })?;
    let mut shape = Vec::new();
    let mut inner = &value;
    while let Value::Array(items) = inner {
        shape.push(items.len());
        match items.first() {
            Some(first) => inner = first,
            None => bail!("expected lists of numbers, found an empty one"),
        }
    }
    let mut numbers = Vec::new();
    flatten(&value, &shape, &mut numbers)?;
    let numbers = match convention.convention().harmonics {
        Harmonics::Real => ArrayNumbers::Real(numbers),
        Harmonics::Complex if shape.pop() == Some(2) => ArrayNumbers::Complex(numbers.as_chunks().0.to_vec()),
        Harmonics::Complex => bail!("numbers of {convention} are complex: each is a list [re, im]"),
    };
    Ok(CoefficientArray { shape, numbers })
}

fn flatten(value: &Value, shape: &[usize], out: &mut Vec<f64>) -> anyhow::Result<()> {
    match (value, shape) {
        (Value::Array(items), [length, inner @ ..]) if items.len() == *length => {
            items.iter().try_for_each(|item| flatten(item, inner, out))
        }
        (Value::Number(number), []) => {
            out.extend(number.as_f64());
            Ok(())
        }
        (Value::Array(_) | Value::Number(_), _) => bail!("lists of different lengths are no array"),
        (other, _) => bail!("expected numbers in lists, found {other}"),
    }
}

/// A number on each line; a complex one is `re im` or `re+imj`. Three parts of equal lengths with blank lines between
/// them are colors.
fn of_text(text: &str, convention: &NamedConvention) -> anyhow::Result<CoefficientArray> {
    let is_complex = convention.convention().harmonics == Harmonics::Complex;
    let mut parts = vec![Vec::new()];
    for (k, line) in text.lines().enumerate() {
        let (line, is_comment) = (line.split('#').next().unwrap_or_default().trim(), line.contains('#'));
        if line.is_empty() && is_comment {
            continue;
        }
        let numbers = parse_line(line, is_complex).map_err(|e| anyhow!("line {}: {e}", k + 1))?;
        match parts.last_mut() {
            Some(last) if !numbers.is_empty() => last.extend(numbers),
            Some(last) if last.is_empty() => {}
            _ => parts.push(Vec::new()),
        }
    }
    parts.retain(|part| !part.is_empty());
    let layout = convention.convention().layout;
    let order_of = |part: &Vec<[f64; 2]>| layout.order_of_count(part.len());
    let are_channels = parts.len() == 3 && parts.iter().all(|part| part.len() == parts[0].len());
    let (order, channels) = match parts.first().and_then(order_of).filter(|_| are_channels) {
        Some(order) => (Some(order), 3),
        None => (layout.order_of_count(parts.iter().map(Vec::len).sum()), 1),
    };
    let numbers = parts.concat();
    let Some(order) = order else {
        let of_one: Vec<usize> = (1..=4).map(|n| layout.shape(n).iter().product()).collect();
        let count = numbers.len();
        bail!(
            "{count} numbers are of no order: {convention} has {of_one:?}, .. for order 1, 2, 3, 4; colors are three \
             blocks with blank lines between them"
        );
    };
    let mut shape = layout.shape(order);
    if channels > 1 {
        shape.insert(0, channels);
    }
    let numbers = if is_complex {
        ArrayNumbers::Complex(numbers)
    } else {
        match numbers.iter().find(|[_, im]| *im != 0.0) {
            Some([re, im]) => bail!("numbers of {convention} are real, found {re}{im:+}j"),
            None => ArrayNumbers::Real(numbers.into_iter().map(|[re, _]| re).collect()),
        }
    };
    Ok(CoefficientArray { shape, numbers })
}

fn parse_line(line: &str, is_complex: bool) -> anyhow::Result<Vec<[f64; 2]>> {
    let words: Vec<&str> = line.split([' ', '\t', ',']).filter(|word| !word.is_empty()).collect();
    match words[..] {
        [re, im] if is_complex && !line.contains('j') => Ok(vec![[number(re)?, number(im)?]]),
        [_, _, _, ..] if is_complex && !words.iter().all(|word| word.contains('j')) => {
            bail!("expected one complex number, re im or re+imj, found {} numbers on a line", words.len())
        }
        _ => words.into_iter().map(parse_complex).collect(),
    }
}

/// `1.5`, or a complex number as Python prints it: `(1.5-2j)`, `1.5+-2j`, `2j`.
fn parse_complex(word: &str) -> anyhow::Result<[f64; 2]> {
    let bare = word.trim_start_matches('(').trim_end_matches(')');
    let Some(parts) = bare.strip_suffix('j') else { return Ok([number(bare)?, 0.0]) };
    let bytes = parts.as_bytes();
    let is_sign = |k: usize| matches!(bytes[k], b'+' | b'-');
    // The sign between the parts: neither the first one nor that of an exponent.
    let middle = (1..bytes.len()).rev().find(|&k| is_sign(k) && !matches!(bytes[k - 1], b'e' | b'E' | b'+' | b'-'));
    match middle {
        Some(k) => Ok([number(&parts[..k])?, number(parts[k..].trim_start_matches('+'))?]),
        None => Ok([0.0, number(parts)?]),
    }
}

fn number(word: &str) -> anyhow::Result<f64> {
    match word.parse::<f64>() {
        Ok(x) if x.is_finite() => Ok(x),
        _ => bail!("expected a finite number, found {word:?}"),
    }
}

/// Nested lists on one line.
fn json(array: &CoefficientArray) -> String {
    fn put(out: &mut String, shape: &[usize], numbers: &[f64]) {
        let Some((&length, inner)) = shape.split_first() else {
            out.push_str(&Value::from(numbers[0]).to_string());
            return;
        };
        out.push('[');
        for (k, part) in numbers.chunks(numbers.len() / length).enumerate() {
            out.push_str(if k > 0 { "," } else { "" });
            put(out, inner, part);
        }
        out.push(']');
    }
    let mut out = String::new();
    match &array.numbers {
        ArrayNumbers::Real(numbers) => put(&mut out, &array.shape, numbers),
        ArrayNumbers::Complex(numbers) => put(&mut out, &[&array.shape[..], &[2]].concat(), numbers.as_flattened()),
    }
    out.push('\n');
    out
}

/// A number on each line, and a blank line between channels.
pub(crate) fn text(array: &CoefficientArray, convention: &NamedConvention) -> String {
    let count = array.numbers.len();
    let channels = convention.convention().channels_and_order(&array.shape, "").map_or(1, |(channels, _)| channels);
    let channel = count / channels;
    let mut out = String::new();
    for i in 0..count {
        if i > 0 && i % channel == 0 {
            out.push('\n');
        }
        let [re, im] = array.numbers.complex(i);
        let _ = match &array.numbers {
            ArrayNumbers::Real(_) => writeln!(out, "{re:?}"),
            ArrayNumbers::Complex(_) => writeln!(out, "{re:?} {im:?}"),
        };
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use lobe::sh::{Rgb, ShVec};

    fn find(name: &str) -> &'static NamedConvention {
        NamedConvention::find(name).unwrap()
    }

    #[test]
    fn every_kind_of_file_is_read_back() {
        let gray = ShVec::from_vec((0..9).map(|k| 0.37 * f64::from(k) - 1.0).collect()).unwrap();
        let colors = gray.map(|c| Rgb::new(c, -c, 0.5 * c));
        for named in NamedConvention::ALL {
            let convention = named.convention();
            for array in [convention.encode(&gray).unwrap(), convention.encode(&colors).unwrap()] {
                for kind in [Kind::Npy, Kind::Json, Kind::Text] {
                    let found = array_of(&kind.bytes(&array, named), named).unwrap();
                    assert_eq!(found, array, "{named}, {kind:?}");
                }
            }
        }
    }

    #[test]
    fn complex_numbers_are_read_as_python_and_numpy_print_them() {
        for (word, expected) in [
            ("(1.5-2j)", [1.5, -2.0]),
            ("1.5+-2.0j", [1.5, -2.0]),
            ("(-1e-05+2e+03j)", [-1e-5, 2e3]),
            ("-2j", [0.0, -2.0]),
            ("3", [3.0, 0.0]),
        ] {
            assert_eq!(parse_complex(word).unwrap(), expected, "{word}");
        }
        for bad in ["j", "1+j2", "nan", "1+nanj", ""] {
            assert!(parse_complex(bad).is_err(), "{bad:?}");
        }
        let found = array_of(b"# alm\n1 0\n2 0 # two\n3,4\n", find("healpy")).unwrap();
        assert_eq!(found.numbers, ArrayNumbers::Complex(vec![[1.0, 0.0], [2.0, 0.0], [3.0, 4.0]]), "pairs");
    }

    #[test]
    fn bad_numbers_are_refused_with_their_place() {
        for (name, bytes, said) in [
            ("ambix", &b""[..], "found an empty file"),
            ("ambix", b"\xff\xfe\x00", "found other bytes"),
            ("ambix", b"1\n2\nx\n4\n", "line 3: expected a finite number, found \"x\""),
            ("ambix", b"1\nnan\n", "line 2: expected a finite number"),
            ("ambix", b"1 2 3", "3 numbers are of no order: ambix has [1, 4, 9, 16], .. for"),
            ("ambix", b"1 2 3 1+2j", "numbers of ambix are real, found 1+2j"),
            ("ambix", b"[1, 2, 3, \"x\"]", "expected numbers in lists, found \"x\""),
            ("ambix", b"[1, 2, [3], 4]", "lists of different lengths"),
            ("ambix", b"[1, 2, NaN, 4]", "JSON has no NaN"),
            ("ambix", b"[]", "found an empty one"),
            ("ambix", b"{\"a\": 1}", "found an object; an expansion of Lobe goes with --to"),
            ("healpy", b"[1, 2, 3]", "numbers of healpy are complex: each is a list [re, im]"),
        ] {
            let found = array_of(bytes, find(name)).unwrap_err().to_string();
            assert!(found.contains(said), "{found}, expected {said}");
        }
    }
}
