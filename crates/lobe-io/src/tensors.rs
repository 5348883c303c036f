//! Safetensors files of Lobe: named tensors, written piece by piece, and one entry of metadata that describes them.
//!
//! Eight bytes of length, JSON padded with blanks to a multiple of eight, the numbers in little-endian order: that is the
//! whole format (<https://github.com/huggingface/safetensors>). The JSON maps each name to type, shape and place of a
//! tensor; its metadata has the one entry `lobe`, JSON again: `format`, `version`, and the members of the header.

use std::fmt::Display;
use std::io::{self, Write};
use std::path::Path;

use half::f16;
pub use safetensors::Dtype;
use safetensors::tensor::TensorView;
use safetensors::{SafeTensorError, SafeTensors};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};

use crate::error::IoError;
use crate::staged::write_atomically;

/// The one entry of the metadata. With more than one their order, and so the bytes, would change from run to run.
const ENTRY: &str = "lobe";

/// Numbers turned to bytes at once, 4 MiB of floats, or one row that is longer.
const AT_ONCE: usize = 1 << 20;

/// A kind of file, and the one version of it that is read and written.
#[derive(Clone, Copy, Debug)]
pub struct TensorFormat {
    /// The name of the kind.
    pub name: &'static str,
    /// The version.
    pub version: u32,
    /// What to do about a file of an older version.
    pub if_older: &'static str,
}

/// The members of the entry that are looked at first.
#[derive(Deserialize)]
struct Kind {
    format: String,
    version: u32,
}

/// All its members.
#[derive(Serialize)]
struct Entry<'a, H> {
    format: &'a str,
    version: u32,
    #[serde(flatten)]
    header: &'a H,
}

/// The numbers of a tensor that is written.
#[derive(Clone, Copy)]
#[non_exhaustive]
pub enum Numbers<'a> {
    /// Floats of 32 bits.
    F32(&'a [f32]),
    /// Floats of 16 bits.
    F16(&'a [f16]),
    /// Unsigned numbers of 16 bits.
    U16(&'a [u16]),
    /// Bytes.
    U8(&'a [u8]),
    /// Floats of 32 bits that need not be in memory: reads the rows from the first on, as many as fill the slice. The
    /// tensor's first length is that of its rows; an error ends the writing and leaves no file.
    Rows(&'a dyn Fn(usize, &mut [f32]) -> io::Result<()>),
}

/// A tensor that is written.
#[derive(Clone)]
pub struct Tensor<'a> {
    /// Its name.
    pub name: &'static str,
    /// The length of each of its dimensions, the slowest first.
    pub shape: Vec<usize>,
    /// As many numbers as the product of the lengths.
    pub numbers: Numbers<'a>,
}

impl<'a> Tensor<'a> {
    /// A tensor of these numbers.
    ///
    /// # Panics
    /// If there are not as many as the shape has.
    #[must_use]
    pub fn new(name: &'static str, shape: impl Into<Vec<usize>>, numbers: Numbers<'a>) -> Self {
        let tensor = Self { name, shape: shape.into(), numbers };
        let has = match numbers {
            Numbers::F32(x) => x.len(),
            Numbers::F16(x) => x.len(),
            Numbers::U16(x) => x.len(),
            Numbers::U8(x) => x.len(),
            Numbers::Rows(_) => tensor.len(),
        };
        assert_eq!(has, tensor.len(), "the numbers of the tensor {name}, of shape {:?}", tensor.shape);
        tensor
    }

    fn len(&self) -> usize {
        self.shape.iter().product()
    }

    /// The name of the numbers' type, and the size of one.
    fn kind(&self) -> (&'static str, usize) {
        match self.numbers {
            Numbers::F32(_) | Numbers::Rows(_) => ("F32", size_of::<f32>()),
            Numbers::F16(_) => ("F16", size_of::<f16>()),
            Numbers::U16(_) => ("U16", size_of::<u16>()),
            Numbers::U8(_) => ("U8", size_of::<u8>()),
        }
    }

    fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        match self.numbers {
            Numbers::F32(x) => write_all(x, f32::to_le_bytes, out),
            Numbers::F16(x) => write_all(x, f16::to_le_bytes, out),
            Numbers::U16(x) => write_all(x, u16::to_le_bytes, out),
            Numbers::U8(x) => out.write_all(x),
            Numbers::Rows(read) => self.write_rows(read, out),
        }
    }

    fn write_rows(&self, read: &dyn Fn(usize, &mut [f32]) -> io::Result<()>, out: &mut dyn Write) -> io::Result<()> {
        let (rows, row) = (self.shape[0], self.shape[1..].iter().product::<usize>());
        let at_once = AT_ONCE.checked_div(row).unwrap_or(rows).clamp(1, rows.max(1));
        let mut numbers = vec![0.0; row * at_once];
        for first in (0..rows).step_by(at_once) {
            let numbers = &mut numbers[..row * at_once.min(rows - first)];
            read(first, numbers)?;
            write_all(numbers, f32::to_le_bytes, out)?;
        }
        Ok(())
    }
}

fn write_all<T: Copy, const N: usize>(
    numbers: &[T],
    bytes_of: impl Fn(T) -> [u8; N],
    out: &mut dyn Write,
) -> io::Result<()> {
    let mut bytes = Vec::with_capacity(N * numbers.len().min(AT_ONCE));
    for some in numbers.chunks(AT_ONCE) {
        bytes.clear();
        bytes.extend(some.iter().flat_map(|x| bytes_of(*x)));
        out.write_all(&bytes)?;
    }
    Ok(())
}

/// Writes a file; until all is written, nothing has its name. Tensors of larger numbers come first, so that each begins at a
/// multiple of the size of its numbers; those of one size keep their order. None of them is copied as a whole.
///
/// # Errors
/// [`IoError::Io`] if it cannot be written, or rows cannot be read; [`IoError::Invalid`] if the header is none that JSON can
/// hold.
pub fn write_tensors(
    path: &Path,
    format: TensorFormat,
    header: &impl Serialize,
    tensors: &[Tensor<'_>],
) -> Result<(), IoError> {
    let entry = Entry { format: format.name, version: format.version, header };
    let entry = serde_json::to_string(&entry).map_err(|e| IoError::invalid(path, e.to_string()))?;
    let mut tensors: Vec<&Tensor<'_>> = tensors.iter().collect();
    tensors.sort_by_key(|tensor| std::cmp::Reverse(tensor.kind().1));
    let json = padded_json(&entry, &tensors);
    let written = write_atomically(path, |out| {
        out.write_all(&(json.len() as u64).to_le_bytes())?;
        out.write_all(&json)?;
        tensors.iter().try_for_each(|tensor| tensor.write(out))
    });
    written.map_err(|source| IoError::io(path, source))
}

fn padded_json(entry: &str, tensors: &[&Tensor<'_>]) -> Vec<u8> {
    let mut members = Map::from_iter([("__metadata__".to_owned(), json!({ENTRY: entry}))]);
    let mut end = 0;
    for tensor in tensors {
        let (dtype, size) = tensor.kind();
        let offsets = [end, end + size * tensor.len()];
        members.insert(tensor.name.to_owned(), json!({"dtype": dtype, "shape": tensor.shape, "data_offsets": offsets}));
        end = offsets[1];
    }
    let mut json = Value::Object(members).to_string().into_bytes();
    json.resize(json.len().next_multiple_of(8), b' ');
    json
}

/// A file of tensors that has been read, its kind and version known.
#[derive(Debug)]
pub struct TensorFile<'a> {
    name: &'a str,
    format: &'static str,
    entry: String,
    tensors: SafeTensors<'a>,
}

impl<'a> TensorFile<'a> {
    /// The file with these bytes, which must be of one of the formats; its name stands in messages. Nothing is allocated
    /// that is larger than the bytes.
    ///
    /// # Errors
    /// [`IoError::Invalid`] if these are no safetensors or of none of the formats; [`IoError::Unsupported`] if they are of
    /// another version.
    pub fn parse(bytes: &'a [u8], name: &'a str, formats: &[TensorFormat]) -> Result<Self, IoError> {
        let expected = formats.first().map_or("nothing", |format| format.name);
        let broken = |e: SafeTensorError| invalid(name, format!("expected safetensors, found {e}"));
        let (_, metadata) = SafeTensors::read_metadata(bytes).map_err(broken)?;
        let Some(entry) = metadata.metadata().as_ref().and_then(|m| m.get(ENTRY)) else {
            return Err(invalid(name, format!("expected tensors of {expected}, found none of Lobe's")));
        };
        let kind: Kind = serde_json::from_str(entry).map_err(|e| bad_entry(name, e))?;
        let Some(format) = formats.iter().find(|format| format.name == kind.format) else {
            return Err(invalid(name, format!("expected {expected}, found {}", kind.format)));
        };
        check_version(name, format, kind.version)?;
        let tensors = SafeTensors::deserialize(bytes).map_err(broken)?;
        Ok(Self { name, format: format.name, entry: entry.clone(), tensors })
    }

    /// The name of the file.
    #[must_use]
    pub fn name(&self) -> &'a str {
        self.name
    }

    /// Which of the formats it is of.
    #[must_use]
    pub fn format(&self) -> &'static str {
        self.format
    }

    /// The members of its header.
    ///
    /// # Errors
    /// [`IoError::Invalid`] if they are others.
    pub fn header<H: DeserializeOwned>(&self) -> Result<H, IoError> {
        serde_json::from_str(&self.entry).map_err(|e| bad_entry(self.name, e))
    }

    /// A fault of this file.
    #[must_use]
    pub fn invalid(&self, message: impl Into<String>) -> IoError {
        invalid(self.name, message)
    }

    /// Whether it has a tensor of this name.
    #[must_use]
    pub fn has(&self, name: &str) -> bool {
        self.tensors.tensor(name).is_ok()
    }

    /// The type and the shape of a tensor.
    ///
    /// # Errors
    /// [`IoError::Invalid`] if there is none of this name.
    pub fn view(&self, name: &str) -> Result<(Dtype, Vec<usize>), IoError> {
        let view = self.tensor(name)?;
        Ok((view.dtype(), view.shape().to_vec()))
    }

    fn tensor(&self, name: &str) -> Result<TensorView<'a>, IoError> {
        self.tensors.tensor(name).map_err(|_| self.invalid(format!("expected a tensor {name}, found none")))
    }

    /// The bytes of a tensor of this type and shape, of which `None` is any length.
    ///
    /// # Errors
    /// [`IoError::Invalid`] if there is no such tensor.
    pub fn bytes(&self, name: &str, dtype: Dtype, shape: &[Option<usize>]) -> Result<&'a [u8], IoError> {
        let view = self.tensor(name)?;
        let (found, lengths) = (view.dtype(), view.shape());
        let fits = lengths.len() == shape.len() && lengths.iter().zip(shape).all(|(a, b)| b.is_none_or(|b| b == *a));
        if !fits {
            let shape: Vec<String> = shape.iter().map(|n| n.map_or("any".to_owned(), |n| n.to_string())).collect();
            let shape = shape.join(", ");
            return Err(self.invalid(format!("expected a tensor {name} of shape [{shape}], found {lengths:?}")));
        }
        if found == dtype {
            return Ok(view.data());
        }
        Err(self.invalid(format!("expected a tensor {name} of {dtype:?}, found {found:?}")))
    }

    /// The numbers of a tensor of floats.
    ///
    /// # Errors
    /// As [`TensorFile::bytes`].
    pub fn f32(&self, name: &str, shape: &[Option<usize>]) -> Result<Vec<f32>, IoError> {
        Ok(self.bytes(name, Dtype::F32, shape)?.as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)).collect())
    }

    /// The numbers of a tensor of floats of 16 bits.
    ///
    /// # Errors
    /// As [`TensorFile::bytes`].
    pub fn f16(&self, name: &str, shape: &[Option<usize>]) -> Result<Vec<f16>, IoError> {
        Ok(self.bytes(name, Dtype::F16, shape)?.as_chunks().0.iter().map(|b| f16::from_le_bytes(*b)).collect())
    }

    /// The numbers of a tensor of unsigned numbers of 16 bits.
    ///
    /// # Errors
    /// As [`TensorFile::bytes`].
    pub fn u16(&self, name: &str, shape: &[Option<usize>]) -> Result<Vec<u16>, IoError> {
        Ok(self.bytes(name, Dtype::U16, shape)?.as_chunks().0.iter().map(|b| u16::from_le_bytes(*b)).collect())
    }
}

fn check_version(name: &str, format: &TensorFormat, found: u32) -> Result<(), IoError> {
    let TensorFormat { name: kind, version, if_older } = *format;
    if found == version {
        return Ok(());
    }
    let advice = if found < version { if_older } else { "take a Lobe as new as the file" };
    let message = format!("expected version {version} of {kind}, found {found}; {advice}");
    Err(IoError::Unsupported { place: name.to_owned(), message })
}

fn bad_entry(name: &str, error: impl Display) -> IoError {
    invalid(name, format!("the entry {ENTRY} of its metadata is wrong: {error}"))
}

/// A fault of a file in one line: messages may quote it.
fn invalid(name: &str, message: impl Into<String>) -> IoError {
    IoError::Invalid { place: name.to_owned(), message: message.into().replace(['\n', '\r'], " ") }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    const FORMAT: TensorFormat = TensorFormat { name: "lobe-test", version: 2, if_older: "make it anew" };

    #[derive(Debug, PartialEq, Serialize, Deserialize)]
    struct Header {
        order: usize,
    }

    /// The bytes of a file of one tensor of each kind, and of one of more rows than are written at once.
    fn file() -> Vec<u8> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.safetensors");
        let read = |first: usize, numbers: &mut [f32]| {
            numbers.iter_mut().zip(2 * first..).for_each(|(x, k)| *x = k as f32);
            Ok(())
        };
        let halves: Vec<f16> = [0.5, -1.0, 2.0].map(f16::from_f32).to_vec();
        let tensors = [
            Tensor::new("bytes", [3], Numbers::U8(&[1, 2, 3])),
            Tensor::new("halves", [3], Numbers::F16(&halves)),
            Tensor::new("shorts", [1, 2], Numbers::U16(&[7, 65535])),
            Tensor::new("rows", [AT_ONCE, 2], Numbers::Rows(&read)),
            Tensor::new("none", [0, 4], Numbers::F32(&[])),
        ];
        write_tensors(&path, FORMAT, &Header { order: 3 }, &tensors).unwrap();
        fs::read(path).unwrap()
    }

    #[test]
    fn every_kind_of_numbers_comes_back_and_lies_at_a_multiple_of_its_size() {
        let bytes = file();
        let file = TensorFile::parse(&bytes, "t", &[FORMAT]).unwrap();
        assert_eq!((file.format(), file.header::<Header>().unwrap()), ("lobe-test", Header { order: 3 }), "header");
        assert_eq!(file.bytes("bytes", Dtype::U8, &[None]).unwrap(), [1, 2, 3], "bytes");
        assert_eq!(file.f16("halves", &[Some(3)]).unwrap().iter().map(|x| x.to_f32()).sum::<f32>(), 1.5, "halves");
        assert_eq!(file.u16("shorts", &[None, Some(2)]).unwrap(), [7, 65535], "shorts");
        let rows = file.f32("rows", &[None, Some(2)]).unwrap();
        assert!(rows.iter().enumerate().all(|(k, x)| *x == k as f32), "rows, read in pieces");
        assert_eq!(rows.len(), 2 * AT_ONCE, "rows");
        assert!(file.f32("none", &[None, Some(4)]).unwrap().is_empty(), "a tensor without numbers");
        for (name, size) in [("rows", 4), ("halves", 2), ("shorts", 2)] {
            let begin = file.tensors.tensor(name).unwrap().data().as_ptr().addr() - bytes.as_ptr().addr();
            assert_eq!(begin % size, 0, "where {name} begins");
        }
    }

    #[test]
    fn other_files_versions_types_and_shapes_are_refused_in_one_line() {
        let bytes = file();
        let message = |format: TensorFormat| TensorFile::parse(&bytes, "t", &[format]).unwrap_err().to_string();
        let other = TensorFormat { name: "lobe-other", ..FORMAT };
        assert_eq!(message(other), "t: expected lobe-other, found lobe-test", "another format");
        let later = TensorFormat { version: 3, ..FORMAT };
        assert_eq!(message(later), "t: expected version 3 of lobe-test, found 2; make it anew", "an older file");
        let earlier = TensorFormat { version: 1, ..FORMAT };
        let expected = "t: expected version 1 of lobe-test, found 2; take a Lobe as new as the file";
        assert_eq!(message(earlier), expected, "a newer file");
        let file = TensorFile::parse(&bytes, "t", &[FORMAT]).unwrap();
        for (refused, expected) in [
            (file.f32("shorts", &[None, None]), "t: expected a tensor shorts of F32, found U16"),
            (file.f32("rows", &[None, Some(3)]), "t: expected a tensor rows of shape [any, 3], found [1048576, 2]"),
            (file.f32("more", &[None]), "t: expected a tensor more, found none"),
        ] {
            assert_eq!(refused.unwrap_err().to_string(), expected, "{expected}");
        }
        for length in [0, 7, 8, 20, bytes.len() - 1] {
            let error = TensorFile::parse(&bytes[..length], "t", &[FORMAT]).unwrap_err().to_string();
            assert!(error.starts_with("t: expected ") && !error.contains('\n'), "cut off after {length}: {error}");
        }
    }

    #[test]
    fn rows_that_cannot_be_read_leave_no_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.safetensors");
        let read = |_: usize, _: &mut [f32]| Err(io::Error::other("gone"));
        let tensor = Tensor::new("rows", [4, 2], Numbers::Rows(&read));
        let error = write_tensors(&path, FORMAT, &Header { order: 3 }, &[tensor]).unwrap_err().to_string();
        assert!(error.ends_with(": gone"), "{error}");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "files");
    }
}
