//! The sum of the logarithms of many spheres, each turned to where the receiver sees it.

use lobe_sh::basis::coefficient_count;
use lobe_sh::simd::{Lanes, Wide, constant};
use pulp::{Arch, Simd, WithSimd};

use crate::accumulate::aim::{ReceiverBlock, ReceiverLanes, aim};
use crate::accumulate::log_table::{FIT, LogTable, MAX_LEN};
use crate::accumulate::monic_columns::MonicColumns;
use crate::accumulate::sphere_tree::Node;

/// Adds the logarithms of spheres, as each of sixteen receivers sees them, to `sums`, `n²` blocks.
///
/// With `plane`, receivers are on surfaces, whose planes hide what is below; see [`aim`].
pub(crate) fn add_logarithms(
    arch: Arch,
    table: &LogTable,
    columns: &MonicColumns,
    at: &ReceiverBlock,
    nodes: &[Node],
    plane: bool,
    sums: &mut [Lanes],
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
    columns: &'a MonicColumns,
    at: &'a ReceiverBlock,
    nodes: &'a [Node],
    sums: &'a mut [Lanes],
}

impl<const N: usize, const PLANE: bool> WithSimd for AddLogarithms<'_, N, PLANE> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Some((out, _)) = self.sums.split_at_mut_checked(coefficient_count(N)) else { return };
        // Arrays of known size, so that no index is checked in the loop.
        let mut fit = [[0.0; FIT]; N];
        fit.iter_mut().zip(&self.table.fit).for_each(|(fit, c)| *fit = *c);
        for part in 0..Wide::<S>::PARTS {
            let at = ReceiverLanes::load(simd, self.at, part);
            let mut sums = [constant(simd, 0.0); MAX_LEN];
            for node in self.nodes {
                let seen = aim::<S, PLANE>(simd, &at, node.center, node.radius);
                let count = node.share.towards(simd, seen.towards) * constant(simd, node.count);
                let mut factors = factors::<S, N>(simd, self.table, &fit, seen.sin_squared, count);
                if node.solid > node.radius {
                    let ratio = node.solid / node.radius;
                    let gain = gain(simd, &fit[0], self.table.fit_end, seen.sin_squared, ratio * ratio);
                    // Array::map is not inlined where the instructions are.
                    for l in 0..N {
                        factors[l] = factors[l] * gain;
                    }
                }
                add_rotated::<S, N>(simd, self.columns, seen.towards, &factors, &mut sums);
            }
            for ((sum, leading), out) in sums.iter().zip(&self.columns.leading).zip(out.iter_mut()) {
                sum.times_plus(constant(simd, *leading), Wide::load(simd, out, part)).store(out, part);
            }
        }
    }
}

/// How much deeper the logarithm of a small part of a solid is than that of a sphere alone.
///
/// The logarithms of small spheres that share what they hide sum to `-O`, with `O` what they hide together, and
/// `exp(-O)` is more than `1 - O`. So each counts as a part of the sphere of the solid's radius around it: by what a
/// unit of
/// `u = sin² θ` has in the mean of its logarithm,
///
/// ```text
///   gain = (F_0(U)/U) / (F_0(u)/u)        U = u ρ²/r²
/// ```
///
/// with `ρ` the radius of the solid; both up to the end of the polynomials.
#[inline(always)]
fn gain<S: Simd>(simd: S, fit: &[f32; FIT], end: f32, u: Wide<S>, ratio: f32) -> Wide<S> {
    let mean_of_unit = |u: Wide<S>| {
        let x = u.min(constant(simd, end)).times_plus(constant(simd, 2.0 / end), constant(simd, -1.0));
        let mut p = constant(simd, fit[FIT - 1]);
        for k in (0..FIT - 1).rev() {
            p = p.times_plus(x, constant(simd, fit[k]));
        }
        p
    };
    let (whole, own) = (mean_of_unit(u * constant(simd, ratio)), mean_of_unit(u));
    // Both are below zero.
    constant(simd, -1.0) * whole * (own * own).inverse_sqrt()
}

/// `count F_l(u)`, with `u = sin² θ`, for as many spheres as `count` says.
#[inline(always)]
fn factors<S: Simd, const N: usize>(
    simd: S,
    table: &LogTable,
    fit: &[[f32; FIT]; N],
    u: Wide<S>,
    count: Wide<S>,
) -> [Wide<S>; N] {
    let end = table.fit_end;
    let small = u.min(constant(simd, end));
    let x = small.times_plus(constant(simd, 2.0 / end), constant(simd, -1.0));
    let scaled = small * count;
    let mut factors = [scaled; N];
    for l in 0..N {
        let mut p = constant(simd, fit[l][FIT - 1]);
        for k in (0..FIT - 1).rev() {
            p = p.times_plus(x, constant(simd, fit[l][k]));
        }
        factors[l] = p * scaled;
    }
    if u.any_above(constant(simd, end)) {
        let (mut sizes, mut counts, mut rows) = (Lanes::ZERO, Lanes::ZERO, [Lanes::ZERO; N]);
        u.store(&mut sizes, 0);
        count.store(&mut counts, 0);
        for l in 0..N {
            factors[l].store(&mut rows[l], 0);
        }
        look_up(table, &sizes, &counts, &mut rows);
        for l in 0..N {
            factors[l] = Wide::load(simd, &rows[l], 0);
        }
    }
    factors
}

/// Takes the factors of large spheres from the rows of the table, lane by lane.
#[cold]
#[inline(never)]
fn look_up<const N: usize>(table: &LogTable, sizes: &Lanes, counts: &Lanes, rows: &mut [Lanes; N]) {
    for (k, u) in sizes.0.iter().enumerate().filter(|(_, u)| **u > table.fit_end) {
        let mut exact = [0.0; N];
        table.interpolated(1.0 - (1.0 - u).max(0.0).sqrt(), &mut exact);
        rows.iter_mut().zip(exact).for_each(|(row, exact)| row[k] = counts[k] * exact);
    }
}

/// Adds `F_l p_l^m(z)` times `C_m` and `S_m` to the sums, column by column of equal `|m|`; their leading coefficients are left
/// for the end.
#[inline(always)]
fn add_rotated<S: Simd, const N: usize>(
    simd: S,
    columns: &MonicColumns,
    [x, y, z]: [Wide<S>; 3],
    factors: &[Wide<S>; N],
    sums: &mut [Wide<S>; MAX_LEN],
) {
    let one = constant(simd, 1.0);
    let (mut cos, mut sin) = (one, one);
    for m in 0..N {
        let (mut before, mut p) = (one, one);
        for l in m..N {
            // Up to m + 1 they are 1 and z.
            if l == m + 1 {
                p = z;
            } else if l > m {
                let b = constant(simd, -columns.steps[m][l]);
                (before, p) = (p, z.times_plus(p, b * before));
            }
            let value = if l == m { factors[l] } else { factors[l] * p };
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
