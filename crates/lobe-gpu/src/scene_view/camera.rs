//! Cameras as shaders have them.

use bytemuck::{Pod, Zeroable};
use lobe_sh::Dir;
use lobe_sh::sphere::vector::{Vec3, add, cross, dot, normalized, scale, sub};

/// The nearest distance at which surfaces are drawn, as a part of the distance of the eye from what it looks at.
const NEAREST: f64 = 1e-4;

/// The least radius of what is framed over its largest coordinate: rounding leaves a direction from its middle to the eye.
const ROUNDING: f64 = 1e-9;

/// An eye that looks at a point, +z upwards in its picture: the camera of `lobe-render`, of which it shows the same.
///
/// ```text
///   right = z × e        up = e × right        e: direction from the point to the eye
/// ```
///
/// What is nearer to the eye than 1/10000 of its distance from that point is not drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GpuCamera {
    right: Vec3,
    up: Vec3,
    towards_eye: Vec3,
    target: Vec3,
    /// Of the eye from the target, and the tangent of half the angle of view.
    distance: f64,
    slope: f64,
}

/// The camera in the WGSL module `camera`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct CameraShape {
    right: [f32; 4],
    up: [f32; 4],
    towards_eye: [f32; 4],
    middle: [f32; 4],
    lens: [f32; 4],
    size: [f32; 4],
}

impl GpuCamera {
    /// Rays from the point `eye`, of which the middle one goes through `target`; the upper edge of the picture is seen at
    /// `half_angle` radians above its middle, in `(0, π/2)`. None if the two points are one, or the angle is out of range.
    #[must_use]
    pub fn look_at(eye: [f64; 3], target: [f64; 3], half_angle: f64) -> Option<Self> {
        let from_target = sub(eye, target);
        let distance = dot(from_target, from_target).sqrt();
        let is_angle = half_angle > 0.0 && half_angle < std::f64::consts::FRAC_PI_2;
        Dir::new(from_target).filter(|_| is_angle).map(|e| Self::new(e, target, [distance, half_angle.tan()]))
    }

    /// Rays from an eye in direction `eye` so far away that the ball around a box of these corners, such as those of
    /// [`Scene::world_bounds`](lobe_scene::Scene::world_bounds), fills the height of the picture. None if the angle is out of
    /// range, or a number is not finite.
    #[must_use]
    pub fn framing([min, max]: [[f64; 3]; 2], eye: Dir, half_angle: f64) -> Option<Self> {
        let half = scale(sub(max, min), 0.5);
        let target = add(min, half);
        // A box without extent is a point, which any distance shows from which it can be told from the eye.
        let least = target.iter().fold(f64::MIN_POSITIVE.sqrt(), |most, c| most.max(ROUNDING * c.abs()));
        let distance = dot(half, half).sqrt().max(least) / half_angle.sin();
        Self::look_at(add(target, scale(eye.to_array(), distance)), target, half_angle)
    }

    fn new(eye: Dir, target: Vec3, [distance, slope]: [f64; 2]) -> Self {
        let e = eye.to_array();
        let horizontal = [-e[1], e[0], 0.0];
        let right = if horizontal == [0.0; 3] { [0.0, -1.0, 0.0] } else { normalized(horizontal) };
        Self { right, up: cross(e, right), towards_eye: e, target, distance, slope }
    }

    /// For a picture of `width` x `height` pixels, in coordinates that count from `origin`.
    pub(crate) fn shape(&self, origin: [f64; 3], [width, height]: [u32; 2]) -> CameraShape {
        let single = |v: Vec3| {
            let [x, y, z] = v.map(|c| c as f32);
            [x, y, z, 0.0]
        };
        let lens = [self.distance, self.slope, NEAREST * self.distance, 0.0];
        CameraShape {
            right: single(self.right),
            up: single(self.up),
            towards_eye: single(self.towards_eye),
            middle: single(sub(self.target, origin)),
            lens: lens.map(|x| x as f32),
            size: [width as f32, height as f32, 0.0, 0.0],
        }
    }
}
