//! Refinement of directions and intensities together: variable projection with Levenberg-Marquardt steps.

use crate::basis::eval_basis;
use crate::expansion::Expansion as _;
use crate::expansion::gradient::eval_basis_gradients;
use crate::light_extraction::light_fit::LightFit;
use crate::light_extraction::light_fit::{LightEquations, LightProblem, total};
use crate::prelude::*;
use crate::scalar::Coefficient;
use crate::solver::bfgs_on_sphere::stepped;
use crate::solver::cholesky::Cholesky;
use crate::solver::matrix::{Matrix, add_scaled, dot, largest, norm};
use crate::sphere::Dir;
use crate::sphere::vector::{self, tangents};

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
        let equations = linearized(problem, &fit);
        let Some((next, step)) = damped_step(problem, &fit, &equations, &mut damping) else { break };
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
    equations: &StepEquations,
    damping: &mut f64,
) -> Option<(LightFit<T::Wide>, f64)> {
    if equations.floor == 0.0 {
        return None;
    }
    while *damping < MOST_DAMPING {
        if let Some((moved, length)) = equations.step(*damping) {
            let next = problem.solve(&moved);
            if total(next.residual) < total(fit.residual) {
                *damping /= DAMPING_FACTOR;
                return Some((next, length));
            }
        }
        *damping *= DAMPING_FACTOR;
    }
    None
}

/// The equations of the next step.
fn linearized<T: Coefficient>(problem: &LightProblem<T>, fit: &LightFit<T::Wide>) -> StepEquations {
    let left = problem.residual_of(fit);
    let channel = |c: usize| Channel {
        left: left.coefficients().iter().map(|x| x.channel(c)).collect(),
        intensities: fit.lights.iter().map(|light| light.intensity.channel(c)).collect(),
        ambient: fit.ambient.channel(c),
    };
    let channels: Vec<Channel> = (0..T::CHANNELS).map(channel).collect();
    StepEquations::new(&problem.equations, fit.lights.iter().map(|light| light.dir).collect(), &channels)
}

/// One channel of a fit: what it leaves of the expansion, and its unknowns.
struct Channel {
    left: Vec<f64>,
    intensities: Vec<f64>,
    ambient: f64,
}

/// The equations of a step from `dirs`. Not generic, so that their solver is compiled in this crate alone.
struct StepEquations {
    dirs: Vec<Dir>,
    /// `JᵀJ`.
    normal: Matrix,
    /// `-Jᵀr`.
    right: Vec<f64>,
    /// Added to the diagonal: a light of zero intensity does not move, but its element must not be zero.
    floor: f64,
    /// The longest step, in radians.
    longest: f64,
}

impl StepEquations {
    fn new(equations: &LightEquations, dirs: Vec<Dir>, channels: &[Channel]) -> Self {
        let (jacobian, residual) = jacobian_and_residual(equations, &dirs, channels);
        let count = jacobian.columns();
        let normal = Matrix::from_fn(count, count, |i, j| dot(jacobian.column(i), jacobian.column(j)));
        let right = jacobian.transposed_times(&residual).into_iter().map(|x| -x).collect();
        let floor = (0..count).map(|k| normal[(k, k)]).fold(0.0, f64::max) * f64::EPSILON;
        let longest = LONGEST_STEP * 2.0 * core::f64::consts::PI / (equations.order() - 1) as f64;
        Self { dirs, normal, right, floor, longest }
    }

    /// The directions after a step of this damping, and its length; `None` if rounding leaves no solution.
    fn step(&self, damping: f64) -> Option<(Vec<Dir>, f64)> {
        let mut damped = self.normal.clone();
        for k in 0..damped.rows() {
            damped[(k, k)] += damping * self.normal[(k, k)] + self.floor;
        }
        let step = Cholesky::new(damped)?.solve(&self.right);
        let longest_part = largest(&step);
        let scale = if longest_part > self.longest { self.longest / longest_part } else { 1.0 };
        let moved = self.dirs.iter().enumerate().map(|(k, dir)| {
            let [u, v] = tangents(dir.to_array());
            stepped(*dir, [0, 1, 2].map(|i| scale * (step[2 * k] * u[i] + step[2 * k + 1] * v[i])))
        });
        Some((moved.collect(), scale * longest_part))
    }
}

/// The projected Jacobian and the residual, all channels.
fn jacobian_and_residual(equations: &LightEquations, dirs: &[Dir], channels: &[Channel]) -> (Matrix, Vec<f64>) {
    let order = equations.order();
    let rows = order * order;
    let weights: Vec<f64> = equations.coefficient_weights().map(f64::sqrt).collect();
    let lights: Vec<Vec<f64>> = dirs.iter().map(|dir| eval_basis(*dir, order)).collect();
    let slopes: Vec<Vec<[f64; 3]>> = dirs.iter().map(|dir| eval_basis_gradients(*dir, order)).collect();
    let mut jacobian = Matrix::zeros(rows * channels.len(), 2 * lights.len());
    let mut residual = vec![0.0; rows * channels.len()];
    for (c, channel) in channels.iter().enumerate() {
        for i in 0..rows {
            residual[c * rows + i] = weights[i] * channel.left[i];
        }
        // Intensities at zero stay there during this step; only the others adapt to a turn.
        let active = (0..lights.len()).filter(|k| channel.intensities[*k] != 0.0);
        let mut span: Vec<Vec<f64>> =
            active.map(|k| weights.iter().zip(&lights[k]).map(|(w, y)| w * y).collect()).collect();
        if channel.ambient != 0.0 || !equations.non_negative {
            span.push((0..rows).map(|i| if i == 0 { weights[0] } else { 0.0 }).collect());
        }
        orthonormalize(&mut span);
        for (k, dir) in dirs.iter().enumerate() {
            let scale = -equations.normalization * channel.intensities[k];
            for (side, t) in tangents(dir.to_array()).into_iter().enumerate() {
                let column = &mut jacobian.column_mut(2 * k + side)[c * rows..(c + 1) * rows];
                for (i, entry) in column.iter_mut().enumerate() {
                    *entry = scale * weights[i] * vector::dot(slopes[k][i], t);
                }
                for q in &span {
                    let part = dot(q, column);
                    add_scaled(column, q, -part);
                }
            }
        }
    }
    (jacobian, residual)
}

/// Gram-Schmidt orthogonalization, twice for each vector; vectors that depend on those before are dropped.
fn orthonormalize(span: &mut Vec<Vec<f64>>) {
    let mut basis: Vec<Vec<f64>> = Vec::with_capacity(span.len());
    for mut v in span.drain(..) {
        let length = norm(&v);
        for _ in 0..2 {
            for q in &basis {
                let part = dot(q, &v);
                add_scaled(&mut v, q, -part);
            }
        }
        let left = norm(&v);
        if left > DEPENDENT * length {
            v.iter_mut().for_each(|v| *v /= left);
            basis.push(v);
        }
    }
    *span = basis;
}
