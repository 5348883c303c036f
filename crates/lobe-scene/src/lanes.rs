//! Eight numbers at once, with AVX2 where the machine has it.
//!
//! Both implementations round every operation alike but [`Lanes::mul_sub`], which only boxes use: they are tested with
//! room for its error, triangles are not. So hits are the same bit by bit.

/// How many boxes or triangles are tested at once.
pub(crate) const WIDTH: usize = 8;

/// Arithmetic on eight lanes of `f32`. Comparisons give a mask with a bit for each lane.
pub(crate) trait Lanes: Copy {
    /// Eight lanes.
    type Vector: Copy;

    fn load(self, values: &[f32; WIDTH]) -> Self::Vector;
    fn splat(self, value: f32) -> Self::Vector;
    fn store(self, values: Self::Vector) -> [f32; WIDTH];
    fn sub(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    fn mul(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// `a b - c`, rounded once or twice.
    fn mul_sub(self, a: Self::Vector, b: Self::Vector, c: Self::Vector) -> Self::Vector;
    fn min(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    fn max(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// Lanes where `a ≤ b`; none where either is NaN.
    fn less_or_equal(self, a: Self::Vector, b: Self::Vector) -> u32;
    /// Lanes where `a < b`; none where either is NaN.
    fn less(self, a: Self::Vector, b: Self::Vector) -> u32;
    /// Calls `work` where the compiler may use the instructions of these lanes.
    fn run<W: Work>(self, work: W) -> W::Output;
}

/// Something to do with eight lanes.
pub(crate) trait Work {
    /// What comes out.
    type Output;

    /// Does it. To be marked `#[inline(always)]`, or it is compiled without the instructions.
    fn work<L: Lanes>(self, lanes: L) -> Self::Output;
}

/// The widest lanes of this machine.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Machine {
    /// x86-64 with AVX2 and FMA.
    #[cfg(target_arch = "x86_64")]
    Avx2(pulp::x86::V3),
    /// Any.
    Scalar,
}

impl Machine {
    /// Asks the processor.
    pub(crate) fn detect() -> Self {
        #[cfg(target_arch = "x86_64")]
        if let Some(v3) = pulp::x86::V3::try_new() {
            return Self::Avx2(v3);
        }
        Self::Scalar
    }

    #[inline]
    pub(crate) fn run<W: Work>(self, work: W) -> W::Output {
        match self {
            #[cfg(target_arch = "x86_64")]
            Self::Avx2(v3) => v3.run(work),
            Self::Scalar => Scalar.run(work),
        }
    }
}

/// Eight lanes one after the other.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scalar;

impl Lanes for Scalar {
    type Vector = [f32; WIDTH];

    #[inline(always)]
    fn load(self, values: &[f32; WIDTH]) -> Self::Vector {
        *values
    }

    #[inline(always)]
    fn splat(self, value: f32) -> Self::Vector {
        [value; WIDTH]
    }

    #[inline(always)]
    fn store(self, values: Self::Vector) -> [f32; WIDTH] {
        values
    }

    #[inline(always)]
    fn sub(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
        std::array::from_fn(|k| a[k] - b[k])
    }

    #[inline(always)]
    fn mul(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
        std::array::from_fn(|k| a[k] * b[k])
    }

    #[inline(always)]
    fn mul_sub(self, a: Self::Vector, b: Self::Vector, c: Self::Vector) -> Self::Vector {
        std::array::from_fn(|k| a[k] * b[k] - c[k])
    }

    #[inline(always)]
    fn min(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
        std::array::from_fn(|k| if a[k] < b[k] { a[k] } else { b[k] })
    }

    #[inline(always)]
    fn max(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
        std::array::from_fn(|k| if a[k] > b[k] { a[k] } else { b[k] })
    }

    #[inline(always)]
    fn less_or_equal(self, a: Self::Vector, b: Self::Vector) -> u32 {
        (0..WIDTH).fold(0, |mask, k| mask | u32::from(a[k] <= b[k]) << k)
    }

    #[inline(always)]
    fn less(self, a: Self::Vector, b: Self::Vector) -> u32 {
        (0..WIDTH).fold(0, |mask, k| mask | u32::from(a[k] < b[k]) << k)
    }

    #[inline(always)]
    fn run<W: Work>(self, work: W) -> W::Output {
        work.work(self)
    }
}

#[cfg(target_arch = "x86_64")]
mod avx2 {
    use std::arch::x86_64::{__m256, _CMP_LE_OQ, _CMP_LT_OQ};

    use pulp::x86::V3;

    use super::{Lanes, WIDTH, Work};

    impl Lanes for V3 {
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
            self.avx._mm256_movemask_ps(self.avx._mm256_cmp_ps::<_CMP_LE_OQ>(a, b)).cast_unsigned()
        }

        #[inline(always)]
        fn less(self, a: Self::Vector, b: Self::Vector) -> u32 {
            self.avx._mm256_movemask_ps(self.avx._mm256_cmp_ps::<_CMP_LT_OQ>(a, b)).cast_unsigned()
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
}
