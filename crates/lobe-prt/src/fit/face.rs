//! A side of a triangle, and the points on it.

use lobe_scene::{Hit, Scene};

use crate::bake::point_transfer::PathStart;
use crate::receivers::planes::plane_of_point;
use crate::receivers::receivers::lift_of;
use crate::sampling::sobol::{Sobol, hash};

/// A side of surfaces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Side {
    /// That of the normals.
    Front,
    Back,
}

impl Side {
    fn turned(self, vector: [f32; 3]) -> [f32; 3] {
        match self {
            Self::Front => vector,
            Self::Back => vector.map(|c| -c),
        }
    }
}

/// A side of a triangle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Face<'a> {
    scene: &'a Scene,
    triangle: usize,
    side: Side,
}

impl<'a> Face<'a> {
    pub(crate) fn new(scene: &'a Scene, triangle: usize, side: Side) -> Self {
        Self { scene, triangle, side }
    }

    /// The corners.
    pub(crate) fn corners(&self) -> [[f32; 3]; 3] {
        let (mesh, number) = self.scene.locate(self.triangle);
        self.scene.meshes()[mesh].corners(number)
    }

    /// The sequences for a seed: of its points, taken in an order of its own as those of bounces are, and of the
    /// directions of their paths with `bounces` more.
    pub(crate) fn sequences(&self, seed: u64, bounces: usize) -> [Sobol; 2] {
        const OF_POINTS: u64 = 0x0050_4F49_4E54;
        let (mesh, number) = self.scene.locate(self.triangle);
        let mesh = &self.scene.meshes()[mesh];
        let corners = mesh.triangles()[number].map(|i| i as usize);
        let at = |i: usize| mesh.positions()[i].into_iter().chain(self.side.turned(mesh.normals()[i]));
        let place = || corners.into_iter().flat_map(at);
        [Sobol::at_place(hash([seed, OF_POINTS]), place(), 1), Sobol::at_place(seed, place(), bounces)]
    }

    /// Point number `index`, by the sequence of its points.
    pub(crate) fn point(&self, index: u32, sequence: &Sobol) -> SurfacePoint {
        let [u, v] = in_triangle(sequence.point(index, 1));
        let surface = self.scene.surface(&Hit { t: 0.0, triangle: self.triangle as u32, u, v });
        let normal = self.side.turned(surface.vertex_normal);
        let plane = plane_of_point(normal, normal, surface.geometric_normal);
        let lift = lift_of(normal, plane.as_slice());
        let [u, v] = [u, v].map(f64::from);
        SurfacePoint { weights: [1.0 - u - v, u, v], position: surface.position, normal, plane, lift }
    }
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

impl SurfacePoint {
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

#[cfg(test)]
mod tests {
    use super::*;

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
