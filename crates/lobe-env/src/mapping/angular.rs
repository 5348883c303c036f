//! Angular map, the mapping of light probes: the radius is proportional to the angle to the center.
//!
//! ```text
//!   p = (θ/π) (cos ψ, sin ψ)       p = (2u - 1, 1 - 2v)
//!   θ  the angle to +x,  ψ  the azimuth around it, from -y (right) towards +z (up)
//!
//!         .-------.
//!       /    +z     \         center      +x, the middle of the lat-long picture
//!      | +y  +x  -y  |        |p| = 1/2   the circle through +z, -y, -z, +y
//!       \    -z     /         rim         -x, all around
//!         '-------'
//! ```
//!
//! A picture of the world from inside, not mirrored. `dΩ = π sin(π|p|)/|p| dp`: the corners of the square around the
//! disc are unused. The form is that of Debevec's light probes, with his forward direction -Z at our +x.

use lobe_sh::Dir;

use crate::mapping::azimuthal::{Frame, Profile};
use crate::mapping::discs::{Discs, opposite};
use crate::mapping::form::Form as _;

pub(crate) const ANGULAR: Discs = Discs {
    name: "angular",
    description: "The light probe: the distance from the middle is the angle",
    profile: Profile::Angular,
    frames: &[Frame { center: [1.0, 0.0, 0.0], right: [0.0, -1.0, 0.0], up: [0.0, 0.0, 1.0] }],
    across: opposite,
    axes_again: &[("-x", [0.0, 0.5])],
};

/// The direction of the point `(u, v)` of the picture; `None` outside the disc.
///
/// ```
/// use lobe_env::angular::dir_from_uv;
/// use lobe_sh::Dir;
///
/// assert_eq!(dir_from_uv(0.5, 0.5), Some(Dir::X));
/// let right = dir_from_uv(0.75, 0.5);
/// assert!(right.is_some_and(|s| s.angle_to(-Dir::Y) < 1e-15));
/// ```
#[must_use]
pub fn dir_from_uv(u: f64, v: f64) -> Option<Dir> {
    ANGULAR.dir_from_uv(u, v)
}

/// The point `(u, v)` of the picture in the direction `s`; `(1, 1/2)` for -x.
#[must_use]
pub fn uv_from_dir(s: Dir) -> (f64, f64) {
    ANGULAR.uv_from_dir(s)
}

/// The solid angle in steradian of texel `(x, y)` of a picture of `width` x `height` texels.
///
/// A line integral around the texel, ten Gauss nodes on a quarter of the radius: within 1e-9 of quadrature over its
/// area (test `solid_angles_equal_the_sum_of_quadrature_nodes`). Texels at the rim have the solid angle of their part
/// in the disc; the sum is `4π` to 1e-11 (test `solid_angles_of_every_mapping_and_size_sum_to_the_whole_sphere`).
///
/// # Panics
/// If there is no such texel.
#[must_use]
pub fn solid_angle(width: usize, height: usize, x: usize, y: usize) -> f64 {
    ANGULAR.solid_angle([width, height], [x, y])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_axes_lie_where_the_figure_says() {
        let cases =
            [(Dir::X, 0.5, 0.5), (-Dir::Y, 0.75, 0.5), (Dir::Y, 0.25, 0.5), (Dir::Z, 0.5, 0.25), (-Dir::X, 1.0, 0.5)];
        for (s, u, v) in cases {
            let found = uv_from_dir(s);
            assert!((found.0 - u).abs() + (found.1 - v).abs() < 1e-15, "{s:?} at {found:?}");
        }
    }

    #[test]
    fn the_radius_is_proportional_to_the_angle() {
        for k in 0..=10 {
            let angle = std::f64::consts::PI * f64::from(k) / 10.0;
            let s = Dir::new([angle.cos(), 0.0, angle.sin()]).unwrap();
            let v = uv_from_dir(s).1;
            let r = if k == 10 { 1.0 } else { 1.0 - 2.0 * v };
            assert!((r - f64::from(k) / 10.0).abs() < 1e-15, "step {k}: {r}");
        }
    }
}
