//! Occlusion fields as safetensors: `NAME.field.safetensors`.

use std::path::Path;

use half::f16;
use lobe_io::{Dtype, IoError, Numbers, Tensor, TensorFile, TensorFormat, read_file, write_tensors};
use lobe_prt::{CompressedTable, PrtError, TableWeights};
use serde::{Deserialize, Serialize};

use crate::field::axial::Axial;
use crate::field::field_storage::StoredRows;
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

/// Version 1 had other radii of spheres for the same header.
const FORMAT: TensorFormat = TensorFormat { name: "lobe-occlusion-field", version: 2, if_older: "bake the field anew" };

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
    let rows = |numbers| Tensor::new("rows", [points, width], numbers);
    let (name, tensors) = match &stored {
        StoredRows::F32 => ("f32", vec![rows(Numbers::F32(field.rows()))]),
        StoredRows::F16(x) => ("f16", vec![rows(Numbers::F16(x))]),
        StoredRows::U8 { ranges, steps } => {
            let ranges = Tensor::new("ranges", [2, width], Numbers::F32(ranges));
            ("u8", vec![ranges, rows(Numbers::U8(steps))])
        }
        StoredRows::Clustered(table) => ("clustered", clustered_tensors(table)),
    };
    let (order, grid) = (field.order(), GridHeader::new(field.grid()));
    write_tensors(path.as_ref(), FORMAT, &OcclusionHeader { order, grid, storage: name.to_owned() }, &tensors)?;
    Ok(report)
}

fn clustered_tensors(table: &CompressedTable) -> Vec<Tensor<'_>> {
    let (rows, components) = (table.rows(), table.components());
    vec![
        Tensor::new("bases", [table.cluster_count(), components + 1, table.width()], Numbers::F32(table.bases())),
        Tensor::new("clusters", [rows], Numbers::U16(table.clusters())),
        Tensor::new("weights", [rows, components], table.weights().into()),
    ]
}

/// Reads what [`write_field`] wrote.
///
/// # Errors
/// [`ShadowError::Io`] if the file cannot be read, [`ShadowError::Invalid`] if it is none of ours, of another version, cut
/// off, or contradicts itself.
pub fn read_field(path: impl AsRef<Path>) -> Result<OcclusionField, ShadowError> {
    let path = path.as_ref();
    read_field_bytes(&read_file(path)?, &path.display().to_string())
}

/// [`read_field`] from the bytes of a file, whose name stands in messages.
///
/// # Errors
/// As [`read_field`].
pub fn read_field_bytes(bytes: &[u8], name: &str) -> Result<OcclusionField, ShadowError> {
    let file = TensorFile::parse(bytes, name, &[FORMAT])?;
    let OcclusionHeader { order, grid, storage } = file.header()?;
    let grid = grid.grid().map_err(|e| e.within(name))?;
    check_order(&file, order)?;
    let (points, width) = (grid.points(), Axial::width(order));
    grid.check_bytes(width).map_err(|e| e.within(name))?;
    let shape = [Some(points), Some(width)];
    let rows = match storage.as_str() {
        "f32" => file.f32("rows", &shape)?,
        "f16" => file.f16("rows", &shape)?.into_iter().map(f16::to_f32).collect(),
        "u8" => {
            let ranges = file.f32("ranges", &[Some(2), Some(width)])?;
            StoredRows::steps_to_numbers(&ranges, file.bytes("rows", Dtype::U8, &shape)?)
        }
        "clustered" => clustered(&file, points, width)?.decode(),
        other => {
            let message = format!("expected storage f32, f16, u8 or clustered, found {other:?}");
            return Err(file.invalid(message).into());
        }
    };
    OcclusionField::new(grid, order, rows).map_err(|error| error.within(name))
}

/// Refuses an order that fields and lamps do not have.
pub(crate) fn check_order(file: &TensorFile<'_>, order: usize) -> Result<(), IoError> {
    match order {
        1..=8 => Ok(()),
        found => Err(file.invalid(format!("expected an order of 1 to 8, found {found}"))),
    }
}

fn clustered(file: &TensorFile<'_>, points: usize, width: usize) -> Result<CompressedTable, IoError> {
    let (_, shape) = file.view("bases")?;
    // Without a component few bytes would stand for many numbers.
    let &[clusters, vectors, _] = &*shape else {
        return Err(file.invalid(format!("expected a tensor bases of three numbers, found {shape:?}")));
    };
    if vectors < 2 {
        let message =
            format!("expected a tensor bases of clusters, 2 vectors or more, and {width} numbers, found {shape:?}");
        return Err(file.invalid(message));
    }
    let components = vectors - 1;
    let bases = file.f32("bases", &[Some(clusters), Some(vectors), Some(width)])?;
    let shape = [Some(points), Some(components)];
    let weights = match file.view("weights")?.0 {
        Dtype::U8 => TableWeights::U8(file.bytes("weights", Dtype::U8, &shape)?.to_vec()),
        Dtype::U16 => TableWeights::U16(file.u16("weights", &shape)?),
        _ => TableWeights::F32(file.f32("weights", &shape)?),
    };
    let of_row = file.u16("clusters", &[Some(points)])?;
    CompressedTable::new(width, components, of_row, weights, bases).map_err(|error| match error {
        // The table says where it is in words of transfer.
        PrtError::Invalid { message, .. } => file.invalid(format!("clusters and weights: {message}")),
        other => file.invalid(other.to_string()),
    })
}
