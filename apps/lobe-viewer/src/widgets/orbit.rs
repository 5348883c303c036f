//! A camera that circles what it looks at.

use std::f64::consts::{FRAC_PI_2, PI};

use lobe::render::Camera;
use lobe::sh::Dir;
use lobe_gpu::GpuCamera;
use serde::{Deserialize, Serialize};

use crate::widgets::within::within;

/// Half the angle of view from top to bottom, in radians.
const HALF_ANGLE: f64 = 0.3;

/// Radians for a drag across the height of the picture.
const TURN: f64 = PI;

/// Parts of the distance for a point of scrolling.
const SCROLL: f64 = 0.0025;

/// The eye stays so far from the axis, in radians, where the picture would have no upwards.
const FROM_AXIS: f64 = 0.01;

/// The least and the greatest distance, in meters, to which a view comes from others; one that frames a scene may be beyond.
const DISTANCES: [f64; 2] = [1e-6, 1e6];

/// The least distance over the largest coordinate of the target: rounding leaves a direction from there to the eye.
const ROUNDING: f64 = 1e-9;

/// Kept targets are at most so far from the origin along each axis, in meters.
const FARTHEST: f64 = 1e6;

/// An eye at a distance from a point, by azimuth and height above the horizon, +z upwards.
///
/// ```text
///   eye = target + distance (cos h cos a, cos h sin a, sin h)
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Orbit {
    /// In radians, from +x towards +y.
    pub azimuth: f64,
    /// In radians, from the horizon upwards.
    pub height: f64,
    /// What it looks at.
    pub target: [f64; 3],
    /// From there to the eye.
    pub distance: f64,
}

impl Default for Orbit {
    fn default() -> Self {
        Self { azimuth: -1.1, height: 0.16, target: [0.0, 0.0, 1.0], distance: 14.0 }
    }
}

impl Orbit {
    /// Brings its numbers into their ranges; angles that are none are those of the first start.
    pub(crate) fn check(&mut self) {
        let first = Self::default();
        let most = FRAC_PI_2 - FROM_AXIS;
        self.azimuth = within(self.azimuth, -2.0 * PI..=2.0 * PI, first.azimuth);
        self.height = within(self.height, -most..=most, first.height);
        self.target = std::array::from_fn(|k| within(self.target[k], -FARTHEST..=FARTHEST, first.target[k]));
        let nearest = DISTANCES[0].max(rounding(self.target));
        self.distance = within(self.distance, nearest..=DISTANCES[1], first.distance);
    }

    /// Whether target and distance are within what [`Orbit::check`] leaves as it is.
    pub(crate) fn is_in_reach(&self) -> bool {
        let mut checked = *self;
        checked.check();
        (checked.target, checked.distance) == (self.target, self.distance)
    }

    /// The same view from where the ball around a box is a little higher than the picture.
    #[must_use]
    pub fn framing(self, [min, max]: [[f64; 3]; 2]) -> Self {
        let half: [f64; 3] = std::array::from_fn(|k| 0.5 * (max[k] - min[k]));
        let target = std::array::from_fn(|k| min[k] + half[k]);
        let radius = half.iter().map(|c| c * c).sum::<f64>().sqrt().max(rounding(target));
        // Scenes are wider than high, and pictures too.
        let distance = 0.7 * radius / HALF_ANGLE.sin();
        Self { target, distance, ..self }
    }

    /// The same view in a picture that is higher than wide, from so far away that as much is seen from side to side as from top to
    /// bottom of others.
    pub(crate) fn fitting(self, width: f64, height: f64) -> Self {
        let farther = (height / width.max(1.0)).clamp(1.0, 1e3);
        Self { distance: farther * self.distance, ..self }
    }

    /// Turns by a drag in parts of the height of the picture: what is under the pointer follows it.
    pub fn turn(&mut self, right: f64, down: f64) {
        self.azimuth = (self.azimuth - TURN * right).rem_euclid(2.0 * PI);
        let most = FRAC_PI_2 - FROM_AXIS;
        self.height = (self.height + TURN * down).clamp(-most, most);
    }

    /// Moves by a drag in parts of the height of the picture: the plane through the target follows the pointer.
    pub fn pan(&mut self, right: f64, down: f64) {
        let Some(camera) = self.camera() else { return };
        let axes = camera.view();
        let length = 2.0 * self.distance * HALF_ANGLE.tan();
        let [x, y, z] = axes.point([-right * length, down * length, 0.0]);
        self.target = [self.target[0] + x, self.target[1] + y, self.target[2] + z];
    }

    /// Comes nearer by a factor above 1, and no farther out of the range of distances than it is.
    pub fn zoom(&mut self, factor: f64) {
        if factor > 0.0 && factor.is_finite() {
            let nearest = DISTANCES[0].max(rounding(self.target)).min(self.distance);
            self.distance = (self.distance / factor).clamp(nearest, DISTANCES[1].max(self.distance));
        }
    }

    /// Comes nearer by `points` of scrolling.
    pub fn scroll(&mut self, points: f64) {
        self.zoom((SCROLL * points).exp());
    }

    /// The direction from the target to the eye.
    pub(crate) fn towards_eye(&self) -> Dir {
        Dir::from_angles(FRAC_PI_2 - self.height, self.azimuth)
    }

    /// Where the eye is.
    #[must_use]
    pub fn eye(&self) -> [f64; 3] {
        let e = self.towards_eye().to_array();
        std::array::from_fn(|k| self.target[k] + self.distance * e[k])
    }

    /// Where a point is in the picture, right and up from its middle, with the upper edge at 1; none behind the eye.
    #[must_use]
    pub fn project(&self, point: [f64; 3]) -> Option<[f64; 2]> {
        let from_target = std::array::from_fn(|k| point[k] - self.target[k]);
        let [right, up, towards_eye] = self.camera()?.view().project(from_target);
        let depth = self.distance - towards_eye;
        (depth > 0.0).then(|| [right, up].map(|c| c / (depth * HALF_ANGLE.tan())))
    }

    /// What a length of 1 at a point has in the picture, in units of half its height; none behind the eye.
    #[must_use]
    pub fn size_at(&self, point: [f64; 3]) -> Option<f64> {
        let from_target = std::array::from_fn(|k| point[k] - self.target[k]);
        let depth = self.distance - self.camera()?.view().project(from_target)[2];
        (depth > 0.0).then(|| 1.0 / (depth * HALF_ANGLE.tan()))
    }

    /// For the device; none of numbers that are no camera.
    #[must_use]
    pub fn on_device(&self) -> Option<GpuCamera> {
        GpuCamera::look_at(self.eye(), self.target, HALF_ANGLE)
    }

    /// For rays.
    #[must_use]
    pub fn camera(&self) -> Option<Camera> {
        Camera::look_at(self.eye(), self.target, HALF_ANGLE)
    }
}

/// The least distance from a target.
fn rounding(target: [f64; 3]) -> f64 {
    ROUNDING * target.iter().fold(1.0_f64, |most, c| most.max(c.abs()))
}
