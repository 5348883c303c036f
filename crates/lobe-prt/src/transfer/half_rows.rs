//! Dot products of many rows of 16 bits with one light.
//!
//! Rationale
//! - Rows are converted a few at a time, into the first-level cache, and summed by [`dot_rows`](super::dot_rows). The conversion is exact, so
//!   that the sums are to the bit those of the same numbers in 32 bits.
//! - [`widen`] has no branch, and compilers turn a loop of it into the widest instructions of the machine. `half` converts eight numbers a
//!   call: with it a gray receiver of order 4 takes 16.8 ns instead of 12.1 (AVX2).

use half::f16;

use crate::transfer::dot_rows::RowsOfChunk;
use crate::transfer::simd4::{Lanes, Work};

/// Receivers whose numbers are converted at a time: those of order 4 in color, the usual ones, and what they become take 9 KB of the
/// first-level cache.
const CONVERTED: usize = 32;

/// To the bit what the same numbers in 32 bits have.
impl Work for RowsOfChunk<'_, f16> {
    #[inline(always)]
    fn work<L: Lanes>(self, lanes: L) {
        let Self { rows, order, channels, light, out } = self;
        let width = order * order * channels;
        let mut numbers = vec![0.0; CONVERTED * width];
        for (rows, out) in rows.chunks(CONVERTED * width).zip(out.chunks_mut(CONVERTED)) {
            let numbers = &mut numbers[..rows.len()];
            for (number, half) in numbers.iter_mut().zip(rows) {
                *number = widen(*half);
            }
            RowsOfChunk { rows: numbers, order, channels, light, out }.work(lanes);
        }
    }
}

/// A finite number of 16 bits in 32.
///
/// Sign, exponent and fraction are put where an `f32` has them. As exponents count from 15 there and from 127 here, what that reads as is
/// `2^(15 - 127)` of the number; below `2⁻¹⁴`, where neither has a leading one, too. The product is exact.
#[inline(always)]
fn widen(half: f16) -> f32 {
    /// The sign, and the 15 bits of exponent and fraction where an `f32` has its own.
    const KEPT: u32 = 1 << 31 | 0x7fff << 13;
    /// `2¹¹²`.
    const SCALE: f32 = f32::from_bits((127 + 112) << 23);
    // The bits copied from the sign on the way fall outside of what is kept.
    let spread = i32::from(half.to_bits().cast_signed()) << 13;
    f32::from_bits(spread.cast_unsigned() & KEPT) * SCALE
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_finite_number_of_16_bits_keeps_its_value_and_its_sign() {
        let finite = (0..=u16::MAX).map(f16::from_bits).filter(|half| half.is_finite());
        let count = finite.map(|half| assert_eq!(widen(half).to_bits(), half.to_f32().to_bits(), "{half:?}")).count();
        assert_eq!(count, 2 * (31 << 10), "of 31 exponents");
    }
}
