//! Analytic skies: radiance over the upper hemisphere, and its expansion.

use std::f64::consts::{FRAC_PI_2, PI};

use lobe_sh::basis::{coefficient_count, coefficient_index, eval_basis_into, legendre};
use lobe_sh::sphere::gauss_legendre;
use lobe_sh::{Coefficient, Dir, Expansion, Rgb, ShVec};

use crate::area_light::vector_irradiance::VectorIrradiance;
use crate::map::env_map::EnvMap;

/// Gauss-Legendre nodes on each panel of zenith angles and on the half circle of azimuths, before those that the order
/// adds. The radiance has a cusp at the sun; panels meet there and their nodes cluster towards it. The coefficients of
/// the skies of this crate are then accurate to 1e-8 of the largest (test `the_projection_of_skies_has_converged`).
const NODES: usize = 32;

/// Further ends of panels, as cosines of the zenith angle: the factor `e^{b/cos θ}` of every sky changes fast there.
const HORIZON_PANELS: [f64; 2] = [0.04, 0.2];

/// The exponent of the clustering: the distance from the sun is this power of the parameter.
const CROWDING: i32 = 3;

/// An analytic sky: the direction of the sun, and a radiance for every direction above the horizon.
///
/// Every sky here is mirror-symmetric about the vertical plane through the sun. The disc of the sun is not part of it:
/// add it as a light ([`SphereLight`](crate::SphereLight), or an impulse).
///
/// This crate has two: [`PreethamSky`](crate::PreethamSky), clear weather in color, and [`CieSky`](crate::CieSky),
/// every weather in luminance. The model of Hosek and Wilkie (2012) is not included: it is a table of some thousand
/// fitted numbers, and no crate that carries them is maintained (`hw-skymodel`, MIT, had its only two releases on one
/// day of 2023). It would be one more implementation of this trait.
pub trait Sky: Sync {
    /// The direction of the sun, not below the horizon.
    fn sun(&self) -> Dir;

    /// The radiance from the direction `s`; zero below the horizon.
    fn radiance(&self, s: Dir) -> Rgb<f64>;

    /// Zenith angles, other than the horizon's and the sun's, where the radiance or its slope jumps.
    fn breaks(&self) -> Vec<f64> {
        Vec::new()
    }
}

/// The ground below the horizon: a Lambertian plane lit by the sky and the sun.
///
/// ```text
///   L = ρ (E_sky + E_sun)/π          E_sky = ∫_upper L cos θ ds = √(4π/3) f_10 of the sky alone
/// ```
///
/// The default ground is black.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ground {
    /// The albedo ρ, each channel in `[0, 1]`.
    pub albedo: Rgb<f64>,
    /// The irradiance `E_sun` of the sun on the horizontal ground, in the sky's unit times steradian.
    pub sun: Rgb<f64>,
}

impl Ground {
    /// The radiance of the ground under a sky whose irradiance on the ground is `sky`.
    #[must_use]
    pub fn radiance(&self, sky: Rgb<f64>) -> Rgb<f64> {
        (self.albedo * (sky + self.sun)).scale(PI.recip())
    }

    /// Adds the ground to the expansion of a sky that is black below the horizon.
    ///
    /// The lower hemisphere of radiance 1 has the coefficients of a cone of half angle 90° about -z ([Sloan 2008] A3):
    ///
    /// ```text
    ///   f_00 = √π        f_l0 = (-1)^l √(π/(2l+1)) (P_{l-1}(0) - P_{l+1}(0))        f_lm = 0
    /// ```
    ///
    /// # Panics
    /// If the order is below 2: without band 1 the irradiance on the ground is unknown.
    ///
    /// [Sloan 2008]: https://www.ppsloan.org/publications/StupidSH36.pdf
    pub fn add_to(&self, sky: &mut ShVec<Rgb<f64>>) {
        assert!(sky.order() >= 2, "the ground needs a sky of order 2 at least, not {}", sky.order());
        let radiance = self.radiance(VectorIrradiance::from_radiance_sh(sky).net(Dir::Z));
        sky[0] += radiance.scale(PI.sqrt());
        // P_{l-1}(0) = P_{l+1}(0) = 0 for even l.
        for l in (1..sky.order()).step_by(2) {
            let cone = (PI / (2 * l + 1) as f64).sqrt() * (legendre(l - 1, 0, 0.0) - legendre(l + 1, 0, 0.0));
            sky[coefficient_index(l, 0)] += radiance.scale(-cone);
        }
    }
}

/// The coefficients of a sky and its ground, by quadrature over the upper hemisphere alone.
///
/// ```text
///   f_lm = ∫_0^{π/2} P̃_lm(cos θ) sin θ ∫_0^{2π} L(θ, φ) cos m(φ - φ_sun) dφ dθ,  then turned about z by φ_sun
/// ```
///
/// The discontinuity at the horizon is an end of the interval, the cusp at the sun a common corner of panels, towards
/// which the nodes cluster: the result has no noise, and no ringing beyond that of the truncation. In the frame of the
/// sun's plane all sine coefficients vanish: half of the azimuths are enough.
#[must_use]
pub fn sky_sh(sky: &impl Sky, ground: &Ground, order: usize) -> ShVec<Rgb<f64>> {
    let mut f = upper_sh(sky, order.max(2), NODES);
    ground.add_to(&mut f);
    f.resized(order)
}

/// The picture of a sky and its ground, sampled at each texel's center.
///
/// # Panics
/// If a side is 0.
#[must_use]
pub fn sky_map(sky: &impl Sky, ground: &Ground, width: usize, height: usize) -> EnvMap {
    let horizontal = VectorIrradiance::from_radiance_sh(&upper_sh(sky, 2, NODES)).net(Dir::Z);
    let below = Rgb::narrow(ground.radiance(horizontal));
    EnvMap::from_fn(width, height, |s| if s.z() < 0.0 { below } else { Rgb::narrow(sky.radiance(s)) })
}

/// Turns an expansion without sine coefficients, `f_l,-m = 0`, about +z by `phi`.
///
/// ```text
///   g_lm = cos(mφ) f_lm        g_l,-m = sin(mφ) f_lm        m > 0
/// ```
pub(crate) fn turn_to_azimuth(f: &mut ShVec<Rgb<f64>>, phi: f64) {
    for m in 1..f.order() {
        let (sin, cos) = (m as f64 * phi).sin_cos();
        for l in m..f.order() {
            let value = f[coefficient_index(l, m as isize)];
            f[coefficient_index(l, m as isize)] = value.scale(cos);
            f[coefficient_index(l, -(m as isize))] = value.scale(sin);
        }
    }
}

/// The expansion of the sky alone.
fn upper_sh(sky: &impl Sky, order: usize, nodes: usize) -> ShVec<Rgb<f64>> {
    let sun = sky.sun();
    let theta_sun = sun.theta().min(FRAC_PI_2);
    let rule = gauss_legendre(nodes + order);
    // Measure azimuths from the sun's, on one side of it.
    let azimuths: Vec<(f64, f64)> = rule.iter().map(|&(x, weight)| crowded(0.0, PI, x, weight)).collect();
    let waves: Vec<Vec<f64>> =
        azimuths.iter().map(|&(phi, w)| (0..order).map(|m| 2.0 * w * (m as f64 * phi).cos()).collect()).collect();
    let mut ends = vec![0.0, FRAC_PI_2];
    ends.extend(sky.breaks());
    ends.extend(HORIZON_PANELS.map(f64::acos));
    ends.push(theta_sun);
    ends.sort_by(f64::total_cmp);

    let mut f = ShVec::zero(order);
    let mut basis = vec![0.0; coefficient_count(order)];
    for panel in ends.windows(2).filter(|panel| panel[1] > panel[0]) {
        for &(x, weight) in &rule {
            let (theta, weight) = match () {
                () if panel[0] == theta_sun => crowded(panel[0], panel[1], x, weight),
                () if panel[1] == theta_sun => crowded(panel[1], panel[0], x, weight),
                () => (0.5 * (panel[0] + panel[1] + x * (panel[1] - panel[0])), 0.5 * weight * (panel[1] - panel[0])),
            };
            let (sin, cos) = theta.sin_cos();
            let mut sums = vec![Rgb::ZERO; order];
            for (&(phi, _), wave) in azimuths.iter().zip(&waves) {
                let radiance = sky.radiance(Dir::from_angles(theta, phi + sun.phi()));
                for (sum, w) in sums.iter_mut().zip(wave) {
                    *sum += radiance.scale(*w);
                }
            }
            // Towards φ = 0 the basis function of m >= 0 is its Legendre factor.
            eval_basis_into([sin, 0.0, cos], &mut basis);
            for l in 0..order {
                for (m, sum) in sums.iter().enumerate().take(l + 1) {
                    let i = coefficient_index(l, m as isize);
                    f[i] += sum.scale(weight * sin * basis[i]);
                }
            }
        }
    }
    turn_to_azimuth(&mut f, sun.phi());
    f
}

/// Maps the node `x` in `(-1, 1)` and its weight to the interval from `near` to `far`, clustered towards `near`.
fn crowded(near: f64, far: f64, x: f64, weight: f64) -> (f64, f64) {
    let t = 0.5 * (1.0 + x);
    let slope = f64::from(CROWDING) * t.powi(CROWDING - 1);
    (near + (far - near) * t.powi(CROWDING), 0.5 * weight * slope * (far - near).abs())
}

#[cfg(test)]
mod tests {
    use lobe_sh::Zonal;

    use super::*;
    use crate::sky::cie_sky::CieSky;
    use crate::sky::preetham::PreethamSky;

    struct Even;

    impl Sky for Even {
        fn sun(&self) -> Dir {
            Dir::from_angles(0.7, 2.0)
        }

        fn radiance(&self, s: Dir) -> Rgb<f64> {
            if s.z() < 0.0 { Rgb::ZERO } else { Rgb::new(1.0, 2.0, 3.0) }
        }
    }

    fn largest(f: &ShVec<Rgb<f64>>) -> f64 {
        f.coefficients().iter().flat_map(|c| c.to_array()).fold(0.0, |a, b| a.max(b.abs()))
    }

    #[test]
    fn the_projection_of_skies_has_converged() {
        for theta in [0.0, 1e-3, 0.4, 0.785, 1.3, 1.565, FRAC_PI_2] {
            let sun = Dir::from_angles(theta, -2.5);
            let check = |name: &str, coarse: &ShVec<Rgb<f64>>, fine: &ShVec<Rgb<f64>>| {
                let error = largest(&(coarse - fine)) / largest(fine);
                println!("{name}, sun at {theta}: {error:.1e}");
                assert!(error < 1e-8, "{name}, sun at {theta}: {error:.1e}");
            };
            for turbidity in [2.0, 4.0, 10.0] {
                let sky = PreethamSky::new(turbidity, sun).unwrap();
                check(&format!("Preetham {turbidity}"), &upper_sh(&sky, 7, NODES), &upper_sh(&sky, 7, 2 * NODES));
            }
            for kind in [1, 8, 13, 15] {
                let sky = CieSky::new(kind, sun, Rgb::splat(1.0)).unwrap();
                check(&format!("CIE {kind}"), &upper_sh(&sky, 7, NODES), &upper_sh(&sky, 7, 2 * NODES));
            }
        }
    }

    #[test]
    fn a_smooth_sky_equals_a_rule_that_is_exact_for_it() {
        // A polynomial above the horizon: add its mirror image below and project with a rule that is exact.
        struct Smooth;
        impl Sky for Smooth {
            fn sun(&self) -> Dir {
                Dir::from_angles(0.9, 1.1)
            }
            fn radiance(&self, s: Dir) -> Rgb<f64> {
                let t = s.dot(self.sun());
                Rgb::splat(1.0 + t * s.z() + t * t)
            }
        }
        let upper = upper_sh(&Smooth, 6, NODES);
        // Exact: after the sum over azimuths the integrand is a polynomial in z.
        let mut exact = vec![0.0; 36];
        for (x, weight) in gauss_legendre(20) {
            let z = 0.5 * (1.0 + x);
            let r = ((1.0 - z) * (1.0 + z)).sqrt();
            for k in 0..32 {
                let (sin, cos) = (PI * f64::from(k) / 16.0).sin_cos();
                let s = Dir::from_unit([r * cos, r * sin, z]);
                for (sum, y) in exact.iter_mut().zip(lobe_sh::eval_basis(s, 6)) {
                    *sum += 0.5 * weight * PI / 16.0 * Smooth.radiance(s).r * y;
                }
            }
        }
        for (i, expected) in exact.into_iter().enumerate() {
            assert!((upper[i].r - expected).abs() < 1e-12, "coefficient {i}: {:?} against {expected}", upper[i]);
        }
    }

    #[test]
    fn an_even_sky_is_a_cone_of_ninety_degrees() {
        let f = sky_sh(&Even, &Ground::default(), 8);
        let cone = Zonal::project(8, &[0.0], 20, |t| if t > 0.0 { 1.0 } else { 0.0 });
        for i in 0..64_usize {
            let expected = if i == coefficient_index(i.isqrt(), 0) { cone.coefficients()[i.isqrt()] } else { 0.0 };
            assert!((f[i].g - 2.0 * expected).abs() < 1e-12, "coefficient {i}: {:?} against {expected}", f[i]);
        }
    }

    #[test]
    fn a_white_ground_under_an_even_sky_closes_the_furnace() {
        let ground = Ground { albedo: Rgb::splat(1.0), sun: Rgb::ZERO };
        let f = sky_sh(&Even, &ground, 8);
        let all = ShVec::constant(8, Rgb::new(1.0, 2.0, 3.0));
        assert!(largest(&(&f - &all)) < 1e-12, "{f:?}");
        let map = sky_map(&Even, &ground, 8, 4);
        for texel in map.texels() {
            assert!((texel.b - 3.0).abs() < 1e-6, "{texel:?}");
        }
    }

    #[test]
    fn the_ground_reflects_the_sun_as_well() {
        let ground = Ground { albedo: Rgb::new(0.5, 0.0, 1.0), sun: Rgb::splat(PI) };
        let f = sky_sh(&Even, &ground, 2);
        let dark = sky_sh(&Even, &Ground::default(), 2);
        // The ground of radiance L adds √π L to the mean: L = ρ (1 or 3 + 1).
        let added = f[0] - dark[0];
        assert!((added.r - PI.sqrt()).abs() < 1e-12 && added.g == 0.0, "{added:?}");
        assert!((added.b - 4.0 * PI.sqrt()).abs() < 1e-12, "{added:?}");
    }

    #[test]
    fn order_one_and_zero_are_cut_from_higher_ones() {
        let ground = Ground { albedo: Rgb::splat(0.3), sun: Rgb::ZERO };
        let f = sky_sh(&Even, &ground, 3);
        let first = sky_sh(&Even, &ground, 1);
        assert!(largest(&(&first - &f.resized(1))) < 1e-12, "order 1: {first:?}");
        assert_eq!(sky_sh(&Even, &ground, 0).order(), 0, "order 0");
    }
}
