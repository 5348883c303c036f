//! Values of many functions towards many vectors:
//!
//! ```text
//!   f_j(s_k) = Σ_i c_ji y_i(s_k)
//! ```
//!
//! A product of matrices, of which the second is computed tile by tile of directions and stays in the first-level cache. Sums of some
//! functions and directions stay in registers. Each runs over the functions of the basis in the order of its recurrence, product and sum
//! rounded together where the machine can, so that a value does not depend on what else is computed.

use alloc::vec::Vec;
use core::ops::Range;

use pulp::{Scalar, Simd};

use crate::basis::basis::Basis;
use crate::basis::index::coefficient_count;
use crate::basis::lane_basis::TILE;
use crate::basis::lane_kernels::LaneKernels;
use crate::basis::lane_rows::{column_order, tile_rows};
use crate::basis::lane_sums::{Directions, EvalSums};
use crate::basis::recurrence::Constants;
use crate::basis::vectors::Vectors;
use crate::simd::{Kernel, Lane, Machine, Wide};

/// Functions whose coefficients lie side by side: as many sums, with two registers of directions each, have room in 32 registers.
const GROUP: usize = 8;

/// Functions whose sums are in registers at a time where there are 16 of them.
const HALF: usize = 4;

/// Registers of directions that have their sums side by side.
const REGISTERS: usize = 2;

/// Bytes of the registers of machines that have 32.
const WIDEST: usize = 64;

/// Functions of one order, ready to be evaluated: of numbers or of colors.
///
/// ```
/// use lobe_sh::basis::Vectors;
/// use lobe_sh::batch::Functions;
///
/// // A constant and z, towards two vectors of any length.
/// let norm = (4.0 * std::f64::consts::PI).sqrt();
/// let numbers = [norm, 0.0, 0.0, 0.0, 0.0, 0.0, norm / 3.0_f64.sqrt(), 0.0];
/// let functions = Functions::new(&numbers, 2, 1);
/// let (mut one, mut z) = ([0.0; 2], [0.0; 2]);
/// let all_have_directions =
///     functions.eval_into(Vectors::Double(&[[0.0, 0.0, 7.0], [3.0, 0.0, -4.0]]), &mut [&mut one, &mut z]);
/// assert!(all_have_directions && (one[1] - 1.0).abs() < 1e-15 && (z[1] + 0.8).abs() < 1e-15);
/// ```
#[derive(Clone, Debug)]
pub struct Functions<'a, T> {
    functions: &'a [T],
    order: usize,
    channels: usize,
    /// Functions of numbers, a color being three, eight side by side: coefficient after coefficient of these, in the order of the recurrence.
    groups: Vec<[T; GROUP]>,
    /// Functions of numbers.
    count: usize,
}

impl<'a, T: Tiled> Functions<'a, T> {
    /// Of functions one after the other, of `channels` numbers a coefficient, 1 or 3.
    ///
    /// # Panics
    /// If the order is 0, there are other channels, or the numbers are not those of some functions.
    #[must_use]
    pub fn new(functions: &'a [T], order: usize, channels: usize) -> Self {
        let size = coefficient_count(order);
        assert!(order > 0 && matches!(channels, 1 | 3), "order {order}, {channels} channels");
        assert!(
            functions.len().is_multiple_of(size * channels),
            "{} numbers of functions of order {order}",
            functions.len()
        );
        let count = functions.len() / size;
        let mut made = Self { functions, order, channels, groups: Vec::new(), count };
        // Of one function the sums are made where its values are.
        if count > channels {
            made.groups = made.grouped();
        }
        made
    }

    /// The coefficients, group after group.
    fn grouped(&self) -> Vec<[T; GROUP]> {
        let (size, channels) = (coefficient_count(self.order), self.channels);
        let mut groups = vec![[T::ZERO; GROUP]; self.count.div_ceil(GROUP) * size];
        let columns = column_order(self.order);
        for j in 0..self.count {
            let function = &self.functions[j / channels * size * channels + j % channels..];
            for (group, i) in groups[j / GROUP * size..][..size].iter_mut().zip(&columns) {
                group[j % GROUP] = function[i * channels];
            }
        }
        groups
    }

    /// Writes the values of each function towards all vectors, of any length above zero, to its row, those of colors one after the other. False if a vector has
    /// no direction; values towards it are then not finite.
    ///
    /// # Panics
    /// If there are not as many rows as functions, or one has not a place for each value.
    pub fn eval_into(&self, vectors: Vectors<'_>, rows: &mut [&mut [T]]) -> bool {
        self.eval_by(Machine::detect(), vectors, rows)
    }

    fn eval_by(&self, machine: Machine, vectors: Vectors<'_>, rows: &mut [&mut [T]]) -> bool {
        self.assert_rows(vectors.len(), rows);
        let order = self.order;
        Basis::<T>::with_shared(order, |basis| {
            let constants = basis.constants();
            if let [row] = rows {
                let directions = Directions::Vectors(vectors);
                return if self.channels == 1 {
                    T::sums(machine, EvalSums { constants, coefficients: self.functions, order, directions, out: row })
                } else {
                    T::color_sums(
                        machine,
                        EvalSums { constants, coefficients: self.functions, order, directions, out: row },
                    )
                };
            }
            // A tile of the basis after the other, which stays in the first-level cache.
            let mut y = vec![[T::ZERO; TILE]; coefficient_count(order)];
            let mut all = true;
            for t in 0..vectors.len().div_ceil(TILE) {
                let tile = vectors.tile(t);
                all &= T::fill(machine, Fill { vectors: tile, constants, order, y: &mut y });
                let first = t * TILE;
                let range = first..first + tile.len();
                T::multiply(machine, Multiply { functions: self, groups: &self.groups, y: &y, range, rows });
            }
            all
        })
    }

    /// The same towards directions whose basis is known.
    ///
    /// # Panics
    /// As [`Functions::eval_into`], or if the orders differ.
    pub fn eval_tiles_into(&self, tiles: &BasisTiles<T>, rows: &mut [&mut [T]]) {
        self.eval_tiles_by(Machine::detect(), tiles, rows);
    }

    fn eval_tiles_by(&self, machine: Machine, tiles: &BasisTiles<T>, rows: &mut [&mut [T]]) {
        assert_eq!(self.order, tiles.order, "orders of functions and of the basis");
        self.assert_rows(tiles.count, rows);
        let made = if self.groups.is_empty() { self.grouped() } else { Vec::new() };
        let groups = if self.groups.is_empty() { &made } else { &self.groups };
        for (t, y) in tiles.y.chunks_exact(coefficient_count(self.order)).enumerate() {
            let range = t * TILE..tiles.count.min((t + 1) * TILE);
            T::multiply(machine, Multiply { functions: self, groups, y, range, rows });
        }
    }

    fn assert_rows(&self, vectors: usize, rows: &[&mut [T]]) {
        assert_eq!(rows.len() * self.channels, self.count, "rows for functions");
        for row in rows {
            assert_eq!(row.len(), vectors * self.channels, "places in a row");
        }
    }
}

/// The basis towards directions, tile by tile of them.
#[derive(Clone, Debug)]
pub struct BasisTiles<T> {
    order: usize,
    count: usize,
    /// Of each tile a row of values for each function of the basis.
    y: Vec<[T; TILE]>,
}

impl<T: Tiled> BasisTiles<T> {
    /// Of no directions.
    #[must_use]
    pub fn new(order: usize) -> Self {
        Self { order, count: 0, y: Vec::new() }
    }

    /// Of the directions of vectors, in the same memory. False if one has none.
    pub fn fill(&mut self, vectors: Vectors<'_>) -> bool {
        self.fill_by(Machine::detect(), vectors)
    }

    fn fill_by(&mut self, machine: Machine, vectors: Vectors<'_>) -> bool {
        let size = coefficient_count(self.order);
        self.count = vectors.len();
        self.y.resize(self.count.div_ceil(TILE) * size, [T::ZERO; TILE]);
        let order = self.order;
        Basis::<T>::with_shared(order, |basis| {
            T::fill(machine, Fill { vectors, constants: basis.constants(), order, y: &mut self.y })
        })
    }
}

/// The basis towards the directions of vectors, tile after tile.
#[derive(Debug)]
pub struct Fill<'a, T> {
    vectors: Vectors<'a>,
    constants: &'a Constants<T>,
    order: usize,
    y: &'a mut [[T; TILE]],
}

impl<T: Lane> Kernel for Fill<'_, T> {
    type Output = bool;

    #[inline(always)]
    fn wide<S: Simd>(self, simd: S) -> bool {
        let mut tile = [[T::ZERO; TILE]; 3];
        let mut all = true;
        for (t, y) in self.y.chunks_exact_mut(coefficient_count(self.order)).enumerate() {
            all &= self.vectors.tile(t).unit_into(simd, &mut tile);
            tile_rows(simd, self.constants, self.order, &tile, y, 1);
        }
        all
    }

    fn plain(self) -> bool {
        let mut tile = [[T::ZERO; TILE]; 3];
        let mut all = true;
        for (t, y) in self.y.chunks_exact_mut(coefficient_count(self.order)).enumerate() {
            all &= self.vectors.tile(t).unit_into_plain(&mut tile);
            let mut rows = y.iter_mut();
            self.constants.for_each_in_block(tile, self.order, |_, values| {
                if let Some(row) = rows.next() {
                    *row = *values;
                }
            });
        }
        all
    }
}

/// The values of all functions towards the directions of a tile, which are `range` of all.
#[derive(Debug)]
pub struct Multiply<'a, 'b, T> {
    functions: &'a Functions<'a, T>,
    groups: &'a [[T; GROUP]],
    y: &'a [[T; TILE]],
    range: Range<usize>,
    rows: &'a mut [&'b mut [T]],
}

impl<T: Lane> Kernel for Multiply<'_, '_, T> {
    type Output = ();

    #[inline(always)]
    fn wide<S: Simd>(self, simd: S) {
        let Self { functions, groups, y, range, rows } = self;
        let mut sums = [[T::ZERO; TILE]; GROUP];
        let mut store = Store { channels: functions.channels, range, rows };
        for (g, group) in groups.chunks_exact(y.len()).enumerate() {
            let first = g * GROUP;
            let count = GROUP.min(functions.count - first);
            if T::count::<S>() * size_of::<T>() == WIDEST && count > HALF {
                tile_sums::<S, T, GROUP>(simd, group, 0, y, &mut sums);
            } else {
                tile_sums::<S, T, HALF>(simd, group, 0, y, &mut sums);
                if count > HALF {
                    tile_sums::<S, T, HALF>(simd, group, HALF, y, &mut sums);
                }
            }
            store.store(first, &sums[..count]);
        }
    }

    fn plain(self) {
        self.wide(Scalar::new());
    }
}

/// `f32` or `f64`, for which the kernels of this file are compiled here, once, and not where they are called.
pub trait Tiled: LaneKernels {
    #[doc(hidden)]
    fn fill(machine: Machine, kernel: Fill<'_, Self>) -> bool;

    #[doc(hidden)]
    fn multiply(machine: Machine, kernel: Multiply<'_, '_, Self>);
}

macro_rules! tiled {
    ($($number:ty),*) => {$(
        impl Tiled for $number {
            fn fill(machine: Machine, kernel: Fill<'_, Self>) -> bool {
                machine.run(kernel)
            }

            fn multiply(machine: Machine, kernel: Multiply<'_, '_, Self>) {
                machine.run(kernel);
            }
        }
    )*};
}

tiled!(f32, f64);

/// The sums of `COUNT` functions of a group, from `first` on, over a whole tile.
#[inline(always)]
fn tile_sums<S: Simd, T: Lane, const COUNT: usize>(
    simd: S,
    group: &[[T; GROUP]],
    first: usize,
    y: &[[T; TILE]],
    out: &mut [[T; TILE]; GROUP],
) {
    for register in (0..TILE / T::count::<S>()).step_by(REGISTERS) {
        let mut sums = [[Wide::splat(simd, T::ZERO); REGISTERS]; COUNT];
        for (c, y) in group.iter().zip(y) {
            let mut values = [Wide::splat(simd, T::ZERO); REGISTERS];
            for r in 0..REGISTERS {
                values[r] = Wide::load_array(simd, y, register + r);
            }
            for j in 0..COUNT {
                let c = Wide::splat(simd, c[first + j]);
                for r in 0..REGISTERS {
                    sums[j][r] = values[r].times_plus(c, sums[j][r]);
                }
            }
        }
        for j in 0..COUNT {
            for r in 0..REGISTERS {
                sums[j][r].store_array(&mut out[first + j], register + r);
            }
        }
    }
}

/// The places of the directions of a tile in the rows of all functions.
struct Store<'a, 'b, T> {
    channels: usize,
    range: Range<usize>,
    rows: &'a mut [&'b mut [T]],
}

impl<T: Lane> Store<'_, '_, T> {
    /// The values of functions of numbers from `first` on.
    #[inline(always)]
    fn store(&mut self, first: usize, sums: &[[T; TILE]]) {
        let channels = self.channels;
        for (j, sums) in (first..).zip(sums) {
            let row = &mut self.rows[j / channels][self.range.start * channels..self.range.end * channels];
            if channels == 1 {
                row.copy_from_slice(&sums[..row.len()]);
            } else {
                for (color, value) in row.chunks_exact_mut(channels).zip(sums) {
                    color[j % channels] = *value;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use lobe_testkit::Random;

    use super::*;
    use crate::basis::basis::eval_basis_into;

    /// Orders with straight-line code and without.
    const ORDERS: [usize; 5] = [1, 4, 10, 11, 40];

    /// Vectors of all lengths that numbers have.
    fn vectors(count: usize) -> Vec<[f64; 3]> {
        let mut random = Random::new(count as u64);
        let length = |k: usize| 10_f64.powi([0, 3, -5, 20][k % 4]);
        (0..count).map(|k| random.direction().map(|c| c * length(k))).collect()
    }

    /// The values of functions of some channels towards vectors, all of which have a direction.
    fn values<T: Tiled>(machine: Machine, c: &[T], order: usize, channels: usize, vectors: Vectors<'_>) -> Vec<T> {
        let rows = c.len() / coefficient_count(order) / channels;
        let mut out = vec![T::ZERO; rows * vectors.len() * channels];
        let functions = Functions::new(c, order, channels);
        let mut rows: Vec<&mut [T]> = out.chunks_exact_mut(vectors.len() * channels).collect();
        assert!(functions.eval_by(machine, vectors, &mut rows), "{}: vectors have directions", machine.name());
        out
    }

    /// Against sums over single directions, relative to the norm of a function.
    fn assert_values<T: Tiled>(limit: f64) {
        let doubles = vectors(70);
        let singles: Vec<[f32; 3]> = doubles.iter().map(|v| v.map(|c| c as f32)).collect();
        for (machine, order) in Machine::available().flat_map(|machine| ORDERS.map(|order| (machine, order))) {
            let size = coefficient_count(order);
            for (rows, channels) in [(1, 1), (1, 3), (2, 1), (4, 3), (9, 1), (16, 1)] {
                let c: Vec<f64> = Random::new(3).signed_vec(rows * size * channels);
                let rounded: Vec<T> = c.iter().map(|c| T::from_f64(*c)).collect();
                for towards in [Vectors::Double(&doubles), Vectors::Single(&singles)] {
                    let found = values(machine, &rounded, order, channels, towards);
                    let mut y = vec![0.0; size];
                    for (k, v) in doubles.iter().enumerate() {
                        let length = v.iter().map(|c| c * c).sum::<f64>().sqrt();
                        eval_basis_into(v.map(|c| c / length), &mut y);
                        for (j, channel) in (0..rows).flat_map(|j| (0..channels).map(move |channel| (j, channel))) {
                            let c = &c[j * size * channels + channel..];
                            let expected: f64 = y.iter().zip(c.iter().step_by(channels)).map(|(y, c)| y * c).sum();
                            let found = found[(j * doubles.len() + k) * channels + channel].to_f64();
                            // A direction that is rounded moves the values by its error times their slope.
                            let limit = if matches!(towards, Vectors::Single(_)) { limit.max(1e-6) } else { limit };
                            assert!(
                                (found - expected).abs() < limit * (order * order) as f64,
                                "{}, order {order}, function {j} of {rows}, channel {channel}, {v:?}: {found}, {expected}",
                                machine.name()
                            );
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn every_machine_has_the_values_of_single_directions() {
        assert_values::<f64>(1e-14);
        assert_values::<f32>(1e-6);
    }

    #[test]
    fn a_value_does_not_depend_on_what_else_is_computed() {
        let all = vectors(75);
        for (machine, order) in Machine::available().flat_map(|machine| ORDERS.map(|order| (machine, order))) {
            let size = coefficient_count(order);
            let c: Vec<f64> = Random::new(5).signed_vec(13 * size);
            let together = values(machine, &c, order, 1, Vectors::Double(&all));
            for (j, c) in c.chunks_exact(size).enumerate() {
                let alone = values(machine, c, order, 1, Vectors::Double(&all));
                assert_eq!(alone, together[j * all.len()..][..all.len()], "{}, order {order}", machine.name());
            }
            for k in [0, 40, 74] {
                let alone = values(machine, &c, order, 1, Vectors::Double(&all[k..=k]));
                let among: Vec<f64> = together.iter().skip(k).step_by(all.len()).copied().collect();
                assert_eq!(alone, among, "{}, order {order}, direction {k}", machine.name());
            }
            let mut tiles = BasisTiles::new(order);
            assert!(tiles.fill_by(machine, Vectors::Double(&all)), "directions");
            for count in [1, 13] {
                let mut out = vec![f64::NAN; count * all.len()];
                let mut rows: Vec<&mut [f64]> = out.chunks_exact_mut(all.len()).collect();
                Functions::new(&c[..count * size], order, 1).eval_tiles_by(machine, &tiles, &mut rows);
                assert_eq!(out, together[..out.len()], "{}, order {order}, {count} by tiles", machine.name());
            }
        }
    }

    #[test]
    fn what_has_no_direction_is_told_whatever_its_length() {
        let c: Vec<f64> = Random::new(7).signed_vec(16);
        let single: Vec<f32> = c.iter().map(|c| *c as f32).collect();
        for machine in Machine::available() {
            for bad in [[0.0; 3], [f64::NAN, 0.0, 1.0], [0.0, f64::INFINITY, 0.0]] {
                let mut all = vectors(40);
                all[33] = bad;
                let (mut out, mut out_single) = (vec![0.0; 40], vec![0.0_f32; 40]);
                let fine = Functions::new(&c, 4, 1).eval_by(machine, Vectors::Double(&all), &mut [&mut out]);
                let singles: Vec<[f32; 3]> = all.iter().map(|v| v.map(|c| c as f32)).collect();
                let functions = Functions::new(&single, 4, 1);
                let fine_single = functions.eval_by(machine, Vectors::Single(&singles), &mut [&mut out_single]);
                assert!(!fine && !fine_single, "{}: {bad:?}", machine.name());
                assert!(!out[33].is_finite() && !out_single[33].is_finite(), "{}: {bad:?}", machine.name());
                assert!(out[32].is_finite() && out[34].is_finite(), "{}: beside {bad:?}", machine.name());
            }
            for length in [1e-300, 1e300] {
                let found = values(machine, &c, 4, 1, Vectors::Double(&[[0.0, 0.6 * length, -0.8 * length]]));
                let expected = values(machine, &c, 4, 1, Vectors::Double(&[[0.0, 0.6, -0.8]]));
                assert!((found[0] - expected[0]).abs() < 1e-14, "{} at {length}: {found:?}", machine.name());
            }
        }
    }
}
