//! Factors per band that change a function least while it becomes non-negative, for any order.

use crate::curvature::dot;
use crate::index::{band_range, order_of_slice};
use crate::minimum::minimum_of;
use crate::nnls::least_norm;
use crate::triangulation::triangulation;
use crate::{Minimum, Real as _, eval_basis_into, scale_bands_in_place};

/// Cutting planes after which the search stops where it is; what it then returns is non-negative all the same.
const MAX_CUTS: usize = 400;

/// How far below zero, relative to the mean, a function may still be when the planes have converged. The final blend with
/// the mean removes it and costs the same part of the contrast. The factors are known to about the square root of that,
/// because near the optimum the change hardly depends on them.
const CONVERGED: f64 = 1e-5;

/// The width of the certified minimum in parts of that.
const WIDTH: f64 = 0.1;

/// Bands of less than this part of the energy are left alone.
const NO_ENERGY: f64 = 1e-28;

/// The factors `w_l` of bands `0..n` that solve
///
/// ```text
///   minimise    Σ_l E_l (1 - w_l)²                              E_l the energy of band l, summed over channels
///   subject to  Σ_l w_l f_l(s) >= 0  for all s and channels,    w_0 = 1,  0 <= w_l <= 1
/// ```
///
/// What is minimised is the squared norm of the change. For every direction `s` the condition is linear in `w`, so the
/// admissible set is convex. It is approached from outside by planes: solve with the planes so far, find the least value of
/// the result over the sphere, add the plane of that direction, until the least value is above `-1e-5` of the mean. Blending
/// towards the mean then makes it non-negative: if `Σ w_l f_l >= m` with `m < 0 < f_0 = c`, the factors `t w_l` give
///
/// ```text
///   (1 - t) c + t Σ_l w_l f_l >= (1 - t) c + t m = margin        t = (c - margin) / (c - m)
/// ```
///
/// `channels` are finite, each with a positive mean or all zero.
pub(crate) fn least_change(channels: &[Vec<f64>], order: usize, margin: f64) -> Vec<f64> {
    let energies: Vec<f64> =
        (0..order).map(|l| channels.iter().flat_map(|f| &f[band_range(l)]).map(|c| c * c).sum()).collect();
    let total: f64 = energies.iter().sum();
    let free: Vec<usize> = (1..order).filter(|&l| energies[l] > NO_ENERGY * total).collect();
    let roots: Vec<f64> = free.iter().map(|&l| energies[l].sqrt()).collect();
    // Unknown u_l = √E_l (w_l - 1), rows (G, h) with G u >= h: first 0 <= w_l <= 1.
    let mut rows = Vec::new();
    for (k, root) in roots.iter().enumerate() {
        let unit = |sign: f64| (0..free.len()).map(|j| if j == k { sign } else { 0.0 }).collect::<Vec<f64>>();
        rows.extend([(unit(-1.0), 0.0), (unit(1.0), -root)]);
    }
    let mut factors = vec![1.0; order];
    loop {
        let last = rows.len() > MAX_CUTS + 2 * free.len();
        let lowest = lowest(channels, &factors, last, &mut |per_band: &[f64]| {
            // 1 + Σ_l p_l w_l >= 0
            let plane: Vec<f64> = free.iter().zip(&roots).map(|(&l, root)| per_band[l] / root).collect();
            rows.push((plane, -1.0 - free.iter().map(|&l| per_band[l]).sum::<f64>()));
        });
        if last || lowest >= -(1.0 + WIDTH) * CONVERGED {
            let t = (1.0 - margin).max(0.0) / (1.0 - lowest.min(0.0));
            for l in free {
                factors[l] *= t.min(1.0);
            }
            return factors;
        }
        for ((u, root), &l) in least_norm(&rows, free.len()).into_iter().zip(&roots).zip(&free) {
            factors[l] = (1.0 + u / root).clamp(0.0, 1.0);
        }
    }
}

/// The certified least value over the sphere and the channels, each relative to its mean; tells `cut` the values of all
/// bands, relative to the mean, where a channel is lowest and below zero.
///
/// Unless it is the `last` look, the search ends where it is known that the function is, or is not, above `-CONVERGED`.
fn lowest(channels: &[Vec<f64>], factors: &[f64], last: bool, cut: &mut dyn FnMut(&[f64])) -> f64 {
    let mut lowest = 0.0_f64;
    for f in channels {
        let mut windowed = f.clone();
        scale_bands_in_place(&mut windowed, factors);
        let mean = f[0] * mean_factor();
        if mean <= 0.0 {
            continue;
        }
        let rms = (windowed.iter().map(|c| c * c).sum::<f64>()).sqrt() * mean_factor();
        let level = -CONVERGED * mean;
        let min = minimum_of(&windowed, WIDTH * CONVERGED * mean / rms, (!last).then_some(level));
        lowest = lowest.min(min.lo / mean);
        if min.hi < level {
            for dir in low_directions(&windowed, &min) {
                let mut y = vec![0.0; f.len()];
                eval_basis_into(dir, &mut y);
                let values: Vec<f64> =
                    (0..factors.len()).map(|l| band_range(l).map(|i| y[i] * f[i]).sum::<f64>() / mean).collect();
                cut(&values);
            }
        }
    }
    lowest
}

/// The direction of the minimum, and others that are nearly as low but not close to one before: a ring of minima takes a
/// plane for each part of it.
fn low_directions(f: &[f64], min: &Minimum) -> Vec<[f64; 3]> {
    /// At most so many at a time.
    const MOST: usize = 12;
    /// As low as this part of the minimum.
    const NEARLY: f64 = 0.5;

    let order = order_of_slice(f);
    let triangles = triangulation(order);
    let components = [0, 1, 2].map(|k| triangles.iter().map(|t| t.centre[k]).collect::<Vec<f64>>());
    let mut values = vec![0.0; triangles.len()];
    let [x, y, z] = &components;
    f64::with_shared_basis(order, |basis| basis.eval_expansion_into(f, [x, y, z], &mut values));
    let mut low: Vec<usize> = (0..triangles.len()).filter(|&k| values[k] < NEARLY * min.hi).collect();
    low.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
    let mut found = vec![min.dir.to_array()];
    let apart = (1.0 / order as f64).cos();
    for k in low {
        let centre = triangles[k].centre;
        if found.len() < MOST && found.iter().all(|d| dot(*d, centre) < apart) {
            found.push(centre);
        }
    }
    found
}

/// `1/√4π`.
fn mean_factor() -> f64 {
    (4.0 * std::f64::consts::PI).sqrt().recip()
}
