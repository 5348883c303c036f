//! Dual paraboloid mapping: two discs side by side, each half of the sphere as a parabolic mirror shows it.
//!
//! ```text
//!   front (u < 1/2, s·x >= 0):  p = (-y, z)/(1 + x)        p = (4u - 1, 1 - 2v)
//!   back  (u > 1/2, s·x < 0):   p = ( y, z)/(1 - x)        p = (4u - 3, 1 - 2v)
//!
//!        .-------.   .-------.
//!      /    +z    \/    +z     \        |p| = tan(θ/2), θ the angle to the center;
//!     |+y   +x   -y|-y  -x   +y |       both rims are the circle x = 0
//!      \    -z    /\    -z     /
//!        '-------'   '-------'
//! ```
//!
//! Each disc is a picture of the world from inside, not mirrored: the front as an eye sees it that looks along +x, the
//! back after half a turn. They touch at -y; everywhere else a point of one rim belongs to its mirror image on the
//! other. `dΩ = 4/(1 + |p|²)² dp`; the area outside the discs is unused.
//!
//! Heidrich and Seidel 1998.

use lobe_sh::Dir;

use crate::mapping::azimuthal::{Frame, Profile};
use crate::mapping::discs::Discs;
use crate::mapping::form::Form as _;

pub(crate) const DUAL_PARABOLOID: Discs = Discs {
    name: "dual-paraboloid",
    description: "Two parabolic mirrors, side by side",
    profile: Profile::Paraboloid,
    // The front and the back.
    frames: &[
        Frame { center: [1.0, 0.0, 0.0], right: [0.0, -1.0, 0.0], up: [0.0, 0.0, 1.0] },
        Frame { center: [-1.0, 0.0, 0.0], right: [0.0, 1.0, 0.0], up: [0.0, 0.0, 1.0] },
    ],
    // The mirror image.
    across: |p| [-p[0], p[1]],
    axes_again: &[("+z", [0.75, 0.0]), ("-z", [0.75, 1.0]), ("+y", [1.0, 0.5])],
};

/// The direction of the point `(u, v)` of the picture; `None` outside the discs.
///
/// ```
/// use lobe_env::dual_paraboloid::dir_from_uv;
/// use lobe_sh::Dir;
///
/// assert_eq!(dir_from_uv(0.25, 0.5), Some(Dir::X));
/// assert_eq!(dir_from_uv(0.75, 0.5), Some(-Dir::X));
/// assert_eq!(dir_from_uv(0.01, 0.01), None);
/// ```
#[must_use]
pub fn dir_from_uv(u: f64, v: f64) -> Option<Dir> {
    DUAL_PARABOLOID.dir_from_uv(u, v)
}

/// The point `(u, v)` of the picture in the direction `s`; the circle `x = 0` belongs to the front.
#[must_use]
pub fn uv_from_dir(s: Dir) -> (f64, f64) {
    DUAL_PARABOLOID.uv_from_dir(s)
}

/// The exact solid angle in steradian of texel `(x, y)` of a picture of `width` x `height` texels.
///
/// In closed form; texels at the rims count with their part of the discs, one between the two discs with both parts.
///
/// # Panics
/// If there is no such texel.
#[must_use]
pub fn solid_angle(width: usize, height: usize, x: usize, y: usize) -> f64 {
    DUAL_PARABOLOID.solid_angle([width, height], [x, y])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_axes_lie_where_the_figure_says() {
        let cases = [
            (Dir::X, 0.25, 0.5),
            (-Dir::X, 0.75, 0.5),
            (Dir::Y, 0.0, 0.5),
            (-Dir::Y, 0.5, 0.5),
            (Dir::Z, 0.25, 0.0),
            (-Dir::Z, 0.25, 1.0),
        ];
        for (s, u, v) in cases {
            let found = uv_from_dir(s);
            assert!((found.0 - u).abs() + (found.1 - v).abs() < 1e-15, "{s:?} at {found:?}");
        }
    }

    #[test]
    fn both_sides_of_the_rim_are_on_their_own_half() {
        for k in 0..40 {
            let (sin, cos) = (0.157 * f64::from(k)).sin_cos();
            let front = Dir::new([1e-9, cos, sin]).unwrap();
            let back = Dir::new([-1e-9, cos, sin]).unwrap();
            let ((uf, vf), (ub, vb)) = (uv_from_dir(front), uv_from_dir(back));
            assert!(uf < 0.5 && ub >= 0.5, "azimuth {k}: {uf} and {ub}");
            // Mirror images: the same height, the same distance from the line between the discs.
            assert!((vf - vb).abs() < 1e-8 && (uf + ub - 1.0).abs() < 1e-8, "azimuth {k}: ({uf}, {vf}) ({ub}, {vb})");
        }
    }
}
