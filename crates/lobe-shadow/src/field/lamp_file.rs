//! Lamps as safetensors: `NAME.lamp.safetensors`.

use std::path::Path;

use lobe_io::{Numbers, Tensor, TensorFile, TensorFormat, read_file, write_tensors};
use lobe_sh::Rgb;
use serde::{Deserialize, Serialize};

use crate::field::axial::Axial;
use crate::field::field_file::check_order;
use crate::field::lamp_surface::check_patches;
use crate::field::radiance_field::Shape;
use crate::{FieldGrid, Lamp, LampSequence, PatchField, PatchedRectangle, RadianceField, Rectangle, ShadowError};

#[derive(Serialize, Deserialize)]
struct LampHeader {
    order: usize,
    #[serde(flatten)]
    shape: ShapeHeader,
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
/// The metadata's entry `lobe` is JSON: format `lobe-lamp`, version 2, order n, and by `shape`:
///
/// | shape | members | tensors of `F32` |
/// |---|---|---|
/// | `ball` | center, radius, radiance | none |
/// | `rectangle` | [`Rectangle`]: corner, u, v, `two_sided`; patches along u and v; inner, outer, spheres and cells of the [`FieldGrid`] | `rows` of `[points, 3, n + n²]`, `radiance` of `[1, patches, 3]` |
/// | `sequence` | the same, pictures, `per_second` | `patches` of `[patches, points, n + n²]`, `radiance` of `[pictures, patches, 3]` |
///
/// A row holds `z`, n numbers, and `g`, n² numbers: the light is `(z_l y_lm(d) + g_lm) / (1 + (r/R)²)`, with `d` the direction
/// from the point to the middle of the lamp; of a sequence the sum over the patches, each times its radiance.
///
/// # Errors
/// [`ShadowError::Io`] if the system refuses.
pub fn write_lamp(path: impl AsRef<Path>, lamp: &Lamp) -> Result<(), ShadowError> {
    let order = lamp.order();
    let width = Axial::width(order);
    let write = |shape, tensors: &[_]| write_tensors(path.as_ref(), FORMAT, &LampHeader { order, shape }, tensors);
    match lamp {
        Lamp::Still(field) => match field.shape() {
            Shape::Ball { center, radius, radiance } => {
                let (center, radius, radiance) = (*center, *radius, radiance.to_array());
                write(ShapeHeader::Ball { center, radius, radiance }, &[])
            }
            Shape::Sampled { source, grid, rows, .. } => {
                let points = PointsHeader::new(&source.rectangle, source.patches, grid);
                let radiance: Vec<f32> = source.radiance.iter().flat_map(|c| c.to_array().map(|c| c as f32)).collect();
                let tensors = [
                    Tensor::new("radiance", [1, points.patches(), 3], Numbers::F32(&radiance)),
                    Tensor::new("rows", [grid.points(), 3, width], Numbers::F32(rows)),
                ];
                write(ShapeHeader::Rectangle { points }, &tensors)
            }
        },
        Lamp::Sequence(sequence) => {
            let (field, pictures) = (sequence.patches(), sequence.pictures());
            let points = PointsHeader::new(field.rectangle(), field.patches(), field.grid());
            let radiance: Vec<f32> = pictures.iter().flatten().flat_map(|c| c.to_array()).collect();
            let tensors = [
                Tensor::new("patches", [points.patches(), field.grid().points(), width], Numbers::F32(field.table())),
                Tensor::new("radiance", [pictures.len(), points.patches(), 3], Numbers::F32(&radiance)),
            ];
            let (pictures, per_second) = (pictures.len(), sequence.per_second());
            write(ShapeHeader::Sequence { points, pictures, per_second }, &tensors)
        }
    }
    .map_err(ShadowError::from)
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
    let LampHeader { order, shape } = file.header()?;
    check_order(&file, order)?;
    read_shape(&file, order, &shape).map_err(|error| error.within(name))
}

fn read_shape(file: &TensorFile<'_>, order: usize, shape: &ShapeHeader) -> Result<Lamp, ShadowError> {
    let width = Axial::width(order);
    match shape {
        ShapeHeader::Ball { center, radius, radiance } => {
            Ok(Lamp::Still(RadianceField::ball(order, *center, *radius, Rgb::from(*radiance))?))
        }
        ShapeHeader::Rectangle { points } => {
            let grid = points.grid()?;
            grid.check_bytes(3 * width)?;
            let rows = file.f32("rows", &[Some(grid.points()), Some(3), Some(width)])?;
            let radiance = read_pictures(file, 1, points)?.concat();
            let radiance = radiance.into_iter().map(|c| Rgb::from(c.to_array().map(f64::from))).collect();
            let source = PatchedRectangle { rectangle: points.rectangle, patches: points.patches, radiance };
            Ok(Lamp::Still(RadianceField::sampled(source, grid, order, rows)?))
        }
        ShapeHeader::Sequence { points, pictures, per_second } => {
            let grid = points.grid()?;
            let table = file.f32("patches", &[Some(points.patches()), Some(grid.points()), Some(width)])?;
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
