//! Silhouettes: the pixels of a picture in which surfaces end, and those that show a back through a gap.

use lobe_sh::sphere::vector::{dot, sub};
use lobe_sh::{Coefficient as _, Rgb};

/// The number of a surface where a ray meets none.
const NOTHING: u32 = u32::MAX;

/// The cosine of the angle between normals beyond which two points lie on both sides of a crease: 12°, beyond what
/// surfaces that look smooth turn from pixel to pixel.
const CREASE: f32 = 0.978;

/// The sine of the angle between a plane and the way to another point beyond which that does not lie on the same
/// surface: 30°.
const STEP: f32 = 0.5;

/// The part of the rays of five by five pixels that may be lost in a gap: that of a gap of two pixels, and rounding.
/// The back of a wall, of which the pixel in the middle shows a straight edge, takes more.
const GAP: f32 = 0.401;

/// What a ray from the eye meets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Met {
    /// The mesh and its side.
    surface: u32,
    position: [f32; 3],
    normal: [f32; 3],
}

impl Met {
    pub(crate) const NOTHING: Self = Self { surface: NOTHING, position: [0.0; 3], normal: [0.0; 3] };

    /// A point of a side of a mesh, and its unit normal, without that of a normal map.
    pub(crate) fn new(mesh: usize, is_front: bool, position: [f32; 3], normal: [f32; 3]) -> Self {
        // Two meshes far apart in the list may share a number; then only their places tell them apart.
        Self { surface: (2 * mesh as u32 + u32::from(is_front)) & !(1 << 31), position, normal }
    }

    /// Whether a surface ends between two rays: they meet others, or the surface has a crease or a step between.
    pub(crate) fn is_apart(&self, other: &Self) -> bool {
        if self.surface != other.surface {
            return true;
        }
        if self.surface == NOTHING {
            return false;
        }
        let way = sub(other.position.map(f64::from), self.position.map(f64::from));
        let limit = f64::from(STEP) * dot(way, way).sqrt();
        let leaves = |normal: [f32; 3]| dot(way, normal.map(f64::from)).abs() > limit;
        dot(self.normal.map(f64::from), other.normal.map(f64::from)) < f64::from(CREASE)
            || leaves(self.normal)
            || leaves(other.normal)
    }
}

/// A pixel as the mean over its rays.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sampled {
    /// The light of all rays, of which those that meet unlit backs have none.
    pub(crate) light: Rgb<f32>,
    /// The part of the rays that stop at surfaces.
    pub(crate) coverage: f32,
    /// The part of the rays that meet unlit backs.
    pub(crate) backs: f32,
    /// What the first ray meets.
    pub(crate) met: Met,
    /// Whether a surface ends between the rays.
    pub(crate) is_edge: bool,
}

/// A pixel to sample again.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Again {
    pub(crate) pixel: usize,
    /// The light of the neighbors, for a pixel that shows nothing but a gap; none where backs that are seen are no gap.
    pub(crate) gap: Option<Rgb<f32>>,
}

/// The pixels of a picture of `width` columns to sample again, in rising order: in which, or between which and a
/// neighbor, a surface ends.
pub(crate) fn silhouettes(pixels: &[Sampled], width: usize) -> Vec<Again> {
    let height = pixels.len() / width;
    let at = |x: usize, y: usize| &pixels[y * width + x];
    let ends_at = |x: usize, y: usize| {
        let own = at(x, y);
        own.is_edge
            || (x > 0 && own.met.is_apart(&at(x - 1, y).met))
            || (y > 0 && own.met.is_apart(&at(x, y - 1).met))
            || (x + 1 < width && own.met.is_apart(&at(x + 1, y).met))
            || (y + 1 < height && own.met.is_apart(&at(x, y + 1).met))
    };
    let pixel = |i: usize| {
        let (x, y) = (i % width, i / width);
        ends_at(x, y).then(|| Again { pixel: i, gap: gap(pixels, [width, height], [x, y]) })
    };
    (0..pixels.len()).filter_map(pixel).collect()
}

/// The light of the nearest surfaces that are lit, for the rays of a pixel that meet a back, if they are few around it:
/// the first look may have missed a narrow gap.
fn gap(pixels: &[Sampled], size: [usize; 2], at: [usize; 2]) -> Option<Rgb<f32>> {
    let (backs, count) = around(pixels, size, at, 2).fold((0.0, 0.0), |(sum, n), p| (sum + p.backs, n + 1.0));
    if backs > GAP * count {
        return None;
    }
    let lit = |distance: usize| {
        let lit = around(pixels, size, at, distance).filter(|p| p.backs == 0.0 && p.met.surface != NOTHING);
        let (light, count) = lit.fold((Rgb::splat(0.0), 0.0), |(sum, n), p| (sum + p.light, n + 1.0));
        (count > 0.0).then(|| light.scale(1.0 / count))
    };
    lit(1).or_else(|| lit(2))
}

/// The pixels of a square, up to `distance` columns and rows away.
fn around(
    pixels: &[Sampled],
    [width, height]: [usize; 2],
    [x, y]: [usize; 2],
    distance: usize,
) -> impl Iterator<Item = &Sampled> {
    let columns = x.saturating_sub(distance)..(x + distance + 1).min(width);
    let rows = y.saturating_sub(distance)..(y + distance + 1).min(height);
    rows.flat_map(move |j| pixels[j * width..][columns.clone()].iter())
}

/// The place of ray `k` of `count`, a power of two, within a pixel, in each coordinate from 0 to 1: a net of
/// Hammersley's points, one in each of `count` columns and in each of `count` rows.
///
/// ```text
///   x = (k + ½)/count        y = (the bits of k reversed + ½)/count
/// ```
pub(crate) fn place_in_pixel(k: usize, count: usize) -> [f64; 2] {
    let reversed = if count > 1 { k.reverse_bits() >> (usize::BITS - count.trailing_zeros()) } else { 0 };
    [k, reversed].map(|k| (k as f64 + 0.5) / count as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn on(mesh: usize, position: [f32; 3]) -> Met {
        Met::new(mesh, true, position, [0.0, 0.0, 1.0])
    }

    fn sampled(met: Met, backs: f32) -> Sampled {
        let light = if backs > 0.0 { Rgb::ZERO } else { Rgb::splat(1.0) };
        Sampled { light, coverage: 1.0, backs, met, is_edge: false }
    }

    #[test]
    fn a_surface_ends_where_another_begins_or_it_has_a_crease_or_a_step() {
        let here = on(3, [0.0; 3]);
        for (what, other, expected) in [
            ("the same plane", on(3, [5.0, 1.0, 0.0]), false),
            ("a gentle slope", on(3, [5.0, 1.0, 1.0]), false),
            ("a step", on(3, [0.1, 0.0, 1.0]), true),
            ("another mesh", on(4, [0.1, 0.0, 0.0]), true),
            ("the other side", Met::new(3, false, [0.1, 0.0, 0.0], [0.0, 0.0, 1.0]), true),
            ("a crease", Met::new(3, true, [0.1, 0.0, 0.0], [0.0, 0.6, 0.8]), true),
            ("nothing", Met::NOTHING, true),
            ("the same place", here, false),
        ] {
            assert_eq!(here.is_apart(&other), expected, "{what}");
            assert_eq!(other.is_apart(&here), expected, "{what}, the other way");
        }
        assert!(!Met::NOTHING.is_apart(&Met::NOTHING), "nothing beside nothing");
    }

    #[test]
    fn pixels_on_both_sides_of_an_edge_are_sampled_again_and_no_others() {
        let pixels: Vec<Sampled> = (0..6 * 4)
            .map(|i| sampled(if i % 6 < 3 { on(0, [0.1 * (i % 6) as f32, 0.0, 0.0]) } else { Met::NOTHING }, 0.0))
            .collect();
        let again = silhouettes(&pixels, 6);
        let expected: Vec<usize> = (0..4).flat_map(|y| [6 * y + 2, 6 * y + 3]).collect();
        assert_eq!(again.iter().map(|again| again.pixel).collect::<Vec<_>>(), expected, "pixels");
        assert!(again.iter().all(|again| again.gap == Some(Rgb::splat(1.0))), "the light beside it: {again:?}");
    }

    #[test]
    fn a_gap_is_at_most_two_pixels_wide_and_the_back_of_a_wall_is_none() {
        for (width, is_gap) in [(1, true), (2, true), (3, false), (5, false)] {
            let pixels: Vec<Sampled> = (0..11 * 7)
                .map(|i| {
                    let is_back = (3..3 + width).contains(&(i % 11));
                    let met = Met::new(usize::from(is_back), !is_back, [0.0; 3], [0.0, 0.0, 1.0]);
                    sampled(met, if is_back { 1.0 } else { 0.0 })
                })
                .collect();
            let again = silhouettes(&pixels, 11);
            let inside: Vec<_> = again.iter().filter(|again| pixels[again.pixel].backs > 0.0).collect();
            assert!(!inside.is_empty(), "{width}");
            for again in inside {
                let expected = is_gap.then(|| Rgb::splat(1.0));
                assert_eq!(again.gap, expected, "{width} columns of backs, pixel {}", again.pixel);
            }
        }
    }

    #[test]
    fn rays_lie_one_in_each_column_and_one_in_each_row() {
        for count in [1_usize, 2, 4, 16, 64] {
            let places: Vec<[f64; 2]> = (0..count).map(|k| place_in_pixel(k, count)).collect();
            for axis in 0..2 {
                let mut strata: Vec<usize> = places.iter().map(|p| (p[axis] * count as f64) as usize).collect();
                strata.sort_unstable();
                assert_eq!(strata, (0..count).collect::<Vec<_>>(), "{count} rays along axis {axis}");
            }
        }
    }
}
