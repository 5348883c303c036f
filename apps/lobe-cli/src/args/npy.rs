//! Arrays of numpy as files: `.npy`.
//!
//! ```text
//!   \x93NUMPY, version (2 bytes), length of the header (2 bytes, from version 2 on 4), header, numbers
//!   {'descr': '<f8', 'fortran_order': False, 'shape': (2, 4, 4), }
//! ```
//!
//! The header is padded by blanks and ends a multiple of 64 bytes after the beginning. Source: the documentation of
//! `numpy.lib.format`.

use anyhow::{Context as _, bail, ensure};
use lobe::sh::convention::{ArrayNumbers, CoefficientArray};

/// The first bytes.
pub(crate) const MAGIC: &[u8] = b"\x93NUMPY";

/// Numbers begin at a multiple of so many bytes.
const ALIGNMENT: usize = 64;

/// What an item is.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Item {
    is_complex: bool,
    is_double: bool,
    is_big_endian: bool,
}

impl Item {
    const fn bytes(self) -> usize {
        (if self.is_double { 8 } else { 4 }) << (self.is_complex as usize)
    }

    /// The type that the text of `descr` says.
    fn of(descr: &str) -> anyhow::Result<Self> {
        let Some(text) = descr.strip_prefix('\'').and_then(|rest| rest.split('\'').next()) else {
            bail!("records with fields are not read; save one field, of numbers");
        };
        let (order, kind) = text.split_at_checked(1).unwrap_or_default();
        let (is_complex, is_double) = match kind {
            "f4" => (false, false),
            "f8" => (false, true),
            "c8" => (true, false),
            "c16" => (true, true),
            _ if kind.starts_with('O') => bail!("objects are not read, only numbers; save array.astype(float)"),
            _ => bail!("numbers of type {text:?} are not read; save array.astype(float), or complex"),
        };
        Ok(Self { is_complex, is_double, is_big_endian: order == ">" })
    }

    /// The real and the imaginary part of the item that these bytes are.
    fn read(self, bytes: &[u8]) -> [f64; 2] {
        let mut parts = [0.0; 2];
        let size = if self.is_double { 8 } else { 4 };
        for (part, bytes) in parts.iter_mut().zip(bytes.chunks_exact(size)) {
            *part = match (<[u8; 8]>::try_from(bytes), <[u8; 4]>::try_from(bytes)) {
                (Ok(b), _) if self.is_big_endian => f64::from_be_bytes(b),
                (Ok(b), _) => f64::from_le_bytes(b),
                (_, Ok(b)) if self.is_big_endian => f32::from_be_bytes(b).into(),
                (_, Ok(b)) => f32::from_le_bytes(b).into(),
                _ => unreachable!("chunks have this size"),
            };
        }
        parts
    }
}

/// What stands behind a key of the header.
fn field<'a>(header: &'a str, key: &str) -> anyhow::Result<&'a str> {
    let quoted = format!("'{key}':");
    let at = header.find(&quoted).with_context(|| format!("the header has no {key}"))?;
    Ok(header[at + quoted.len()..].trim_start())
}

/// The lengths in `(2, 3, 3)`.
fn shape_of(text: &str) -> anyhow::Result<Vec<usize>> {
    let inside = text.strip_prefix('(').and_then(|rest| rest.split_once(')')).map(|(inside, _)| inside);
    let lengths = inside.map(|inside| {
        let words = inside.split(',').map(str::trim).filter(|word| !word.is_empty());
        words.map(str::parse).collect::<Result<Vec<usize>, _>>()
    });
    match lengths {
        Some(Ok(shape)) => Ok(shape),
        _ => bail!("the header has no shape such as (2, 4, 4)"),
    }
}

/// Splits the header off.
fn split(bytes: &[u8]) -> anyhow::Result<(&str, &[u8])> {
    const CUT: &str = "the file is cut off in its header";
    let version = *bytes.get(MAGIC.len()).context(CUT)?;
    ensure!((1..=3).contains(&version), "version {version} of .npy is not read; numpy.save writes version 1");
    let (start, length) = if version == 1 { (10, bytes.get(8..10)) } else { (12, bytes.get(8..12)) };
    let length = length.context(CUT)?.iter().rev().fold(0_usize, |all, byte| all << 8 | usize::from(*byte));
    let header = bytes.get(start..).and_then(|rest| rest.get(..length)).context(CUT)?;
    Ok((str::from_utf8(header).context("the header is no text")?, &bytes[start + length..]))
}

/// The array of a file.
///
/// # Errors
/// If the file is cut off or longer than its shape says, or holds other things than real or complex numbers of 4 or 8
/// bytes.
pub(crate) fn read_npy(bytes: &[u8]) -> anyhow::Result<CoefficientArray> {
    let (header, data) = split(bytes)?;
    let item = Item::of(field(header, "descr")?)?;
    let is_fortran = field(header, "fortran_order")?.starts_with("True");
    let shape = shape_of(field(header, "shape")?)?;
    let count = shape.iter().try_fold(1_usize, |all, length| all.checked_mul(*length));
    let expected = count.and_then(|count| count.checked_mul(item.bytes()));
    let Some((count, expected)) = count.zip(expected) else { bail!("no memory holds an array of shape {shape:?}") };
    if data.len() != expected {
        let why = if data.len() < expected { "the file is cut off" } else { "more bytes than the shape has" };
        bail!("{why}: expected {expected} bytes of numbers for shape {shape:?}, found {}", data.len());
    }
    let mut numbers: Vec<[f64; 2]> = data.chunks_exact(item.bytes()).map(|bytes| item.read(bytes)).collect();
    if is_fortran {
        numbers = (0..count).map(|i| numbers[fortran_place(i, &shape)]).collect();
    }
    let numbers = if item.is_complex {
        ArrayNumbers::Complex(numbers)
    } else {
        ArrayNumbers::Real(numbers.into_iter().map(|[re, _]| re).collect())
    };
    Ok(CoefficientArray { shape, numbers })
}

/// Where number `i` in C order, the last axis fastest, stands in Fortran's, the first fastest.
fn fortran_place(mut i: usize, shape: &[usize]) -> usize {
    let mut index = vec![0; shape.len()];
    for (index, length) in index.iter_mut().zip(shape).rev() {
        (*index, i) = (i % length, i / length);
    }
    index.iter().zip(shape).rev().fold(0, |place, (index, length)| place * length + index)
}

/// The bytes of a file of version 1: `<f8` or `<c16`, in C order.
pub(crate) fn npy_bytes(array: &CoefficientArray) -> Vec<u8> {
    let descr = if matches!(array.numbers, ArrayNumbers::Complex(_)) { "<c16" } else { "<f8" };
    let lengths: String = array.shape.iter().map(|length| format!("{length}, ")).collect();
    // A tuple of one has its comma, others none at the end.
    let lengths = if array.shape.len() == 1 { lengths.trim_end() } else { lengths.trim_end_matches(", ") };
    let mut header = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': ({lengths}), }}");
    let before = MAGIC.len() + 4;
    while !(before + header.len() + 1).is_multiple_of(ALIGNMENT) {
        header.push(' ');
    }
    header.push('\n');
    let mut bytes = MAGIC.to_vec();
    bytes.extend([1, 0]);
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    let mut put = |number: f64| bytes.extend(number.to_le_bytes());
    match &array.numbers {
        ArrayNumbers::Real(numbers) => numbers.iter().for_each(|number| put(*number)),
        ArrayNumbers::Complex(numbers) => numbers.as_flattened().iter().for_each(|number| put(*number)),
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(header: &str, data: &[u8]) -> Vec<u8> {
        let mut bytes = MAGIC.to_vec();
        bytes.extend([1, 0]);
        bytes.extend((header.len() as u16).to_le_bytes());
        bytes.extend(header.as_bytes());
        bytes.extend(data);
        bytes
    }

    fn of(descr: &str, fortran: &str, shape: &str) -> String {
        format!("{{'descr': {descr}, 'fortran_order': {fortran}, 'shape': {shape}, }}\n")
    }

    #[test]
    fn what_is_written_is_read_back() {
        let real = ArrayNumbers::Real((0..18).map(|k| 0.1 * f64::from(k)).collect());
        let complex = ArrayNumbers::Complex((0..6).map(|k| [f64::from(k), -0.5 * f64::from(k)]).collect());
        for (shape, numbers) in [(vec![2, 3, 3], real), (vec![6], complex)] {
            let array = CoefficientArray { shape, numbers };
            let bytes = npy_bytes(&array);
            assert_eq!(read_npy(&bytes).unwrap(), array, "{array:?}");
            let item = if matches!(array.numbers, ArrayNumbers::Complex(_)) { 16 } else { 8 };
            assert_eq!((bytes.len() - item * array.numbers.len()) % ALIGNMENT, 0, "numbers are aligned");
        }
    }

    #[test]
    fn either_order_of_bytes_and_of_axes_is_read() {
        let columns: Vec<u8> = [1.0_f32, 3.0, 2.0, 4.0].iter().flat_map(|x| x.to_be_bytes()).collect();
        let found = read_npy(&file(&of("'>f4'", "True", "(2, 2)"), &columns)).unwrap();
        assert_eq!(found.numbers, ArrayNumbers::Real(vec![1.0, 2.0, 3.0, 4.0]), "columns, most significant first");
        let pair: Vec<u8> = [1.5_f32, -2.5].iter().flat_map(|x| x.to_le_bytes()).collect();
        let found = read_npy(&file(&of("'<c8'", "False", "(1,)"), &pair)).unwrap();
        assert_eq!(found.numbers, ArrayNumbers::Complex(vec![[1.5, -2.5]]), "single complex");
        let places: Vec<usize> = (0..6).map(|i| fortran_place(i, &[2, 3])).collect();
        assert_eq!(places, [0, 2, 4, 1, 3, 5], "two rows of three");
    }

    #[test]
    fn what_is_no_array_of_numbers_is_refused() {
        let whole = file(&of("'<f8'", "False", "(4,)"), &[0; 32]);
        for (bytes, said) in [
            (whole[..40].to_vec(), "cut off in its header"),
            (whole[..whole.len() - 1].to_vec(), "the file is cut off: expected 32 bytes"),
            ([&whole[..], &[0]].concat(), "more bytes than the shape has"),
            (whole[..7].to_vec(), "cut off"),
            (file(&of("'|O'", "False", "(4,)"), &[0; 32]), "objects are not read"),
            (file(&of("'<i8'", "False", "(4,)"), &[0; 32]), "\"<i8\" are not read; save array.astype(float)"),
            (file(&of("[('a', '<f8')]", "False", "(4,)"), &[0; 32]), "records with fields"),
            (file(&of("''", "False", "(4,)"), &[0; 32]), "are not read"),
            (file(&of("'<f8'", "False", "(x,)"), &[0; 32]), "no shape"),
            (file(&of("'<f8'", "False", "(99999999999, 99999999999)"), &[]), "no memory"),
            (file("{'descr': '<f8'}", &[]), "no fortran_order"),
            ([MAGIC, &[9, 0, 0, 0]].concat(), "version 9"),
        ] {
            let found = read_npy(&bytes).unwrap_err().to_string();
            assert!(found.contains(said), "{found}, expected {said}");
        }
    }
}
