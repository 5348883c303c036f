//! One product of two expansions of order 3 or 4 in `f32`, with fused sums where the machine has them.

use crate::product::fused::{general_3, general_4};
use crate::simd::{Kernel, Machine};

/// Sums of products in one operation, rounded once.
pub(crate) trait Fuse {
    /// `self a`.
    fn times(self, a: Self) -> Self;

    /// `self a + g`.
    fn times_plus(self, a: Self, g: Self) -> Self;

    /// `g - self a`.
    fn times_from(self, a: Self, g: Self) -> Self;
}

impl Fuse for f32 {
    #[inline(always)]
    fn times(self, a: Self) -> Self {
        self * a
    }

    #[inline(always)]
    fn times_plus(self, a: Self, g: Self) -> Self {
        self.mul_add(a, g)
    }

    #[inline(always)]
    fn times_from(self, a: Self, g: Self) -> Self {
        (-self).mul_add(a, g)
    }
}

/// The product in place of `out` if both factors and the product are of order 3 or of order 4, and the machine fuses;
/// whether it is.
///
/// Sums and products in one operation are half as many operations that wait for each other.
pub(crate) fn multiply_pair(a: &[f32], b: &[f32], out: &mut [f32]) -> bool {
    let machine = Machine::detect();
    if machine.is_plain() {
        return false;
    }
    if let (Ok(a), Ok(b), Ok(out)) = (a.try_into(), b.try_into(), <&mut [f32; 9]>::try_from(&mut *out)) {
        machine.run_scalar(OfOrder3 { a, b, out });
        return true;
    }
    if let (Ok(a), Ok(b), Ok(out)) = (a.try_into(), b.try_into(), <&mut [f32; 16]>::try_from(&mut *out)) {
        machine.run_scalar(OfOrder4 { a, b, out });
        return true;
    }
    false
}

macro_rules! kernel {
    ($name:ident $count:literal $code:ident) => {
        struct $name<'a> {
            a: &'a [f32; $count],
            b: &'a [f32; $count],
            out: &'a mut [f32; $count],
        }

        impl Kernel for $name<'_> {
            type Output = ();

            #[inline(always)]
            fn wide<S: pulp::Simd>(self, _: S) {
                $code::product(self.a, self.b, self.out);
            }

            fn plain(self) {
                $code::product(self.a, self.b, self.out);
            }
        }
    };
}

kernel!(OfOrder3 9 general_3);
kernel!(OfOrder4 16 general_4);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::product::generated;

    /// Of sums of some twenty products of numbers below 1.
    const ERROR: f32 = 1e-6;

    #[test]
    fn fused_products_are_those_that_round_each_operation() {
        let mut random = lobe_testkit::Random::new(9);
        for order in [3_usize, 4] {
            let count = order * order;
            for _ in 0..100 {
                let [a, b] = [(); 2].map(|()| -> Vec<f32> { (0..count).map(|_| random.signed() as f32).collect() });
                let (mut fused, mut expected) = (vec![f32::NAN; count], vec![f32::NAN; count]);
                assert!(generated::general(&a, &b, &mut expected), "order {order} has code");
                let is_fused = multiply_pair(&a, &b, &mut fused);
                assert_eq!(is_fused, !Machine::detect().is_plain(), "order {order}");
                if is_fused {
                    let worst = fused.iter().zip(&expected).fold(0.0_f32, |worst, (x, y)| worst.max((x - y).abs()));
                    assert!(worst < ERROR, "order {order}: {worst} of {fused:?} and {expected:?}");
                }
            }
        }
    }
}
