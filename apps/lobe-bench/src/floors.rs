//! The limits of the machine: arithmetic, and bytes at each level of its memory. Measured on one thread, with the
//! instructions that the kernels use, by probes that are compiled where the kernels are.

use std::hint::black_box;
use std::time::Duration;

use lobe::sh::probes;
use lobe::sh::simd::{Lanes, Machine, copy_past_caches};
use serde::Serialize;

use crate::clock::nanoseconds;

/// Blocks that fit the first-level cache with room to spare, and the second-level cache but not the first. The least
/// that machines of today have is 32 KiB and 256 KiB, the most that a first level has 64 KiB but for a few.
const FIRST_LEVEL: usize = 16 * 1024 / size_of::<Lanes>();
const SECOND_LEVEL: usize = 160 * 1024 / size_of::<Lanes>();

/// Blocks that fit no cache: 144 MiB.
const MEMORY: usize = 144 * 1024 * 1024 / size_of::<Lanes>();

/// Bytes of the first-level cache where the processor does not tell.
const LEAST_FIRST_LEVEL: usize = 32 * 1024;

/// Operations of the chain that measures the clock.
const CHAIN: usize = 20_000;

/// Multiply-adds of a whole register that a machine does in a cycle at least. Most do one or two; wide ones lower
/// their clock for it by up to a third, and small cores need two cycles.
const LEAST_EACH_CYCLE: f64 = 0.45;

/// The rates of one thread.
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct Floors {
    /// The instructions of the kernels, as in `LOBE_SIMD`.
    pub(crate) instructions: &'static str,
    /// Cycles in a nanosecond, by a chain of integer operations.
    pub(crate) gigahertz: f64,
    /// Operations in a nanosecond; a fused multiply-add counts two.
    pub(crate) gflops: f64,
    /// Multiply-adds of whole registers in a cycle.
    pub(crate) each_cycle: f64,
    /// Bytes of the first-level cache.
    pub(crate) first_level: usize,
    /// Bytes written in a nanosecond, in the first-level cache.
    pub(crate) store_first_level: f64,
    /// Bytes read and written in a nanosecond, in the first-level cache.
    pub(crate) copy_first_level: f64,
    /// Bytes written in a nanosecond, in the second-level cache.
    pub(crate) store_second_level: f64,
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
        let gigahertz = (CHAIN * probes::CHAIN_CYCLES) as f64
            / nanoseconds(time, || {
                black_box(probes::integer_chain(CHAIN));
            });
        let (registers, lanes) = probes::multiply_adds_in(machine);
        let multiply_adds = registers as f64
            / nanoseconds(time, || {
                black_box(probes::multiply_adds(machine, black_box(0.5), black_box(1.0)));
            });
        let in_cache = |blocks: usize| {
            let (mut to, from) = (vec![Lanes::ZERO; blocks], vec![Lanes::splat(1.0); blocks / 2]);
            let copied =
                nanoseconds(time, || probes::copy(machine, black_box(&from), black_box(&mut to[..from.len()])));
            let stored = nanoseconds(time, || probes::store(machine, black_box(1.0), black_box(&mut to)));
            [stored, copied].map(|time| size_of_val(&*to) as f64 / time)
        };
        let [store_first_level, copy_first_level] = in_cache(FIRST_LEVEL);
        let [store_second_level, copy_second_level] = in_cache(SECOND_LEVEL);
        let mut blocks = vec![Lanes::ZERO; MEMORY];
        let bytes = size_of_val(&*blocks) as f64;
        let store = nanoseconds(time, || probes::store(machine, black_box(1.0), black_box(&mut blocks)));
        let read = nanoseconds(time, || {
            black_box(probes::sum(machine, black_box(&blocks)));
        });
        drop(blocks);
        let (mut numbers, from) = (vec![0.0; bytes as usize / size_of::<f32>()], vec![1.0; SECOND_LEVEL]);
        let past_caches = nanoseconds(time, || {
            black_box(&mut numbers).chunks_exact_mut(from.len()).for_each(|to| copy_past_caches(&from, to));
        });
        Self {
            instructions: machine.name(),
            gigahertz,
            gflops: 2.0 * lanes as f64 * multiply_adds,
            each_cycle: multiply_adds / gigahertz,
            first_level: probes::cache_bytes(1).unwrap_or(LEAST_FIRST_LEVEL),
            store_first_level,
            copy_first_level,
            store_second_level,
            copy_second_level,
            store: bytes / store,
            store_past_caches: bytes / past_caches,
            read: bytes / read,
        }
    }

    /// Why the floors say nothing, if they do: a probe of arithmetic far below what its instructions allow.
    pub(crate) fn doubt(&self) -> Option<String> {
        let Self { each_cycle, instructions, .. } = self;
        (*each_cycle < LEAST_EACH_CYCLE).then(|| {
            format!(
                "expected {LEAST_EACH_CYCLE} multiply-adds of a register or more in a cycle by {instructions}, found \
                 {each_cycle:.2}: floors are too high and ratios too low; the processor is emulated, or lobe-sh is \
                 built without optimization"
            )
        })
    }
}

#[cfg(test)]
impl Floors {
    /// A machine of round numbers.
    pub(crate) const EXAMPLE: Self = Self {
        instructions: "plain",
        gigahertz: 1.0,
        gflops: 10.0,
        each_cycle: 1.0,
        first_level: 1000,
        store_first_level: 100.0,
        copy_first_level: 80.0,
        store_second_level: 25.0,
        copy_second_level: 50.0,
        store: 3.0,
        store_past_caches: 5.0,
        read: 8.0,
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_probe_that_spills_its_sums_is_doubted() {
        let mut floors = Floors { each_cycle: 1.0, ..Floors::EXAMPLE };
        assert_eq!(floors.doubt(), None, "one register a cycle");
        // As a command that was optimized little had it.
        floors.each_cycle = 0.06;
        let line = floors.doubt().unwrap();
        assert!(line.contains("found 0.06: floors are too high"), "{line}");
    }
}
