//! Solids by formula.

use std::f64::consts::TAU;

use lobe_scene::{Mesh, MeshParts, Scene};
use lobe_shadow::Solid;

pub(crate) type Triangle = [[f32; 3]; 3];

/// The cube from -half to half, 12 triangles facing outwards, cut at the same diagonals on all sides.
pub(crate) fn cube(half: f32) -> Vec<Triangle> {
    let mut triangles = Vec::new();
    for axis in 0..3 {
        for side in [-half, half] {
            let corner = |u: f32, v: f32| {
                let mut p = [0.0; 3];
                (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) = (side, u * half, v * half);
                p
            };
            let [a, b, c, d] = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
            triangles.extend(if side > 0.0 { [[a, b, c], [a, c, d]] } else { [[a, c, b], [a, d, c]] });
        }
    }
    triangles
}

/// A torus about the z axis, of radii 1 and 0.3.
pub(crate) fn torus(around: u32, across: u32) -> Vec<Triangle> {
    let at = |i: u32, j: u32| {
        let (u, v) = (TAU * f64::from(i % around) / f64::from(around), TAU * f64::from(j % across) / f64::from(across));
        let r = 1.0 + 0.3 * v.cos();
        [r * u.cos(), r * u.sin(), 0.3 * v.sin()].map(|x| x as f32)
    };
    let cells = (0..around).flat_map(|i| (0..across).map(move |j| (i, j)));
    cells
        .flat_map(|(i, j)| {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            [[a, b, c], [a, c, d]]
        })
        .collect()
}

/// A star of five prongs, neither convex nor smooth.
pub(crate) fn star() -> Vec<Triangle> {
    let ring = |i: u32| {
        let (sin, cos) = (TAU * f64::from(i % 10) / 10.0).sin_cos();
        let r = if i.is_multiple_of(2) { 1.0 } else { 0.4 };
        [(r * cos) as f32, (r * sin) as f32, 0.0]
    };
    let tips = [[0.0, 0.0, 0.3], [0.0, 0.0, -0.3]];
    (0..10).flat_map(|i| [[tips[0], ring(i), ring(i + 1)], [tips[1], ring(i + 1), ring(i)]]).collect()
}

pub(crate) fn solid(triangles: &[Triangle]) -> Solid {
    Solid::new(triangles.iter().copied()).unwrap()
}

/// Every triangle with three vertices of its own.
pub(crate) fn scene(triangles: &[Triangle]) -> Scene {
    let positions = triangles.as_flattened().to_vec();
    let triangles = (0..triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    let mesh = Mesh::new(MeshParts { positions, triangles, ..MeshParts::default() }).unwrap();
    Scene::new(vec![mesh], Vec::new(), Vec::new()).unwrap()
}

/// Triangles at one place share a vertex.
pub(crate) fn welded(triangles: &[Triangle]) -> Scene {
    let mut positions: Vec<[f32; 3]> = Vec::new();
    let mut vertex = |p: [f32; 3]| {
        positions.iter().position(|q| *q == p).unwrap_or_else(|| {
            positions.push(p);
            positions.len() - 1
        }) as u32
    };
    let triangles = triangles.iter().map(|triangle| triangle.map(&mut vertex)).collect();
    let mesh = Mesh::new(MeshParts { positions, triangles, ..MeshParts::default() }).unwrap();
    Scene::new(vec![mesh], Vec::new(), Vec::new()).unwrap()
}
