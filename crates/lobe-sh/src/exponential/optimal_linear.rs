//! The optimal linear exponential, `exp(f) ≈ a 1 + b f`, its two numbers tabulated over the norm of `f`.

use core::f64::consts::PI;

use crate::expansion::{Expansion, ShVec};
use crate::exponential::logarithm::LOG_CLAMP;
use crate::exponential::matrix_function::{apply, spectrum};
use crate::exponential::zonal_logarithm::ZonalLogarithm;
use crate::prelude::*;
use crate::sphere::Dir;

/// Angles of the spheres that the table is made from. Between two of them `a` and `b` change by less than 3 %, below the
/// error of the method itself.
const ANGLES: usize = 180;

/// The two numbers of [`ExpMethod::OptimalLinear`](crate::exponential::ExpMethod::OptimalLinear) over `‖f‖`, made from single spheres
/// of all sizes: `exp(f) ≈ a 1 + b f` for a function without mean.
///
/// For exponentials of many functions at once, elsewhere; [`Exponential`](crate::exponential::Exponential) holds its own.
#[derive(Clone, Debug)]
pub struct OptimalLinear {
    /// Norm, `a - 1` and `b`, in ascending norm.
    rows: Vec<[f64; 3]>,
}

impl OptimalLinear {
    /// The table of an order.
    ///
    /// For the logarithm `f` of a sphere without its mean, `g = exp(f)` by eigenvectors, the best fit is
    ///
    /// ```text
    ///   a = ⟨g, 1⟩/⟨1, 1⟩        b = ⟨g, f⟩/⟨f, f⟩
    /// ```
    #[must_use]
    pub fn new(order: usize) -> Self {
        // ‖f‖ = 0: exp(f) = 1 + f.
        let mut rows = alloc::vec![[0.0, 0.0, 1.0]];
        let logarithm = ZonalLogarithm::new(order, LOG_CLAMP);
        for k in 1..=if order == 0 { 0 } else { ANGLES } {
            let angle = 0.5 * PI * k as f64 / ANGLES as f64;
            let mut f = logarithm.of_sphere(angle).towards(Dir::Z, 1.0);
            isolate_mean(f.coefficients_mut());
            let square = f.dot(&f);
            let norm = square.sqrt();
            // The norm has its maximum below 90°. Beyond, and where the clamp lets it fall, the table has it already.
            if norm > rows[rows.len() - 1][0] {
                // f has no mean: ⟨g - 1, f⟩ is ⟨g, f⟩.
                let rest = exponential_less_one(&f);
                rows.push([norm, rest.coefficients()[0] / (4.0 * PI).sqrt(), rest.dot(&f) / square]);
            }
        }
        Self { rows }
    }

    /// `a - 1` and `b` for a norm; those of the last row beyond it. Of `a` few digits are left where it is near 1.
    #[must_use]
    pub fn factors(&self, norm: f64) -> (f64, f64) {
        let above = self.rows.partition_point(|row| row[0] <= norm);
        let [low, high] = [self.rows[above.max(1) - 1], self.rows[above.min(self.rows.len() - 1)]];
        let t = if high[0] > low[0] { (norm - low[0]) / (high[0] - low[0]) } else { 0.0 };
        (low[1] + t * (high[1] - low[1]), low[2] + t * (high[2] - low[2]))
    }
}

/// Takes the mean value out of the coefficients of a function and returns it.
pub(crate) fn isolate_mean(f: &mut [f64]) -> f64 {
    let Some(first) = f.first_mut() else { return 0.0 };
    core::mem::take(first) / (4.0 * PI).sqrt()
}

/// `exp(f)`, [`exponential_less_one`] and 1.
pub(crate) fn exponential_by_eigenvectors(f: &ShVec<f64>) -> ShVec<f64> {
    &ShVec::constant(f.order(), 1.0) + &exponential_less_one(f)
}

/// `exp(f) - 1 = R q(D) Rᵀ f`, `q(x) = (eˣ - 1)/x`, from the product matrix `M = R D Rᵀ` of `f`.
fn exponential_less_one(f: &ShVec<f64>) -> ShVec<f64> {
    let q = |d: f64| if d == 0.0 { 1.0 } else { d.exp_m1() / d };
    let Some(spectrum) = spectrum(f) else { return f.map(|_| f64::NAN) };
    ShVec::of(apply(&spectrum, &q, f.coefficients()))
}
