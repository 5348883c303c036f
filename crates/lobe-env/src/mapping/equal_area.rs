//! Equal-area octahedral mapping: folded like the octahedral one, and every texel has the same solid angle.
//!
//! ```text
//!   z >= 0:  r = √(1 - |z|)    φ' = (2/π) atan(|y|/|x|)    |a| = r (1 - φ')    |b| = r φ'
//!   z < 0:   (|a|, |b|) -> (1 - |b|, 1 - |a|)
//!   signs of a and b as of x and y      u = (1 + a)/2      v = (1 + b)/2
//! ```
//!
//! The unfolded figure is that of [`octahedral`](crate::octahedral): +z in the middle, +x on the right, +y below, -z in
//! the corners, sides folded in their middle. `dΩ = 4π du dv` everywhere.
//!
//! Clarberg 2008. The orientation is that of pbrt's square environment maps.

use std::f64::consts::{FRAC_PI_4, PI};

use lobe_sh::Dir;

use crate::mapping::form::{Form, Obstacle, Pair, Rule};
use crate::mapping::octahedral::{CORNERS, add_folded_nodes, folded_taps, sign};
use crate::mapping::taps::Taps;

/// The direction of the point `(u, v)` of the picture; both are clamped to `[0, 1]`.
///
/// ```
/// use lobe_env::equal_area::dir_from_uv;
/// use lobe_sh::Dir;
///
/// assert_eq!(dir_from_uv(0.5, 0.5), Dir::Z);
/// assert!(dir_from_uv(1.0, 0.5).angle_to(Dir::X) < 1e-15);
/// assert!(dir_from_uv(0.75, 0.75).angle_to(Dir::from_angles(1.0, 0.7853981633974483)) < 0.6);
/// ```
#[must_use]
pub fn dir_from_uv(u: f64, v: f64) -> Dir {
    let (a, b) = ((2.0 * u - 1.0).clamp(-1.0, 1.0), (2.0 * v - 1.0).clamp(-1.0, 1.0));
    // The distance from the diamond |a| + |b| = 1, the horizon.
    let d = 1.0 - (a.abs() + b.abs());
    let r = 1.0 - d.abs();
    let turn = if r > 0.0 { (b.abs() - a.abs()) / r + 1.0 } else { 1.0 };
    let (sin, cos) = (FRAC_PI_4 * turn).sin_cos();
    let horizontal = r * (2.0 - r * r).max(0.0).sqrt();
    let z = (1.0 - r * r) * if d < 0.0 { -1.0 } else { 1.0 };
    Dir::from_unit([sign(a) * cos * horizontal, sign(b) * sin * horizontal, z])
}

/// The point `(u, v)` of the picture in the direction `s`; on the fold below -z the side of positive x or y.
#[must_use]
pub fn uv_from_dir(s: Dir) -> (f64, f64) {
    let horizontal = s.x().hypot(s.y());
    // 1 - |z| without cancellation.
    let r = horizontal / (1.0 + s.z().abs()).sqrt();
    let b = r * s.y().abs().atan2(s.x().abs()) / (2.0 * FRAC_PI_4);
    let a = r - b;
    let (a, b) = if s.z() < 0.0 { (1.0 - b, 1.0 - a) } else { (a, b) };
    (0.5 + 0.5 * a * sign(s.x()), 0.5 + 0.5 * b * sign(s.y()))
}

/// The solid angle in steradian of every texel of a picture of `width` x `height` texels: `4π/(w h)`.
#[must_use]
pub fn solid_angle(width: usize, height: usize) -> f64 {
    4.0 * PI / (width as f64 * height as f64)
}

/// The mapping to the unfolded octahedron in equal areas.
pub(crate) struct EqualArea;

impl Form for EqualArea {
    fn name(&self) -> &'static str {
        "equal-area"
    }

    fn description(&self) -> &'static str {
        "The octahedron, unfolded so that all texels have the same solid angle"
    }

    fn dir_from_uv(&self, u: f64, v: f64) -> Option<Dir> {
        Some(dir_from_uv(u, v))
    }

    fn uv_from_dir(&self, s: Dir) -> (f64, f64) {
        uv_from_dir(s)
    }

    fn solid_angle(&self, [width, height]: Pair, _texel: Pair) -> f64 {
        solid_angle(width, height)
    }

    fn density(&self, _u: f64, _v: f64) -> f64 {
        4.0 * PI
    }

    fn density_towards(&self, _s: Dir) -> f64 {
        4.0 * PI
    }

    fn axes_again(&self) -> &'static [(&'static str, [f64; 2])] {
        &CORNERS
    }

    fn taps(&self, size: Pair, p: [f64; 2]) -> Taps {
        folded_taps(size, p)
    }

    fn add_nodes(&self, size: Pair, texel: Pair, [rule, _]: [&Rule; 2], out: &mut Vec<(Dir, f64)>) {
        add_folded_nodes(self, size, texel, rule, out);
    }

    fn obstacle(&self, size: Pair, texel: Pair) -> Option<Obstacle> {
        Some(Obstacle::Singularity(pole_distance(size, texel)))
    }

    /// That of a texel beside the one with the pole in its middle.
    fn worst_obstacle(&self, [width, height]: Pair) -> Option<Obstacle> {
        let (w, h) = (width as f64, height as f64);
        Some(Obstacle::Singularity(1.0 + (w / h).min(h / w)))
    }
}

// The azimuth is π/2 |b|/(|a| + |b|), a and b from a pole: singular where |a| = -|b|, as far beyond the axis as the node
// in b is on this side of it. A texel with the pole in its corner is summed along rays, and across them is singular as
// the texel beside it is.

/// The least distance of the singularity at a pole from the middle of texel `(x, y)` of an equal-area picture, in halves
/// of the texel along either side.
fn pole_distance([width, height]: Pair, [x, y]: Pair) -> f64 {
    let stretch = width as f64 / height as f64;
    // The columns and rows between a texel and the pole.
    let halves = |[i, j]: [f64; 2]| {
        let aside = if i + j > 0.0 { (i + j * stretch).min(j + i / stretch) } else { stretch.min(1.0 / stretch) };
        1.0 + 2.0 * aside
    };
    let from_middle = |i: usize, n: usize| (0.5 * (2 * i + 1).abs_diff(n) as f64 - 0.5).max(0.0);
    let from_corner = |i: usize, n: usize| i.min(n - 1 - i) as f64;
    let (middle, corner) =
        ([from_middle(x, width), from_middle(y, height)], [from_corner(x, width), from_corner(y, height)]);
    halves(middle).min(halves(corner))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quarter_squares_hold_their_part_of_the_sphere() {
        // Points uniform in the square are uniform on the sphere: a fifth of them has z > 0.6.
        let n = 500;
        let at = |i: usize| (i as f64 + 0.5) / n as f64;
        let count = (0..n * n).filter(|i| dir_from_uv(at(i % n), at(i / n)).z() > 0.6).count();
        let share = count as f64 / (n * n) as f64;
        assert!((share - 0.2).abs() < 1e-3, "{share}");
        let east = (0..n * n).filter(|i| dir_from_uv(at(i % n), at(i / n)).x() > 0.6).count() as f64 / (n * n) as f64;
        assert!((east - 0.2).abs() < 1e-3, "{east}");
    }

    #[test]
    fn the_horizon_is_the_diamond() {
        for t in [0.0, 0.2, 0.5, 0.9, 1.0] {
            let s = dir_from_uv(0.5 + 0.5 * t, 0.5 + 0.5 * (1.0 - t));
            assert!(s.z().abs() < 1e-15 && s.x() >= 0.0 && s.y() >= 0.0, "{t}: {s:?}");
        }
    }
}
