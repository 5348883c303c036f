//! Lamps as safetensors: `NAME.lamp.safetensors`.

use std::fs;
use std::path::Path;

use lobe_io::{Numbers, Tensor, TensorFile, TensorFormat, write_tensors};
use lobe_sh::Rgb;
use serde::{Deserialize, Serialize};

use crate::field::axial::Axial;
use crate::field::field_file::{GridHeader, check_order};
use crate::field::radiance_field::Shape;
use crate::{Lamp, LampSequence, PatchField, RadianceField, ShadowError};

#[derive(Serialize, Deserialize)]
struct LampHeader {
    order: usize,
    #[serde(flatten)]
    shape: ShapeHeader,
}

#[derive(Serialize, Deserialize)]
#[serde(tag = "shape", rename_all = "lowercase")]
enum ShapeHeader {
    Ball { center: [f64; 3], radius: f64, radiance: [f64; 3] },
    Sampled { grid: GridHeader },
    Sequence { grid: GridHeader, patches: [usize; 2], pictures: usize, per_second: f64 },
}

const FORMAT: TensorFormat = TensorFormat { name: "lobe-lamp", version: 1, if_older: "make the lamp anew" };

/// Writes a lamp; until all is written nothing has the file's name.
///
/// The metadata's entry `lobe` is JSON: format `lobe-lamp`, version 1, order n, and by `shape`:
///
/// | shape | members | tensors of `F32` |
/// |---|---|---|
/// | `ball` | center, radius, radiance | none |
/// | `sampled` | grid: the numbers of a [`FieldGrid`](crate::FieldGrid) | `rows` of `[points, 3, n + n²]` |
/// | `sequence` | grid, patches along rows and columns, pictures, `per_second` | `patches` of `[patches, points, n + n²]`, `radiance` of `[pictures, patches, 3]` |
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
            Shape::Sampled { grid, rows, .. } => {
                let rows = Tensor::new("rows", [grid.points(), 3, width], Numbers::F32(rows));
                write(ShapeHeader::Sampled { grid: GridHeader::new(grid) }, &[rows])
            }
        },
        Lamp::Sequence(sequence) => {
            let (field, pictures) = (sequence.patches(), sequence.pictures());
            let [columns, rows] = field.patches();
            let radiance: Vec<f32> = pictures.iter().flatten().flat_map(|c| c.to_array()).collect();
            let shape = ShapeHeader::Sequence {
                grid: GridHeader::new(field.grid()),
                patches: field.patches(),
                pictures: pictures.len(),
                per_second: sequence.per_second(),
            };
            let patches = [columns * rows, field.grid().points(), width];
            let tensors = [
                Tensor::new("patches", patches, Numbers::F32(field.table())),
                Tensor::new("radiance", [pictures.len(), columns * rows, 3], Numbers::F32(&radiance)),
            ];
            write(shape, &tensors)
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
    let place = path.display().to_string();
    let bytes = fs::read(path).map_err(|source| ShadowError::Io { place: place.clone(), source })?;
    read_lamp_bytes(&bytes, &place)
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
        ShapeHeader::Sampled { grid } => {
            let grid = grid.grid()?;
            grid.check_bytes(3 * width)?;
            let rows = file.f32("rows", &[Some(grid.points()), Some(3), Some(width)])?;
            Ok(Lamp::Still(RadianceField::sampled(grid, order, rows)?))
        }
        ShapeHeader::Sequence { grid, patches, pictures, per_second } => {
            let grid = grid.grid()?;
            let count = patches[0].saturating_mul(patches[1]);
            let table = file.f32("patches", &[Some(count), Some(grid.points()), Some(width)])?;
            let field = PatchField::from_table(grid, order, *patches, table)?;
            let radiance = file.f32("radiance", &[Some(*pictures), Some(count), Some(3)])?;
            let colors = |picture: &[f32]| picture.as_chunks().0.iter().map(|c: &[f32; 3]| Rgb::from(*c)).collect();
            let pictures = radiance.chunks_exact(3 * count).map(colors).collect();
            Ok(Lamp::Sequence(LampSequence::new(field, pictures, *per_second)?))
        }
    }
}
