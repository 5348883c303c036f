//! Convolution of a function with a zonal kernel: the clamped cosine, Phong and GGX lobes.

use core::f64::consts::PI;

use crate::basis::index::{band_range, order_of_slice};
use crate::basis::legendre::legendre_all;
use crate::expansion::Zonal;
use crate::expansion::zonal::zonal_norm;
use crate::scalar::{Coefficient, Real};
use crate::sphere::quadrature::gauss_legendre;

/// Convolves the function given by `coefficients` with `kernel`.
///
/// ```text
///   (f * h)(n) = ∫ f(s) h(n · s) ds        (f * h)_lm = √(4π/(2l+1)) h_l f_lm
/// ```
///
/// Bands that the kernel does not reach become zero. With [`Zonal::clamped_cosine`] radiance becomes
/// irradiance, not divided by π. Only kernels that are symmetric about their axis keep the result a function on the
/// sphere.
///
/// # Panics
/// If `coefficients` are not `n²`.
pub fn convolve_in_place<T: Coefficient>(coefficients: &mut [T], kernel: &Zonal) {
    let order = order_of_slice(coefficients);
    for (l, factor) in (0..order).zip(kernel.factors().chain(core::iter::repeat(0.0))) {
        let factor = T::Scalar::from_f64(factor);
        for c in &mut coefficients[band_range(l)] {
            *c = c.scale(factor);
        }
    }
}

/// Gauss-Legendre nodes per piece of the GGX integral, beyond the half order that the Legendre polynomial needs.
/// On a piece whose ends differ by a factor of four the rest of the integrand is then resolved to rounding.
const GGX_NODES: usize = 24;

impl Zonal {
    /// The clamped cosine `max(cos θ, 0)`, in closed form for any order.
    ///
    /// Convolved with radiance it gives irradiance, not divided by π. The factor of band `l` in the convolution
    /// ([Ramamoorthi and Hanrahan 2001]):
    ///
    /// ```text
    ///   A_0 = π,   A_1 = 2π/3,   A_l = 0 for odd l > 1
    ///   A_l = 2π (-1)^{l/2-1} / ((l+2)(l-1)) · l! / (2^l (l/2)!²)      for even l
    ///
    ///   A_l / π = 1, 2/3, 1/4, 0, -1/24, 0, 1/64, 0, -1/128, ..
    /// ```
    ///
    /// [Ramamoorthi and Hanrahan 2001]: https://cseweb.ucsd.edu/~ravir/papers/envmap/envmap.pdf
    #[must_use]
    pub fn clamped_cosine(order: usize) -> Self {
        let mut central = 1.0; // l! / (2^l (l/2)!²), the product of (2k-1)/(2k) up to k = l/2
        let factor = |l: usize| {
            let lf = l as f64;
            match l {
                0 => PI,
                1 => 2.0 * PI / 3.0,
                _ if l % 2 == 1 => 0.0,
                _ => {
                    central *= (lf - 1.0) / lf;
                    let sign = if l % 4 == 2 { 1.0 } else { -1.0 };
                    sign * 2.0 * PI * central / ((lf + 2.0) * (lf - 1.0))
                }
            }
        };
        Self::from_convolution_factors((0..order).map(factor))
    }

    /// The Phong lobe `(s+1)/(2π) max(cos θ, 0)^s` of exponent `s >= 0`, which integrates to 1.
    ///
    /// The convolution factors follow from `∫_0^1 t^s P_l(t) dt`, whose recurrence comes from that of `P_l`:
    ///
    /// ```text
    ///   B_0 = 1        B_1 = (s+1)/(s+2)        B_l = B_{l-2} (s - l + 2) / (s + l + 1)
    /// ```
    ///
    /// For `s = 1` this is the clamped cosine divided by π. As `s` grows the lobe tends to an impulse, all `B_l` to 1.
    ///
    /// # Panics
    /// If `s` is negative or not finite.
    #[must_use]
    pub fn phong(order: usize, s: f64) -> Self {
        assert!(s >= 0.0 && s.is_finite(), "a Phong exponent is finite and not negative, not {s}");
        let mut factors = vec![1.0, (s + 1.0) / (s + 2.0)];
        for l in 2..order {
            let lf = l as f64;
            factors.push(factors[l - 2] * (s - lf + 2.0) / (s + lf + 1.0));
        }
        Self::from_convolution_factors(factors.into_iter().take(order))
    }

    /// The GGX lobe of roughness `alpha` in `[0, 1]` for a view along the normal, which integrates to 1.
    ///
    /// ```text
    ///   h(θ) ∝ D(θ/2) max(cos θ, 0)        D(θ_h) = α² / (π ((α² - 1) cos² θ_h + 1)²)
    /// ```
    ///
    /// The half vector of a reflected direction at angle `θ` from the normal is at `θ/2`; the factor `cos θ` is
    /// the weight of the split-sum prefilter (Karis 2013). `D` is that of [Walter et al. 2007] eq. 33. With
    /// `α = 0` it is an impulse: all convolution factors are 1.
    ///
    /// Integrated over `d = 1 - cos θ` in pieces whose ends grow by a factor of four from the width of the peak, `α²`,
    /// so that the sharpest lobes keep their digits: the tests `ggx_factors_agree_with_brute_force` and
    /// `the_linear_ggx_factor_has_its_closed_form` bound the error by 1e-11 and 1e-14.
    ///
    /// # Panics
    /// If `alpha` is outside `[0, 1]`.
    ///
    /// [Walter et al. 2007]: https://www.cs.cornell.edu/~srm/publications/EGSR07-btdf.pdf
    #[must_use]
    pub fn ggx(order: usize, alpha: f64) -> Self {
        assert!((0.0..=1.0).contains(&alpha), "a GGX roughness lies in [0, 1], it is not {alpha}");
        let width = alpha * alpha;
        let mut integrals = vec![0.0; order];
        // Below the smallest normal number `α²` has lost digits, and the lobe is an impulse long before.
        if width < f64::MIN_POSITIVE {
            return Self::from_convolution_factors(vec![1.0; order]);
        }
        let rule = gauss_legendre(GGX_NODES + order / 2);
        let (mut start, mut end) = (0.0, width.min(1.0));
        while start < 1.0 {
            let half = 0.5 * (end - start);
            for &(x, weight) in &rule {
                let d = start + half * (1.0 + x);
                // (α² - 1) cos² θ_h + 1 with cos² θ_h = 1 - d/2, free of cancellation
                let denominator = width + (1.0 - width) * 0.5 * d;
                // Squared after the division: the square of a small denominator alone would underflow.
                let peak = width / denominator;
                let h = weight * half * (1.0 - d) * peak * peak;
                for (sum, p) in integrals.iter_mut().zip(legendre_all(order, 1.0 - d)) {
                    *sum += h * p;
                }
            }
            (start, end) = (end, (4.0 * end).min(1.0));
        }
        let total = integrals.first().copied().unwrap_or(1.0);
        Self::from_convolution_factors(integrals.into_iter().map(|b| b / total))
    }

    /// The kernel that multiplies band `l` of a function by the `l`-th factor when it is convolved with it.
    ///
    /// ```text
    ///   z_l = √((2l+1)/4π) · factor
    /// ```
    #[must_use]
    pub fn from_convolution_factors(factors: impl IntoIterator<Item = f64>) -> Self {
        Self::new(factors.into_iter().enumerate().map(|(l, factor)| factor * zonal_norm(l)).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expansion::Expansion as _;
    use crate::expansion::ShVec;
    use crate::sphere::Dir;
    use crate::sphere::quadrature::SphereQuadrature;
    use lobe_testkit::golden_f64s;

    /// The convolution factors of any kernel by plain quadrature in the angle, finely enough for smooth lobes.
    fn factors_by_brute_force(order: usize, h: impl Fn(f64) -> f64) -> Vec<f64> {
        let mut factors = vec![0.0; order];
        for (x, weight) in gauss_legendre(1000) {
            let theta = 0.25 * PI * (x + 1.0); // the lobes are zero below the horizon
            let value = 0.25 * PI * weight * 2.0 * PI * theta.sin() * h(theta);
            for (factor, p) in factors.iter_mut().zip(legendre_all(order, theta.cos())) {
                *factor += value * p;
            }
        }
        factors
    }

    fn assert_close(found: &[f64], expected: &[f64], tolerance: f64, what: &str) {
        assert_eq!(found.len(), expected.len(), "{what}");
        for (l, (a, b)) in found.iter().zip(expected).enumerate() {
            assert!((a - b).abs() <= tolerance, "{what}, band {l}: {a} against {b}");
        }
    }

    #[test]
    fn the_clamped_cosine_has_its_golden_coefficients() {
        let golden: Vec<f64> = golden_f64s("/cos_lobe_zh_normalised").iter().map(|z| z * PI).collect();
        assert_close(Zonal::clamped_cosine(10).coefficients(), &golden, 1e-14, "golden");
    }

    #[test]
    fn the_clamped_cosine_equals_its_projection_to_order_64() {
        let projected = Zonal::project(64, &[0.0], 40, |t| t.max(0.0));
        assert_close(Zonal::clamped_cosine(64).coefficients(), projected.coefficients(), 1e-13, "projection");
    }

    #[test]
    fn the_order_three_cosine_reaches_seventeen_sixteenths() {
        let cosine = Zonal::clamped_cosine(3);
        assert_close(&[cosine.eval(1.0), cosine.eval(-1.0)], &[17.0 / 16.0, 1.0 / 16.0], 1e-14, "order 3 at the poles");
        let cosine = Zonal::clamped_cosine(5);
        assert_close(
            &[cosine.eval(1.0), cosine.eval(-1.0)],
            &[31.0 / 32.0, -1.0 / 32.0],
            1e-14,
            "order 5 at the poles",
        );
    }

    #[test]
    fn phong_of_exponent_one_is_the_clamped_cosine_over_pi() {
        let cosine: Vec<f64> = Zonal::clamped_cosine(20).convolution_factors().iter().map(|a| a / PI).collect();
        assert_close(&Zonal::phong(20, 1.0).convolution_factors(), &cosine, 1e-15, "s = 1");
    }

    #[test]
    fn phong_factors_agree_with_brute_force() {
        for s in [0.0, 0.5, 2.0, 7.3, 50.0, 2000.0] {
            let h = |theta: f64| (s + 1.0) / (2.0 * PI) * theta.cos().powf(s);
            let expected = factors_by_brute_force(12, h);
            // At s = 0.5 the root at the horizon limits the quadrature of the test.
            assert_close(&Zonal::phong(12, s).convolution_factors(), &expected, 1e-9, &format!("s = {s}"));
        }
    }

    #[test]
    fn ggx_factors_agree_with_brute_force() {
        for alpha in [0.02, 0.1, 0.5, 1.0] {
            let h = |theta: f64| {
                let cos_h = (0.5 * theta).cos();
                let d = alpha * alpha / (PI * ((alpha * alpha - 1.0) * cos_h * cos_h + 1.0).powi(2));
                d * theta.cos()
            };
            let mut expected = factors_by_brute_force(12, h);
            let total = expected[0];
            expected.iter_mut().for_each(|b| *b /= total);
            assert_close(&Zonal::ggx(12, alpha).convolution_factors(), &expected, 1e-11, &format!("alpha = {alpha}"));
        }
    }

    #[test]
    fn sharp_lobes_tend_to_an_impulse() {
        for kernel in [Zonal::ggx(32, 0.0), Zonal::ggx(32, 1e-6), Zonal::phong(32, 1e12)] {
            assert_close(&kernel.convolution_factors(), &[1.0; 32], 1e-6, "impulse");
        }
        for alpha in [1e-20, 1e-80, 1e-150, 1e-155, 1e-160, 1e-300] {
            assert_close(&Zonal::ggx(32, alpha).convolution_factors(), &[1.0; 32], 1e-14, &format!("alpha = {alpha}"));
        }
    }

    // With w = α², c = (1 - w)/2 and s = w + c, the substitution v = w + c d gives
    //
    //   ∫_0^1 (1-d)/(w + cd)² dd  = (s/w - 1 - ln(s/w)) / c²
    //   ∫_0^1 (1-d)²/(w + cd)² dd = (s²/w - w - 2s ln(s/w)) / c³
    #[test]
    fn the_linear_ggx_factor_has_its_closed_form() {
        for alpha in [0.3_f64, 0.1, 1e-2, 1e-3, 1e-4, 1e-6, 1e-9] {
            let w = alpha * alpha;
            let c = 0.5 * (1.0 - w);
            let s = w + c;
            let log = (s / w).ln();
            let expected = (s * s / w - w - 2.0 * s * log) / c / (s / w - 1.0 - log);
            assert_close(
                &Zonal::ggx(2, alpha).convolution_factors()[1..],
                &[expected],
                1e-14,
                &format!("alpha {alpha}"),
            );
        }
    }

    #[test]
    fn rougher_mirrors_blur_more_in_every_band() {
        for pair in [0.05, 0.2, 0.4, 0.6, 0.8, 1.0].windows(2) {
            let (sharp, rough) = (Zonal::ggx(3, pair[0]), Zonal::ggx(3, pair[1]));
            for l in 1..3 {
                let (a, b) = (sharp.convolution_factors()[l], rough.convolution_factors()[l]);
                assert!(a > b && b > 0.0, "alpha {pair:?}, band {l}: {a}, {b}");
            }
        }
    }

    #[test]
    fn order_zero_kernels_are_empty() {
        for kernel in [Zonal::clamped_cosine(0), Zonal::phong(0, 3.0), Zonal::ggx(0, 0.3), Zonal::ggx(0, 0.0)] {
            assert_eq!(kernel.order(), 0, "{kernel:?}");
        }
    }

    #[test]
    fn convolution_equals_its_integral() {
        let f = ShVec::from_vec(lobe_testkit::Random::new(3).signed_vec(36)).unwrap();
        let kernel = Zonal::new(vec![0.7, -0.3, 0.2, 0.9, 0.1, -0.5]);
        let g = f.convolved(&kernel);
        let rule = SphereQuadrature::of_degree(10);
        for v in lobe_testkit::directions() {
            let n = Dir::from_unit(v);
            let integral = rule.integrate(|s| f.eval(s) * kernel.eval(n.dot(s)));
            assert!((g.eval(n) - integral).abs() < 1e-12, "towards {v:?}: {} against {integral}", g.eval(n));
        }
    }

    #[test]
    fn irradiance_brightens_towards_the_light() {
        for axis in [Dir::X, Dir::Y, Dir::Z] {
            let sky = crate::project(3, 1, |s| 1.0 + s.dot(axis));
            let e = sky.convolved(&Zonal::clamped_cosine(3));
            let (front, back) = (e.eval(axis), e.eval(-axis));
            assert!((front - (PI + 2.0 * PI / 3.0)).abs() < 1e-13, "facing {axis:?}: {front}");
            assert!((back - (PI - 2.0 * PI / 3.0)).abs() < 1e-13, "turned away from {axis:?}: {back}");
        }
    }

    #[test]
    fn bands_beyond_the_kernel_become_zero() {
        let mut f = [1.0_f32; 9];
        convolve_in_place(&mut f, &Zonal::from_convolution_factors([2.0, 0.5]));
        assert_eq!(f, [2.0, 0.5, 0.5, 0.5, 0.0, 0.0, 0.0, 0.0, 0.0], "bands");
    }
}
