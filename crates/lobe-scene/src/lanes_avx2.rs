//! Eight lanes by AVX2 and FMA.

use std::arch::x86_64::{_CMP_LE_OQ, _CMP_LT_OQ};

use pulp::x86::V3;

use crate::lanes::{Lanes, WIDTH, Work};

/// What both instruction sets compute alike, by AVX and FMA.
macro_rules! avx_arithmetic {
    () => {
        type Vector = std::arch::x86_64::__m256;

        #[inline(always)]
        fn load(self, values: &[f32; WIDTH]) -> Self::Vector {
            pulp::cast(*values)
        }

        #[inline(always)]
        fn splat(self, value: f32) -> Self::Vector {
            self.avx._mm256_set1_ps(value)
        }

        #[inline(always)]
        fn store(self, values: Self::Vector) -> [f32; WIDTH] {
            pulp::cast(values)
        }

        #[inline(always)]
        fn sub(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
            self.avx._mm256_sub_ps(a, b)
        }

        #[inline(always)]
        fn mul(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
            self.avx._mm256_mul_ps(a, b)
        }

        #[inline(always)]
        fn mul_sub(self, a: Self::Vector, b: Self::Vector, c: Self::Vector) -> Self::Vector {
            self.fma._mm256_fmsub_ps(a, b, c)
        }

        #[inline(always)]
        fn min(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
            self.avx._mm256_min_ps(a, b)
        }

        #[inline(always)]
        fn max(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
            self.avx._mm256_max_ps(a, b)
        }
    };
}

pub(crate) use avx_arithmetic;

impl Lanes for V3 {
    avx_arithmetic!();

    #[inline(always)]
    fn less_or_equal(self, a: Self::Vector, b: Self::Vector) -> u32 {
        self.avx._mm256_movemask_ps(self.avx._mm256_cmp_ps::<_CMP_LE_OQ>(a, b)).cast_unsigned()
    }

    #[inline(always)]
    fn less(self, a: Self::Vector, b: Self::Vector) -> u32 {
        self.avx._mm256_movemask_ps(self.avx._mm256_cmp_ps::<_CMP_LT_OQ>(a, b)).cast_unsigned()
    }

    #[inline(always)]
    fn compress(self, values: &[u32; WIDTH], mask: u32) -> [u32; WIDTH] {
        let places = self.avx2._mm256_cvtepu8_epi32(pulp::cast([PLACES[mask as usize % PLACES.len()], 0]));
        pulp::cast(self.avx2._mm256_permutevar8x32_epi32(pulp::cast(*values), places))
    }

    #[inline(always)]
    fn run<W: Work>(self, work: W) -> W::Output {
        struct Job<W>(V3, W);

        impl<W: Work> pulp::NullaryFnOnce for Job<W> {
            type Output = W::Output;

            #[inline(always)]
            fn call(self) -> W::Output {
                self.1.work(self.0)
            }
        }
        self.vectorize(Job(self, work))
    }
}

/// For each mask, the numbers of its lanes in a row, a byte each.
static PLACES: [u64; 1 << WIDTH] = {
    let mut places = [0; 1 << WIDTH];
    let mut mask = 0;
    while mask < places.len() {
        let (mut lane, mut count) = (0, 0);
        while lane < WIDTH {
            if mask >> lane & 1 == 1 {
                places[mask] |= (lane as u64) << (8 * count);
                count += 1;
            }
            lane += 1;
        }
        mask += 1;
    }
    places
};
