//! Points all over the triangles of a scene, from which transfer is fitted at its vertices.

use glam::DVec3;
use lobe_scene::Scene;

use crate::fit::face::Face;
use crate::fit::fitted_vertices::FittedVertices;
use crate::receivers::inset::wide;

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
    fitted: &'a FittedVertices<'a>,
    counts: Vec<u32>,
    /// The part that each triangle has of the area of all.
    areas: Vec<f64>,
    /// Paths from each point.
    pub(crate) paths: u32,
}

impl<'a> SurfacePoints<'a> {
    /// Those of the same triangles for another number of paths from each vertex.
    pub(crate) fn of_samples(&self, samples: u32) -> Self {
        Self::new(self.fitted, samples)
    }

    /// The points for `samples` paths from each vertex.
    pub(crate) fn new(fitted: &'a FittedVertices<'a>, samples: u32) -> Self {
        let most = (samples / POINTS_OF_VERTEX).clamp(1, PATHS);
        let paths = 1 << most.ilog2();
        let mut areas: Vec<f64> = (0..fitted.corners().len()).map(|k| area(fitted.face(k).corners())).collect();
        let counts = counts(fitted, &areas, f64::from(samples) / f64::from(paths));
        let all: f64 = areas.iter().sum();
        if all > 0.0 {
            areas.iter_mut().for_each(|area| *area /= all);
        }
        Self { fitted, counts, areas, paths }
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

    /// A triangle.
    pub(crate) fn face(&self, triangle: usize) -> Face<'a> {
        self.fitted.face(triangle)
    }
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
fn counts(fitted: &FittedVertices<'_>, areas: &[f64], share: f64) -> Vec<u32> {
    let mut around = vec![0.0; fitted.scene().vertex_count()];
    for (corners, area) in fitted.corners().iter().zip(areas) {
        corners.iter().for_each(|&vertex| around[vertex as usize] += area);
    }
    let count = |(corners, &area): (&[u32; 3], &f64)| {
        let of_corners: f64 = corners.iter().map(|&vertex| area / around[vertex as usize]).sum();
        if area > 0.0 { ((share * of_corners).round() as u32).max(LEAST_POINTS) } else { 0 }
    };
    fitted.corners().iter().zip(areas).map(count).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use lobe_scene::built_in;

    #[test]
    fn triangles_have_as_many_paths_as_vertices_had() {
        let scene = built_in::ball_over_ground(24);
        let fitted = FittedVertices::all(&scene).unwrap();
        for samples in [256, 1024, 4096] {
            let points = SurfacePoints::new(&fitted, samples);
            let [found, expected] = [points.len() * points.paths as usize, scene.vertex_count() * samples as usize];
            // Whole numbers of points, of four and more.
            assert!((found as f64 / expected as f64 - 1.0).abs() < 0.05, "{found} paths, {expected} at vertices");
        }
    }
}
