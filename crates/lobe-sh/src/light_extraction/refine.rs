//! Refinement of directions and intensities together: variable projection with Levenberg-Marquardt steps.

use nalgebra::{DMatrix, DVector};

use crate::light_extraction::light_fit::{LightProblem, total};
use crate::prelude::*;
use crate::solver::bfgs_on_sphere::stepped;
use crate::sphere::vector::{dot, tangents};
use crate::{Coefficient, Dir, Expansion as _, LightFit, eval_basis, eval_basis_gradients};

/// The most steps: well separated lights need some six, lights that drift together many.
const STEPS: usize = 60;

/// The step at which the refinement has converged, in radians.
const SHORTEST_STEP: f64 = 1e-13;

/// The longest step of a light as a fraction of the shortest wavelength.
const LONGEST_STEP: f64 = 0.1;

/// The first damping, relative to the diagonal: close to the Gauss-Newton step, which suits well separated lights.
const FIRST_DAMPING: f64 = 1e-3;

/// The factor by which a failed step raises the damping and a successful one lowers it.
const DAMPING_FACTOR: f64 = 10.0;

/// The damping at which the search for a step ends.
const MOST_DAMPING: f64 = 1e12;

/// A vector counts as dependent on those before if less than this fraction of its length is orthogonal to them: half of
/// the digits.
const DEPENDENT: f64 = 1e-8;

/// Moves the directions of a fit, intensities and ambient light with them, to a minimum of the residual.
///
/// Variable projection: the intensities are the least-squares solution for the current directions, so that only two
/// angles for each light remain. The Jacobian is that of the directions, projected to the complement of the lights
/// (Kaufman 1975), the step that of Levenberg and Marquardt:
///
/// ```text
///   r = w (f - Σ_k c_k L(d_k) - a L_a)        J = -(1 - QQᵀ) w c_k N ∇y(d_k)        Q spans w L(d_k), w L_a
///   (JᵀJ + μ diag JᵀJ) δ = -Jᵀr
/// ```
///
/// A step that does not lower the residual is not taken. Colors are fitted together, channel below channel.
pub(crate) fn refine<T: Coefficient>(problem: &LightProblem<T>, start: LightFit<T::Wide>) -> LightFit<T::Wide> {
    let mut fit = start;
    let mut damping = FIRST_DAMPING;
    for _ in 0..STEPS {
        if fit.lights.is_empty() || total(fit.residual) == 0.0 {
            break;
        }
        // Linearize, and take a damped step that lowers the residual.
        let (jacobian, residual) = linearized(problem, &fit);
        let normal = jacobian.transpose() * &jacobian;
        let right = -(jacobian.transpose() * residual);
        let Some((next, step)) = damped_step(problem, &fit, &normal, &right, &mut damping) else { break };
        fit = next;
        if step < SHORTEST_STEP {
            break;
        }
    }
    fit
}

/// Raises the damping until the step lowers the residual. The second value is the length of the step.
fn damped_step<T: Coefficient>(
    problem: &LightProblem<T>,
    fit: &LightFit<T::Wide>,
    normal: &DMatrix<f64>,
    right: &DVector<f64>,
    damping: &mut f64,
) -> Option<(LightFit<T::Wide>, f64)> {
    let longest = LONGEST_STEP * 2.0 * core::f64::consts::PI / (problem.order() - 1) as f64;
    // A light of zero intensity does not move, but its diagonal element must not be zero.
    let floor = normal.diagonal().amax() * f64::EPSILON;
    if floor == 0.0 {
        return None;
    }
    while *damping < MOST_DAMPING {
        let mut damped = normal.clone();
        for k in 0..damped.nrows() {
            damped[(k, k)] += *damping * normal[(k, k)] + floor;
        }
        if let Some(cholesky) = damped.cholesky() {
            let step = cholesky.solve(right);
            let longest_part = step.amax();
            let scale = if longest_part > longest { longest / longest_part } else { 1.0 };
            let moved = fit.lights.iter().enumerate().map(|(k, light)| {
                let [u, v] = tangents(light.dir.to_array());
                stepped(light.dir, [0, 1, 2].map(|i| scale * (step[2 * k] * u[i] + step[2 * k + 1] * v[i])))
            });
            let moved: Vec<Dir> = moved.collect();
            let next = problem.solve(&moved);
            if total(next.residual) < total(fit.residual) {
                *damping /= DAMPING_FACTOR;
                return Some((next, scale * longest_part));
            }
        }
        *damping *= DAMPING_FACTOR;
    }
    None
}

/// The projected Jacobian and the residual, all channels.
fn linearized<T: Coefficient>(problem: &LightProblem<T>, fit: &LightFit<T::Wide>) -> (DMatrix<f64>, DVector<f64>) {
    let order = problem.order();
    let rows = order * order;
    let weights: Vec<f64> = problem.coefficient_weights().map(f64::sqrt).collect();
    let left = problem.residual_of(fit);
    let lights: Vec<Vec<f64>> = fit.lights.iter().map(|light| eval_basis(light.dir, order)).collect();
    let slopes: Vec<Vec<[f64; 3]>> = fit.lights.iter().map(|light| eval_basis_gradients(light.dir, order)).collect();
    let mut jacobian = DMatrix::zeros(rows * T::CHANNELS, 2 * lights.len());
    let mut residual = DVector::zeros(rows * T::CHANNELS);
    for c in 0..T::CHANNELS {
        for i in 0..rows {
            residual[c * rows + i] = weights[i] * left.coefficients()[i].channel(c);
        }
        // Intensities at zero stay there during this step; only the others adapt to a turn.
        let active = (0..lights.len()).filter(|k| fit.lights[*k].intensity.channel(c) != 0.0);
        let mut span: Vec<DVector<f64>> =
            active.map(|k| DVector::from_fn(rows, |i, _| weights[i] * lights[k][i])).collect();
        if fit.ambient.channel(c) != 0.0 || !problem.non_negative {
            span.push(DVector::from_fn(rows, |i, _| if i == 0 { weights[0] } else { 0.0 }));
        }
        orthonormalize(&mut span);
        for (k, light) in fit.lights.iter().enumerate() {
            let scale = -problem.normalization * light.intensity.channel(c);
            for (side, t) in tangents(light.dir.to_array()).into_iter().enumerate() {
                let mut column = DVector::from_fn(rows, |i, _| scale * weights[i] * dot(slopes[k][i], t));
                for q in &span {
                    column -= q * q.dot(&column);
                }
                jacobian.view_mut((c * rows, 2 * k + side), (rows, 1)).copy_from(&column);
            }
        }
    }
    (jacobian, residual)
}

/// Gram-Schmidt orthogonalization, twice for each vector; vectors that depend on those before are dropped.
fn orthonormalize(span: &mut Vec<DVector<f64>>) {
    let mut basis: Vec<DVector<f64>> = Vec::with_capacity(span.len());
    for mut v in span.drain(..) {
        let length = v.norm();
        for _ in 0..2 {
            for q in &basis {
                v -= q * q.dot(&v);
            }
        }
        let left = v.norm();
        if left > DEPENDENT * length {
            basis.push(v / left);
        }
    }
    *span = basis;
}
