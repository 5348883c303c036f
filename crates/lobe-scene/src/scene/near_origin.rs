//! Translation of scenes far from the origin to where `f32` is precise.

use std::borrow::Cow;

use crate::{Bounds, Mesh, Scene};

/// A scene is moved along an axis where its center is farther from the origin than this many times half its longest
/// side.
const FAR: f64 = 4.0;

impl Scene {
    /// The scene moved near the origin, if it is far from it, and the vector back to its place, zero along axes along
    /// which it was not moved.
    ///
    /// Numbers of `f32` are coarse far from zero, and so are offsets above a surface relative to the largest
    /// coordinate, such as [`Bvh::offset`](crate::Bvh::offset). To trace rays among the triangles of a scene that may
    /// be anywhere, use those of this one. Its lighting does not depend on its place.
    ///
    /// Nothing is rounded: the center m is a number of `f32`, and all coordinates p along the axis are so near to it
    /// that their difference is one too [Sterbenz 1974],
    ///
    /// ```text
    ///   |m| > 4 e,  |p - m| ≤ e   ⟹   p/2 ≤ m ≤ 2p   ⟹   p - m is exact
    /// ```
    #[must_use]
    pub fn near_origin(&self) -> (Cow<'_, Self>, [f32; 3]) {
        let Bounds { min, max } = self.bounds();
        let longest = (0..3).map(|k| f64::from(max[k]) - f64::from(min[k])).fold(0.0, f64::max);
        let shift = [0, 1, 2].map(|k| {
            let middle = 0.5 * (f64::from(min[k]) + f64::from(max[k]));
            if middle.abs() > FAR * 0.5 * longest { middle as f32 } else { 0.0 }
        });
        if shift == [0.0; 3] {
            return (Cow::Borrowed(self), shift);
        }
        let meshes = self.meshes().iter().map(|mesh| moved_back(mesh, shift)).collect();
        (Cow::Owned(self.with_moved_meshes(meshes)), shift)
    }
}

fn moved_back(mesh: &Mesh, shift: [f32; 3]) -> Mesh {
    mesh.with_positions(|p| [0, 1, 2].map(|k| p[k] - shift[k]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::built_in;

    fn moved(scene: &Scene, by: [f32; 3]) -> Scene {
        let meshes = scene.meshes().iter().map(|mesh| mesh.with_positions(|p| [0, 1, 2].map(|k| p[k] + by[k])));
        scene.with_moved_meshes(meshes.collect())
    }

    #[test]
    fn a_scene_near_its_origin_stays_where_it_is() {
        for name in built_in::NAMES {
            let Some(scene) = built_in::named(name) else { panic!("{name} is a name") };
            let (near, shift) = scene.near_origin();
            assert!(matches!(near, Cow::Borrowed(_)) && shift == [0.0; 3], "{name} was moved by {shift:?}");
        }
    }

    #[test]
    fn a_scene_far_away_is_moved_without_rounding_along_the_axes_it_is_far_along() {
        let scene = built_in::ball_over_ground(16);
        for by in [[1e5, 0.0, 0.0], [-1e5, 1e6, 0.0], [3e4, 7.0, -5e7]] {
            let far = moved(&scene, by);
            let (near, shift) = far.near_origin();
            for k in 0..3 {
                assert_eq!(shift[k] != 0.0, by[k].abs() > 1e3, "axis {k}: {shift:?} for {by:?}");
            }
            for (near, far) in near.meshes().iter().zip(far.meshes()) {
                for (p, q) in near.positions().iter().zip(far.positions()) {
                    let exact = |k: usize| f64::from(q[k]) - f64::from(shift[k]);
                    assert!((0..3).all(|k| f64::from(p[k]) == exact(k)), "{p:?} is not {q:?} less {shift:?}");
                }
                assert_eq!((near.triangles(), near.normals()), (far.triangles(), far.normals()), "the rest, {by:?}");
            }
            let Bounds { min, max } = near.bounds();
            assert!(min.iter().chain(&max).all(|c| c.abs() < 100.0), "{min:?} to {max:?} for {by:?}");
        }
    }
}
