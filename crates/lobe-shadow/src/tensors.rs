//! Safetensors files of fields: named tensors, written piece by piece, and one entry of metadata that describes them.

use std::io::{self, Write};
use std::path::Path;

use lobe_io::write_atomically;
use safetensors::{Dtype, SafeTensorError, SafeTensors};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::{Map, json};

use crate::ShadowError;

/// The one entry of the metadata. With more than one their order, and so the bytes, would change from run to run.
const ENTRY: &str = "lobe";

/// Numbers turned to bytes at once.
const AT_ONCE: usize = 1 << 16;

/// What describes the tensors of a format.
pub(crate) trait Header: Serialize + DeserializeOwned {
    const FORMAT: &'static str;
    const VERSION: u32;
    /// What to do about a file of an older version.
    const IF_OLDER: &'static str = "make the file anew";
}

/// The members that are looked at first.
#[derive(Deserialize)]
struct Kind {
    format: String,
    version: u32,
}

/// All members.
#[derive(Serialize)]
struct Entry<'a, H> {
    format: &'a str,
    version: u32,
    #[serde(flatten)]
    header: &'a H,
}

/// The numbers of a tensor.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Numbers<'a> {
    F32(&'a [f32]),
    F16(&'a [half::f16]),
    U16(&'a [u16]),
    U8(&'a [u8]),
}

impl Numbers<'_> {
    fn name_and_bytes(self) -> (&'static str, usize) {
        match self {
            Self::F32(x) => ("F32", size_of_val(x)),
            Self::F16(x) => ("F16", size_of_val(x)),
            Self::U16(x) => ("U16", size_of_val(x)),
            Self::U8(x) => ("U8", size_of_val(x)),
        }
    }

    fn write(self, out: &mut dyn Write) -> io::Result<()> {
        match self {
            Self::F32(x) => write_all(x, f32::to_le_bytes, out),
            Self::F16(x) => write_all(x, half::f16::to_le_bytes, out),
            Self::U16(x) => write_all(x, u16::to_le_bytes, out),
            Self::U8(x) => out.write_all(x),
        }
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

/// A tensor to write.
#[derive(Clone, Debug)]
pub(crate) struct Tensor<'a> {
    pub(crate) name: &'static str,
    pub(crate) shape: Vec<usize>,
    pub(crate) numbers: Numbers<'a>,
}

/// Writes a file; nothing half-written ever has its name. Tensors of larger numbers come first, so that each begins at a
/// multiple of the size of its numbers. None of them is copied.
///
/// # Errors
/// [`ShadowError::Io`] if it cannot be written.
pub(crate) fn write<H: Header>(path: &Path, header: &H, tensors: &[Tensor<'_>]) -> Result<(), ShadowError> {
    let place = path.display().to_string();
    let entry = Entry { format: H::FORMAT, version: H::VERSION, header };
    let entry = serde_json::to_string(&entry).map_err(|e| invalid(&place, &e.to_string()))?;
    // Eight bytes of length, JSON padded with blanks to a multiple of eight, the numbers: that is the whole format.
    let mut json = Map::from_iter([("__metadata__".to_owned(), json!({ENTRY: entry}))]);
    let mut end = 0;
    for tensor in tensors {
        let (dtype, bytes) = tensor.numbers.name_and_bytes();
        let offsets = [end, end + bytes];
        json.insert(tensor.name.to_owned(), json!({"dtype": dtype, "shape": tensor.shape, "data_offsets": offsets}));
        end += bytes;
    }
    let mut json = serde_json::Value::Object(json).to_string().into_bytes();
    json.resize(json.len().next_multiple_of(8), b' ');
    let written = write_atomically(path, |out| {
        out.write_all(&(json.len() as u64).to_le_bytes())?;
        out.write_all(&json)?;
        tensors.iter().try_for_each(|tensor| tensor.numbers.write(out))
    });
    written.map_err(|source| ShadowError::Io { place, source })
}

/// A file that has been read, its header understood.
pub(crate) struct TensorFile<'a, H> {
    name: &'a str,
    pub(crate) header: H,
    tensors: SafeTensors<'a>,
}

impl<'a, H: Header> TensorFile<'a, H> {
    /// # Errors
    /// [`ShadowError::Invalid`] if these are no safetensors, or of another format or version.
    pub(crate) fn parse(bytes: &'a [u8], name: &'a str) -> Result<Self, ShadowError> {
        let broken = |e: SafeTensorError| invalid(name, &format!("expected safetensors, found {e}"));
        let (_, metadata) = SafeTensors::read_metadata(bytes).map_err(broken)?;
        let Some(entry) = metadata.metadata().as_ref().and_then(|m| m.get(ENTRY)) else {
            return Err(invalid(name, &format!("expected tensors of {}, found none of Lobe's", H::FORMAT)));
        };
        let bad = |e: serde_json::Error| invalid(name, &format!("the entry {ENTRY} of its metadata is wrong: {e}"));
        let kind: Kind = serde_json::from_str(entry).map_err(bad)?;
        if kind.format != H::FORMAT {
            return Err(invalid(name, &format!("expected {}, found {}", H::FORMAT, kind.format)));
        }
        if kind.version != H::VERSION {
            let advice = if kind.version < H::VERSION { H::IF_OLDER } else { "take a Lobe as new as the file" };
            let (version, format, found) = (H::VERSION, H::FORMAT, kind.version);
            return Err(invalid(name, &format!("expected version {version} of {format}, found {found}; {advice}")));
        }
        let header = serde_json::from_str(entry).map_err(bad)?;
        let tensors = SafeTensors::deserialize(bytes).map_err(broken)?;
        Ok(Self { name, header, tensors })
    }

    pub(crate) fn invalid(&self, message: &str) -> ShadowError {
        invalid(self.name, message)
    }

    /// The same fault, of this file.
    pub(crate) fn within(&self, error: ShadowError) -> ShadowError {
        match error {
            ShadowError::Invalid { message, .. } | ShadowError::Options(message) => self.invalid(&message),
            other => other,
        }
    }

    /// The type and the shape of a tensor.
    pub(crate) fn view(&self, name: &str) -> Result<(Dtype, Vec<usize>), ShadowError> {
        let view = self.tensors.tensor(name);
        let view = view.map_err(|_| self.invalid(&format!("expected a tensor {name}, found none")))?;
        Ok((view.dtype(), view.shape().to_vec()))
    }

    /// The bytes of a tensor of this type and shape.
    pub(crate) fn bytes(&self, name: &str, dtype: Dtype, shape: &[usize]) -> Result<&'a [u8], ShadowError> {
        let (found, of) = self.view(name)?;
        match self.tensors.tensor(name) {
            Ok(view) if (found, &*of) == (dtype, shape) => Ok(view.data()),
            _ => Err(self.invalid(&format!("expected a tensor {name} of {dtype:?} {shape:?}, found {found:?} {of:?}"))),
        }
    }

    pub(crate) fn f32(&self, name: &str, shape: &[usize]) -> Result<Vec<f32>, ShadowError> {
        Ok(self.bytes(name, Dtype::F32, shape)?.as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)).collect())
    }

    pub(crate) fn u16(&self, name: &str, shape: &[usize]) -> Result<Vec<u16>, ShadowError> {
        Ok(self.bytes(name, Dtype::U16, shape)?.as_chunks().0.iter().map(|b| u16::from_le_bytes(*b)).collect())
    }
}

/// A fault of a file in one line, which may quote it.
fn invalid(name: &str, message: &str) -> ShadowError {
    ShadowError::Invalid { place: name.to_owned(), message: message.replace(['\n', '\r'], " ") }
}
