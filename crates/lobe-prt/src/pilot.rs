//! A few receivers baked many times, to know beforehand how many bounces matter and how large the error will be.

use rayon::prelude::*;

use crate::chunks::{Job, Tally};
use crate::sobol::hash;

/// Independent bakes of each receiver of the pilot. The standard error they give is itself known to `1/√(2·7)` for each
/// receiver, and to a few per cent for all of them.
const REPETITIONS: usize = 8;

/// Receivers in the pilot: 512 bakes of one receiver, which is 1 % of those of 50 000.
const RECEIVERS: usize = 64;

/// What the pilot found.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Pilot {
    /// Bounces that carry enough energy.
    pub(crate) bounces: usize,
    /// Relative standard error of the constant coefficient.
    pub(crate) stderr_dc: f64,
}

/// Bakes evenly chosen receivers with other seeds, derived from that of the job.
pub(crate) fn pilot<J: Job>(job: &J, energy_stop: f64) -> Pilot {
    let all = job.receivers();
    let count = all.min(RECEIVERS);
    let tallies: Vec<Tally> = (0..count * REPETITIONS)
        .into_par_iter()
        .map_init(
            || (job.scratch(), vec![0.0; job.row()]),
            |(scratch, row), k| {
                let (receiver, repetition) = ((k / REPETITIONS) * all / count, k % REPETITIONS);
                let seed = hash([job.seed(), 0x0050_494C_4F54, repetition as u64]);
                job.work(seed, receiver, scratch, row)
            },
        )
        .collect();
    let bounces = bounces_that_matter(&tallies, energy_stop);
    Pilot { bounces, stderr_dc: relative_standard_error(&tallies, bounces) }
}

/// The last bounce that carries at least the part `stop` of all energy.
fn bounces_that_matter(tallies: &[Tally], stop: f64) -> usize {
    let mut sum = Tally::default();
    tallies.iter().for_each(|tally| sum += tally);
    let all: f64 = sum.energy.iter().sum();
    if stop == 0.0 {
        return sum.energy.len() - 1;
    }
    sum.energy.iter().rposition(|&energy| energy > 0.0 && energy >= stop * all).unwrap_or(0)
}

/// The root mean square over receivers of the standard deviation of exit radiance under a constant sky, over its mean.
fn relative_standard_error(tallies: &[Tally], bounces: usize) -> f64 {
    let (mut variance, mut mean) = (0.0, 0.0);
    let receivers = tallies.chunks_exact(REPETITIONS);
    let count = receivers.len() as f64;
    for repetitions in receivers {
        let values: Vec<f64> = repetitions.iter().map(|tally| tally.energy[..=bounces].iter().sum()).collect();
        let middle = values.iter().sum::<f64>() / REPETITIONS as f64;
        variance += values.iter().map(|v| (v - middle).powi(2)).sum::<f64>() / (REPETITIONS - 1) as f64 / count;
        mean += middle / count;
    }
    if mean > 0.0 { variance.sqrt() / mean } else { 0.0 }
}
