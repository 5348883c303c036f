//! A function that is symmetric about an axis.

use std::f64::consts::PI;

use serde::{Deserialize, Serialize};

use crate::index::len;
use crate::legendre::legendre_all;
use crate::quadrature::gauss_legendre;
use crate::{Coefficient, Dir, Real, ShVec};

/// A function of the angle to an axis alone, by one coefficient per band.
///
/// ```text
///   h(cos θ) = Σ_l z_l K_l P_l(cos θ)        K_l = √((2l+1)/4π)
/// ```
///
/// About +z it is the expansion with `f_l0 = z_l` and all others zero. It is a light's shape
/// ([`Zonal::towards`]) or a kernel to convolve with ([`convolve_in_place`](crate::convolve_in_place)).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Zonal {
    coefficients: Vec<f64>,
}

impl Zonal {
    /// From the coefficient of every band.
    #[must_use]
    pub fn new(coefficients: Vec<f64>) -> Self {
        Self { coefficients }
    }

    /// Projects `h(cos θ)` with `nodes` Gauss-Legendre nodes on each piece of `[-1, 1]` between `breaks`.
    ///
    /// ```text
    ///   z_l = 2π K_l ∫_{-1}^{1} h(t) P_l(t) dt
    /// ```
    ///
    /// `breaks` are the cosines, in ascending order inside `(-1, 1)`, where `h` or a derivative jumps: with them,
    /// piecewise polynomials are integrated exactly when `nodes >= (degree + order) / 2`.
    #[must_use]
    pub fn project(order: usize, breaks: &[f64], nodes: usize, mut h: impl FnMut(f64) -> f64) -> Self {
        let rule = gauss_legendre(nodes);
        let mut coefficients = vec![0.0; order];
        let mut start = -1.0;
        for &end in breaks.iter().chain(&[1.0]) {
            let (middle, half) = (0.5 * (start + end), 0.5 * (end - start));
            for &(x, weight) in &rule {
                let t = middle + half * x;
                let value = weight * half * h(t);
                for (z, p) in coefficients.iter_mut().zip(legendre_all(order, t)) {
                    *z += value * p;
                }
            }
            start = end;
        }
        for (l, z) in coefficients.iter_mut().enumerate() {
            *z *= 2.0 * PI * zonal_norm(l);
        }
        Self { coefficients }
    }

    /// The order: the number of bands.
    #[must_use]
    pub fn order(&self) -> usize {
        self.coefficients.len()
    }

    /// The coefficient `z_l` of every band.
    #[must_use]
    pub fn coefficients(&self) -> &[f64] {
        &self.coefficients
    }

    /// The value at the angle of the given cosine from the axis.
    #[must_use]
    pub fn eval(&self, cos_theta: f64) -> f64 {
        let p = legendre_all(self.order(), cos_theta);
        self.coefficients.iter().zip(p).enumerate().map(|(l, (z, p))| z * zonal_norm(l) * p).sum()
    }

    /// The expansion of the function turned from +z to the axis `axis`, in the colour or strength `value`.
    ///
    /// ```text
    ///   f_lm = √(4π/(2l+1)) z_l y_lm(axis)
    /// ```
    ///
    /// The number of multiplications is that of one evaluation of the basis: no rotation is needed
    /// (Sloan, Luna and Snyder 2005).
    #[must_use]
    pub fn towards<T: Coefficient>(&self, axis: Dir, value: T) -> ShVec<T> {
        let mut f = vec![T::ZERO; len(self.order())];
        let factors = self.convolution_factors();
        f64::with_shared_basis(self.order(), |basis| {
            basis.for_each(axis.to_array(), self.order(), |i, y| {
                f[i] = T::narrow(value.widen().scale(factors[i.isqrt()] * y));
            });
        });
        ShVec::from_vec(f).unwrap_or_else(|| unreachable!("n² places were made"))
    }

    /// The factor of every band in a convolution with this kernel: `√(4π/(2l+1)) z_l`.
    #[must_use]
    pub fn convolution_factors(&self) -> Vec<f64> {
        self.coefficients.iter().enumerate().map(|(l, z)| z / zonal_norm(l)).collect()
    }
}

/// `K_l = √((2l+1)/4π)`, the norm of `P_l(cos θ)` as a basis function.
pub(crate) fn zonal_norm(l: usize) -> f64 {
    ((2 * l + 1) as f64 / (4.0 * PI)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Expansion as _;
    use lobe_testkit::{directions, golden, golden_f64s};

    #[test]
    fn a_zonal_function_has_one_value_by_every_route() {
        let h = Zonal::new(vec![0.5, -1.0, 0.25, 0.125, 2.0]);
        for v in directions() {
            let axis = Dir::from_unit(v);
            let turned = h.towards(axis, 1.0);
            for s in [Dir::X, Dir::Y, -Dir::Z, Dir::from_angles(2.2, -0.4), axis] {
                let (a, b) = (turned.eval(s), h.eval(axis.dot(s)));
                assert!((a - b).abs() < 1e-13, "axis {v:?}, towards {s:?}: {a} against {b}");
            }
        }
    }

    #[test]
    fn projection_finds_a_planted_zonal_function() {
        let planted = Zonal::new(lobe_testkit::Random::new(2).signed_vec(64));
        let found = Zonal::project(64, &[], 64, |t| planted.eval(t));
        for (l, (a, b)) in found.coefficients().iter().zip(planted.coefficients()).enumerate() {
            assert!((a - b).abs() < 1e-13, "band {l}: {a} against {b}");
        }
    }

    #[test]
    fn a_disc_of_constant_radiance_has_its_golden_coefficients() {
        for degrees in golden("/cone_zh").as_object().unwrap().keys() {
            let cosine = degrees.parse::<f64>().unwrap().to_radians().cos();
            let breaks: &[f64] = if cosine > -1.0 { &[cosine] } else { &[] };
            let found = Zonal::project(8, breaks, 8, |t| f64::from(u8::from(t > cosine)));
            for (l, golden) in golden_f64s(&format!("/cone_zh/{degrees}")).iter().enumerate() {
                let z = found.coefficients()[l];
                assert!((z - golden).abs() < 1e-13, "{degrees} degrees, band {l}: {z} against {golden}");
            }
        }
    }
}
