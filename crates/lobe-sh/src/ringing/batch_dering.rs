//! Dering of many functions at once.

use alloc::vec::Vec;
use core::array;

use crate::basis::index::{band_range, coefficient_count};
use crate::batch::sh_batch::ShBatch;
use crate::ringing::DeringOutcome;
use crate::ringing::dering::{DeringOptions, DeringReport};
use crate::ringing::dering::{dering_in_place, report_of};
use crate::ringing::lane_dering::SixteenFunctions;
use crate::ringing::quadratic_dering::LeastFactors;
use crate::scalar::{Coefficient, Rgb};
use crate::simd::{LANES, Lanes, Machine};

impl ShBatch {
    /// Makes each function of a batch non-negative by the least change, as [`dering_in_place`](crate::ringing::dering_in_place) does one without evidence:
    /// a batch of numbers, or three of the channels of colors, which share their factors. What it says of each function comes back in their order.
    ///
    /// Up to three bands are computed side by side; more are taken one function after the other.
    ///
    /// A function has the result that it has alone, whatever lies beside it: to rounding that of the code for one, or to 1e-7 of it where one of the
    /// two searches takes a step more. Only where the minimum is within rounding of `-`[`DERING_ALLOWED`](crate::ringing::DERING_ALLOWED) times the mean may one
    /// of them change it and the other not. A band of nothing has any factor. What is not changed keeps every bit: what is non-negative, zero,
    /// not finite or without a positive mean.
    ///
    /// ```
    /// use lobe_sh::batch::ShBatch;
    /// use lobe_sh::{Dir, Expansion as _, ShL2};
    ///
    /// // The red, green and blue of a sun in a blue sky.
    /// let channels = [5.0, 4.0, 2.5].map(|sun| {
    ///     let mut f = ShL2::<f32>::impulse(Dir::Z, sun);
    ///     f[0] += sun.recip();
    ///     f
    /// });
    /// let mut batches = channels.map(|f| ShBatch::from_functions(&[f]));
    /// let reports = ShBatch::dering_in_place(&mut batches);
    /// assert!(reports[0].factors[2] < 0.8, "{reports:?}");
    /// let red: ShL2<f32> = batches[0].function(0);
    /// assert!(red.eval(Dir::from_angles(1.9, 0.0)) > -1e-6);
    /// ```
    ///
    /// # Panics
    /// If there are neither one nor three batches, or they differ in order or number.
    pub fn dering_in_place(channels: &mut [Self]) -> Vec<DeringReport> {
        assert!(matches!(channels.len(), 1 | 3), "a batch of numbers or three of colors, not {}", channels.len());
        let size = (channels[0].order(), channels[0].len());
        for channel in &channels[1..] {
            let found = (channel.order(), channel.len());
            assert_eq!(found, size, "orders and numbers of functions of the channels");
        }
        match (size.0, channels.len()) {
            (..=3, _) => side_by_side(channels),
            (_, 1) => one_by_one::<f32>(channels),
            _ => one_by_one::<Rgb<f32>>(channels),
        }
    }
}

/// The functions of a batch of up to three bands, side by side.
fn side_by_side(channels: &mut [ShBatch]) -> Vec<DeringReport> {
    let (order, functions) = (channels[0].order(), channels[0].len());
    let machine = Machine::detect();
    let mut found = Vec::with_capacity(functions);
    for first in (0..functions).step_by(LANES) {
        let of = |c: usize| sixteen(&channels[c.min(channels.len() - 1)], first / LANES);
        machine.run(SixteenFunctions {
            channels: &[of(0), of(1), of(2)][..channels.len()],
            count: LANES.min(functions - first),
            found: &mut found,
            left: &mut 0,
        });
    }
    let mut reports = Vec::with_capacity(functions);
    for (b, found) in found.chunks(LANES).enumerate() {
        let energies = band_energies(channels, order, b);
        let of = |k: usize| [0, 1, 2].map(|l| energies[l][k]);
        reports.extend(found.iter().enumerate().map(|(k, found)| report_of(found, order, || of(k))));
    }
    channels.iter_mut().for_each(|channel| scale(channel, &found));
    reports
}

/// The energies of up to three bands of block `b` of sixteen functions, summed over the channels.
fn band_energies(channels: &[ShBatch], order: usize, b: usize) -> [[f64; LANES]; 3] {
    let mut energies = [[0.0; LANES]; 3];
    for (l, energies) in energies.iter_mut().enumerate().take(order) {
        for coefficient in channels.iter().flat_map(|channel| &sixteen(channel, b)[band_range(l)]) {
            for (k, energy) in energies.iter_mut().enumerate() {
                *energy += f64::from(coefficient[k]) * f64::from(coefficient[k]);
            }
        }
    }
    energies
}

/// The functions of a batch of more bands, one after the other.
fn one_by_one<T: Coefficient<Scalar = f32>>(channels: &mut [ShBatch]) -> Vec<DeringReport> {
    let mut f = vec![T::ZERO; coefficient_count(channels[0].order())];
    let mut numbers = vec![0.0; f.len()];
    let dering = DeringOptions::default().evidence(false);
    let mut reports = Vec::with_capacity(channels[0].len());
    for k in 0..channels[0].len() {
        let lane = |channel: &ShBatch, i: usize| sixteen(channel, k / LANES)[i][k % LANES];
        for (i, f) in f.iter_mut().enumerate() {
            *f = T::from_channels(|c| lane(&channels[c], i));
        }
        reports.push(dering_in_place(&mut f, &dering));
        for (c, channel) in channels.iter_mut().enumerate() {
            numbers.iter_mut().zip(&f).for_each(|(number, f)| *number = f.channel(c));
            channel.set(k, &numbers);
        }
    }
    reports
}

/// Blocks `b` of sixteen functions.
fn sixteen(batch: &ShBatch, b: usize) -> &[Lanes] {
    let count = coefficient_count(batch.order());
    &batch.blocks()[b * count..][..count]
}

/// Applies the factors to one channel.
fn scale(channel: &mut ShBatch, found: &[LeastFactors]) {
    let (order, count) = (channel.order(), coefficient_count(channel.order()));
    if count == 0 {
        return;
    }
    for (blocks, found) in channel.blocks_mut().chunks_exact_mut(count).zip(found.chunks(LANES)) {
        for band in 1..order {
            let is_changed = |found: &&LeastFactors| found.outcome == DeringOutcome::Windowed;
            let factors: [f64; LANES] =
                array::from_fn(|k| found.get(k).filter(is_changed).map_or(1.0, |found| found.factors[band]));
            for block in &mut blocks[band_range(band)] {
                for (coefficient, factor) in block.0.iter_mut().zip(&factors) {
                    let scaled = (f64::from(*coefficient) * factor) as f32;
                    // Bits of what is not finite change by conversion.
                    *coefficient = if *factor == 1.0 { *coefficient } else { scaled };
                }
            }
        }
    }
}
