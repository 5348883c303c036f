//! Eight-wide SIMD arithmetic, with AVX-512 or AVX2 where the machine has it.
//!
//! All implementations round every operation alike except [`Lanes::mul_sub`] and [`Lanes::mul_add`]. These are used
//! only where tolerances cover their error, for boxes and edge planes, never for decisions. So hits are the same bit by
//! bit.

/// The number of boxes or triangles tested at once.
pub(crate) const WIDTH: usize = 8;

/// The singleton set of each number, in memory, so that one load broadcasts it to all lanes.
pub(crate) static ALONE: [u64; 64] = {
    let mut sets = [0; 64];
    let mut number = 0;
    while number < 64 {
        sets[number] = 1 << number;
        number += 1;
    }
    sets
};

/// Arithmetic on eight lanes of `f32`. Comparisons give a mask with a bit for each lane.
pub(crate) trait Lanes: Copy {
    /// Eight lanes.
    type Vector: Copy;
    /// For each lane a set of numbers below 64.
    type Sets: Copy;

    fn load(self, values: &[f32; WIDTH]) -> Self::Vector;
    fn splat(self, value: f32) -> Self::Vector;
    fn store(self, values: Self::Vector) -> [f32; WIDTH];
    fn sub(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    fn mul(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// `a b - c`, rounded once or twice.
    fn mul_sub(self, a: Self::Vector, b: Self::Vector, c: Self::Vector) -> Self::Vector;
    /// `a b + c`, rounded once or twice.
    fn mul_add(self, a: Self::Vector, b: Self::Vector, c: Self::Vector) -> Self::Vector;
    fn sqrt(self, a: Self::Vector) -> Self::Vector;
    /// The size of `a` with the sign of `b`.
    fn copy_sign(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    fn min(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    fn max(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// Lanes where `a ≤ b`; none where either is NaN.
    fn less_or_equal(self, a: Self::Vector, b: Self::Vector) -> u32;
    /// Lanes where `a < b`; none where either is NaN.
    fn less(self, a: Self::Vector, b: Self::Vector) -> u32;
    /// The values of the lanes in a mask, compacted to the front in their order; the rest is unspecified.
    fn compress(self, values: &[u32; WIDTH], mask: u32) -> [u32; WIDTH];
    /// Empty sets.
    fn empty_sets(self) -> Self::Sets;
    /// Puts a number into the sets of the lanes where `a ≤ b`.
    fn insert_where(self, sets: Self::Sets, a: Self::Vector, b: Self::Vector, number: usize) -> Self::Sets;
    fn store_sets(self, sets: Self::Sets) -> [u64; WIDTH];
    /// Prefetches a value.
    fn prefetch<T>(self, value: &T);
    /// Calls `work` compiled for the instructions of these lanes.
    fn run<W: Work>(self, work: W) -> W::Output;
}

/// A computation with eight lanes.
pub(crate) trait Work {
    /// The result.
    type Output;

    /// Runs the computation. Mark it `#[inline(always)]`, or it is compiled without the instructions.
    fn work<L: Lanes>(self, lanes: L) -> Self::Output;
}

/// The vector instructions with which rays are traced. All find the same hits, bit by bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum Simd {
    /// None: any machine.
    Scalar,
    /// AVX2 and FMA of x86-64.
    Avx2,
    /// AVX-512 of x86-64: F, VL and what comes with them.
    Avx512,
}

impl Simd {
    /// From narrow to wide.
    pub const ALL: [Self; 3] = [Self::Scalar, Self::Avx2, Self::Avx512];

    /// The widest of this machine.
    #[must_use]
    pub fn widest() -> Self {
        Self::ALL.into_iter().rev().find(|simd| simd.is_available()).unwrap_or(Self::Scalar)
    }

    /// Whether this machine has them.
    #[must_use]
    pub fn is_available(self) -> bool {
        Machine::new(self).is_some()
    }
}

/// Lanes available on this machine.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Machine {
    #[cfg(target_arch = "x86_64")]
    Avx512(pulp::x86::V4),
    #[cfg(target_arch = "x86_64")]
    Avx2(pulp::x86::V3),
    Scalar,
}

impl Machine {
    /// The lanes of an instruction set, if the processor has it.
    pub(crate) fn new(simd: Simd) -> Option<Self> {
        match simd {
            #[cfg(target_arch = "x86_64")]
            Simd::Avx512 => pulp::x86::V4::try_new().map(Self::Avx512),
            #[cfg(target_arch = "x86_64")]
            Simd::Avx2 => pulp::x86::V3::try_new().map(Self::Avx2),
            Simd::Scalar => Some(Self::Scalar),
            #[cfg(not(target_arch = "x86_64"))]
            Simd::Avx2 | Simd::Avx512 => None,
        }
    }

    /// The widest lanes.
    pub(crate) fn detect() -> Self {
        Self::new(Simd::widest()).unwrap_or(Self::Scalar)
    }

    #[inline]
    pub(crate) fn run<W: Work>(self, work: W) -> W::Output {
        match self {
            #[cfg(target_arch = "x86_64")]
            Self::Avx512(v4) => v4.run(work),
            #[cfg(target_arch = "x86_64")]
            Self::Avx2(v3) => v3.run(work),
            Self::Scalar => Scalar.run(work),
        }
    }
}

/// Eight lanes in scalar code.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scalar;

impl Lanes for Scalar {
    type Vector = [f32; WIDTH];
    type Sets = [u64; WIDTH];

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
    fn mul_add(self, a: Self::Vector, b: Self::Vector, c: Self::Vector) -> Self::Vector {
        std::array::from_fn(|k| a[k] * b[k] + c[k])
    }

    #[inline(always)]
    fn sqrt(self, a: Self::Vector) -> Self::Vector {
        a.map(f32::sqrt)
    }

    #[inline(always)]
    fn copy_sign(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
        std::array::from_fn(|k| a[k].copysign(b[k]))
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
    fn compress(self, values: &[u32; WIDTH], mask: u32) -> [u32; WIDTH] {
        let mut front = [0; WIDTH];
        let mut count = 0;
        for (k, &value) in values.iter().enumerate() {
            front[count % WIDTH] = value;
            count += (mask >> k & 1) as usize;
        }
        front
    }

    #[inline(always)]
    fn empty_sets(self) -> Self::Sets {
        [0; WIDTH]
    }

    #[inline(always)]
    fn insert_where(self, sets: Self::Sets, a: Self::Vector, b: Self::Vector, number: usize) -> Self::Sets {
        std::array::from_fn(|k| sets[k] | if a[k] <= b[k] { ALONE[number % 64] } else { 0 })
    }

    #[inline(always)]
    fn store_sets(self, sets: Self::Sets) -> [u64; WIDTH] {
        sets
    }

    #[inline(always)]
    fn prefetch<T>(self, _: &T) {}

    #[inline(always)]
    fn run<W: Work>(self, work: W) -> W::Output {
        work.work(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every operation on some numbers, as bits.
    struct AllOperations([[f32; WIDTH]; 2]);

    impl Work for AllOperations {
        type Output = Vec<u32>;

        #[inline(always)]
        fn work<L: Lanes>(self, lanes: L) -> Vec<u32> {
            let [a, b] = self.0.map(|values| lanes.load(&values));
            let mut bits = vec![lanes.less_or_equal(a, b), lanes.less(a, b)];
            let vectors = [lanes.splat(1.5), lanes.sub(a, b), lanes.mul(a, b), lanes.min(a, b), lanes.max(a, b)];
            bits.extend(vectors.into_iter().flat_map(|v| lanes.store(v)).map(f32::to_bits));
            bits.extend(lanes.store(lanes.copy_sign(a, b)).map(f32::to_bits));
            bits.extend(lanes.store(lanes.sqrt(lanes.copy_sign(a, lanes.splat(1.0)))).map(f32::to_bits));
            let mut sets = lanes.empty_sets();
            for (number, (a, b)) in [(0, (a, b)), (31, (b, a)), (32, (a, b)), (63, (b, a))] {
                sets = lanes.insert_where(sets, a, b, number);
            }
            bits.extend(lanes.store_sets(sets).into_iter().flat_map(|set| [set as u32, (set >> 32) as u32]));
            for mask in 0..1 << WIDTH {
                let front = lanes.compress(&self.0[0].map(f32::to_bits), mask);
                bits.extend(&front[..mask.count_ones() as usize]);
            }
            bits
        }
    }

    #[test]
    fn all_lanes_compute_the_same_bits() {
        let numbers = [1.0, -2.5, 0.0, f32::INFINITY, 1e-38, f32::MAX, 3.0, -0.1];
        let others = [1.0, 2.5, -1.0, 1.0, 1e30, 2.0, f32::NAN, f32::NEG_INFINITY];
        for (a, b) in [(numbers, others), (others, numbers)] {
            let expected = Machine::Scalar.run(AllOperations([a, b]));
            for simd in Simd::ALL {
                match Machine::new(simd) {
                    Some(machine) => assert_eq!(machine.run(AllOperations([a, b])), expected, "{simd:?}"),
                    None => lobe_testkit::skipped(&format!("this machine has no {simd:?}")),
                }
            }
        }
    }
}
