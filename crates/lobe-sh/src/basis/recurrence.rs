//! The recurrence of the basis: its constants, and its plain code.

use crate::basis::index::coefficient_index;
use crate::prelude::*;
use crate::scalar::Real;

/// `P̄` is kept times this and `(x + iy)^m` divided by it, so that both stay in the range of `f32` to [`MAX_ORDER`](crate::basis::MAX_ORDER).
pub(crate) const BALANCE: f64 = 1.0 / (1_u64 << 56) as f64;

/// The constants of the step to band `l` of one column; see [`Basis`](crate::basis::Basis).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Step<S> {
    pub(crate) a: S,
    pub(crate) b: S,
    pub(crate) g: S,
}

/// The constants of bands `0..order`; see [`Basis`](crate::basis::Basis).
#[derive(Clone, Debug)]
pub(crate) struct Constants<S> {
    order: usize,
    /// `P̄_m^m` for every `m`.
    diagonal: Vec<S>,
    /// For `l` from `m+1` to `order-1`, column after column.
    recurrence: Vec<Step<S>>,
}

impl<S: Real> Constants<S> {
    /// Computed in `f64` and rounded once.
    pub(crate) fn new(order: usize) -> Self {
        let mut diagonal = Vec::with_capacity(order);
        let mut recurrence = Vec::with_capacity(order * order.saturating_sub(1) / 2);
        let mut d = (4.0 * core::f64::consts::PI).sqrt().recip();
        for m in 0..order {
            let mf = m as f64;
            match m {
                0 => {}
                1 => d *= -(3.0_f64.sqrt()),
                _ => d *= -((2.0 * mf + 1.0) / (2.0 * mf)).sqrt(),
            }
            diagonal.push(S::from_f64(d));
            let mut a_before = f64::INFINITY;
            for l in m + 1..order {
                let lf = l as f64;
                let a = ((4.0 * lf * lf - 1.0) / ((lf - mf) * (lf + mf))).sqrt();
                let b = a / a_before;
                recurrence.push(Step { a: S::from_f64(a), b: S::from_f64(b), g: S::from_f64(a - 1.0 - b) });
                a_before = a;
            }
        }
        Self { order, diagonal, recurrence }
    }

    pub(crate) fn order(&self) -> usize {
        self.order
    }

    /// Panics if an order is above that of the constants.
    pub(crate) fn assert_reaches(&self, order: usize) {
        assert!(order <= self.order, "this basis reaches order {}, not {order}", self.order);
    }

    /// `P̄_m^m`.
    pub(crate) fn diagonal(&self, m: usize) -> S {
        self.diagonal[m]
    }

    /// The steps of column `m` to the bands from `m + 1` to `order - 1`.
    pub(crate) fn steps(&self, m: usize, order: usize) -> &[Step<S>] {
        &self.recurrence[self.column_start(m)..][..order - 1 - m]
    }

    /// The start of column `m`: after `m` columns of `order-1`, `order-2`, .. entries.
    fn column_start(&self, m: usize) -> usize {
        m * (2 * self.order - 1 - m) / 2
    }

    /// The recurrence in plain code: calls `emit(i, y_i)` once for every basis function, column by column of equal `|m|`, for `W` directions at once, in structure-of-arrays form.
    #[inline(always)]
    pub(crate) fn for_each_in_block<const W: usize>(
        &self,
        [x, y, z]: [[S; W]; 3],
        order: usize,
        mut emit: impl FnMut(usize, &[S; W]),
    ) {
        self.assert_reaches(order);
        let side: [S; W] = lanes(|k| if z[k] < S::ZERO { -S::ONE } else { S::ONE });
        let w: [S; W] = lanes(|k| z[k] * side[k] - S::ONE);
        let balance = S::from_f64(BALANCE);
        let mut cos = [S::ONE / balance; W];
        let mut sin = [S::ZERO; W];
        for m in 0..order {
            // Below the equator the functions of odd l - m change sign.
            let cos_odd: [S; W] = lanes(|k| cos[k] * side[k]);
            let sin_odd: [S; W] = lanes(|k| sin[k] * side[k]);
            let mut p = [self.diagonal[m] * balance; W];
            let mut difference = [S::ZERO; W];
            let recurrence = self.steps(m, order);
            for l in m..order {
                let (c, s) = if (l - m).is_multiple_of(2) { (&cos, &sin) } else { (&cos_odd, &sin_odd) };
                emit(coefficient_index(l, m as isize), &lanes(|k| p[k] * c[k]));
                if m > 0 {
                    emit(coefficient_index(l, -(m as isize)), &lanes(|k| p[k] * s[k]));
                }
                if let Some(&Step { a, b, g }) = recurrence.get(l - m) {
                    difference = lanes(|k| b * difference[k] + (g + a * w[k]) * p[k]);
                    p = lanes(|k| p[k] + difference[k]);
                }
            }
            (cos, sin) = (lanes(|k| x[k] * cos[k] - y[k] * sin[k]), lanes(|k| x[k] * sin[k] + y[k] * cos[k]));
        }
    }
}

/// One value for each lane.
#[inline(always)]
pub(crate) fn lanes<S: Real, const W: usize>(mut f: impl FnMut(usize) -> S) -> [S; W] {
    let mut out = [S::ZERO; W];
    for (k, out) in out.iter_mut().enumerate() {
        *out = f(k);
    }
    out
}
