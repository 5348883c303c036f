//! Safetensors files of Lobe: named tensors, and one entry of metadata that describes them.

use std::collections::HashMap;
use std::path::Path;
use std::{fs, io};

use lobe_io::{Job, write_atomically};
use safetensors::tensor::TensorView;
use safetensors::{Dtype, SafeTensors, serialize};
use serde::{Deserialize, Serialize};
use serde_json::json;

use crate::job::checkpoint::rows_at_once;
use crate::job::meter::Meter;
use crate::transfer::transfer::check_order;
use crate::{Channels, PrtError, Recipe};

/// The one entry of the metadata. With more than one their order, and so the bytes, would change from run to run.
const ENTRY: &str = "lobe";

/// The version of every format.
const VERSION: u32 = 1;

/// The corners of the box of a grid, and its points along x, y and z.
pub(crate) type GridMember = ([f64; 3], [f64; 3], [usize; 3]);

/// The header of every format, without the members that it does not have.
#[derive(Serialize, Deserialize)]
pub(crate) struct Header {
    pub(crate) format: String,
    pub(crate) version: u32,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) quantity: Option<String>,
    pub(crate) order: usize,
    pub(crate) channels: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) clusters: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) components: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) lobes: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) grid: Option<GridMember>,
    #[serde(default)]
    pub(crate) recipe: Recipe,
}

impl Header {
    pub(crate) fn new(format: &str, order: usize, channels: Channels, recipe: &Recipe) -> Self {
        Self {
            format: format.to_owned(),
            version: VERSION,
            quantity: None,
            order,
            channels: channels.count(),
            clusters: None,
            components: None,
            lobes: None,
            grid: None,
            recipe: recipe.clone(),
        }
    }
}

/// The members that are looked at first.
#[derive(Deserialize)]
struct Kind {
    format: String,
    version: u32,
}

/// A tensor to write: name, type, shape, bytes in little-endian order.
pub(crate) struct Tensor {
    pub(crate) name: &'static str,
    pub(crate) dtype: Dtype,
    pub(crate) shape: Vec<usize>,
    pub(crate) bytes: Vec<u8>,
}

impl Tensor {
    pub(crate) fn f32(name: &'static str, shape: Vec<usize>, values: impl IntoIterator<Item = f32>) -> Self {
        Self { name, dtype: Dtype::F32, shape, bytes: values.into_iter().flat_map(f32::to_le_bytes).collect() }
    }

    pub(crate) fn u16(name: &'static str, shape: Vec<usize>, values: &[u16]) -> Self {
        Self { name, dtype: Dtype::U16, shape, bytes: values.iter().flat_map(|x| x.to_le_bytes()).collect() }
    }
}

/// Writes a file; nothing half-written ever has its name.
///
/// # Errors
/// [`PrtError::Io`] if it cannot be written.
pub(crate) fn write(path: &Path, header: &Header, tensors: &[Tensor]) -> Result<(), PrtError> {
    let file = path.display().to_string();
    let invalid = |message: String| PrtError::invalid(&file, message);
    let header = serde_json::to_string(header).map_err(|e| invalid(e.to_string()))?;
    let views: Result<Vec<_>, _> =
        tensors.iter().map(|t| Ok((t.name, TensorView::new(t.dtype, t.shape.clone(), &t.bytes)?))).collect();
    let views = views.map_err(|e: safetensors::SafeTensorError| invalid(e.to_string()))?;
    let metadata = HashMap::from([(ENTRY.to_owned(), header)]);
    let bytes = serialize(views, Some(metadata)).map_err(|e| invalid(e.to_string()))?;
    write_atomically(path, |out| out.write_all(&bytes)).map_err(|source| PrtError::Io { place: file, source })
}

/// One tensor of `f32` that need not be in memory.
pub(crate) struct Streamed<'a> {
    pub(crate) name: &'static str,
    /// Its first number is that of the rows.
    pub(crate) shape: Vec<usize>,
    /// Reads the rows from the first on, as many as fill the slice.
    pub(crate) read_rows: &'a dyn Fn(usize, &mut [f32]) -> io::Result<()>,
}

/// Writes a file of one tensor, 4 MiB at a time; until all is written, nothing has its name.
///
/// # Errors
/// [`PrtError::Io`] if it cannot be written, or the rows cannot be read; [`PrtError::Cancelled`] if the job was told to
/// stop.
pub(crate) fn write_streamed(
    path: &Path,
    header: &Header,
    tensor: &Streamed<'_>,
    job: Job<'_>,
) -> Result<(), PrtError> {
    let file = path.display().to_string();
    let lobe = serde_json::to_string(header).map_err(|e| PrtError::invalid(&file, e.to_string()))?;
    let (rows, row) = (tensor.shape[0], tensor.shape[1..].iter().product::<usize>());
    // Eight bytes of length, JSON padded with blanks to a multiple of eight, the numbers: that is the whole format.
    let json = json!({
        "__metadata__": {ENTRY: lobe},
        tensor.name: {"dtype": "F32", "shape": tensor.shape, "data_offsets": [0, rows * row * 4]},
    });
    let mut json = json.to_string().into_bytes();
    json.resize(json.len().next_multiple_of(8), b' ');
    let (at_once, mut meter) = (rows_at_once(row), Meter::new(rows, job)?);
    let written = write_atomically(path, |out| {
        out.write_all(&(json.len() as u64).to_le_bytes())?;
        out.write_all(&json)?;
        let (mut numbers, mut bytes) = (vec![0.0; row * at_once.min(rows)], Vec::new());
        for first in (0..rows).step_by(at_once) {
            meter.go_on_writing()?;
            let numbers = &mut numbers[..row * at_once.min(rows - first)];
            (tensor.read_rows)(first, numbers)?;
            bytes.clear();
            bytes.extend(numbers.iter().flat_map(|c| c.to_le_bytes()));
            out.write_all(&bytes)?;
            meter.step(numbers.len() / row);
        }
        Ok(())
    });
    meter.written(&file, written)
}

/// A file's bytes.
///
/// # Errors
/// [`PrtError::Io`] if it cannot be read.
pub(crate) fn load(path: &Path) -> Result<Vec<u8>, PrtError> {
    fs::read(path).map_err(|source| PrtError::Io { place: path.display().to_string(), source })
}

/// A file that has been read, its header understood.
pub(crate) struct TensorFile<'a> {
    name: String,
    pub(crate) header: Header,
    tensors: SafeTensors<'a>,
}

impl<'a> TensorFile<'a> {
    /// # Errors
    /// [`PrtError::Invalid`] if these are no safetensors or of none of the formats; [`PrtError::Unsupported`] if a later
    /// version wrote them.
    pub(crate) fn parse(bytes: &'a [u8], name: &str, formats: &[&str]) -> Result<Self, PrtError> {
        let format = formats[0];
        // Remove line breaks: messages may quote the file.
        let invalid = |message: String| PrtError::invalid(name, message.replace(['\n', '\r'], " "));
        let broken = |e: safetensors::SafeTensorError| invalid(format!("expected safetensors, found {e}"));
        let (_, metadata) = SafeTensors::read_metadata(bytes).map_err(broken)?;
        let entry = metadata.metadata().as_ref().and_then(|m| m.get(ENTRY));
        let Some(header) = entry else {
            return Err(invalid(format!("expected tensors of {format}, found none of Lobe's")));
        };
        let bad_header = |e: serde_json::Error| invalid(format!("the entry {ENTRY} of its metadata is wrong: {e}"));
        let kind: Kind = serde_json::from_str(header).map_err(bad_header)?;
        if !formats.contains(&kind.format.as_str()) {
            return Err(invalid(format!("expected {format}, found {}", kind.format)));
        }
        if kind.version != VERSION {
            let message = format!(
                "expected version {VERSION} of {}, found {}; take a Lobe as new as the file",
                kind.format, kind.version
            );
            return Err(PrtError::Unsupported { place: name.to_owned(), message });
        }
        let header = serde_json::from_str(header).map_err(bad_header)?;
        let tensors = SafeTensors::deserialize(bytes).map_err(broken)?;
        Ok(Self { name: name.to_owned(), header, tensors })
    }

    pub(crate) fn name(&self) -> &str {
        &self.name
    }

    /// The order and the channels of the header, if transfer can have them.
    pub(crate) fn order_and_channels(&self) -> Result<(usize, Channels), PrtError> {
        let Header { order, channels, .. } = self.header;
        check_order(order).map_err(|error| PrtError::invalid(&self.name, error.to_string()))?;
        let message = match channels {
            1 => return Ok((order, Channels::Gray)),
            3 => return Ok((order, Channels::Rgb)),
            found => format!("expected 1 or 3 channels, found {found}"),
        };
        Err(PrtError::invalid(&self.name, message))
    }

    /// A member of the header that the format has.
    pub(crate) fn member<T>(&self, name: &str, member: Option<T>) -> Result<T, PrtError> {
        member.ok_or_else(|| PrtError::invalid(&self.name, format!("expected {name} in its header, found none")))
    }

    /// A tensor's type, and its bytes if the shape is as expected; `None` in it stands for any length.
    ///
    /// # Errors
    /// [`PrtError::Invalid`] if there is no such tensor, or it has another shape.
    pub(crate) fn tensor(&self, name: &str, shape: &[Option<usize>]) -> Result<(Dtype, TensorView<'a>), PrtError> {
        let Ok(view) = self.tensors.tensor(name) else {
            return Err(PrtError::invalid(&self.name, format!("expected a tensor {name}, found none")));
        };
        let fits =
            view.shape().len() == shape.len() && view.shape().iter().zip(shape).all(|(a, b)| b.is_none_or(|b| b == *a));
        if !fits {
            let expected: Vec<String> = shape.iter().map(|n| n.map_or("any".to_owned(), |n| n.to_string())).collect();
            let message =
                format!("expected a tensor {name} of shape [{}], found {:?}", expected.join(", "), view.shape());
            return Err(PrtError::invalid(&self.name, message));
        }
        Ok((view.dtype(), view))
    }

    /// A tensor of `f32`.
    ///
    /// # Errors
    /// As for [`TensorFile::tensor`], and if it is of another type.
    pub(crate) fn f32(&self, name: &str, shape: &[Option<usize>]) -> Result<Vec<f32>, PrtError> {
        let (dtype, view) = self.tensor(name, shape)?;
        self.expect(name, dtype, Dtype::F32)?;
        Ok(f32s(view.data()))
    }

    /// Refuses a tensor of the wrong type.
    pub(crate) fn expect(&self, name: &str, found: Dtype, expected: Dtype) -> Result<(), PrtError> {
        if found == expected {
            return Ok(());
        }
        Err(PrtError::invalid(&self.name, format!("expected a tensor {name} of {expected:?}, found {found:?}")))
    }
}

pub(crate) fn f32s(bytes: &[u8]) -> Vec<f32> {
    bytes.as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)).collect()
}

pub(crate) fn u16s(bytes: &[u8]) -> Vec<u16> {
    bytes.as_chunks().0.iter().map(|b| u16::from_le_bytes(*b)).collect()
}
