//! Emitters: lamps near by, as shapes from which the path tracer draws directions.

use std::f64::consts::PI;

use lobe_env::Sun;
use lobe_io::Fingerprint;
use lobe_sh::Rgb;
use lobe_sh::sphere::vector::{Vec3, add_scaled, cross, dot, length, normalized, scale, sub, tangents_along_z};
use lobe_shadow::{LampSurface, PatchedRectangle, Placement};

/// A lamp in the world. It lights surfaces; it is no surface itself, so that no ray hits it and no eye sees it.
#[derive(Clone, Debug, PartialEq)]
pub struct Emitter {
    surface: LampSurface,
}

/// How far away the ball of a sun is, in diagonals of the scene: directions to it differ by 10⁻⁷ over the scene, as
/// much as directions of rays are rounded.
const FAR: f64 = 1e7;

/// A direction drawn from an emitter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct EmitterSample {
    /// A unit vector.
    pub(crate) towards: Vec3,
    /// To the emitter.
    pub(crate) distance: f64,
    /// By solid angle.
    pub(crate) density: f64,
    /// What arrives from there.
    pub(crate) radiance: Rgb<f64>,
}

impl Emitter {
    /// A lamp at a place: a scale makes it larger, not brighter.
    #[must_use]
    pub fn new(surface: &LampSurface, placement: &Placement) -> Self {
        let turned = |v: Vec3| sub(placement.to_world(v), placement.translation());
        let mut surface = surface.clone();
        match &mut surface {
            LampSurface::Ball { center, radius, .. } => {
                (*center, *radius) = (placement.to_world(*center), placement.scale() * *radius);
            }
            LampSurface::Rectangle(PatchedRectangle { rectangle: r, .. }) => {
                (r.corner, r.u, r.v) = (placement.to_world(r.corner), turned(r.u), turned(r.v));
            }
        }
        Self { surface }
    }

    /// A sun for what lies within these corners, in the world: a ball of its radiance, so far away that its direction
    /// differs by less than its own rounding between them.
    #[must_use]
    pub fn of_sun(sun: &Sun, [min, max]: [Vec3; 2]) -> Self {
        let middle = [0, 1, 2].map(|k| 0.5 * (min[k] + max[k]));
        let far = FAR * length(sub(max, min)).max(f64::MIN_POSITIVE);
        let center = add_scaled(middle, sun.direction.to_array(), far);
        let radius = far * (0.5 * sun.angular_diameter).sin();
        Self { surface: LampSurface::Ball { center, radius, radiance: sun.radiance() } }
    }

    /// The same in a frame whose origin is there.
    pub(crate) fn relative_to(&self, origin: Vec3) -> Self {
        let mut surface = self.surface.clone();
        let place = match &mut surface {
            LampSurface::Ball { center, .. } => center,
            LampSurface::Rectangle(patched) => &mut patched.rectangle.corner,
        };
        *place = sub(*place, origin);
        Self { surface }
    }

    /// A direction in which a point sees it if nothing is between; none where it is dark from there.
    pub(crate) fn sample(&self, from: Vec3, numbers: [f64; 2]) -> Option<EmitterSample> {
        match &self.surface {
            LampSurface::Ball { center, radius, radiance } => {
                Some(toward_ball(sub(*center, from), *radius, *radiance, numbers))
            }
            LampSurface::Rectangle(patched) => toward_rectangle(patched, from, numbers),
        }
    }

    /// Writes everything that identifies this lamp into a fingerprint, its shape first.
    pub(crate) fn write_into(&self, all: &mut Fingerprint) {
        all.word(match &self.surface {
            LampSurface::Ball { .. } => 0,
            LampSurface::Rectangle(_) => 1,
        });
        let mut write = |numbers: &[f64]| numbers.iter().for_each(|c| all.word(c.to_bits()));
        match &self.surface {
            LampSurface::Ball { center, radius, radiance } => {
                write(center);
                write(&[*radius]);
                write(&radiance.to_array());
            }
            LampSurface::Rectangle(PatchedRectangle { rectangle, patches, radiance }) => {
                write(&[rectangle.corner, rectangle.u, rectangle.v].concat());
                write(&[f64::from(u8::from(rectangle.two_sided)), patches[0] as f64, patches[1] as f64]);
                radiance.iter().for_each(|color| write(&color.to_array()));
            }
        }
    }
}

/// A direction to a point uniform over the area of a rectangle.
fn toward_rectangle(patched: &PatchedRectangle, from: Vec3, [a, b]: [f64; 2]) -> Option<EmitterSample> {
    let PatchedRectangle { rectangle: r, patches: [columns, rows], radiance } = patched;
    let normal = cross(r.u, r.v);
    let to = sub(add_scaled(add_scaled(r.corner, r.u, a), r.v, b), from);
    let distance = length(to);
    let towards = scale(to, distance.recip());
    // The area times the cosine at the emitter.
    let facing = -dot(towards, normal);
    let facing = if r.two_sided { facing.abs() } else { facing };
    let [i, j] = [(a, *columns), (b, *rows)].map(|(x, count)| ((x * count as f64) as usize).min(count - 1));
    (facing > 0.0 && distance > 0.0).then(|| EmitterSample {
        towards,
        distance,
        density: distance * distance / facing,
        radiance: radiance[j * columns + i],
    })
}

/// A direction uniform over the cone that a ball fills, or over the sphere from within, where its surface is at distance t:
///
/// ```text
///   |t s - c|² = r²        t = c·s + √((c·s)² + r² - |c|²)
/// ```
fn toward_ball(to: Vec3, radius: f64, radiance: Rgb<f64>, [a, b]: [f64; 2]) -> EmitterSample {
    let distance = length(to);
    if distance <= radius {
        let z = 1.0 - 2.0 * a;
        let (sin, cos) = (2.0 * PI * b).sin_cos();
        let r = (1.0 - z * z).max(0.0).sqrt();
        let towards = [r * cos, r * sin, z];
        let along = dot(to, towards);
        let half_chord = (along * along + (radius - distance) * (radius + distance)).sqrt();
        return EmitterSample { towards, distance: along + half_chord, density: 0.25 / PI, radiance };
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
    EmitterSample { towards, distance: distance * z - depth, density: 0.5 / (PI * height), radiance }
}

#[cfg(test)]
mod tests {
    use lobe_sh::{Coefficient as _, Rotation};
    use lobe_shadow::{Placement, Rectangle};

    use super::*;

    const WHITE: Rgb<f64> = Rgb::new(1.0, 1.0, 1.0);

    /// The irradiance along +z at the origin, by a grid of numbers.
    fn irradiance(surface: &LampSurface, at: [f64; 3]) -> Rgb<f64> {
        let emitter = Emitter::new(surface, &Placement::new(at, Rotation::IDENTITY, 1.0));
        let n = 200;
        let mut sum = Rgb::ZERO;
        for i in 0..n * n {
            let numbers = [i % n, i / n].map(|k| (k as f64 + 0.5) / n as f64);
            if let Some(sample) = emitter.sample([0.0; 3], numbers) {
                sum += sample.radiance.scale(sample.towards[2].max(0.0) / sample.density);
            }
        }
        sum.scale(((n * n) as f64).recip())
    }

    /// What a parallel rectangle of sides a and b sends to a point at distance 1 below its corner: its form factor times π (Siegel
    /// and Howell, configuration 4).
    fn below_corner(a: f64, b: f64) -> f64 {
        let (x, y) = ((1.0 + a * a).sqrt(), (1.0 + b * b).sqrt());
        0.5 * (a / x * (b / x).atan() + b / y * (a / y).atan())
    }

    #[test]
    fn irradiance_has_its_closed_form() {
        // A ball of radius r overhead at distance d sends π (r/d)²; from within everything.
        let found = irradiance(&LampSurface::ball(0.5, WHITE), [0.0, 0.0, 2.0]).g;
        assert!((found / (PI / 16.0) - 1.0).abs() < 1e-4, "a ball: {found}");
        let found = irradiance(&LampSurface::ball(3.0, WHITE), [0.0, 0.0, 2.0]).g;
        assert!((found / PI - 1.0).abs() < 1e-3, "within a ball: {found}");
        let off = LampSurface::Ball { center: [0.0, 0.0, 1.5], radius: 0.5, radiance: WHITE };
        let found = irradiance(&off, [0.0, 0.0, 0.5]).g;
        assert!((found / (PI / 16.0) - 1.0).abs() < 1e-4, "a ball off the middle of its frame: {found}");
        let (a, b) = (1.5_f64, 0.5_f64);
        let corner = below_corner(a, b);
        let shape = |v: [f64; 3], two_sided| {
            LampSurface::rectangle(Rectangle { corner: [0.0; 3], u: [a, 0.0, 0.0], v, two_sided }, WHITE)
        };
        // It shines towards u × v, which is down for a `v` of negative sign: with the corner at (0, b).
        let down = irradiance(&shape([0.0, -b, 0.0], false), [0.0, b, 1.0]).g;
        assert!((down / corner - 1.0).abs() < 1e-4, "a rectangle: {down}, expected {corner}");
        let up = irradiance(&shape([0.0, b, 0.0], false), [0.0, 0.0, 1.0]);
        assert!(up == Rgb::ZERO, "its back is dark: {up:?}");
        let both = irradiance(&shape([0.0, b, 0.0], true), [0.0, 0.0, 1.0]).g;
        assert!((both / corner - 1.0).abs() < 1e-4, "both sides shine: {both}");
    }

    #[test]
    fn from_within_a_ball_samples_end_on_its_surface() {
        let (center, radius) = ([0.3, -0.4, 1.2], 2.0);
        let surface = LampSurface::Ball { center, radius, radiance: WHITE };
        let emitter = Emitter::new(&surface, &Placement::IDENTITY);
        for numbers in [[0.01, 0.3], [0.5, 0.5], [0.9, 0.1], [0.99, 0.8]] {
            let sample = emitter.sample([0.0; 3], numbers).unwrap();
            let end = scale(sample.towards, sample.distance);
            let found = length(sub(end, center));
            assert!((found - radius).abs() < 1e-12, "{sample:?} ends {found} from the middle, the radius is {radius}");
        }
    }

    #[test]
    fn patches_shine_where_they_are() {
        // Halves along u in red and green, of the near row; the far row is dark but for blue at its end.
        let rectangle = Rectangle { corner: [0.0; 3], u: [2.0, 0.0, 0.0], v: [0.0, 1.0, 0.0], two_sided: true };
        let radiance = vec![Rgb::new(3.0, 0.0, 0.0), Rgb::new(0.0, 5.0, 0.0), Rgb::ZERO, Rgb::new(0.0, 0.0, 7.0)];
        let surface = LampSurface::Rectangle(PatchedRectangle { rectangle, patches: [2, 2], radiance });
        let found = irradiance(&surface, [0.0, 0.0, 1.0]);
        let [near, wide] = [below_corner(1.0, 0.5), below_corner(2.0, 0.5)];
        let expected =
            [3.0 * near, 5.0 * (wide - near), 7.0 * (below_corner(2.0, 1.0) - below_corner(1.0, 1.0) - wide + near)];
        for (found, expected) in found.to_array().into_iter().zip(expected) {
            assert!((found / expected - 1.0).abs() < 1e-4, "{found}, expected {expected}");
        }
    }
}
