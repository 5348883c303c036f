//! The numbers that rows of transfer are kept in.

use half::f16;

use crate::transfer::simd::{EIGHT, FOUR, Lanes, widened};

/// A number of 32 or 16 bits.
pub(crate) trait Number: Copy + Sync {
    /// Eight of them in 32 bits. Exact.
    fn wide<L: Lanes>(lanes: L, numbers: &[Self; EIGHT]) -> L::Wide;

    /// One in 32 bits. Exact.
    fn single(self) -> f32;

    /// The columns of eight rows, in 32 bits.
    fn columns<L: Lanes>(lanes: L, rows: [&[Self; EIGHT]; EIGHT]) -> [L::Wide; EIGHT];

    /// The same of rows of four.
    fn four_columns<L: Lanes>(lanes: L, rows: [&[Self; FOUR]; EIGHT]) -> [L::Wide; FOUR];
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

    /// Halves of rows are loaded beside each other: no number moves from one half of a register to the other.
    #[inline(always)]
    fn columns<L: Lanes>(lanes: L, rows: [&[Self; EIGHT]; EIGHT]) -> [L::Wide; EIGHT] {
        let (mut first, mut last) = ([&[0.0; FOUR]; EIGHT], [&[0.0; FOUR]; EIGHT]);
        for k in 0..EIGHT {
            if let ([a, b], _) = rows[k].as_chunks::<FOUR>() {
                (first[k], last[k]) = (a, b);
            }
        }
        let ([a, b, c, d], [e, f, g, h]) = (Self::four_columns(lanes, first), Self::four_columns(lanes, last));
        [a, b, c, d, e, f, g, h]
    }

    #[inline(always)]
    fn four_columns<L: Lanes>(lanes: L, [a, b, c, d, e, f, g, h]: [&[Self; FOUR]; EIGHT]) -> [L::Wide; FOUR] {
        lanes.transpose_halves([lanes.pair(a, e), lanes.pair(b, f), lanes.pair(c, g), lanes.pair(d, h)])
    }
}

/// Finite ones: transfer has no others.
impl Number for f16 {
    #[inline(always)]
    fn wide<L: Lanes>(lanes: L, numbers: &[Self; EIGHT]) -> L::Wide {
        let mut bits = [0; EIGHT];
        for k in 0..EIGHT {
            bits[k] = numbers[k].to_bits();
        }
        lanes.widen(&bits)
    }

    #[inline(always)]
    fn single(self) -> f32 {
        widened(self.to_bits())
    }

    #[inline(always)]
    fn columns<L: Lanes>(lanes: L, rows: [&[Self; EIGHT]; EIGHT]) -> [L::Wide; EIGHT] {
        let mut square = [lanes.splat_wide(0.0); EIGHT];
        for k in 0..EIGHT {
            square[k] = Self::wide(lanes, rows[k]);
        }
        lanes.transpose(square)
    }

    #[inline(always)]
    fn four_columns<L: Lanes>(lanes: L, rows: [&[Self; FOUR]; EIGHT]) -> [L::Wide; FOUR] {
        let mut pairs = [lanes.splat_wide(0.0); FOUR];
        for k in 0..FOUR {
            let ([a, b, c, d], [e, f, g, h]) = (*rows[k], *rows[k + FOUR]);
            pairs[k] = Self::wide(lanes, &[a, b, c, d, e, f, g, h]);
        }
        lanes.transpose_halves(pairs)
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
            let rows: [[f16; EIGHT]; EIGHT] = std::array::from_fn(row);
            *self.1 = f16::columns(lanes, rows.each_ref()).map(|column| lanes.store_wide(column));
        }
    }

    /// The first half of the columns of a square.
    struct Fours<'a, T>(&'a [[T; EIGHT]; EIGHT], &'a mut [[f32; EIGHT]; FOUR]);

    impl<T: Number> Work for Fours<'_, T> {
        #[inline(always)]
        fn work<L: Lanes>(self, lanes: L) {
            let rows = self.0.each_ref().map(|row| &row.as_chunks::<FOUR>().0[0]);
            *self.1 = T::four_columns(lanes, rows).map(|column| lanes.store_wide(column));
        }
    }

    #[test]
    fn half_of_the_columns_are_those_of_the_whole() {
        let square: [[f32; EIGHT]; EIGHT] = std::array::from_fn(|k| std::array::from_fn(|i| (EIGHT * k + i) as f32));
        let halves = square.map(|row| row.map(f16::from_f32));
        for machine in [Machine::detect(), Machine::Plain] {
            let (mut singles, mut widened) = ([[f32::NAN; EIGHT]; FOUR], [[f32::NAN; EIGHT]; FOUR]);
            machine.run(Fours(&square, &mut singles));
            machine.run(Fours(&halves, &mut widened));
            for i in 0..FOUR {
                let expected: [f32; EIGHT] = std::array::from_fn(|k| square[k][i]);
                assert_eq!([singles[i], widened[i]], [expected; 2], "column {i}, {machine:?}");
            }
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
