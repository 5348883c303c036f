//! Perspective and orthographic cameras: rays from the eye through the points of a picture.

use lobe_scene::{Bounds, Ray};
use lobe_sh::Dir;

use crate::camera::view::View;
use lobe_sh::sphere::vector::{Vec3, add, dot, normalized, scale, sub};

/// An eye that looks at the origin, or at a target, +z upwards in its picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    view: View,
    lens: Lens,
    target: Vec3,
}

/// Parallel rays start at `distance` from the plane through the target, others from one point there.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Lens {
    Orthographic { half_height: f64, distance: f64 },
    Perspective { distance: f64, slope: f64 },
}

/// The distance at which parallel rays start, in units of the half height of the picture: outside of shapes about as deep as
/// they are high. Scenes may be deeper: see [`BEYOND`].
const FAR: f64 = 100.0;

/// The distance at which parallel rays start from a scene that is deeper, in units of its reach towards the eye: numbers of
/// `f32` round off much less.
const BEYOND: f64 = 1.01;

impl Camera {
    /// Parallel rays; the picture shows `half_height` above and below the origin.
    ///
    /// All rays have one direction, so whatever lies infinitely far behind the shape is one color.
    ///
    /// # Panics
    /// If `half_height` is not positive.
    #[must_use]
    pub fn orthographic(view: View, half_height: f64) -> Self {
        assert!(half_height > 0.0, "a picture of half height {half_height} shows nothing");
        let lens = Lens::Orthographic { half_height, distance: FAR * half_height };
        Self { view, lens, target: [0.0; 3] }
    }

    /// Rays from one point at `distance` from the origin; the upper edge of the picture is seen at `half_angle` radians
    /// above its middle, in `(0, π/2)`.
    ///
    /// # Panics
    /// If `distance` or `half_angle` is out of range.
    #[must_use]
    pub fn perspective(view: View, distance: f64, half_angle: f64) -> Self {
        let in_range = distance > 0.0 && half_angle > 0.0 && half_angle < std::f64::consts::FRAC_PI_2;
        assert!(in_range, "no picture from distance {distance} with half an angle of {half_angle}");
        Self { view, lens: Lens::Perspective { distance, slope: half_angle.tan() }, target: [0.0; 3] }
    }

    /// Rays from the point `eye`, of which the middle one goes through `target`; `half_angle` as in
    /// [`perspective`](Camera::perspective). None if the two points are one.
    ///
    /// # Panics
    /// If `half_angle` is out of range.
    #[must_use]
    pub fn look_at(eye: [f64; 3], target: [f64; 3], half_angle: f64) -> Option<Self> {
        let towards_eye = sub(eye, target);
        let view = View::from_eye(Dir::new(towards_eye)?);
        let distance = dot(towards_eye, towards_eye).sqrt();
        Some(Self { target, ..Self::perspective(view, distance, half_angle) })
    }

    /// Rays from an eye in the direction of `view` so far away that the ball around a box of these corners fills the
    /// height of the picture, such as those of [`Scene::world_bounds`](lobe_scene::Scene::world_bounds).
    ///
    /// ```text
    ///   distance = radius / sin(half angle)
    /// ```
    ///
    /// # Panics
    /// If `half_angle` is out of range.
    #[must_use]
    pub fn framing(min: [f64; 3], max: [f64; 3], view: View, half_angle: f64) -> Self {
        let half = scale(sub(max, min), 0.5);
        // A box without extent is a point, which any distance shows.
        let radius = dot(half, half).sqrt().max(f64::MIN_POSITIVE.sqrt());
        Self { target: add(min, half), ..Self::perspective(view, radius / half_angle.sin(), half_angle) }
    }

    /// The same camera in coordinates that count from a point, such as [`Scene::origin`](lobe_scene::Scene::origin).
    #[must_use]
    pub fn relative_to(self, origin: [f64; 3]) -> Self {
        Self { target: sub(self.target, origin), ..self }
    }

    /// The same camera, whose parallel rays start outside of a box; rays from an eye start there all the same.
    pub(crate) fn outside_of(self, Bounds { min, max }: Bounds) -> Self {
        let Lens::Orthographic { half_height, distance } = self.lens else { return self };
        let towards_eye = self.view.point([0.0, 0.0, 1.0]);
        let along = |k: usize, corner: f32| towards_eye[k] * (f64::from(corner) - self.target[k]);
        let reach: f64 = (0..3).map(|k| along(k, min[k]).max(along(k, max[k]))).sum();
        Self { lens: Lens::Orthographic { half_height, distance: distance.max(BEYOND * reach) }, ..self }
    }

    /// The view: the axes of the picture.
    #[must_use]
    pub fn view(&self) -> View {
        self.view
    }

    /// The eye of a perspective, its target and half of the angle from the lower to the upper edge of the picture, in
    /// radians; none of parallel rays.
    #[must_use]
    pub fn eye_target_angle(&self) -> Option<([f64; 3], [f64; 3], f64)> {
        let Lens::Perspective { distance, slope } = self.lens else { return None };
        Some((add(self.target, self.view.point([0.0, 0.0, distance])), self.target, slope.atan()))
    }

    /// The start and the direction of the ray at `right` and `up` of the middle, the upper edge at `up = 1`.
    ///
    /// ```text
    ///   orthographic   o = target + h (right R + up U) + 100 h E          d = -E
    ///   perspective    o = target + distance E                            d ∝ tan(half angle) (right R + up U) - E
    /// ```
    ///
    /// `R`, `U`, `E` are the axes of the [`View`]: right, up, towards the eye. Pictures of scenes that reach farther than `100 h`
    /// towards the eye start their parallel rays beyond them.
    #[must_use]
    pub fn ray(&self, right: f64, up: f64) -> ([f64; 3], Dir) {
        let (from_target, d) = match self.lens {
            Lens::Orthographic { half_height: h, distance } => {
                (self.view.point([h * right, h * up, distance]), Dir::from_unit(self.view.point([0.0, 0.0, -1.0])))
            }
            Lens::Perspective { distance, slope } => {
                let towards: Vec3 = self.view.point([slope * right, slope * up, -1.0]);
                (self.view.point([0.0, 0.0, distance]), Dir::from_unit(normalized(towards)))
            }
        };
        (add(self.target, from_target), d)
    }

    /// The ray through the point `[x, y]` of a picture of `[width, height]` pixels, in pixels from its top left corner,
    /// and the direction of that ray.
    pub(crate) fn ray_of_pixel(&self, [width, height]: [usize; 2], [x, y]: [f64; 2]) -> (Ray, Dir) {
        let half = 0.5 * height as f64;
        let (origin, towards) = self.ray((x - 0.5 * width as f64) / half, (half - y) / half);
        (Ray::new(origin.map(|c| c as f32), towards.to_array().map(|c| c as f32)), towards)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_lenses_see_the_plane_through_the_origin_in_the_same_size() {
        let view = View::three_quarter();
        let half_angle = 0.3_f64;
        let cameras = [Camera::orthographic(view, 2.0), Camera::perspective(view, 2.0 / half_angle.tan(), half_angle)];
        for camera in cameras {
            for (right, up) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (-0.7, 0.4)] {
                let (origin, d) = camera.ray(right, up);
                let [_, _, height] = view.project(origin);
                let [_, _, falls] = view.project(d.to_array());
                let p = add(origin, scale(d.to_array(), -height / falls));
                let [x, y, _] = view.project(p);
                let off = (x - 2.0 * right).hypot(y - 2.0 * up);
                assert!(off < 1e-12, "{camera:?} at ({right}, {up}) sees ({x}, {y})");
            }
        }
    }
    #[test]
    fn the_middle_ray_goes_through_the_target() {
        let (eye, target) = ([3.0, -2.0, 5.0], [1.0, 1.0, 1.0]);
        let camera = Camera::look_at(eye, target, 0.4).unwrap();
        let (origin, d) = camera.ray(0.0, 0.0);
        let t = dot(sub(target, origin), d.to_array());
        let off = sub(add(origin, scale(d.to_array(), t)), target);
        assert!(dot(off, off).sqrt() < 1e-12 && dot(sub(origin, eye), sub(origin, eye)) < 1e-24, "{camera:?}");
        assert!(camera.ray(0.0, 0.5).1.z() > d.z(), "up is +z");
        assert!(Camera::look_at(eye, eye, 0.4).is_none(), "no direction");
    }

    #[test]
    fn a_framed_ball_touches_the_upper_edge() {
        let camera = Camera::framing([1.0, 2.0, 3.0], [2.0, 4.0, 5.0], View::three_quarter(), 0.3);
        let (origin, d) = camera.ray(0.0, 1.0);
        let from = sub([1.5, 3.0, 4.0], origin);
        let along = dot(from, d.to_array());
        let distance = (dot(from, from) - along * along).sqrt();
        assert!((distance - 1.5).abs() < 1e-12, "the upper edge passes the middle at {distance}, its radius is 1.5");
    }
}
