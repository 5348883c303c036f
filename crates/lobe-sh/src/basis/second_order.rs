//! Value, gradient and Hessian of a scalar expansion, several directions at once.

#[cfg(not(feature = "std"))]
use num_traits::Float as _;

use crate::basis::basis::Basis;
use crate::basis::index::{coefficient_index, order_of_slice};
use crate::basis::recurrence::Step;
use crate::sphere::vector::{dot, tangents, unit};

/// The value, gradient and Hessian of a function at a direction, in the plane of two unit tangents.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LocalQuadratic {
    /// The direction.
    pub(crate) s: [f64; 3],
    /// `f(s)`.
    pub(crate) value: f64,
    /// The tangents `t_1, t_2`: with `s` a right-handed frame.
    pub(crate) tangents: [[f64; 3]; 2],
    /// The slopes along the tangents.
    pub(crate) gradient: [f64; 2],
    /// The second derivatives along great circles: 11, 12, 22.
    pub(crate) hessian: [f64; 3],
}

impl LocalQuadratic {
    /// The point of the great circle that leaves `s` along `a t_1 + b t_2`, at a distance of that vector's length.
    pub(crate) fn step(&self, [a, b]: [f64; 2]) -> [f64; 3] {
        let angle = a.hypot(b);
        if angle == 0.0 {
            return self.s;
        }
        let (sin, cos) = angle.sin_cos();
        let t = [0, 1, 2].map(|k| (a * self.tangents[0][k] + b * self.tangents[1][k]) / angle);
        unit([0, 1, 2].map(|k| cos * self.s[k] + sin * t[k]))
    }

    /// The principal curvatures, the lower first, the slopes along their axes, and the axes in the frame of tangents.
    pub(crate) fn principal_curvatures(&self) -> ([f64; 2], [f64; 2], [[f64; 2]; 2]) {
        let [xx, xy, yy] = self.hessian;
        let (mean, half) = (0.5 * (xx + yy), 0.5 * (xx - yy));
        let radius = half.hypot(xy);
        // The axis of the larger curvature at half the angle of (half, xy); the longer of two forms has no
        // cancellation.
        let (a, b) = if half >= 0.0 { (radius + half, xy) } else { (xy, radius - half) };
        let length = a.hypot(b);
        let high = if length > 0.0 { [a / length, b / length] } else { [1.0, 0.0] };
        let low = [-high[1], high[0]];
        let [g0, g1] = self.gradient;
        let slopes = [low, high].map(|v| v[0] * g0 + v[1] * g1);
        ([mean - radius, mean + radius], slopes, [low, high])
    }
}

/// A function and its derivatives in space towards `W` directions, for the continuation `F = Σ Q(z) C(x, y)` of
/// [`Basis`] off the sphere. The derivatives follow from the sums over `l` of a column `m`:
///
/// ```text
///   q = Σ_l f_lm Q_l    q' = Σ_l f_lm Q_l'    q'' = Σ_l f_lm Q_l''        (p, p', p'' for -m)
///
///   F_x  =  m (q C_{m-1} + p S_{m-1})            F_y  = m (p C_{m-1} - q S_{m-1})       F_z  = q' C_m + p' S_m
///   F_xx =  m (m-1) (q C_{m-2} + p S_{m-2})      F_yy = -F_xx                           F_zz = q'' C_m + p'' S_m
///   F_xy =  m (m-1) (p C_{m-2} - q S_{m-2})      F_xz = m (q' C_{m-1} + p' S_{m-1})     F_yz = m (p' C_{m-1} - q' S_{m-1})
/// ```
///
/// Along the great circle `γ(t) = s cos t + v sin t` with a unit tangent `v`,
///
/// ```text
///   (f∘γ)'(0) = v · ∂F        (f∘γ)''(0) = vᵀ ∂²F v - s · ∂F
/// ```
pub(crate) fn second_order<const W: usize>(
    basis: &Basis<f64>,
    coefficients: &[f64],
    directions: &[[f64; 3]; W],
) -> [LocalQuadratic; W] {
    let order = order_of_slice(coefficients);
    let mut sums = [[0.0; W]; 9];
    let [x, y, z]: [[f64; W]; 3] = [0, 1, 2].map(|k| core::array::from_fn(|w| directions[w][k]));
    // (x + iy)^m, ^(m-1) and ^(m-2)
    let mut powers = [([1.0; W], [0.0; W]), ([0.0; W], [0.0; W]), ([0.0; W], [0.0; W])];
    for m in 0..order {
        let (mut q0, mut q1, mut q2) = ([basis.diagonal(m); W], [0.0; W], [0.0; W]);
        let (mut b0, mut b1, mut b2) = ([0.0; W], [0.0; W], [0.0; W]);
        let mut column = [[0.0; W]; 6];
        for l in m..order {
            let plus = coefficients[coefficient_index(l, m as isize)];
            let minus = if m > 0 { coefficients[coefficient_index(l, -(m as isize))] } else { 0.0 };
            for w in 0..W {
                column[0][w] += plus * q0[w];
                column[1][w] += plus * q1[w];
                column[2][w] += plus * q2[w];
                column[3][w] += minus * q0[w];
                column[4][w] += minus * q1[w];
                column[5][w] += minus * q2[w];
            }
            if l + 1 < order {
                let Step { a, b, .. } = basis.recurrence(m, l + 1);
                for w in 0..W {
                    let next2 = a * (2.0 * q1[w] + z[w] * q2[w]) - b * b2[w];
                    let next1 = a * (q0[w] + z[w] * q1[w]) - b * b1[w];
                    let next0 = a * z[w] * q0[w] - b * b0[w];
                    (b0[w], b1[w], b2[w]) = (q0[w], q1[w], q2[w]);
                    (q0[w], q1[w], q2[w]) = (next0, next1, next2);
                }
            }
        }
        add_column(m as f64, &column, &powers, &mut sums);
        let (c, s) = powers[0];
        let next =
            (core::array::from_fn(|w| x[w] * c[w] - y[w] * s[w]), core::array::from_fn(|w| x[w] * s[w] + y[w] * c[w]));
        powers = [next, powers[0], powers[1]];
    }
    core::array::from_fn(|w| on_the_sphere(directions[w], &sums.map(|sum| sum[w])))
}

/// Adds a column to `F, F_x, F_y, F_z, F_xx, F_xy, F_zz, F_xz, F_yz`.
#[inline(always)]
fn add_column<const W: usize>(
    m: f64,
    [q, q1, q2, p, p1, p2]: &[[f64; W]; 6],
    [(c0, s0), (c1, s1), (c2, s2)]: &[([f64; W], [f64; W]); 3],
    sums: &mut [[f64; W]; 9],
) {
    let mm = m * (m - 1.0);
    for w in 0..W {
        sums[0][w] += q[w] * c0[w] + p[w] * s0[w];
        sums[1][w] += m * (q[w] * c1[w] + p[w] * s1[w]);
        sums[2][w] += m * (p[w] * c1[w] - q[w] * s1[w]);
        sums[3][w] += q1[w] * c0[w] + p1[w] * s0[w];
        sums[4][w] += mm * (q[w] * c2[w] + p[w] * s2[w]);
        sums[5][w] += mm * (p[w] * c2[w] - q[w] * s2[w]);
        sums[6][w] += q2[w] * c0[w] + p2[w] * s0[w];
        sums[7][w] += m * (q1[w] * c1[w] + p1[w] * s1[w]);
        sums[8][w] += m * (p1[w] * c1[w] - q1[w] * s1[w]);
    }
}

/// From derivatives in space to those on the sphere.
fn on_the_sphere(s: [f64; 3], &[value, fx, fy, fz, fxx, fxy, fzz, fxz, fyz]: &[f64; 9]) -> LocalQuadratic {
    let tangents = tangents(s);
    let gradient = [fx, fy, fz];
    let along = dot(gradient, s);
    let times = |v: [f64; 3]| {
        [
            fxx * v[0] + fxy * v[1] + fxz * v[2],
            fxy * v[0] - fxx * v[1] + fyz * v[2],
            fxz * v[0] + fyz * v[1] + fzz * v[2],
        ]
    };
    let [h1, h2] = tangents.map(times);
    LocalQuadratic {
        s,
        value,
        tangents,
        gradient: tangents.map(|t| dot(t, gradient)),
        hessian: [dot(tangents[0], h1) - along, dot(tangents[1], h1), dot(tangents[1], h2) - along],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expansion::gradient::eval_with_gradient;
    use crate::expansion::{Expansion as _, ShVec};
    use crate::sphere::Dir;
    use lobe_testkit::{Random, directions};

    #[test]
    fn values_slopes_and_curvatures_are_those_along_great_circles() {
        let step = 1e-3;
        for order in [1, 2, 3, 7, 10] {
            let f = ShVec::from_vec(Random::new(order as u64).signed_vec(order * order)).unwrap();
            for v in directions() {
                let [local] = Basis::<f64>::with_shared(order, |basis| second_order(basis, f.coefficients(), &[v]));
                let (value, gradient) = eval_with_gradient(&f, Dir::from_unit(v));
                assert!((local.value - value).abs() < 1e-12, "order {order} at {v:?}: {} {value}", local.value);
                for (k, t) in local.tangents.into_iter().enumerate() {
                    let slope = dot(t, gradient);
                    assert!((local.gradient[k] - slope).abs() < 1e-11, "at {v:?}: {} {slope}", local.gradient[k]);
                }
                let along = |a: f64, b: f64| {
                    let at = |k: f64| f.eval(Dir::from_unit(local.step([k * step * a, k * step * b])));
                    let outer = at(2.0) + at(-2.0);
                    (16.0 * (at(1.0) + at(-1.0)) - outer - 30.0 * at(0.0)) / (12.0 * step * step)
                };
                let r = 0.5_f64.sqrt();
                let mixed = 0.5 * (along(r, r) - along(r, -r));
                for (found, expected) in local.hessian.into_iter().zip([along(1.0, 0.0), mixed, along(0.0, 1.0)]) {
                    // Rounding of a second difference: 1e-15 · 60 / 12e-6
                    assert!((found - expected).abs() < 2e-6, "order {order} at {v:?}: {found} against {expected}");
                }
            }
        }
    }

    #[test]
    fn several_directions_are_as_good_as_one() {
        let f = Random::new(5).signed_vec(36);
        let all = directions();
        Basis::<f64>::with_shared(6, |basis| {
            for four in all.as_chunks::<4>().0 {
                for (s, local) in four.iter().zip(second_order(basis, &f, four)) {
                    let [one] = second_order(basis, &f, &[*s]);
                    assert_eq!((one.value, one.hessian), (local.value, local.hessian), "towards {s:?}");
                }
            }
        });
    }
}
