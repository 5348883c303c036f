//! Cones of light, with a hard edge (also the light of a sphere) and with a soft one.

use core::f64::consts::PI;

use crate::expansion::Zonal;
use crate::expansion::zonal::zonal_norm;
use crate::prelude::*;

/// Below this `x = ka` the series of [`ease_sine`] is summed, above it its closed form is taken. There the closed form
/// has lost a factor of 3 by cancellation, and the series needs [`SERIES_TERMS`].
const SERIES_LIMIT: f64 = 2.0;

/// The first term left out is below `2^29/29! = 6e-23` of the first.
const SERIES_TERMS: usize = 14;

impl Zonal {
    /// Radiance 1 within `half_angle` (radians, in `[0, π]`) of the axis, 0 outside.
    ///
    /// The same as the light of a sphere of radius `r` at distance `d`, with `half_angle = asin(r/d)`. With `a` the
    /// half angle and `c = cos a` ([Sloan 2008] A3, where band 3 is misprinted):
    ///
    /// ```text
    ///   z_0 = √π (1 - c)                     = 2√π sin²(a/2)
    ///   z_l = √(π/(2l+1)) (P_{l-1}(c) - P_{l+1}(c))
    ///       = √(π (2l+1)) sin² a P_l'(c) / (l(l+1))            P_{l+1}' = P_{l-1}' + (2l+1) P_l
    /// ```
    ///
    /// The second form of each line is computed: nothing cancels, so that small discs keep all their digits. The tests
    /// `hard_cones_equal_quadrature` (1e-12) and `small_cones_keep_their_digits` (relative 1e-12) bound the error.
    /// With `half_angle` 0 it is zero, with π the constant 1.
    ///
    /// # Panics
    /// If `half_angle` is outside `[0, π]`.
    ///
    /// [Sloan 2008]: https://www.ppsloan.org/publications/StupidSH36.pdf
    #[must_use]
    pub fn cone(order: usize, half_angle: f64) -> Self {
        assert!((0.0..=PI).contains(&half_angle), "the half angle of a cone lies in [0, π], it is not {half_angle}");
        let cosine = half_angle.cos();
        let sine_squared = half_angle.sin().powi(2);
        // P_{l-1}, P_l and P_{l-1}', P_l'
        let (mut p_before, mut p) = (0.0, 1.0);
        let (mut slope_before, mut slope) = (0.0, 0.0);
        let band = |l: usize| {
            if l == 0 {
                return 2.0 * PI.sqrt() * (0.5 * half_angle).sin().powi(2);
            }
            let lf = l as f64;
            (slope_before, slope) = (slope, slope_before + (2.0 * lf - 1.0) * p);
            (p_before, p) = (p, ((2.0 * lf - 1.0) * cosine * p - (lf - 1.0) * p_before) / lf);
            (PI * (2.0 * lf + 1.0)).sqrt() * sine_squared * slope / (lf * (lf + 1.0))
        };
        Self::new((0..order).map(band).collect())
    }

    /// Radiance that falls from 1 at the axis to 0 at `half_angle` (radians, in `[0, π]`) and beyond.
    ///
    /// The fall is the cubic ease `f(t) = 1 - 3 (t/a)² + 2 (t/a)³` of [Sloan 2008], flat at both ends, `t` the angle
    /// from the axis and `a` the half angle. One closed form serves every band, because `P_l(cos t) sin t` is a sum of
    /// few sines:
    ///
    /// ```text
    ///   P_l(cos t) = Σ_{j=0}^{l} c_j c_{l-j} cos((l-2j) t)        c_j = (2j)! / (4^j j!²)
    ///   P_l(cos t) sin t = Σ_k b_k sin kt                         k = l+1, l-1, .. > 0
    ///
    ///   z_l = 2π K_l Σ_k b_k s_k        s_k = ∫_0^a f(t) sin kt dt = (1 + 6(1 + cos x)/x² - 12 sin x/x³)/k,    x = ka
    /// ```
    ///
    /// The terms in parentheses cancel to `0.15 x²` for small `x`, which is why the printed forms fail in `f32` below 8
    /// degrees (A4 of the paper, where bands 1 and 2 are also misprinted). Below `x = 2` the power series of `s_k`
    /// takes over, so that `z_l` has an error of 1e-12 at every angle, relative to itself or, where it passes through
    /// zero, to a thousandth of the largest band: tests `soft_cones_equal_quadrature_to_every_digit` and, for `f32`,
    /// `soft_cones_in_f32_are_good_to_1e_5_at_every_angle`. With `half_angle` 0 it is zero.
    ///
    /// # Panics
    /// If `half_angle` is outside `[0, π]`.
    ///
    /// [Sloan 2008]: https://www.ppsloan.org/publications/StupidSH36.pdf
    #[must_use]
    pub fn soft_cone(order: usize, half_angle: f64) -> Self {
        assert!((0.0..=PI).contains(&half_angle), "the half angle of a cone lies in [0, π], it is not {half_angle}");
        let sines: Vec<f64> = (0..=order).map(|k| ease_sine(k, half_angle)).collect();
        // c_j = c_{j-1} (2j-1)/(2j)
        let mut c = vec![1.0; order.max(1)];
        for j in 1..order {
            c[j] = c[j - 1] * (2 * j - 1) as f64 / (2 * j) as f64;
        }
        // cos(qt) sin t = (sin (q+1)t - sin (q-1)t) / 2, where sin of a negative angle and sin 0 enter as they are.
        let sine = |k: isize| if k < 0 { -sines[k.unsigned_abs()] } else { sines[k.unsigned_abs()] };
        let band = |l: usize| {
            let term = |j: usize| {
                let q = l as isize - 2 * j as isize;
                0.5 * c[j] * c[l - j] * (sine(q + 1) - sine(q - 1))
            };
            2.0 * PI * zonal_norm(l) * (0..=l).map(term).sum::<f64>()
        };
        Self::new((0..order).map(band).collect())
    }
}

/// `∫_0^a f(t) sin kt dt` of the ease `f`; see [`Zonal::soft_cone`].
///
/// ```text
///   = (1/k) Σ_j (-1)^j x^{2j+2}/(2j+1)! (1/(2j+2) - 3/(2j+4) + 2/(2j+5))        x = ka
/// ```
pub(crate) fn ease_sine(k: usize, a: f64) -> f64 {
    if k == 0 {
        return 0.0;
    }
    let kf = k as f64;
    let x = kf * a;
    if x > SERIES_LIMIT {
        return (1.0 + 6.0 * (1.0 + x.cos()) / (x * x) - 12.0 * x.sin() / (x * x * x)) / kf;
    }
    let (mut power, mut sum) = (x * x, 0.0);
    for j in 0..SERIES_TERMS {
        let m = 2.0 * j as f64;
        sum += power * (1.0 / (m + 2.0) - 3.0 / (m + 4.0) + 2.0 / (m + 5.0));
        power *= -(x * x) / ((m + 2.0) * (m + 3.0));
    }
    sum / kf
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sphere::quadrature::gauss_legendre;
    use lobe_testkit::golden_f64s;

    /// From a hundredth of a degree to the whole sphere, evenly in the logarithm, and the angles of the golden values.
    fn half_angles() -> Vec<f64> {
        let spread = (0..=60).map(|k| 0.01 * 18000.0_f64.powf(f64::from(k) / 60.0));
        spread.chain([0.5, 2.0, 8.0, 12.5, 30.0, 45.0, 90.0, 120.0]).map(|a| a.min(180.0).to_radians()).collect()
    }

    #[test]
    fn hard_cones_equal_quadrature() {
        for a in half_angles() {
            for order in 1..=10 {
                let c = a.cos();
                let expected = Zonal::project(order, &[c], 8, |t| f64::from(u8::from(t > c)));
                for (l, (z, q)) in Zonal::cone(order, a).coefficients().iter().zip(expected.coefficients()).enumerate()
                {
                    assert!((z - q).abs() < 1e-12, "{} degrees, order {order}, band {l}: {z}, {q}", a.to_degrees());
                }
            }
        }
    }

    #[test]
    fn hard_cones_have_their_golden_coefficients() {
        for degrees in ["0.5", "2", "8", "15", "30", "45", "60", "90", "120", "180"] {
            let cone = Zonal::cone(8, degrees.parse::<f64>().unwrap().to_radians());
            for (l, (z, golden)) in
                cone.coefficients().iter().zip(golden_f64s(&format!("/cone_zh/{degrees}"))).enumerate()
            {
                assert!((z - golden).abs() < 1e-14, "{degrees} degrees, band {l}: {z} against {golden}");
            }
        }
    }

    // Where (l+1) a is small, P_l(cos t) = J_0((l + ½) t) + O(t²), and the integral of the first two terms of its
    // series is z_l = √π √(2l+1) a²/2 (1 - (l² + l + ⅔) a²/8 .. ), good to a relative O((l a)⁴).
    #[test]
    fn small_cones_keep_their_digits() {
        for a in [1e-4, 1e-6, 1e-9, 1e-100_f64] {
            for (l, z) in Zonal::cone(10, a).coefficients().iter().enumerate() {
                let lf = l as f64;
                // ∫_0^a (1 - l(l+1) t²/4)(t - t³/6) dt
                let ratio = 1.0 - (lf * (lf + 1.0) + 2.0 / 3.0) * a * a / 8.0;
                let expected = (PI * (2.0 * lf + 1.0)).sqrt() * 0.5 * a * a * ratio;
                assert!((z / expected - 1.0).abs() < 1e-12, "a {a}, band {l}: {z} against {expected}");
            }
        }
    }

    #[test]
    fn the_whole_sphere_is_the_constant_and_no_cone_is_zero() {
        for (l, z) in Zonal::cone(20, PI).coefficients().iter().enumerate() {
            let expected = if l == 0 { 2.0 * PI.sqrt() } else { 0.0 };
            assert!((z - expected).abs() < 1e-14, "band {l}: {z}");
        }
        assert_eq!(Zonal::cone(4, 0.0), Zonal::new(vec![0.0; 4]), "a half angle of 0");
        assert_eq!(Zonal::cone(0, 1.0).order(), 0, "order 0");
    }

    #[test]
    #[should_panic(expected = "half angle of a cone")]
    fn a_half_angle_beyond_the_sphere_is_refused() {
        let _ = Zonal::cone(2, 3.2);
    }

    fn many_half_angles() -> impl Iterator<Item = f64> {
        (0..=400).map(|k| (0.01 * 18000.0_f64.powf(f64::from(k) / 400.0)).min(180.0).to_radians())
    }

    /// A soft cone is a mixture of hard ones: `∫_0^1 6u(1-u) cone(a u) du`, since `-f'(t) dt = 6u(1-u) du` with `t = a
    /// u`. The hard cones of small angles keep their digits, so this keeps all digits too.
    fn mixture(order: usize, a: f64) -> Vec<f64> {
        let mut sum = vec![0.0; order];
        for (x, weight) in gauss_legendre(24 + 2 * order) {
            let u = 0.5 * (1.0 + x);
            for (sum, z) in sum.iter_mut().zip(Zonal::cone(order, a * u).coefficients()) {
                *sum += 0.5 * weight * 6.0 * u * (1.0 - u) * z;
            }
        }
        sum
    }

    #[test]
    fn soft_cones_equal_quadrature_to_every_digit() {
        let mut worst = 0.0_f64;
        for a in many_half_angles() {
            let expected = mixture(10, a);
            let largest = expected.iter().fold(0.0_f64, |m, z| m.max(z.abs()));
            for (l, (z, q)) in Zonal::soft_cone(10, a).coefficients().iter().zip(&expected).enumerate() {
                // Relative to the band; one that passes through zero is held against the largest.
                let error = (z - q).abs() / q.abs().max(1e-3 * largest);
                worst = worst.max(error);
                assert!((z - q).abs() < 1e-12 && error < 1e-12, "{} degrees, band {l}: {z}, {q}", a.to_degrees());
            }
        }
        println!("worst relative error of the soft cone: {worst:.1e}");
    }

    #[test]
    fn soft_cones_equal_direct_quadrature_at_every_order() {
        for a in many_half_angles().step_by(10) {
            for order in 1..=10 {
                let mut expected = vec![0.0; order];
                for (x, weight) in gauss_legendre(48) {
                    let t = 0.5 * a * (1.0 + x);
                    let ease = 1.0 - 3.0 * (t / a).powi(2) + 2.0 * (t / a).powi(3);
                    for (l, sum) in expected.iter_mut().enumerate() {
                        *sum +=
                            PI * a * weight * ease * t.sin() * zonal_norm(l) * crate::basis::legendre(l, 0, t.cos());
                    }
                }
                for (l, (z, q)) in Zonal::soft_cone(order, a).coefficients().iter().zip(&expected).enumerate() {
                    assert!((z - q).abs() < 1e-12, "{} degrees, order {order}, band {l}: {z}, {q}", a.to_degrees());
                }
            }
        }
    }

    #[test]
    fn soft_cones_in_f32_are_good_to_1e_5_at_every_angle() {
        const ORDER: usize = 10;
        let mut worst = 0.0_f64;
        for a in many_half_angles() {
            let expected = mixture(ORDER, a);
            let axis = crate::Dir::Z;
            let found = Zonal::soft_cone(ORDER, a).towards(axis, 1.0_f32);
            // Some bands of the cone of 180 degrees are exactly zero.
            let largest = expected.iter().fold(0.0_f64, |m, z| m.max(z.abs()));
            for (l, q) in expected.iter().enumerate() {
                let z = f64::from(found[l * (l + 1)]);
                let error = (z - q).abs() / q.abs().max(1e-9 * largest);
                worst = worst.max(error);
                assert!(error < 1e-5, "{} degrees, band {l}: {z} against {q}", a.to_degrees());
            }
        }
        println!("worst relative error of the soft cone in f32: {worst:.1e}");
    }

    #[test]
    fn soft_cones_have_their_golden_coefficients() {
        for degrees in ["0.5", "2", "8", "15", "30", "45", "60", "90", "120", "180"] {
            let cone = Zonal::soft_cone(8, degrees.parse::<f64>().unwrap().to_radians());
            let golden = golden_f64s(&format!("/ease_cone_zh/{degrees}"));
            for (l, (z, golden)) in cone.coefficients().iter().zip(golden).enumerate() {
                assert!((z - golden).abs() < 1e-13, "{degrees} degrees, band {l}: {z} against {golden}");
            }
        }
    }

    #[test]
    fn the_series_meets_the_closed_form() {
        for k in 1..12 {
            let a = SERIES_LIMIT / k as f64;
            let (below, above) = (ease_sine(k, a * (1.0 - 1e-13)), ease_sine(k, a * (1.0 + 1e-13)));
            assert!((below / above - 1.0).abs() < 1e-12, "k {k}: {below} and {above}");
        }
    }

    #[test]
    fn high_orders_and_empty_ones_are_fine() {
        for a in [1e-4, 0.1, 1.0, 3.0] {
            let expected = mixture(64, a);
            for (l, (z, q)) in Zonal::soft_cone(64, a).coefficients().iter().zip(&expected).enumerate() {
                assert!((z - q).abs() < 1e-13, "a {a}, band {l}: {z} against {q}");
            }
        }
        assert_eq!(Zonal::soft_cone(0, 1.0).order(), 0, "order 0");
        assert_eq!(Zonal::soft_cone(3, 0.0), Zonal::new(vec![0.0; 3]), "a half angle of 0");
    }
}
