//! Hall of columns.

use glam::DVec3;

use crate::built_in::shapes::{Shape, scene};
use crate::{Material, Scene};

/// A hall: a floor of 8 × 14 × 0.25 below z = 0, two rows of five columns, and a roof of 7 × 13 × 0.5 on them.
///
/// Columns are 4 high, of radius 0.4, at x = ±2 and y = -5, -2.5, 0, 2.5, 5. Floor and roof have `detail` cells to the
/// meter, columns `2 detail` to the meter up and `8 detail` around. Floor (0.55, 0.5, 0.45), columns (0.75, 0.72,
/// 0.65), roof (0.5, 0.3, 0.2).
///
/// # Panics
/// If `detail` is zero.
#[must_use]
pub fn columns_hall(detail: usize) -> Scene {
    assert!(detail > 0, "no detail");
    let (mut floor, mut columns, mut roof) = (Shape::default(), Shape::default(), Shape::default());
    let thin = detail.div_ceil(4);
    floor.cuboid(DVec3::new(-4.0, -7.0, -0.25), DVec3::new(4.0, 7.0, 0.0), [8 * detail, 14 * detail, thin]);
    roof.cuboid(DVec3::new(-3.5, -6.5, 4.0), DVec3::new(3.5, 6.5, 4.5), [7 * detail, 13 * detail, thin]);
    for x in [-2.0, 2.0] {
        for y in [-5.0, -2.5, 0.0, 2.5, 5.0] {
            columns.column(DVec3::new(x, y, 0.0), 0.4, 4.0, (8 * detail, 8 * detail));
        }
    }
    let meshes = vec![floor.into_mesh("floor", 0), columns.into_mesh("columns", 1), roof.into_mesh("roof", 2)];
    let materials = vec![
        Material::matte("floor", [0.55, 0.5, 0.45]),
        Material::matte("columns", [0.75, 0.72, 0.65]),
        Material::matte("roof", [0.5, 0.3, 0.2]),
    ];
    scene(meshes, materials)
}
