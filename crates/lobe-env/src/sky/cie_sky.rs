//! CIE standard general skies (ISO 15469:2004).

use std::f64::consts::FRAC_PI_2;

use lobe_sh::{Coefficient, Dir, Rgb};

use crate::error::EnvError;
use crate::sky::preetham::check_sun;
use crate::sky::sky::Sky;

/// One of the CIE standard general skies (ISO 15469:2004, CIE S 011/E:2003), from heavily overcast to cloudless.
///
/// ```text
///   L = L_z φ(θ) f(γ) / (φ(0) f(θ_sun))              θ from the zenith, γ from the sun
///   φ(θ) = 1 + a e^{b/cos θ},  φ(π/2) = 1            gradation from zenith to horizon
///   f(γ) = 1 + c (e^{dγ} - e^{dπ/2}) + e cos²γ       scattering around the sun
/// ```
///
/// The standard is in luminance; the zenith's color is a factor of every direction.
///
/// | type | sky | gradation | scattering |
/// |---|---|---|---|
/// | 1 to 4 | overcast: steep, steep and brighter towards the sun, moderate, moderate and brighter | I, I, II, II | 1, 2, 1, 2 |
/// | 5 | overcast, the same everywhere | III | 1 |
/// | 6 to 8 | partly cloudy, no gradation, ever brighter about the sun | III | 2, 3, 4 |
/// | 9 to 11 | partly cloudy: hidden sun, brighter about the sun, white-blue | IV | 2, 3, 4 |
/// | 12, 13 | clear, low turbidity; clear, polluted | V | 4, 5 |
/// | 14, 15 | cloudless, turbid, broad corona; white-blue, turbid, broad corona | VI | 5, 6 |
/// | 16 | the traditional overcast sky `L = L_z (1 + 2 cos θ)/3` (Moon and Spencer 1942), a separate formula of the standard | | |
///
/// Types and parameters are those of the standard as [Darula and Kittler 2002] publish them, table 1.
///
/// [Darula and Kittler 2002]: https://publications.ibpsa.org/proceedings/esim/2002/papers/esim2002_o2.pdf
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CieSky {
    sun: Dir,
    shape: Shape,
    /// `L_z / (φ(0) f(θ_sun))`.
    scale: Rgb<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Shape {
    General { gradation: [f64; 2], scattering: [f64; 3] },
    TraditionalOvercast,
}

/// `a` and `b` of the groups I to VI.
const GRADATIONS: [[f64; 2]; 6] = [[4.0, -0.7], [1.1, -0.8], [0.0, -1.0], [-1.0, -0.55], [-1.0, -0.32], [-1.0, -0.15]];

/// `c`, `d` and `e` of the groups 1 to 6.
const SCATTERINGS: [[f64; 3]; 6] = [
    [0.0, -1.0, 0.0],
    [2.0, -1.5, 0.15],
    [5.0, -2.5, 0.30],
    [10.0, -3.0, 0.45],
    [16.0, -3.0, 0.30],
    [24.0, -2.8, 0.15],
];

/// The groups of the types 1 to 15, from 1.
const TYPES: [(usize, usize); 15] = [
    (1, 1),
    (1, 2),
    (2, 1),
    (2, 2),
    (3, 1),
    (3, 2),
    (3, 3),
    (3, 4),
    (4, 2),
    (4, 3),
    (4, 4),
    (5, 4),
    (5, 5),
    (6, 5),
    (6, 6),
];

impl CieSky {
    /// The sky of type 1 to 16 with this radiance (or luminance) at the zenith.
    ///
    /// # Errors
    /// [`EnvError::Options`] for any other type, or a sun below the horizon.
    pub fn new(kind: usize, sun: Dir, zenith: Rgb<f64>) -> Result<Self, EnvError> {
        check_sun(sun)?;
        let shape = match (kind, kind.checked_sub(1).and_then(|k| TYPES.get(k))) {
            (_, Some(&(gradation, scattering))) => {
                Shape::General { gradation: GRADATIONS[gradation - 1], scattering: SCATTERINGS[scattering - 1] }
            }
            (16, None) => Shape::TraditionalOvercast,
            _ => return Err(EnvError::Options(format!("a CIE sky of type 1 to 16 expected, found {kind}"))),
        };
        let scale = zenith.scale(shape.value(1.0, sun.theta()).recip());
        Ok(Self { sun, shape, scale })
    }
}

impl Shape {
    /// `φ f`.
    fn value(self, cos_theta: f64, gamma: f64) -> f64 {
        match self {
            Self::General { gradation: [a, b], scattering: [c, d, e] } => {
                // At the horizon b/cos θ is -∞ and its exponential 0: no limit needs to be taken.
                let phi = 1.0 + a * (b / cos_theta).exp();
                let cos_gamma = gamma.cos();
                phi * (1.0 + c * ((d * gamma).exp() - (d * FRAC_PI_2).exp()) + e * cos_gamma * cos_gamma)
            }
            Self::TraditionalOvercast => (1.0 + 2.0 * cos_theta) / 3.0,
        }
    }
}

impl Sky for CieSky {
    fn sun(&self) -> Dir {
        self.sun
    }

    fn radiance(&self, s: Dir) -> Rgb<f64> {
        if s.z() < 0.0 {
            return Rgb::ZERO;
        }
        // Adding zero turns -0 into 0, whose quotient has the right sign.
        self.scale.scale(self.shape.value(s.z() + 0.0, s.angle_to(self.sun)))
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::area_light::vector_irradiance::VectorIrradiance;
    use crate::sky::sky::{Ground, sky_sh};

    #[test]
    fn every_sky_has_its_zenith_and_is_positive() {
        for kind in 1..=16 {
            for theta in [0.0, 0.5, 1.0, 1.4] {
                let sky = CieSky::new(kind, Dir::from_angles(theta, 0.3), Rgb::new(1.0, 2.0, 3.0)).unwrap();
                let zenith = sky.radiance(Dir::Z);
                assert!((zenith.g - 2.0).abs() < 1e-14, "type {kind}: {zenith:?}");
                for v in lobe_testkit::directions() {
                    let s = Dir::new(v).unwrap();
                    let value = sky.radiance(s).r;
                    let good = if s.z() < 0.0 { value == 0.0 } else { value > 0.0 && value.is_finite() };
                    assert!(good, "type {kind}, sun at {theta}, towards {s:?}: {value}");
                }
            }
        }
    }

    #[test]
    fn the_traditional_overcast_sky_leaves_seven_ninths_of_pi() {
        let sky = CieSky::new(16, Dir::Z, Rgb::splat(1.0)).unwrap();
        let e = VectorIrradiance::from_radiance_sh(&sky_sh(&sky, &Ground::default(), 3)).net(Dir::Z);
        assert!((e.r - 7.0 * PI / 9.0).abs() < 1e-12, "{e:?}");
    }

    #[test]
    fn type_five_is_the_same_everywhere() {
        let sky = CieSky::new(5, Dir::from_angles(1.0, 2.0), Rgb::splat(1.0)).unwrap();
        for s in [Dir::Z, Dir::X, Dir::from_angles(1.0, 2.0)] {
            assert!((sky.radiance(s).r - 1.0).abs() < 1e-15, "towards {s:?}");
        }
    }

    #[test]
    fn the_overcast_types_have_their_gradation() {
        // 1: the horizon has 1/(1 + 4 e^{-0.7}) of the zenith, close to the traditional third.
        let sky = CieSky::new(1, Dir::Z, Rgb::splat(1.0)).unwrap();
        let horizon = sky.radiance(Dir::X).r;
        assert!((horizon - 1.0 / (1.0 + 4.0 * (-0.7_f64).exp())).abs() < 1e-14, "{horizon}");
        assert!((horizon - 1.0 / 3.0).abs() < 0.01, "{horizon}");
    }

    #[test]
    fn type_twelve_is_the_clear_sky_of_kittler() {
        // Kittler 1967, the CIE's clear sky of 1973. Its constant 0.91 is 1 - 10 e^{-3π/2} of the general sky, rounded.
        let light = |theta: f64, gamma: f64| {
            let scattering = |gamma: f64| 0.91 + 10.0 * (-3.0 * gamma).exp() + 0.45 * gamma.cos().powi(2);
            scattering(gamma) * (1.0 - (-0.32 / theta.cos()).exp()) / (1.0 - f64::exp(-0.32))
        };
        for theta in [0.0, 0.4, 1.0, 1.5] {
            let sun = Dir::from_angles(theta, -0.8);
            let sky = CieSky::new(12, sun, Rgb::splat(1.0)).unwrap();
            for s in lobe_testkit::directions().into_iter().filter_map(Dir::new).filter(|s| s.z() > 1e-3) {
                let expected = light(s.theta(), s.angle_to(sun)) / light(0.0, theta);
                let found = sky.radiance(s).r;
                assert!((found / expected - 1.0).abs() < 0.01, "sun at {theta}, {s:?}: {found} against {expected}");
            }
        }
    }

    #[test]
    fn other_types_are_refused() {
        for kind in [0, 17, usize::MAX] {
            assert!(CieSky::new(kind, Dir::Z, Rgb::splat(1.0)).is_err(), "type {kind}");
        }
    }
}
