//! Lamps as safetensors: `NAME.lamp.safetensors`.

use std::path::Path;

use lobe_io::{Numbers, Tensor, TensorFile, TensorFormat, read_file, write_tensors};
use lobe_sh::Rgb;
use serde::{Deserialize, Serialize};

use crate::error::ShadowError;
use crate::field::axial::Axial;
use crate::field::field_file::check_order;
use crate::field::field_grid::FieldGrid;
use crate::field::field_storage::StoredRows;
use crate::field::field_storage::{FieldStorage, StorageReport};
use crate::field::lamp::{Lamp, LampSequence};
use crate::field::lamp_surface::check_patches;
use crate::field::lamp_surface::{PatchedRectangle, Rectangle};
use crate::field::patch_field::PatchField;
use crate::field::radiance_field::RadianceField;
use crate::field::radiance_field::Shape;

#[derive(Serialize, Deserialize)]
struct LampHeader {
    order: usize,
    #[serde(flatten)]
    shape: ShapeHeader,
    /// `f32` where it is left out, as it is of balls.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    storage: Option<String>,
}

#[derive(Serialize, Deserialize)]
#[serde(tag = "shape", rename_all = "lowercase")]
enum ShapeHeader {
    Ball {
        center: [f64; 3],
        radius: f64,
        radiance: [f64; 3],
    },
    Rectangle {
        #[serde(flatten)]
        points: PointsHeader,
    },
    Sequence {
        #[serde(flatten)]
        points: PointsHeader,
        pictures: usize,
        per_second: f64,
    },
}

/// A rectangle in patches, and the sample points around it.
#[derive(Serialize, Deserialize)]
struct PointsHeader {
    #[serde(flatten)]
    rectangle: Rectangle,
    patches: [usize; 2],
    inner: f64,
    outer: f64,
    spheres: usize,
    cells: usize,
}

impl PointsHeader {
    fn new(rectangle: &Rectangle, patches: [usize; 2], grid: &FieldGrid) -> Self {
        let [inner, outer] = grid.range();
        Self { rectangle: *rectangle, patches, inner, outer, spheres: grid.spheres(), cells: grid.cells() }
    }

    fn grid(&self) -> Result<FieldGrid, ShadowError> {
        self.rectangle.grid([self.inner, self.outer], self.spheres, self.cells)
    }

    fn patches(&self) -> usize {
        self.patches[0].saturating_mul(self.patches[1])
    }
}

/// Version 1 did not know what shines.
const FORMAT: TensorFormat = TensorFormat { name: "lobe-lamp", version: 2, if_older: "make the lamp anew" };

/// Writes a lamp; until all is written nothing has the file's name.
///
/// The metadata's entry `lobe` is JSON: format `lobe-lamp`, version 2, order n, the storage if it is not `f32`, and by `shape`:
///
/// | shape | members | tensors |
/// |---|---|---|
/// | `ball` | center, radius, radiance | none |
/// | `rectangle` | [`Rectangle`]: corner, u, v, `two_sided`; patches along u and v; inner, outer, spheres and cells of the [`FieldGrid`] | `rows` of `[points, 3, n + n²]`, `radiance` of `[1, patches, 3]` |
/// | `sequence` | the same, pictures, `per_second` | `patches` of `[patches, points, n + n²]`, `radiance` of `[pictures, patches, 3]` |
///
/// `radiance` is of `F32`; `rows` and `patches` are stored as those of [`write_field`](crate::write_field): of a rectangle a row has the
/// `3 (n + n²)` numbers of a point, of a sequence the `n + n²` of a point and patch. Balls have no numbers to store.
///
/// A row holds `z`, n numbers, and `g`, n² numbers: the light is `(z_l y_lm(d) + g_lm) / (1 + (r/R)²)`, with `d` the direction
/// from the point to the middle of the lamp; of a sequence the sum over the patches, each times its radiance.
///
/// # Errors
/// [`ShadowError::Io`] if the system refuses, [`ShadowError::Options`] for options of clusters out of range, or numbers beyond those
/// of the storage.
pub fn write_lamp(path: impl AsRef<Path>, lamp: &Lamp, storage: &FieldStorage) -> Result<StorageReport, ShadowError> {
    let (path, order) = (path.as_ref(), lamp.order());
    match lamp {
        Lamp::Still(field) => match field.shape() {
            Shape::Ball { center, radius, radiance } => {
                let (center, radius, radiance) = (*center, *radius, radiance.to_array());
                let shape = ShapeHeader::Ball { center, radius, radiance };
                write_tensors(path, FORMAT, &LampHeader { order, shape, storage: None }, &[])?;
                Ok(StoredRows::F32.report(&[]))
            }
            Shape::Sampled { source, grid, rows, .. } => {
                let points = PointsHeader::new(&source.rectangle, source.patches, grid);
                let radiance: Vec<f32> = source.radiance.iter().flat_map(|c| c.to_array().map(|c| c as f32)).collect();
                let (shape, shell) = ([grid.points(), 3, Axial::width(order)], grid.points_of_sphere());
                let table = Table { name: "rows", shape, rows, pictures: 1, shell };
                table.write(path, order, ShapeHeader::Rectangle { points }, &radiance, storage)
            }
        },
        Lamp::Sequence(sequence) => {
            let (field, pictures) = (sequence.patches(), sequence.pictures());
            let points = PointsHeader::new(field.rectangle(), field.patches(), field.grid());
            let radiance: Vec<f32> = pictures.iter().flatten().flat_map(|c| c.to_array()).collect();
            let shape = [points.patches(), field.grid().points(), Axial::width(order)];
            let shell = field.grid().points_of_sphere();
            let table = Table { name: "patches", shape, rows: field.table(), pictures: pictures.len(), shell };
            let (pictures, per_second) = (pictures.len(), sequence.per_second());
            table.write(path, order, ShapeHeader::Sequence { points, pictures, per_second }, &radiance, storage)
        }
    }
}

/// The numbers of a rectangle.
struct Table<'a> {
    name: &'static str,
    shape: [usize; 3],
    rows: &'a [f32],
    pictures: usize,
    /// Points of a sphere.
    shell: usize,
}

impl Table<'_> {
    fn write(
        &self,
        path: &Path,
        order: usize,
        shape: ShapeHeader,
        radiance: &[f32],
        storage: &FieldStorage,
    ) -> Result<StorageReport, ShadowError> {
        let shell = if self.name == "rows" { self.shell } else { self.shape[1] };
        let width = row_width(self.name, self.shape);
        let stored = StoredRows::encode_in_shells(self.rows, width, shell, storage)?;
        let of_radiance = [self.pictures, radiance.len() / (3 * self.pictures), 3];
        let mut tensors = vec![Tensor::new("radiance", of_radiance, Numbers::F32(radiance))];
        tensors.extend(stored.tensors(self.name, &self.shape, self.rows));
        let storage = (stored != StoredRows::F32).then(|| stored.name().to_owned());
        write_tensors(path, FORMAT, &LampHeader { order, shape, storage }, &tensors)?;
        Ok(stored.report(self.rows))
    }
}

/// The numbers of a row: the colors of a point go together, the patches do not.
fn row_width(name: &str, [_, middle, last]: [usize; 3]) -> usize {
    if name == "rows" { middle * last } else { last }
}

/// Reads what [`write_lamp`] wrote.
///
/// # Errors
/// [`ShadowError::Io`] if the file cannot be read, [`ShadowError::Invalid`] if it is none of ours, of another version, cut
/// off, or contradicts itself.
pub fn read_lamp(path: impl AsRef<Path>) -> Result<Lamp, ShadowError> {
    let path = path.as_ref();
    read_lamp_bytes(&read_file(path)?, &path.display().to_string())
}

/// [`read_lamp`] from the bytes of a file, whose name stands in messages.
///
/// # Errors
/// As [`read_lamp`].
pub fn read_lamp_bytes(bytes: &[u8], name: &str) -> Result<Lamp, ShadowError> {
    let file = TensorFile::parse(bytes, name, &[FORMAT])?;
    let LampHeader { order, shape, storage } = file.header()?;
    check_order(&file, order)?;
    read_shape(&file, order, &shape, storage.as_deref().unwrap_or("f32")).map_err(|error| error.within(name))
}

fn read_shape(file: &TensorFile<'_>, order: usize, shape: &ShapeHeader, storage: &str) -> Result<Lamp, ShadowError> {
    let width = Axial::width(order);
    let read = |name: &str, shape: [usize; 3]| StoredRows::read(file, storage, name, &shape, row_width(name, shape));
    match shape {
        ShapeHeader::Ball { center, radius, radiance } => {
            Ok(Lamp::Still(RadianceField::ball(order, *center, *radius, Rgb::from(*radiance))?))
        }
        ShapeHeader::Rectangle { points } => {
            let grid = points.grid()?;
            grid.check_bytes(3 * width)?;
            let rows = read("rows", [grid.points(), 3, width])?;
            let radiance = read_pictures(file, 1, points)?.concat();
            let radiance = radiance.into_iter().map(|c| Rgb::from(c.to_array().map(f64::from))).collect();
            let source = PatchedRectangle { rectangle: points.rectangle, patches: points.patches, radiance };
            Ok(Lamp::Still(RadianceField::sampled(source, grid, order, rows)?))
        }
        ShapeHeader::Sequence { points, pictures, per_second } => {
            let grid = points.grid()?;
            // Before a few bytes are taken for many numbers.
            check_patches(points.patches)?;
            grid.check_bytes(points.patches() * width)?;
            let table = read("patches", [points.patches(), grid.points(), width])?;
            let field = PatchField::from_table(points.rectangle, grid, order, points.patches, table)?;
            Ok(Lamp::Sequence(LampSequence::new(field, read_pictures(file, *pictures, points)?, *per_second)?))
        }
    }
}

/// For each picture the radiance of each patch.
fn read_pictures(
    file: &TensorFile<'_>,
    pictures: usize,
    points: &PointsHeader,
) -> Result<Vec<Vec<Rgb<f32>>>, ShadowError> {
    check_patches(points.patches)?;
    let radiance = file.f32("radiance", &[Some(pictures), Some(points.patches()), Some(3)])?;
    let colors = |picture: &[f32]| picture.as_chunks().0.iter().map(|c: &[f32; 3]| Rgb::from(*c)).collect();
    Ok(radiance.chunks_exact(3 * points.patches()).map(colors).collect())
}
