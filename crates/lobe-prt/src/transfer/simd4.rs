//! Four-lane SIMD arithmetic, with AVX2's instructions where the machine has them.
//!
//! Left to itself the compiler turns rows into columns by way of the stack, at three times the cost. Every operation
//! rounds by itself and alike in both implementations, so the bytes are the same.

#[cfg(target_arch = "x86_64")]
use pulp::NullaryFnOnce;

/// The number of lanes.
pub(crate) const FOUR: usize = 4;

/// Arithmetic on four lanes of `f32`.
pub(crate) trait Lanes: Copy {
    /// Four lanes.
    type Vector: Copy;

    fn load(self, values: [f32; FOUR]) -> Self::Vector;
    fn splat(self, value: f32) -> Self::Vector;
    fn store(self, values: Self::Vector) -> [f32; FOUR];
    /// `sum + a b`, rounded twice.
    fn add_product(self, sum: Self::Vector, a: Self::Vector, b: Self::Vector) -> Self::Vector;
}

/// Work to be done with four lanes.
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

/// Four lanes as the compiler likes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plain;

impl Lanes for Plain {
    type Vector = [f32; FOUR];

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
}

#[cfg(target_arch = "x86_64")]
mod avx2 {
    use std::arch::x86_64::__m128;

    use pulp::x86::V3;

    use super::{FOUR, Lanes};

    impl Lanes for V3 {
        type Vector = __m128;

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
    }
}
