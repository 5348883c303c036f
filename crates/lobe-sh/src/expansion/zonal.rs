//! A function that is symmetric about an axis.

use core::f64::consts::PI;
use core::ops::{Add, AddAssign, Index, Mul, Neg, Sub, SubAssign};

use crate::basis::basis::Basis;
use crate::basis::index::{band_range, coefficient_count, order_of_slice};
use crate::basis::legendre::legendre_all;
use crate::by_type::{by_type, of_each_type};
use crate::expansion::sh_vec::sums;
use crate::expansion::{Expansion, FixedOrder, ShVec};
use crate::prelude::*;
use crate::scalar::Coefficient;
use crate::sphere::Dir;
use crate::sphere::quadrature::gauss_legendre;
use crate::sphere::vector::dot_slices;

/// A function of the angle to an axis alone, by one coefficient per band.
///
/// ```text
///   h(cos θ) = Σ_l z_l K_l P_l(cos θ)        K_l = √((2l+1)/4π)
/// ```
///
/// About +z it is the expansion with `f_l0 = z_l` and all others zero. It is the shape of a light
/// ([`Zonal::towards`]) or a kernel to convolve with ([`convolve_in_place`](crate::filter::convolve_in_place)).
/// Operators need equal orders; [`Zonal::resized`] makes them equal.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(transparent))]
pub struct Zonal {
    coefficients: Vec<f64>,
}

impl Zonal {
    /// From the coefficient of every band.
    #[must_use]
    pub fn new(coefficients: Vec<f64>) -> Self {
        Self { coefficients }
    }

    /// The zonal part of `f` about `axis`: the nearest zonal function.
    ///
    /// ```text
    ///   z_l = √(4π/(2l+1)) Σ_m f_lm y_lm(axis)
    /// ```
    ///
    /// It is the mean of `f` over the circles about the axis, and undoes [`Zonal::towards`].
    #[must_use]
    pub fn about(axis: Dir, f: &impl Expansion<f64>) -> Self {
        let mut coefficients = vec![0.0; f.order()];
        Basis::<f64>::with_shared(f.order(), |basis| {
            basis.for_each(axis.to_array(), f.order(), |i, y| coefficients[i.isqrt()] += f.coefficients()[i] * y);
        });
        for (l, z) in coefficients.iter_mut().enumerate() {
            *z /= zonal_norm(l);
        }
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
    ///
    /// # Panics
    /// If `nodes` is 0, or `breaks` do not ascend within `[-1, 1]`.
    #[must_use]
    pub fn project(order: usize, breaks: &[f64], nodes: usize, mut h: impl FnMut(f64) -> f64) -> Self {
        assert!(nodes > 0, "an integral needs one node at least");
        let ascending = breaks.windows(2).all(|pair| pair[0] <= pair[1]);
        let inside = breaks.iter().all(|t| (-1.0..=1.0).contains(t));
        assert!(ascending && inside, "breaks ascend within [-1, 1], not as {breaks:?} do");
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

    /// The function with another order: cut off, or filled up with zeros.
    #[must_use]
    pub fn resized(&self, order: usize) -> Self {
        let mut coefficients = self.coefficients.clone();
        coefficients.resize(order, 0.0);
        Self { coefficients }
    }

    /// The integral over the sphere of the product of two functions of the same axis, `Σ_l z_l z'_l`.
    ///
    /// If the orders differ, the missing coefficients of the shorter one are zero.
    #[must_use]
    pub fn dot(&self, other: &Self) -> f64 {
        dot_slices(&self.coefficients, &other.coefficients)
    }

    /// The value at the angle of the given cosine from the axis.
    #[must_use]
    pub fn eval(&self, cos_theta: f64) -> f64 {
        let p = legendre_all(self.order(), cos_theta);
        self.coefficients.iter().zip(p).enumerate().map(|(l, (z, p))| z * zonal_norm(l) * p).sum()
    }

    /// The expansion of the function turned from +z to the axis `axis`, in the color or strength `value`.
    ///
    /// ```text
    ///   f_lm = √(4π/(2l+1)) z_l y_lm(axis)
    /// ```
    ///
    /// The number of multiplications is that of one evaluation of the basis: no rotation is needed
    /// (Sloan, Luna and Snyder 2005).
    #[must_use]
    pub fn towards<T: Coefficient>(&self, axis: Dir, value: T) -> ShVec<T> {
        let mut f = vec![T::ZERO; coefficient_count(self.order())];
        self.towards_into(axis, value, &mut f);
        ShVec::of(f)
    }

    /// [`Zonal::towards`] without an allocation, to the order that `out` has room for: bands that this function does
    /// not have become zero, bands beyond that order are left out.
    ///
    /// # Panics
    /// If `out.len()` is no perfect square.
    pub fn towards_into<T: Coefficient>(&self, axis: Dir, value: T, out: &mut [T]) {
        let value = &[value][..];
        by_type!(T: value; mut out => towards_into(self, axis, value[0], out));
    }

    /// [`Zonal::towards`] to the order of the type that is asked for.
    #[must_use]
    pub fn towards_as<E: FixedOrder>(&self, axis: Dir, value: E::Value) -> E {
        let mut f = E::zero();
        self.towards_into(axis, value, f.coefficients_mut());
        f
    }

    /// The factor of every band in a convolution with this kernel: `√(4π/(2l+1)) z_l`.
    #[must_use]
    pub fn convolution_factors(&self) -> Vec<f64> {
        self.factors().collect()
    }

    /// [`Zonal::convolution_factors`], one after the other.
    pub(crate) fn factors(&self) -> impl Iterator<Item = f64> {
        self.coefficients.iter().enumerate().map(|(l, z)| z / zonal_norm(l))
    }
}

of_each_type! {
    pub(super) fn towards_into(zonal: &Zonal, axis: Dir, value: T, out: &mut [T]) {
        let order = order_of_slice(out);
        let value = value.widen();
        Basis::<f64>::with_shared(order, |basis| {
            basis.for_each(axis.to_array(), order, |i, y| out[i] = T::narrow(value.scale(y)));
        });
        for (l, factor) in (0..order).zip(zonal.factors().chain(core::iter::repeat(0.0))) {
            for f in &mut out[band_range(l)] {
                *f = T::narrow(f.widen().scale(factor));
            }
        }
    }
}

impl Index<usize> for Zonal {
    type Output = f64;

    fn index(&self, l: usize) -> &f64 {
        &self.coefficients[l]
    }
}

sums!([] Zonal, Add add, AddAssign add_assign);
sums!([] Zonal, Sub sub, SubAssign sub_assign);

impl Neg for &Zonal {
    type Output = Zonal;

    fn neg(self) -> Zonal {
        self * -1.0
    }
}

impl Mul<f64> for &Zonal {
    type Output = Zonal;

    fn mul(self, s: f64) -> Zonal {
        Zonal { coefficients: self.coefficients.iter().map(|z| z * s).collect() }
    }
}

/// `K_l = √((2l+1)/4π)`, the norm of `P_l(cos θ)` as a basis function.
pub(crate) fn zonal_norm(l: usize) -> f64 {
    ((2 * l + 1) as f64 / (4.0 * PI)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::basis::basis::eval_basis;
    use crate::scalar::Rgb;
    use crate::sphere::quadrature::SphereQuadrature;
    use lobe_testkit::{Random, directions, golden, golden_f64s};

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
        let planted = Zonal::new(Random::new(2).signed_vec(64));
        let found = Zonal::project(64, &[], 64, |t| planted.eval(t));
        for (l, (a, b)) in found.coefficients().iter().zip(planted.coefficients()).enumerate() {
            assert!((a - b).abs() < 1e-13, "band {l}: {a} against {b}");
        }
    }

    #[test]
    fn a_disc_of_constant_radiance_has_its_golden_coefficients() {
        for degrees in golden("/cone_zh").as_object().unwrap().keys() {
            let cosine = degrees.parse::<f64>().unwrap().to_radians().cos();
            let found = Zonal::project(8, &[cosine], 8, |t| f64::from(u8::from(t > cosine)));
            for (l, golden) in golden_f64s(&format!("/cone_zh/{degrees}")).iter().enumerate() {
                let z = found.coefficients()[l];
                assert!((z - golden).abs() < 1e-13, "{degrees} degrees, band {l}: {z} against {golden}");
            }
        }
    }

    #[test]
    fn arithmetic_is_that_of_the_functions() {
        let (f, g) = (Zonal::new(Random::new(3).signed_vec(6)), Zonal::new(Random::new(4).signed_vec(6)));
        let h = &(&(&f + &g) * 2.0) - &-&f;
        for t in [-1.0, -0.3, 0.0, 0.5, 1.0] {
            let expected = 3.0 * f.eval(t) + 2.0 * g.eval(t);
            assert!((h.eval(t) - expected).abs() < 1e-13, "at {t}: {} against {expected}", h.eval(t));
        }
        let integral = SphereQuadrature::of_degree(10).integrate(|s| f.eval(s.z()) * g.eval(s.z()));
        assert!((f.dot(&g) - integral).abs() < 1e-13, "{} against {integral}", f.dot(&g));
        assert_eq!(f.resized(8).resized(6), f, "longer and back");
        assert_eq!((f.resized(8)[7], f.resized(2).order()), (0.0, 2), "zeros, and cut off");
    }

    #[test]
    #[should_panic(expected = "the orders of two functions differ")]
    fn zonal_functions_of_different_orders_do_not_add() {
        let _ = &Zonal::new(vec![1.0; 2]) + &Zonal::new(vec![1.0; 3]);
    }

    #[test]
    fn the_zonal_part_undoes_turning_and_is_the_mean_over_circles() {
        let h = Zonal::new(Random::new(5).signed_vec(7));
        let f = ShVec::from_vec(Random::new(6).signed_vec(49)).unwrap();
        for v in directions() {
            let axis = Dir::from_unit(v);
            let back = Zonal::about(axis, &h.towards(axis, 1.0));
            assert!((&back - &h).dot(&(&back - &h)) < 1e-26, "about {v:?}: {back:?} against {h:?}");
            let rest = &f - &Zonal::about(axis, &f).towards(axis, 1.0);
            let product = rest.dot(&h.towards(axis, 1.0));
            assert!(product.abs() < 1e-13, "about {v:?}: what is left has {product} along a zonal function");
        }
    }

    #[test]
    fn a_lobe_fits_any_order_and_color() {
        let h = Zonal::new(vec![0.5, -1.0, 0.25]);
        let axis = Dir::from_angles(2.0, -1.0);
        let y = eval_basis(axis, 5);
        for order in 0..6 {
            let mut out = vec![Rgb::splat(f64::NAN); order * order];
            h.towards_into(axis, Rgb::new(1.0, 2.0, 0.0), &mut out);
            for (i, found) in out.iter().enumerate() {
                // `√(4π / (2l + 1)) z_l y_lm(axis)`, and nothing in bands that the lobe has not.
                let l = i.isqrt();
                let z = if l < h.order() { h[l] } else { 0.0 };
                let expected = (4.0 * PI / (2 * l + 1) as f64).sqrt() * z * y[i];
                let error = (found.r - expected).abs() + (found.g - 2.0 * expected).abs() + found.b.abs();
                assert!(error < 1e-14, "order {order}, coefficient {i}: {found:?} against {expected}");
            }
        }
    }

    #[test]
    #[should_panic(expected = "breaks ascend")]
    fn breaks_out_of_order_are_refused() {
        let _ = Zonal::project(2, &[0.5, -0.5], 4, |t| t);
    }
}
