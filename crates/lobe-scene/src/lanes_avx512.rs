//! Eight lanes by AVX-512: comparisons give masks, and lanes move together by one instruction.

use std::arch::x86_64::{_CMP_LE_OQ, _CMP_LT_OQ};

use pulp::x86::V4;

use crate::lanes::{Lanes, WIDTH, Work};
use crate::lanes_avx2::avx_arithmetic;

impl Lanes for V4 {
    avx_arithmetic!();

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
