//! The limits of a machine: multiply-adds, bytes written, copied and read, and the cycles of its clock.

use core::hint::black_box;

use pulp::Simd;

use crate::simd::{Kernel, Lanes, Machine};

/// Sums that do not wait for each other. Two units of four or five cycles each need ten; the sixteen registers of
/// AVX2 have room for fourteen beside the factor and the term.
const CHAINS: usize = 12;

/// Steps of each chain in a run.
const STEPS: usize = 1 << 12;

/// Cycles of a step of [`integer_chain`]: an addition and a rotation of a register, each of which takes one on every
/// processor of the kinds for which there are wide kernels.
pub const CHAIN_CYCLES: usize = 2;

/// A chain of `steps` integer operations, each of which waits for the one before: its time is `steps` times
/// [`CHAIN_CYCLES`] cycles.
#[inline(never)]
#[must_use]
pub fn integer_chain(steps: usize) -> u64 {
    /// Any odd number: a constant that is no immediate operand, which some processors add while they rename registers.
    const ADDED: u64 = 0x9e37_79b9_7f4a_7c15;
    const TURN: u32 = 7;
    let added = black_box(ADDED);
    let mut x = added;
    for _ in 0..steps {
        x = x.wrapping_add(added).rotate_left(TURN);
    }
    x
}

/// The multiply-adds of registers in a run of [`multiply_adds`], and the numbers of a register.
#[inline(never)]
#[must_use]
pub fn multiply_adds_in(machine: Machine) -> (usize, usize) {
    (CHAINS * STEPS, machine.run(Width))
}

/// A run of multiply-adds `x ← x · factor + term` in chains that do not wait for each other; the sum of what comes out.
#[inline(never)]
#[must_use]
pub fn multiply_adds(machine: Machine, factor: f32, term: f32) -> f32 {
    machine.run(MultiplyAdds { factor, term })
}

/// Writes one number everywhere.
#[inline(never)]
pub fn store(machine: Machine, value: f32, to: &mut [Lanes]) {
    machine.run(Store { to, value });
}

/// Copies as many blocks as the shorter has.
#[inline(never)]
pub fn copy(machine: Machine, from: &[Lanes], to: &mut [Lanes]) {
    machine.run(Copy { to, from });
}

/// Reads all numbers; their sum, without those past the last whole group of eight blocks.
#[inline(never)]
#[must_use]
pub fn sum(machine: Machine, blocks: &[Lanes]) -> f32 {
    machine.run(Sum(blocks))
}

/// Sums of blocks that do not wait for each other: two units of four cycles each need eight registers, which by AVX2
/// are four blocks, by AVX-512 eight.
const SUMS: usize = 8;

/// Numbers of the registers that every machine has for which plain code is compiled.
const PLAIN_LANES: usize = 4;

/// The numbers of a register.
struct Width;

impl Kernel for Width {
    type Output = usize;

    #[inline(always)]
    fn wide<S: Simd>(self, _: S) -> usize {
        S::F32_LANES
    }

    fn plain(self) -> usize {
        PLAIN_LANES
    }
}

struct MultiplyAdds {
    factor: f32,
    term: f32,
}

impl Kernel for MultiplyAdds {
    type Output = f32;

    #[inline(always)]
    fn wide<S: Simd>(self, simd: S) -> f32 {
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
        sum
    }

    fn plain(self) -> f32 {
        let mut chains = [[0.0_f32; PLAIN_LANES]; CHAINS];
        for _ in 0..STEPS {
            for k in 0..CHAINS {
                chains[k] = chains[k].map(|x| x * self.factor + self.term);
            }
        }
        // Stored side by side, so that the compiler keeps them in registers side by side.
        black_box(chains).as_flattened().iter().sum()
    }
}

struct Store<'a> {
    to: &'a mut [Lanes],
    value: f32,
}

impl Kernel for Store<'_> {
    type Output = ();

    #[inline(always)]
    fn wide<S: Simd>(self, simd: S) {
        let value = simd.splat_f32s(self.value);
        for block in self.to {
            for to in S::as_mut_simd_f32s(&mut block.0).0 {
                *to = value;
            }
        }
    }

    fn plain(self) {
        self.to.fill(Lanes::splat(self.value));
    }
}

struct Copy<'a> {
    to: &'a mut [Lanes],
    from: &'a [Lanes],
}

impl Kernel for Copy<'_> {
    type Output = ();

    #[inline(always)]
    fn wide<S: Simd>(self, _: S) {
        for (to, from) in self.to.iter_mut().zip(self.from) {
            for (to, from) in S::as_mut_simd_f32s(&mut to.0).0.iter_mut().zip(S::as_simd_f32s(&from.0).0) {
                *to = *from;
            }
        }
    }

    fn plain(self) {
        for (to, from) in self.to.iter_mut().zip(self.from) {
            *to = *from;
        }
    }
}

struct Sum<'a>(&'a [Lanes]);

impl Kernel for Sum<'_> {
    type Output = f32;

    #[inline(always)]
    fn wide<S: Simd>(self, simd: S) -> f32 {
        let mut sums = [simd.splat_f32s(0.0); SUMS];
        for blocks in self.0.as_chunks::<SUMS>().0 {
            for (k, block) in blocks.iter().enumerate() {
                for (j, x) in S::as_simd_f32s(&block.0).0.iter().enumerate() {
                    // Of several registers of a block each has its own sum.
                    let at = (k + j * SUMS / 2) % SUMS;
                    sums[at] = simd.add_f32s(sums[at], *x);
                }
            }
        }
        let mut sum = 0.0;
        for k in 0..SUMS {
            sum += simd.reduce_sum_f32s(sums[k]);
        }
        sum
    }

    fn plain(self) -> f32 {
        let mut sums = [Lanes::ZERO; 2];
        for blocks in self.0.as_chunks::<SUMS>().0 {
            for (k, block) in blocks.iter().enumerate() {
                for (sum, x) in sums[k % 2].0.iter_mut().zip(&block.0) {
                    *sum += x;
                }
            }
        }
        sums.iter().flat_map(|sum| sum.0).sum()
    }
}

#[cfg(test)]
mod tests {
    use alloc::vec;

    use super::*;
    use crate::simd::LANES;

    #[test]
    fn kernels_do_on_every_machine_what_is_counted() {
        for machine in Machine::available() {
            let name = machine.name();
            let (count, width) = multiply_adds_in(machine);
            assert_eq!(count, CHAINS * STEPS, "{name}: registers");
            // x ← x/2 + 1 rises to 2 in every chain and lane.
            let sum_of_chains = multiply_adds(machine, 0.5, 1.0);
            assert!((sum_of_chains - (2 * CHAINS * width) as f32).abs() < 1e-3, "{name}: {sum_of_chains}");
            let mut numbers = vec![Lanes::ZERO; 4 * SUMS];
            store(machine, 3.0, &mut numbers);
            assert!(numbers.iter().all(|x| *x == Lanes::splat(3.0)), "{name}: all is written");
            let mut copied = vec![Lanes::ZERO; numbers.len()];
            copy(machine, &numbers, &mut copied);
            assert!(copied == numbers, "{name}: all is copied");
            assert_eq!(sum(machine, &numbers), (3 * LANES * numbers.len()) as f32, "{name}: all is read");
        }
    }

    #[test]
    fn each_operation_of_the_chain_needs_the_one_before() {
        // Undone backward, the chain leads to its start.
        let added = 0x9e37_79b9_7f4a_7c15_u64;
        let start = (0..1000).fold(integer_chain(1000), |x, _| x.rotate_right(7).wrapping_sub(added));
        assert_eq!(start, added, "the start");
    }
}
