//! A still life: a knot, a polished ball and two colored screens on a round ground.

use std::f64::consts::TAU;

use glam::DVec3;

use crate::built_in::shapes::{Shape, scene};
use crate::scene::material::Material;
use crate::scene::scene::Scene;

/// The radius of the ground.
const GROUND: f64 = 4.5;

/// Meters for one unit of the curve of the knot, and the radius of its tube.
const KNOT_SCALE: f64 = 0.42;
const TUBE: f64 = 0.25;

/// The height of the middle of the knot.
const KNOT_HEIGHT: f64 = 1.6;

/// The inner and the outer radius of the screens, and their height.
const SCREEN: [f64; 2] = [2.75, 2.9];
const SCREEN_HEIGHT: f64 = 2.6;

/// The directions in which the wall and the fins begin and end, in turns counter-clockwise from +x.
const WALL: [f64; 2] = [0.13, 0.36];
const FINS: [f64; 2] = [0.42, 0.66];

/// How many fins stand on their arc, and how thick each is.
const FIN_COUNT: usize = 11;
const FIN: f64 = 0.09;

/// A still life: what light does to shapes, in one picture.
///
/// ```text
///   knot    the trefoil c(t) = (sin t + 2 sin 2t, sin 3t, cos t - 2 cos 2t), 0.42 m for a unit, in a tube of radius 0.25 about
///           (0, 0, 1.6): it shadows itself deeply
///   wall    a piece of a cylinder about the z axis, 2.6 high, red: it colors what stands before it
///   fins    eleven upright plates on an arc, blue green: between them light comes in stripes
///   ball    radius 0.5, at (1.25, -1.35, 0.5), gold; its material is smooth
///   ground  a disc of radius 4.5 at z = 0, gray
/// ```
///
/// The ground has `cells` × `cells` cells, the knot `2 cells` vertices along it and `cells / 2` around it, the others as many to
/// the meter.
///
/// # Panics
/// If `cells` is below 16.
#[must_use]
pub fn still_life(cells: usize) -> Scene {
    assert!(cells >= 16, "{cells} cells, expected at least 16");
    let mut ball = Shape::default();
    ball.ball(DVec3::new(1.25, -1.35, 0.5), 0.5, cells / 2);
    // α = roughness² = 0.3: about the sharpest reflection that four bands hold.
    let gold = Material { metallic: 1.0, roughness: 0.55, ..Material::matte("gold", [0.9, 0.62, 0.2]) };
    let parts = [
        (ground(cells), Material::matte("ground", [0.62, 0.6, 0.57])),
        (knot(cells), Material::matte("knot", [0.82, 0.79, 0.72])),
        (wall(cells), Material::matte("wall", [0.75, 0.13, 0.07])),
        (fins(cells), Material::matte("fins", [0.06, 0.42, 0.5])),
        (ball, gold),
    ];
    let meshes = ["ground", "knot", "wall", "fins", "ball"];
    let (shapes, materials): (Vec<Shape>, Vec<Material>) = parts.into_iter().unzip();
    let meshes = shapes.into_iter().zip(meshes).enumerate().map(|(k, (shape, name))| shape.into_mesh(name, k));
    scene(meshes.collect(), materials)
}

/// A disc: a square under the map (x √(1 - y²/2), y √(1 - x²/2)), whose cells keep an area everywhere.
fn ground(cells: usize) -> Shape {
    let mut ground = Shape::default();
    ground.surface((cells, cells), |u, v| {
        // Short of the corners, where the map has none.
        let [x, y] = [u, v].map(|c| 0.985 * (2.0 * c - 1.0));
        let disc = DVec3::new(x * (1.0 - 0.5 * y * y).sqrt(), y * (1.0 - 0.5 * x * x).sqrt(), 0.0);
        (GROUND * disc, DVec3::Z)
    });
    ground
}

/// A tube about the trefoil, along its normal and its binormal.
fn knot(cells: usize) -> Shape {
    let mut knot = Shape::default();
    knot.surface((2 * cells, cells / 2), |u, v| {
        let t = TAU * u;
        let ((sin, cos), (sin2, cos2), (sin3, cos3)) = (t.sin_cos(), (2.0 * t).sin_cos(), (3.0 * t).sin_cos());
        let middle = DVec3::new(sin + 2.0 * sin2, sin3, cos - 2.0 * cos2);
        let first = DVec3::new(cos + 4.0 * cos2, 3.0 * cos3, -sin + 4.0 * sin2);
        let second = DVec3::new(-sin - 8.0 * sin2, -9.0 * sin3, -cos + 8.0 * cos2);
        let along = first.normalize();
        let binormal = first.cross(second).normalize();
        let (sin_v, cos_v) = (TAU * v).sin_cos();
        let normal = cos_v * binormal.cross(along) - sin_v * binormal;
        (DVec3::Z * KNOT_HEIGHT + KNOT_SCALE * middle + TUBE * normal, normal)
    });
    knot
}

/// Cells on a length in meters, as dense as those of the ground.
fn cells_on(length: f64, cells: usize) -> usize {
    (0.5 * length * cells as f64 / GROUND).ceil() as usize
}

/// The wall: its inner and outer face, its top and its two ends.
fn wall(cells: usize) -> Shape {
    let [from, to] = WALL.map(|turn| TAU * turn);
    let around = cells_on((to - from) * SCREEN[1], cells);
    let up = cells_on(SCREEN_HEIGHT, cells);
    let at = |angle: f64| DVec3::new(angle.cos(), angle.sin(), 0.0);
    let top = DVec3::Z * SCREEN_HEIGHT;
    let mut wall = Shape::default();
    wall.surface((around, up), |u, v| {
        let outwards = at(from + (to - from) * u);
        (SCREEN[1] * outwards + v * top, outwards)
    });
    wall.surface((around, up), |u, v| {
        let outwards = at(to + (from - to) * u);
        (SCREEN[0] * outwards + v * top, -outwards)
    });
    wall.surface((2, around), |u, v| {
        let outwards = at(from + (to - from) * v);
        ((SCREEN[0] + (SCREEN[1] - SCREEN[0]) * u) * outwards + top, DVec3::Z)
    });
    let thick = SCREEN[1] - SCREEN[0];
    wall.parallelogram(at(from) * SCREEN[0], [at(from) * thick, top], (2, up));
    wall.parallelogram(at(to) * SCREEN[1], [at(to) * -thick, top], (2, up));
    wall
}

/// The fins: plates that point at the axis.
fn fins(cells: usize) -> Shape {
    let mut fins = Shape::default();
    let (deep, up) = (cells_on(0.6, cells).max(2), cells_on(SCREEN_HEIGHT, cells));
    for k in 0..FIN_COUNT {
        let angle = TAU * (FINS[0] + (FINS[1] - FINS[0]) * k as f64 / (FIN_COUNT - 1) as f64);
        let outwards = DVec3::new(angle.cos(), angle.sin(), 0.0);
        let across = DVec3::Z.cross(outwards);
        let corner = SCREEN[0] * outwards - 0.5 * FIN * across;
        let (depth, width, height) = (0.6 * outwards, FIN * across, SCREEN_HEIGHT * DVec3::Z);
        fins.parallelogram(corner, [depth, height], (deep, up));
        fins.parallelogram(corner + width + depth, [-depth, height], (deep, up));
        fins.parallelogram(corner + width, [-width, height], (1, up));
        fins.parallelogram(corner + depth, [width, height], (1, up));
        fins.parallelogram(corner + height, [depth, width], (deep, 1));
    }
    fins
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tube_of_the_knot_nowhere_meets_itself_or_the_ground() {
        let knot = knot(64);
        let mesh = knot.into_mesh("knot", 0);
        let points: Vec<DVec3> = mesh.positions().iter().map(|p| DVec3::from(p.map(f64::from))).collect();
        let lowest = points.iter().map(|p| p.z).fold(f64::INFINITY, f64::min);
        assert!(lowest > 0.0, "{lowest}");
        // Middles of the tube at places far apart along it are farther from each other than two radii.
        let (along, around) = (129, 33);
        let middle = |i: usize| {
            let ring = (0..around - 1).map(|j| points[j * along + i]);
            ring.sum::<DVec3>() / (around - 1) as f64
        };
        let middles: Vec<DVec3> = (0..along - 1).map(middle).collect();
        let count = middles.len();
        for i in 0..count {
            for j in 0..count {
                let apart = i.abs_diff(j).min(count - i.abs_diff(j));
                if apart > count / 8 {
                    let distance = (middles[i] - middles[j]).length();
                    assert!(distance > 2.0 * TUBE, "{i} and {j}: {distance}");
                }
            }
        }
    }
}
