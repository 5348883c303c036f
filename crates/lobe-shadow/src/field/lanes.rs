//! Several receivers side by side: a coefficient of each in one value.

use std::ops::{Add, AddAssign, Mul, Neg, Sub, SubAssign};

use lobe_sh::{Coefficient, Real};

/// Receivers side by side: as many as a vector register of 128 bits holds, which every x86-64 processor has.
pub(crate) const LANES: usize = 4;

/// One number of each of [`LANES`] receivers. As a [`Coefficient`] it goes through the kernels of `lobe-sh`, whose
/// straight-line code then works on all of them at once.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(16))]
pub(crate) struct Lanes<S>(pub(crate) [S; LANES]);

impl<S: Real> Default for Lanes<S> {
    fn default() -> Self {
        Self::ZERO
    }
}

/// `f` of every lane.
#[inline(always)]
fn each<S: Real>(f: impl FnMut(usize) -> S) -> Lanes<S> {
    Lanes(std::array::from_fn(f))
}

impl<S: Real> Add for Lanes<S> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        each(|k| self.0[k] + other.0[k])
    }
}

impl<S: Real> Sub for Lanes<S> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        each(|k| self.0[k] - other.0[k])
    }
}

impl<S: Real> Mul for Lanes<S> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        each(|k| self.0[k] * other.0[k])
    }
}

impl<S: Real> Neg for Lanes<S> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        each(|k| -self.0[k])
    }
}

impl<S: Real> AddAssign for Lanes<S> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<S: Real> SubAssign for Lanes<S> {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl<S: Real> Coefficient for Lanes<S> {
    type Scalar = S;
    type Wide = Lanes<f64>;
    const CHANNELS: usize = LANES;
    const ZERO: Self = Self([S::ZERO; LANES]);

    #[inline(always)]
    fn splat(s: S) -> Self {
        Self([s; LANES])
    }

    #[inline(always)]
    fn scale(self, s: S) -> Self {
        each(|k| self.0[k] * s)
    }

    #[inline]
    fn channel(self, c: usize) -> S {
        self.0[c]
    }

    #[inline]
    fn from_channels(f: impl FnMut(usize) -> S) -> Self {
        each(f)
    }

    #[inline(always)]
    fn widen(self) -> Lanes<f64> {
        each(|k| self.0[k].to_f64())
    }

    #[inline(always)]
    fn narrow(wide: Lanes<f64>) -> Self {
        each(|k| S::from_f64(wide.0[k]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lobe_sh::product_into;
    use lobe_testkit::Random;

    #[test]
    fn every_lane_of_a_product_is_the_product_of_the_lanes() {
        let mut random = Random::new(1);
        for order in 1..=7 {
            let n = order * order;
            let mut lanes = || -> Vec<Lanes<f32>> { (0..n).map(|_| each(|_| random.signed() as f32)).collect() };
            let (a, b) = (lanes(), lanes());
            let mut c = vec![Lanes::ZERO; n];
            product_into(&a, &b, &mut c);
            for k in 0..LANES {
                let of = |x: &[Lanes<f32>]| x.iter().map(|x| x.0[k]).collect::<Vec<f32>>();
                let mut expected = vec![0.0; n];
                product_into(&of(&a), &of(&b), &mut expected);
                assert_eq!(of(&c), expected, "order {order}, lane {k}");
            }
        }
    }
}
