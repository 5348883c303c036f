//! Ascent to a local maximum of an expansion by the method of Broyden, Fletcher, Goldfarb and Shanno (BFGS).

#[cfg(not(feature = "std"))]
use num_traits::Float as _;

use crate::expansion::gradient::eval_with_gradient;
use crate::expansion::{Expansion, ShVec};
use crate::sphere::Dir;
use crate::sphere::vector::{dot, length, sub, tangents};

/// The most steps. From within a grid cell of a maximum some 8 are usual; a flat ridge may take several times as many.
const STEPS: usize = 200;

/// The gradient at which the ascent has converged, relative to the largest that the bands' energies allow: ten times
/// its rounding.
const FLAT: f64 = 1e-13;

/// The longest step as a fraction of the shortest wavelength `2π/(n-1)`, so that the ascent stays on its hill.
const LONGEST_STEP: f64 = 0.1;

/// The distance at which a point is compared with its surroundings to tell a maximum from a saddle, as a fraction of
/// the wavelength.
const LOOK_AROUND: f64 = 1e-4;

/// A function on the sphere with the scales that its ascent needs.
///
/// [Sloan 2008] minimizes `-f(x/|x|)` over all of space by BFGS, so that the search may leave the sphere; the gradient
/// is that on the sphere times the Jacobian of normalization,
///
/// ```text
///   ∂(x/|x|)/∂x = (1 - s sᵀ)/|x|        s = x/|x|
///       diagonal (|x|² - x²)/|x|³, off the diagonal -xy/|x|³ (printed with |x| in place of its cube)
/// ```
///
/// Here every step begins on the sphere, `|x| = 1`, where that Jacobian projects to the tangent plane; the gradient of
/// [`eval_with_gradient`] is tangent already.
///
/// [Sloan 2008]: https://www.ppsloan.org/publications/StupidSH36.pdf
pub(crate) struct BfgsAscent<'a> {
    f: &'a ShVec<f64>,
    /// `Σ_l √((2l+1)/4π) ‖f_l‖` from band 1 on: no value differs from the mean by more.
    height: f64,
    /// `Σ_l √((2l+1)/4π l(l+1)) ‖f_l‖`: no gradient is longer.
    steepness: f64,
    wavelength: f64,
}

impl<'a> BfgsAscent<'a> {
    /// `None` for a function that is constant to rounding, or has coefficients that are not finite.
    pub(crate) fn new(f: &'a ShVec<f64>) -> Option<Self> {
        let (mut height, mut steepness) = (0.0, 0.0);
        for (l, energy) in f.band_energies().iter().enumerate().skip(1) {
            // Cauchy and Schwarz with Σ_m y_lm² = (2l+1)/4π and Σ_m |∇y_lm|² = l(l+1)(2l+1)/4π.
            let bound = (energy * (2 * l + 1) as f64 / (4.0 * core::f64::consts::PI)).sqrt();
            height += bound;
            steepness += bound * ((l * (l + 1)) as f64).sqrt();
        }
        let finite = height.is_finite() && steepness.is_finite() && f.mean().is_finite();
        let wavelength = 2.0 * core::f64::consts::PI / (f.order().max(2) - 1) as f64;
        (finite && height > f64::EPSILON * f.mean().abs()).then_some(Self { f, height, steepness, wavelength })
    }

    /// The distance below which two maxima count as one.
    pub(crate) fn resolution(&self) -> f64 {
        10.0 * LOOK_AROUND * self.wavelength
    }

    /// The maximum that the ascent from `start` reaches, and its value.
    pub(crate) fn ascend(&self, start: Dir) -> (Dir, f64) {
        let (mut at, mut value) = self.ascend_by_bfgs(start);
        // Leave a saddle towards a higher point beside it.
        while let Some(higher) = self.higher_nearby(at, value) {
            let (next, next_value) = self.ascend_by_bfgs(higher);
            if next_value <= value {
                break;
            }
            (at, value) = (next, next_value);
        }
        (at, value)
    }

    /// A point close by that is higher by more than rounding.
    fn higher_nearby(&self, at: Dir, value: f64) -> Option<Dir> {
        let [u, v] = tangents(at.to_array());
        let radius = LOOK_AROUND * self.wavelength;
        let around = (0..8).map(|k| {
            let (sin, cos) = (core::f64::consts::PI * f64::from(k) / 4.0).sin_cos();
            stepped(at, [0, 1, 2].map(|i| radius * (cos * u[i] + sin * v[i])))
        });
        let rounding = 64.0 * f64::EPSILON * (self.height + self.f.mean().abs());
        let best = around.map(|s| (s, self.f.eval(s))).max_by(|a, b| a.1.total_cmp(&b.1));
        best.filter(|(_, higher)| *higher > value + rounding).map(|(s, _)| s)
    }

    /// Ascends by BFGS, which builds the inverse Hessian of `-f` in the tangent plane from the changes of the gradient.
    fn ascend_by_bfgs(&self, start: Dir) -> (Dir, f64) {
        let mut at = start;
        let (mut value, mut gradient) = eval_with_gradient(self.f, at);
        // Begin with the inverse of the largest possible curvature: the steepest slope times the highest degree.
        let first = self.wavelength / (2.0 * core::f64::consts::PI * self.steepness);
        let mut inverse = scaled_identity(first);
        for _ in 0..STEPS {
            if length(gradient) <= FLAT * self.steepness {
                break;
            }
            // Take the quasi-Newton step, or steepest ascent where that does not ascend.
            let mut step = tangent(at, multiply(&inverse, gradient));
            if dot(step, gradient) <= 0.0 {
                inverse = scaled_identity(first);
                step = gradient.map(|g| first * g);
            }
            // Keep the step short against the wavelength, and search along it.
            let longest = LONGEST_STEP * self.wavelength;
            let shrink = (longest / length(step)).min(1.0);
            let step = step.map(|c| c * shrink);
            let Some((next, next_value, next_gradient, taken)) = self.line_search(at, value, gradient, step) else {
                break;
            };
            // Update the inverse Hessian by the change of the gradient.
            let change = tangent(next, sub(gradient, next_gradient));
            inverse = updated(&inverse, tangent(next, taken), change).unwrap_or(inverse);
            (at, value, gradient) = (next, next_value, next_gradient);
        }
        (at, value)
    }

    /// Halves the step until the function rises or, where rounding hides a rise, the gradient becomes shorter.
    fn line_search(
        &self,
        at: Dir,
        value: f64,
        gradient: [f64; 3],
        mut step: [f64; 3],
    ) -> Option<(Dir, f64, [f64; 3], [f64; 3])> {
        let rounding = 16.0 * f64::EPSILON * (self.height + self.f.mean().abs());
        for _ in 0..30 {
            let next = stepped(at, step);
            let (next_value, next_gradient) = eval_with_gradient(self.f, next);
            let risen = next_value > value + 1e-4 * dot(step, gradient) + rounding;
            let flatter = next_value > value - rounding && length(next_gradient) < length(gradient);
            if risen || flatter {
                return Some((next, next_value, next_gradient, step));
            }
            step = step.map(|c| 0.5 * c);
        }
        None
    }
}

/// The BFGS update of the inverse Hessian after a step `s` changed the gradient by `y`; `None` where the function is
/// not concave along the step.
///
/// ```text
///   H ← (1 - s yᵀ/yᵀs) H (1 - y sᵀ/yᵀs) + s sᵀ/yᵀs
/// ```
fn updated(inverse: &[[f64; 3]; 3], s: [f64; 3], y: [f64; 3]) -> Option<[[f64; 3]; 3]> {
    let curvature = dot(s, y);
    if curvature <= f64::EPSILON * length(s) * length(y) {
        return None;
    }
    let hy = multiply(inverse, y);
    let scale = (1.0 + dot(y, hy) / curvature) / curvature;
    Some(
        [0, 1, 2].map(|i| {
            [0, 1, 2].map(|j| inverse[i][j] - (hy[i] * s[j] + s[i] * hy[j]) / curvature + scale * s[i] * s[j])
        }),
    )
}

/// The direction of `s + step`, for a tangent step.
pub(crate) fn stepped(s: Dir, step: [f64; 3]) -> Dir {
    let s = s.to_array();
    Dir::new([0, 1, 2].map(|k| s[k] + step[k])).unwrap_or_else(|| unreachable!("a tangent does not cancel its foot"))
}

fn scaled_identity(scale: f64) -> [[f64; 3]; 3] {
    [[scale, 0.0, 0.0], [0.0, scale, 0.0], [0.0, 0.0, scale]]
}

fn tangent(s: Dir, v: [f64; 3]) -> [f64; 3] {
    let s = s.to_array();
    let along = dot(s, v);
    [0, 1, 2].map(|k| v[k] - along * s[k])
}

fn multiply(m: &[[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
    m.map(|row| dot(row, v))
}
