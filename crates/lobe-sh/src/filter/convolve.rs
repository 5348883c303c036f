//! Convolution of a function with a kernel that is symmetric about an axis.

use crate::basis::index::{band_range, order_of_slice};
use crate::{Coefficient, Expansion, Real, Zonal};

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

/// The convolution of `f` with `kernel`; see [`convolve_in_place`].
///
/// ```
/// use lobe_sh::{Dir, Expansion as _, ShL2, Zonal, convolved};
///
/// let sky = ShL2::constant(1.0_f64);
/// let irradiance = convolved(&sky, &Zonal::clamped_cosine(3));
/// assert!((irradiance.eval(Dir::Z) - std::f64::consts::PI).abs() < 1e-14);
/// ```
#[must_use]
pub fn convolved<T: Coefficient, E: Expansion<T>>(f: &E, kernel: &Zonal) -> E {
    let mut g = f.clone();
    convolve_in_place(g.coefficients_mut(), kernel);
    g
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Dir, ShVec, SphereQuadrature};

    #[test]
    fn convolution_equals_its_integral() {
        let f = ShVec::from_vec(lobe_testkit::Random::new(3).signed_vec(36)).unwrap();
        let kernel = Zonal::new(vec![0.7, -0.3, 0.2, 0.9, 0.1, -0.5]);
        let g = convolved(&f, &kernel);
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
            let e = convolved(&sky, &Zonal::clamped_cosine(3));
            let (front, back) = (e.eval(axis), e.eval(-axis));
            let pi = core::f64::consts::PI;
            assert!((front - (pi + 2.0 * pi / 3.0)).abs() < 1e-13, "facing {axis:?}: {front}");
            assert!((back - (pi - 2.0 * pi / 3.0)).abs() < 1e-13, "turned away from {axis:?}: {back}");
        }
    }

    #[test]
    fn bands_beyond_the_kernel_become_zero() {
        let mut f = [1.0_f32; 9];
        convolve_in_place(&mut f, &Zonal::from_convolution_factors([2.0, 0.5]));
        assert_eq!(f, [2.0, 0.5, 0.5, 0.5, 0.0, 0.0, 0.0, 0.0, 0.0], "bands");
    }
}
