//! Translation of meshes far from the origin to where `f32` is precise.

use crate::scene::mesh::Mesh;

/// A scene is moved along an axis where its center is farther from the origin than this many times half its longest
/// side.
const FAR: f64 = 4.0;

/// A coordinate may be rounded by this part of half of all edges: their directions change by a milliradian, and the
/// digits that dense scans have beyond `f32` stay far below it.
const NOTICEABLE: f64 = 1e-3;

/// The center of a box along the axes along which it is far from the origin; zero along the others.
pub(crate) fn far_center(min: [f64; 3], max: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| {
        let middle = 0.5 * (min[k] + max[k]);
        if middle.abs() > reach(min, max) { middle } else { 0.0 }
    })
}

/// The distance from the center of a box up to which a point is near it.
pub(crate) fn reach(min: [f64; 3], max: [f64; 3]) -> f64 {
    FAR * 0.5 * (0..3).map(|k| max[k] - min[k]).fold(0.0, f64::max)
}

/// The point from which points of `f64` are to count before they become numbers of `f32`.
///
/// It is the center of their box, rounded to `f32`, along each axis on which they are far from the origin. It is zero
/// along the others.
///
/// Points that are numbers of `f32` already come out as [`near_origin`] leaves them.
pub(crate) fn origin_of(points: impl Iterator<Item = [f64; 3]>) -> [f64; 3] {
    let (mut min, mut max) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for p in points {
        (min, max) = ([0, 1, 2].map(|k| min[k].min(p[k])), [0, 1, 2].map(|k| max[k].max(p[k])));
    }
    if min.iter().chain(&max).all(|c| c.is_finite()) {
        far_center(min, max).map(|c| f64::from(c as f32))
    } else {
        [0.0; 3]
    }
}

/// A point of `f64` as it counts from an origin.
pub(crate) fn from_origin(p: [f64; 3], origin: [f64; 3]) -> [f32; 3] {
    [0, 1, 2].map(|k| (p[k] - origin[k]) as f32)
}

/// The largest change of a coordinate by [`from_origin`], if it is noticeable next to the edges of the faces, which are
/// given by the numbers of their points; numbers that no point has are left out.
pub(crate) fn noticeable_rounding(
    points: &[[f64; 3]],
    edges: impl Iterator<Item = [usize; 2]>,
    origin: [f64; 3],
) -> Option<f64> {
    let moved = |p: &[f64; 3]| {
        let rounded = from_origin(*p, origin);
        (0..3).map(|k| (p[k] - origin[k] - f64::from(rounded[k])).abs()).fold(0.0, f64::max)
    };
    let (mut most, mut lengths) = (0.0_f64, Vec::new());
    for [a, b] in edges {
        let (Some(a), Some(b)) = (points.get(a), points.get(b)) else { continue };
        most = most.max(moved(a)).max(moved(b));
        let length = (0..3).map(|k| (a[k] - b[k]).abs()).fold(0.0, f64::max);
        lengths.extend((length > 0.0).then_some(length));
    }
    let middle = lengths.len() / 2;
    let edge = (!lengths.is_empty()).then(|| *lengths.select_nth_unstable_by(middle, f64::total_cmp).1)?;
    (most > NOTICEABLE * edge).then_some(most)
}

/// The note of a rounding.
pub(crate) fn note_of_rounding(rounding: f64) -> String {
    format!(
        "coordinates are rounded by up to {rounding:.1e}: they are too far apart for their digits; \
         leave out what stands far from the rest"
    )
}

/// The meshes of a box moved near the origin, if it is far from it, and the vector back to their place, zero along axes
/// along which they were not moved.
///
/// Numbers of `f32` are coarse far from zero, and so are offsets above a surface relative to the largest coordinate,
/// such as [`Bvh::offset`](crate::Bvh::offset).
///
/// Nothing is rounded: the center m is a number of `f32`, and all coordinates p along the axis are so near to it that
/// their difference is one too [Sterbenz 1974],
///
/// ```text
///   |m| > 4 e,  |p - m| ≤ e   ⟹   p/2 ≤ m ≤ 2p   ⟹   p - m is exact
/// ```
pub(crate) fn near_origin(meshes: Vec<Mesh>, min: [f32; 3], max: [f32; 3]) -> (Vec<Mesh>, [f64; 3]) {
    let [min, max] = [min, max].map(|corner| corner.map(f64::from));
    let shift = far_center(min, max).map(|c| c as f32);
    if shift == [0.0; 3] {
        return (meshes, [0.0; 3]);
    }
    let back = |mesh: Mesh| mesh.with_positions(|p| [0, 1, 2].map(|k| p[k] - shift[k]));
    (meshes.into_iter().map(back).collect(), shift.map(f64::from))
}

#[cfg(test)]
mod tests {
    use crate::built_in;
    use crate::scene::scene::{Bounds, Scene};

    fn moved(scene: &Scene, by: [f32; 3]) -> Scene {
        let (meshes, materials, textures) = scene.clone().into_parts();
        let meshes = meshes.into_iter().map(|mesh| mesh.with_positions(|p| [0, 1, 2].map(|k| p[k] + by[k])));
        Scene::new(meshes.collect(), materials, textures).unwrap()
    }

    #[test]
    fn a_scene_near_its_origin_stays_where_it_is() {
        for name in built_in::NAMES {
            let Some(scene) = built_in::named(name) else { panic!("{name} is a name") };
            assert_eq!(scene.origin(), [0.0; 3], "{name} was moved");
        }
    }

    #[test]
    fn a_scene_far_away_is_moved_without_rounding_along_the_axes_it_is_far_along() {
        let scene = built_in::ball_over_ground(16);
        for by in [[1e5, 0.0, 0.0], [-1e5, 1e6, 0.0], [3e4, 7.0, -5e7]] {
            let near = moved(&scene, by);
            let shift = near.origin();
            for k in 0..3 {
                assert_eq!(shift[k] != 0.0, by[k].abs() > 1e3, "axis {k}: {shift:?} for {by:?}");
            }
            for (near, here) in near.meshes().iter().zip(scene.meshes()) {
                for (p, q) in near.positions().iter().zip(here.positions()) {
                    let exact = |k: usize| f64::from(q[k] + by[k]) - shift[k];
                    assert!((0..3).all(|k| f64::from(p[k]) == exact(k)), "{p:?} is not {q:?} + {by:?} less {shift:?}");
                }
                assert_eq!((near.triangles(), near.normals()), (here.triangles(), here.normals()), "the rest, {by:?}");
            }
            let [low, high] = near.world_bounds();
            assert!((0..3).all(|k| low[k] <= f64::from(by[k]) && f64::from(by[k]) <= high[k]), "{low:?} to {high:?}");
            let Bounds { min, max } = near.bounds();
            assert!(min.iter().chain(&max).all(|c| c.abs() < 100.0), "{min:?} to {max:?} for {by:?}");
        }
    }
}
