//! Emitters: lamps near by, as shapes from which the path tracer draws directions.

use std::f64::consts::PI;

use lobe_io::Fingerprint;
use lobe_sh::Rgb;
use lobe_sh::vector::{Vec3, add_scaled, cross, dot, length, normalized, scale, sub, tangents_along_z};
use lobe_shadow::{LampShape, Placement};

/// A lamp of one radiance in the world. It lights surfaces; it is no surface itself, so that no ray hits it and no eye sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Emitter {
    shape: EmitterShape,
    radiance: Rgb<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum EmitterShape {
    Ball {
        center: Vec3,
        radius: f64,
    },
    /// A corner and two edges; it shines towards `u × v`.
    Rectangle {
        corner: Vec3,
        u: Vec3,
        v: Vec3,
        two_sided: bool,
    },
}

/// A direction drawn from an emitter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct EmitterSample {
    /// A unit vector.
    pub(crate) towards: Vec3,
    /// To the emitter.
    pub(crate) distance: f64,
    /// By solid angle.
    pub(crate) density: f64,
}

impl Emitter {
    /// A lamp at a place: a scale makes it larger, not brighter.
    #[must_use]
    pub fn new(shape: &LampShape, placement: &Placement, radiance: Rgb<f64>) -> Self {
        let turned = |v: Vec3| sub(placement.to_world(v), placement.translation());
        let shape = match shape {
            LampShape::Ball(radius) => {
                EmitterShape::Ball { center: placement.translation(), radius: placement.scale() * radius }
            }
            LampShape::Rectangle(r) => EmitterShape::Rectangle {
                corner: placement.to_world(r.corner),
                u: turned(r.u),
                v: turned(r.v),
                two_sided: r.two_sided,
            },
        };
        Self { shape, radiance }
    }

    /// The same in a frame whose origin is there.
    pub(crate) fn relative_to(mut self, origin: Vec3) -> Self {
        match &mut self.shape {
            EmitterShape::Ball { center, .. } => *center = sub(*center, origin),
            EmitterShape::Rectangle { corner, .. } => *corner = sub(*corner, origin),
        }
        self
    }

    pub(crate) fn radiance(&self) -> Rgb<f64> {
        self.radiance
    }

    /// A direction in which a point sees it if nothing is between; none where it is dark from there.
    pub(crate) fn sample(&self, from: Vec3, numbers: [f64; 2]) -> Option<EmitterSample> {
        match self.shape {
            EmitterShape::Ball { center, radius } => Some(toward_ball(sub(center, from), radius, numbers)),
            EmitterShape::Rectangle { corner, u, v, two_sided } => {
                let normal = cross(u, v);
                let point = add_scaled(add_scaled(corner, u, numbers[0]), v, numbers[1]);
                let to = sub(point, from);
                let distance = length(to);
                let towards = scale(to, distance.recip());
                // The area times the cosine at the emitter.
                let facing = -dot(towards, normal);
                let facing = if two_sided { facing.abs() } else { facing };
                (facing > 0.0 && distance > 0.0).then(|| EmitterSample {
                    towards,
                    distance,
                    density: distance * distance / facing,
                })
            }
        }
    }

    pub(crate) fn write_into(&self, all: &mut Fingerprint) {
        let numbers = match self.shape {
            EmitterShape::Ball { center, radius } => [center, [radius; 3], [0.0; 3], [0.0; 3]],
            EmitterShape::Rectangle { corner, u, v, two_sided } => {
                [corner, u, v, [1.0 + f64::from(u8::from(two_sided)); 3]]
            }
        };
        numbers.as_flattened().iter().chain(&self.radiance.to_array()).for_each(|c| all.word(c.to_bits()));
    }
}

/// A direction uniform over the cone that a ball fills, or over the sphere from within.
fn toward_ball(to: Vec3, radius: f64, [a, b]: [f64; 2]) -> EmitterSample {
    let distance = length(to);
    if distance <= radius {
        let z = 1.0 - 2.0 * a;
        let (sin, cos) = (2.0 * PI * b).sin_cos();
        let r = (1.0 - z * z).max(0.0).sqrt();
        return EmitterSample { towards: [r * cos, r * sin, z], distance: 0.0, density: 0.25 / PI };
    }
    let sine2 = (radius / distance).powi(2);
    // 1 - cos of the half angle, without cancellation.
    let height = sine2 / (1.0 + (1.0 - sine2).sqrt());
    let z = 1.0 - a * height;
    let r2 = (a * height * (2.0 - a * height)).max(0.0);
    let (sin, cos) = (2.0 * PI * b).sin_cos();
    let axis = normalized(to);
    let [u, v] = tangents_along_z(axis);
    let r = r2.sqrt();
    let towards = std::array::from_fn(|k| r * cos * u[k] + r * sin * v[k] + z * axis[k]);
    let depth = (radius * radius - distance * distance * r2).max(0.0).sqrt();
    EmitterSample { towards, distance: distance * z - depth, density: 0.5 / (PI * height) }
}

#[cfg(test)]
mod tests {
    use lobe_sh::Rotation;
    use lobe_shadow::Placement;

    use super::*;

    /// The irradiance along +z at the origin, by a grid of numbers.
    fn irradiance(shape: &LampShape, at: [f64; 3]) -> f64 {
        let placement = Placement::new(at, Rotation::IDENTITY, 1.0);
        let emitter = Emitter::new(shape, &placement, Rgb::new(1.0, 1.0, 1.0));
        let n = 200;
        let mut sum = 0.0;
        for i in 0..n * n {
            let numbers = [i % n, i / n].map(|k| (k as f64 + 0.5) / n as f64);
            if let Some(sample) = emitter.sample([0.0; 3], numbers) {
                sum += sample.towards[2].max(0.0) / sample.density;
            }
        }
        sum / (n * n) as f64
    }

    #[test]
    fn irradiance_has_its_closed_form() {
        // A ball of radius r overhead at distance d sends π (r/d)²; from within everything.
        let found = irradiance(&LampShape::Ball(0.5), [0.0, 0.0, 2.0]);
        assert!((found / (PI / 16.0) - 1.0).abs() < 1e-4, "a ball: {found}");
        let found = irradiance(&LampShape::Ball(3.0), [0.0, 0.0, 2.0]);
        assert!((found / PI - 1.0).abs() < 1e-3, "within a ball: {found}");
        // A rectangle with a corner overhead: the form factor of parallel rectangles, Siegel and Howell.
        let (a, b) = (1.5_f64, 0.5_f64);
        let (x, y) = ((1.0 + a * a).sqrt(), (1.0 + b * b).sqrt());
        let corner = 0.5 * (a / x * (b / x).atan() + b / y * (a / y).atan());
        let shape = |v: [f64; 3], two_sided| {
            LampShape::Rectangle(lobe_shadow::Rectangle { corner: [0.0; 3], u: [a, 0.0, 0.0], v, two_sided })
        };
        // It shines towards u × v, which is down for a `v` of negative sign: with the corner at (0, b).
        let down = irradiance(&shape([0.0, -b, 0.0], false), [0.0, b, 1.0]);
        assert!((down / corner - 1.0).abs() < 1e-4, "a rectangle: {down}, expected {corner}");
        let up = irradiance(&shape([0.0, b, 0.0], false), [0.0, 0.0, 1.0]);
        assert!(up == 0.0, "its back is dark: {up}");
        let both = irradiance(&shape([0.0, b, 0.0], true), [0.0, 0.0, 1.0]);
        assert!((both / corner - 1.0).abs() < 1e-4, "both sides shine: {both}");
    }
}
