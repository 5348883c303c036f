//! Occlusion fields as safetensors: `NAME.field.safetensors`.

use std::collections::HashMap;
use std::fs;
use std::path::Path;

use half::f16;
use lobe_io::write_atomically;
use lobe_prt::{CompressedTable, Weights};
use safetensors::tensor::TensorView;
use safetensors::{Dtype, SafeTensorError, SafeTensors, serialize};
use serde::{Deserialize, Serialize};

use crate::field::axial::Axial;
use crate::field::field_storage::StoredRows;
use crate::{FieldGrid, FieldStorage, OcclusionField, ShadowError, StorageReport};

const FORMAT: &str = "lobe-occlusion-field";
const VERSION: u32 = 1;

/// The one entry of the metadata. With more than one their order, and so the bytes, would change from run to run.
const ENTRY: &str = "lobe";

/// What every header has, and what is read of it first.
#[derive(Deserialize)]
struct Kind {
    format: String,
    version: u32,
}

#[derive(Serialize, Deserialize)]
struct Header {
    format: String,
    version: u32,
    order: usize,
    center: [f64; 3],
    radius: f64,
    inner: f64,
    outer: f64,
    spheres: usize,
    cells: usize,
    storage: String,
}

/// Writes a field; until all is written nothing has the file's name.
///
/// The metadata's entry `lobe` is JSON: format `lobe-occlusion-field`, version 1, order, and the numbers of the
/// [`FieldGrid`]: center, radius, inner, outer, spheres, cells; and the storage. The tensors, one row for each sample point
/// of the `width = order + order²` numbers of [`OcclusionField::rows`]:
///
/// | storage | tensors |
/// |---|---|
/// | `f32`, `f16` | `rows` of `[points, width]` |
/// | `u8` | `rows` of bytes; `ranges` of `[2, width]`: the least value of each coefficient, then its step |
/// | `clustered` | `clusters` of `[points]`, `weights` of `[points, components]`, `bases` of `[clusters, components + 1, width]` |
///
/// # Errors
/// [`ShadowError::Io`] if the system refuses, [`ShadowError::Options`] for options of clusters out of range.
pub fn write_field(
    path: impl AsRef<Path>,
    field: &OcclusionField,
    storage: &FieldStorage,
) -> Result<StorageReport, ShadowError> {
    let path = path.as_ref();
    let place = path.display().to_string();
    let stored = StoredRows::encode(field, storage)?;
    let bytes = file_bytes(field, &stored)
        .map_err(|error| ShadowError::Invalid { place: place.clone(), message: error.to_string() })?;
    write_atomically(path, |out| out.write_all(&bytes)).map_err(|source| ShadowError::Io { place, source })?;
    Ok(stored.report(field))
}

fn file_bytes(field: &OcclusionField, stored: &StoredRows) -> Result<Vec<u8>, SafeTensorError> {
    let grid = field.grid();
    let (points, width) = (grid.points(), Axial::width(field.order()));
    let floats = |x: &[f32]| x.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
    let rows = |dtype, bytes| ("rows", dtype, vec![points, width], bytes);
    let (storage, tensors) = match stored {
        StoredRows::F32(x) => ("f32", vec![rows(Dtype::F32, floats(x))]),
        StoredRows::F16(x) => ("f16", vec![rows(Dtype::F16, x.iter().flat_map(|x| x.to_le_bytes()).collect())]),
        StoredRows::U8 { ranges, steps } => {
            ("u8", vec![rows(Dtype::U8, steps.clone()), ("ranges", Dtype::F32, vec![2, width], floats(ranges))])
        }
        StoredRows::Clustered(table) => ("clustered", clustered_tensors(table)),
    };
    let [inner, outer] = grid.range();
    let header = Header {
        format: FORMAT.to_owned(),
        version: VERSION,
        order: field.order(),
        center: grid.center(),
        radius: grid.radius(),
        inner,
        outer,
        spheres: grid.spheres(),
        cells: grid.cells(),
        storage: storage.to_owned(),
    };
    let header = serde_json::to_string(&header).map_err(SafeTensorError::from)?;
    let mut views = Vec::new();
    for (name, dtype, shape, bytes) in &tensors {
        views.push((*name, TensorView::new(*dtype, shape.clone(), bytes)?));
    }
    serialize(views, Some(HashMap::from([(ENTRY.to_owned(), header)])))
}

type NamedTensor = (&'static str, Dtype, Vec<usize>, Vec<u8>);

fn clustered_tensors(table: &CompressedTable) -> Vec<NamedTensor> {
    let (rows, components) = (table.rows(), table.components());
    let u16s = |x: &[u16]| x.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
    let floats = |x: &[f32]| x.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
    let (dtype, weights) = match table.weights() {
        Weights::F32(w) => (Dtype::F32, floats(w)),
        Weights::U16(w) => (Dtype::U16, u16s(w)),
        Weights::U8(w) => (Dtype::U8, w.clone()),
        // A form of weights that this format does not know fails the check of the shape.
        _ => (Dtype::F32, Vec::new()),
    };
    vec![
        ("clusters", Dtype::U16, vec![rows], u16s(table.clusters())),
        ("weights", dtype, vec![rows, components], weights),
        ("bases", Dtype::F32, vec![table.cluster_count(), components + 1, table.width()], floats(table.bases())),
    ]
}

/// Reads what [`write_field`] wrote.
///
/// # Errors
/// [`ShadowError::Io`] if the file cannot be read, [`ShadowError::Invalid`] if it is none of ours, of another version, cut
/// off, or contradicts itself.
pub fn read_field(path: impl AsRef<Path>) -> Result<OcclusionField, ShadowError> {
    let path = path.as_ref();
    let place = path.display().to_string();
    let bytes = fs::read(path).map_err(|source| ShadowError::Io { place: place.clone(), source })?;
    read_field_bytes(&bytes, &place)
}

/// [`read_field`] from the bytes of a file, whose name stands in messages.
///
/// # Errors
/// As [`read_field`].
pub fn read_field_bytes(bytes: &[u8], name: &str) -> Result<OcclusionField, ShadowError> {
    let file = File::parse(bytes, name)?;
    let Header { order, center, radius, inner, outer, spheres, cells, storage, .. } = &file.header;
    let grid = FieldGrid::new(*center, *radius, [*inner, *outer], *spheres, *cells).map_err(|e| file.within(e))?;
    if !(1..=8).contains(order) {
        return Err(file.invalid(&format!("expected an order of 1 to 8, found {order}")));
    }
    let (points, width) = (grid.points(), Axial::width(*order));
    let stored = match storage.as_str() {
        "f32" => StoredRows::F32(f32s(file.tensor("rows", Dtype::F32, &[points, width])?)),
        "f16" => {
            let bytes = file.tensor("rows", Dtype::F16, &[points, width])?;
            StoredRows::F16(bytes.as_chunks().0.iter().map(|b| f16::from_le_bytes(*b)).collect())
        }
        "u8" => StoredRows::U8 {
            ranges: f32s(file.tensor("ranges", Dtype::F32, &[2, width])?),
            steps: file.tensor("rows", Dtype::U8, &[points, width])?.to_vec(),
        },
        "clustered" => StoredRows::Clustered(file.clustered(points, width)?),
        other => return Err(file.invalid(&format!("expected storage f32, f16, u8 or clustered, found {other:?}"))),
    };
    OcclusionField::new(grid, *order, stored.decode()).map_err(|error| file.within(error))
}

/// A file whose header is understood.
struct File<'a> {
    name: &'a str,
    header: Header,
    tensors: SafeTensors<'a>,
}

impl<'a> File<'a> {
    fn parse(bytes: &'a [u8], name: &'a str) -> Result<Self, ShadowError> {
        let broken = |e: SafeTensorError| invalid(name, &format!("expected safetensors, found {e}"));
        let (_, metadata) = SafeTensors::read_metadata(bytes).map_err(broken)?;
        let Some(entry) = metadata.metadata().as_ref().and_then(|m| m.get(ENTRY)) else {
            return Err(invalid(name, &format!("expected tensors of {FORMAT}, found none of Lobe's")));
        };
        let bad = |e: serde_json::Error| invalid(name, &format!("the entry {ENTRY} of its metadata is wrong: {e}"));
        let kind: Kind = serde_json::from_str(entry).map_err(bad)?;
        if kind.format != FORMAT {
            return Err(invalid(name, &format!("expected {FORMAT}, found {}", kind.format)));
        }
        if kind.version != VERSION {
            return Err(invalid(
                name,
                &format!(
                    "expected version {VERSION} of {FORMAT}, found {}; take a Lobe as new as the file",
                    kind.version
                ),
            ));
        }
        let header = serde_json::from_str(entry).map_err(bad)?;
        let tensors = SafeTensors::deserialize(bytes).map_err(broken)?;
        Ok(Self { name, header, tensors })
    }

    fn invalid(&self, message: &str) -> ShadowError {
        invalid(self.name, message)
    }

    /// The same fault, of this file.
    fn within(&self, error: ShadowError) -> ShadowError {
        match error {
            ShadowError::Invalid { message, .. } | ShadowError::Options(message) => self.invalid(&message),
            other => other,
        }
    }

    fn view(&self, name: &str) -> Result<TensorView<'a>, ShadowError> {
        self.tensors.tensor(name).map_err(|_| self.invalid(&format!("expected a tensor {name}, found none")))
    }

    /// The bytes of a tensor of this type and shape.
    fn tensor(&self, name: &str, dtype: Dtype, shape: &[usize]) -> Result<&'a [u8], ShadowError> {
        let view = self.view(name)?;
        if (view.dtype(), view.shape()) == (dtype, shape) {
            return Ok(view.data());
        }
        let (found, of) = (view.dtype(), view.shape());
        Err(self.invalid(&format!("expected a tensor {name} of {dtype:?} {shape:?}, found {found:?} {of:?}")))
    }

    fn clustered(&self, points: usize, width: usize) -> Result<CompressedTable, ShadowError> {
        let (bases, weights) = (self.view("bases")?, self.view("weights")?);
        let &[clusters, vectors, _] = bases.shape() else {
            return Err(self.invalid(&format!("expected a tensor bases of three numbers, found {:?}", bases.shape())));
        };
        let components = vectors.saturating_sub(1);
        let basis = f32s(self.tensor("bases", Dtype::F32, &[clusters, vectors, width])?);
        let shape = [points, components];
        let weights = match weights.dtype() {
            Dtype::U8 => Weights::U8(self.tensor("weights", Dtype::U8, &shape)?.to_vec()),
            Dtype::U16 => Weights::U16(u16s(self.tensor("weights", Dtype::U16, &shape)?)),
            _ => Weights::F32(f32s(self.tensor("weights", Dtype::F32, &shape)?)),
        };
        let of_row = u16s(self.tensor("clusters", Dtype::U16, &[points])?);
        CompressedTable::new(width, components, of_row, weights, basis).map_err(|e| self.invalid(&e.to_string()))
    }
}

/// A fault of a file in one line, which may quote it.
fn invalid(name: &str, message: &str) -> ShadowError {
    ShadowError::Invalid { place: name.to_owned(), message: message.replace(['\n', '\r'], " ") }
}

fn f32s(bytes: &[u8]) -> Vec<f32> {
    bytes.as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)).collect()
}

fn u16s(bytes: &[u8]) -> Vec<u16> {
    bytes.as_chunks().0.iter().map(|b| u16::from_le_bytes(*b)).collect()
}
