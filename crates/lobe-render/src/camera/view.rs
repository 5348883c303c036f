//! View directions: the axes of a picture, right, up and towards the eye.

use lobe_sh::Dir;

use lobe_sh::sphere::vector::{Vec3, add, cross, dot, normalized, scale};

/// A parallel (orthographic) view of the neighborhood of the origin, with +z upwards in the picture.
///
/// ```text
///   right = z × e        up = e × right        e: direction from the origin to the eye
/// ```
///
/// `(right, up, e)` is right-handed, so pictures are not mirrored.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    right: Vec3,
    up: Vec3,
    towards_eye: Vec3,
}

impl View {
    /// The view along +x from an eye on the side of -x: right is -y, as in a lat-long picture.
    ///
    /// The center of a lat-long picture lies behind the ball; the ball shows the light from behind the eye.
    pub const ALONG_X: Self = Self { right: [0.0, -1.0, 0.0], up: [0.0, 0.0, 1.0], towards_eye: [-1.0, 0.0, 0.0] };

    /// The view from an eye in the direction `eye`; straight from above, and from below, right is -y.
    #[must_use]
    pub fn from_eye(eye: Dir) -> Self {
        let e = eye.to_array();
        let horizontal = [-e[1], e[0], 0.0];
        let right = if horizontal == [0.0; 3] { [0.0, -1.0, 0.0] } else { normalized(horizontal) };
        Self { right, up: cross(e, right), towards_eye: e }
    }

    /// The view that textbooks draw: +x comes forward to the left, +y goes to the right, +z goes up.
    ///
    /// The eye stands 30° from +x towards +y and 25° above the horizon.
    #[must_use]
    pub fn three_quarter() -> Self {
        Self::from_eye(Dir::from_angles(65.0_f64.to_radians(), 30.0_f64.to_radians()))
    }

    /// The coordinates of the point `p` along right, up and towards the eye.
    #[must_use]
    pub fn project(&self, p: [f64; 3]) -> [f64; 3] {
        [dot(p, self.right), dot(p, self.up), dot(p, self.towards_eye)]
    }

    /// The point with these coordinates along right, up and towards the eye: the inverse of [`View::project`].
    #[must_use]
    pub fn point(&self, [right, up, towards_eye]: [f64; 3]) -> [f64; 3] {
        add(add(scale(self.right, right), scale(self.up, up)), scale(self.towards_eye, towards_eye))
    }

    /// The direction of the point of the unit sphere seen at `(right, up)`: on the rim, if it lies outside the disc.
    #[must_use]
    pub fn dir_at(&self, right: f64, up: f64) -> Dir {
        let radius = right.hypot(up);
        let shrink = radius.max(1.0).recip();
        let (right, up) = (right * shrink, up * shrink);
        let forward = (1.0 - right * right - up * up).max(0.0).sqrt();
        let p = self.point([right, up, forward]);
        Dir::new(p).unwrap_or_else(|| unreachable!("the point {p:?} lies on the unit sphere"))
    }
}

#[cfg(test)]
mod tests {
    use lobe_testkit::directions;

    use super::*;

    #[test]
    fn views_are_right_handed_and_keep_z_up() {
        for eye in directions() {
            let view = View::from_eye(Dir::new(eye).unwrap());
            let handed = dot(cross(view.right, view.up), view.towards_eye);
            assert!((handed - 1.0).abs() < 1e-12, "eye {eye:?}: the triple product is {handed}");
            let [right, up, _] = view.project([0.0, 0.0, 1.0]);
            assert!(right.abs() < 1e-12 && up >= 0.0, "eye {eye:?}: +z is seen at ({right}, {up})");
        }
    }

    #[test]
    fn the_view_along_x_has_minus_y_on_the_right() {
        assert_eq!(View::from_eye(-Dir::X), View::ALONG_X, "the eye on the side of -x");
        assert_eq!(View::ALONG_X.project([0.0, -1.0, 0.0]), [1.0, 0.0, 0.0], "-y");
    }

    #[test]
    fn visible_points_project_to_where_they_are_seen() {
        let view = View::three_quarter();
        for d in directions() {
            let [right, up, forward] = view.project(d);
            if forward > 0.0 {
                let angle = view.dir_at(right, up).angle_to(Dir::new(d).unwrap());
                // Near the rim the depth is the square root of a rounded difference.
                assert!(angle < 1e-7, "{d:?} came back {angle} rad away");
            }
        }
    }

    #[test]
    fn the_three_quarter_view_shows_all_three_axes() {
        let view = View::three_quarter();
        let [x, y, z] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|axis| view.project(axis));
        assert!(x[0] < -0.3 && x[1] < 0.0 && x[2] > 0.0, "+x comes forward to the left: {x:?}");
        assert!(y[0] > 0.3 && y[2] > 0.0, "+y goes to the right: {y:?}");
        assert!(z[0] == 0.0 && z[1] > 0.8 && z[2] > 0.0, "+z goes up: {z:?}");
    }
}
