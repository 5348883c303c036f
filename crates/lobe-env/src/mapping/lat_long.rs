//! Lat-long (equirectangular) mapping: longitude across, latitude down.
//!
//! ```text
//!   u = 0 .. 1 from the left edge to the right      φ = π (1 - 2u)
//!   v = 0 .. 1 from the top edge to the bottom      θ = π v
//!
//!          u = 0      1/4      1/2      3/4       1
//!   v = 0   +----------------- +z -----------------+
//!     1/2  -x         +y       +x       -y        -x
//!   v = 1   +----------------- -z -----------------+
//! ```
//!
//! A photograph seen from inside: right of the center, +x, lies -y. Texel `(x, y)` of a picture of `w` columns and
//! `h` rows covers `[x, x+1]/w × [y, y+1]/h`; its center is at `(x + 1/2, y + 1/2)`.

use std::f64::consts::{FRAC_1_PI, PI};

use lobe_sh::Dir;

use crate::mapping::fast_atan::fast_atan2;
use crate::mapping::form::{Form, Pair};
use crate::mapping::taps::Taps;

/// The direction of the point `(u, v)` of the picture.
///
/// `u` may be any finite number: it wraps around. `v` is clamped to `[0, 1]`. Exact on the axes: `v = 0` and `v = 1`
/// are the poles whatever `u` is.
///
/// ```
/// use lobe_env::lat_long::dir_from_uv;
/// use lobe_sh::Dir;
///
/// assert_eq!(dir_from_uv(0.5, 0.5), Dir::X);
/// assert_eq!(dir_from_uv(0.25, 0.5), Dir::Y);
/// assert_eq!(dir_from_uv(0.8, 0.0), Dir::Z);
/// ```
#[must_use]
pub fn dir_from_uv(u: f64, v: f64) -> Dir {
    let (sin_theta, cos_theta) = sin_cos_pi(v.clamp(0.0, 1.0));
    let (sin_phi, cos_phi) = sin_cos_pi(1.0 - 2.0 * (u - u.floor()));
    Dir::from_unit([sin_theta * cos_phi, sin_theta * sin_phi, cos_theta])
}

/// The point `(u, v)` of the picture in the direction `s`, `u` in `[0, 1)`, `v` in `[0, 1]`; `u = 1/2` at the poles.
#[must_use]
pub fn uv_from_dir(s: Dir) -> (f64, f64) {
    // Remove the sign of zero: φ is 0 at both poles, and π on the whole seam.
    let u = 0.5 - 0.5 * FRAC_1_PI * (s.y() + 0.0).atan2(s.x() + 0.0);
    // Rounding may reach 1 from below.
    (if u < 1.0 { u } else { 0.0 }, (FRAC_1_PI * s.theta()).min(1.0))
}

/// The solid angle in steradian of any texel in row `y` of a picture of `width` columns and `height` rows.
///
/// ```text
///   Ω = (2π/w) (cos θ_y - cos θ_{y+1}) = (4π/w) sin(π/2h) sin(π (y + 1/2)/h)      θ_y = π y/h
/// ```
///
/// The second form keeps all digits at the poles. Over all texels the sum is `4π` (test
/// `solid_angles_sum_to_the_whole_sphere`).
///
/// # Panics
/// If `y >= height` or `width` is 0.
#[must_use]
pub fn solid_angle(width: usize, height: usize, y: usize) -> f64 {
    assert!(y < height && width > 0, "no row {y} in a picture of {width} x {height}");
    // The mirrored row has the same value; of the two, the upper one has the smaller rounding error.
    let upper = y.min(height - 1 - y);
    let middle = sin_cos_pi((upper as f64 + 0.5) / height as f64).0;
    4.0 * PI / width as f64 * sin_cos_pi(0.5 / height as f64).0 * middle
}

/// `(sin πt, cos πt)`, exact where either is 0, 1 or -1.
///
/// The nearest multiple of a quarter turn is taken out before `π` comes in; that subtraction is exact.
pub(crate) fn sin_cos_pi(t: f64) -> (f64, f64) {
    let quarters = (2.0 * t).round();
    let (sin, cos) = (PI * (t - 0.5 * quarters)).sin_cos();
    match quarters.rem_euclid(4.0) as u8 {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    }
}

// Plain bilinear interpolation in θ gives the rows of a lat-long picture wrong solid angles: 8 % too much for the first
// row, since between its center and the next one the sphere widens. Between the centers of two rows, at
// θ = m + (t - 1/2) δ with m the edge between them and δ = π/h, the weight 1 - t of the upper row is therefore bent to
//
//     g(t) = 1 - t - β t (1 - t)      with β such that   ∫_0^1 g(t) sin θ dt = ∫_0^{1/2} sin θ dt
//
// so that either row has its own half of the strip, and each row, with the strip at the pole, its solid angle. With
// x = θ - m, sin θ = sin m cos x + cos m sin x and 1 - t = 1/2 - x/δ, all integrals are elementary:
//
//     β = cot m · ((1 - cos δ/2) - I₁)/(δ K)              I₁ = ∫ x sin x dt = (2/δ)(sin δ/2 - δ/2 cos δ/2)
//     K = ∫ t(1-t) cos x dt = sin(δ/2)/(2δ) - J/δ²        J = ∫ x² cos x dt = (2/δ)(δ²/4 sin δ/2 + δ cos δ/2 - 2 sin δ/2)
//
// which is cot(m) δ/4 + O(δ³): 1/4 at the first edge, a hundredth of it 100 rows on. In place of g, the fraction t is
// bent: t + β t (1 - t).

/// Up to this height of a row, in radians, β is approximated by its first term: the error is below `SMALL_STRIP²`, and
/// the closed form loses as much to cancellation.
const SMALL_STRIP: f64 = 1e-3;

/// The mapping to lat-long pictures.
pub(crate) struct LatLong;

impl Form for LatLong {
    fn name(&self) -> &'static str {
        "lat-long"
    }

    fn description(&self) -> &'static str {
        "Longitude across, latitude down (Blinn and Newell)"
    }

    fn dir_from_uv(&self, u: f64, v: f64) -> Option<Dir> {
        Some(dir_from_uv(u, v))
    }

    fn uv_from_dir(&self, s: Dir) -> (f64, f64) {
        uv_from_dir(s)
    }

    fn fast_uv_from_dir(&self, s: Dir) -> (f64, f64) {
        let (x, y) = (s.x(), s.y());
        let u = 0.5 - 0.5 * FRAC_1_PI * fast_atan2(y, x);
        (u, FRAC_1_PI * fast_atan2((x * x + y * y).sqrt(), s.z()))
    }

    fn solid_angle(&self, [width, height]: Pair, [_, y]: Pair) -> f64 {
        solid_angle(width, height, y)
    }

    fn density(&self, _u: f64, v: f64) -> f64 {
        2.0 * PI * PI * sin_cos_pi(v).0
    }

    fn density_towards(&self, s: Dir) -> f64 {
        2.0 * PI * PI * (s.x() * s.x() + s.y() * s.y()).sqrt()
    }

    fn aspect(&self) -> Pair {
        [2, 1]
    }

    fn is_told_by(&self, [width, height]: Pair) -> bool {
        width == 2 * height
    }

    fn has_rows_of_latitude(&self) -> bool {
        true
    }

    fn axes_again(&self) -> &'static [(&'static str, [f64; 2])] {
        &[("-x", [0.0, 0.5]), ("-x", [1.0, 0.5])]
    }

    fn lengths(&self, [width, height]: Pair, _middle: [f64; 2], center: Dir) -> [f64; 2] {
        [2.0 * PI * (1.0 / width as f64) * center.x().hypot(center.y()), PI * (1.0 / height as f64)]
    }

    /// Above 1 towards the poles.
    fn texels_across(&self, height: usize, y: f64) -> f64 {
        1.0 / (PI * y / height as f64).sin().max(1.0 / height as f64)
    }

    fn bend(&self, height: usize, row: f64) -> f64 {
        bend_factor(height) * cotangent(height, row)
    }

    /// Columns wrap around; beyond the first and the last row comes the same row, half a turn further.
    fn taps(&self, [width, height]: Pair, [x, y]: [f64; 2]) -> Taps {
        let (column, row) = (x - 0.5, y - 0.5);
        let (left, above) = (column.floor(), row.floor());
        let (s, t) = ((column - left) as f32, (row - above) as f32);
        let mut taps = Taps::NONE;
        if left >= 0.0 && above >= 0.0 && left + 1.0 < width as f64 && above + 1.0 < height as f64 {
            let first = above as usize * width + left as usize;
            let last = first + width;
            return Taps::of_four(first, last, [s, t]);
        }
        let last = height as f64 - 1.0;
        for (y, weight) in [(above, 1.0 - t), (above + 1.0, t)] {
            let across = if y < 0.0 || y > last { 0.5 * width as f64 } else { 0.0 };
            let start = y.clamp(0.0, last) as usize * width;
            let column = column + across;
            let left = column.floor();
            let s = (column - left) as f32;
            let left = left.rem_euclid(width as f64) as usize % width;
            let right = if left + 1 == width { 0 } else { left + 1 };
            taps.push(start + left, (1.0 - s) * weight);
            taps.push(start + right, s * weight);
        }
        taps
    }
}

/// `cot θ` at the lower edge of a row, 0 beyond the first and the last one.
fn cotangent(height: usize, row: f64) -> f64 {
    if row < 0.0 || row + 1.0 >= height as f64 {
        return 0.0;
    }
    let (sin, cos) = sin_cos_pi((row + 1.0) / height as f64);
    cos / sin
}

/// The bend of a strip over its [`cotangent`].
fn bend_factor(height: usize) -> f64 {
    let d = PI / height as f64;
    let (sin, cos) = (0.5 * d).sin_cos();
    if d < SMALL_STRIP {
        return 0.25 * d;
    }
    let i1 = 2.0 / d * (sin - 0.5 * d * cos);
    let x2 = 2.0 / d * (0.25 * d * d * sin + d * cos - 2.0 * sin);
    let k = 0.5 * sin / d - x2 / (d * d);
    ((1.0 - cos) - i1) / (d * k)
}

#[cfg(test)]
mod tests {
    use lobe_testkit::directions;

    use super::*;

    fn dir(v: [f64; 3]) -> Dir {
        Dir::new(v).unwrap()
    }

    #[test]
    fn the_axes_lie_where_the_figure_says() {
        let cases = [
            (0.0, 0.5, -Dir::X),
            (0.25, 0.5, Dir::Y),
            (0.5, 0.5, Dir::X),
            (0.75, 0.5, -Dir::Y),
            (1.0, 0.5, -Dir::X),
            (0.3, 0.0, Dir::Z),
            (0.3, 1.0, -Dir::Z),
        ];
        for (u, v, expected) in cases {
            let s = dir_from_uv(u, v);
            assert_eq!(s.to_array().map(|c| c + 0.0), expected.to_array().map(|c| c + 0.0), "u {u}, v {v}");
        }
    }

    #[test]
    fn mapping_and_inverse_agree_over_the_whole_sphere() {
        for v in directions() {
            let s = dir(v);
            let (u, v) = uv_from_dir(s);
            assert!((0.0..1.0).contains(&u) && (0.0..=1.0).contains(&v), "{s:?} is at ({u}, {v})");
            let back = dir_from_uv(u, v);
            assert!(s.angle_to(back) < 1e-15 * 4.0, "{s:?} came back as {back:?}");
        }
    }

    #[test]
    fn both_sides_of_the_seam_are_the_left_edge() {
        for y in [0.0, -0.0] {
            assert_eq!(uv_from_dir(Dir::from_unit([-1.0, y, 0.0])), (0.0, 0.5), "y = {y:?}");
        }
        let beyond = uv_from_dir(dir([-1.0, -1e-300, 0.0]));
        assert_eq!(beyond, (0.0, 0.5), "a hair beyond the seam");
    }

    #[test]
    fn the_poles_lie_in_the_middle_whatever_the_signs_of_their_zeros() {
        for (x, y) in [(0.0, 0.0), (-0.0, 0.0), (0.0, -0.0), (-0.0, -0.0)] {
            for (z, v) in [(1.0, 0.0), (-1.0, 1.0)] {
                let found = uv_from_dir(Dir::from_unit([x, y, z]));
                assert_eq!(found, (0.5, v), "({x:?}, {y:?}, {z})");
            }
        }
    }

    #[test]
    fn u_wraps_around() {
        for u in [-3.0, -1.0, 1.0, 7.0] {
            let (a, b) = (dir_from_uv(0.3, 0.7), dir_from_uv(0.3 + u, 0.7));
            assert!(a.angle_to(b) < 1e-14, "u + {u}: {a:?} and {b:?}");
        }
    }

    #[test]
    fn solid_angles_sum_to_the_whole_sphere() {
        for (w, h) in [(1, 1), (2, 1), (7, 3), (512, 256), (4096, 2048)] {
            let sum: f64 = (0..h).map(|y| w as f64 * solid_angle(w, h, y)).sum();
            assert!((sum / (4.0 * PI) - 1.0).abs() < 1e-14, "{w} x {h}: {sum}");
        }
    }

    #[test]
    fn solid_angles_have_all_their_digits_at_the_poles() {
        // 1 - cos x = x²/2 - x⁴/24 + ..
        let (w, h) = (8192, 4096);
        let x = PI / h as f64;
        let exact = 2.0 * PI / w as f64 * x * x * (0.5 - x * x / 24.0 + x.powi(4) / 720.0);
        for y in [0, h - 1] {
            let found = solid_angle(w, h, y);
            assert!((found / exact - 1.0).abs() < 1e-14, "row {y}: {found} against {exact}");
        }
    }
}
