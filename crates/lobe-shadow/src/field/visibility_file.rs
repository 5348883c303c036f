//! Visibility of points of a surface as safetensors: `NAME.visibility.safetensors`.

use std::path::Path;

use lobe_io::{Numbers, Tensor, TensorFile, TensorFormat, read_file, write_tensors};
use serde::{Deserialize, Serialize};

use crate::error::ShadowError;
use crate::field::field_file::check_order;
use crate::field::field_storage::StoredRows;
use crate::field::field_storage::{FieldStorage, StorageReport};

#[derive(Serialize, Deserialize)]
struct Header {
    order: usize,
    storage: String,
}

const FORMAT: TensorFormat = TensorFormat { name: "lobe-visibility", version: 1, if_older: "bake the visibility anew" };

/// What points of a surface see of the sky past the scene that it is of.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceVisibility {
    order: usize,
    rows: Vec<f32>,
    positions: Option<Vec<[f32; 3]>>,
}

impl SurfaceVisibility {
    /// The visibility of some points.
    ///
    /// # Errors
    /// [`ShadowError::Options`] for an order out of range, [`ShadowError::Invalid`] unless all numbers are finite and there are `order²`
    /// of each point.
    pub fn new(order: usize, rows: Vec<f32>) -> Result<Self, ShadowError> {
        if !(1..=8).contains(&order) {
            return Err(ShadowError::Options(format!("expected an order of 1 to 8, found {order}")));
        }
        let invalid = |message: String| Err(ShadowError::Invalid { place: "visibility".to_owned(), message });
        if !rows.len().is_multiple_of(order * order) {
            return invalid(format!("expected {} numbers for each point, found {} in all", order * order, rows.len()));
        }
        if let Some(bad) = rows.iter().find(|x| !x.is_finite()) {
            return invalid(format!("expected finite numbers, found {bad}"));
        }
        Ok(Self { order, rows, positions: None })
    }

    /// The same with the place of each point, by which another program finds its own points among them.
    ///
    /// # Errors
    /// [`ShadowError::Invalid`] unless there is a finite place for each point.
    pub fn with_positions(mut self, positions: Vec<[f32; 3]>) -> Result<Self, ShadowError> {
        let invalid = |message: String| Err(ShadowError::Invalid { place: "visibility".to_owned(), message });
        if positions.len() != self.points() {
            return invalid(format!("expected {} positions, found {}", self.points(), positions.len()));
        }
        if let Some(bad) = positions.iter().find(|p| !p.iter().all(|c| c.is_finite())) {
            return invalid(format!("expected finite positions, found {bad:?}"));
        }
        self.positions = Some(positions);
        Ok(self)
    }

    /// The places of the points; none if the file was written without.
    #[must_use]
    pub fn positions(&self) -> Option<&[[f32; 3]]> {
        self.positions.as_deref()
    }

    /// Number of bands, 1 to 8.
    #[must_use]
    pub fn order(&self) -> usize {
        self.order
    }

    /// `order²` numbers for each point, as [`bake_visibility`](crate::bake_visibility) returns them.
    #[must_use]
    pub fn rows(&self) -> &[f32] {
        &self.rows
    }

    /// Number of points.
    #[must_use]
    pub fn points(&self) -> usize {
        self.rows.len() / (self.order * self.order)
    }
}

/// Writes visibility; until all is written nothing has the file's name.
///
/// The metadata's entry `lobe` is JSON: format `lobe-visibility`, version 1, order, storage. The tensors are those of
/// [`write_field`](crate::write_field), with a row of `order²` numbers for each point, and `positions` of `[points, 3]` where they are known.
///
/// # Errors
/// [`ShadowError::Io`] if the system refuses, [`ShadowError::Options`] for options of clusters out of range, or numbers beyond those
/// of the storage.
pub fn write_visibility(
    path: impl AsRef<Path>,
    visibility: &SurfaceVisibility,
    storage: &FieldStorage,
) -> Result<StorageReport, ShadowError> {
    let SurfaceVisibility { order, rows, positions } = visibility;
    let width = order * order;
    let stored = StoredRows::encode(rows, width, storage)?;
    let mut tensors = stored.tensors("rows", &[visibility.points(), width], rows);
    if let Some(positions) = positions {
        tensors.push(Tensor::new("positions", [positions.len(), 3], Numbers::F32(positions.as_flattened())));
    }
    let header = Header { order: *order, storage: stored.name().to_owned() };
    write_tensors(path.as_ref(), FORMAT, &header, &tensors)?;
    Ok(stored.report(rows))
}

/// Reads what [`write_visibility`] wrote.
///
/// # Errors
/// [`ShadowError::Io`] if the file cannot be read, [`ShadowError::Invalid`] if it is none of ours, of another version, cut
/// off, or contradicts itself.
pub fn read_visibility(path: impl AsRef<Path>) -> Result<SurfaceVisibility, ShadowError> {
    let path = path.as_ref();
    read_visibility_bytes(&read_file(path)?, &path.display().to_string())
}

/// [`read_visibility`] from the bytes of a file, whose name stands in messages.
///
/// # Errors
/// As [`read_visibility`].
pub fn read_visibility_bytes(bytes: &[u8], name: &str) -> Result<SurfaceVisibility, ShadowError> {
    let file = TensorFile::parse(bytes, name, &[FORMAT])?;
    let Header { order, storage } = file.header()?;
    check_order(&file, order)?;
    let width = order * order;
    let (_, shape) = file.view(if storage == "clustered" { "clusters" } else { "rows" })?;
    let points = shape.first().copied().unwrap_or(0);
    let rows = StoredRows::read(&file, &storage, "rows", &[points, width], width)?;
    let visibility = SurfaceVisibility::new(order, rows);
    let visibility = match file.view("positions") {
        Ok(_) => {
            let positions = file.f32("positions", &[Some(points), Some(3)])?;
            visibility.and_then(|visibility| visibility.with_positions(positions.as_chunks().0.to_vec()))
        }
        Err(_) => visibility,
    };
    visibility.map_err(|error| error.within(name))
}
