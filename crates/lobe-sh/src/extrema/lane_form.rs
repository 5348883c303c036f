//! Functions of three bands as quadratic forms, one in each lane: [`QuadraticForm`](crate::extrema::quadratic_form::QuadraticForm) but for the
//! tangents, which it finds by comparisons.

use pulp::Simd;

use crate::extrema::quadratic_form::norms;
use crate::simd::{Wide, rounded};

/// As many `f64` as a register holds.
pub(crate) type Many<S> = Wide<S, f64>;

/// A form in each lane.
#[derive(Clone, Copy)]
pub(crate) struct LaneForm<S: Simd> {
    simd: S,
    /// The mean.
    pub(crate) c: Many<S>,
    b: [Many<S>; 3],
    /// xx, yy, zz, xy, xz, yz.
    a: [Many<S>; 6],
    /// `|b|`.
    linear: Many<S>,
    /// No eigenvalue of `A` is larger.
    form: Many<S>,
}

/// The eigenvalues of each form, without the axes.
#[derive(Clone, Copy)]
pub(crate) struct LaneEigenvalues<S: Simd> {
    /// The lowest.
    pub(crate) low: Many<S>,
    /// The distances of all from it.
    pub(crate) distances: [Many<S>; 3],
    /// `b/2` along the eigenvectors.
    pub(crate) beta: [Many<S>; 3],
}

impl<S: Simd> LaneForm<S> {
    /// Of the coefficients of three bands.
    #[inline(always)]
    pub(crate) fn new(simd: S, f: &[Many<S>; 9]) -> Self {
        let [k0, k1, k2, third, _] = *norms();
        let [k0, k1, k2, third] =
            [rounded(simd, k0), rounded(simd, k1), rounded(simd, k2), rounded::<S, f64>(simd, third)];
        let diagonal = third * f[6];
        let (left, right) = (f[8] - diagonal, f[8].negated() - diagonal);
        let b = [k1.negated() * f[3], k1.negated() * f[1], k1 * f[2]];
        let a =
            [k2 * left, k2 * right, k2 * (diagonal + diagonal), k2 * f[4], k2.negated() * f[7], k2.negated() * f[5]];
        Self::from_parts(simd, k0 * f[0], b, a)
    }

    #[inline(always)]
    fn from_parts(simd: S, c: Many<S>, b: [Many<S>; 3], a: [Many<S>; 6]) -> Self {
        let [xx, yy, zz, xy, xz, yz] = a;
        let rest = dot([xy, xz, yz], [xy, xz, yz]);
        let square = dot([xx, yy, zz], [xx, yy, zz]) + (rest + rest);
        Self { simd, c, b, a, linear: dot(b, b).sqrt(), form: (rounded::<S, f64>(simd, 2.0 / 3.0) * square).sqrt() }
    }

    /// An upper bound of the absolute value of bands 1 and 2, scaled by `w`.
    #[inline(always)]
    pub(crate) fn amplitude(&self, w: [Many<S>; 2]) -> Many<S> {
        w[0].times_plus(self.linear, w[1] * self.form)
    }

    /// `then` where `x < y`, `or` elsewhere.
    #[inline(always)]
    pub(crate) fn if_less([x, y]: [Many<S>; 2], then: &Self, or: &Self) -> Self {
        let (mut b, mut a) = (or.b, or.a);
        for k in 0..3 {
            b[k] = x.if_less(y, then.b[k], or.b[k]);
        }
        for k in 0..6 {
            a[k] = x.if_less(y, then.a[k], or.a[k]);
        }
        Self {
            simd: then.simd,
            c: x.if_less(y, then.c, or.c),
            b,
            a,
            linear: x.if_less(y, then.linear, or.linear),
            form: x.if_less(y, then.form, or.form),
        }
    }

    /// A lower bound of the minimum when bands 1 and 2 are scaled by factors `w` for which `other` is not negative.
    #[inline(always)]
    pub(crate) fn least_beside(&self, other: &Self, w: [Many<S>; 2]) -> Many<S> {
        let zero = rounded(self.simd, 0.0);
        let whole = other.inner(other);
        let s = zero.if_less(whole, (self.inner(other) / whole).max(zero), zero);
        let (mut b, mut a) = (self.b, self.a);
        for k in 0..3 {
            b[k] = s.times_from(other.b[k], b[k]);
        }
        for k in 0..6 {
            a[k] = s.times_from(other.a[k], a[k]);
        }
        let rest = Self::from_parts(self.simd, s.times_from(other.c, self.c), b, a);
        rest.c - rest.amplitude(w)
    }

    /// The inner product of the coefficients of bands 1 and 2, but for a factor.
    #[inline(always)]
    fn inner(&self, other: &Self) -> Many<S> {
        let (p, q) = (self.a, other.a);
        let diagonal = dot([p[0], p[1], p[2]], [q[0], q[1], q[2]]);
        let rest = dot([p[3], p[4], p[5]], [q[3], q[4], q[5]]);
        rounded::<S, f64>(self.simd, 2.5).times_plus(dot(self.b, other.b), diagonal + (rest + rest))
    }

    /// The eigenvalues, and the linear part along the eigenvectors.
    #[inline(always)]
    pub(crate) fn eigenvalues(&self) -> LaneEigenvalues<S> {
        let simd = self.simd;
        let (zero, one) = (rounded(simd, 0.0), rounded::<S, f64>(simd, 1.0));
        let half = rounded(simd, 0.5);
        let isolated = self.isolated_eigenvalue();
        let axis = self.isolated_eigenvector(isolated);
        let [u, v] = tangents(simd, axis);
        let au = times(&self.a, u);
        let (uu, uv) = (dot(u, au), dot(v, au));
        // The rotation in the plane of the other two, by the smaller of two angles.
        let middle = half.negated() * isolated;
        let gap = middle - uu;
        let root = dot([gap, uv, zero], [gap, uv, zero]).sqrt();
        let tan = zero.if_less(root, uv / (absolute(gap) + root) * gap.sign(), zero);
        let cos = one / tan.times_plus(tan, one).sqrt();
        let sin = tan * cos;
        let (along_u, along_v) = (half * dot(self.b, u), half * dot(self.b, v));
        let lower = cos * along_u - sin * along_v;
        let upper = sin * along_u + cos * along_v;
        let pair = [gap.if_less(zero, upper, lower), gap.if_less(zero, lower, upper)];
        let alone = half * dot(self.b, axis);
        let far = rounded::<S, f64>(simd, 1.5) * absolute(isolated);
        // The isolated eigenvalue is the lowest or the highest.
        let mut beta = [
            isolated.if_less(zero, alone, pair[0]),
            isolated.if_less(zero, pair[0], pair[1]),
            isolated.if_less(zero, pair[1], alone),
        ];
        let rounding = rounded::<S, f64>(simd, f64::EPSILON) * self.linear;
        for k in 0..3 {
            beta[k] = rounding.if_less(absolute(beta[k]), beta[k], zero);
        }
        LaneEigenvalues {
            low: isolated.if_less(zero, isolated, middle - root),
            distances: [zero, isolated.if_less(zero, far - root, root + root), far + root],
            beta,
        }
    }

    #[inline(always)]
    fn isolated_eigenvalue(&self) -> Many<S> {
        let simd = self.simd;
        let (zero, one, three) = (rounded(simd, 0.0), rounded(simd, 1.0), rounded::<S, f64>(simd, 3.0));
        let p = rounded::<S, f64>(simd, 0.5) * self.form;
        let [xx, yy, zz, xy, xz, yz] = self.a;
        let determinant = xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz);
        let twice = (absolute(determinant) / (p * p * p)).min(one + one);
        let half = rounded::<S, f64>(simd, 0.5) * twice;
        let [root, third] = [norms()[4], 1.0 / 3.0];
        let parabola = rounded::<S, f64>(simd, 2.0 - root - third).times_plus(half, rounded(simd, third));
        let mut x = half.times_plus(parabola, rounded(simd, root));
        for _ in 0..3 {
            let square = x * x;
            x = x - (x * (square - three) - twice) / (three * (square - one));
        }
        zero.if_less(p, p * x * determinant.sign(), zero)
    }

    #[inline(always)]
    fn isolated_eigenvector(&self, isolated: Many<S>) -> [Many<S>; 3] {
        let (zero, one) = (rounded(self.simd, 0.0), rounded::<S, f64>(self.simd, 1.0));
        let [xx, yy, zz, xy, xz, yz] = self.a;
        let [xx, yy, zz] = [xx - isolated, yy - isolated, zz - isolated];
        let (dx, dy, dz) = (yy * zz - yz * yz, xx * zz - xz * xz, xx * yy - xy * xy);
        let (ex, ey, ez) = (xy * xz - yz * xx, xy * yz - xz * yy, xz * yz - xy * zz);
        let two = dx.max(dy);
        let mut column = [dx.if_less(dy, ez, dx), dx.if_less(dy, dy, ez), dx.if_less(dy, ex, ey)];
        column = [two.if_less(dz, ey, column[0]), two.if_less(dz, ex, column[1]), two.if_less(dz, dz, column[2])];
        let longest = two.max(dz);
        let length = dot(column, column).sqrt();
        [
            zero.if_less(longest, column[0] / length, one),
            zero.if_less(longest, column[1] / length, zero),
            zero.if_less(longest, column[2] / length, zero),
        ]
    }
}

/// The larger of a number and its negative.
#[inline(always)]
pub(crate) fn absolute<S: Simd>(x: Many<S>) -> Many<S> {
    x.max(x.negated())
}

#[inline(always)]
fn dot<S: Simd>(a: [Many<S>; 3], b: [Many<S>; 3]) -> Many<S> {
    a[0].times_plus(b[0], a[1].times_plus(b[1], a[2] * b[2]))
}

#[inline(always)]
fn times<S: Simd>(&[xx, yy, zz, xy, xz, yz]: &[Many<S>; 6], x: [Many<S>; 3]) -> [Many<S>; 3] {
    [dot([xx, xy, xz], x), dot([xy, yy, yz], x), dot([xz, yz, zz], x)]
}

/// Two unit vectors at right angles to each other and to a unit vector (Duff et al. 2017).
#[inline(always)]
fn tangents<S: Simd>(simd: S, [x, y, z]: [Many<S>; 3]) -> [[Many<S>; 3]; 2] {
    let one = rounded::<S, f64>(simd, 1.0);
    let sign = z.sign();
    let a = one.negated() / (sign + z);
    let b = x * y * a;
    [[sign.times_plus(x * x * a, one), sign * b, sign.negated() * x], [b, sign + y * y * a, y.negated()]]
}
