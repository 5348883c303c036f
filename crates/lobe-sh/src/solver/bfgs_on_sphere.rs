//! The way uphill from a point to a maximum of a function on the sphere.

use crate::sphere::vector::{difference, dot, length, tangents};
use crate::{Dir, Expansion, ShVec, eval_with_gradient};

/// Steps allowed. A start within a grid cell of a maximum needs some 8; a flat ridge may take several times as many.
const STEPS: usize = 200;

/// The gradient, over the largest that the bands' energies allow, at which a maximum is found: ten times its rounding.
const FLAT: f64 = 1e-13;

/// A step never goes farther than this part of the shortest wavelength `2π/(n-1)`, so that the climb stays on its hill.
const LONGEST_STEP: f64 = 0.1;

/// Where a found point is compared with its surroundings to tell a maximum from a saddle, in parts of the wavelength.
const LOOK_AROUND: f64 = 1e-4;

/// A function on the sphere, ready to be climbed.
///
/// [Sloan 2008] minimizes `-f(x/|x|)` over all of space by BFGS, so that the search may leave the sphere; the gradient
/// is that on the sphere times the Jacobian of normalization,
///
/// ```text
///   ∂(x/|x|)/∂x = (1 - s sᵀ)/|x|        s = x/|x|
///       diagonal (|x|² - x²)/|x|³, off the diagonal -xy/|x|³ (printed with |x| in place of its cube)
/// ```
///
/// Here every step begins on the sphere, `|x| = 1`, in the tangent plane, to which that Jacobian projects; the gradient
/// of [`eval_with_gradient`] is projected already.
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
            let bound = (energy * (2 * l + 1) as f64 / (4.0 * std::f64::consts::PI)).sqrt();
            height += bound;
            steepness += bound * ((l * (l + 1)) as f64).sqrt();
        }
        let finite = height.is_finite() && steepness.is_finite() && f.mean().is_finite();
        let wavelength = 2.0 * std::f64::consts::PI / (f.order().max(2) - 1) as f64;
        (finite && height > f64::EPSILON * f.mean().abs()).then_some(Self { f, height, steepness, wavelength })
    }

    /// The distance at which two found maxima are one.
    pub(crate) fn resolution(&self) -> f64 {
        10.0 * LOOK_AROUND * self.wavelength
    }

    /// The maximum uphill of `start`, and its value.
    pub(crate) fn ascend(&self, start: Dir) -> (Dir, f64) {
        let (mut at, mut value) = self.climb(start);
        // A saddle, or a start on one, is left sideways.
        while let Some(higher) = self.higher_nearby(at, value) {
            let (next, next_value) = self.climb(higher);
            if next_value <= value {
                break;
            }
            (at, value) = (next, next_value);
        }
        (at, value)
    }

    /// A point close by that is higher beyond doubt.
    fn higher_nearby(&self, at: Dir, value: f64) -> Option<Dir> {
        let [u, v] = tangents(at.to_array());
        let radius = LOOK_AROUND * self.wavelength;
        let around = (0..8).map(|k| {
            let (sin, cos) = (std::f64::consts::PI * f64::from(k) / 4.0).sin_cos();
            stepped(at, [0, 1, 2].map(|i| radius * (cos * u[i] + sin * v[i])))
        });
        let doubt = 64.0 * f64::EPSILON * (self.height + self.f.mean().abs());
        let best = around.map(|s| (s, self.f.eval(s))).max_by(|a, b| a.1.total_cmp(&b.1));
        best.filter(|(_, higher)| *higher > value + doubt).map(|(s, _)| s)
    }

    /// BFGS: the inverse Hessian of `-f` in the tangent plane is learned from the changes of the gradient.
    fn climb(&self, start: Dir) -> (Dir, f64) {
        let mut at = start;
        let (mut value, mut gradient) = eval_with_gradient(self.f, at);
        // The curvature is at most steepness times the highest degree.
        let first = self.wavelength / (2.0 * std::f64::consts::PI * self.steepness);
        let mut inverse = scaled_identity(first);
        for _ in 0..STEPS {
            if length(gradient) <= FLAT * self.steepness {
                break;
            }
            let mut step = tangent(at, multiply(&inverse, gradient));
            if dot(step, gradient) <= 0.0 {
                inverse = scaled_identity(first);
                step = gradient.map(|g| first * g);
            }
            let longest = LONGEST_STEP * self.wavelength;
            let shrink = (longest / length(step)).min(1.0);
            let step = step.map(|c| c * shrink);
            let Some((next, next_value, next_gradient, taken)) = self.line_search(at, value, gradient, step) else {
                break;
            };
            let change = tangent(next, difference(gradient, next_gradient));
            inverse = updated(&inverse, tangent(next, taken), change).unwrap_or(inverse);
            (at, value, gradient) = (next, next_value, next_gradient);
        }
        (at, value)
    }

    /// Halves the step until the function rises, or, where its rounding hides that, the gradient falls.
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

/// Broyden, Fletcher, Goldfarb, Shanno: the inverse Hessian after a step `s` changed the gradient by `y`; `None` where
/// the function is not curved the right way along the step.
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
