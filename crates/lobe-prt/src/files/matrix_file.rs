//! Transfer matrices as safetensors.

use std::path::Path;

use lobe_io::{Job, TensorFormat, read_file};

use crate::bake::transfer_grid::{Neighborhood, NeighborhoodGrid};
use crate::error::PrtError;
use crate::files::tensor_file::{GridMember, Header, TransferFile, format, write_streamed};
use crate::recipe::Recipe;
use crate::transfer::transfer_matrices::TransferMatrices;
use crate::transfer::transfer_rows::MatrixRows;

pub(crate) const MATRICES: TensorFormat = format("lobe-transfer-matrices");
pub(crate) const NEIGHBORHOOD: TensorFormat = format("lobe-neighbourhood-transfer");
const TENSOR: &str = "matrices";

/// Writes transfer matrices as a safetensors file: one tensor `matrices` of `[points, channels, n², n²]` floats, row by
/// row.
///
/// The metadata's entry `lobe` is JSON: format `lobe-transfer-matrices`, version 1, order, channels, recipe.
/// The matrices are read a few points at a time; until all is written, nothing has the file's name.
///
/// # Errors
/// [`PrtError::Io`] if the system refuses, [`PrtError::Cancelled`] if the job was told to stop.
pub fn write_matrices(
    path: impl AsRef<Path>,
    matrices: &dyn MatrixRows,
    recipe: &Recipe,
    job: Job<'_>,
) -> Result<(), PrtError> {
    write_with(path.as_ref(), matrices, MATRICES, None, recipe, job)
}

/// Reads what [`write_matrices`] wrote: the matrices and their recipe.
///
/// # Errors
/// [`PrtError::Io`] if the file cannot be read, [`PrtError::Unsupported`] if it is of a later version,
/// [`PrtError::Invalid`] if it is none of ours or contradicts itself.
pub fn read_matrices(path: impl AsRef<Path>) -> Result<(TransferMatrices, Recipe), PrtError> {
    let path = path.as_ref();
    read_matrices_bytes(&read_file(path)?, &path.display().to_string())
}

/// [`read_matrices`] from the bytes of a file, whose name stands in messages.
///
/// # Errors
/// As [`read_matrices`].
pub fn read_matrices_bytes(bytes: &[u8], name: &str) -> Result<(TransferMatrices, Recipe), PrtError> {
    let (matrices, header) = read_with(bytes, name, MATRICES)?;
    Ok((matrices, header.recipe))
}

/// Writes neighborhood transfer as [`write_matrices`] does, x fastest; the entry `lobe` has format
/// `lobe-neighbourhood-transfer` and `grid`: the corners of the box, and the numbers of points along x, y and z.
///
/// # Errors
/// As [`write_matrices`], and [`PrtError::Invalid`] if the matrices are not those of the grid's points.
pub fn write_neighborhood(
    path: impl AsRef<Path>,
    grid: &NeighborhoodGrid,
    matrices: &dyn MatrixRows,
    recipe: &Recipe,
    job: Job<'_>,
) -> Result<(), PrtError> {
    grid.check_points(matrices.points())?;
    let [min, max] = grid.corners();
    write_with(path.as_ref(), matrices, NEIGHBORHOOD, Some((min, max, grid.counts())), recipe, job)
}

/// Reads what [`write_neighborhood`] wrote.
///
/// # Errors
/// As [`read_matrices`].
pub fn read_neighborhood(path: impl AsRef<Path>) -> Result<(Neighborhood, Recipe), PrtError> {
    let path = path.as_ref();
    read_neighborhood_bytes(&read_file(path)?, &path.display().to_string())
}

/// [`read_neighborhood`] from the bytes of a file, whose name stands in messages.
///
/// # Errors
/// As [`read_matrices`].
pub fn read_neighborhood_bytes(bytes: &[u8], name: &str) -> Result<(Neighborhood, Recipe), PrtError> {
    let (matrices, header) = read_with(bytes, name, NEIGHBORHOOD)?;
    let (min, max, counts) = header.grid.ok_or_else(|| PrtError::invalid(name, "expected a grid, found none"))?;
    let grid =
        NeighborhoodGrid::between(min, max, counts).map_err(|error| PrtError::invalid(name, error.to_string()))?;
    let neighborhood = Neighborhood::new(grid, matrices).map_err(|error| error.within(name))?;
    Ok((neighborhood, header.recipe))
}

fn write_with(
    path: &Path,
    matrices: &dyn MatrixRows,
    format: TensorFormat,
    grid: Option<GridMember>,
    recipe: &Recipe,
    job: Job<'_>,
) -> Result<(), PrtError> {
    let (order, channels) = (matrices.order(), matrices.channels());
    let shape = vec![matrices.points(), channels.count(), order * order, order * order];
    let header = Header { grid, ..Header::new(order, channels, recipe) };
    let read_rows = |first: usize, rows: &mut [f32]| matrices.read_rows(first, rows);
    write_streamed(path, (format, &header), (TENSOR, shape), &read_rows, job)
}

fn read_with(bytes: &[u8], name: &str, format: TensorFormat) -> Result<(TransferMatrices, Header), PrtError> {
    let file = TransferFile::parse(bytes, name, &[format])?;
    let (order, channels) = file.order_and_channels()?;
    let bands = Some(order * order);
    let numbers = file.f32(TENSOR, &[None, Some(channels.count()), bands, bands])?;
    let matrices = TransferMatrices::new(order, channels, numbers).map_err(|error| error.within(file.name()))?;
    Ok((matrices, file.header))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transfer::transfer::Channels;
    use lobe_io::{Numbers, Tensor, write_tensors};
    use lobe_scene::Bounds;
    use serde_json::json;

    fn matrices(points: usize) -> TransferMatrices {
        let count = points * 3 * 16;
        TransferMatrices::new(2, Channels::Rgb, (0..count).map(|i| i as f32).collect()).unwrap()
    }

    #[test]
    fn what_is_written_is_read_and_kinds_are_not_mixed_up() {
        let folder = tempfile::tempdir().unwrap();
        let [a, b] = ["a.safetensors", "b.safetensors"].map(|name| folder.path().join(name));
        write_matrices(&a, &matrices(5), &Recipe::from(json!({"seed": 3})), Job::default()).unwrap();
        assert_eq!(read_matrices(&a).unwrap(), (matrices(5), Recipe::from(json!({"seed": 3}))), "matrices");
        let grid = NeighborhoodGrid::new(Bounds { min: [-1.0; 3], max: [0.5, 1.0, 2.0] }, [2, 3, 2]).unwrap();
        let neighborhood = Neighborhood::new(grid, matrices(12)).unwrap();
        write_neighborhood(&b, &grid, neighborhood.matrices(), &Recipe::default(), Job::default()).unwrap();
        assert_eq!(read_neighborhood(&b).unwrap(), (neighborhood, Recipe::default()), "neighborhood");
        let error = read_matrices(&b).unwrap_err().to_string();
        assert!(error.ends_with("expected lobe-transfer-matrices, found lobe-neighbourhood-transfer"), "{error}");
        let error = read_neighborhood(&a).unwrap_err().to_string();
        assert!(error.ends_with("expected lobe-neighbourhood-transfer, found lobe-transfer-matrices"), "{error}");
    }

    #[test]
    fn headers_that_do_not_fit_their_numbers_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.safetensors");
        let grid = Some(([0.0; 3], [1.0; 3], [2, 2, 3]));
        for (order, channels, grid, part) in [
            (9, 3, grid, "expected an order of 1 to 8, found 9"),
            (2, 2, grid, "expected 1 or 3 channels, found 2"),
            (3, 3, grid, "expected a tensor matrices of shape [any, 3, 9, 9], found [5, 3, 4, 4]"),
            (2, 3, None, "expected a grid, found none"),
            (2, 3, grid, "expected matrices of 12 points, found 5"),
            (2, 3, Some(([0.0; 3], [0.0; 3], [2, 2, 2])), "expected a box with a volume"),
        ] {
            let header = Header { order, channels, grid, ..Header::new(2, Channels::Gray, &Recipe::default()) };
            let matrices = matrices(5);
            let tensor = Tensor::new(TENSOR, [5, 3, 4, 4], Numbers::F32(matrices.coefficients()));
            write_tensors(&path, NEIGHBORHOOD, &header, &[tensor]).unwrap();
            let error = read_neighborhood(&path).unwrap_err().to_string();
            assert!(error.contains(part) && !error.contains('\n'), "{part}: {error}");
        }
    }
}
