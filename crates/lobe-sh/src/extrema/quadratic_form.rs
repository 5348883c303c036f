//! A function of three bands as a quadratic form on the unit sphere, and its exact minimum.

use core::f64::consts::PI;

#[cfg(not(feature = "std"))]
use num_traits::Float as _;

use crate::once::Once;
use crate::sphere::vector::{dot, tangents, unit};
use crate::{Coefficient, Dir, Extremum, Real};

/// The most Newton steps for the multiplier. It rises monotonically and the digits double: 3 to 6 are usual.
const NEWTON_STEPS: usize = 64;

/// The relative step at which the multiplier has converged; the next step would be of the order of its square.
const CONVERGED: f64 = 1e-9;

/// The rounding error of a value of the form and of the remainder, some twenty operations each, relative to the largest
/// value: four times the largest error that the test `forms_are_evaluated_within_their_bound` finds.
const ROUNDING: f64 = 32.0 * f64::EPSILON;

/// A function of bands 0 to 2, `f(x) = c + b·x + xᵀ A x` on `|x| = 1`, with `A` symmetric and without trace.
///
/// ```text
///   c = f_0/√4π        b = √(3/4π) (-f_3, -f_1, f_2)
///
///                 [ f_8 - f_6/√3     f_4             -f_7      ]
///   A = √(15/16π) [ f_4             -f_8 - f_6/√3    -f_5      ]
///                 [-f_7             -f_5              2 f_6/√3 ]
/// ```
///
/// # Derivation
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
pub(crate) struct QuadraticForm {
    /// The mean.
    pub(crate) c: f64,
    b: [f64; 3],
    /// xx, yy, zz, xy, xz, yz.
    a: [f64; 6],
    /// `|b|`, the largest value of the linear part.
    pub(crate) linear: f64,
    /// No eigenvalue of `A` is larger: a matrix without trace has them within `√(2/3) |A|`.
    pub(crate) form: f64,
}

/// The eigenvalues and eigenvectors of a [`QuadraticForm`].
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

/// The coefficients of one channel, filled up with zeros.
fn nine<T: Coefficient>(coefficients: &[T], channel: usize) -> [f64; 9] {
    let mut f = [0.0; 9];
    for (f, c) in f.iter_mut().zip(coefficients) {
        *f = c.channel(channel).to_f64();
    }
    f
}

/// The power of two by which numbers of which this is the largest come to between 1 and 2, or as near as it can bring them: a factor that does
/// not round, after which squares and cubes stay in range.
pub(crate) fn to_unit_size(largest: f64) -> f64 {
    2.0_f64.powi((-largest.max(f64::MIN_POSITIVE).log2().floor()).min(1000.0) as i32)
}

impl QuadraticForm {
    /// From the `n²` coefficients of one channel, `n` up to 3; missing bands are zero.
    pub(crate) fn new<T: Coefficient>(coefficients: &[T], channel: usize) -> Self {
        Self::of(nine(coefficients, channel))
    }

    /// [`QuadraticForm::new`] of the function times [`to_unit_size`], so that products of four coefficients stay in range; and that factor.
    pub(crate) fn normalized<T: Coefficient>(coefficients: &[T], channel: usize) -> (Self, f64) {
        let f = nine(coefficients, channel);
        let scale = to_unit_size(f.iter().fold(0.0, |largest: f64, f| largest.max(f.abs())));
        (Self::of(f.map(|f| f * scale)), scale)
    }

    fn of(f: [f64; 9]) -> Self {
        let [k0, k1, k2, third, _] = *norms();
        let diagonal = third * f[6];
        let a = [f[8] - diagonal, -f[8] - diagonal, 2.0 * diagonal, f[4], -f[7], -f[5]];
        Self::from_parts(k0 * f[0], [-k1 * f[3], -k1 * f[1], k1 * f[2]], a.map(|a| k2 * a))
    }

    /// From `c`, `b` and `A` as xx, yy, zz, xy, xz, yz, without trace.
    pub(crate) fn from_parts(c: f64, b: [f64; 3], a: [f64; 6]) -> Self {
        let [xx, yy, zz, xy, xz, yz] = a;
        let square = xx * xx + yy * yy + zz * zz + 2.0 * (xy * xy + xz * xz + yz * yz);
        Self { c, b, a, linear: dot(b, b).sqrt(), form: (2.0 / 3.0 * square).sqrt() }
    }

    /// An upper bound of the absolute value of bands 1 and 2, scaled by `w`.
    #[inline]
    pub(crate) fn amplitude(&self, w: [f64; 2]) -> f64 {
        w[0] * self.linear + w[1] * self.form
    }

    /// A lower bound of the minimum when bands 1 and 2 are scaled by factors `w` for which `other` is not negative: the
    /// bound of the remainder `f - s f_other`, with the `s >= 0` for which bands 1 and 2 of the remainder are smallest.
    /// Tight for light of one color.
    pub(crate) fn least_beside(&self, other: &Self, w: [f64; 2]) -> f64 {
        // The inner product of the coefficients, from |b|² and |A|² with the norms √(3/4π) and √(15/8π).
        let inner = |p: &Self, q: &Self| {
            let diagonal = p.a[0] * q.a[0] + p.a[1] * q.a[1] + p.a[2] * q.a[2];
            let rest = p.a[3] * q.a[3] + p.a[4] * q.a[4] + p.a[5] * q.a[5];
            2.5 * dot(p.b, q.b) + diagonal + 2.0 * rest
        };
        let whole = inner(other, other);
        let s = if whole > 0.0 { (inner(self, other) / whole).max(0.0) } else { 0.0 };
        let b = [0, 1, 2].map(|k| self.b[k] - s * other.b[k]);
        let a = [0, 1, 2, 3, 4, 5].map(|k| self.a[k] - s * other.a[k]);
        let rest = Self::from_parts(self.c - s * other.c, b, a);
        rest.c - rest.amplitude(w)
    }

    /// The values of the three bands towards `x`.
    #[inline]
    pub(crate) fn bands(&self, x: [f64; 3]) -> [f64; 3] {
        [self.c, dot(self.b, x), dot(x, times(&self.a, x))]
    }

    /// `b` and the rows of `A`.
    pub(crate) fn parts(&self) -> ([f64; 3], [[f64; 3]; 3]) {
        let [xx, yy, zz, xy, xz, yz] = self.a;
        (self.b, [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    }

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

    /// The minimum when bands 1 and 2 are scaled by `w`, certified by (1) of [`QuadraticForm`]:
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

#[inline]
fn times(&[xx, yy, zz, xy, xz, yz]: &[f64; 6], [x, y, z]: [f64; 3]) -> [f64; 3] {
    [xx * x + xy * y + xz * z, xy * x + yy * y + yz * z, xz * x + yz * y + zz * z]
}

/// `1/√4π`, `√(3/4π)`, `√(15/16π)`, `1/√3`, `√3`.
pub(crate) fn norms() -> &'static [f64; 5] {
    static NORMS: Once<[f64; 5]> = Once::new();
    NORMS.get_or_init(|| {
        [(0.25 / PI).sqrt(), (0.75 / PI).sqrt(), (0.9375 / PI).sqrt(), 3.0_f64.sqrt().recip(), 3.0_f64.sqrt()]
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sphere::vector::cross;
    use crate::{Expansion as _, ShL2, Zonal};
    use lobe_testkit::{Random, directions};

    #[test]
    fn the_quadratic_form_is_the_function() {
        let f = ShL2::<f64>::from_slice(&Random::new(1).signed_vec(9));
        let form = QuadraticForm::new(f.coefficients(), 0);
        for s in directions() {
            let sum: f64 = form.bands(s).iter().sum();
            let value = f.eval(Dir::from_unit(s));
            assert!((sum - value).abs() < 1e-14, "towards {s:?}: {sum} against {value}");
        }
    }

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
    fn a_channel_beside_another_is_not_below_its_bound() {
        let mut random = Random::new(6);
        for case in 0..1000 {
            let mut f = random.signed_vec(9);
            f[0] = 0.0;
            f[0] = -QuadraticForm::new(&f, 0).minimum([1.0, 1.0]).lo * (4.0 * PI).sqrt();
            let scale = 2.0 * random.unit();
            let g: Vec<f64> = f.iter().map(|f| scale * f + 0.1 * (random.unit() - 0.5) * f64::from(case % 4)).collect();
            let (f, g) = (QuadraticForm::new(&f, 0), QuadraticForm::new(&g, 0));
            let (bound, least) = (g.least_beside(&f, [1.0, 1.0]), g.minimum([1.0, 1.0]));
            assert!(bound <= least.hi + 1e-14, "case {case}: {bound} against {least:?}");
            assert!(case % 4 > 0 || bound > -1e-14, "case {case}, one color: {bound}");
        }
    }

    #[test]
    fn scaled_bands_have_the_minimum_of_the_scaled_function() {
        let mut random = Random::new(3);
        for case in 0..500 {
            let f = ShL2::<f64>::from_slice(&random.signed_vec(9));
            let w = [[1.0, 1.0], [0.5, 0.25], [1.0, 0.0], [0.0, 1.0], [0.0, 0.0], [1e-9, 1.0], [1.0, 1e-12]][case % 7];
            let mut scaled = f;
            crate::scale_bands_in_place(scaled.coefficients_mut(), &[1.0, w[0], w[1]]);
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
