//! Maps from the unit square to directions on the sphere and the hemisphere.

use std::f32::consts::{FRAC_PI_4, TAU};

use glam::Vec3;

/// Axes with a given third one, in which directions about a normal are written.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame {
    x: Vec3,
    y: Vec3,
    z: Vec3,
}

impl Frame {
    /// Axes about the unit vector `normal`.
    pub(crate) fn about(normal: [f32; 3]) -> Self {
        let z = Vec3::from(normal);
        let (x, y) = z.any_orthonormal_pair();
        Self { x, y, z }
    }

    fn world(&self, x: f32, y: f32, z: f32) -> [f32; 3] {
        (self.x * x + self.y * y + self.z * z).into()
    }

    /// A direction with density `max(n·s, 0)/π`: a point uniform in the unit disc, lifted to the hemisphere (Malley).
    pub(crate) fn cosine(&self, point: [f32; 2]) -> [f32; 3] {
        let [x, y] = disc(point);
        self.world(x, y, (1.0 - x * x - y * y).max(0.0).sqrt())
    }

    /// A direction uniform over the hemisphere, of density `1/2π`: the disc by Lambert's equal-area map.
    pub(crate) fn hemisphere(&self, point: [f32; 2]) -> [f32; 3] {
        let [x, y] = disc(point);
        let square = x * x + y * y;
        let stretch = (2.0 - square).max(0.0).sqrt();
        self.world(x * stretch, y * stretch, (1.0 - square).max(0.0))
    }
}

/// A direction uniform over the sphere, of density `1/4π`: heights are equally frequent (Archimedes).
pub(crate) fn sphere([u, v]: [f32; 2]) -> [f32; 3] {
    let z = 1.0 - 2.0 * u;
    let r = (2.0 * (u * (1.0 - u)).max(0.0).sqrt()).min(1.0);
    let (sin, cos) = (TAU * v).sin_cos();
    [r * cos, r * sin, z]
}

/// A point uniform in the unit disc: squares about the center become circles, so that neighbors stay neighbors
/// [Shirley and Chiu 1997].
fn disc([u, v]: [f32; 2]) -> [f32; 2] {
    let (a, b) = (2.0 * u - 1.0, 2.0 * v - 1.0);
    if a == 0.0 && b == 0.0 {
        return [0.0; 2];
    }
    if a.abs() > b.abs() {
        let (sin, cos) = (FRAC_PI_4 * (b / a)).sin_cos();
        [a * cos, a * sin]
    } else {
        let (sin, cos) = (FRAC_PI_4 * (a / b)).sin_cos();
        [b * sin, b * cos]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::sobol::Sobol;
    use lobe_testkit::{ChiSquare, Random, directions};
    use std::f64::consts::PI;

    /// The mean of a function over 2¹⁴ directions from the square.
    fn mean(warp: impl Fn([f32; 2]) -> [f32; 3], f: impl Fn(Vec3) -> f64) -> f64 {
        let sobol = Sobol::new(5, 0);
        let count = 1 << 14;
        (0..count).map(|i| f(warp(sobol.point(i, 0)).into())).sum::<f64>() / f64::from(count)
    }

    /// 2¹⁴ well distributed points, discontinuous integrands avoided.
    const TOLERANCE: f64 = 1e-4;

    #[test]
    fn directions_have_the_moments_of_their_density() {
        for n in directions().into_iter().map(|n| n.map(|c| c as f32)).step_by(7) {
            let (frame, normal) = (Frame::about(n), Vec3::from(n));
            let cos = |s: Vec3| f64::from(normal.dot(s));
            for (what, found, expected) in [
                ("cosine, first moment", mean(|p| frame.cosine(p), cos), 2.0 / 3.0),
                ("cosine, second", mean(|p| frame.cosine(p), |s| cos(s).powi(2)), 0.5),
                ("hemisphere, first", mean(|p| frame.hemisphere(p), cos), 0.5),
                ("hemisphere, second", mean(|p| frame.hemisphere(p), |s| cos(s).powi(2)), 1.0 / 3.0),
                ("sphere, first", mean(sphere, cos), 0.0),
                ("sphere, second", mean(sphere, |s| cos(s).powi(2)), 1.0 / 3.0),
                ("cosine, sideways", mean(|p| frame.cosine(p), |s| f64::from(frame.x.dot(s))), 0.0),
                ("hemisphere, x y", mean(|p| frame.hemisphere(p), |s| f64::from(frame.x.dot(s) * frame.y.dot(s))), 0.0),
            ] {
                assert!((found - expected).abs() < TOLERANCE, "{what} about {n:?}: {found}, expected {expected}");
            }
        }
    }

    #[test]
    fn directions_are_drawn_with_the_density_stated() {
        let normal = Vec3::new(0.6, -0.48, 0.64);
        let (frame, mut random) = (Frame::about(normal.into()), Random::new(2));
        let wide = |s: [f32; 3]| Some(s.map(f64::from));
        let cos = |s: [f64; 3]| normal.dot(Vec3::from(s.map(|c| c as f32)));
        let mut point = || [random.unit() as f32, random.unit() as f32];
        for (name, test) in [
            ("cosine", ChiSquare::new(200_000, || wide(frame.cosine(point())), |s| f64::from(cos(s).max(0.0)) / PI)),
            (
                "hemisphere",
                ChiSquare::new(
                    200_000,
                    || wide(frame.hemisphere(point())),
                    |s| if cos(s) > 0.0 { 0.5 / PI } else { 0.0 },
                ),
            ),
            ("sphere", ChiSquare::new(200_000, || wide(sphere(point())), |_| 0.25 / PI)),
        ] {
            // Chance passes 5 once in three million.
            assert!(test.z() < 5.0 && test.missing.abs() < 1e-3, "{name}: z = {}, {test:?}", test.z());
        }
    }

    #[test]
    fn corners_and_the_middle_of_the_square_give_unit_vectors() {
        let frame = Frame::about([0.0, 0.0, -1.0]);
        let last = 1.0_f32.next_down();
        for point in [[0.0, 0.0], [last, 0.0], [0.0, last], [last, last], [0.5, 0.5], [0.5, 0.0], [0.0, 0.5]] {
            for s in [frame.cosine(point), frame.hemisphere(point), sphere(point)] {
                let length = Vec3::from(s).length();
                assert!((length - 1.0).abs() < 1e-6, "{point:?} gives {s:?} of length {length}");
            }
        }
    }
}
