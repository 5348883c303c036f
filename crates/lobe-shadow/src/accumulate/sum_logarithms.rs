//! The sum of the logarithms of many spheres, each turned to where the receiver sees it.

use lobe_sh::{Basis, len};
use pulp::{Arch, Simd, WithSimd};

use crate::accumulate::aim::{ReceiverBlock, SphereReceivers, aim};
use crate::accumulate::lanes::{BLOCK, Block, Lanes};
use crate::accumulate::log_table::{FIT, LogTable, MAX_TABLE_ORDER};
use crate::accumulate::sphere_tree::Node;

/// Coefficients of the highest order.
pub(crate) const MAX_LEN: usize = MAX_TABLE_ORDER * MAX_TABLE_ORDER;

/// The constants of the basis in single precision, column by column of equal `m`:
/// `P̄_m^m` and the steps `P̄_l^m = a z P̄_{l-1}^m - b P̄_{l-2}^m`; see [`lobe_sh::Basis`].
///
/// The plain recurrence, half the operations of the one there, is within 3e-6 to order 8 (test
/// `sums_in_lanes_are_those_of_the_scalar_path`).
#[derive(Clone, Debug)]
pub(crate) struct Columns {
    diagonal: [f32; MAX_TABLE_ORDER],
    steps: [[[f32; 2]; MAX_TABLE_ORDER]; MAX_TABLE_ORDER],
}

impl Columns {
    pub(crate) fn new() -> Self {
        let mut columns =
            Self { diagonal: [0.0; MAX_TABLE_ORDER], steps: [[[0.0; 2]; MAX_TABLE_ORDER]; MAX_TABLE_ORDER] };
        let mut diagonal = (4.0 * std::f64::consts::PI).sqrt().recip();
        for m in 0..MAX_TABLE_ORDER {
            if m > 0 {
                // √2 of the real basis comes in with m = 1.
                let first = if m == 1 { 2.0 } else { 1.0 };
                diagonal *= -(first * (2 * m + 1) as f64 / (2 * m) as f64).sqrt();
            }
            columns.diagonal[m] = diagonal as f32;
            let mut before = f64::INFINITY;
            for l in m + 1..MAX_TABLE_ORDER {
                let a = ((4 * l * l - 1) as f64 / (l * l - m * m) as f64).sqrt();
                columns.steps[m][l] = [a as f32, (a / before) as f32];
                before = a;
            }
        }
        columns
    }
}

/// Adds the logarithms of spheres, as each of sixteen receivers sees them, to `sums`, `n²` blocks.
///
/// With `plane`, receivers are on surfaces, whose planes hide what is below; see [`aim`].
pub(crate) fn add_logarithms(
    arch: Arch,
    table: &LogTable,
    columns: &Columns,
    at: &ReceiverBlock,
    nodes: &[Node],
    plane: bool,
    sums: &mut [Block],
) {
    macro_rules! of_orders {
        ($($n:literal)*) => {
            match (table.order(), plane) {
                $(
                    ($n, true) => arch.dispatch(AddLogarithms::<'_, $n, true> { table, columns, at, nodes, sums }),
                    ($n, false) => arch.dispatch(AddLogarithms::<'_, $n, false> { table, columns, at, nodes, sums }),
                )*
                (order, _) => unreachable!("a table has order 1 to 8, not {order}"),
            }
        };
    }
    of_orders!(1 2 3 4 5 6 7 8);
}

/// To be compiled for the machine's registers, once for each order `N`.
struct AddLogarithms<'a, const N: usize, const PLANE: bool> {
    table: &'a LogTable,
    columns: &'a Columns,
    at: &'a ReceiverBlock,
    nodes: &'a [Node],
    sums: &'a mut [Block],
}

impl<const N: usize, const PLANE: bool> WithSimd for AddLogarithms<'_, N, PLANE> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Some((out, _)) = self.sums.split_at_mut_checked(len(N)) else { return };
        // Arrays of known size, so that no index is checked in the loop.
        let mut fit = [[0.0; FIT]; N];
        fit.iter_mut().zip(&self.table.fit).for_each(|(fit, c)| *fit = *c);
        for part in 0..Lanes::<S>::PARTS {
            let at = SphereReceivers::load(simd, self.at, part);
            let mut sums = [Lanes::splat(simd, 0.0); MAX_LEN];
            for (sum, out) in sums.iter_mut().zip(out.iter()) {
                *sum = Lanes::load(simd, out, part);
            }
            for node in self.nodes {
                let seen = aim::<S, PLANE>(simd, &at, node.center, node.radius);
                let factors = factors::<S, N>(simd, self.table, &fit, seen.sin_squared, node.count);
                add_rotated::<S, N>(simd, self.columns, seen.towards, &factors, &mut sums);
            }
            for (sum, out) in sums.iter().zip(out.iter_mut()) {
                sum.store(out, part);
            }
        }
    }
}

/// `count F_l(u)`, with `u = sin² θ`.
#[inline(always)]
fn factors<S: Simd, const N: usize>(
    simd: S,
    table: &LogTable,
    fit: &[[f32; FIT]; N],
    u: Lanes<S>,
    count: f32,
) -> [Lanes<S>; N] {
    let end = table.fit_end;
    let small = u.min(Lanes::splat(simd, end));
    let x = small.times_plus(Lanes::splat(simd, 2.0 / end), Lanes::splat(simd, -1.0));
    let scaled = small * Lanes::splat(simd, count);
    let mut factors = [scaled; N];
    for l in 0..N {
        let mut p = Lanes::splat(simd, fit[l][FIT - 1]);
        for k in (0..FIT - 1).rev() {
            p = p.times_plus(x, Lanes::splat(simd, fit[l][k]));
        }
        factors[l] = p * scaled;
    }
    if u.any_above(Lanes::splat(simd, end)) {
        let (mut sizes, mut rows) = ([0.0; BLOCK], [[0.0; BLOCK]; N]);
        u.store(&mut sizes, 0);
        for l in 0..N {
            factors[l].store(&mut rows[l], 0);
        }
        look_up(table, &sizes, count, &mut rows);
        for l in 0..N {
            factors[l] = Lanes::load(simd, &rows[l], 0);
        }
    }
    factors
}

/// Takes the factors of large spheres from the rows of the table, lane by lane.
#[cold]
#[inline(never)]
fn look_up<const N: usize>(table: &LogTable, sizes: &Block, count: f32, rows: &mut [Block; N]) {
    for (k, u) in sizes.iter().enumerate().filter(|(_, u)| **u > table.fit_end) {
        let mut exact = [0.0; N];
        table.interpolated(1.0 - (1.0 - u).max(0.0).sqrt(), &mut exact);
        rows.iter_mut().zip(exact).for_each(|(row, exact)| row[k] = count * exact);
    }
}

/// Adds `F_l y_lm(s)` to the sums, column by column of equal `|m|`.
#[inline(always)]
fn add_rotated<S: Simd, const N: usize>(
    simd: S,
    columns: &Columns,
    [x, y, z]: [Lanes<S>; 3],
    factors: &[Lanes<S>; N],
    sums: &mut [Lanes<S>; MAX_LEN],
) {
    let splat = |value| Lanes::splat(simd, value);
    let (mut cos, mut sin) = (splat(1.0), splat(0.0));
    for m in 0..N {
        let (mut before, mut p) = (splat(0.0), splat(columns.diagonal[m]));
        for l in m..N {
            if l > m {
                let [a, b] = columns.steps[m][l];
                (before, p) = (p, (splat(a) * z).times_plus(p, splat(-b) * before));
            }
            let value = factors[l] * p;
            let middle = l * (l + 1);
            if m == 0 {
                sums[middle] = sums[middle] + value;
            } else {
                sums[middle + m] = value.times_plus(cos, sums[middle + m]);
                sums[middle - m] = value.times_plus(sin, sums[middle - m]);
            }
        }
        (cos, sin) = if m == 0 { (x, y) } else { (x * cos - y * sin, x * sin + y * cos) };
    }
}

/// The values of the basis towards one direction, in `f32`, for what is not worth lanes.
pub(crate) fn basis_towards(s: [f32; 3], out: &mut [f32]) {
    let order = out.len().isqrt();
    let mut y = [0.0; 9 * 9];
    let y = &mut y[..out.len()];
    Basis::<f64>::with_shared(order, |basis| basis.eval_into(s.map(f64::from), y));
    out.iter_mut().zip(y.iter()).for_each(|(out, y)| *out = *y as f32);
}
