//! The factors of [`quadratic_dering`](crate::ringing::quadratic_dering) for many functions, one in each lane.
//!
//! Lanes take the usual way: the channel of the largest amplitude is the first that rings, Newton's method finds its factors, and they
//! suffice for the others. Functions that need another, and those that are refused, are left to the code for one.

use alloc::vec::Vec;

#[cfg(feature = "std")]
use pulp::Simd;

#[cfg(feature = "std")]
use crate::ringing::quadratic_dering::{NEWTON_CONVERGED, NEWTON_STEPS, ROUNDING, TIE, unit_roundoff};
use crate::ringing::quadratic_dering::{QuadraticDeringReport, least_change_order_3};
#[cfg(feature = "std")]
use crate::simd::LANES;
use crate::simd::{Kernel, Lanes};
use crate::{Coefficient, Rgb};
#[cfg(feature = "std")]
use crate::{
    DERING_ALLOWED, DeringOutcome,
    extrema::lane_form::{LaneEigenvalues, LaneForm, Many, absolute},
    simd::rounded,
};

/// The coefficients of three bands.
const COUNT: usize = 9;

/// The factors of sixteen functions of one channel or three, each channel up to nine blocks.
pub(crate) struct Factors<'a> {
    /// The blocks of each channel.
    pub(crate) channels: &'a [&'a [Lanes]],
    /// The functions that there are of the sixteen.
    pub(crate) count: usize,
    /// Gets a report of each.
    pub(crate) reports: &'a mut Vec<QuadraticDeringReport>,
}

impl Factors<'_> {
    /// The report of function `k` by the code for one.
    fn report(&self, k: usize) -> QuadraticDeringReport {
        if self.channels.len() == 1 { self.report_of::<f32>(k) } else { self.report_of::<Rgb<f32>>(k) }
    }

    fn report_of<T: Coefficient<Scalar = f32>>(&self, k: usize) -> QuadraticDeringReport {
        let mut f = [T::ZERO; COUNT];
        let count = self.channels[0].len();
        for (i, f) in f[..count].iter_mut().enumerate() {
            *f = T::from_channels(|c| self.channels[c][i][k]);
        }
        least_change_order_3(&f[..count])
    }
}

impl Kernel for Factors<'_> {
    type Output = ();

    #[cfg(feature = "std")]
    #[inline(always)]
    fn wide<S: Simd>(self, simd: S) {
        let mut found = Found { state: [LEFT; LANES], factors: [[1.0; LANES]; 2] };
        for part in 0..self.count.div_ceil(S::F64_LANES) {
            Search::new(simd, self.channels, part).run(&mut found, part);
        }
        for k in 0..self.count {
            let report = if found.state[k] == UNCHANGED {
                QuadraticDeringReport { outcome: DeringOutcome::Unchanged, factors: [1.0; 3] }
            } else if found.state[k] == WINDOWED {
                let factors = [1.0, found.factors[0][k], found.factors[1][k]];
                QuadraticDeringReport { outcome: DeringOutcome::Windowed, factors }
            } else {
                self.report(k)
            };
            self.reports.push(report);
        }
    }

    fn plain(self) {
        for k in 0..self.count {
            let report = self.report(k);
            self.reports.push(report);
        }
    }
}

// What lanes found of a function, as a number in its lane: it is left to the code for one, is non-negative, or has factors.
#[cfg(feature = "std")]
const LEFT: f64 = 0.0;
#[cfg(feature = "std")]
const UNCHANGED: f64 = 1.0;
#[cfg(feature = "std")]
const WINDOWED: f64 = 2.0;

#[cfg(feature = "std")]
struct Found {
    state: [f64; LANES],
    factors: [[f64; LANES]; 2],
}

/// A function in each lane.
#[cfg(feature = "std")]
struct Search<S: Simd> {
    simd: S,
    channels: usize,
    forms: [LaneForm<S>; 3],
    /// The energies of bands 1 and 2, summed over the channels.
    weights: [Many<S>; 2],
}

#[cfg(feature = "std")]
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
        Self { simd, channels: channels.len(), forms, weights: [weights[0].max(floor), weights[1].max(floor)] }
    }

    #[inline(always)]
    fn run(&self, found: &mut Found, part: usize) {
        let simd = self.simd;
        let (zero, one) = (rounded(simd, 0.0), rounded::<S, f64>(simd, 1.0));
        // The channel of the largest amplitude. `is_usable`: every mean is above 0 and every coefficient finite.
        let (mut reach, mut is_usable) = ([zero; 3], one);
        let (mut form, mut decides, mut top) = (self.forms[0], zero, zero);
        for k in 0..self.channels {
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
            let mut beside = state;
            for k in 0..if one.any_above(rings) { self.channels } else { 0 } {
                let is_negative = self.forms[k].least_beside(&form, [one, one]).if_less(zero, left, beside);
                let is_near = one.if_less(reach[k], is_negative, beside);
                beside = other_than(simd, decides, k, is_near, beside);
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
        let (mut worst, mut scale) = (zero, zero);
        for k in 0..self.channels {
            let other = &self.forms[k];
            let amplitude = other.amplitude(w);
            scale = scale.max(one + amplitude / other.c);
            let mut value = other_than(simd, decides, k, other.least_beside(form, w) / other.c, zero);
            if tie.any_above(value) {
                let (least, _) = other.eigenvalues().least(simd, other.c, [w[0] / w[1], w[1]], zero);
                let least = other.c.if_less(amplitude, least, zero);
                value = value.if_less(tie, least, value);
            }
            worst = worst.min(value);
        }
        let margin = rounded::<S, f64>(simd, unit_roundoff::<f32>() + ROUNDING) * scale;
        let t = (one - margin).max(zero) / (one - worst);
        ([t * w[0], t * w[1]], worst.if_less(tie, zero, one))
    }
}

/// `then` where the channel that decides is another one than `k`.
#[cfg(feature = "std")]
#[inline(always)]
fn other_than<S: Simd>(simd: S, decides: Many<S>, k: usize, then: Many<S>, or: Many<S>) -> Many<S> {
    absolute(decides - rounded(simd, k as f64)).if_less(rounded(simd, 0.5), or, then)
}

// Newton's methods of `quadratic_dering`, with its names; a lane that has converged stays as it is, so that a function has one result beside
// any others.
#[cfg(feature = "std")]
impl<S: Simd> LaneEigenvalues<S> {
    /// `S_1, S_2, S_3`.
    #[inline(always)]
    fn sums(&self, simd: S, t: Many<S>) -> [Many<S>; 3] {
        let zero = rounded(simd, 0.0);
        let mut sums = [zero; 3];
        for k in 0..3 {
            let beta = self.beta[k];
            let inverse = zero.if_less(absolute(beta), (self.distances[k] + t).recip(), zero);
            let y = beta * inverse;
            let square = y * y;
            sums[0] = y.times_plus(beta, sums[0]);
            sums[1] = sums[1] + square;
            sums[2] = square.times_plus(inverse, sums[2]);
        }
        sums
    }

    /// The least possible multiplier.
    #[inline(always)]
    fn first(&self, simd: S, kappa: Many<S>) -> Many<S> {
        let mut first = rounded(simd, 0.0);
        for k in 0..3 {
            first = first.max(kappa * absolute(self.beta[k]) - self.distances[k]);
        }
        first
    }

    /// One step of Newton's method for `t`.
    #[inline(always)]
    fn next(&self, simd: S, kappa: Many<S>, t: Many<S>, [_, s2, s3]: [Many<S>; 3]) -> Many<S> {
        let (zero, one) = (rounded(simd, 0.0), rounded(simd, 1.0));
        let rise = zero.if_less(s3, (kappa * s2.sqrt() - one) * s2 / s3, zero);
        (t + rise).max(self.first(simd, kappa))
    }

    /// A lower bound of the minimum under the window `κ, w`, relative to the mean `c`, and its multiplier.
    #[inline(always)]
    fn least(&self, simd: S, c: Many<S>, [kappa, w]: [Many<S>; 2], enough: Many<S>) -> (Many<S>, Many<S>) {
        let (zero, one) = (rounded(simd, 0.0), rounded::<S, f64>(simd, 1.0));
        let converged = rounded::<S, f64>(simd, NEWTON_CONVERGED);
        let part = w / c;
        let mut t = self.first(simd, kappa);
        let mut value = rounded(simd, f64::NEG_INFINITY);
        let mut goes_on = one;
        for _ in 0..NEWTON_STEPS {
            let sums = self.sums(simd, t);
            let m = (kappa * kappa).times_plus(sums[0], t - self.low);
            value = value.max(part.times_from(m, one));
            let next = self.next(simd, kappa, t, sums);
            goes_on = value.if_less(enough, goes_on, zero);
            goes_on = (converged * t).if_less(absolute(next - t), goes_on, zero);
            if !goes_on.any_above(zero) {
                break;
            }
            t = zero.if_less(goes_on, next, t);
        }
        (value, t)
    }

    /// The factors `w_1, w_2 <= 1` nearest to 1 that make the function non-negative, and 1 where they were found.
    #[inline(always)]
    fn nearest(&self, simd: S, c: Many<S>, [e1, e2]: [Many<S>; 2], mut t: Many<S>) -> ([Many<S>; 2], Many<S>) {
        let (zero, one, two) = (rounded(simd, 0.0), rounded::<S, f64>(simd, 1.0), rounded::<S, f64>(simd, 2.0));
        let (converged, lowest) = (rounded::<S, f64>(simd, NEWTON_CONVERGED), rounded(simd, f64::NEG_INFINITY));
        let mut kappa = one;
        let mut goes_on = one;
        for _ in 0..NEWTON_STEPS {
            let sums @ [s1, s2, s3] = self.sums(simd, t);
            let m = (kappa * kappa).times_plus(s1, t - self.low);
            let w2 = c / m;
            // m'/m and m''/m.
            let curved = zero.if_less(t, zero.if_less(s3, s2 * s2 / s3, zero), zero);
            let (slope, bend) = (two * kappa * s1 / m, two * (s1 - curved) / m);
            let (d2, dd2) = (w2.negated() * slope, w2 * (two * slope * slope - bend));
            let (d1, dd1) = (kappa.times_plus(d2, w2), kappa.times_plus(dd2, two * d2));
            let (r1, r2) = (e1 * kappa.times_from(w2, one), e2 * (one - w2));
            let convex = e1 * d1 * d1 + e2 * d2 * d2;
            let full = convex - r1 * dd1 - r2 * dd2;
            let curvature = (rounded::<S, f64>(simd, 0.1) * convex).if_less(full, full, convex);
            let back = zero.if_less(slope, (w2 - one) / slope, lowest);
            let step = ((r1 * d1 + r2 * d2) / curvature).max(back);
            let kappa_next = kappa + step;
            let next = self.next(simd, kappa_next, t, sums);
            let near = (converged * kappa_next).if_less(absolute(step), one, zero);
            let far = (converged * next).if_less(absolute(next - t), one, zero);
            kappa = zero.if_less(goes_on, kappa_next, kappa);
            t = zero.if_less(goes_on, next, t);
            goes_on = zero.if_less(goes_on, near.max(far), zero);
            if !goes_on.any_above(zero) {
                break;
            }
        }
        let [s1, ..] = self.sums(simd, t);
        let w2 = c / (kappa * kappa).times_plus(s1, t - self.low);
        let w1 = (kappa * w2).min(kappa).min(one);
        let is_found = zero.if_less(goes_on, zero, zero.if_less(w2, zero.if_less(w1, one, zero), zero));
        ([w1, w2.min(one)], is_found)
    }
}

#[cfg(test)]
mod tests {
    use lobe_testkit::Random;

    use super::*;
    use crate::filter::window::band_energies;
    use crate::simd::Machine;
    use crate::{Dir, Expansion as _, ShBatch, ShL2, Zonal, certified_minimum, convolved, scale_bands_in_place};

    /// Between what the factors of one function by lanes and by the code for one leave of it, relative to it without its mean: both end where
    /// a step of Newton's method is below [`NEWTON_CONVERGED`], after which the next is of the order of its square. Without such a step more or less
    /// they are equal to 2e-15.
    const RESULTS: f64 = 1e-7;

    /// Lights of one color and of several, that ring and that do not, with functions among them that are refused.
    fn probe(random: &mut Random, case: usize) -> ShL2<Rgb<f32>> {
        let mut f = ShL2::<Rgb<f64>>::constant(Rgb::from_channels(|_| 0.05 + random.unit()));
        for _ in 0..=case % 3 {
            let s = Dir::from_unit(random.direction());
            let white = 2.0 * random.unit();
            let color = Rgb::from_channels(|_| white + [0.0, 0.3, 2.0][case / 3 % 3] * random.unit());
            f += ShL2::impulse(s, color);
        }
        if case.is_multiple_of(2) {
            f = convolved(&f, &Zonal::clamped_cosine(3));
        }
        let mut f = f.map(|c| Rgb::from_channels(|k| c.channel(k) as f32));
        match case % 97 {
            5 => f[4].g = f32::NAN,
            6 => f[0].b = -1.0,
            7 => f = ShL2::default(),
            8 => f = f.map(|c| Rgb::new(c.r, 0.0, c.b)),
            9 => f = ShL2::constant(Rgb::splat(0.5)),
            10 => f[8] = Rgb::splat(f32::INFINITY),
            11 => scale_bands_in_place(f.coefficients_mut(), &[1.0, 1.0, 0.0]),
            12 => scale_bands_in_place(f.coefficients_mut(), &[1.0, 0.0, 1.0]),
            13 => scale_bands_in_place(f.coefficients_mut(), &[1e-30, 1e-30, 1e-30]),
            _ => {}
        }
        f
    }

    fn reports(machine: Machine, order: usize, probes: &[ShL2<Rgb<f32>>]) -> Vec<QuadraticDeringReport> {
        let channels: [ShBatch; 3] = core::array::from_fn(|c| {
            let mut batch = ShBatch::zero(order, probes.len());
            for (k, f) in probes.iter().enumerate() {
                batch.set(k, f.map(|v| v.channel(c)).coefficients().get(..order * order).unwrap_or_default());
            }
            batch
        });
        let mut reports = Vec::new();
        for first in (0..probes.len()).step_by(LANES) {
            let of = |c: usize| &channels[c].blocks()[first / LANES * order * order..][..order * order];
            let count = LANES.min(probes.len() - first);
            machine.run(Factors { channels: &[of(0), of(1), of(2)], count, reports: &mut reports });
        }
        reports
    }

    /// The norm of what two sets of factors leave differently of bands 1 and 2, relative to theirs.
    fn difference(f: &[Rgb<f32>], x: [f64; 3], y: [f64; 3]) -> f64 {
        let energies = band_energies(f);
        let different: f64 = energies.iter().zip(x.iter().zip(y)).map(|(e, (x, y))| e * (x - y).powi(2)).sum();
        (different / energies[1..].iter().sum::<f64>()).sqrt()
    }

    #[test]
    fn every_machine_finds_the_factors_of_the_code_for_one() {
        let mut random = Random::new(3);
        let probes: Vec<_> = (0..4009).map(|case| probe(&mut random, case)).collect();
        for order in 1..=3 {
            for machine in Machine::available() {
                let found = reports(machine, order, &probes);
                assert_eq!(found.len(), probes.len(), "one report of each");
                let (mut worst, mut windowed) = (0.0_f64, 0);
                for (case, (f, found)) in probes.iter().zip(&found).enumerate() {
                    let f = &f.coefficients()[..order * order];
                    let expected = least_change_order_3(f);
                    let name = machine.name();
                    assert_eq!(found.outcome, expected.outcome, "{name}, order {order}, case {case}: {f:?}");
                    if found.outcome == DeringOutcome::Windowed {
                        worst = worst.max(difference(f, found.factors, expected.factors));
                    }
                    windowed += usize::from(found.outcome == DeringOutcome::Windowed);
                }
                println!("{}, order {order}: {windowed} windowed, within {worst:.1e}", machine.name());
                assert!(worst < RESULTS, "{}, order {order}: results differ by {worst}", machine.name());
                assert!(windowed > 1000 || order == 1, "only {windowed} of order {order}");
            }
        }
    }

    #[test]
    fn a_function_has_one_result_beside_any_others() {
        let mut random = Random::new(4);
        let probes: Vec<_> = (0..64).map(|case| probe(&mut random, case)).collect();
        for machine in Machine::available() {
            let together = reports(machine, 3, &probes);
            for (k, f) in probes.iter().enumerate() {
                assert_eq!(reports(machine, 3, &[*f]), [together[k]], "{}, function {k}", machine.name());
            }
        }
    }

    #[test]
    fn batches_are_nowhere_below_zero() {
        let mut random = Random::new(5);
        for count in [0, 1, 15, 16, 17, 1000] {
            let probes: Vec<_> = (0..count).map(|case| probe(&mut random, case)).collect();
            let of = |c: usize| probes.iter().map(|f| f.map(|v| v.channel(c))).collect::<Vec<_>>();
            let mut batches = [0, 1, 2].map(|c| ShBatch::from_functions(&of(c)));
            if count == 0 {
                batches = [0, 1, 2].map(|_| ShBatch::zero(3, 0));
            }
            let reports = crate::dering_batch_order_3_in_place(&mut batches);
            let mut alone = [batches[1].clone()];
            crate::dering_batch_order_3_in_place(&mut alone);
            for (k, report) in reports.iter().enumerate() {
                for c in 0..3 {
                    let (f, before): (ShL2<f32>, _) = (batches[c].function(k), of(c)[k]);
                    if report.outcome == DeringOutcome::Windowed {
                        let min = certified_minimum(f.coefficients(), 1e-7);
                        let mean = f64::from(f.mean());
                        assert!(min.lo >= -1e-6 * mean, "function {k} of {count}, channel {c}: {min:?} of {mean}");
                    } else {
                        let bits = |f: &ShL2<f32>| f.coefficients().iter().map(|c| c.to_bits()).collect::<Vec<_>>();
                        assert_eq!(bits(&f), bits(&before), "function {k} of {count}, {report:?}");
                    }
                }
                // What is non-negative stays as it is.
                let again: ShL2<f32> = alone[0].function(k);
                let is_same = again == batches[1].function(k);
                assert!(is_same || report.outcome != DeringOutcome::Windowed, "function {k} of {count} twice");
            }
        }
    }
}
