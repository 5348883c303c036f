//! BFGS: quasi-Newton minimization of a smooth function of a few variables.

use lobe_sh::sphere::vector::dot_slices as dot;

/// Halvings of a step before the search gives up.
const HALVINGS: usize = 30;

/// The part of the expected fall that a step must bring (Armijo).
const SUFFICIENT: f64 = 1e-4;

/// Minimizes from `x` by the method of Broyden, Fletcher, Goldfarb and Shanno; returns the value reached.
///
/// ```text
///   x ← x - t H g        H ← (1 - s yᵀ/yᵀs) H (1 - y sᵀ/yᵀs) + s sᵀ/yᵀs        s, y: changes of x and of g
/// ```
///
/// `value_and_gradient` writes the gradient at its argument and returns the value. The first `H` is `first` times the
/// identity, no step is longer than `longest`, and a value never rises. It ends after `steps` steps, or where neither
/// the gradient nor a step changes the value by more than `tolerance`.
pub(crate) fn minimize(
    x: &mut [f64],
    [first, longest, tolerance]: [f64; 3],
    steps: usize,
    mut value_and_gradient: impl FnMut(&[f64], &mut [f64]) -> f64,
) -> f64 {
    let n = x.len();
    let mut inverse = identity(n, first);
    let (mut g, mut next_g) = (vec![0.0; n], vec![0.0; n]);
    let (mut step, mut next, mut hy) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
    let mut value = value_and_gradient(x, &mut g);
    for _ in 0..steps {
        // Take the quasi-Newton direction, or steepest descent where that does not fall.
        multiply(&inverse, &g, &mut step);
        let mut fall = dot(&step, &g);
        if fall <= 0.0 {
            inverse = identity(n, first);
            step.iter_mut().zip(&g).for_each(|(s, g)| *s = first * g);
            fall = dot(&step, &g);
        }
        let mut t = -(longest / dot(&step, &step).sqrt()).min(1.0);
        // End where nothing is left to gain: the quadratic model falls by half of this over a whole step.
        if fall * -t <= tolerance {
            break;
        }
        // Backtrack until the value falls sufficiently (Armijo).
        let mut halvings = 0;
        let lower = loop {
            next.iter_mut().zip(x.iter().zip(&step)).for_each(|(next, (x, s))| *next = x + t * s);
            let lower = value_and_gradient(&next, &mut next_g);
            if lower <= value + SUFFICIENT * t * fall {
                break Some(lower);
            }
            halvings += 1;
            if halvings > HALVINGS {
                break None;
            }
            t *= 0.5;
        };
        let Some(lower) = lower else { break };
        // Update the inverse Hessian by the changes of position and gradient.
        step.iter_mut().for_each(|s| *s *= t);
        g.iter_mut().zip(&next_g).for_each(|(g, next)| *g = next - *g);
        learn(&mut inverse, &step, &g, &mut hy);
        x.copy_from_slice(&next);
        std::mem::swap(&mut g, &mut next_g);
        let fallen = value - lower;
        value = lower;
        if fallen <= tolerance {
            break;
        }
    }
    value
}

/// The update of the inverse Hessian, left out where the function is not curved the right way along the step.
fn learn(inverse: &mut [f64], s: &[f64], y: &[f64], hy: &mut [f64]) {
    let curvature = dot(s, y);
    if curvature <= f64::EPSILON * (dot(s, s) * dot(y, y)).sqrt() {
        return;
    }
    multiply(inverse, y, hy);
    let scale = (1.0 + dot(y, hy) / curvature) / curvature;
    for (i, row) in inverse.chunks_exact_mut(s.len()).enumerate() {
        for (j, h) in row.iter_mut().enumerate() {
            *h += scale * s[i] * s[j] - (hy[i] * s[j] + s[i] * hy[j]) / curvature;
        }
    }
}

fn identity(n: usize, scale: f64) -> Vec<f64> {
    let mut m = vec![0.0; n * n];
    m.iter_mut().step_by(n + 1).for_each(|d| *d = scale);
    m
}

fn multiply(m: &[f64], v: &[f64], out: &mut [f64]) {
    for (out, row) in out.iter_mut().zip(m.chunks_exact(v.len())) {
        *out = dot(row, v);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bottom_of_a_curved_valley_is_found() {
        // Rosenbrock's function: minimum 0 at (1, 1).
        let mut x = [-1.2, 1.0];
        let value = minimize(&mut x, [1e-3, 1.0, 1e-20], 200, |x, g| {
            let (a, b) = (1.0 - x[0], x[1] - x[0] * x[0]);
            g.copy_from_slice(&[-2.0 * a - 400.0 * x[0] * b, 200.0 * b]);
            a * a + 100.0 * b * b
        });
        assert!(value < 1e-16 && (x[0] - 1.0).abs() < 1e-7, "{value} at {x:?}");
    }

    #[test]
    fn a_flat_place_stays() {
        let mut x = [0.5];
        let value = minimize(&mut x, [1.0, 1.0, 1e-12], 10, |_, g| {
            g[0] = 0.0;
            3.0
        });
        assert_eq!((value, x), (3.0, [0.5]), "nothing to gain");
    }
}
