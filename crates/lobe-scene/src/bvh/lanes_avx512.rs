//! Eight-wide SIMD by AVX-512: comparisons give masks, and one instruction compacts lanes.

use std::arch::x86_64::{__m512i, _CMP_LE_OQ, _CMP_LT_OQ};

use pulp::x86::V4;

use crate::bvh::lanes::{ALONE, Lanes, WIDTH, Work};
use crate::bvh::lanes_avx2::avx_arithmetic;

impl Lanes for V4 {
    avx_arithmetic!();

    type Sets = __m512i;

    #[inline(always)]
    fn empty_sets(self) -> Self::Sets {
        self.avx512f._mm512_setzero_si512()
    }

    #[inline(always)]
    fn insert_where(self, sets: Self::Sets, a: Self::Vector, b: Self::Vector, number: usize) -> Self::Sets {
        let is_in = self.avx512f._mm256_cmp_ps_mask::<_CMP_LE_OQ>(a, b);
        let alone = self.avx512f._mm512_set1_epi64(ALONE[number % 64].cast_signed());
        self.avx512f._mm512_mask_or_epi64(sets, is_in, sets, alone)
    }

    #[inline(always)]
    fn store_sets(self, sets: Self::Sets) -> [u64; WIDTH] {
        pulp::cast(sets)
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
