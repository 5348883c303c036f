//! Points all over the triangles of a scene, from which transfer is fitted at its vertices.

use glam::DVec3;
use lobe_scene::{Hit, Scene};

use crate::bake::diffuse::PathStart;
use crate::receivers::inset::wide;
use crate::receivers::planes::plane_of_point;
use crate::receivers::receivers::lift_of;
use crate::sampling::sobol::{Sobol, hash};

/// Paths from a point, at most: their directions fill the hemisphere evenly, and are traced together. In a room with
/// walls of two triangles 8 paths a point leave a fit 1.2 times as noisy at equal rays, and 128 are no better.
const PATHS: u32 = 64;

/// Points in a triangle, at least, if it has any area: one more than a linear function has numbers.
const LEAST_POINTS: u32 = 4;

/// Points among which the paths of a vertex are shared, at least, while there is a path for each.
const POINTS_OF_VERTEX: u32 = 16;

/// A gap that is narrower than this part of the scene's diagonal hides what is in it.
const GAP: f64 = 1.0 / 1024.0;

/// The points of a scene: for each triangle their number.
///
/// ```text
///   paths of triangle t = Σ over its corners v of  N |t| / Σ over the triangles u at v of |u|
/// ```
///
/// N paths of each vertex are so shared by area among the triangles around it; all triangles together have as many as
/// all vertices had. Each point has up to 64 of them.
#[derive(Debug)]
pub(crate) struct SurfacePoints<'a> {
    scene: &'a Scene,
    counts: Vec<u32>,
    /// The part that each triangle has of the area of all.
    areas: Vec<f64>,
    /// Paths from each point.
    pub(crate) paths: u32,
}

/// A point in a triangle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SurfacePoint {
    /// Barycentric coordinates: the weights of the corners.
    pub(crate) weights: [f64; 3],
    pub(crate) position: [f32; 3],
    /// The normal to shade with, without normal maps.
    pub(crate) normal: [f32; 3],
    /// The normal of the triangle on the same side, unless the two are the same.
    pub(crate) plane: Option<[f32; 3]>,
    /// The vector along which rays are lifted off the surface.
    pub(crate) lift: [f32; 3],
}

impl<'a> SurfacePoints<'a> {
    /// The points for `samples` paths from each vertex.
    pub(crate) fn new(scene: &'a Scene, samples: u32) -> Self {
        let most = (samples / POINTS_OF_VERTEX).clamp(1, PATHS);
        let paths = 1 << most.ilog2();
        let mut areas: Vec<f64> = scene.corners().map(area).collect();
        let counts = counts(scene, &areas, f64::from(samples) / f64::from(paths));
        let all: f64 = areas.iter().sum();
        if all > 0.0 {
            areas.iter_mut().for_each(|area| *area /= all);
        }
        Self { scene, counts, areas, paths }
    }

    /// Triangles.
    pub(crate) fn triangles(&self) -> usize {
        self.counts.len()
    }

    /// Points of all triangles.
    pub(crate) fn len(&self) -> usize {
        self.counts.iter().map(|&count| count as usize).sum()
    }

    /// Points in a triangle.
    pub(crate) fn count(&self, triangle: usize) -> u32 {
        self.counts[triangle]
    }

    /// The part that a triangle has of the area of all.
    pub(crate) fn area(&self, triangle: usize) -> f64 {
        self.areas[triangle]
    }

    /// The triangles.
    pub(crate) fn scene(&self) -> &'a Scene {
        self.scene
    }
}

impl SurfacePoint {
    /// The sequences of a triangle for a seed: of its points, taken in an order of its own as those of bounces are, and
    /// of the directions of their paths with `bounces` more.
    pub(crate) fn sequences(scene: &Scene, seed: u64, triangle: usize, bounces: usize) -> [Sobol; 2] {
        const OF_POINTS: u64 = 0x0050_4F49_4E54;
        let (mesh, number) = scene.locate(triangle);
        let mesh = &scene.meshes()[mesh];
        let corners = mesh.triangles()[number].map(|i| i as usize);
        let place = || corners.into_iter().flat_map(|i| mesh.positions()[i].into_iter().chain(mesh.normals()[i]));
        [Sobol::at_place(hash([seed, OF_POINTS]), place(), 1), Sobol::at_place(seed, place(), bounces)]
    }

    /// Point number `index` of a triangle, by the sequence of its points.
    pub(crate) fn new(scene: &Scene, triangle: usize, index: u32, sequence: &Sobol) -> Self {
        let [u, v] = in_triangle(sequence.point(index, 1));
        let surface = scene.surface(&Hit { t: 0.0, triangle: triangle as u32, u, v });
        let normal = surface.vertex_normal;
        let plane = plane_of_point(normal, normal, surface.geometric_normal);
        let lift = lift_of(normal, plane.as_slice());
        let [u, v] = [u, v].map(f64::from);
        Self { weights: [1.0 - u - v, u, v], position: surface.position, normal, plane, lift }
    }

    /// The start of its paths, from number `first` of the sequences on, as if it were white.
    pub(crate) fn start<'a>(&'a self, sobol: &'a Sobol, first: u32) -> PathStart<'a> {
        let Self { position, normal, lift, plane, .. } = self;
        let planes = plane.as_slice();
        PathStart { position: *position, normal: *normal, lift: *lift, planes, albedo: [1.0; 3], sobol, first }
    }
}

/// A point of the unit square, moved into the triangle below its diagonal: the two halves of the square above and below
/// the other diagonal are each pressed into a half of the triangle, so that neighbors stay neighbors [Heitz 2019].
fn in_triangle([x, y]: [f32; 2]) -> [f32; 2] {
    if y > x { [0.5 * x, y - 0.5 * x] } else { [x - 0.5 * y, 0.5 * y] }
}

/// The width of gaps that hide what is in them.
pub(crate) fn gap(scene: &Scene) -> f32 {
    let bounds = scene.bounds();
    (wide(bounds.max).distance(wide(bounds.min)) * GAP) as f32
}

pub(crate) fn area(corners: [[f32; 3]; 3]) -> f64 {
    let [a, b, c]: [DVec3; 3] = corners.map(wide);
    0.5 * (b - a).cross(c - a).length()
}

/// The number of points in each triangle, of `share` points for each vertex.
fn counts(scene: &Scene, areas: &[f64], share: f64) -> Vec<u32> {
    let mut counts = Vec::with_capacity(areas.len());
    let mut rest = areas;
    for mesh in scene.meshes() {
        let (own, others) = rest.split_at(mesh.triangles().len());
        rest = others;
        let mut around = vec![0.0; mesh.positions().len()];
        for (triangle, area) in mesh.triangles().iter().zip(own) {
            triangle.iter().for_each(|&v| around[v as usize] += area);
        }
        counts.extend(mesh.triangles().iter().zip(own).map(|(triangle, &area)| {
            let of_corners: f64 = triangle.iter().map(|&v| area / around[v as usize]).sum();
            if area > 0.0 { ((share * of_corners).round() as u32).max(LEAST_POINTS) } else { 0 }
        }));
    }
    counts
}

#[cfg(test)]
mod tests {
    use super::*;
    use lobe_scene::built_in;

    #[test]
    fn triangles_have_as_many_paths_as_vertices_had() {
        let scene = built_in::ball_over_ground(24);
        for samples in [256, 1024, 4096] {
            let points = SurfacePoints::new(&scene, samples);
            let [found, expected] = [points.len() * points.paths as usize, scene.vertex_count() * samples as usize];
            // Whole numbers of points, of four and more.
            assert!((found as f64 / expected as f64 - 1.0).abs() < 0.05, "{found} paths, {expected} at vertices");
        }
    }

    #[test]
    fn points_fill_a_triangle_evenly() {
        let sobol = Sobol::new(3, 0);
        let (mut count, mut mean) = ([0; 4], [0.0; 2]);
        for index in 0..1024 {
            let [u, v] = in_triangle(sobol.point(index, 0));
            assert!(u >= 0.0 && v >= 0.0 && u + v <= 1.0, "({u}, {v}) in the triangle");
            [mean[0], mean[1]] = [mean[0] + f64::from(u) / 1024.0, mean[1] + f64::from(v) / 1024.0];
            // The four similar triangles within.
            let within = [u > 0.5, v > 0.5, u + v < 0.5].iter().position(|&is| is).unwrap_or(3);
            count[within] += 1;
        }
        // Evenly distributed points miss a quarter by a few; 1024 random ones by 14.
        assert!(count.iter().all(|&c: &i32| (c - 256).abs() < 14), "{count:?}");
        assert!(mean.iter().all(|m| (m - 1.0 / 3.0).abs() < 2e-3), "{mean:?}");
    }
}
