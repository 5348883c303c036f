//! The exact minimum of a quadratic form on the unit sphere.

#[cfg(not(feature = "std"))]
use num_traits::Float as _;

use crate::extrema::Extremum;
use crate::extrema::quadratic_form::{QuadraticForm, norms, times};
use crate::sphere::Dir;
use crate::sphere::vector::{dot, tangents, unit};

/// The most Newton steps for the multiplier. It rises monotonically and the digits double: 3 to 6 are usual.
const NEWTON_STEPS: usize = 64;

/// The relative step at which the multiplier has converged; the next step would be of the order of its square.
const CONVERGED: f64 = 1e-9;

/// The rounding error of a value of the form and of the remainder, some twenty operations each, relative to the largest
/// value: four times the largest error that the test `forms_are_evaluated_within_their_bound` finds.
const ROUNDING: f64 = 32.0 * f64::EPSILON;

/// The eigenvalues and eigenvectors of a [`QuadraticForm`].
///
/// # Derivation of the minimum
///
/// A minimum `x` on the sphere has a multiplier `ν` with `2 (A + ν) x + b = 0`, and it is the global one if and only if
/// `A + ν` has no negative eigenvalue: for any unit `y`, because `|x| = |y|`,
///
/// ```text
///   f(y) - f(x) = (y - x)ᵀ (A + ν) (y - x) + (2 (A + ν) x + b)·(y - x)                                    (1)
/// ```
///
/// In the eigenvectors of `A`, with `β_i` the parts of `b/2`, `d_i >= 0` the distances of the eigenvalues from the
/// lowest one and `t = ν + λ_1 >= 0`, the condition `|x| = 1` is
///
/// ```text
///   h(t) = (Σ_i β_i² / (d_i + t)²)^(-1/2) = 1        x_i = -β_i / (d_i + t)
/// ```
///
/// `h` is a power mean, of exponent -2, of rising lines, so it rises and is concave, and Newton's method from any point
/// left of the root rises towards it without passing it. As no `|x_i|` is above 1, `max |β_i| - d_i` is such a point.
/// If `h(0) >= 1`, `b` has no part along the lowest eigenvector, which then completes `x` at `t = 0` to a unit vector
/// (the hard case of the trust-region problem, and the usual one here: a sun's ring of minima).
///
/// Scaling the bands by `w_1, w_2` only changes the right side to `h(t/w_2) = w_1/w_2`, so that a search over windows
/// computes the eigenvectors once.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Eigensystem {
    /// The lowest eigenvalue.
    pub(crate) low: f64,
    /// The distances of the eigenvalues from the lowest, which comes first.
    pub(crate) distances: [f64; 3],
    /// The eigenvectors.
    axes: [[f64; 3]; 3],
    /// `b/2` along them.
    pub(crate) beta: [f64; 3],
}

impl QuadraticForm {
    /// The eigenvalues and eigenvectors. The eigenvalue farthest from the other two is the extreme root of a cubic, and
    /// well conditioned; a rotation in the plane perpendicular to its eigenvector gives the other two, however close
    /// they are.
    pub(crate) fn eigensystem(&self) -> Eigensystem {
        let isolated = self.isolated_eigenvalue();
        let axis = self.isolated_eigenvector(isolated);
        let [u, v] = tangents(axis);
        let au = times(&self.a, u);
        let (uu, uv) = (dot(u, au), dot(v, au));
        // tan 2φ = uv/half, with the smaller of the two angles; eigenvalues -isolated/2 ± root, the trace being 0.
        let half = -0.5 * isolated - uu;
        let root = (half * half + uv * uv).sqrt();
        let tan = if root > 0.0 { uv / (half.abs() + root) * half.signum() } else { 0.0 };
        let cos = 1.0 / (tan * tan + 1.0).sqrt();
        let sin = tan * cos;
        let mut pair = [[0, 1, 2].map(|k| cos * u[k] - sin * v[k]), [0, 1, 2].map(|k| sin * u[k] + cos * v[k])];
        if half < 0.0 {
            pair.swap(0, 1);
        }
        let (low, far) = (-0.5 * isolated - root, 1.5 * isolated.abs());
        if isolated < 0.0 {
            self.along([axis, pair[0], pair[1]], isolated, [0.0, far - root, far + root])
        } else {
            self.along([pair[0], pair[1], axis], low, [0.0, 2.0 * root, far + root])
        }
    }

    /// With `A = p B`, `tr B² = 6`, eigenvalues of `B` satisfy
    ///
    /// ```text
    ///   x³ - 3x - det B = 0        -2 <= det B <= 2
    /// ```
    ///
    /// and the one of the sign of `det B` lies between √3 and 2 in size. Newton's method from the parabola that has the
    /// value and slope at `det B = 0` and the value at 2, which errs by 3e-3: 7e-6, 4e-11, rounding.
    fn isolated_eigenvalue(&self) -> f64 {
        let p = 0.5 * self.form;
        if p == 0.0 {
            return 0.0;
        }
        let [xx, yy, zz, xy, xz, yz] = self.a;
        let determinant = xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz);
        let half = (0.5 * determinant.abs() / (p * p * p)).min(1.0);
        let root = norms()[4];
        let mut x = root + half * (1.0 / 3.0 + (2.0 - root - 1.0 / 3.0) * half);
        for _ in 0..3 {
            x -= (x * (x * x - 3.0) - 2.0 * half) / (3.0 * (x * x - 1.0));
        }
        (p * x).copysign(determinant)
    }

    /// The eigenvector of an eigenvalue apart from the others: a column of the adjugate of `A - λ`, the longest one.
    fn isolated_eigenvector(&self, isolated: f64) -> [f64; 3] {
        let [xx, yy, zz, xy, xz, yz] = self.a;
        let [xx, yy, zz] = [xx - isolated, yy - isolated, zz - isolated];
        let (dx, dy, dz) = (yy * zz - yz * yz, xx * zz - xz * xz, xx * yy - xy * xy);
        let (ex, ey, ez) = (xy * xz - yz * xx, xy * yz - xz * yy, xz * yz - xy * zz);
        if dx >= dy && dx >= dz {
            if dx > 0.0 { unit([dx, ez, ey]) } else { [1.0, 0.0, 0.0] }
        } else if dy >= dz {
            unit([ez, dy, ex])
        } else {
            unit([ey, ex, dz])
        }
    }

    /// The linear part along the eigenvectors; components within rounding become zero.
    fn along(&self, axes: [[f64; 3]; 3], low: f64, distances: [f64; 3]) -> Eigensystem {
        let rounding = f64::EPSILON * self.linear;
        let beta = axes.map(|axis| 0.5 * dot(axis, self.b)).map(|b| if b.abs() <= rounding { 0.0 } else { b });
        Eigensystem { low, distances, axes, beta }
    }

    /// The direction of the least value when bands 1 and 2 are scaled by `w`, both at least 0.
    #[inline]
    pub(crate) fn lowest(&self, eigensystem: &Eigensystem, w: [f64; 2]) -> [f64; 3] {
        // Ignore a form that changes no digit of the linear part.
        if w[1] * self.form <= 0.25 * f64::EPSILON * w[0] * self.linear {
            let linear = self.linear * w[0];
            return if linear > 0.0 { unit(self.b.map(|b| -b)) } else { [0.0, 0.0, 1.0] };
        }
        eigensystem.lowest(w[0] / w[1])
    }

    /// The minimum when bands 1 and 2 are scaled by `w`, certified by (1) of [`Eigensystem`]:
    ///
    /// ```text
    ///   f(y) >= f(x) - 2 |2 (A + ν) x + b|        for all y, if A + ν has no negative eigenvalue
    /// ```
    pub(crate) fn minimum(&self, w: [f64; 2]) -> Extremum {
        let x = self.lowest(&self.eigensystem(), w);
        let [c, linear, quadratic] = self.bands(x);
        let value = c + w[0] * linear + w[1] * quadratic;
        let rounding = ROUNDING * (c.abs() + self.amplitude(w));
        let b = self.b.map(|b| w[0] * b);
        let a = self.a.map(|a| w[1] * a);
        let ax = times(&a, x);
        // Take the multiplier of the least remainder, and raise it until A + ν is positive.
        let best = -0.5 * dot([0, 1, 2].map(|k| 2.0 * ax[k] + b[k]), x);
        let form = w[1] * self.form;
        let mut shift = ROUNDING * (form + best.abs());
        let mut nu = best + shift;
        while form > 0.0 && !is_positive(&a, nu) && shift < 4.0 * form {
            shift *= 8.0;
            nu = best + shift;
        }
        let remainder = [0, 1, 2].map(|k| 2.0 * (ax[k] + nu * x[k]) + b[k]);
        let lo = value - 2.0 * dot(remainder, remainder).sqrt() - rounding;
        Extremum { lo, hi: value + rounding, dir: Dir::from_unit(x) }
    }
}

impl Eigensystem {
    /// The direction of the least value when the linear part is scaled by `kappa` against the form.
    #[inline]
    fn lowest(&self, kappa: f64) -> [f64; 3] {
        let beta = self.beta.map(|b| kappa * b);
        let d = self.distances;
        let mut t = (beta[0].abs() - d[0]).max(beta[1].abs() - d[1]).max(beta[2].abs() - d[2]).max(0.0);
        let mut y = [0.0; 3];
        for step in 0..NEWTON_STEPS {
            let mut slope = 0.0;
            for k in 0..3 {
                let inverse = if beta[k] == 0.0 { 0.0 } else { 1.0 / (d[k] + t) };
                y[k] = -beta[k] * inverse;
                slope += y[k] * y[k] * inverse;
            }
            let square = dot(y, y);
            if square <= 1.0 {
                if step == 0 && t == 0.0 {
                    // The component along the lowest eigenvector is free; both signs give the same value.
                    y[0] += (1.0 - square).sqrt() * if y[0] < 0.0 { -1.0 } else { 1.0 };
                }
                break;
            }
            // t <- t + (|y| - 1) |y|²/(yᵀ (d + t)⁻¹ y)
            let rise = (square.sqrt() - 1.0) * square / slope;
            t += rise;
            if rise <= CONVERGED * t {
                for k in 0..3 {
                    y[k] = if beta[k] == 0.0 { 0.0 } else { -beta[k] / (d[k] + t) };
                }
                break;
            }
        }
        unit([0, 1, 2].map(|k| y[0] * self.axes[0][k] + y[1] * self.axes[1][k] + y[2] * self.axes[2][k]))
    }
}

/// Whether `A + ν` has no negative eigenvalue, by the pivots of its factorization `L D Lᵀ`, which is backward stable:
/// rounding acts like a change of `ν` by a few units in its last place.
fn is_positive(&[xx, yy, zz, xy, xz, yz]: &[f64; 6], nu: f64) -> bool {
    let d0 = xx + nu;
    if d0 <= 0.0 {
        return false;
    }
    let d1 = yy + nu - xy * xy / d0;
    if d1 <= 0.0 {
        return false;
    }
    let l = yz - xy * xz / d0;
    zz + nu - xz * xz / d0 - l * l / d1 >= 0.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expansion::{Expansion as _, ShL2, Zonal};
    use crate::sphere::vector::cross;
    use lobe_testkit::Random;

    /// `Σ p_k q_k r_k` as if rounded once: every product is split into its value and its rounding error.
    fn compensated(terms: &[[f64; 3]]) -> f64 {
        let (mut sum, mut lost) = (0.0_f64, 0.0_f64);
        let mut add = |x: f64| {
            let next = sum + x;
            lost += if sum.abs() >= x.abs() { (sum - next) + x } else { (x - next) + sum };
            sum = next;
        };
        for &[p, q, r] in terms {
            let product = p * q;
            for (part, r) in [(product, r), (p.mul_add(q, -product), r)] {
                let term = part * r;
                add(term);
                add(part.mul_add(r, -term));
            }
        }
        sum + lost
    }

    #[test]
    fn forms_are_evaluated_within_their_bound() {
        let mut random = Random::new(7);
        let mut worst = [0.0_f64; 2];
        for case in 0..20_000 {
            let mut f = random.signed_vec(9);
            // One band alone, and bands of unequal sizes.
            f[1..4].iter_mut().for_each(|c| *c *= [1.0, 1e-3, 0.0][case % 3]);
            f[4..].iter_mut().for_each(|c| *c *= [1.0, 0.0, 1e-3][case % 5 % 3]);
            let form = QuadraticForm::new(&f, 0);
            let x = random.direction();
            let [xx, yy, zz, xy, xz, yz] = form.a;
            let (b, nu) = (form.b, form.form * random.signed());
            let [p, q, r] = x;
            let quadratic = [[xx, p, p], [yy, q, q], [zz, r, r], [2.0 * xy, p, q], [2.0 * xz, p, r], [2.0 * yz, q, r]];
            let rest = [[form.c, 1.0, 1.0], [b[0], p, 1.0], [b[1], q, 1.0], [b[2], r, 1.0]];
            let exact = compensated(&[&quadratic[..], &rest[..]].concat());
            let amplitude = form.amplitude([1.0, 1.0]);
            let size = form.c.abs() + amplitude;
            worst[0] = worst[0].max((form.bands(x).iter().sum::<f64>() - exact).abs() / (ROUNDING * size));
            let ax = times(&form.a, x);
            for (k, row) in [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]].into_iter().enumerate() {
                let exact = compensated(&[
                    [2.0 * row[0], p, 1.0],
                    [2.0 * row[1], q, 1.0],
                    [2.0 * row[2], r, 1.0],
                    [2.0 * nu, x[k], 1.0],
                    [b[k], 1.0, 1.0],
                ]);
                let found = 2.0 * (ax[k] + nu * x[k]) + b[k];
                // The remainder is multiplied by 2.
                worst[1] = worst[1].max(2.0 * (found - exact).abs() / (ROUNDING * amplitude.max(f64::MIN_POSITIVE)));
            }
        }
        println!("a value errs by {:.3} of the bound, a remainder by {:.3}", worst[0], worst[1]);
        assert!(worst[0] < 0.25 && worst[1] < 0.25, "values and remainders err by {worst:?} of the bound");
    }

    /// Planted: `A` and `b` are made so that (1) holds at a chosen `x` with chosen eigenvalues of `A + ν`.
    #[test]
    fn planted_minima_are_found_with_their_values() {
        let mut random = Random::new(2);
        for case in 0..2000 {
            let gaps = [[1.0, 2.0, 3.0], [0.0, 0.5, 1.5], [0.0, 0.0, 1.0], [1e-9, 1.0, 1.0], [0.3, 0.3, 0.3]][case % 5];
            let e = [0, 1, 2].map(|_| random.direction());
            let e0 = e[0];
            let e1 = unit(cross(e0, e[1]));
            let e2 = cross(e0, e1);
            let entry =
                |i: usize, j: usize| gaps[0] * e0[i] * e0[j] + gaps[1] * e1[i] * e1[j] + gaps[2] * e2[i] * e2[j];
            let nu = gaps.iter().sum::<f64>() / 3.0;
            let shifted = [entry(0, 0), entry(1, 1), entry(2, 2), entry(0, 1), entry(0, 2), entry(1, 2)];
            let x = e[2];
            let b = times(&shifted, x).map(|v| -2.0 * v);
            let mut a = shifted;
            for a in &mut a[..3] {
                *a -= nu;
            }
            let form = QuadraticForm::from_parts(0.5, b, a);
            let expected: f64 = form.bands(x).iter().sum();
            let found = form.minimum([1.0, 1.0]);
            let close = found.lo <= expected && expected <= found.hi && found.hi - found.lo < 1e-12;
            assert!(close, "case {case}: {found:?} against {expected}");
        }
    }

    /// Double eigenvalues, high and low, included: the form of a sun has them.
    #[test]
    fn principal_axes_rebuild_the_form() {
        let mut random = Random::new(5);
        for case in 0..3000 {
            let mut f = random.signed_vec(9);
            if case % 3 > 0 {
                let z = Zonal::new(vec![1.0, 1.0, [1.0, -1.0][case % 2]]);
                f = z.towards(Dir::from_unit(random.direction()), 1.0).coefficients().to_vec();
            }
            if case % 3 == 2 {
                f.iter_mut().for_each(|c| *c += 1e-9 * random.unit());
            }
            let form = QuadraticForm::new(&f, 0);
            let Eigensystem { low, distances, axes, .. } = form.eigensystem();
            let (_, rows) = form.parts();
            assert!(distances[0] == 0.0 && distances.iter().all(|d| *d >= 0.0), "case {case}: {distances:?}");
            for i in 0..3 {
                for j in 0..3 {
                    let sum: f64 = (0..3).map(|k| (low + distances[k]) * axes[k][i] * axes[k][j]).sum();
                    let error = (sum - rows[i][j]).abs();
                    assert!(error < 6e-15 * form.form, "case {case}, {i}{j}: off by {error} of {}", form.form);
                    let one: f64 = (0..3).map(|k| axes[k][i] * axes[k][j]).sum();
                    let expected = f64::from(u8::from(i == j));
                    assert!((one - expected).abs() < 4e-15, "case {case}, {i}{j}: axes give {one}");
                }
            }
        }
    }

    #[test]
    fn scaled_bands_have_the_minimum_of_the_scaled_function() {
        let mut random = Random::new(3);
        for case in 0..500 {
            let f = ShL2::<f64>::from_slice(&random.signed_vec(9));
            let w = [[1.0, 1.0], [0.5, 0.25], [1.0, 0.0], [0.0, 1.0], [0.0, 0.0], [1e-9, 1.0], [1.0, 1e-12]][case % 7];
            let mut scaled = f;
            crate::filter::scale_bands_in_place(scaled.coefficients_mut(), &[1.0, w[0], w[1]]);
            let a = QuadraticForm::new(f.coefficients(), 0).minimum(w);
            let b = QuadraticForm::new(scaled.coefficients(), 0).minimum([1.0, 1.0]);
            assert!((a.hi - b.hi).abs() < 1e-12 && (a.lo - b.lo).abs() < 1e-12, "case {case}, {w:?}: {a:?} {b:?}");
        }
    }

    #[test]
    fn zonal_minima_are_those_of_their_parabola() {
        let mut random = Random::new(4);
        for _ in 0..500 {
            let z = Zonal::new(random.signed_vec(3));
            let axis = Dir::from_unit(random.direction());
            // q(t) = c + b t + a (3t² - 1)/2
            let [q0, q1, q2] = [0.0, 1.0, -1.0].map(|t| z.eval(t));
            let (a, b) = (0.5 * (q1 + q2) - q0, 0.5 * (q1 - q2));
            let inside = if a > 0.0 && b.abs() < 2.0 * a { q0 - b * b / (4.0 * a) } else { f64::INFINITY };
            let expected = inside.min(q1).min(q2);
            let found = QuadraticForm::new(z.towards(axis, 1.0).coefficients(), 0).minimum([1.0, 1.0]);
            assert!((found.hi - expected).abs() < 1e-13 && found.lo <= expected + 1e-15, "{found:?}, {expected}");
            assert!(found.hi - found.lo < 1e-12, "{found:?} is wide");
        }
    }
}
