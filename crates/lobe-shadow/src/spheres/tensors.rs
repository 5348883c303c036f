//! Safetensors files of spheres: named tensors, and one entry of metadata that says what they are.

use std::collections::HashMap;
use std::fs;
use std::path::Path;

use lobe_io::write_atomically;
use safetensors::tensor::TensorView;
use safetensors::{Dtype, SafeTensors, serialize};
use serde::{Deserialize, Serialize};

use crate::ShadowError;

/// The one entry of the metadata. With more than one their order, and so the bytes, would change from run to run.
const ENTRY: &str = "lobe";

/// The version of all formats of spheres.
const VERSION: u32 = 1;

#[derive(Serialize, Deserialize)]
struct Header {
    format: String,
    version: u32,
    /// The point of the mesh's frame from which centers count.
    #[serde(default)]
    origin: [f64; 3],
}

/// A tensor: its name, type, shape and little-endian bytes.
pub(crate) struct Tensor {
    pub(crate) name: &'static str,
    pub(crate) dtype: Dtype,
    pub(crate) shape: Vec<usize>,
    pub(crate) bytes: Vec<u8>,
}

impl Tensor {
    pub(crate) fn f32(name: &'static str, shape: Vec<usize>, values: &[f32]) -> Self {
        Self { name, dtype: Dtype::F32, shape, bytes: values.iter().flat_map(|x| x.to_le_bytes()).collect() }
    }

    pub(crate) fn u16(name: &'static str, shape: Vec<usize>, values: &[u16]) -> Self {
        Self { name, dtype: Dtype::U16, shape, bytes: values.iter().flat_map(|x| x.to_le_bytes()).collect() }
    }
}

/// Writes tensors whose centers count from an origin; nothing half-written ever has the file's name.
pub(crate) fn write(path: &Path, format: &str, origin: [f64; 3], tensors: &[Tensor]) -> Result<(), ShadowError> {
    let place = path.display().to_string();
    let invalid = |message: String| ShadowError::Invalid { place: place.clone(), message };
    let header = Header { format: format.to_owned(), version: VERSION, origin };
    let header = serde_json::to_string(&header).map_err(|e| invalid(e.to_string()))?;
    let views: Result<Vec<_>, _> =
        tensors.iter().map(|t| Ok((t.name, TensorView::new(t.dtype, t.shape.clone(), &t.bytes)?))).collect();
    let views = views.map_err(|e: safetensors::SafeTensorError| invalid(e.to_string()))?;
    let metadata = HashMap::from([(ENTRY.to_owned(), header)]);
    let bytes = serialize(views, Some(metadata)).map_err(|e| invalid(e.to_string()))?;
    write_atomically(path, |out| out.write_all(&bytes)).map_err(|source| ShadowError::Io { place, source })
}

/// A file's bytes.
pub(crate) fn load(path: &Path) -> Result<Vec<u8>, ShadowError> {
    fs::read(path).map_err(|source| ShadowError::Io { place: path.display().to_string(), source })
}

/// Tensors that have been read.
pub(crate) struct TensorFile<'a> {
    name: String,
    /// The point of the mesh's frame from which centers count.
    pub(crate) origin: [f64; 3],
    tensors: SafeTensors<'a>,
}

impl<'a> TensorFile<'a> {
    /// The tensors of a file of the format.
    pub(crate) fn parse(bytes: &'a [u8], name: &str, format: &str) -> Result<Self, ShadowError> {
        // Remove line breaks: messages may quote the file.
        let invalid = |message: String| ShadowError::Invalid {
            place: name.to_owned(),
            message: message.replace(['\n', '\r'], " "),
        };
        let broken = |e: safetensors::SafeTensorError| invalid(format!("expected safetensors, found {e}"));
        let (_, metadata) = SafeTensors::read_metadata(bytes).map_err(broken)?;
        let Some(header) = metadata.metadata().as_ref().and_then(|m| m.get(ENTRY)) else {
            return Err(invalid(format!("expected tensors of {format}, found none of Lobe's")));
        };
        let header: Header = serde_json::from_str(header)
            .map_err(|e| invalid(format!("the entry {ENTRY} of its metadata is wrong: {e}")))?;
        if header.format != format {
            return Err(invalid(format!("expected {format}, found {}", header.format)));
        }
        if header.version != VERSION {
            let message = format!(
                "expected version {VERSION} of {format}, found {}; take a Lobe as new as the file",
                header.version
            );
            return Err(invalid(message));
        }
        let tensors = SafeTensors::deserialize(bytes).map_err(broken)?;
        Ok(Self { name: name.to_owned(), origin: header.origin, tensors })
    }

    pub(crate) fn invalid(&self, message: String) -> ShadowError {
        ShadowError::Invalid { place: self.name.clone(), message }
    }

    pub(crate) fn has(&self, name: &str) -> bool {
        self.tensors.tensor(name).is_ok()
    }

    /// The bytes of a tensor whose rows have `columns` numbers; 0 stands for a tensor of one dimension.
    fn bytes(&self, name: &str, dtype: Dtype, columns: usize) -> Result<&'a [u8], ShadowError> {
        let Ok(view) = self.tensors.tensor(name) else {
            return Err(self.invalid(format!("expected a tensor {name}, found none")));
        };
        let is_as_expected = match (columns, view.shape()) {
            (0, [_]) => true,
            (columns, [_, found]) => *found == columns,
            _ => false,
        };
        if !is_as_expected || view.dtype() != dtype {
            let shape = if columns == 0 { "[any]".to_owned() } else { format!("[any, {columns}]") };
            let message =
                format!("expected a tensor {name} of {dtype:?} {shape}, found {:?} {:?}", view.dtype(), view.shape());
            return Err(self.invalid(message));
        }
        Ok(view.data())
    }

    pub(crate) fn f32(&self, name: &str, columns: usize) -> Result<Vec<f32>, ShadowError> {
        Ok(self.bytes(name, Dtype::F32, columns)?.as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)).collect())
    }

    pub(crate) fn u16(&self, name: &str, columns: usize) -> Result<Vec<u16>, ShadowError> {
        Ok(self.bytes(name, Dtype::U16, columns)?.as_chunks().0.iter().map(|b| u16::from_le_bytes(*b)).collect())
    }
}
