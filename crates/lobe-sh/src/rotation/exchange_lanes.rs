//! The sums of the exchange of y and z in a high band, several `m'` side by side.

use alloc::vec::Vec;

#[cfg(feature = "simd")]
use pulp::Simd;

use crate::simd::Kernel;

/// Lists of `m'` are padded to a multiple of this: one AVX-512 register, two of AVX2.
pub(crate) const PADDED: usize = 8;

/// `Σ_m D_{m,m'} x_m` for all `m'`, apart for those `m` that differ from `l` by even and by odd numbers; `D` as in
/// `high_bands`.
///
/// The first become cosines and the second sines. What is summed are the cosines for the `m'` of the parity of `l` and the
/// sines for the others: `J_l` has entries between functions of the same parity in x whose parities in y and z are exchanged.
pub(crate) struct Exchange<'a, const CHANNELS: usize> {
    pub(crate) l: usize,
    /// `c_m` from `m = l` downwards.
    pub(crate) steps: &'a [f64],
    /// `D_{l,m'}` of even and of odd `m'`, as long as a multiple of [`PADDED`].
    pub(crate) starts: [&'a [f64]; 2],
    /// Cosines and sines from `m = l` downwards, all channels of each.
    pub(crate) staged: [&'a [f64]; 2],
    /// For even and odd `m'` cosines and sines, a channel after the other.
    pub(crate) sums: &'a mut [[Vec<f64>; 2]; 2],
}

/// Two steps of the recurrence, and the numbers before the first and the second.
type Pairs<'a, const CHANNELS: usize> = (&'a [[f64; 2]], &'a [[[f64; CHANNELS]; 2]]);

impl<'a, const CHANNELS: usize> Exchange<'a, CHANNELS> {
    /// The band from `m = l` downwards, for even (0) or odd (1) `m'`.
    #[inline(always)]
    fn pairs(&self, parity: usize) -> Pairs<'a, CHANNELS> {
        let staged = self.staged[(self.l + parity) % 2];
        (self.steps.as_chunks().0, staged.as_chunks::<CHANNELS>().0.as_chunks().0)
    }
}

impl<const CHANNELS: usize> Kernel for Exchange<'_, CHANNELS> {
    type Output = ();

    #[cfg(feature = "simd")]
    #[inline(always)]
    fn wide<S: Simd>(self, simd: S) {
        for parity in 0..2 {
            let (pairs, starts) = (self.pairs(parity), self.starts[parity]);
            let registers = starts.len() / S::F64_LANES;
            let sums = &mut self.sums[parity];
            let mut k = 0;
            // As many registers as hide the latency of a step and keep all sums in registers.
            if CHANNELS == 1 {
                while k + 4 <= registers {
                    wide_sums::<S, 4, CHANNELS>(simd, [parity, k], starts, pairs, sums);
                    k += 4;
                }
            }
            while k + 2 <= registers && (CHANNELS == 1 || S::F64_LANES > 4) {
                wide_sums::<S, 2, CHANNELS>(simd, [parity, k], starts, pairs, sums);
                k += 2;
            }
            while k < registers {
                wide_sums::<S, 1, CHANNELS>(simd, [parity, k], starts, pairs, sums);
                k += 1;
            }
        }
    }

    fn plain(self) {
        for parity in 0..2 {
            let (pairs, starts) = (self.pairs(parity), self.starts[parity]);
            for k in 0..starts.len() / PADDED {
                plain_sums(parity, k, starts, pairs, &mut self.sums[parity]);
            }
        }
    }
}

/// The sums of `REGISTERS` registers of `m'` from the `k`-th on.
#[cfg(feature = "simd")]
#[inline(always)]
fn wide_sums<S: Simd, const REGISTERS: usize, const CHANNELS: usize>(
    simd: S,
    [parity, k]: [usize; 2],
    starts: &[f64],
    (steps, staged): Pairs<'_, CHANNELS>,
    out: &mut [Vec<f64>; 2],
) {
    let mut numbers = [simd.splat_f64s(0.0); REGISTERS];
    let mut ramp = [0.0; PADDED];
    for i in 0..PADDED {
        ramp[i] = (2 * i + parity) as f64;
    }
    let (mut d, mut before) = (numbers, numbers);
    let mut sums = [[[simd.splat_f64s(0.0); REGISTERS]; CHANNELS]; 2];
    for r in 0..REGISTERS {
        let first = simd.splat_f64s((2 * S::F64_LANES * (k + r)) as f64);
        numbers[r] = simd.add_f64s(first, S::as_simd_f64s(&ramp).0[0]);
        d[r] = S::as_simd_f64s(starts).0[k + r];
    }
    for (steps, x) in steps.iter().zip(staged) {
        for half in 0..2 {
            let step = simd.splat_f64s(steps[half]);
            for c in 0..CHANNELS {
                let x = simd.splat_f64s(x[half][c]);
                for r in 0..REGISTERS {
                    sums[half][c][r] = simd.mul_add_e_f64s(d[r], x, sums[half][c][r]);
                }
            }
            for r in 0..REGISTERS {
                let next = simd.mul_add_e_f64s(simd.mul_f64s(step, numbers[r]), d[r], before[r]);
                (before[r], d[r]) = (d[r], next);
            }
        }
    }
    for half in 0..2 {
        for c in 0..CHANNELS {
            let channel = &mut out[half][c * starts.len()..][..starts.len()];
            for r in 0..REGISTERS {
                S::as_mut_simd_f64s(channel).0[k + r] = sums[half][c][r];
            }
        }
    }
}

/// The same for [`PADDED`] of `m'` in plain code.
fn plain_sums<const CHANNELS: usize>(
    parity: usize,
    k: usize,
    starts: &[f64],
    (steps, staged): Pairs<'_, CHANNELS>,
    out: &mut [Vec<f64>; 2],
) {
    let mut numbers = [0.0; PADDED];
    for (i, number) in numbers.iter_mut().enumerate() {
        *number = (2 * (k * PADDED + i) + parity) as f64;
    }
    let (mut d, mut before) = ([0.0; PADDED], [0.0; PADDED]);
    d.copy_from_slice(&starts[k * PADDED..][..PADDED]);
    let mut sums = [[[0.0; PADDED]; CHANNELS]; 2];
    for (steps, x) in steps.iter().zip(staged) {
        for half in 0..2 {
            for c in 0..CHANNELS {
                for i in 0..PADDED {
                    sums[half][c][i] += d[i] * x[half][c];
                }
            }
            for i in 0..PADDED {
                let next = steps[half] * numbers[i] * d[i] + before[i];
                (before[i], d[i]) = (d[i], next);
            }
        }
    }
    for half in 0..2 {
        for c in 0..CHANNELS {
            out[half][c * starts.len()..][k * PADDED..][..PADDED].copy_from_slice(&sums[half][c]);
        }
    }
}
