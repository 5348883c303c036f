//! Kelley's cutting planes: the factors per band that make a function non-negative with the least change, at any order.

use crate::basis::basis::{Basis, eval_basis_into};
use crate::basis::index::{band_range, order_of_slice};
use crate::basis::second_order::second_order;
use crate::extrema::Extremum;
use crate::extrema::branch_and_bound::{minimum_of, newton_descent};
use crate::filter::window::scale_bands_in_place;
use crate::prelude::*;
use crate::solver::ldp::least_distance;
use crate::sphere::triangulation::fine_directions;
use crate::sphere::vector::dot;

/// The depth below zero, relative to the mean, at which the planes have converged. The final blend with the mean
/// removes it, and changes the function by about as much.
const CONVERGED: f64 = 1e-6;

/// The width of the certified minimum's interval relative to the mean; the final blend covers it as well.
const WIDTH: f64 = 5e-7;

/// The most rounds of planes; 8 to 25 are usual. After the last one the function is blended as it is, and `excess`
/// includes the cost.
const MAX_ROUNDS: usize = 100;

/// A plane is dropped if the solution satisfies it with this slack, relative to the mean.
const MAX_SLACK: f64 = 0.3;

/// Bands with less than this fraction of the energy keep the factor 1.
const NO_ENERGY: f64 = 1e-28;

/// The result of [`least_change`].
pub(crate) struct LeastChange {
    /// One factor for every band.
    pub(crate) factors: Vec<f64>,
    /// An upper bound of the norm of the change divided by the least possible one, minus 1.
    pub(crate) excess: f64,
}

/// The factors `w_l` of bands `0..n` that solve
///
/// ```text
///   minimize    Σ_l E_l (1 - w_l)²                              E_l the energy of band l, summed over channels
///   subject to  Σ_l w_l f_l(s) >= 0  for all s and channels,    w_0 = 1,  0 <= w_l <= 1
/// ```
///
/// The objective is the squared norm of the change. For every direction `s` the constraint is linear in `w`, so the
/// feasible set is convex, and Kelley's method of cutting planes approaches it from outside: solve the quadratic
/// program with the planes so far, find the minima of the result, add their planes, until the certified minimum is
/// above `-1e-6` of the mean. Blending towards the mean then makes the function non-negative: if `Σ w_l f_l >= m` with
/// `m < 0 < f_0 = c`, the factors `t w_l` give
///
/// ```text
///   (1 - t) c + t Σ_l w_l f_l >= (1 - t) c + t m = margin        t = (c - margin) / (c - m)
/// ```
///
/// The planes are necessary conditions, so that no feasible factors change the function less than the last solution
/// before the blend: that bounds the excess.
///
/// `channels` are finite, each with a positive mean.
pub(crate) fn least_change(channels: &[Vec<f64>], order: usize, margin: f64) -> LeastChange {
    Basis::<f64>::with_shared(order, |basis| {
        let channels: Vec<Channel<'_>> = channels.iter().map(|f| Channel::new(f, basis)).collect();
        let mut planes = CuttingPlanes::new(&channels, order);
        let mut factors = vec![1.0; order];
        let mut lowest = f64::NEG_INFINITY;
        for round in 1.. {
            // Search for minima below zero, quickly at first; when that finds none, with proof.
            let mut low: Vec<Vec<f64>> = channels.iter().flat_map(|channel| channel.low_points(&factors)).collect();
            if low.is_empty() || round == MAX_ROUNDS {
                let minima: Vec<Extremum> =
                    channels.iter().map(|ch| ch.certified(&factors, round < MAX_ROUNDS)).collect();
                lowest = minima.iter().map(|min| min.lo).fold(0.0, f64::min);
                let below = channels.iter().zip(&minima).filter(|(_, min)| min.hi < -CONVERGED);
                low = below.map(|(channel, min)| channel.bands_at(min.dir.to_array())).collect();
            }
            if low.is_empty() || round == MAX_ROUNDS {
                break;
            }
            // Cut them off, and solve again.
            planes.add(low);
            factors = planes.nearest();
        }
        // Blend with the mean until the function is non-negative.
        let least = planes.change(&factors);
        let t = ((1.0 - margin).max(0.0) / (1.0 - lowest)).min(1.0);
        planes.free.iter().for_each(|&(l, _)| factors[l] *= t);
        LeastChange { excess: excess(planes.change(&factors), least), factors }
    })
}

/// An upper bound of the relative excess of the change by `factors` over the least possible one, from one constraint
/// for each channel, in the direction given for it.
pub(crate) fn excess_at(channels: &[Vec<f64>], factors: &[f64], directions: &[[f64; 3]]) -> f64 {
    let order = factors.len();
    Basis::<f64>::with_shared(order, |basis| {
        let channels: Vec<Channel<'_>> = channels.iter().map(|f| Channel::new(f, basis)).collect();
        let mut planes = CuttingPlanes::new(&channels, order);
        planes.add(channels.iter().zip(directions).map(|(channel, s)| channel.bands_at(*s)).collect());
        let least = planes.nearest();
        excess(planes.change(factors), planes.change(&least))
    })
}

fn excess(change: f64, least: f64) -> f64 {
    if change > least { change / least - 1.0 } else { 0.0 }
}

/// The cutting planes: half spaces that contain the feasible factors.
struct CuttingPlanes {
    order: usize,
    /// The bands whose factors are unknown, with the square roots of their parts of the energy: in the unit of the function what is
    /// rounded would depend on that.
    free: Vec<(usize, f64)>,
    /// In the unknowns `u_l = √(E_l/ΣE) (w_l - 1)`, rows `(g, h)` with `g·u >= h`.
    rows: Vec<(Vec<f64>, f64)>,
}

impl CuttingPlanes {
    /// The bounds `0 <= w_l <= 1`.
    fn new(channels: &[Channel<'_>], order: usize) -> Self {
        let energy = |l: usize| channels.iter().flat_map(|ch| &ch.f[band_range(l)]).map(|c| c * c).sum::<f64>();
        let total: f64 = (0..order).map(energy).sum();
        let free: Vec<_> =
            (1..order).filter(|&l| energy(l) > NO_ENERGY * total).map(|l| (l, (energy(l) / total).sqrt())).collect();
        let unit = |k: usize, sign: f64| (0..free.len()).map(|j| if j == k { sign } else { 0.0 }).collect::<Vec<f64>>();
        let rows = (0..free.len()).flat_map(|k| [(unit(k, -1.0), 0.0), (unit(k, 1.0), -free[k].1)]).collect();
        Self { order, free, rows }
    }

    /// Adds `Σ_l w_l p_l >= 0` for each point, given by the values `p_l` of the bands there relative to the mean, `p_0
    /// = 1`.
    fn add(&mut self, points: Vec<Vec<f64>>) {
        for p in points {
            let plane: Vec<f64> = self.free.iter().map(|&(l, root)| p[l] / root).collect();
            self.rows.push((plane, -p.iter().sum::<f64>()));
        }
    }

    /// The factors that satisfy all planes with the least change (LDP); drops planes with much slack.
    fn nearest(&mut self) -> Vec<f64> {
        let u = least_distance(&self.rows, self.free.len());
        let slack = |(g, h): &(Vec<f64>, f64)| g.iter().zip(&u).map(|(g, u)| g * u).sum::<f64>() - h;
        let sides = 2 * self.free.len();
        let mut k = 0;
        self.rows.retain(|row| {
            k += 1;
            k <= sides || slack(row) < MAX_SLACK
        });
        let mut factors = vec![1.0; self.order];
        for (&(l, root), u) in self.free.iter().zip(&u) {
            factors[l] = (1.0 + u / root).clamp(0.0, 1.0);
        }
        factors
    }

    /// The norm of the change by these factors.
    fn change(&self, factors: &[f64]) -> f64 {
        self.free.iter().map(|&(l, root)| (root * (1.0 - factors[l])).powi(2)).sum::<f64>().sqrt()
    }
}

/// One channel, scaled by its mean.
struct Channel<'a> {
    f: &'a [f64],
    basis: &'a Basis<f64>,
    mean: f64,
    /// The values of each band towards the directions of [`fine_directions`].
    samples: Vec<Vec<f64>>,
}

impl<'a> Channel<'a> {
    fn new(f: &'a [f64], basis: &'a Basis<f64>) -> Self {
        let order = order_of_slice(f);
        let mean = f[0] / (4.0 * core::f64::consts::PI).sqrt();
        let [x, y, z] = fine_directions(order);
        let sample = |l: usize| {
            let mut band = vec![0.0; f.len()];
            band[band_range(l)].iter_mut().zip(&f[band_range(l)]).for_each(|(b, c)| *b = c / mean);
            let mut values = vec![0.0; x.len()];
            basis.eval_expansion_into(&band, [x, y, z], &mut values);
            values
        };
        Self { f, basis, mean, samples: (0..order).map(sample).collect() }
    }

    /// The windowed function, relative to the mean.
    fn windowed(&self, factors: &[f64]) -> Vec<f64> {
        let mut windowed: Vec<f64> = self.f.iter().map(|c| c / self.mean).collect();
        scale_bands_in_place(&mut windowed, factors);
        windowed
    }

    /// The values of all bands towards `s`.
    fn bands_at(&self, s: [f64; 3]) -> Vec<f64> {
        let mut y = vec![0.0; self.f.len()];
        eval_basis_into(s, &mut y);
        let value = |l: usize| band_range(l).map(|i| y[i] * self.f[i]).sum::<f64>() / self.mean;
        (0..self.samples.len()).map(value).collect()
    }

    /// The certified minimum; with `level` the search ends as soon as it is known to lie above or below `-CONVERGED`.
    fn certified(&self, factors: &[f64], level: bool) -> Extremum {
        let windowed = self.windowed(factors);
        let rms = (windowed.iter().map(|c| c * c).sum::<f64>() / (4.0 * core::f64::consts::PI)).sqrt();
        minimum_of(&windowed, WIDTH / rms, level.then_some(-CONVERGED))
    }

    /// The values of the bands at minima below zero, found by Newton's method from the lowest samples that are not
    /// close to each other. May miss some minima.
    fn low_points(&self, factors: &[f64]) -> Vec<Vec<f64>> {
        /// The most starts: a ring of minima has infinitely many points.
        const MAX_STARTS: usize = 12;
        /// A sample above this fraction of the mean rarely has a zero near it.
        const HIGH: f64 = 0.5;
        /// The least angle between two starts, as a fraction of `1/n`.
        const APART: f64 = 0.7;
        /// Points at which no band differs by more, relative to the mean, give the same plane, as those of a ring do.
        const SAME: f64 = 1e-7;

        let order = factors.len();
        let mut values = vec![0.0; self.samples[0].len()];
        for (samples, w) in self.samples.iter().zip(factors) {
            values.iter_mut().zip(samples).for_each(|(value, sample)| *value += w * sample);
        }
        let mut low: Vec<usize> = (0..values.len()).filter(|&k| values[k] < HIGH).collect();
        low.sort_unstable_by(|&a, &b| values[a].total_cmp(&values[b]));
        let [x, y, z] = fine_directions(order);
        let apart = (APART / order as f64).cos();
        let mut starts: Vec<[f64; 3]> = Vec::new();
        for s in low.into_iter().map(|k| [x[k], y[k], z[k]]) {
            if starts.len() < MAX_STARTS && starts.iter().all(|d| dot(*d, s) < apart) {
                starts.push(s);
            }
        }
        let windowed = self.windowed(factors);
        let at = |s: [f64; 3]| second_order(self.basis, &windowed, &[s])[0];
        let minima = starts.into_iter().map(|s| newton_descent(at(s), order, at));
        let mut found: Vec<Vec<f64>> = Vec::new();
        for local in minima.filter(|local| local.value < -CONVERGED) {
            let bands = self.bands_at(local.s);
            let same = |other: &Vec<f64>| other.iter().zip(&bands).all(|(a, b)| (a - b).abs() < SAME);
            if !found.iter().any(same) {
                found.push(bands);
            }
        }
        found
    }
}
