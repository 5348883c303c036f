//! Bounds on the error of exponentials.

use core::f64::consts::PI;

#[cfg(not(feature = "std"))]
use num_traits::Float as _;

use crate::expansion::Expansion;
use crate::exponential::exponential::{ExpMethod, Exponential};

impl Exponential {
    /// A bound on the norm of the error of [`Exponential::of`], `None` for methods that have none.
    ///
    /// With `f̂` the function without its mean, `|f̂(s)| <= ρ` everywhere by the addition theorem, and the product matrix
    /// `M` of `f̂`, being multiplication by it between two projections, has `‖M‖ <= ρ` too:
    ///
    /// ```text
    ///   ρ = ‖f̂‖ √((n² - 1)/4π)
    /// ```
    ///
    /// [`ExpMethod::ProductSeries`] of `P` terms differs from [`ExpMethod::Eigen`], its limit, by the terms left out,
    /// `‖M^(k-1) f̂‖/k! <= ρ^(k-1) ‖f̂‖/k!`:
    ///
    /// ```text
    ///   ‖error‖ <= e^mean ‖f̂‖ Σ_(k>P) ρ^(k-1)/k!
    /// ```
    ///
    /// [`ExpMethod::Grid`] differs from the projection of the true `e^f` by what its quadrature makes of
    /// `r = e^f̂ - 1 - f̂ - f̂²/2`; all before that has degree `3 (n - 1)` at most with a basis function, and is exact. The
    /// projections of `r` by integrals and by the quadrature both have at most the norm of `r`, in their sense of a norm:
    ///
    /// ```text
    ///   ‖error‖ <= e^mean 2 √4π (e^ρ - 1 - ρ - ρ²/2)
    /// ```
    ///
    /// Both are far above the error found where `ρ` is large, and useful below about 1 (test
    /// `errors_stay_below_their_bounds`). The optimal linear method is a fit, and the hybrid rests on it.
    ///
    /// # Panics
    /// If `f` has another order.
    #[must_use]
    pub fn error_bound(&self, f: &impl Expansion<f64>) -> Option<f64> {
        assert_eq!(f.order(), self.order(), "the order of the function against that of the exponential");
        let Some((first, rest)) = f.coefficients().split_first() else { return Some(0.0) };
        let norm = rest.iter().map(|c| c * c).sum::<f64>().sqrt();
        let rho = norm * (rest.len() as f64 / (4.0 * PI)).sqrt();
        let scale = (first / (4.0 * PI).sqrt()).exp();
        let bound = match self.method() {
            ExpMethod::ProductSeries(terms) => norm * tail(rho, terms) / rho.max(f64::MIN_POSITIVE),
            ExpMethod::Grid => 2.0 * (4.0 * PI).sqrt() * tail(rho, 2),
            _ => return None,
        };
        Some(scale * bound)
    }
}

/// `Σ_(k>terms) x^k/k!` for `x >= 0`: by its terms, since the difference from `e^x` loses all digits for small `x`.
fn tail(x: f64, terms: usize) -> f64 {
    let mut term = 1.0;
    for k in 1..=terms {
        term *= x / k as f64;
        // Terms do not come back from zero, and no bound is below infinity after one that is not finite.
        if term == 0.0 || !term.is_finite() {
            return term;
        }
    }
    let mut sum = 0.0;
    for k in terms + 1.. {
        term *= x / k as f64;
        sum += term;
        // From here on each term is less than half of the one before.
        if !sum.is_finite() || (k as f64 > 2.0 * x && term <= f64::EPSILON * sum) {
            break;
        }
    }
    sum
}
