//! The windows that make one function of three bands non-negative, and the one of them with the least change.

#[cfg(not(feature = "std"))]
use num_traits::Float as _;

use crate::extrema::quadratic_form::Eigensystem;

/// The most Newton steps; 3 or 4 are usual. Functions that need more are left to the cutting planes.
const STEPS: usize = 16;

/// The relative step after which a search ends. The next step would be of the order of its square, and its gain of the
/// order of that squared.
const CONVERGED: f64 = 1e-4;

// With the bands scaled by `w_2 = w` and `w_1 = κ w`, for every `t >= 0` and every `x` of the sphere
//
//   f(x) >= c - w m(κ, t)      m(κ, t) = t - λ_1 + κ² S_1(t)      S_k(t) = Σ_i β_i² / (d_i + t)^k
//
// because `f(x) - c + w m` is a sum of squares, `w Σ_i (d_i + t) (x_i + κ β_i/(d_i + t))²`. So every `t` gives a
// lower bound; the least `m(κ)`, where `|y|² = κ² S_2(t) = 1` or `t = 0`, gives the minimum (see `QuadraticForm`), and
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

    /// One step of Newton's method for `t`, from either side; see
    /// [`QuadraticForm`](crate::extrema::quadratic_form::QuadraticForm).
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
        for _ in 0..STEPS {
            let sums = self.sums(t);
            value = value.max(1.0 - w * (t - self.low + kappa * kappa * sums[0]) / c);
            let next = self.next(kappa, t, sums);
            if value >= enough || (next - t).abs() <= CONVERGED * t {
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
        for _ in 0..STEPS {
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
            settled = step.abs() <= CONVERGED * kappa && (t - before).abs() <= CONVERGED * t;
        }
        None
    }
}
