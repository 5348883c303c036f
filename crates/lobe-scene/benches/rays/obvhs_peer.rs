//! Comparison with the traversal of obvhs itself, in the form its documentation recommends for speed.

use std::time::Duration;

use glam::Vec3A;
use obvhs::BvhBuildParams;
use obvhs::cwbvh::{CwBvh, builder::build_cwbvh_from_tris};
use obvhs::ray::Ray;
use obvhs::triangle::Triangle;

/// Its compressed eight-wide tree, the triangles in the tree's order.
pub(crate) struct Obvhs {
    bvh: CwBvh,
    triangles: Vec<Triangle>,
}

impl Obvhs {
    pub(crate) fn new(corners: &[[[f32; 3]; 3]]) -> Self {
        let as_obvhs =
            |[a, b, c]: &[[f32; 3]; 3]| Triangle { v0: Vec3A::from(*a), v1: Vec3A::from(*b), v2: Vec3A::from(*c) };
        let triangles: Vec<Triangle> = corners.iter().map(as_obvhs).collect();
        let bvh = build_cwbvh_from_tris(&triangles, BvhBuildParams::slow_build(), &mut Duration::default());
        let triangles = bvh.primitive_indices.iter().map(|&i| triangles[i as usize]).collect();
        Self { bvh, triangles }
    }

    /// The number of occluded rays: `ray_traverse_miss` stops at the first hit.
    pub(crate) fn occluded(&self, origin: [f32; 3], directions: &[[f32; 3]]) -> usize {
        let is_occluded = |d: &&[f32; 3]| {
            let ray = Ray::new_inf(Vec3A::from(origin), Vec3A::from(**d));
            !self.bvh.ray_traverse_miss(ray, |ray, id| self.triangles[id].intersect(ray))
        };
        directions.iter().filter(is_occluded).count()
    }
}
