//! SIMD arithmetic on four and on eight lanes, with AVX2's instructions where the machine has them.
//!
//! Left to itself the compiler turns rows into columns by way of the stack, at three times the cost. Every operation
//! rounds by itself and alike in both implementations, so the bytes are the same.

#[cfg(target_arch = "x86_64")]
use pulp::NullaryFnOnce;

/// The number of lanes of a vector.
pub(crate) const FOUR: usize = 4;

/// The number of lanes of a wide one.
pub(crate) const EIGHT: usize = 8;

/// Arithmetic on four and on eight lanes of `f32`.
pub(crate) trait Lanes: Copy {
    /// Four lanes.
    type Vector: Copy;
    /// Eight lanes.
    type Wide: Copy;

    fn load(self, values: [f32; FOUR]) -> Self::Vector;
    fn splat(self, value: f32) -> Self::Vector;
    fn store(self, values: Self::Vector) -> [f32; FOUR];
    /// `sum + a b`, rounded twice.
    fn add_product(self, sum: Self::Vector, a: Self::Vector, b: Self::Vector) -> Self::Vector;

    fn load_wide(self, values: &[f32; EIGHT]) -> Self::Wide;
    fn splat_wide(self, value: f32) -> Self::Wide;
    #[cfg(test)]
    fn store_wide(self, values: Self::Wide) -> [f32; EIGHT];
    /// `sum + a b`, rounded twice.
    fn add_product_wide(self, sum: Self::Wide, a: Self::Wide, b: Self::Wide) -> Self::Wide;
    /// The finite numbers of 16 bits with these bits, as [`widened`] has each.
    fn widen(self, halves: &[u16; EIGHT]) -> Self::Wide;
    /// `((v_0 + v_4) + (v_2 + v_6)) + ((v_1 + v_5) + (v_3 + v_7))` of each.
    fn sums(self, values: [Self::Wide; 3]) -> [f32; 3];
    /// The columns of a square.
    fn transpose(self, rows: [Self::Wide; EIGHT]) -> [Self::Wide; EIGHT];
    /// Four numbers beside four others.
    fn pair(self, first: &[f32; FOUR], last: &[f32; FOUR]) -> Self::Wide;
    /// The columns of the first halves beside those of the last halves.
    fn transpose_halves(self, rows: [Self::Wide; FOUR]) -> [Self::Wide; FOUR];
    /// Colors from their channels.
    fn store_colors(self, channels: [Self::Wide; 3]) -> [f32; 3 * EIGHT];
}

/// Exponent and fraction of a half, where an `f32` has its own.
const SIZE: u32 = 0x7fff << 13;

/// The sign.
const SIGN: u32 = 1 << 31;

/// What is added to an exponent that counts from 15 to make it count from 127.
const BIAS: u32 = (127 - 15) << 23;

/// `2⁻¹⁴`, the least half that has a leading one.
const LEAST: f32 = f32::from_bits((127 - 14) << 23);

/// A finite number of 16 bits in 32.
///
/// ```text
///   P = exponent and fraction where an f32 has them, 112 added to the exponent        |x| = min(P, 2P - 2⁻¹⁴)
/// ```
///
/// From `2⁻¹⁴` on `P` is the number. Below, a half has no leading one and an exponent of 0 that counts as 1: `P` reads as
/// `2⁻¹⁵ (1 + f)` for `2⁻¹⁴ f`. Both are exact, and no `f32` on the way is below the normal ones, for which processors of
/// Intel take some 150 cycles (test `no_half_becomes_a_number_without_a_leading_one_on_its_way`).
#[inline(always)]
pub(crate) fn widened(half: u16) -> f32 {
    // The bits copied from the sign on the way fall outside of what is kept.
    let spread = (i32::from(half.cast_signed()) << 13).cast_unsigned();
    let [size, small] = sizes(spread);
    let least = if size < small { size } else { small };
    f32::from_bits(least.to_bits() | spread & SIGN)
}

/// `P` and `2P - 2⁻¹⁴`, see [`widened`].
#[inline(always)]
fn sizes(spread: u32) -> [f32; 2] {
    let size = f32::from_bits((spread & SIZE) + BIAS);
    [size, 2.0 * size - LEAST]
}

/// Work to be done with these lanes.
pub(crate) trait Work {
    /// Does the work. To be marked `#[inline(always)]`, or it is compiled without the instructions.
    fn work<L: Lanes>(self, lanes: L);
}

/// The widest instructions of this machine.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Machine {
    /// x86-64 with AVX2.
    #[cfg(target_arch = "x86_64")]
    Avx2(pulp::x86::V3),
    /// Any.
    Plain,
}

impl Machine {
    /// The widest that [`lobe_sh::simd::Machine`] allows.
    pub(crate) fn detect() -> Self {
        #[cfg(target_arch = "x86_64")]
        if let Some(v3) = lobe_sh::simd::Machine::detect().avx2() {
            return Self::Avx2(v3);
        }
        Self::Plain
    }

    #[inline]
    pub(crate) fn run<W: Work>(self, work: W) {
        match self {
            #[cfg(target_arch = "x86_64")]
            Self::Avx2(v3) => v3.vectorize(Job(v3, work)),
            Self::Plain => work.work(Plain),
        }
    }
}

/// A type, because closures are not inlined where the instructions are.
#[cfg(target_arch = "x86_64")]
struct Job<L, W>(L, W);

#[cfg(target_arch = "x86_64")]
impl<L: Lanes, W: Work> NullaryFnOnce for Job<L, W> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        self.1.work(self.0);
    }
}

/// The same lanes as the compiler likes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plain;

impl Lanes for Plain {
    type Vector = [f32; FOUR];
    type Wide = [f32; EIGHT];

    #[inline(always)]
    fn load(self, values: [f32; FOUR]) -> Self::Vector {
        values
    }

    #[inline(always)]
    fn splat(self, value: f32) -> Self::Vector {
        [value; FOUR]
    }

    #[inline(always)]
    fn store(self, values: Self::Vector) -> [f32; FOUR] {
        values
    }

    #[inline(always)]
    fn add_product(self, sum: Self::Vector, a: Self::Vector, b: Self::Vector) -> Self::Vector {
        std::array::from_fn(|k| sum[k] + a[k] * b[k])
    }

    #[inline(always)]
    fn load_wide(self, values: &[f32; EIGHT]) -> Self::Wide {
        *values
    }

    #[inline(always)]
    fn splat_wide(self, value: f32) -> Self::Wide {
        [value; EIGHT]
    }

    #[cfg(test)]
    #[inline(always)]
    fn store_wide(self, values: Self::Wide) -> [f32; EIGHT] {
        values
    }

    #[inline(always)]
    fn add_product_wide(self, sum: Self::Wide, a: Self::Wide, b: Self::Wide) -> Self::Wide {
        std::array::from_fn(|k| sum[k] + a[k] * b[k])
    }

    #[inline(always)]
    fn widen(self, halves: &[u16; EIGHT]) -> Self::Wide {
        halves.map(widened)
    }

    #[inline(always)]
    fn sums(self, values: [Self::Wide; 3]) -> [f32; 3] {
        values.map(|v| ((v[0] + v[4]) + (v[2] + v[6])) + ((v[1] + v[5]) + (v[3] + v[7])))
    }

    #[inline(always)]
    fn transpose(self, rows: [Self::Wide; EIGHT]) -> [Self::Wide; EIGHT] {
        std::array::from_fn(|i| std::array::from_fn(|k| rows[k][i]))
    }

    #[inline(always)]
    fn pair(self, first: &[f32; FOUR], last: &[f32; FOUR]) -> Self::Wide {
        std::array::from_fn(|i| if i < FOUR { first[i] } else { last[i - FOUR] })
    }

    #[inline(always)]
    fn transpose_halves(self, rows: [Self::Wide; FOUR]) -> [Self::Wide; FOUR] {
        std::array::from_fn(|i| std::array::from_fn(|k| rows[k % FOUR][k / FOUR * FOUR + i]))
    }

    #[inline(always)]
    fn store_colors(self, channels: [Self::Wide; 3]) -> [f32; 3 * EIGHT] {
        std::array::from_fn(|k| channels[k % 3][k / 3])
    }
}

#[cfg(target_arch = "x86_64")]
mod avx2 {
    use std::arch::x86_64::{__m128, __m256};

    use pulp::x86::V3;

    use super::{BIAS, EIGHT, FOUR, LEAST, Lanes, SIGN, SIZE};

    impl Lanes for V3 {
        type Vector = __m128;
        type Wide = __m256;

        #[inline(always)]
        fn load(self, values: [f32; FOUR]) -> Self::Vector {
            pulp::cast(values)
        }

        #[inline(always)]
        fn splat(self, value: f32) -> Self::Vector {
            self.sse._mm_set1_ps(value)
        }

        #[inline(always)]
        fn store(self, values: Self::Vector) -> [f32; FOUR] {
            pulp::cast(values)
        }

        #[inline(always)]
        fn add_product(self, sum: Self::Vector, a: Self::Vector, b: Self::Vector) -> Self::Vector {
            self.sse._mm_add_ps(sum, self.sse._mm_mul_ps(a, b))
        }

        #[inline(always)]
        fn load_wide(self, values: &[f32; EIGHT]) -> Self::Wide {
            pulp::cast(*values)
        }

        #[inline(always)]
        fn splat_wide(self, value: f32) -> Self::Wide {
            self.avx._mm256_set1_ps(value)
        }

        #[cfg(test)]
        #[inline(always)]
        fn store_wide(self, values: Self::Wide) -> [f32; EIGHT] {
            pulp::cast(values)
        }

        #[inline(always)]
        fn add_product_wide(self, sum: Self::Wide, a: Self::Wide, b: Self::Wide) -> Self::Wide {
            self.avx._mm256_add_ps(sum, self.avx._mm256_mul_ps(a, b))
        }

        #[inline(always)]
        fn widen(self, halves: &[u16; EIGHT]) -> Self::Wide {
            let spread = self.avx2._mm256_slli_epi32::<13>(self.avx2._mm256_cvtepi16_epi32(pulp::cast(*halves)));
            let [size, sign, bias] = [SIZE, SIGN, BIAS].map(u32::cast_signed);
            let size = self.avx2._mm256_and_si256(spread, self.avx._mm256_set1_epi32(size));
            let size = pulp::cast(self.avx2._mm256_add_epi32(size, self.avx._mm256_set1_epi32(bias)));
            let small = self.fma._mm256_fmsub_ps(size, self.avx._mm256_set1_ps(2.0), self.avx._mm256_set1_ps(LEAST));
            let sign = self.avx2._mm256_and_si256(spread, self.avx._mm256_set1_epi32(sign));
            self.avx._mm256_or_ps(self.avx._mm256_min_ps(size, small), pulp::cast(sign))
        }

        #[inline(always)]
        fn sums(self, values: [Self::Wide; 3]) -> [f32; 3] {
            let add = |a, b| self.sse._mm_add_ps(a, b);
            let [r, g, b] =
                values.map(|v| add(self.avx._mm256_castps256_ps128(v), self.avx._mm256_extractf128_ps::<1>(v)));
            // r_0 + r_2, g_0 + g_2, r_1 + r_3, g_1 + g_3.
            let pairs = add(self.sse._mm_unpacklo_ps(r, g), self.sse._mm_unpackhi_ps(r, g));
            let pair = add(b, self.sse._mm_movehl_ps(b, b));
            let [red, green, ..] = self.store(add(pairs, self.sse._mm_movehl_ps(pairs, pairs)));
            let [even, odd, ..] = self.store(pair);
            [red, green, even + odd]
        }

        /// Of each half, then of halves. Without closures: long ones are compiled by themselves, for any machine.
        #[inline(always)]
        fn transpose(self, [a, b, c, d, e, f, g, h]: [Self::Wide; EIGHT]) -> [Self::Wide; EIGHT] {
            let (first, last) = (self.transpose_halves([a, b, c, d]), self.transpose_halves([e, f, g, h]));
            let mut columns = [a; EIGHT];
            for i in 0..FOUR {
                columns[i] = self.avx._mm256_permute2f128_ps::<0x20>(first[i], last[i]);
                columns[FOUR + i] = self.avx._mm256_permute2f128_ps::<0x31>(first[i], last[i]);
            }
            columns
        }

        #[inline(always)]
        fn pair(self, first: &[f32; FOUR], last: &[f32; FOUR]) -> Self::Wide {
            self.avx._mm256_set_m128(pulp::cast(*last), pulp::cast(*first))
        }

        #[inline(always)]
        fn transpose_halves(self, [a, b, c, d]: [Self::Wide; FOUR]) -> [Self::Wide; FOUR] {
            let (lo, hi) = (self.avx._mm256_unpacklo_ps(a, b), self.avx._mm256_unpackhi_ps(a, b));
            let (next_lo, next_hi) = (self.avx._mm256_unpacklo_ps(c, d), self.avx._mm256_unpackhi_ps(c, d));
            [
                self.avx._mm256_shuffle_ps::<0x44>(lo, next_lo),
                self.avx._mm256_shuffle_ps::<0xee>(lo, next_lo),
                self.avx._mm256_shuffle_ps::<0x44>(hi, next_hi),
                self.avx._mm256_shuffle_ps::<0xee>(hi, next_hi),
            ]
        }

        /// Three registers of four colors each half, then the halves one after the other.
        #[inline(always)]
        fn store_colors(self, [r, g, b]: [Self::Wide; 3]) -> [f32; 3 * EIGHT] {
            let (first, last) = (self.avx._mm256_unpacklo_ps(r, g), self.avx._mm256_unpackhi_ps(r, g));
            let first =
                self.avx._mm256_shuffle_ps::<0b10_00_01_00>(first, self.avx._mm256_shuffle_ps::<0b01_01_00_00>(b, r));
            let middle = self.avx._mm256_shuffle_ps::<0b01_01_01_01>(g, b);
            let middle = self.avx._mm256_shuffle_ps::<0b01_00_10_00>(middle, last);
            let last = self.avx._mm256_shuffle_ps::<0b11_11_11_11>(g, b);
            let last =
                self.avx._mm256_shuffle_ps::<0b10_00_10_00>(self.avx._mm256_shuffle_ps::<0b11_11_10_10>(b, r), last);
            let lines = [
                self.avx._mm256_permute2f128_ps::<0x20>(first, middle),
                self.avx._mm256_permute2f128_ps::<0x30>(last, first),
                self.avx._mm256_permute2f128_ps::<0x31>(middle, last),
            ];
            pulp::cast(lines)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_half_becomes_a_number_without_a_leading_one_on_its_way() {
        for half in (0..=u16::MAX).filter(|half| half & 0x7c00 != 0x7c00) {
            let [size, small] = sizes((i32::from(half.cast_signed()) << 13).cast_unsigned());
            assert!(size.is_normal(), "{half:#06x}: {size:e}");
            assert!(small.is_normal() || small == 0.0, "{half:#06x}: {small:e}");
            assert_eq!(widened(half), half::f16::from_bits(half).to_f32(), "{half:#06x}");
        }
    }
}
