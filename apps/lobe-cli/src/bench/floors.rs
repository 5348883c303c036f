//! The limits of the machine: arithmetic, and bytes at each level of its memory. Measured on one thread, with the
//! instructions that the kernels use.

use std::hint::black_box;
use std::time::Duration;

use lobe::sh::simd::{Kernel, Machine, copy_past_caches};
use pulp::Simd;
use serde::Serialize;

use crate::bench::clock::nanoseconds;

/// Sums that do not wait for each other: two units of four cycles each need eight, and as many registers as the narrowest
/// machine has leave room for no more than fourteen.
const CHAINS: usize = 12;

/// Steps of each chain in a run.
const STEPS: usize = 1 << 12;

/// Numbers that fit the first-level cache with room to spare, and the second-level cache. The least that machines of today have is
/// 32 KiB and 256 KiB.
const FIRST_LEVEL: usize = 16 * 1024 / size_of::<f32>();
const SECOND_LEVEL: usize = 128 * 1024 / size_of::<f32>();

/// Numbers that fit no cache: 144 MiB.
const MEMORY: usize = 144 * 1024 * 1024 / size_of::<f32>();

/// The rates of one thread.
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct Floors {
    /// The instructions of the kernels, as in `LOBE_SIMD`.
    pub(crate) instructions: &'static str,
    /// Operations in a nanosecond; a fused multiply-add counts two.
    pub(crate) gflops: f64,
    /// Bytes written in a nanosecond, in the first-level cache.
    pub(crate) store_first_level: f64,
    /// Bytes read and written in a nanosecond, in the second-level cache.
    pub(crate) copy_second_level: f64,
    /// Bytes written in a nanosecond, in memory, by ordinary stores.
    pub(crate) store: f64,
    /// The same past the caches, from the second-level cache.
    pub(crate) store_past_caches: f64,
    /// Bytes read in a nanosecond, in memory.
    pub(crate) read: f64,
}

impl Floors {
    /// Measures each rate for as long as `time`.
    pub(crate) fn measure(time: Duration) -> Self {
        let machine = Machine::detect();
        let mut lanes = 0;
        let of_sums = nanoseconds(time, || {
            let (sum, width) = machine.run(MultiplyAdds { factor: black_box(0.5), term: black_box(1.0) });
            black_box(sum);
            lanes = width;
        });
        let bytes = |count: usize| (count * size_of::<f32>()) as f64;
        let mut numbers = vec![0.0; FIRST_LEVEL];
        let first = nanoseconds(time, || machine.run(Store { to: black_box(&mut numbers), value: black_box(1.0) }));
        let (mut to, from) = (vec![0.0; SECOND_LEVEL / 2], vec![1.0; SECOND_LEVEL / 2]);
        let second = nanoseconds(time, || machine.run(Copy { to: black_box(&mut to), from: black_box(&from) }));
        let mut numbers = vec![0.0; MEMORY];
        let store = nanoseconds(time, || machine.run(Store { to: black_box(&mut numbers), value: black_box(1.0) }));
        let from = vec![1.0; SECOND_LEVEL];
        let past_caches = nanoseconds(time, || {
            black_box(&mut numbers).chunks_exact_mut(SECOND_LEVEL).for_each(|to| copy_past_caches(&from, to));
        });
        let read = nanoseconds(time, || {
            black_box(machine.run(Sum(black_box(&numbers))));
        });
        Self {
            instructions: machine.name(),
            gflops: (2 * lanes * CHAINS * STEPS) as f64 / of_sums,
            store_first_level: bytes(FIRST_LEVEL) / first,
            copy_second_level: bytes(SECOND_LEVEL) / second,
            store: bytes(MEMORY) / store,
            store_past_caches: bytes(MEMORY) / past_caches,
            read: bytes(MEMORY) / read,
        }
    }
}

/// Chains of `x ← x · factor + term`; what comes out and the numbers of a register.
struct MultiplyAdds {
    factor: f32,
    term: f32,
}

impl Kernel for MultiplyAdds {
    type Output = (f32, usize);

    #[inline(always)]
    fn wide<S: Simd>(self, simd: S) -> (f32, usize) {
        let (factor, term) = (simd.splat_f32s(self.factor), simd.splat_f32s(self.term));
        let mut chains = [simd.splat_f32s(0.0); CHAINS];
        for _ in 0..STEPS {
            for k in 0..CHAINS {
                chains[k] = simd.mul_add_e_f32s(chains[k], factor, term);
            }
        }
        let mut sum = 0.0;
        for k in 0..CHAINS {
            sum += simd.reduce_sum_f32s(chains[k]);
        }
        (sum, S::F32_LANES)
    }

    fn plain(self) -> (f32, usize) {
        /// Numbers of the registers that every machine has for which this is compiled.
        const LANES: usize = 4;
        let mut chains = [[0.0_f32; LANES]; CHAINS];
        for _ in 0..STEPS {
            for chain in &mut chains {
                for x in chain {
                    *x = *x * self.factor + self.term;
                }
            }
        }
        (chains.as_flattened().iter().sum(), LANES)
    }
}

/// Writes one number everywhere.
struct Store<'a> {
    to: &'a mut [f32],
    value: f32,
}

impl Kernel for Store<'_> {
    type Output = ();

    #[inline(always)]
    fn wide<S: Simd>(self, simd: S) {
        let value = simd.splat_f32s(self.value);
        for to in S::as_mut_simd_f32s(self.to).0 {
            *to = value;
        }
    }

    fn plain(self) {
        self.to.fill(self.value);
    }
}

struct Copy<'a> {
    to: &'a mut [f32],
    from: &'a [f32],
}

impl Kernel for Copy<'_> {
    type Output = ();

    #[inline(always)]
    fn wide<S: Simd>(self, _: S) {
        for (to, from) in S::as_mut_simd_f32s(self.to).0.iter_mut().zip(S::as_simd_f32s(self.from).0) {
            *to = *from;
        }
    }

    fn plain(self) {
        self.to.copy_from_slice(self.from);
    }
}

/// Reads all numbers.
struct Sum<'a>(&'a [f32]);

impl Kernel for Sum<'_> {
    type Output = f32;

    #[inline(always)]
    fn wide<S: Simd>(self, simd: S) -> f32 {
        let mut sums = [simd.splat_f32s(0.0); CHAINS];
        for numbers in S::as_simd_f32s(self.0).0.as_chunks::<CHAINS>().0 {
            for k in 0..CHAINS {
                sums[k] = simd.add_f32s(sums[k], numbers[k]);
            }
        }
        let mut sum = 0.0;
        for k in 0..CHAINS {
            sum += simd.reduce_sum_f32s(sums[k]);
        }
        sum
    }

    fn plain(self) -> f32 {
        let mut sums = [0.0; 4 * CHAINS];
        for numbers in self.0.as_chunks::<{ 4 * CHAINS }>().0 {
            for k in 0..4 * CHAINS {
                sums[k] += numbers[k];
            }
        }
        sums.iter().sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kernels_do_on_every_machine_what_is_counted() {
        for machine in Machine::available() {
            let name = machine.name();
            // x ← x/2 + 1 rises to 2 in every chain and lane.
            let (sum, lanes) = machine.run(MultiplyAdds { factor: 0.5, term: 1.0 });
            assert!((sum - (2 * CHAINS * lanes) as f32).abs() < 1e-3, "{name}: {sum} of {lanes} lanes");
            let mut numbers = vec![0.0; 16 * 4 * CHAINS];
            machine.run(Store { to: &mut numbers, value: 3.0 });
            assert!(numbers.iter().all(|x| *x == 3.0), "{name}: all is written");
            let mut copy = vec![0.0; numbers.len()];
            machine.run(Copy { to: &mut copy, from: &numbers });
            assert!(copy == numbers, "{name}: all is copied");
            assert_eq!(machine.run(Sum(&numbers)), 3.0 * numbers.len() as f32, "{name}: all is read");
        }
    }

    #[test]
    fn rates_are_finite_and_above_zero() {
        let floors = Floors::measure(Duration::from_millis(1));
        let Floors { gflops, store_first_level, copy_second_level, store, store_past_caches, read, .. } = floors;
        let all = [gflops, store_first_level, copy_second_level, store, store_past_caches, read];
        assert!(all.iter().all(|rate| rate.is_finite() && *rate > 0.0), "{floors:?}");
    }
}
