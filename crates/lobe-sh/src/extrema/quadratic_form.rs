//! A function of three bands as a quadratic form on the unit sphere.

use core::f64::consts::PI;

#[cfg(not(feature = "std"))]
use num_traits::Float as _;

use crate::once::Once;
use crate::scalar::{Coefficient, Real};
use crate::sphere::vector::dot;

/// A function of bands 0 to 2, `f(x) = c + b·x + xᵀ A x` on `|x| = 1`, with `A` symmetric and without trace.
///
/// ```text
///   c = f_0/√4π        b = √(3/4π) (-f_3, -f_1, f_2)
///
///                 [ f_8 - f_6/√3     f_4             -f_7      ]
///   A = √(15/16π) [ f_4             -f_8 - f_6/√3    -f_5      ]
///                 [-f_7             -f_5              2 f_6/√3 ]
/// ```
#[derive(Clone, Copy, Debug)]
pub(crate) struct QuadraticForm {
    /// The mean.
    pub(crate) c: f64,
    pub(crate) b: [f64; 3],
    /// xx, yy, zz, xy, xz, yz.
    pub(crate) a: [f64; 6],
    /// `|b|`, the largest value of the linear part.
    pub(crate) linear: f64,
    /// No eigenvalue of `A` is larger: a matrix without trace has them within `√(2/3) |A|`.
    pub(crate) form: f64,
}

/// The coefficients of one channel, filled up with zeros.
fn nine<T: Coefficient>(coefficients: &[T], channel: usize) -> [f64; 9] {
    let mut f = [0.0; 9];
    for (f, c) in f.iter_mut().zip(coefficients) {
        *f = c.channel(channel).to_f64();
    }
    f
}

/// The power of two by which numbers of which this is the largest come to between 1 and 2, or as near as it can bring them: a factor that does
/// not round, after which squares and cubes stay in range.
pub(crate) fn to_unit_size(largest: f64) -> f64 {
    2.0_f64.powi((-largest.max(f64::MIN_POSITIVE).log2().floor()).min(1000.0) as i32)
}

impl QuadraticForm {
    /// From the `n²` coefficients of one channel, `n` up to 3; missing bands are zero.
    pub(crate) fn new<T: Coefficient>(coefficients: &[T], channel: usize) -> Self {
        Self::of(nine(coefficients, channel))
    }

    /// [`QuadraticForm::new`] of the function times [`to_unit_size`], so that products of four coefficients stay in range; and that factor.
    pub(crate) fn normalized<T: Coefficient>(coefficients: &[T], channel: usize) -> (Self, f64) {
        let f = nine(coefficients, channel);
        let scale = to_unit_size(f.iter().fold(0.0, |largest: f64, f| largest.max(f.abs())));
        (Self::of(f.map(|f| f * scale)), scale)
    }

    fn of(f: [f64; 9]) -> Self {
        let [k0, k1, k2, third, _] = *norms();
        let diagonal = third * f[6];
        let a = [f[8] - diagonal, -f[8] - diagonal, 2.0 * diagonal, f[4], -f[7], -f[5]];
        Self::from_parts(k0 * f[0], [-k1 * f[3], -k1 * f[1], k1 * f[2]], a.map(|a| k2 * a))
    }

    /// From `c`, `b` and `A` as xx, yy, zz, xy, xz, yz, without trace.
    pub(crate) fn from_parts(c: f64, b: [f64; 3], a: [f64; 6]) -> Self {
        let [xx, yy, zz, xy, xz, yz] = a;
        let square = xx * xx + yy * yy + zz * zz + 2.0 * (xy * xy + xz * xz + yz * yz);
        Self { c, b, a, linear: dot(b, b).sqrt(), form: (2.0 / 3.0 * square).sqrt() }
    }

    /// An upper bound of the absolute value of bands 1 and 2, scaled by `w`.
    #[inline]
    pub(crate) fn amplitude(&self, w: [f64; 2]) -> f64 {
        w[0] * self.linear + w[1] * self.form
    }

    /// A lower bound of the minimum when bands 1 and 2 are scaled by factors `w` for which `other` is not negative: the
    /// bound of the remainder `f - s f_other`, with the `s >= 0` for which bands 1 and 2 of the remainder are smallest.
    /// Tight for light of one color.
    pub(crate) fn least_beside(&self, other: &Self, w: [f64; 2]) -> f64 {
        // The inner product of the coefficients, from |b|² and |A|² with the norms √(3/4π) and √(15/8π).
        let inner = |p: &Self, q: &Self| {
            let diagonal = p.a[0] * q.a[0] + p.a[1] * q.a[1] + p.a[2] * q.a[2];
            let rest = p.a[3] * q.a[3] + p.a[4] * q.a[4] + p.a[5] * q.a[5];
            2.5 * dot(p.b, q.b) + diagonal + 2.0 * rest
        };
        let whole = inner(other, other);
        let s = if whole > 0.0 { (inner(self, other) / whole).max(0.0) } else { 0.0 };
        let b = [0, 1, 2].map(|k| self.b[k] - s * other.b[k]);
        let a = [0, 1, 2, 3, 4, 5].map(|k| self.a[k] - s * other.a[k]);
        let rest = Self::from_parts(self.c - s * other.c, b, a);
        rest.c - rest.amplitude(w)
    }

    /// The values of the three bands towards `x`.
    #[inline]
    pub(crate) fn bands(&self, x: [f64; 3]) -> [f64; 3] {
        [self.c, dot(self.b, x), dot(x, times(&self.a, x))]
    }

    /// `b` and the rows of `A`.
    pub(crate) fn parts(&self) -> ([f64; 3], [[f64; 3]; 3]) {
        let [xx, yy, zz, xy, xz, yz] = self.a;
        (self.b, [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    }
}

/// `A x`.
#[inline]
pub(crate) fn times(&[xx, yy, zz, xy, xz, yz]: &[f64; 6], [x, y, z]: [f64; 3]) -> [f64; 3] {
    [xx * x + xy * y + xz * z, xy * x + yy * y + yz * z, xz * x + yz * y + zz * z]
}

/// `1/√4π`, `√(3/4π)`, `√(15/16π)`, `1/√3`, `√3`.
pub(crate) fn norms() -> &'static [f64; 5] {
    static NORMS: Once<[f64; 5]> = Once::new();
    NORMS.get_or_init(|| {
        [(0.25 / PI).sqrt(), (0.75 / PI).sqrt(), (0.9375 / PI).sqrt(), 3.0_f64.sqrt().recip(), 3.0_f64.sqrt()]
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expansion::{Expansion as _, ShL2};
    use crate::sphere::Dir;
    use lobe_testkit::{Random, directions};

    #[test]
    fn the_quadratic_form_is_the_function() {
        let f = ShL2::<f64>::from_slice(&Random::new(1).signed_vec(9));
        let form = QuadraticForm::new(f.coefficients(), 0);
        for s in directions() {
            let sum: f64 = form.bands(s).iter().sum();
            let value = f.eval(Dir::from_unit(s));
            assert!((sum - value).abs() < 1e-14, "towards {s:?}: {sum} against {value}");
        }
    }

    #[test]
    fn a_channel_beside_another_is_not_below_its_bound() {
        let mut random = Random::new(6);
        for case in 0..1000 {
            let mut f = random.signed_vec(9);
            f[0] = 0.0;
            f[0] = -QuadraticForm::new(&f, 0).minimum([1.0, 1.0]).lo * (4.0 * PI).sqrt();
            let scale = 2.0 * random.unit();
            let g: Vec<f64> = f.iter().map(|f| scale * f + 0.1 * (random.unit() - 0.5) * f64::from(case % 4)).collect();
            let (f, g) = (QuadraticForm::new(&f, 0), QuadraticForm::new(&g, 0));
            let (bound, least) = (g.least_beside(&f, [1.0, 1.0]), g.minimum([1.0, 1.0]));
            assert!(bound <= least.hi + 1e-14, "case {case}: {bound} against {least:?}");
            assert!(case % 4 > 0 || bound > -1e-14, "case {case}, one color: {bound}");
        }
    }
}
