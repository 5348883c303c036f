//! The basis of any order towards some registers of directions at once.

use pulp::Simd;

use crate::basis::index::coefficient_index;
use crate::basis::recurrence::{BALANCE, Constants, Step};
use crate::simd::{Lane, Wide, rounded};

/// Where the values of registers go whose recurrences run side by side.
pub(crate) trait PlacesTogether<S: Simd, T: Lane> {
    /// Takes the values of `y_i` in register `r` of them; those of one function come one after the other.
    fn put_register(&mut self, i: usize, r: usize, value: Wide<S, T>);
}

/// A function `P̄_l^m` of the basis, for each register, and its difference to the band before.
struct Column<S: Simd, T: Lane, const R: usize> {
    p: [Wide<S, T>; R],
    difference: [Wide<S, T>; R],
}

impl<S: Simd, T: Lane, const R: usize> Column<S, T, R> {
    /// The functions of band `l` and `m`, `-m`.
    #[inline(always)]
    fn put(&self, l: usize, m: usize, [cos, sin]: [&[Wide<S, T>; R]; 2], out: &mut impl PlacesTogether<S, T>) {
        for r in 0..R {
            out.put_register(coefficient_index(l, m as isize), r, self.p[r] * cos[r]);
        }
        if m > 0 {
            for r in 0..R {
                out.put_register(coefficient_index(l, -(m as isize)), r, self.p[r] * sin[r]);
            }
        }
    }

    /// On to the next band.
    #[inline(always)]
    fn step(&mut self, simd: S, w: &[Wide<S, T>; R], step: &Step<T>) {
        let (a, b, g) = (Wide::splat(simd, step.a), Wide::splat(simd, step.b), Wide::splat(simd, step.g));
        for r in 0..R {
            self.difference[r] = w[r].times_plus(a, g).times_plus(self.p[r], self.difference[r] * b);
            self.p[r] = self.p[r] + self.difference[r];
        }
    }
}

/// The recurrence of [`Basis`](crate::basis::Basis) for `R` registers of unit vectors, given by their components: each step waits for the one before, some ten
/// cycles, in which the other registers have theirs. Functions come column by column of equal `|m|`.
#[inline(always)]
pub(crate) fn recurrence<S: Simd, T: Lane, const R: usize>(
    simd: S,
    constants: &Constants<T>,
    order: usize,
    [x, y, z]: &[[Wide<S, T>; R]; 3],
    out: &mut impl PlacesTogether<S, T>,
) {
    let (zero, one) = (Wide::splat(simd, T::ZERO), Wide::splat(simd, T::ONE));
    let (mut side, mut w) = ([zero; R], [zero; R]);
    for r in 0..R {
        side[r] = z[r].sign();
        w[r] = z[r] * side[r] - one;
    }
    let mut cos = [rounded(simd, 1.0 / BALANCE); R];
    let mut sin = [zero; R];
    for m in 0..order {
        // Below the equator the functions of odd l - m change sign.
        let (mut cos_odd, mut sin_odd) = (cos, sin);
        for r in 0..R {
            cos_odd[r] = cos[r] * side[r];
            sin_odd[r] = sin[r] * side[r];
        }
        let first = constants.diagonal(m) * T::from_f64(BALANCE);
        let mut column = Column { p: [Wide::splat(simd, first); R], difference: [zero; R] };
        let steps = constants.steps(m, order);
        column.put(m, m, [&cos, &sin], out);
        for (k, steps) in steps.chunks(2).enumerate() {
            let l = m + 2 * k;
            column.step(simd, &w, &steps[0]);
            column.put(l + 1, m, [&cos_odd, &sin_odd], out);
            if let Some(step) = steps.get(1) {
                column.step(simd, &w, step);
                column.put(l + 2, m, [&cos, &sin], out);
            }
        }
        for r in 0..R {
            (cos[r], sin[r]) = (y[r].times_from(sin[r], x[r] * cos[r]), x[r].times_plus(sin[r], y[r] * cos[r]));
        }
    }
}
