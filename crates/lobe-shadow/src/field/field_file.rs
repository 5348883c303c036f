//! Occlusion fields as safetensors: `NAME.field.safetensors`.

use std::path::Path;

use lobe_io::{IoError, TensorFile, TensorFormat, read_file, write_tensors};
use serde::{Deserialize, Serialize};

use crate::error::ShadowError;
use crate::field::axial::Axial;
use crate::field::field_grid::FieldGrid;
use crate::field::field_storage::StoredRows;
use crate::field::field_storage::{FieldStorage, StorageReport};
use crate::field::occlusion_field::OcclusionField;

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
/// Of the spheres of points each quarter has as many clusters of its own as every other.
///
/// # Errors
/// [`ShadowError::Io`] if the system refuses, [`ShadowError::Options`] for options of clusters out of range.
pub fn write_field(
    path: impl AsRef<Path>,
    field: &OcclusionField,
    storage: &FieldStorage,
) -> Result<StorageReport, ShadowError> {
    let (points, width) = (field.grid().points(), Axial::width(field.order()));
    let shell = field.grid().points_of_sphere();
    let stored = StoredRows::encode_in_shells(field.rows(), width, shell, storage)?;
    let tensors = stored.tensors("rows", &[points, width], field.rows());
    let (order, grid, storage) = (field.order(), GridHeader::new(field.grid()), stored.name().to_owned());
    write_tensors(path.as_ref(), FORMAT, &OcclusionHeader { order, grid, storage }, &tensors)?;
    Ok(stored.report(field.rows()))
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
    let rows = StoredRows::read(&file, &storage, "rows", &[points, width], width)?;
    OcclusionField::new(grid, order, rows).map_err(|error| error.within(name))
}

/// Refuses an order that fields and lamps do not have.
pub(crate) fn check_order(file: &TensorFile<'_>, order: usize) -> Result<(), IoError> {
    match order {
        1..=8 => Ok(()),
        found => Err(file.invalid(format!("expected an order of 1 to 8, found {found}"))),
    }
}
