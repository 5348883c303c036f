//! Cave scene with openings.

use glam::DVec3;

use crate::built_in::shapes::{Shape, scene};
use crate::{Material, Scene};

/// Half the length, width and height of the cave.
const RADII: DVec3 = DVec3::new(6.0, 4.0, 3.0);

/// The amplitude of its walls' roughness.
const ROUGHNESS: f64 = 0.35;

/// A cave: an ellipsoid of half axes 6, 4 and 3 about (0, 0, 1), its walls rough by 0.35, its floor flat at z = -0.5.
///
/// It opens towards +x, where the walls within 28° of the axis are left out, and to the sky within 16° of the direction
/// (-0.5, 0.2, 1). Its surface faces inwards and is seen from both sides; `cells` vertices go around, `cells / 2` bands
/// from top to bottom. Its albedo is (0.55, 0.45, 0.35).
///
/// # Panics
/// If `cells` is below 16.
#[must_use]
pub fn cave(cells: usize) -> Scene {
    assert!(cells >= 16, "{cells} cells, expected at least 16");
    let mut ball = Shape::default();
    ball.ball(DVec3::ZERO, 1.0, cells);
    let (gate, light) = (DVec3::X, DVec3::new(-0.5, 0.2, 1.0).normalize());
    let is_open = |p: DVec3| {
        let s = p.normalize();
        s.dot(gate) > 28_f64.to_radians().cos() || s.dot(light) > 16_f64.to_radians().cos()
    };
    let cave = ball.inside_out().without(is_open).moved(|p| wall(p.normalize()));
    scene(vec![cave.into_mesh("cave", 0)], vec![Material::matte("rock", [0.55, 0.45, 0.35])])
}

/// The wall in the direction `s` from the middle: waves of three lengths, and the floor.
fn wall(s: DVec3) -> DVec3 {
    let wave = |f: f64, a: DVec3| (f * s.dot(a)).sin();
    let rough = 0.5 * wave(5.0, DVec3::new(0.6, -0.5, 0.8)) * wave(4.0, DVec3::new(-0.7, 0.9, 0.3))
        + 0.3 * wave(11.0, DVec3::new(0.2, 0.9, -0.6)) * wave(9.0, DVec3::new(0.9, 0.1, 0.5))
        + 0.2 * wave(23.0, DVec3::new(-0.8, 0.4, 0.5));
    let p = s * RADII * (1.0 + ROUGHNESS * rough / 3.0) + DVec3::Z;
    // Below the floor the wall is flattened to a hundredth, which keeps its triangles' areas positive.
    let floor = -0.5;
    if p.z < floor { DVec3::new(p.x, p.y, floor + 0.01 * (p.z - floor)) } else { p }
}
