//! Eight lanes by AVX-512: comparisons give masks, and lanes move together by one instruction.

use std::arch::x86_64::{__m256, _CMP_LE_OQ, _CMP_LT_OQ};

use pulp::x86::V4;

use crate::lanes::{Lanes, WIDTH, Work};

impl Lanes for V4 {
    type Vector = __m256;

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

    #[inline(always)]
    fn less_or_equal(self, a: Self::Vector, b: Self::Vector) -> u32 {
        self.avx512f._mm256_cmp_ps_mask::<_CMP_LE_OQ>(a, b).into()
    }

    #[inline(always)]
    fn less(self, a: Self::Vector, b: Self::Vector) -> u32 {
        self.avx512f._mm256_cmp_ps_mask::<_CMP_LT_OQ>(a, b).into()
    }

    #[inline(always)]
    fn compress(self, values: &[u32; WIDTH], mask: u32) -> [u32; WIDTH] {
        pulp::cast(self.avx512f._mm256_maskz_compress_epi32(mask as u8, pulp::cast(*values)))
    }

    #[inline(always)]
    fn run<W: Work>(self, work: W) -> W::Output {
        struct Job<W>(V4, W);

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
