//! The exchange of the y and z axes in high bands, without a matrix: its entries follow from each other by three terms.

use core::f64::consts::SQRT_2;

use crate::basis::index::MAX_ORDER;
use crate::basis::index::{band_range, order_of_slice};
use crate::once::Once;
use crate::prelude::*;
use crate::rotation::cos_sin::CosSin;
use crate::rotation::exchange_lanes::{Exchange, PADDED};
use crate::scalar::{Coefficient, Real};
use crate::simd::Machine;

/// The first band whose exchange has no table of its entries: below, tables are quicker by up to a third for one channel
/// and stay in the second-level cache (0.7 MB).
pub(crate) const FIRST_HIGH_BAND: usize = 64;

/// The constants of bands [`FIRST_HIGH_BAND`]`..order`, from which the entries of the exchange `J_l` follow.
///
/// ```text
///   J_(l,±m')(l,±m) = σ_m' σ_m w_m' w_m B_{m,m'}            σ_m = (-1)^(⌊m/2⌋ + lm)      w_0 = 1, else √2
///
///   B_{l,m'} = √(2l over l - m') 2^-l
///   a_m B_{m-1,m'} = 2m' B_{m,m'} - a_{m+1} B_{m+1,m'}      a_m = √((l + m)(l - m + 1))
///
///   with B_m = s_m g_m D_m, s = 1, 1, -1, -1, 1, .. from m = l downwards, g_{m-1} = g_{m+1} a_{m+1} / a_m:
///   D_{m-1} = c_m m' D_m + D_{m+1}                          c_m = 2 s_m g_m / (a_m s_{m-1} g_{m-1})
/// ```
///
/// `B` is the matrix of `WignerHalfPi`, indexed by `l - m`: Krawtchouk's polynomials, normalized (DLMF 18.22 has their three
/// terms). From `m = l` downwards the wanted solution is the growing one where `m² + m'² > l (l + 1)` and a wave below, so
/// that errors do not grow: the test `high_bands_have_the_entries_of_the_tables` finds 1e-13 at band 255, and the smallest
/// start, `2^-l`, is a normal number to band 1022.
///
/// One step costs a multiplication and a fused one, less than loading an entry of a table that leaves the cache: order 256
/// takes 1.1 ms on an AVX-512 machine. Its constants take 1 MB where the entries would take 45, and 1 ms once.
struct HighBands {
    bands: Vec<HighBand>,
}

/// The constants of one band; lists that run from `m = l` downwards are padded to an even length with zeros.
struct HighBand {
    l: usize,
    /// `c_m`.
    steps: Vec<f64>,
    /// `σ_m w_m s_m g_m`.
    before: Vec<f64>,
    /// `σ_m' w_m'`, upwards from 0.
    after: Vec<f64>,
    /// `B_{l,m'}` of even `m'` and of odd `m'`, upwards, with zeros to a multiple of [`PADDED`].
    starts: [Vec<f64>; 2],
}

impl HighBands {
    /// Calls `f` with the constants of at least `order` bands: those shared by the whole process up to [`MAX_ORDER`], new
    /// ones above.
    fn with_shared<R>(order: usize, f: impl FnOnce(&Self) -> R) -> R {
        static SHARED: Once<HighBands> = Once::new();
        if order <= MAX_ORDER { f(SHARED.get_or_init(|| Self::new(MAX_ORDER))) } else { f(&Self::new(order)) }
    }

    fn new(order: usize) -> Self {
        Self { bands: (FIRST_HIGH_BAND..order).map(HighBand::new).collect() }
    }

    fn band(&self, l: usize) -> &HighBand {
        &self.bands[l - FIRST_HIGH_BAND]
    }
}

impl HighBand {
    fn new(l: usize) -> Self {
        let a = |m: usize| (((l + m) * (l + 1 - m)) as f64).sqrt();
        let signed = |m: usize| {
            let sign = if (m / 2 + l * m).is_multiple_of(2) { 1.0 } else { -1.0 };
            if m == 0 { sign } else { sign * SQRT_2 }
        };
        let even = (l + 1).next_multiple_of(2);
        let (mut steps, mut before) = (Vec::with_capacity(even), Vec::with_capacity(even));
        let (mut g, mut g_below) = (1.0, 1.0);
        for m in (0..=l).rev() {
            let [s, turned] = [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]][(l - m) % 4];
            before.push(s * signed(m) * g);
            steps.push(if m > 0 { turned * 2.0 * g / (a(m) * g_below) } else { 0.0 });
            if m > 1 {
                (g, g_below) = (g_below, g * a(m) / a(m - 1));
            } else {
                g = g_below;
            }
        }
        steps.resize(even, 0.0);
        before.resize(even, 0.0);
        // From the middle of the row of Pascal's triangle outwards.
        let middle = (1..=l).fold(1.0, |product, i| product * ((2 * i - 1) as f64 / (2 * i) as f64).sqrt());
        let mut starts = [Vec::new(), Vec::new()];
        let mut start = middle;
        for m in 0..=l {
            starts[m % 2].push(start);
            start *= ((l - m) as f64 / (l + m + 1) as f64).sqrt();
        }
        for starts in &mut starts {
            starts.resize(starts.len().next_multiple_of(PADDED), 0.0);
        }
        Self { l, steps, before, after: (0..=l).map(signed).collect(), starts }
    }
}

/// The turns of a rotation `Z(α) J Z(-β) J Z(γ)`: for each of `γ`, `-β`, `α` the cosine and sine of `m` times it.
type Turns = [Vec<[f64; 2]>; 3];

/// Cosine and sine of `m` times each angle, `m < order`, by repeated multiplication.
fn turns([alpha, beta, gamma]: [CosSin; 3], order: usize) -> Turns {
    [gamma, CosSin { sin: -beta.sin, ..beta }, alpha].map(|angle| {
        let mut turn = CosSin { cos: 1.0, sin: 0.0 };
        (0..order)
            .map(|_| {
                let here = [turn.cos, turn.sin];
                turn = turn.and(angle);
                here
            })
            .collect()
    })
}

/// Rotates the bands from [`FIRST_HIGH_BAND`] on.
pub(crate) fn rotate_high_bands<T: Coefficient>(angles: [CosSin; 3], coefficients: &mut [T]) {
    let order = order_of_slice(coefficients);
    if order <= FIRST_HIGH_BAND {
        return;
    }
    let machine = Machine::detect();
    let [gamma, minus_beta, alpha] = &turns(angles, order);
    each_band(coefficients, |work, l, band, coefficients| {
        work.load(l, coefficients);
        work.turn(gamma);
        work.exchange(machine, band);
        work.turn(minus_beta);
        work.exchange(machine, band);
        work.turn(alpha);
        work.store(l, coefficients);
    });
}

/// Exchanges y and z in the bands from [`FIRST_HIGH_BAND`] on.
pub(crate) fn exchange_high_bands<T: Coefficient>(coefficients: &mut [T]) {
    let machine = Machine::detect();
    each_band(coefficients, |work, l, band, coefficients| {
        work.load(l, coefficients);
        work.exchange(machine, band);
        work.store(l, coefficients);
    });
}

fn each_band<T: Coefficient>(coefficients: &mut [T], mut f: impl FnMut(&mut Work, usize, &HighBand, &mut [T])) {
    let order = order_of_slice(coefficients);
    if order <= FIRST_HIGH_BAND {
        return;
    }
    let mut work = Work::new(order, T::CHANNELS);
    HighBands::with_shared(order, |bands| {
        for l in FIRST_HIGH_BAND..order {
            f(&mut work, l, bands.band(l), &mut coefficients[band_range(l)]);
        }
    });
}

/// The coefficients of one band and what the exchange needs, in double precision.
struct Work {
    channels: usize,
    /// Cosines and sines, for each `m` upwards all channels.
    parts: [Vec<f64>; 2],
    /// The same from `m = l` downwards, weighted: what goes into the exchange.
    staged: [Vec<f64>; 2],
    /// What comes out: for even and odd `m'` the cosines and sines, for each `m'` upwards, a channel after the other.
    sums: [[Vec<f64>; 2]; 2],
}

impl Work {
    fn new(order: usize, channels: usize) -> Self {
        let list = || vec![0.0; channels * (order + 1)];
        let sums = || vec![0.0; channels * (order / 2 + 1).next_multiple_of(PADDED)];
        Self { channels, parts: [list(), list()], staged: [list(), list()], sums: [[sums(), sums()], [sums(), sums()]] }
    }

    fn load<T: Coefficient>(&mut self, l: usize, band: &[T]) {
        let [cos, sin] = &mut self.parts;
        for part in [&mut *cos, &mut *sin] {
            part.resize(self.channels * (l + 1), 0.0);
        }
        for m in 0..=l {
            for c in 0..self.channels {
                cos[m * self.channels + c] = band[l + m].channel(c).to_f64();
                sin[m * self.channels + c] = band[l - m].channel(c).to_f64();
            }
        }
        sin[..self.channels].fill(0.0);
    }

    fn store<T: Coefficient>(&self, l: usize, band: &mut [T]) {
        let [cos, sin] = &self.parts;
        let color = |part: &[f64], m: usize| T::from_channels(|c| T::Scalar::from_f64(part[m * self.channels + c]));
        band[l] = color(cos, 0);
        for m in 1..=l {
            band[l + m] = color(cos, m);
            band[l - m] = color(sin, m);
        }
    }

    /// Rotates about z.
    fn turn(&mut self, turns: &[[f64; 2]]) {
        let [cos, sin] = &mut self.parts;
        let colors = cos.chunks_exact_mut(self.channels).zip(sin.chunks_exact_mut(self.channels));
        for ((plus, minus), &[c, s]) in colors.zip(turns) {
            for (g, f) in plus.iter_mut().zip(minus) {
                (*f, *g) = (*f * c + *g * s, *g * c - *f * s);
            }
        }
    }

    /// Exchanges y and z.
    fn exchange(&mut self, machine: Machine, band: &HighBand) {
        let (channels, count) = (self.channels, band.steps.len());
        for (part, staged) in self.parts.iter().zip(&mut self.staged) {
            staged.resize(channels * count, 0.0);
            let downwards = part.chunks_exact(channels).rev().zip(&band.before);
            for ((from, before), to) in downwards.zip(staged.chunks_exact_mut(channels)) {
                to.iter_mut().zip(from).for_each(|(to, from)| *to = before * from);
            }
            let rest = channels * band.after.len();
            staged[rest..].fill(0.0);
        }
        let staged = [&self.staged[0][..], &self.staged[1][..]];
        let (l, steps, sums) = (band.l, &band.steps[..], &mut self.sums);
        let starts = [&band.starts[0][..], &band.starts[1][..]];
        match channels {
            1 => machine.run(Exchange::<1> { l, steps, starts, staged, sums }),
            _ => machine.run(Exchange::<3> { l, steps, starts, staged, sums }),
        }
        for (part, to) in self.parts.iter_mut().enumerate() {
            for (m, (to, after)) in to.chunks_exact_mut(channels).zip(&band.after).enumerate() {
                let (sums, stride) = (&self.sums[m % 2][part], band.starts[m % 2].len());
                for (c, to) in to.iter_mut().enumerate() {
                    *to = after * sums[c * stride + m / 2];
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rotation::yz_exchange::{SplitBand, YzExchange};

    #[test]
    fn high_bands_have_the_entries_of_the_tables() {
        let table = YzExchange::new(MAX_ORDER);
        let mut random = lobe_testkit::Random::new(51);
        for l in [64, 65, 100, 127, 128, 200, 254, 255] {
            let mut work = Work::new(MAX_ORDER, 1);
            let mut places = vec![0.0; 2 * SplitBand::<f64>::places(MAX_ORDER)];
            let (from, to) = places.split_at_mut(SplitBand::<f64>::places(MAX_ORDER));
            let (mut from, mut to) = (SplitBand::new(MAX_ORDER, from), SplitBand::new(MAX_ORDER, to));
            let f = random.signed_vec(2 * l + 1);
            let mut expected = f.clone();
            from.load(l, &f);
            table.band(l).apply(l, &from, &mut to);
            to.store(l, &mut expected);
            for machine in Machine::available() {
                let mut found = f.clone();
                work.load(l, &found);
                work.exchange(machine, &HighBand::new(l));
                work.store(l, &mut found);
                let worst = found.iter().zip(&expected).fold(0.0_f64, |worst, (a, b)| worst.max((a - b).abs()));
                assert!(worst < 3e-13, "band {l}, {}: off by {worst:e}", machine.name());
            }
        }
    }
}
