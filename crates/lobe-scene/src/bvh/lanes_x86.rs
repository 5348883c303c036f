//! Eight-wide SIMD by AVX2 and FMA, and by AVX-512, where comparisons give masks and one instruction compacts lanes.

use std::arch::x86_64::{__m256i, __m512i, _CMP_LE_OQ, _CMP_LT_OQ};

use pulp::x86::{V3, V4};

use crate::bvh::lanes::{ALONE, Lanes, WIDTH, Work};

/// The operations that both instruction sets share, by AVX and FMA.
macro_rules! avx_arithmetic {
    ($set:ident) => {
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
        fn mul_add(self, a: Self::Vector, b: Self::Vector, c: Self::Vector) -> Self::Vector {
            self.fma._mm256_fmadd_ps(a, b, c)
        }

        #[inline(always)]
        fn sqrt(self, a: Self::Vector) -> Self::Vector {
            self.avx._mm256_sqrt_ps(a)
        }

        #[inline(always)]
        fn copy_sign(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
            let sign = self.avx._mm256_set1_ps(-0.0);
            self.avx._mm256_or_ps(self.avx._mm256_andnot_ps(sign, a), self.avx._mm256_and_ps(sign, b))
        }

        #[inline(always)]
        fn prefetch<T>(self, value: &T) {
            let start = std::ptr::from_ref(value).cast::<i8>();
            for line in 0..size_of::<T>().div_ceil(64) {
                self.sse._mm_prefetch::<{ std::arch::x86_64::_MM_HINT_T0 }>(start.wrapping_add(64 * line));
            }
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
        fn run<W: Work>(self, work: W) -> W::Output {
            struct Job<W>($set, W);

            impl<W: Work> pulp::NullaryFnOnce for Job<W> {
                type Output = W::Output;

                #[inline(always)]
                fn call(self) -> W::Output {
                    self.1.work(self.0)
                }
            }
            self.vectorize(Job(self, work))
        }
    };
}

impl Lanes for V3 {
    avx_arithmetic!(V3);

    /// Of lanes 0, 1, 4, 5 and of lanes 2, 3, 6, 7.
    type Sets = [__m256i; 2];

    #[inline(always)]
    fn empty_sets(self) -> Self::Sets {
        [self.avx._mm256_setzero_si256(); 2]
    }

    #[inline(always)]
    fn insert_where(self, sets: Self::Sets, a: Self::Vector, b: Self::Vector, number: usize) -> Self::Sets {
        let is_in = pulp::cast(self.avx._mm256_cmp_ps::<_CMP_LE_OQ>(a, b));
        let alone = self.avx._mm256_set1_epi64x(ALONE[number % 64].cast_signed());
        let twice = [self.avx2._mm256_unpacklo_epi32(is_in, is_in), self.avx2._mm256_unpackhi_epi32(is_in, is_in)];
        std::array::from_fn(|k| self.avx2._mm256_or_si256(sets[k], self.avx2._mm256_and_si256(twice[k], alone)))
    }

    #[inline(always)]
    fn store_sets(self, sets: Self::Sets) -> [u64; WIDTH] {
        let [[a, b, e, f], [c, d, g, h]]: [[u64; 4]; 2] = sets.map(pulp::cast);
        [a, b, c, d, e, f, g, h]
    }

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
}

/// For each mask, the indices of its lanes in order, a byte each.
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

impl Lanes for V4 {
    avx_arithmetic!(V4);

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
}
