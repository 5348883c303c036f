//! Newton's methods of [`quadratic_dering`](crate::ringing::quadratic_dering) in lanes, with its names; a lane that has converged stays as it
//! is, so that a function has one result beside any others.

use pulp::Simd;

use crate::extrema::lane_form::{LaneEigenvalues, Many, absolute};
use crate::ringing::quadratic_dering::{NEWTON_CONVERGED, NEWTON_STEPS};
use crate::simd::rounded;

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
    pub(crate) fn least(&self, simd: S, c: Many<S>, [kappa, w]: [Many<S>; 2], enough: Many<S>) -> (Many<S>, Many<S>) {
        let (zero, one) = (rounded(simd, 0.0), rounded::<S, f64>(simd, 1.0));
        let converged = rounded::<S, f64>(simd, NEWTON_CONVERGED);
        let scale = w / c;
        let mut t = self.first(simd, kappa);
        let mut value = rounded(simd, f64::NEG_INFINITY);
        let mut goes_on = one;
        for _ in 0..NEWTON_STEPS {
            let sums = self.sums(simd, t);
            let m = (kappa * kappa).times_plus(sums[0], t - self.low);
            value = value.max(scale.times_from(m, one));
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
    pub(crate) fn nearest(
        &self,
        simd: S,
        c: Many<S>,
        [e1, e2]: [Many<S>; 2],
        mut t: Many<S>,
    ) -> ([Many<S>; 2], Many<S>) {
        let (zero, one, two) = (rounded(simd, 0.0), rounded::<S, f64>(simd, 1.0), rounded::<S, f64>(simd, 2.0));
        let (converged, lowest) = (rounded::<S, f64>(simd, NEWTON_CONVERGED), rounded(simd, f64::NEG_INFINITY));
        let mut kappa = one;
        let mut goes_on = one;
        // The last of the steps of the code for one takes what the one before has found.
        for _ in 1..NEWTON_STEPS {
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
        // Asked before they are cut off at 1, which would hide what is no number.
        let w2 = c / (kappa * kappa).times_plus(s1, t - self.low);
        let w1 = (kappa * w2).min(kappa).min(one);
        let is_found = zero.if_less(goes_on, zero, zero.if_less(w2, zero.if_less(w1, one, zero), zero));
        ([w1, w2.min(one)], is_found)
    }
}
