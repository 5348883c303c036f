//! Denoising: averages of texels that differ by their noise alone.

use glam::Vec3;
use rayon::iter::{IntoParallelIterator as _, ParallelIterator as _};

use crate::error::PrtError;
use crate::receivers::texel_receivers::TexelReceivers;
use crate::transfer::transfer::Transfer;

/// Texels to each side that may be averaged.
const REACH: i32 = 3;

/// Texels to each side around which the noise is alike.
const NOISE_REACH: i32 = 2;

/// The part of the noise that the median of least differences shows: .42 where it is in four coefficients, .72 in 16,
/// and few have most of it. The test
/// `planted_noise_is_found_and_most_of_it_goes` measures it.
const LEAST_OF_FOUR: f32 = 0.6;

/// What texels may differ more than noise explains, as a part of it, until their weight is 1/e.
const WIDTH: f32 = 0.5;

/// The most that a value changes, in standard errors of its noise.
const MOST_CHANGE: f32 = 2.0;

/// The cosine of normals at which surfaces are none of one kind any more.
const OTHER_SIDE: f32 = 0.9;

/// Heights above the plane of a texel, as a part of the distance, until the weight is e^-½.
const HEIGHT: f32 = 0.25;

/// Transfer of texels with less noise: the mean of those around in the chart whose difference noise explains.
///
/// ```text
///   T̂_i = Σ_j w_ij T_j / Σ_j w_ij     j up to three texels from i in its chart
///   w_ij = exp(-max(0, D_ij - (σ_i² + σ_j²)) / (½ (σ_i² + σ_j²))) · n_ij · h_ij
/// ```
///
/// `D_ij` is the mean of `|T - T'|²`, over all coefficients, of both texels and their four neighbors: where it is no
/// more than noise, texels show the same light [Buades 2005] [Rousselle 2012]. `n_ij` falls from 1 to 0 while the
/// normals turn away from each other by 26°, `h_ij` where j is off the plane of i. `σ_i²` is the noise of all
/// coefficients together: `⅔ |T_i - (T_a + T_b)/2|²` of the two neighbors along the line, of four, where that is least,
/// so that the border of a shadow is no noise, and the median of that over 5 × 5 texels.
///
/// `T̂_i` is at most `2 σ_i` from `T_i`, which is right on average: so is the bias. The RMS error of a ball over the
/// ground, order 3, against 16 384 paths falls from 3.4 to 2.6 % at 64 paths, from 1.07 to 1.00 at 256, and from .359
/// to .356 at 1024, where there is little left. The test
/// `denoising_brings_baked_texels_nearer_to_the_truth_at_any_number_of_paths` measures it.
pub(crate) fn denoised(texels: &TexelReceivers, charts: &[u32], transfer: &Transfer) -> Result<Transfer, PrtError> {
    let grid = Grid::new(texels, charts, transfer);
    let count = transfer.receivers();
    let least: Vec<f32> = (0..count).into_par_iter().map(|i| grid.least_difference(i)).collect();
    let noise: Vec<f32> = (0..count).into_par_iter().map(|i| grid.median_around(i, &least)).collect();
    let rows: Vec<Vec<f32>> = (0..count).into_par_iter().map(|i| grid.mean(i, &noise)).collect();
    Transfer::new(transfer.order(), transfer.channels(), rows.concat())
}

/// The receivers by their places in the picture.
struct Grid<'a> {
    texels: &'a TexelReceivers,
    charts: &'a [u32],
    rows: &'a [f32],
    row: usize,
    /// The receiver of each texel.
    at: Vec<u32>,
}

impl<'a> Grid<'a> {
    const NONE: u32 = u32::MAX;

    fn new(texels: &'a TexelReceivers, charts: &'a [u32], transfer: &'a Transfer) -> Self {
        let mut at = vec![Self::NONE; texels.width() * texels.width()];
        for (receiver, &texel) in texels.texels().iter().enumerate() {
            at[texel as usize] = receiver as u32;
        }
        let row = transfer.coefficients().len() / transfer.receivers().max(1);
        Self { texels, charts, rows: transfer.coefficients(), row, at }
    }

    fn chart(&self, receiver: usize) -> u32 {
        self.charts[self.texels.triangles()[receiver] as usize]
    }

    fn values(&self, receiver: usize) -> &[f32] {
        &self.rows[receiver * self.row..][..self.row]
    }

    /// The receiver some texels away, if it is of the same chart.
    fn near(&self, receiver: usize, (across, down): (i32, i32)) -> Option<usize> {
        let width = self.texels.width() as i32;
        let texel = self.texels.texels()[receiver] as i32;
        let (x, y) = (texel % width + across, texel / width + down);
        if !(0..width).contains(&x) || !(0..width).contains(&y) {
            return None;
        }
        let other = self.at[(y * width + x) as usize];
        (other != Self::NONE && self.chart(other as usize) == self.chart(receiver)).then_some(other as usize)
    }

    /// The noise that the smoothest line through a texel shows; none in the corner of a chart.
    fn least_difference(&self, receiver: usize) -> f32 {
        let along = |(across, down): (i32, i32)| {
            let a = self.values(self.near(receiver, (across, down))?);
            let b = self.values(self.near(receiver, (-across, -down))?);
            let values = self.values(receiver).iter().zip(a.iter().zip(b));
            Some(values.map(|(t, (a, b))| (t - 0.5 * (a + b)).powi(2)).sum::<f32>() * 2.0 / 3.0)
        };
        let least = [(1, 0), (0, 1), (1, 1), (1, -1)].into_iter().filter_map(along).reduce(f32::min);
        least.map_or(f32::NAN, |least| least / LEAST_OF_FOUR)
    }

    /// The median of what is known around a texel; 0 where nothing is.
    fn median_around(&self, receiver: usize, of: &[f32]) -> f32 {
        let near = window(NOISE_REACH).filter_map(|step| self.near(receiver, step)).map(|other| of[other]);
        let mut known: Vec<f32> = near.filter(|v| !v.is_nan()).collect();
        let middle = known.len() / 2;
        if known.is_empty() { 0.0 } else { *known.select_nth_unstable_by(middle, f32::total_cmp).1 }
    }

    /// The squared difference of two texels and their neighbors.
    fn difference(&self, a: usize, b: usize) -> f32 {
        let (mut sum, mut count) = (0.0, 0.0);
        for step in [(0, 0), (1, 0), (-1, 0), (0, 1), (0, -1)] {
            if let (Some(a), Some(b)) = (self.near(a, step), self.near(b, step)) {
                sum += self.values(a).iter().zip(self.values(b)).map(|(a, b)| (a - b).powi(2)).sum::<f32>();
                count += 1.0;
            }
        }
        sum / count
    }

    fn weight(&self, a: usize, b: usize, noise: &[f32]) -> f32 {
        let receivers = self.texels.receivers();
        let vector = |all: &[[f32; 3]], i: usize| Vec3::from(all[i]);
        let [normal, other] = [a, b].map(|i| vector(receivers.normals(), i));
        let alike = (normal.dot(other) - OTHER_SIDE) / (1.0 - OTHER_SIDE);
        let both = noise[a] + noise[b];
        if alike <= 0.0 || both <= 0.0 {
            return 0.0;
        }
        let way = vector(receivers.positions(), b) - vector(receivers.positions(), a);
        let height = normal.dot(way) / (HEIGHT * way.length()).max(f32::MIN_POSITIVE);
        let more = (self.difference(a, b) - both).max(0.0) / (WIDTH * both);
        alike * (-more - 0.5 * height * height).exp()
    }

    /// The mean around a texel.
    fn mean(&self, receiver: usize, noise: &[f32]) -> Vec<f32> {
        let own = self.values(receiver);
        let (mut sums, mut all) = (own.to_vec(), 1.0);
        for other in window(REACH).filter(|&step| step != (0, 0)).filter_map(|step| self.near(receiver, step)) {
            let weight = self.weight(receiver, other, noise);
            if weight > 0.0 {
                sums.iter_mut().zip(self.values(other)).for_each(|(sum, v)| *sum += weight * v);
                all += weight;
            }
        }
        let change: f32 = sums.iter().zip(own).map(|(sum, own)| (sum / all - own).powi(2)).sum();
        let most = MOST_CHANGE * MOST_CHANGE * noise[receiver];
        let part = if change > most { (most / change).sqrt() } else { 1.0 };
        sums.iter().zip(own).map(|(sum, own)| own + part * (sum / all - own)).collect()
    }
}

/// The steps to the texels of a square around one.
fn window(reach: i32) -> impl Iterator<Item = (i32, i32)> {
    (-reach..=reach).flat_map(move |down| (-reach..=reach).map(move |across| (across, down)))
}
