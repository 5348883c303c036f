//! Primitive shapes for the built-in scenes.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use crate::scene::material::Material;
use crate::scene::mesh::{Mesh, MeshParts};
use crate::scene::scene::Scene;
use crate::scene::vertex_normals::angle_weighted_normals;

/// The margin on each side of an unwrapped surface in its square: two texels of a lightmap 128 texels wide.
const GAP: f64 = 1.0 / 16.0;

/// Triangles under construction.
#[derive(Clone, Debug, Default)]
pub(crate) struct Shape {
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
    /// The surface of each vertex and its position on it; complete only if every vertex lies on a surface.
    charts: Vec<(usize, [f64; 2])>,
    surfaces: usize,
}

impl Shape {
    fn vertex(&mut self, position: DVec3, normal: DVec3) -> u32 {
        self.positions.push(position.as_vec3().into());
        self.normals.push(normal.as_vec3().into());
        (self.positions.len() - 1) as u32
    }

    /// The number of surfaces added.
    pub(crate) fn surfaces(&self) -> usize {
        self.surfaces
    }

    /// A parallelogram of `cells.0` × `cells.1` cells from `corner` along `a` and `b`, facing `a × b`.
    pub(crate) fn parallelogram(&mut self, corner: DVec3, [a, b]: [DVec3; 2], cells: (usize, usize)) {
        self.surface(cells, |u, v| (corner + a * u + b * v, a.cross(b).normalize()));
    }

    /// The image of the unit square under `at`, which gives position and normal at (u, v), in `cells.0` × `cells.1`
    /// cells. Triangles are counter-clockwise seen from the side of ∂u × ∂v.
    pub(crate) fn surface(&mut self, cells: (usize, usize), at: impl Fn(f64, f64) -> (DVec3, DVec3)) {
        let first = self.positions.len() as u32;
        let (m, n) = cells;
        for j in 0..=n {
            for i in 0..=m {
                let place = [i as f64 / m as f64, j as f64 / n as f64];
                let (position, normal) = at(place[0], place[1]);
                self.vertex(position, normal);
                self.charts.push((self.surfaces, place));
            }
        }
        self.surfaces += 1;
        let index = |i: usize, j: usize| first + (j * (m + 1) + i) as u32;
        for j in 0..n {
            for i in 0..m {
                let [a, b, c, d] = [index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1)];
                // Diagonals alternate, so that no direction is preferred.
                if (i + j) % 2 == 0 {
                    self.triangles.extend([[a, b, c], [a, c, d]]);
                } else {
                    self.triangles.extend([[a, b, d], [b, c, d]]);
                }
            }
        }
    }

    /// A box from `min` to `max` of `cells` cells along each edge, facing outwards. Faces share no vertices.
    pub(crate) fn cuboid(&mut self, min: DVec3, max: DVec3, cells: [usize; 3]) {
        for axis in 0..3 {
            let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
            let along = |k: usize| DVec3::AXES[k] * (max[k] - min[k]);
            self.parallelogram(min, [along(j), along(i)], (cells[j], cells[i]));
            self.parallelogram(min + along(axis), [along(i), along(j)], (cells[i], cells[j]));
        }
    }

    /// A ball with `around` vertices on its equator and `around / 2` bands from pole to pole, its vertices shared.
    pub(crate) fn ball(&mut self, center: DVec3, radius: f64, around: usize) {
        let bands = around / 2;
        self.closed((around, bands), |j, i| {
            let (sin_t, cos_t) = (PI * j as f64 / bands as f64).sin_cos();
            let (sin_p, cos_p) = (TAU * i as f64 / around as f64).sin_cos();
            let n = match j {
                0 => DVec3::Z,
                _ if j == bands => -DVec3::Z,
                _ => DVec3::new(sin_t * cos_p, sin_t * sin_p, cos_t),
            };
            (center + n * radius, n)
        });
    }

    /// A closed surface like a globe: a pole, `bands - 1` rings of `around` vertices, and the other pole. `at` gives
    /// position and normal by the number of the ring, 0 and `bands` for the poles, and the number within it;
    /// rings run counter-clockwise seen from the first pole.
    pub(crate) fn closed(&mut self, (around, bands): (usize, usize), at: impl Fn(usize, usize) -> (DVec3, DVec3)) {
        let first = self.positions.len() as u32;
        let ring = |j: usize, i: usize| first + 1 + ((j - 1) * around + i % around) as u32;
        let south = first + 1 + ((bands - 1) * around) as u32;
        let mut vertex = |j: usize, i: usize| {
            let (position, normal) = at(j, i);
            self.vertex(position, normal);
        };
        vertex(0, 0);
        for j in 1..bands {
            (0..around).for_each(|i| vertex(j, i));
        }
        vertex(bands, 0);
        for i in 0..around {
            self.triangles.push([first, ring(1, i), ring(1, i + 1)]);
            for j in 1..bands - 1 {
                let [a, b, c, d] = [ring(j, i), ring(j + 1, i), ring(j + 1, i + 1), ring(j, i + 1)];
                self.triangles.extend([[a, b, c], [a, c, d]]);
            }
            self.triangles.push([south, ring(bands - 1, i + 1), ring(bands - 1, i)]);
        }
    }

    /// The side of an upright column on `foot`, `around` × `up` cells, its vertices shared, open above and below.
    pub(crate) fn column(&mut self, foot: DVec3, radius: f64, height: f64, (around, up): (usize, usize)) {
        let first = self.positions.len() as u32;
        for j in 0..=up {
            for i in 0..around {
                let (sin, cos) = (TAU * i as f64 / around as f64).sin_cos();
                let n = DVec3::new(cos, sin, 0.0);
                self.vertex(foot + n * radius + DVec3::Z * (height * j as f64 / up as f64), n);
            }
        }
        let index = |i: usize, j: usize| first + (j * around + i % around) as u32;
        for j in 0..up {
            for i in 0..around {
                let [a, b, c, d] = [index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1)];
                self.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
    }

    /// Flips the orientation of all triangles and normals.
    pub(crate) fn inside_out(mut self) -> Self {
        self.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        self.normals.iter_mut().for_each(|n| *n = n.map(|c| -c));
        self
    }

    /// Removes the triangles whose center is in `hole`.
    pub(crate) fn without(mut self, hole: impl Fn(DVec3) -> bool) -> Self {
        let positions = &self.positions;
        let center =
            |t: &[u32; 3]| t.iter().map(|&i| DVec3::from(positions[i as usize].map(f64::from))).sum::<DVec3>() / 3.0;
        self.triangles.retain(|t| !hole(center(t)));
        self
    }

    /// Moves every vertex, and recomputes the normals.
    pub(crate) fn moved(mut self, to: impl Fn(DVec3) -> DVec3) -> Self {
        for p in &mut self.positions {
            *p = to(DVec3::from(p.map(f64::from))).as_vec3().into();
        }
        self.normals = angle_weighted_normals(&self.positions, &self.triangles);
        self
    }

    /// Removes unused vertices and keeps the order of the others.
    fn compacted(self) -> Self {
        let mut place = vec![u32::MAX; self.positions.len()];
        self.triangles.as_flattened().iter().for_each(|&i| place[i as usize] = 0);
        let mut compact = Self::default();
        for (i, place) in place.iter_mut().enumerate().filter(|(_, place)| **place == 0) {
            *place = compact.positions.len() as u32;
            compact.positions.push(self.positions[i]);
            compact.normals.push(self.normals[i]);
            compact.charts.extend(self.charts.get(i));
        }
        compact.triangles = self.triangles.iter().map(|t| t.map(|i| place[i as usize])).collect();
        compact
    }

    /// The mesh of a shape with triangles.
    ///
    /// # Panics
    /// If it has none, or its numbers are not finite.
    pub(crate) fn into_mesh(self, name: &str, material: usize) -> Mesh {
        let shape = self.compacted();
        mesh(shape.into_parts(name, material))
    }

    /// The mesh of a shape of surfaces only, each unwrapped onto a square of its own of an atlas of `columns` ×
    /// `columns` squares, from square `first` on: no two points share texture coordinates.
    pub(crate) fn into_unfolded_mesh(self, name: &str, material: usize, first: usize, columns: usize) -> Mesh {
        let shape = self.compacted();
        let uv = |&(surface, place): &(usize, [f64; 2])| {
            let square = first + surface;
            let corner = [square % columns, square / columns].map(|k| k as f64);
            [0, 1].map(|k| ((corner[k] + GAP + (1.0 - 2.0 * GAP) * place[k]) / columns as f64) as f32)
        };
        let uvs = [shape.charts.iter().map(uv).collect(), Vec::new()];
        mesh(MeshParts { uvs, ..shape.into_parts(name, material) })
    }

    fn into_parts(self, name: &str, material: usize) -> MeshParts {
        let Self { positions, normals, triangles, .. } = self;
        MeshParts { name: name.into(), positions, normals, triangles, material: Some(material), ..MeshParts::default() }
    }
}

fn mesh(parts: MeshParts) -> Mesh {
    match Mesh::new(parts) {
        Ok(mesh) => mesh,
        Err(error) => unreachable!("the shapes of built-in scenes are meshes: {error}"),
    }
}

/// The scene of meshes with all their materials.
pub(crate) fn scene(meshes: Vec<Mesh>, materials: Vec<Material>) -> Scene {
    match Scene::new(meshes, materials, Vec::new()) {
        Ok(scene) => scene,
        Err(error) => unreachable!("built-in scenes name only materials that they have: {error}"),
    }
}
