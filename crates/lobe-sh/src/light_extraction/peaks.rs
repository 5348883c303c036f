//! All local maxima of a function on the sphere.

use core::f64::consts::PI;

use crate::basis::eval_basis;
use crate::basis::index::{coefficient_count, coefficient_index};
use crate::expansion::sh_vec::widened;
use crate::expansion::{Expansion, ShVec};
use crate::once::Once;
use crate::prelude::*;
use crate::solver::bfgs_on_sphere::BfgsAscent;
use crate::sphere::Dir;
use crate::sphere::point_sets::thomson_points;

/// Rows of the grid for each band. With 12 rows one of the 14098 maxima of 2000 random expansions of order 6 was
/// missed, a low hill on a ridge, hardly wider than the grid.
const ROWS_PER_BAND: usize = 16;

/// The fraction of the strongest curvature below which a ridge counts as level, see [`may_be_highest`]. With 0.3, a
/// grid of 12 rows for each band missed one more maximum, of order 5.
const RIDGE_SLACK: f64 = 0.4;

/// The numbers of start points of [Sloan 2008] for orders 1 to 6.
///
/// [Sloan 2008]: https://www.ppsloan.org/publications/StupidSH36.pdf
const PAPER_STARTS: [usize; 6] = [1, 3, 6, 10, 15, 22];

/// A local maximum.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Peak {
    /// Its direction.
    pub dir: Dir,
    /// The value of the function there.
    pub value: f64,
}

/// The starts of the ascents of [`local_maxima`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
pub enum PeakSearch {
    /// Every point of a fine grid that is as high as its eight neighbors. Several times slower than
    /// [`PeakSearch::Paper`] at order 6 (benchmarks `light-peaks-grid` and `light-peaks-paper`).
    #[default]
    Grid,
    /// The 1, 3, 6, 10, 15 or 22 points that [Sloan 2008] gives for orders 1 to 6, solutions of Thomson's problem.
    /// Faster, but an ascent may miss a low hill: of the maxima of random expansions 0.3 to 0.7 % are lost at orders 4
    /// to 6, none at 2 and 3 (test `the_starts_of_the_paper_miss_few_maxima`). Above order 6 the grid is used.
    ///
    /// [Sloan 2008]: https://www.ppsloan.org/publications/StupidSH36.pdf
    Paper,
}

/// All local maxima of `f`, the highest first.
///
/// Ascends by BFGS ([Sloan 2008]) from every start; maxima closer than a thousandth of the shortest wavelength count as
/// one. A constant has none, nor has a function with a coefficient that is not finite; of a ridge of constant height,
/// such as the equator of `-z²`, some points are returned.
///
/// [Sloan 2008]: https://www.ppsloan.org/publications/StupidSH36.pdf
///
/// ```
/// use lobe_sh::light_extraction::{PeakSearch, local_maxima};
/// use lobe_sh::{Dir, ShVec};
///
/// let two = &ShVec::impulse(6, Dir::X, 1.0) + &ShVec::impulse(6, Dir::Z, 0.5);
/// let peaks = local_maxima(&two, PeakSearch::Grid);
/// // The slope of each at the other's place moves the maxima, by 0.019 and 0.059 radians.
/// assert!(peaks[0].dir.angle_to(Dir::X) < 0.02 && peaks[1].dir.angle_to(Dir::Z) < 0.06, "{peaks:?}");
/// ```
#[must_use]
pub fn local_maxima(f: &impl Expansion<f64>, search: PeakSearch) -> Vec<Peak> {
    let f = widened(f);
    let Some(ascent) = BfgsAscent::new(&f) else { return Vec::new() };
    let starts = match (search, PAPER_STARTS.get(f.order() - 1)) {
        (PeakSearch::Paper, Some(_)) => paper_starts(f.order()).to_vec(),
        _ => grid_maxima(&f, ROWS_PER_BAND * f.order(), RIDGE_SLACK),
    };
    ascended(&ascent, starts)
}

/// The ends of the ascents from these points, each once, the highest first.
fn ascended(ascent: &BfgsAscent<'_>, starts: Vec<Dir>) -> Vec<Peak> {
    let mut peaks: Vec<Peak> = Vec::new();
    for start in starts {
        let (dir, value) = ascent.ascend(start);
        match peaks.iter_mut().find(|known| known.dir.angle_to(dir) < ascent.resolution()) {
            Some(known) if known.value >= value => {}
            Some(known) => *known = Peak { dir, value },
            None => peaks.push(Peak { dir, value }),
        }
    }
    peaks.sort_by(|a, b| b.value.total_cmp(&a.value));
    peaks
}

fn paper_starts(order: usize) -> &'static [Dir] {
    static SETS: Once<Vec<Vec<Dir>>> = Once::new();
    let set = |count: &usize| thomson_points(*count).into_iter().map(Dir::from_unit).collect();
    &SETS.get_or_init(|| PAPER_STARTS.iter().map(set).collect())[order - 1]
}

/// The points of a grid in `θ` and `φ`, poles included, near which a maximum may lie.
fn grid_maxima(f: &ShVec<f64>, rows: usize, slack: f64) -> Vec<Dir> {
    let columns = 2 * rows;
    let theta = |row: usize| PI * (row as f64 + 0.5) / rows as f64;
    let values = grid_values(f, rows, columns, theta);
    // Beyond a pole the grid continues on the opposite meridian.
    let at = |row: isize, column: usize| {
        let beyond = row < 0 || row >= rows as isize;
        let row = if row < 0 { 0 } else { row.unsigned_abs().min(rows - 1) };
        values[row * columns + (column + if beyond { rows } else { 0 }) % columns]
    };
    let mut starts = Vec::new();
    for (pole, row) in [(Dir::Z, 0), (-Dir::Z, rows as isize - 1)] {
        let value = f.eval(pole);
        if (0..columns).all(|column| at(row, column) <= value) {
            starts.push(pole);
        }
    }
    for row in 0..rows {
        for column in 0..columns {
            let (west, east) = ((column + columns - 1) % columns, (column + 1) % columns);
            let (row_, value) = (row as isize, values[row * columns + column]);
            let (north, south) = (row_ - 1, row_ + 1);
            let lines = [
                (at(row_, west), at(row_, east)),
                (at(north, column), at(south, column)),
                (at(north, west), at(south, east)),
                (at(north, east), at(south, west)),
            ];
            if may_be_highest(value, lines, slack) {
                starts.push(Dir::from_angles(theta(row), 2.0 * PI * column as f64 / columns as f64));
            }
        }
    }
    starts
}

/// Tells whether a maximum may lie within a cell of a point, from its value and those of its neighbors on four lines.
///
/// A point is as high as both its neighbors on a line if the slope along the line, `|a - b|`, is at most the curvature
/// `2v - a - b`. Along a ridge the curvature is small, and rounding or a neighboring saddle would decide; there a slope
/// up to a fraction of the strongest curvature is accepted.
fn may_be_highest(value: f64, lines: [(f64, f64); 4], slack: f64) -> bool {
    let curvature = |(a, b): (f64, f64)| (value - a) + (value - b);
    let strongest = lines.into_iter().map(curvature).fold(0.0, f64::max);
    lines.into_iter().all(|(a, b)| {
        let curvature = curvature((a, b));
        curvature >= -slack * strongest && (a - b).abs() <= curvature.max(slack * strongest)
    })
}

/// The values of `f` on the grid, row by row: for every row the bands are summed first, then a Fourier sum is left.
///
/// ```text
///   f(θ, φ) = Σ_m (a_m cos mφ + b_m sin mφ)        a_m + i b_m = Σ_l (f_lm + i f_l-m) y_lm(θ, 0)
/// ```
fn grid_values(f: &ShVec<f64>, rows: usize, columns: usize, theta: impl Fn(usize) -> f64) -> Vec<f64> {
    let order = f.order();
    let mut values = vec![0.0; rows * columns];
    let turn = |k: usize| (2.0 * PI * (k % columns) as f64 / columns as f64).sin_cos();
    let turns: Vec<(f64, f64)> = (0..order * columns).map(|k| turn(k / columns * (k % columns))).collect();
    for (row, values) in values.chunks_mut(columns).enumerate() {
        let y = eval_basis(Dir::from_angles(theta(row), 0.0), order);
        debug_assert_eq!(y.len(), coefficient_count(order), "one value for each coefficient");
        for m in 0..order {
            let (mut a, mut b) = (0.0, 0.0);
            for l in m..order {
                let y = y[coefficient_index(l, m as isize)];
                a += f[coefficient_index(l, m as isize)] * y;
                b += f[coefficient_index(l, -(m as isize))] * y;
            }
            if m == 0 {
                b = 0.0;
            }
            for (value, (sin, cos)) in values.iter_mut().zip(&turns[m * columns..]) {
                *value += a * cos + b * sin;
            }
        }
    }
    values
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::basis::basis::Basis;
    use crate::basis::second_order::second_order;
    use crate::extrema::branch_and_bound::newton_descent;
    use lobe_testkit::Random;

    #[test]
    fn the_grid_holds_the_values_of_the_function() {
        let f = ShVec::from_vec(Random::new(1).signed_vec(49)).unwrap();
        let theta = |row: usize| 0.2 + 0.4 * row as f64;
        for (k, value) in grid_values(&f, 7, 20, theta).iter().enumerate() {
            let s = Dir::from_angles(theta(k / 20), 2.0 * PI * (k % 20) as f64 / 20.0);
            assert!((value - f.eval(s)).abs() < 1e-13, "towards {s:?}: {value} against {}", f.eval(s));
        }
    }

    /// Rows of the dense grid for every band: more than four times as many points as [`PeakSearch::Grid`] looks at.
    const DENSE_ROWS_PER_BAND: usize = 33;

    /// The maxima that a dense grid finds, each once: every point of it as high as its eight neighbors, followed
    /// uphill by the Newton steps of the certified minimum, which share nothing with the ascents of the search.
    fn dense_maxima(f: &ShVec<f64>) -> Vec<Dir> {
        let rows = DENSE_ROWS_PER_BAND * f.order();
        let columns = 2 * rows;
        let theta = |row: usize| PI * (row as f64 + 0.5) / rows as f64;
        let values = grid_values(f, rows, columns, theta);
        let at = |row: usize, column: usize| values[row * columns + column % columns];
        let is_highest = |row: usize, column: usize| {
            let value = at(row, column);
            let (west, east) = (column + columns - 1, column + 1);
            at(row, west) <= value
                && at(row, east) <= value
                && [row.wrapping_sub(1), row + 1].into_iter().all(|other| {
                    // Over a pole the grid goes on half way round.
                    let (other, turn) = if other < rows { (other, 0) } else { (row, rows) };
                    [west, column, east].into_iter().all(|c| at(other, c + turn) <= value)
                })
        };
        let negative: Vec<f64> = f.coefficients().iter().map(|c| -c).collect();
        let steepness = f.order() as f64 * f.dot(f).sqrt();
        let mut maxima: Vec<Dir> = Vec::new();
        Basis::<f64>::with_shared(f.order(), |basis| {
            let evaluate = |s: [f64; 3]| second_order(basis, &negative, &[s])[0];
            for row in 0..rows {
                for column in (0..columns).filter(|column| is_highest(row, *column)) {
                    let start = Dir::from_angles(theta(row), 2.0 * PI * column as f64 / columns as f64);
                    let mut local = evaluate(start.to_array());
                    loop {
                        local = newton_descent(local, f.order(), evaluate);
                        // Where a whole Newton step does not help, a short one along the slope does, but at the top.
                        let [a, b] = local.gradient;
                        let steps = (0..40).map(|k| 0.3 * 0.5_f64.powi(k) / f.order() as f64 / a.hypot(b));
                        let shorter = steps.map(|step| evaluate(local.step([-step * a, -step * b])));
                        let is_steep = a.hypot(b) > 1e-8 * steepness;
                        match shorter.into_iter().find(|next| is_steep && next.value < local.value) {
                            Some(next) => local = next,
                            None => break,
                        }
                    }
                    let top = Dir::from_unit(local.s);
                    if maxima.iter().all(|known| known.angle_to(top) > 1e-3) {
                        maxima.push(top);
                    }
                }
            }
        });
        maxima
    }

    /// How many of the dense maxima of `count` random expansions a search finds, how many there are, and how many
    /// maxima the search has beyond them.
    fn found_of(order: usize, count: u64, search: PeakSearch) -> (usize, usize, usize) {
        let (mut found, mut total, mut beyond) = (0, 0, 0);
        for seed in 0..count {
            let f = ShVec::from_vec(Random::new(1000 * order as u64 + seed).signed_vec(order * order)).unwrap();
            let peaks = local_maxima(&f, search);
            let dense = dense_maxima(&f);
            total += dense.len();
            found += dense.iter().filter(|top| peaks.iter().any(|p| p.dir.angle_to(**top) < 1e-3)).count();
            beyond += peaks.iter().filter(|p| dense.iter().all(|top| p.dir.angle_to(*top) >= 1e-3)).count();
        }
        (found, total, beyond)
    }

    #[test]
    fn the_search_finds_every_maximum_that_a_dense_grid_finds() {
        // How many maxima 2000 such expansions have, to 5 % of 500: one, 1.84 and so on each.
        for (order, expected) in [(2, 2000_usize), (3, 3681), (4, 6360), (5, 9801), (6, 14_098)] {
            let (found, total, beyond) = found_of(order, 500, PeakSearch::Grid);
            println!("order {order}: {found} of {total} maxima, {beyond} more");
            assert_eq!(found, total, "order {order}: maxima of 500 expansions");
            let expected = expected / 4;
            assert!(total.abs_diff(expected) <= expected / 20, "order {order}: {total} maxima, expected {expected}");
            assert!(beyond <= 2, "order {order}: {beyond} maxima are not those of a dense grid");
        }
    }

    #[test]
    fn the_starts_of_the_paper_miss_few_maxima() {
        for order in 2..=6 {
            let (found, total, _) = found_of(order, 400, PeakSearch::Paper);
            println!("order {order}: {found} of {total} maxima from the starts of the paper");
            assert!(found as f64 >= 0.992 * total as f64, "order {order}: {found} of {total}");
            assert!(order > 3 || found == total, "order {order}: {found} of {total}");
        }
    }

    #[test]
    fn an_impulse_is_found_wherever_it_points() {
        const ORDERS: [usize; 4] = [2, 3, 6, 9];
        /// The directions before the Fibonacci sphere.
        const EXCEPTIONAL: usize = 53;
        for (k, v) in lobe_testkit::directions().into_iter().enumerate() {
            let s = Dir::from_unit(v);
            // All orders at the axes, poles and seam, one in turn all over the sphere.
            let orders = if k < EXCEPTIONAL { &ORDERS[..] } else { &ORDERS[k % ORDERS.len()..][..1] };
            for &order in orders {
                let f = ShVec::impulse(order, s, 2.0);
                for search in [PeakSearch::Grid, PeakSearch::Paper] {
                    let peak = local_maxima(&f, search)[0];
                    assert!(peak.dir.angle_to(s) < 1e-7, "order {order}, {search:?}: {peak:?} for {v:?}");
                    assert!((peak.value - f.eval(s)).abs() < 1e-13, "order {order}: {peak:?}");
                }
            }
        }
    }

    #[test]
    fn a_climb_leaves_a_saddle_and_a_minimum() {
        // xy: maxima at ±45° in the plane, saddles at the poles; -z: a minimum at the zenith.
        let saddle = crate::project(3, 2, |s| s.x() * s.y());
        let (top, value) = BfgsAscent::new(&saddle).unwrap().ascend(Dir::Z);
        assert!((value - 0.5).abs() < 1e-12, "{top:?}: {value}");
        let below = crate::project(2, 1, |s| -s.z());
        let (top, value) = BfgsAscent::new(&below).unwrap().ascend(Dir::Z);
        assert!((value - 1.0).abs() < 1e-12, "{top:?}: {value}");
    }

    #[test]
    fn what_has_no_hills_has_no_maxima() {
        let nan = ShVec::from_vec(vec![0.0, f64::NAN, 0.0, 0.0]).unwrap();
        for f in [ShVec::zero(0), ShVec::zero(4), ShVec::constant(3, 2.0), ShVec::constant(1, 1.0), nan] {
            for search in [PeakSearch::Grid, PeakSearch::Paper] {
                assert!(local_maxima(&f, search).is_empty(), "{f:?}");
            }
        }
        let ridge = crate::project(3, 2, |s| -s.z() * s.z());
        let peaks = local_maxima(&ridge, PeakSearch::Grid);
        assert!(!peaks.is_empty() && peaks.iter().all(|p| p.value.abs() < 1e-13), "{peaks:?}");
    }
}
