//! Gradients on the sphere.

use alloc::vec::Vec;

use crate::basis::basis::Basis;
use crate::basis::index::{coefficient_count, coefficient_index, order_of_slice};
use crate::basis::recurrence::Step;
use crate::by_type::{by_type, of_each_type};
use crate::expansion::Expansion;
use crate::scalar::{Coefficient, Real};
use crate::sphere::Dir;

impl<S: Real> Basis<S> {
    /// Calls `emit(i, y_i(s), ∇y_i(s))` once for every basis function of `order`.
    ///
    /// ```text
    ///   y = Q(z) C_m(x, y)        ∂y = (m Q C_{m-1}, -m Q S_{m-1}, Q' C_m)        for m >= 0
    ///   y = Q(z) S_m(x, y)        ∂y = (m Q S_{m-1},  m Q C_{m-1}, Q' S_m)        for -m < 0
    ///   ∇y = ∂y - (∂y · s) s
    /// ```
    ///
    /// `Q` is the column of [`Basis`] and `Q'` its derivative, by the differentiated recurrence. The last line
    /// removes the part along `s`, which depends on how `y` is continued off the sphere. Nothing divides by
    /// `sin θ`, so the poles need no special case.
    fn for_each_gradient(&self, s: [S; 3], order: usize, mut emit: impl FnMut(usize, S, [S; 3])) {
        let [x, y, z] = s;
        let mut emit_tangent = |i: usize, value: S, d: [S; 3]| {
            let along = d[0] * x + d[1] * y + d[2] * z;
            emit(i, value, [d[0] - along * x, d[1] - along * y, d[2] - along * z]);
        };
        let (mut cos, mut sin) = (S::ONE, S::ZERO);
        let (mut cos_before, mut sin_before) = (S::ZERO, S::ZERO);
        for m in 0..order {
            let mf = S::from_f64(m as f64);
            let (mut q_before, mut q) = (S::ZERO, self.diagonal(m));
            let (mut slope_before, mut slope) = (S::ZERO, S::ZERO);
            for l in m..order {
                let mq = mf * q;
                emit_tangent(
                    coefficient_index(l, m as isize),
                    q * cos,
                    [mq * cos_before, -(mq * sin_before), slope * cos],
                );
                if m > 0 {
                    let d = [mq * sin_before, mq * cos_before, slope * sin];
                    emit_tangent(coefficient_index(l, -(m as isize)), q * sin, d);
                }
                if l + 1 < order {
                    let Step { a, b, .. } = self.recurrence(m, l + 1);
                    (slope_before, slope) = (slope, a * (q + z * slope) - b * slope_before);
                    (q_before, q) = (q, a * z * q - b * q_before);
                }
            }
            (cos_before, sin_before) = (cos, sin);
            (cos, sin) = (x * cos - y * sin, x * sin + y * cos);
        }
    }
}

/// The gradients on the sphere of the basis functions of bands `0..order` at `s`: tangent vectors, in index order.
///
/// A step of angle `ε` along the unit tangent `t` changes `y_i` by `ε t · ∇y_i`.
#[must_use]
pub fn eval_basis_gradients(s: Dir, order: usize) -> Vec<[f64; 3]> {
    let mut out = vec![[0.0; 3]; coefficient_count(order)];
    Basis::<f64>::with_shared(order, |basis| {
        basis.for_each_gradient(s.to_array(), order, |i, _, gradient| out[i] = gradient);
    });
    out
}

/// The value of an expansion at `s` and its gradient on the sphere, as the three components of a tangent vector.
#[must_use]
pub fn eval_with_gradient<T: Coefficient>(f: &impl Expansion<T>, s: Dir) -> (T, [T; 3]) {
    let mut sums = [T::ZERO; 4];
    let (coefficients, out) = (f.coefficients(), &mut sums[..]);
    by_type!(T: coefficients; mut out => eval_with_gradient(coefficients, s, out));
    let [value, gradient @ ..] = sums;
    (value, gradient)
}

of_each_type! {
    /// To `[value, gradient]`.
    pub(super) fn eval_with_gradient(coefficients: &[T], s: Dir, out: &mut [T]) {
        let order = order_of_slice(coefficients);
        let mut sums = [<T as Coefficient>::Wide::ZERO; 4];
        Basis::<f64>::with_shared(order, |basis| {
            basis.for_each_gradient(s.to_array(), order, |i, y, [dx, dy, dz]| {
                let c = coefficients[i].widen();
                for (sum, factor) in sums.iter_mut().zip([y, dx, dy, dz]) {
                    *sum += c.scale(factor);
                }
            });
        });
        for (out, sum) in out.iter_mut().zip(sums) {
            *out = T::narrow(sum);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::basis::eval_basis;
    use crate::basis::index::band_and_m;
    use crate::expansion::ShVec;
    use crate::sphere::quadrature::SphereQuadrature;
    use crate::sphere::vector::tangents;
    use lobe_testkit::directions;

    #[test]
    fn gradients_equal_finite_differences_at_the_poles_too() {
        // Central differences of fourth order: the step balances truncation against rounding at band 7.
        let step = 1e-3;
        for v in directions() {
            let s = Dir::from_unit(v);
            let gradients = eval_basis_gradients(s, 8);
            for t in tangents(v) {
                let at = |angle: f64| {
                    let (sin, cos) = angle.sin_cos();
                    eval_basis(Dir::from_unit([0, 1, 2].map(|k| cos * v[k] + sin * t[k])), 8)
                };
                let [a, b, c, d] = [-2.0, -1.0, 1.0, 2.0].map(|k| at(k * step));
                for i in 0..64 {
                    let difference = (a[i] - 8.0 * b[i] + 8.0 * c[i] - d[i]) / (12.0 * step);
                    let slope: f64 = (0..3).map(|k| gradients[i][k] * t[k]).sum();
                    assert!((slope - difference).abs() < 1e-8, "∇y_{i} at {v:?}: {slope} against {difference}");
                }
            }
        }
    }

    #[test]
    fn gradients_are_tangent() {
        for v in directions() {
            for (i, g) in eval_basis_gradients(Dir::from_unit(v), 20).iter().enumerate() {
                let along: f64 = (0..3).map(|k| g[k] * v[k]).sum();
                assert!(along.abs() < 1e-12, "∇y_{i} at {v:?} has {along} along it");
            }
        }
    }

    #[test]
    fn gradient_energies_are_the_eigenvalues_of_the_laplacian() {
        // ∫ ∇y_i · ∇y_j ds = l(l+1) δ_ij
        let order = 6;
        let rule = SphereQuadrature::of_degree(2 * order);
        let mut gram = vec![0.0; 36 * 36];
        for (s, weight) in rule.points() {
            let g = eval_basis_gradients(s, order);
            for i in 0..36 {
                for j in 0..36 {
                    gram[36 * i + j] += weight * (0..3).map(|k| g[i][k] * g[j][k]).sum::<f64>();
                }
            }
        }
        for i in 0..36 {
            for j in 0..36 {
                let l = band_and_m(i).0 as f64;
                let expected = if i == j { l * (l + 1.0) } else { 0.0 };
                let found = gram[36 * i + j];
                assert!((found - expected).abs() < 1e-12, "⟨∇y_{i}, ∇y_{j}⟩: {found} against {expected}");
            }
        }
    }

    #[test]
    fn an_expansion_sums_the_gradients_of_its_terms() {
        let f = ShVec::from_vec(lobe_testkit::Random::new(4).signed_vec(49)).unwrap();
        for v in directions() {
            let s = Dir::from_unit(v);
            let (value, gradient) = eval_with_gradient(&f, s);
            assert!((value - f.eval(s)).abs() < 1e-12, "at {v:?}: {value} against {}", f.eval(s));
            for k in 0..3 {
                let gradients = eval_basis_gradients(s, 7);
                let sum: f64 = gradients.iter().zip(f.coefficients()).map(|(g, c)| g[k] * c).sum();
                assert!((gradient[k] - sum).abs() < 1e-11, "at {v:?}, component {k}: {} against {sum}", gradient[k]);
            }
        }
    }
}
