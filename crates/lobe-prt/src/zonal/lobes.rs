//! Linear least squares of zonal lobes with given axes, and the gradient of its cost by the axes (variable projection).

use std::f64::consts::PI;

use lobe_sh::basis::{band_range, eval_basis_into};
use lobe_sh::expansion::eval_with_gradient;
use lobe_sh::sphere::vector::dot_slices as dot;
use lobe_sh::{Dir, Expansion as _, ShVec};

/// The most lobes.
pub(crate) const MOST: usize = 8;

/// Tikhonov damping: the weight of squared coefficients over that of squared error. Where axes meet or are opposite,
/// coefficients would grow without bound; this bounds them, and changes those of a single lobe by less than their
/// rounding to `f32`.
const DAMPING: f64 = 1e-9;

/// Axes and, for each of them, coefficients channel by channel, band by band.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Lobes {
    pub(crate) axes: Vec<Dir>,
    pub(crate) coefficients: Vec<f64>,
    /// The squared error plus the damping.
    pub(crate) cost: f64,
}

/// A function in one or three channels, of squared norm 1 or 0, to be approximated by lobes that share their axes.
///
/// ```text
///   f_lm ≈ Σ_k z_kl u_lm(d_k)        u_lm(d) = √(4π/(2l+1)) y_lm(d)        u_l(d)·u_l(e) = P_l(d·e)
/// ```
///
/// For given axes the bands and channels are separate linear least-squares problems in the `z_kl`. With these
/// eliminated only the axes are left (variable projection, Golub and Pereyra 1973); the derivative by an axis is that
/// with the `z` kept,
///
/// ```text
///   ∂|r|²/∂d_k = -2 Σ_lm z_kl r_lm ∇u_lm(d_k)        r = f - Σ_k z_k u(d_k)
/// ```
pub(crate) struct LobeProblem {
    order: usize,
    channels: usize,
    f: Vec<f64>,
    /// `√(4π/(2l+1))`.
    factors: Vec<f64>,
    lobes: Vec<f64>,
    pub(crate) residual: Vec<f64>,
    slope: ShVec<f64>,
}

impl LobeProblem {
    pub(crate) fn new(order: usize, channels: usize) -> Self {
        let n = order * order;
        Self {
            order,
            channels,
            f: vec![0.0; n * channels],
            factors: (0..order).map(|l| (4.0 * PI / (2 * l + 1) as f64).sqrt()).collect(),
            lobes: Vec::new(),
            residual: vec![0.0; n * channels],
            slope: ShVec::zero(order),
        }
    }

    /// Takes on another function; returns its squared norm, by which it is divided.
    pub(crate) fn set(&mut self, f: &[f32]) -> f64 {
        let energy: f64 = f.iter().map(|f| f64::from(*f).powi(2)).sum();
        let scale = if energy > 0.0 { energy.sqrt().recip() } else { 0.0 };
        self.f.iter_mut().zip(f).for_each(|(out, f)| *out = scale * f64::from(*f));
        energy
    }

    /// The coefficients of least squares for these axes; leaves the residual behind.
    pub(crate) fn solve(&mut self, axes: &[Dir]) -> Lobes {
        let (n, order) = (self.order * self.order, self.order);
        debug_assert!(axes.len() <= MOST, "at most {MOST} lobes");
        // Evaluate the unit lobes along the axes.
        self.lobes.resize(axes.len() * n, 0.0);
        for (axis, u) in axes.iter().zip(self.lobes.chunks_exact_mut(n)) {
            eval_basis_into(axis.to_array(), u);
            for (l, factor) in self.factors.iter().enumerate() {
                u[band_range(l)].iter_mut().for_each(|u| *u *= factor);
            }
        }
        self.residual.copy_from_slice(&self.f);
        let mut coefficients = vec![0.0; axes.len() * self.channels * order];
        let mut cost = 0.0;
        for l in 0..order {
            let range = band_range(l);
            let part = |k: usize| &self.lobes[k * n..][range.clone()];
            // Set up and factorize the damped normal equations of the band.
            let mut gram = [[0.0; MOST]; MOST];
            for i in 0..axes.len() {
                for j in 0..=i {
                    gram[i][j] = dot(part(i), part(j)) + if i == j { DAMPING } else { 0.0 };
                }
            }
            factorize(&mut gram, axes.len());
            for c in 0..self.channels {
                // Solve them for each channel.
                let f = &self.f[c * n..][range.clone()];
                let mut z = [0.0; MOST];
                for k in 0..axes.len() {
                    z[k] = dot(part(k), f);
                }
                substitute(&gram, &mut z, axes.len());
                // Subtract the lobes from the residual.
                let residual = &mut self.residual[c * n..][range.clone()];
                for (k, z) in z[..axes.len()].iter().enumerate() {
                    residual.iter_mut().zip(&self.lobes[k * n..][range.clone()]).for_each(|(r, u)| *r -= z * u);
                    coefficients[(k * self.channels + c) * order + l] = *z;
                    cost += DAMPING * z * z;
                }
            }
        }
        cost += dot(&self.residual, &self.residual);
        Lobes { axes: axes.to_vec(), coefficients, cost }
    }

    /// The derivative of the cost by axis `k`, a tangent vector there, for the lobes that [`LobeProblem::solve`] has
    /// just found.
    pub(crate) fn slope(&mut self, lobes: &Lobes, k: usize) -> [f64; 3] {
        let n = self.order * self.order;
        for l in 0..self.order {
            for i in band_range(l) {
                let along =
                    |c: usize| lobes.coefficients[(k * self.channels + c) * self.order + l] * self.residual[c * n + i];
                self.slope.coefficients_mut()[i] = -2.0 * self.factors[l] * (0..self.channels).map(along).sum::<f64>();
            }
        }
        eval_with_gradient(&self.slope, lobes.axes[k]).1
    }

    /// The squared residual that a further lobe along `u`, the vector of a direction, could explain if it were
    /// orthogonal to the others.
    pub(crate) fn gain(&self, u: &[f64]) -> f64 {
        let n = self.order * self.order;
        let band = |l: usize, c: usize| dot(&u[band_range(l)], &self.residual[c * n..][band_range(l)]).powi(2);
        (0..self.order).map(|l| (0..self.channels).map(|c| band(l, c)).sum::<f64>()).sum()
    }
}

/// `u(d)`, see [`LobeProblem`].
pub(crate) fn unit_lobe(d: Dir, order: usize) -> Vec<f64> {
    let mut u = vec![0.0; order * order];
    eval_basis_into(d.to_array(), &mut u);
    for l in 0..order {
        let factor = (4.0 * PI / (2 * l + 1) as f64).sqrt();
        u[band_range(l)].iter_mut().for_each(|u| *u *= factor);
    }
    u
}

/// Cholesky's factor of the lower half, in its place.
fn factorize(m: &mut [[f64; MOST]; MOST], size: usize) {
    for i in 0..size {
        for j in 0..=i {
            let mut sum = m[i][j];
            for k in 0..j {
                sum -= m[i][k] * m[j][k];
            }
            // The damping keeps the pivots above zero but for rounding.
            m[i][j] = if i == j { sum.max(0.5 * DAMPING).sqrt() } else { sum / m[j][j] };
        }
    }
}

fn substitute(factor: &[[f64; MOST]; MOST], x: &mut [f64; MOST], size: usize) {
    for i in 0..size {
        for k in 0..i {
            x[i] -= factor[i][k] * x[k];
        }
        x[i] /= factor[i][i];
    }
    for i in (0..size).rev() {
        for k in i + 1..size {
            x[i] -= factor[k][i] * x[k];
        }
        x[i] /= factor[i][i];
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lobe_testkit::Random;

    #[test]
    fn the_slope_is_that_of_differences() {
        let mut random = Random::new(5);
        for (order, channels, count) in [(3, 1, 1), (4, 3, 2), (6, 1, 4), (2, 3, 3)] {
            let f: Vec<f32> = random.signed_vec(order * order * channels).iter().map(|x| *x as f32).collect();
            let axes: Vec<Dir> = (0..count).map(|_| Dir::from_unit(random.direction())).collect();
            let mut problem = LobeProblem::new(order, channels);
            problem.set(&f);
            let lobes = problem.solve(&axes);
            for k in 0..count {
                let slope = problem.slope(&lobes, k);
                let along = random.direction();
                let radial: f64 = (0..3).map(|i| along[i] * axes[k].to_array()[i]).sum();
                let step = 1e-5;
                let mut cost = |sign: f64| {
                    let mut moved = axes.clone();
                    moved[k] = Dir::new(
                        [0, 1, 2]
                            .map(|i| axes[k].to_array()[i] * (1.0 - sign * step * radial) + sign * step * along[i]),
                    )
                    .unwrap();
                    problem.solve(&moved).cost
                };
                let expected = (cost(1.0) - cost(-1.0)) / (2.0 * step);
                let found: f64 = (0..3).map(|i| slope[i] * along[i]).sum();
                assert!(
                    (found - expected).abs() < 1e-6,
                    "order {order}, axis {k} of {count}: {found} against {expected}"
                );
                problem.solve(&axes);
            }
        }
    }

    #[test]
    fn axes_that_meet_share_their_lobe() {
        let mut problem = LobeProblem::new(4, 1);
        let f: Vec<f32> = unit_lobe(Dir::X, 4).iter().map(|u| *u as f32).collect();
        problem.set(&f);
        for other in [Dir::X, -Dir::X] {
            let lobes = problem.solve(&[Dir::X, other]);
            assert!(lobes.cost < 1e-8, "{other:?}: {}", lobes.cost);
            assert!(lobes.coefficients.iter().all(|z| z.abs() < 1.0), "{:?}", lobes.coefficients);
        }
    }
}
