//! The least change that makes three bands non-negative: two factors, found in a plane.

#[cfg(not(feature = "std"))]
use num_traits::Float as _;

use crate::extrema::quadratic_form::{QuadraticForm, to_unit_size};
use crate::extrema::quadratic_minimum::Eigensystem;
use crate::ringing::DeringOutcome;
use crate::scalar::{Coefficient, Real};

/// The most cutting planes. The result is non-negative after any number of them.
const MAX_CUTS: usize = 24;

/// The depth below zero, relative to the mean, at which the planes have converged; a blend with the mean removes it.
/// The factors are known to about its square root, because near the optimum the change hardly depends on them.
const CONVERGED: f64 = 1e-6;

/// The depth below zero, relative to the mean, that another channel may have where one decides, removed by the blend:
/// channels that are equal but for rounding differ by less.
pub(crate) const TIE: f64 = 1e-8;

/// The effect of rounding in `f64` on a minimum, relative to the function's scale.
pub(crate) const ROUNDING: f64 = 1e-14;

/// How the search for factors ended, and the factors of bands 0 to 2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LeastFactors {
    pub(crate) outcome: DeringOutcome,
    pub(crate) factors: [f64; 3],
}

/// A channel and, once needed, its eigensystem.
struct Channel {
    form: QuadraticForm,
    eigensystem: Option<Eigensystem>,
}

impl Channel {
    #[inline]
    fn eigensystem(&mut self) -> &Eigensystem {
        let form = &self.form;
        self.eigensystem.get_or_insert_with(|| form.eigensystem())
    }

    /// The least value under the factors `w`, `w_2` not 0, relative to the mean, as [`Eigensystem::least`] finds it;
    /// `None` if it cannot be negative.
    #[inline]
    fn least(&mut self, w: [f64; 2], enough: f64) -> Option<(f64, f64)> {
        let c = self.form.c;
        (self.form.amplitude(w) > c).then(|| self.eigensystem().least(c, [w[0] / w[1], w[1]], enough))
    }

    /// `p` and `q` of the value `1 + w_1 p + w_2 q` at the channel's minimum, relative to the mean; `None` if it cannot
    /// be negative.
    #[inline]
    fn lowest(&mut self, w: [f64; 2]) -> Option<[f64; 2]> {
        let c = self.form.c;
        if self.form.amplitude(w) <= c {
            return None;
        }
        let form = self.form;
        let [_, linear, form] = form.bands(form.lowest(self.eigensystem(), w));
        Some([linear / c, form / c])
    }
}

/// The factors `w_1, w_2` that make a function of up to three bands non-negative and change it least, without an allocation.
///
/// ```text
///   minimize  E_1 (1 - w_1)² + E_2 (1 - w_2)²        subject to  c + w_1 b·x + w_2 xᵀ A x >= 0 on the sphere, 0 <= w <= 1
/// ```
///
/// All channels share the factors; `E_l` sums their energies. Usually the channel that rings most decides alone:
/// Newton's method finds the point of least change on the boundary of its feasible set, and a bound shows that the
/// other channels need no more. Otherwise cutting planes: every direction `x` gives a line in the plane of `w`; while
/// the function is negative somewhere, the line of its minimum is added, and because the last solution violates that
/// line, the next one lies on it, which leaves one unknown. The factors for the irradiance of a sun alone are `w =
/// (0.857890, 0.909395)` to 3e-4 (test `the_irradiance_of_an_impulse_has_its_known_factors`).
///
/// A function that is nowhere below `-`[`DERING_ALLOWED`](crate::ringing::DERING_ALLOWED) times the mean has no factors but 1.
pub(crate) fn least_change_order_3<T: Coefficient>(coefficients: &[T]) -> LeastFactors {
    let unchanged = |outcome| LeastFactors { outcome, factors: [1.0; 3] };
    let mut channels: [Option<Channel>; 3] = [const { None }; 3];
    for (c, channel) in channels.iter_mut().enumerate().take(T::CHANNELS) {
        let (form, _) = QuadraticForm::normalized(coefficients, c);
        let reach = form.amplitude([1.0, 1.0]);
        if !(form.c + reach).is_finite() {
            return unchanged(DeringOutcome::NotFinite);
        }
        if form.c == 0.0 && reach == 0.0 {
            continue;
        }
        if form.c <= 0.0 {
            return unchanged(DeringOutcome::MeanNotPositive { channel: c });
        }
        *channel = Some(Channel { form, eigensystem: None });
    }
    let Some(ringing) = first_ringing(&mut channels) else {
        return unchanged(DeringOutcome::Unchanged);
    };
    let weights = weights(coefficients);
    let (w, worst) = by_one_channel(&mut channels, ringing, weights).unwrap_or_else(|| by_cuts(&mut channels, weights));
    // Blend with the mean as `least_change` does, with a margin for the rounding of the result.
    let scale = channels.iter().flatten().map(|ch| 1.0 + ch.form.amplitude(w) / ch.form.c).fold(0.0, f64::max);
    let margin = (unit_roundoff::<T::Scalar>() + ROUNDING) * scale;
    let t = (1.0 - margin).max(0.0) / (1.0 - worst.min(0.0));
    LeastFactors { outcome: DeringOutcome::Windowed, factors: [1.0, t * w[0], t * w[1]] }
}

/// The first channel that is negative without a window, beginning with the one of the largest amplitude, and the
/// multiplier of its minimum.
fn first_ringing(channels: &mut [Option<Channel>; 3]) -> Option<(usize, f64)> {
    let reach = channels.each_ref().map(|ch| ch.as_ref().map_or(0.0, |ch| ch.form.amplitude([1.0, 1.0]) / ch.form.c));
    let largest = [1, 2].into_iter().fold(0, |a, b| if reach[b] > reach[a] { b } else { a });
    let mut passed: Option<QuadraticForm> = None;
    for k in [largest, (largest + 1) % 3, (largest + 2) % 3] {
        let Some(channel) = &mut channels[k] else { continue };
        // Skip a channel that its amplitude, or a channel of nearly the same color, shows to be non-negative.
        let near = reach[k] > 1.0;
        if !near || passed.is_some_and(|other| channel.form.least_beside(&other, [1.0, 1.0]) >= 0.0) {
            continue;
        }
        match channel.least([1.0, 1.0], -crate::ringing::DERING_ALLOWED) {
            Some((value, t)) if value < -crate::ringing::DERING_ALLOWED => return Some((k, t)),
            _ => passed = Some(channel.form),
        }
    }
    None
}

/// The best factors and the least value they leave, relative to the mean, if the best factors of a single channel
/// suffice for the others, as they do for most light; `None` if they do not.
fn by_one_channel(
    channels: &mut [Option<Channel>; 3],
    (mut decides, mut t): (usize, f64),
    weights: [f64; 2],
) -> Option<([f64; 2], f64)> {
    for _ in 0..channels.len() {
        let channel = channels[decides].as_mut()?;
        let form = channel.form;
        let w = channel.eigensystem().nearest(form.c, weights, t)?;
        let mut worst = (decides, 0.0);
        for other in (0..channels.len()).filter(|k| *k != decides) {
            let Some(channel) = &mut channels[other] else { continue };
            let mut value = channel.form.least_beside(&form, w) / channel.form.c;
            if value < -TIE {
                value = channel.least(w, 0.0).map_or(0.0, |(value, _)| value);
            }
            if value < worst.1 {
                worst = (other, value);
            }
        }
        if worst.1 >= -TIE {
            return Some((w, worst.1));
        }
        // Try the factors of the channel that is now lowest.
        decides = worst.0;
        let (value, at) = channels[decides].as_mut()?.least([1.0, 1.0], 0.0)?;
        if value >= 0.0 {
            return None;
        }
        t = at;
    }
    None
}

/// The best factors and the least value they leave for any channels, by cutting planes.
fn by_cuts(channels: &mut [Option<Channel>; 3], weights: [f64; 2]) -> ([f64; 2], f64) {
    let mut w = [1.0, 1.0];
    let mut low = lowest(channels, w);
    let (mut cuts, mut count) = ([[0.0; 2]; MAX_CUTS], 0);
    while low.value < -CONVERGED && count < MAX_CUTS {
        cuts[count] = low.cut;
        count += 1;
        w = nearest_on_last(&cuts[..count], weights);
        // Finish one channel before looking at the others: most often it decides.
        low = lowest_of(channels, low.channel, w);
        if low.value >= -CONVERGED || count == MAX_CUTS {
            low = lowest(channels, w);
        }
    }
    (w, low.value)
}

/// The unit roundoff of `S`: the largest relative error of rounding to it.
pub(crate) fn unit_roundoff<S: Real>() -> f64 {
    if size_of::<S>() == 4 { 0.5 * f64::from(f32::EPSILON) } else { 0.5 * f64::EPSILON }
}

/// The minimum of a channel under some factors.
#[derive(Clone, Copy)]
struct Low {
    channel: usize,
    /// The least value relative to the mean, not above 0.
    value: f64,
    cut: [f64; 2],
}

/// The lowest minimum of all channels.
#[inline]
fn lowest(channels: &mut [Option<Channel>; 3], w: [f64; 2]) -> Low {
    let all = [0, 1, 2].map(|c| lowest_of(channels, c, w));
    all.into_iter().fold(all[0], |a, b| if b.value < a.value { b } else { a })
}

#[inline]
fn lowest_of(channels: &mut [Option<Channel>; 3], channel: usize, w: [f64; 2]) -> Low {
    match channels[channel].as_mut().and_then(|ch| ch.lowest(w)) {
        Some(cut) => Low { channel, value: (1.0 + w[0] * cut[0] + w[1] * cut[1]).min(0.0), cut },
        None => Low { channel, value: 0.0, cut: [0.0; 2] },
    }
}

/// The energies of bands 1 and 2, summed over the channels, in any unit: only their ratio counts.
fn weights<T: Coefficient>(coefficients: &[T]) -> [f64; 2] {
    let channels = |f: &T| -> [f64; 3] { [0, 1, 2].map(|c| if c < T::CHANNELS { f.channel(c).to_f64() } else { 0.0 }) };
    let largest = coefficients.iter().skip(1).flat_map(channels).fold(0.0, |largest: f64, f| largest.max(f.abs()));
    let scale = to_unit_size(largest);
    let mut weights = [0.0; 2];
    for (i, f) in coefficients.iter().enumerate().skip(1) {
        for f in channels(f) {
            weights[usize::from(i > 3)] += (f * scale).powi(2);
        }
    }
    // Keep a tiny weight for a band without energy, whose factor is arbitrary.
    let floor = f64::EPSILON * f64::EPSILON * (weights[0] + weights[1]);
    weights.map(|e| e.max(floor))
}

/// The point of the last line `1 + p w_1 + q w_2 = 0` that is nearest to (1, 1) in the weighted distance among those in
/// all other half planes and in the square `0 <= w <= 1`.
#[inline]
fn nearest_on_last(cuts: &[[f64; 2]], [e1, e2]: [f64; 2]) -> [f64; 2] {
    let Some((&[p, q], others)) = cuts.split_last() else { return [1.0, 1.0] };
    // Swap the weights in place of inverting them: only their ratio counts.
    let tau = -(1.0 + p + q) / (p * p * e2 + q * q * e1);
    let foot = [1.0 + tau * p * e2, 1.0 + tau * q * e1];
    let along = [q, -p];
    let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
    let mut clip = |value: f64, slope: f64| {
        // value + slope t >= 0
        if slope > 0.0 {
            low = low.max(-value / slope);
        } else if slope < 0.0 {
            high = high.min(-value / slope);
        }
    };
    for other in others {
        let value = 1.0 + other[0] * foot[0] + other[1] * foot[1];
        clip(value, other[0] * along[0] + other[1] * along[1]);
    }
    for k in 0..2 {
        clip(foot[k], along[k]);
        clip(1.0 - foot[k], -along[k]);
    }
    // Rounding may leave nothing between lines that are almost parallel; take their crossing.
    let t = if low <= high { 0.0_f64.clamp(low, high) } else { 0.5 * (low + high) };
    [0, 1].map(|k| (foot[k] + t * along[k]).clamp(0.0, 1.0))
}

/// The most Newton steps; 3 or 4 are usual. Functions that need more are left to the cutting planes.
pub(crate) const NEWTON_STEPS: usize = 16;

/// The relative step after which a search ends. The next step would be of the order of its square, and its gain of the
/// order of that squared.
pub(crate) const NEWTON_CONVERGED: f64 = 1e-4;

// With the bands scaled by `w_2 = w` and `w_1 = κ w`, for every `t >= 0` and every `x` of the sphere
//
//   f(x) >= c - w m(κ, t)      m(κ, t) = t - λ_1 + κ² S_1(t)      S_k(t) = Σ_i β_i² / (d_i + t)^k
//
// because `f(x) - c + w m` is a sum of squares, `w Σ_i (d_i + t) (x_i + κ β_i/(d_i + t))²`. So every `t` gives a
// lower bound; the least `m(κ)`, where `|y|² = κ² S_2(t) = 1` or `t = 0`, gives the minimum (see `Eigensystem`), and
// an error of `t` enters it squared. The windowed function is non-negative if and only if `w <= c/m(κ)`.
impl Eigensystem {
    /// `S_1, S_2, S_3`.
    #[inline]
    fn sums(&self, t: f64) -> [f64; 3] {
        let mut sums = [0.0; 3];
        for (beta, d) in self.beta.iter().zip(&self.distances) {
            if *beta != 0.0 {
                let inverse = 1.0 / (d + t);
                let y = beta * inverse;
                sums[0] += y * beta;
                sums[1] += y * y;
                sums[2] += y * y * inverse;
            }
        }
        sums
    }

    /// The least possible multiplier `t`: no component of `y` is longer than 1.
    #[inline]
    fn first(&self, kappa: f64) -> f64 {
        let Self { beta, distances: d, .. } = self;
        let least = |k: usize| kappa * beta[k].abs() - d[k];
        least(0).max(least(1)).max(least(2)).max(0.0)
    }

    /// One step of Newton's method for `t`, from either side; see [`Eigensystem`].
    #[inline]
    fn next(&self, kappa: f64, t: f64, [_, s2, s3]: [f64; 3]) -> f64 {
        let rise = if s3 > 0.0 { (kappa * s2.sqrt() - 1.0) * s2 / s3 } else { 0.0 };
        (t + rise).max(self.first(kappa))
    }

    /// A lower bound of the minimum under the window `κ, w`, relative to the mean `c`, and its multiplier. The search
    /// ends when the minimum is known to be at least `enough`.
    #[inline]
    pub(crate) fn least(&self, c: f64, [kappa, w]: [f64; 2], enough: f64) -> (f64, f64) {
        let mut t = self.first(kappa);
        let mut value = f64::NEG_INFINITY;
        for _ in 0..NEWTON_STEPS {
            let sums = self.sums(t);
            value = value.max(1.0 - w * (t - self.low + kappa * kappa * sums[0]) / c);
            let next = self.next(kappa, t, sums);
            if value >= enough || (next - t).abs() <= NEWTON_CONVERGED * t {
                break;
            }
            t = next;
        }
        (value, t)
    }

    /// The factors `w_1, w_2 <= 1` nearest to 1 in the distance `D = E_1 (1 - w_1)² + E_2 (1 - w_2)²` that make the
    /// function non-negative. It is negative for factors of 1, and `t` is the multiplier there. `None` if Newton's
    /// method does not converge.
    ///
    /// ```text
    ///   w_2 = c/m    w_1 = κ c/m       m' = 2κ S_1    m'' = 2 S_1 - 2 S_2²/S_3   (2 S_1 where t = 0)
    ///
    ///   w_2' = -w_2 m'/m               w_2'' = w_2 (2 (m'/m)² - m''/m)
    ///   w_1' = w_2 + κ w_2'            w_1'' = 2 w_2' + κ w_2''
    ///
    ///   D'/2 = -Σ E_l (1 - w_l) w_l'       D''/2 = Σ E_l (w_l'² - (1 - w_l) w_l'')
    /// ```
    ///
    /// The derivatives of `m` use that it is stationary in `t`. `m` is convex in `κ`, so that a Newton step for `m(κ) =
    /// c`, where `w_2 = 1`, stays right of that point: no step goes further to the left.
    pub(crate) fn nearest(&self, c: f64, [e1, e2]: [f64; 2], mut t: f64) -> Option<[f64; 2]> {
        let mut kappa = 1.0;
        let mut settled = false;
        for _ in 0..NEWTON_STEPS {
            let sums @ [s1, s2, s3] = self.sums(t);
            let m = t - self.low + kappa * kappa * s1;
            let w2 = c / m;
            if settled {
                return (w2 > 0.0).then(|| [(kappa * w2).min(kappa).min(1.0), w2.min(1.0)]);
            }
            let bend = if t > 0.0 && s3 > 0.0 { 2.0 * (s1 - s2 * s2 / s3) } else { 2.0 * s1 };
            let (slope, bend) = (2.0 * kappa * s1 / m, bend / m);
            let (d2, dd2) = (-w2 * slope, w2 * (2.0 * slope * slope - bend));
            let (d1, dd1) = (w2 + kappa * d2, 2.0 * d2 + kappa * dd2);
            let (r1, r2) = (e1 * (1.0 - kappa * w2), e2 * (1.0 - w2));
            let convex = e1 * d1 * d1 + e2 * d2 * d2;
            // Far from the minimum the curvature of D may be negative; then use its convex part.
            let full = convex - r1 * dd1 - r2 * dd2;
            let step = (r1 * d1 + r2 * d2) / if full > 0.1 * convex { full } else { convex };
            let back = if slope > 0.0 { (c / m - 1.0) / slope } else { f64::NEG_INFINITY };
            let step = step.max(back);
            if !step.is_finite() {
                return None;
            }
            kappa += step;
            let before = t;
            t = self.next(kappa, t, sums);
            settled = step.abs() <= NEWTON_CONVERGED * kappa && (t - before).abs() <= NEWTON_CONVERGED * t;
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lobe_testkit::Random;

    fn channels(f: &[[f64; 9]; 3]) -> [Option<Channel>; 3] {
        f.map(|f| Some(Channel { form: QuadraticForm::new(&f, 0), eigensystem: None }))
    }

    /// Newton's method along the boundary and cutting planes have nothing in common but the lowest direction.
    #[test]
    fn one_channel_alone_and_cutting_planes_find_one_answer() {
        let mut random = Random::new(1);
        let (mut answered, cases) = (0, 3000);
        for case in 0..cases {
            let mut f = [[0.0; 9]; 3];
            let first = random.signed_vec(9);
            for f in &mut f {
                let scale = 0.5 + random.unit();
                *f = core::array::from_fn(|i| scale * first[i] + 0.3 * random.signed());
                f[0] = 0.1 + 3.0 * random.unit();
                // Forms that hardly count and linear parts that hardly do.
                let factor = [1.0, 1e-4, 1.0, 1e-9][case % 4];
                f[4..].iter_mut().for_each(|c| *c *= factor);
                f[1..4].iter_mut().for_each(|c| *c *= if case % 4 == 2 { 1e-6 } else { 1.0 });
            }
            let energy =
                |band: core::ops::Range<usize>| f.iter().flat_map(|f| f[band.clone()].iter().map(|c| c * c)).sum();
            let weights: [f64; 2] = [energy(1..4), energy(4..9)];
            let Some(ringing) = first_ringing(&mut channels(&f)) else { continue };
            let Some((w, worst)) = by_one_channel(&mut channels(&f), ringing, weights) else { continue };
            answered += 1;
            let cost = |w: [f64; 2]| weights[0] * (1.0 - w[0]).powi(2) + weights[1] * (1.0 - w[1]).powi(2);
            let (cuts, left) = by_cuts(&mut channels(&f), weights);
            let difference = (cost(w) - cost(cuts)) / cost([0.0, 0.0]);
            // The cuts leave up to 1e-6 of the mean negative.
            assert!(difference.abs() < 3e-6, "case {case}: {w:?} {worst} costs {difference} more than {cuts:?} {left}");
            assert!(w.iter().all(|w| (0.0..=1.0).contains(w)), "case {case}: {w:?} outside the square");
            let low = lowest(&mut channels(&f), w).value;
            assert!(low >= -1.1 * TIE, "case {case}: {low} is left under {w:?}");
        }
        assert!(answered > cases / 3, "only {answered} of {cases} were answered");
    }
}
