//! The pilot bake: a few receivers, from which bounces, paths and the standard error are known beforehand.

use std::sync::OnceLock;

use lobe_io::parallel;

use crate::bake::options::BakeOptions;
use crate::job::chunks::{Estimator, Tally};
use crate::sampling::sobol::hash;

/// Receivers whose energy by bounce is estimated.
const RECEIVERS: usize = 64;

/// Independent bakes of those whose error is estimated. The standard error they give is itself known to `1/√(2·7)` for
/// each, and to a tenth for all of them.
const REPETITIONS: usize = 8;

/// One receiver in 128 is baked repeatedly, but at least eight and at most [`RECEIVERS`]: 512 bakes, or 1 % of 50 000.
const RECEIVERS_FOR_ONE: usize = 128;

/// A bound for the paths of the pilot where receivers have very many: some seconds of work, which are lost if the bake
/// is killed.
const MOST_PATHS: usize = 1 << 22;

/// The part of the mean square of all that is added to that of a place before its error is compared with it: what sends
/// a tenth of the mean counts half, and what is black nothing.
pub(crate) const DARKEST: f64 = 0.01;

/// What a pilot has found: it bakes a few receivers to know beforehand how many bounces matter, and how far results vary.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pilot {
    /// Bounces that carry enough energy.
    pub(crate) bounces: usize,
    /// Paths from each receiver.
    pub(crate) samples: u32,
    /// Relative standard error of the constant coefficient.
    pub(crate) stderr_dc: f64,
}

/// An estimator whose work a pilot decides.
pub(crate) trait Piloted: Estimator {
    /// Bakes no more bounces than these from now on.
    fn limit_bounces(&mut self, bounces: usize);

    /// Bakes so many paths from each receiver from now on.
    fn set_samples(&mut self, samples: u32);

    /// By how much the energy of a receiver, and its part of all surfaces, are larger than those of others.
    fn weight(&self, _receiver: usize) -> f64 {
        1.0
    }
}

/// The pilot of one bake, found by whichever part of it a process makes first.
pub(crate) type KnownPilot = OnceLock<Pilot>;

/// The pilot of a bake, which has more paths where those of the first pilot leave too much noise.
pub(crate) fn pilot<E: Piloted>(estimator: &mut E, options: &BakeOptions) -> Pilot {
    let (first, noise) = pilot_of(estimator, options.first_samples(), options.energy_stop);
    let samples = options.samples_for(noise);
    if samples == first.samples {
        return first;
    }
    estimator.set_samples(samples);
    pilot_of(estimator, samples, options.energy_stop).0
}

/// Bakes evenly chosen receivers with other seeds, derived from that of the estimator, which has so many paths. Beside
/// the pilot it finds the noise: the standard error of each receiver, relative to its own value.
fn pilot_of<E: Piloted>(estimator: &E, samples: u32, energy_stop: f64) -> (Pilot, f64) {
    let all = estimator.receivers();
    let most = (MOST_PATHS / (REPETITIONS * estimator.paths().max(1))).clamp(2, RECEIVERS);
    let once = all.min(most);
    let repeated = (all / RECEIVERS_FOR_ONE).max(8).min(most).min(all);
    let seeds: [u64; REPETITIONS] = std::array::from_fn(|k| hash([estimator.seed(), 0x0050_494C_4F54, k as u64]));
    // Bake some receivers once, to see how much energy each bounce carries.
    let first = bakes(estimator, once, &|k| (k * all / once, seeds[0]));
    let bounces = bounces_that_matter(&first, energy_stop);
    // Bake some of them with other seeds, to see how much the result varies.
    let receiver = |k: usize| k * all / repeated;
    let again = bakes(estimator, repeated * REPETITIONS, &|k| (receiver(k / REPETITIONS), seeds[k % REPETITIONS]));
    let spreads: Vec<Spread> = again.chunks_exact(REPETITIONS).map(|tallies| Spread::of(tallies, bounces)).collect();
    let weights: Vec<f64> = (0..repeated).map(|k| estimator.weight(receiver(k))).collect();
    (Pilot { bounces, samples, stderr_dc: relative_standard_error(&spreads) }, noise_by_place(&spreads, &weights))
}

/// Bakes `count` receivers with a seed each, which `receiver_and_seed` tells.
fn bakes<E: Estimator>(
    estimator: &E,
    count: usize,
    receiver_and_seed: &(dyn Fn(usize) -> (usize, u64) + Sync),
) -> Vec<Tally> {
    let scratch = || (estimator.scratch(), vec![0.0_f32; estimator.row()]);
    let work = |(scratch, row): &mut (E::Scratch, Vec<f32>), k: usize| {
        let (receiver, seed) = receiver_and_seed(k);
        estimator.estimate(seed, receiver, scratch, row)
    };
    parallel::map_with(count, &scratch, &work)
}

/// The last bounce that carries at least the part `stop` of all energy; all of them if these receivers see no light.
fn bounces_that_matter(tallies: &[Tally], stop: f64) -> usize {
    let mut sum = Tally::default();
    tallies.iter().for_each(|tally| sum += tally);
    let all: f64 = sum.energy.iter().sum();
    if stop == 0.0 || all == 0.0 {
        return sum.energy.len() - 1;
    }
    sum.energy.iter().rposition(|&energy| energy > 0.0 && energy >= stop * all).unwrap_or(0)
}

/// Exit radiance of a receiver under a constant sky: what several bakes have found.
#[derive(Clone, Copy, Debug)]
struct Spread {
    mean: f64,
    variance: f64,
}

impl Spread {
    fn of(tallies: &[Tally], bounces: usize) -> Self {
        let values: Vec<f64> = tallies.iter().map(|tally| tally.energy[..=bounces].iter().sum()).collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (values.len() - 1) as f64;
        Self { mean, variance }
    }
}

/// The root mean square over receivers of the standard deviation, over the mean of all; 0 if these receivers see no
/// light.
fn relative_standard_error(spreads: &[Spread]) -> f64 {
    let sum = |of: fn(&Spread) -> f64| spreads.iter().map(of).sum::<f64>();
    let mean = sum(|spread| spread.mean) / spreads.len() as f64;
    if mean > 0.0 { (sum(|spread| spread.variance) / spreads.len() as f64).sqrt() / mean } else { 0.0 }
}

/// The root mean square over surfaces of the standard deviation relative to the receiver's own mean: a dim room is
/// looked at by an eye that is used to it. What sends a tenth of the mean of all counts half, see [`DARKEST`]; 0 if
/// these receivers see no light. Means and deviations are those of receivers times their weights.
fn noise_by_place(spreads: &[Spread], weights: &[f64]) -> f64 {
    let all: f64 = weights.iter().sum();
    let own = || spreads.iter().zip(weights).filter(|(_, weight)| **weight > 0.0);
    let square = own().map(|(spread, weight)| spread.mean * spread.mean / weight).sum::<f64>() / all;
    let relative = |(spread, weight): (&Spread, &f64)| {
        weight * spread.variance / (spread.mean * spread.mean + DARKEST * square * weight * weight)
    };
    if square > 0.0 { (own().map(relative).sum::<f64>() / all).sqrt() } else { 0.0 }
}
