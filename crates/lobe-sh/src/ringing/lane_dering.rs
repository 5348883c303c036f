//! The factors of [`quadratic_dering`](crate::ringing::quadratic_dering) for many functions, one in each lane.
//!
//! Lanes take the usual way: the channel of the largest amplitude is the first that rings, Newton's method finds its factors, and they
//! suffice for the others. Functions that need another, and those that are refused, are left to the code for one; so is what is not a number anywhere
//! on the way, for only a comparison that holds lets lanes answer.

use alloc::vec::Vec;

#[cfg(feature = "simd")]
use pulp::Simd;

#[cfg(feature = "simd")]
use crate::extrema::lane_form::{LaneForm, Many, absolute};
use crate::ringing::quadratic_dering::{LeastFactors, least_change_order_3};
#[cfg(feature = "simd")]
use crate::ringing::quadratic_dering::{ROUNDING, TIE, unit_roundoff};
#[cfg(feature = "simd")]
use crate::ringing::{DERING_ALLOWED, DeringOutcome};
use crate::scalar::{Coefficient, Rgb};
#[cfg(feature = "simd")]
use crate::simd::LANES;
#[cfg(feature = "simd")]
use crate::simd::rounded;
use crate::simd::{Kernel, Lanes};

/// The coefficients of three bands.
const COUNT: usize = 9;

/// The search for the factors of sixteen functions of one channel or three, each channel up to nine blocks.
pub(crate) struct SixteenFunctions<'a> {
    /// The blocks of each channel.
    pub(crate) channels: &'a [&'a [Lanes]],
    /// The functions that there are of the sixteen.
    pub(crate) count: usize,
    /// Gets the factors of each.
    pub(crate) found: &'a mut Vec<LeastFactors>,
    /// Counts those that lanes left to the code for one.
    pub(crate) left: &'a mut usize,
}

impl SixteenFunctions<'_> {
    /// The factors of function `k` by the code for one.
    fn alone(&self, k: usize) -> LeastFactors {
        if self.channels.len() == 1 { self.alone_of::<f32>(k) } else { self.alone_of::<Rgb<f32>>(k) }
    }

    fn alone_of<T: Coefficient<Scalar = f32>>(&self, k: usize) -> LeastFactors {
        let mut f = [T::ZERO; COUNT];
        let count = self.channels[0].len();
        for (i, f) in f[..count].iter_mut().enumerate() {
            *f = T::from_channels(|c| self.channels[c][i][k]);
        }
        least_change_order_3(&f[..count])
    }
}

impl Kernel for SixteenFunctions<'_> {
    type Output = ();

    #[cfg(feature = "simd")]
    #[inline(always)]
    fn wide<S: Simd>(self, simd: S) {
        let mut found = Found { state: [LEFT; LANES], factors: [[1.0; LANES]; 2] };
        for part in 0..self.count.div_ceil(S::F64_LANES) {
            Search::new(simd, self.channels, part).run(&mut found, part);
        }
        for k in 0..self.count {
            let factors = if found.state[k] == UNCHANGED {
                LeastFactors { outcome: DeringOutcome::Unchanged, factors: [1.0; 3] }
            } else if found.state[k] == WINDOWED {
                let factors = [1.0, found.factors[0][k], found.factors[1][k]];
                LeastFactors { outcome: DeringOutcome::Windowed, factors }
            } else {
                *self.left += 1;
                self.alone(k)
            };
            self.found.push(factors);
        }
    }

    fn plain(self) {
        for k in 0..self.count {
            let factors = self.alone(k);
            self.found.push(factors);
        }
        *self.left += self.count;
    }
}

// What lanes found of a function, as a number in its lane: it is left to the code for one, is non-negative, or has factors.
#[cfg(feature = "simd")]
const LEFT: f64 = 0.0;
#[cfg(feature = "simd")]
const UNCHANGED: f64 = 1.0;
#[cfg(feature = "simd")]
const WINDOWED: f64 = 2.0;

#[cfg(feature = "simd")]
struct Found {
    state: [f64; LANES],
    factors: [[f64; LANES]; 2],
}

/// A function in each lane.
#[cfg(feature = "simd")]
struct Search<S: Simd> {
    simd: S,
    /// The forms that there are: 1 or 3.
    count: usize,
    forms: [LaneForm<S>; 3],
    /// The energies of bands 1 and 2, summed over the channels.
    weights: [Many<S>; 2],
}

#[cfg(feature = "simd")]
impl<S: Simd> Search<S> {
    #[inline(always)]
    fn new(simd: S, channels: &[&[Lanes]], part: usize) -> Self {
        let zero = rounded(simd, 0.0);
        let mut forms = [LaneForm::new(simd, &[zero; COUNT]); 3];
        let mut weights = [zero; 2];
        for (channel, form) in channels.iter().zip(&mut forms) {
            let mut f = [zero; COUNT];
            for (i, block) in channel.iter().enumerate() {
                let mut numbers = [0.0; LANES];
                for (number, c) in numbers.iter_mut().zip(&block.0[part * S::F64_LANES..][..S::F64_LANES]) {
                    *number = f64::from(*c);
                }
                f[i] = Many::load_array(simd, &numbers, 0);
            }
            for (i, f) in f.iter().enumerate().skip(1) {
                let band = usize::from(i > 3);
                weights[band] = f.times_plus(*f, weights[band]);
            }
            *form = LaneForm::new(simd, &f);
        }
        // A tiny weight for a band without energy, whose factor is arbitrary.
        let floor = rounded::<S, f64>(simd, f64::EPSILON * f64::EPSILON) * (weights[0] + weights[1]);
        Self { simd, count: channels.len(), forms, weights: [weights[0].max(floor), weights[1].max(floor)] }
    }

    #[inline(always)]
    fn run(&self, found: &mut Found, part: usize) {
        let simd = self.simd;
        let (zero, one) = (rounded(simd, 0.0), rounded::<S, f64>(simd, 1.0));
        // The channel of the largest amplitude. `is_usable`: every mean is above 0 and every coefficient finite.
        let (mut reach, mut is_usable) = ([zero; 3], one);
        let (mut form, mut decides, mut top) = (self.forms[0], zero, zero);
        for k in 0..self.count {
            let (c, amplitude) = (self.forms[k].c, self.forms[k].amplitude([one, one]));
            is_usable = zero.if_less(c, is_usable, zero);
            is_usable = (c + amplitude).if_less(rounded(simd, f64::INFINITY), is_usable, zero);
            reach[k] = amplitude / c;
            form = LaneForm::if_less([top, reach[k]], &self.forms[k], &form);
            decides = top.if_less(reach[k], rounded(simd, k as f64), decides);
            top = top.max(reach[k]);
        }
        let mut state = zero.if_less(is_usable, rounded(simd, UNCHANGED), rounded(simd, LEFT));
        if top.any_above(one) {
            let allowed = rounded(simd, -DERING_ALLOWED);
            let eigenvalues = form.eigenvalues();
            let (value, t) = eigenvalues.least(simd, form.c, [one, one], allowed);
            let rings = one.if_less(top, value.if_less(allowed, one, zero), zero);
            // Where it does not ring, it shows that another does not, or nothing is known.
            let left = rounded(simd, LEFT);
            let mut beside = one.if_less(top, at_least(simd, value, allowed, state, left), state);
            for k in 0..if one.any_above(rings) { self.count } else { 0 } {
                let least = self.forms[k].least_beside(&form, [one, one]);
                let shown = one.if_less(reach[k], at_least(simd, least, zero, beside, left), beside);
                beside = other_than(simd, decides, k, shown, beside);
            }
            let windowed = if rings.any_above(zero) {
                let (w, is_found) = eigenvalues.nearest(simd, form.c, self.weights, t);
                let (w, is_enough) = self.blended(&form, decides, w);
                w[0].store_array(&mut found.factors[0], part);
                w[1].store_array(&mut found.factors[1], part);
                let is_found = zero.if_less(is_found, is_enough, zero);
                zero.if_less(is_found, rounded(simd, WINDOWED), left)
            } else {
                left
            };
            state = zero.if_less(is_usable, zero.if_less(rings, windowed, beside), left);
        }
        state.store_array(&mut found.state, part);
    }

    /// The factors that `form`, channel `decides`, needs, blended with the mean for rounding, and 1 where they suffice for the other channels.
    #[inline(always)]
    fn blended(&self, form: &LaneForm<S>, decides: Many<S>, w: [Many<S>; 2]) -> ([Many<S>; 2], Many<S>) {
        let simd = self.simd;
        let (zero, one) = (rounded(simd, 0.0), rounded::<S, f64>(simd, 1.0));
        let tie = rounded(simd, -TIE);
        let (mut worst, mut scale, mut is_enough) = (zero, zero, one);
        for k in 0..self.count {
            let other = &self.forms[k];
            let amplitude = other.amplitude(w);
            scale = scale.max(one + amplitude / other.c);
            let mut value = other_than(simd, decides, k, other.least_beside(form, w) / other.c, zero);
            if tie.any_above(value) {
                let (least, _) = other.eigenvalues().least(simd, other.c, [w[0] / w[1], w[1]], zero);
                let least = other.c.if_less(amplitude, least, zero);
                value = value.if_less(tie, least, value);
            }
            is_enough = at_least(simd, value, tie, is_enough, zero);
            worst = worst.min(value);
        }
        let margin = rounded::<S, f64>(simd, unit_roundoff::<f32>() + ROUNDING) * scale;
        let t = (one - margin).max(zero) / (one - worst);
        ([t * w[0], t * w[1]], is_enough)
    }
}

/// `then` where `value >= limit`, `or` elsewhere, where it is no number too.
#[cfg(feature = "simd")]
#[inline(always)]
fn at_least<S: Simd>(simd: S, value: Many<S>, limit: Many<S>, then: Many<S>, or: Many<S>) -> Many<S> {
    value.if_less(limit, or, value.if_less(rounded(simd, f64::INFINITY), then, or))
}

/// `then` where the channel that decides is another one than `k`.
#[cfg(feature = "simd")]
#[inline(always)]
fn other_than<S: Simd>(simd: S, decides: Many<S>, k: usize, then: Many<S>, or: Many<S>) -> Many<S> {
    absolute(decides - rounded(simd, k as f64)).if_less(rounded(simd, 0.5), or, then)
}

#[cfg(all(test, feature = "simd"))]
mod tests {
    use lobe_testkit::Random;

    use super::*;
    use crate::batch::sh_batch::ShBatch;
    use crate::expansion::{Expansion as _, ShL2, Zonal};
    use crate::extrema::branch_and_bound::certified_minimum;
    use crate::filter::squared_laplacian::band_energies;
    use crate::filter::window::scale_bands_in_place;
    use crate::simd::Machine;
    use crate::sphere::Dir;

    /// Between what the factors of one function by lanes and by the code for one leave of it, relative to it without its mean, where both take
    /// as many steps. 2e-15 was found.
    const EQUAL: f64 = 1e-13;

    /// The same where one takes a step more: they end where a step of Newton's method is below [`NEWTON_CONVERGED`], and the next is of the order of its
    /// square.
    const NEAR: f64 = 1e-7;

    /// Kinds of probes: lights of one color and of several, that ring and that do not, every so many with a fault or a degenerate band.
    const FAULTS: usize = 97;

    fn probe(random: &mut Random, case: usize) -> ShL2<Rgb<f32>> {
        let mut f = ShL2::<Rgb<f64>>::constant(Rgb::from_channels(|_| 0.05 + random.unit()));
        for _ in 0..=case % 3 {
            let s = Dir::from_unit(random.direction());
            let white = 2.0 * random.unit();
            let color = Rgb::from_channels(|_| white + [0.0, 0.3, 2.0][case / 3 % 3] * random.unit());
            f += ShL2::impulse(s, color);
        }
        if case.is_multiple_of(2) {
            f = f.convolved(&Zonal::clamped_cosine(3));
        }
        let mut f = f.map(|c| Rgb::from_channels(|k| c.channel(k) as f32));
        match case % FAULTS {
            5 => f[4].g = f32::from_bits(0x7f80_0001),
            6 => f[0].b = -1.0,
            7 => f = ShL2::default(),
            8 => f = f.map(|c| Rgb::new(c.r, 0.0, c.b)),
            9 => f = ShL2::constant(Rgb::splat(0.5)),
            10 => f[8] = Rgb::splat(f32::INFINITY),
            11 => scale_bands_in_place(f.coefficients_mut(), &[1.0, 1.0, 0.0]),
            12 => scale_bands_in_place(f.coefficients_mut(), &[1.0, 0.0, 1.0]),
            13 => scale_bands_in_place(f.coefficients_mut(), &[1e-30, 1e-30, 1e-30]),
            14 => scale_bands_in_place(f.coefficients_mut(), &[1e-40, 1e-40, 1e-40]),
            15 => scale_bands_in_place(f.coefficients_mut(), &[1.0, 1e-40, 1.0]),
            16 => scale_bands_in_place(f.coefficients_mut(), &[1e36, 1e36, 1e36]),
            _ => {}
        }
        f
    }

    /// The first `count` channels of probes, cut off at an order; places that no function takes hold what is no number.
    fn batches(order: usize, count: usize, probes: &[ShL2<Rgb<f32>>]) -> Vec<ShBatch> {
        let channel = |c: usize| {
            let mut batch = ShBatch::zero(order, probes.len());
            batch.blocks_mut().fill(Lanes([f32::NAN; LANES]));
            for (k, f) in probes.iter().enumerate() {
                batch.set(k, &f.map(|v| v.channel(c)).coefficients()[..order * order]);
            }
            batch
        };
        (0..count).map(channel).collect()
    }

    /// The factors, and how many functions lanes left to the code for one.
    fn least_factors(machine: Machine, order: usize, channels: &[ShBatch]) -> (Vec<LeastFactors>, usize) {
        let (mut all, mut left) = (Vec::new(), 0);
        for first in (0..channels[0].len()).step_by(LANES) {
            let of = |channel: &ShBatch| channel.blocks()[first / LANES * order * order..][..order * order].to_vec();
            let blocks: Vec<Vec<Lanes>> = channels.iter().map(of).collect();
            let blocks: Vec<&[Lanes]> = blocks.iter().map(Vec::as_slice).collect();
            let count = LANES.min(channels[0].len() - first);
            machine.run(SixteenFunctions { channels: &blocks, count, found: &mut all, left: &mut left });
        }
        (all, left)
    }

    /// What the code for one says of the first channel or of all.
    fn alone(f: &[Rgb<f32>], channels: usize) -> LeastFactors {
        if channels == 3 {
            return least_change_order_3(f);
        }
        let red: Vec<f32> = f.iter().map(|c| c.r).collect();
        least_change_order_3(&red)
    }

    /// The norm of what two sets of factors leave differently of bands 1 and 2, relative to theirs.
    fn difference(f: &[Rgb<f32>], channels: usize, x: [f64; 3], y: [f64; 3]) -> f64 {
        let red: Vec<f32> = f.iter().map(|c| c.r).collect();
        let energies = if channels == 3 { band_energies(f) } else { band_energies(&red) };
        let different: f64 = energies.iter().zip(x.iter().zip(y)).map(|(e, (x, y))| e * (x - y).powi(2)).sum();
        (different / energies[1..].iter().sum::<f64>()).sqrt()
    }

    #[test]
    fn every_machine_finds_the_factors_of_the_code_for_one() {
        let mut random = Random::new(3);
        let probes: Vec<_> = (0..4009).map(|case| probe(&mut random, case)).collect();
        for (order, channels) in [(1, 1), (1, 3), (2, 1), (2, 3), (3, 1), (3, 3)] {
            let batches = batches(order, channels, &probes);
            for machine in Machine::available() {
                let (found, left) = least_factors(machine, order, &batches);
                assert_eq!(found.len(), probes.len(), "factors of each");
                let name = format!("{}, order {order}, {channels} channels", machine.name());
                let (mut worst, mut windowed, mut near) = (0.0_f64, 0, 0);
                for (case, (f, found)) in probes.iter().zip(&found).enumerate() {
                    let f = &f.coefficients()[..order * order];
                    let expected = alone(f, channels);
                    assert_eq!(found.outcome, expected.outcome, "{name}, case {case}: {f:?}");
                    if found.outcome == DeringOutcome::Windowed {
                        let difference = difference(f, channels, found.factors, expected.factors);
                        worst = worst.max(difference);
                        near += usize::from(difference > EQUAL);
                        windowed += 1;
                    }
                }
                println!("{name}: {windowed} windowed, within {worst:.1e}, {near} of them beyond {EQUAL}, {left} left");
                assert!(worst < NEAR && 100 * near <= windowed, "{name}: {near} differ, by up to {worst}");
                assert!(windowed > 400 || order == 1, "{name}: only {windowed} windowed");
                let is_by_lanes = left < probes.len() / 10;
                assert_eq!(is_by_lanes, machine.name() != "plain", "{name}: {left} left to the code for one");
            }
        }
    }

    #[test]
    fn a_function_has_one_result_beside_any_others() {
        let mut random = Random::new(4);
        let probes: Vec<_> = (0..97).map(|case| probe(&mut random, case)).collect();
        for (order, channels) in [(2, 3), (3, 1), (3, 3)] {
            for machine in Machine::available() {
                let (together, _) = least_factors(machine, order, &batches(order, channels, &probes));
                for (k, f) in probes.iter().enumerate() {
                    let (single, _) = least_factors(machine, order, &batches(order, channels, &[*f]));
                    let name = machine.name();
                    assert_eq!(single, [together[k]], "{name}, order {order}, {channels} channels, function {k}");
                }
            }
        }
    }

    #[test]
    fn batches_are_nowhere_below_zero_and_what_is_refused_keeps_its_bits() {
        let mut random = Random::new(5);
        for (channels, count) in [(1, 1000), (3, 0), (3, 1), (3, 15), (3, 16), (3, 17), (3, 1000), (1, 17)] {
            let probes: Vec<_> = (0..count).map(|case| probe(&mut random, case)).collect();
            let before = batches(3, channels, &probes);
            let mut after = before.clone();
            let reports = ShBatch::dering_in_place(&mut after);
            assert_eq!(reports.len(), count, "one report of each");
            for (k, report) in reports.iter().enumerate() {
                for c in 0..channels {
                    let [before, f]: [ShL2<f32>; 2] = [before[c].function(k), after[c].function(k)];
                    // Below the normal numbers of `f32` rounding is not relative, and no margin of factors covers it.
                    let is_normal = before.mean() > 1e6 * f32::MIN_POSITIVE;
                    if report.outcome == DeringOutcome::Windowed && is_normal {
                        let min = certified_minimum(f.coefficients(), 1e-9);
                        let mean = f64::from(f.mean());
                        assert!(min.lo >= -DERING_ALLOWED * mean, "function {k} of {count}, {c}: {min:?} of {mean}");
                    } else if report.outcome != DeringOutcome::Windowed {
                        let bits = |f: &ShL2<f32>| f.coefficients().iter().map(|c| c.to_bits()).collect::<Vec<_>>();
                        assert_eq!(bits(&f), bits(&before), "function {k} of {count}, {report:?}");
                    }
                }
            }
        }
        let mut empty = [ShBatch::zero(0, 3)];
        let outcome = least_change_order_3::<f32>(&[]).outcome;
        assert!(ShBatch::dering_in_place(&mut empty).iter().all(|report| report.outcome == outcome), "of no band");
    }
}
