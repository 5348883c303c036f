//! The numbers that rows of transfer are kept in.

use half::f16;

use crate::transfer::simd::{EIGHT, Lanes, widened};

/// A number of 32 or 16 bits.
pub(crate) trait Number: Copy + Sync {
    /// Eight of them in 32 bits. Exact.
    fn wide<L: Lanes>(lanes: L, numbers: &[Self; EIGHT]) -> L::Wide;

    /// One in 32 bits. Exact.
    fn single(self) -> f32;
}

impl Number for f32 {
    #[inline(always)]
    fn wide<L: Lanes>(lanes: L, numbers: &[Self; EIGHT]) -> L::Wide {
        lanes.load_wide(numbers)
    }

    #[inline(always)]
    fn single(self) -> f32 {
        self
    }
}

/// Finite ones: transfer has no others.
impl Number for f16 {
    #[inline(always)]
    fn wide<L: Lanes>(lanes: L, numbers: &[Self; EIGHT]) -> L::Wide {
        lanes.widen(&numbers.map(Self::to_bits))
    }

    #[inline(always)]
    fn single(self) -> f32 {
        widened(self.to_bits())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transfer::simd::{Machine, Work};

    #[test]
    fn every_finite_number_of_16_bits_keeps_its_value_and_its_sign() {
        let finite = (0..=u16::MAX).map(f16::from_bits).filter(|half| half.is_finite());
        let check = |half: f16| assert_eq!(half.single().to_bits(), half.to_f32().to_bits(), "{half:?}");
        assert_eq!(finite.map(check).count(), 2 * (31 << 10), "of 31 exponents");
    }

    /// Widens and transposes the halves whose bits begin at a number.
    struct Square<'a>(u16, &'a mut [[f32; EIGHT]; EIGHT]);

    impl Work for Square<'_> {
        #[inline(always)]
        fn work<L: Lanes>(self, lanes: L) {
            let row = |k: usize| std::array::from_fn(|i| f16::from_bits(self.0 + (EIGHT * k + i) as u16));
            let rows = std::array::from_fn(|k| f16::wide(lanes, &row(k)));
            *self.1 = lanes.transpose(rows).map(|column| lanes.store_wide(column));
        }
    }

    #[test]
    fn eight_at_a_time_are_the_same_and_columns_have_them_where_rows_did() {
        let first_bits = (0..1 << 16).step_by(EIGHT * EIGHT).map(|first| first as u16);
        for first in first_bits.filter(|&first| f16::from_bits(first).is_finite()) {
            let mut columns = [[f32::NAN; EIGHT]; EIGHT];
            Machine::detect().run(Square(first, &mut columns));
            for (i, column) in columns.iter().enumerate() {
                for (k, found) in column.iter().enumerate() {
                    let half = f16::from_bits(first + (EIGHT * k + i) as u16);
                    assert_eq!(found.to_bits(), half.to_f32().to_bits(), "{half:?}");
                }
            }
        }
    }
}
