//! Mirror ball seen from far away: OpenGL's sphere map, and the photograph of a chrome ball.
//!
//! The picture is the square around the disc of the ball. Light from the direction `r` is seen where the ball's normal
//! is halfway between `r` and the eye:
//!
//! ```text
//!   p = (r·right, r·up) / √(2 (1 + r·eye))          p = (2u - 1, 1 - 2v)
//!   r = 2 √(1 - |p|²) (p, √(1 - |p|²)) - eye
//! ```
//!
//! The center reflects the eye; the whole rim is the one direction behind the ball. The projection keeps areas: every
//! texel that lies on the ball has the solid angle `16/(w h)`.
//!
//! ```text
//!            +z  up                        the rim: behind the ball
//!         .-------.                                 eye       right     up
//!       /    +z     \            sphere map         -y        +x        +z
//!      | -r   e   +r |           mirror ball        -x        -y        +z
//!       \    -z     /
//!         '-------'              (e: towards the eye, at r = 0; ±r, ±z at |p| = √½)
//! ```
//!
//! * [`Mapping::Sphere`](crate::Mapping::Sphere) is OpenGL's `GL_SPHERE_MAP` in eye coordinates (x right, y up, z
//!   towards the eye), brought to z up by Lobe's one y-up rotation: the eye is at -y. OpenGL counts `t` upwards:
//!   `s = u`, `t = 1 - v`.
//! * [`Mapping::MirrorBall`](crate::Mapping::MirrorBall) is the ball in the frame of the lat-long picture: a
//!   photographer at -x looks along +x, the middle of that picture, and sees -y on the right.
//!
//! Both are pictures of a ball, not of the world: a letter in the world appears mirrored. A camera at a finite distance
//! of `d` radii cannot see directions within about `1/d` of the one behind the ball; that is not modeled.
//!
//! OpenGL 4.6 (compatibility profile), section 12.1.3, `SPHERE_MAP`.

use lobe_sh::Dir;

use crate::mapping::azimuthal::{Frame, Profile};
use crate::mapping::discs::{Discs, opposite};
use crate::mapping::form::Form as _;

pub(crate) const SPHERE: Discs = Discs {
    name: "sphere",
    description: "OpenGL's sphere map",
    profile: Profile::Ball,
    frames: &[Frame { center: [0.0, -1.0, 0.0], right: [1.0, 0.0, 0.0], up: [0.0, 0.0, 1.0] }],
    across: opposite,
    axes_again: &[("+y", [0.0, 0.5])],
};

pub(crate) const MIRROR_BALL: Discs = Discs {
    name: "mirror-ball",
    description: "The photograph of a mirror ball",
    profile: Profile::Ball,
    frames: &[Frame { center: [-1.0, 0.0, 0.0], right: [0.0, -1.0, 0.0], up: [0.0, 0.0, 1.0] }],
    across: opposite,
    axes_again: &[("+x", [0.0, 0.5])],
};

/// The direction seen in the point `(u, v)` of OpenGL's sphere map; `None` beside the ball.
///
/// ```
/// use lobe_env::mirror_ball::{dir_from_uv, sphere_dir_from_uv};
/// use lobe_sh::Dir;
///
/// assert_eq!(sphere_dir_from_uv(0.5, 0.5), Some(-Dir::Y));
/// assert_eq!(dir_from_uv(0.5, 0.5), Some(-Dir::X));
/// assert_eq!(dir_from_uv(0.0, 0.0), None);
/// ```
#[must_use]
pub fn sphere_dir_from_uv(u: f64, v: f64) -> Option<Dir> {
    SPHERE.dir_from_uv(u, v)
}

/// The point `(u, v)` of OpenGL's sphere map in the direction `s`; `(1, 1/2)` for the one behind the ball.
#[must_use]
pub fn sphere_uv_from_dir(s: Dir) -> (f64, f64) {
    SPHERE.uv_from_dir(s)
}

/// The direction seen in the point `(u, v)` of a photographed mirror ball; `None` beside the ball.
#[must_use]
pub fn dir_from_uv(u: f64, v: f64) -> Option<Dir> {
    MIRROR_BALL.dir_from_uv(u, v)
}

/// The point `(u, v)` of a photographed mirror ball in the direction `s`; `(1, 1/2)` for the one behind the ball.
#[must_use]
pub fn uv_from_dir(s: Dir) -> (f64, f64) {
    MIRROR_BALL.uv_from_dir(s)
}

/// The exact solid angle in steradian of texel `(x, y)` of a ball's picture of `width` x `height` texels.
///
/// Texels at the rim have the solid angle of their part on the ball, those outside have 0. The sum is `4π`.
///
/// # Panics
/// If there is no such texel.
#[must_use]
pub fn solid_angle(width: usize, height: usize, x: usize, y: usize) -> f64 {
    MIRROR_BALL.solid_angle([width, height], [x, y])
}

#[cfg(test)]
mod tests {
    use lobe_testkit::directions;

    use super::*;

    #[test]
    fn sphere_maps_are_looked_up_as_opengl_computes_texture_coordinates() {
        for v in directions() {
            let d = Dir::new(v).unwrap();
            let (rx, ry, rz) = (d.x(), d.z(), -d.y());
            let m = 2.0 * (rx * rx + ry * ry + (rz + 1.0) * (rz + 1.0)).sqrt();
            if m > 1e-3 {
                let (s, t) = (rx / m + 0.5, ry / m + 0.5);
                let (u, v) = sphere_uv_from_dir(d);
                assert!((u - s).abs() + (1.0 - v - t).abs() < 1e-13, "{d:?}: ({u}, {v}) against ({s}, {t})");
            }
        }
    }

    #[test]
    fn the_photographer_sees_the_right_hand_world_on_the_right() {
        let at = |s: Dir| uv_from_dir(s);
        let side = 0.5 + 0.5 * 0.5_f64.sqrt();
        for (s, expected) in [(-Dir::X, (0.5, 0.5)), (-Dir::Y, (side, 0.5)), (Dir::Z, (0.5, 1.0 - side))] {
            let (u, v) = at(s);
            assert!((u - expected.0).abs() + (v - expected.1).abs() < 1e-15, "{s:?} at ({u}, {v})");
        }
        assert!((at(Dir::X).0, at(Dir::X).1) == (1.0, 0.5), "behind the ball: {:?}", at(Dir::X));
    }

    #[test]
    fn texels_on_the_ball_have_equal_solid_angles() {
        let (w, h) = (40, 30);
        let found = solid_angle(w, h, 18, 11);
        assert!((found / (16.0 / (w * h) as f64) - 1.0).abs() < 1e-12, "{found}");
        assert!(solid_angle(w, h, 0, 0) == 0.0, "the corner lies beside the ball");
    }
}
