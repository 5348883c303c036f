//! Occlusion fields as safetensors: `NAME.field.safetensors`.

use std::fs;
use std::path::Path;

use half::f16;
use lobe_prt::{CompressedTable, PrtError, TableWeights};
use safetensors::Dtype;
use serde::{Deserialize, Serialize};

use crate::field::axial::Axial;
use crate::field::field_storage::StoredRows;
use crate::tensors::{Header, Numbers, Tensor, TensorFile, write};
use crate::{FieldGrid, FieldStorage, OcclusionField, ShadowError, StorageReport};

/// The numbers of a [`FieldGrid`] in the header of a file.
#[derive(Serialize, Deserialize)]
pub(crate) struct GridHeader {
    center: [f64; 3],
    radius: f64,
    inner: f64,
    outer: f64,
    spheres: usize,
    cells: usize,
}

impl GridHeader {
    pub(crate) fn new(grid: &FieldGrid) -> Self {
        let [inner, outer] = grid.range();
        let (center, radius, spheres, cells) = (grid.center(), grid.radius(), grid.spheres(), grid.cells());
        Self { center, radius, inner, outer, spheres, cells }
    }

    /// # Errors
    /// As [`FieldGrid::new`].
    pub(crate) fn grid(&self) -> Result<FieldGrid, ShadowError> {
        FieldGrid::new(self.center, self.radius, [self.inner, self.outer], self.spheres, self.cells)
    }
}

#[derive(Serialize, Deserialize)]
struct OcclusionHeader {
    order: usize,
    #[serde(flatten)]
    grid: GridHeader,
    storage: String,
}

impl Header for OcclusionHeader {
    const FORMAT: &'static str = "lobe-occlusion-field";
    /// Version 1 had other radii of spheres for the same header.
    const VERSION: u32 = 2;
    const IF_OLDER: &'static str = "bake the field anew";
}

/// Writes a field; until all is written nothing has the file's name.
///
/// The metadata's entry `lobe` is JSON: format `lobe-occlusion-field`, version 2, order, and the numbers of the
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
    let stored = StoredRows::encode(field, storage)?;
    let report = stored.report(field);
    let (points, width) = (field.grid().points(), Axial::width(field.order()));
    let rows = |numbers| Tensor { name: "rows", shape: vec![points, width], numbers };
    let (name, tensors) = match &stored {
        StoredRows::F32 => ("f32", vec![rows(Numbers::F32(field.rows()))]),
        StoredRows::F16(x) => ("f16", vec![rows(Numbers::F16(x))]),
        StoredRows::U8 { ranges, steps } => {
            let ranges = Tensor { name: "ranges", shape: vec![2, width], numbers: Numbers::F32(ranges) };
            ("u8", vec![ranges, rows(Numbers::U8(steps))])
        }
        StoredRows::Clustered(table) => ("clustered", clustered_tensors(table)),
    };
    let (order, grid) = (field.order(), GridHeader::new(field.grid()));
    write(path.as_ref(), &OcclusionHeader { order, grid, storage: name.to_owned() }, &tensors)?;
    Ok(report)
}

fn clustered_tensors(table: &CompressedTable) -> Vec<Tensor<'_>> {
    let (rows, components) = (table.rows(), table.components());
    let weights = match table.weights() {
        TableWeights::F32(w) => Numbers::F32(w),
        TableWeights::U16(w) => Numbers::U16(w),
        TableWeights::U8(w) => Numbers::U8(w),
        // A form of weights that this format does not know fails the check of the shape.
        _ => Numbers::U8(&[]),
    };
    let shape = vec![table.cluster_count(), components + 1, table.width()];
    let bases = Tensor { name: "bases", shape, numbers: Numbers::F32(table.bases()) };
    let clusters = Tensor { name: "clusters", shape: vec![rows], numbers: Numbers::U16(table.clusters()) };
    let weights = Tensor { name: "weights", shape: vec![rows, components], numbers: weights };
    if matches!(weights.numbers, Numbers::F32(_)) {
        return vec![bases, weights, clusters];
    }
    vec![bases, clusters, weights]
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
    let file = TensorFile::<OcclusionHeader>::parse(bytes, name)?;
    let OcclusionHeader { order, grid, storage } = &file.header;
    let grid = grid.grid().map_err(|e| file.within(e))?;
    if !(1..=8).contains(order) {
        return Err(file.invalid(&format!("expected an order of 1 to 8, found {order}")));
    }
    let (points, width) = (grid.points(), Axial::width(*order));
    grid.check_bytes(width).map_err(|e| file.within(e))?;
    let rows = match storage.as_str() {
        "f32" => file.f32("rows", &[points, width])?,
        "f16" => {
            let bytes = file.bytes("rows", Dtype::F16, &[points, width])?;
            bytes.as_chunks().0.iter().map(|b| f16::from_le_bytes(*b).to_f32()).collect()
        }
        "u8" => {
            let ranges = file.f32("ranges", &[2, width])?;
            StoredRows::steps_to_numbers(&ranges, file.bytes("rows", Dtype::U8, &[points, width])?)
        }
        "clustered" => clustered(&file, points, width)?.decode(),
        other => return Err(file.invalid(&format!("expected storage f32, f16, u8 or clustered, found {other:?}"))),
    };
    OcclusionField::new(grid, *order, rows).map_err(|error| file.within(error))
}

fn clustered(
    file: &TensorFile<'_, OcclusionHeader>,
    points: usize,
    width: usize,
) -> Result<CompressedTable, ShadowError> {
    let (_, shape) = file.view("bases")?;
    // Without a component few bytes would stand for many numbers.
    let &[clusters, vectors, _] = &*shape else {
        return Err(file.invalid(&format!("expected a tensor bases of three numbers, found {shape:?}")));
    };
    if vectors < 2 {
        let message =
            format!("expected a tensor bases of clusters, 2 vectors or more, and {width} numbers, found {shape:?}");
        return Err(file.invalid(&message));
    }
    let components = vectors - 1;
    let bases = file.f32("bases", &[clusters, vectors, width])?;
    let shape = [points, components];
    let weights = match file.view("weights")?.0 {
        Dtype::U8 => TableWeights::U8(file.bytes("weights", Dtype::U8, &shape)?.to_vec()),
        Dtype::U16 => TableWeights::U16(file.u16("weights", &shape)?),
        _ => TableWeights::F32(file.f32("weights", &shape)?),
    };
    let of_row = file.u16("clusters", &[points])?;
    CompressedTable::new(width, components, of_row, weights, bases).map_err(|error| match error {
        // The table says where it is in words of transfer.
        PrtError::Invalid { message, .. } => file.invalid(&format!("clusters and weights: {message}")),
        other => file.invalid(&other.to_string()),
    })
}
