//! Cameras as shaders have them.

use bytemuck::{Pod, Zeroable};
use lobe_sh::Dir;
use lobe_sh::vector::{Vec3, add, cross, dot, normalized, scale, sub};

/// The nearest distance at which surfaces are drawn, as a part of the distance of the eye from what it looks at.
const NEAREST: f64 = 1e-4;

/// The least radius of what is framed over its largest coordinate: rounding leaves a direction from its middle to the eye.
const ROUNDING: f64 = 1e-9;

/// The distance at which parallel rays start, in units of the half height of the picture.
const FAR: f64 = 100.0;

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
    lens: Lens,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Lens {
    Orthographic { half_height: f64 },
    Perspective { distance: f64, slope: f64 },
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
        let lens = Lens::Perspective { distance, slope: half_angle.tan() };
        let is_angle = half_angle > 0.0 && half_angle < std::f64::consts::FRAC_PI_2;
        Dir::new(from_target).filter(|_| is_angle).map(|e| Self::new(e, target, lens))
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

    /// Parallel rays from direction `eye`; the picture shows `half_height` above and below `target`. None if the height is not
    /// positive.
    #[must_use]
    pub fn orthographic(eye: Dir, target: [f64; 3], half_height: f64) -> Option<Self> {
        (half_height > 0.0).then(|| Self::new(eye, target, Lens::Orthographic { half_height }))
    }

    fn new(eye: Dir, target: Vec3, lens: Lens) -> Self {
        let e = eye.to_array();
        let horizontal = [-e[1], e[0], 0.0];
        let right = if horizontal == [0.0; 3] { [0.0, -1.0, 0.0] } else { normalized(horizontal) };
        Self { right, up: cross(e, right), towards_eye: e, target, lens }
    }

    /// For a picture of `width` x `height` pixels, in coordinates that count from `origin`.
    pub(crate) fn shape(&self, origin: [f64; 3], [width, height]: [u32; 2]) -> CameraShape {
        let single = |v: Vec3| {
            let [x, y, z] = v.map(|c| c as f32);
            [x, y, z, 0.0]
        };
        let lens = match self.lens {
            Lens::Orthographic { half_height } => [0.0, FAR * half_height, half_height, 0.0],
            Lens::Perspective { distance, slope } => [1.0, distance, slope, NEAREST * distance],
        };
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
