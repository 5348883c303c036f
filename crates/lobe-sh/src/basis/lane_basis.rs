//! The basis towards many directions by the registers of the machine: orders 1 to 10 by straight-line code, any other by the
//! recurrence.

use pulp::Simd;

use crate::basis::lane_recurrence::{PlacesTogether, recurrence};
use crate::basis::lanes;
use crate::basis::places::Places;
use crate::basis::recurrence::Constants;
use crate::simd::{Kernel, Lane, Machine, Wide};

/// The highest order that has straight-line code.
pub(crate) const HIGHEST_ORDER: usize = 10;

/// The lowest order that planes have code for: below, the plain code is as quick.
const LOWEST_IN_PLANES: usize = 3;

/// Directions of a tile, whole registers of every machine.
pub(crate) const TILE: usize = 32;

/// The components of as many unit vectors.
pub(crate) type Tile<T> = [[T; TILE]; 3];

/// Where the values of a tile go, some registers at a time.
pub(crate) trait TilePlaces<S: Simd, T: Lane>: Places<S, T> + PlacesTogether<S, T> {
    /// The values of registers from `first` on follow.
    fn begin(&mut self, first: usize);

    /// The values of `count` registers have been put.
    fn end(&mut self, count: usize);
}

/// Straight-line code of one order.
#[inline(always)]
pub(crate) fn basis<S: Simd, T: Lane>(simd: S, order: usize, s: [Wide<S, T>; 3], out: &mut impl Places<S, T>) {
    match order {
        1 => lanes::order_1::basis(simd, s, out),
        2 => lanes::order_2::basis(simd, s, out),
        3 => lanes::order_3::basis(simd, s, out),
        4 => lanes::order_4::basis(simd, s, out),
        5 => lanes::order_5::basis(simd, s, out),
        6 => lanes::order_6::basis(simd, s, out),
        7 => lanes::order_7::basis(simd, s, out),
        8 => lanes::order_8::basis(simd, s, out),
        9 => lanes::order_9::basis(simd, s, out),
        10 => lanes::order_10::basis(simd, s, out),
        _ => {}
    }
}

/// The values of all functions towards a tile of directions, column by column of equal `|m|`.
#[inline(always)]
pub(crate) fn tile_basis<S: Simd, T: Lane>(
    simd: S,
    constants: &Constants<T>,
    order: usize,
    tile: &Tile<T>,
    out: &mut impl TilePlaces<S, T>,
) {
    let registers = TILE / T::count::<S>();
    if order <= HIGHEST_ORDER {
        for r in 0..registers {
            out.begin(r);
            let [x, y, z] = tile;
            let s = [Wide::load_array(simd, x, r), Wide::load_array(simd, y, r), Wide::load_array(simd, z, r)];
            basis(simd, order, s, out);
            out.end(1);
        }
    } else if registers >= 4 {
        tile_recurrence::<S, T, 4>(simd, constants, order, tile, out);
    } else {
        tile_recurrence::<S, T, 2>(simd, constants, order, tile, out);
    }
}

/// By `R` registers at a time.
#[inline(always)]
fn tile_recurrence<S: Simd, T: Lane, const R: usize>(
    simd: S,
    constants: &Constants<T>,
    order: usize,
    tile: &Tile<T>,
    out: &mut impl TilePlaces<S, T>,
) {
    for first in (0..TILE / T::count::<S>()).step_by(R) {
        let mut s = [[Wide::splat(simd, T::ZERO); R]; 3];
        for axis in 0..3 {
            for r in 0..R {
                s[axis][r] = Wide::load_array(simd, &tile[axis], first + r);
            }
        }
        out.begin(first);
        recurrence::<S, T, R>(simd, constants, order, &s, out);
        out.end(R);
    }
}

/// The values of a tile from `start` on in planes of `stride` values, one for each function.
struct Planes<'a, T> {
    values: &'a mut [T],
    stride: usize,
    start: usize,
    first: usize,
}

impl<S: Simd, T: Lane> Places<S, T> for Planes<'_, T> {
    #[inline(always)]
    fn put(&mut self, i: usize, value: Wide<S, T>) {
        self.put_register(i, 0, value);
    }
}

impl<S: Simd, T: Lane> PlacesTogether<S, T> for Planes<'_, T> {
    #[inline(always)]
    fn put_register(&mut self, i: usize, r: usize, value: Wide<S, T>) {
        // An array, not a slice: its length is known at compile time.
        if let Some(place) = self.values[i * self.stride + self.start..].first_chunk_mut::<TILE>() {
            value.store_array(place, self.first + r);
        }
    }
}

impl<S: Simd, T: Lane> TilePlaces<S, T> for Planes<'_, T> {
    #[inline(always)]
    fn begin(&mut self, first: usize) {
        self.first = first;
    }

    #[inline(always)]
    fn end(&mut self, _: usize) {}
}

/// `Basis::eval_many_into` of as many directions as are whole tiles, if the machine and the order have code for it; the
/// number of directions that are done.
pub(crate) fn eval_planes<T: Lane>(
    machine: Machine,
    constants: &Constants<T>,
    order: usize,
    components: [&[T]; 3],
    out: &mut [T],
) -> usize {
    if order < LOWEST_IN_PLANES || machine.is_plain() {
        return 0;
    }
    constants.assert_reaches(order);
    machine.run(EvalPlanes { constants, order, components, out })
}

struct EvalPlanes<'a, T> {
    constants: &'a Constants<T>,
    order: usize,
    components: [&'a [T]; 3],
    out: &'a mut [T],
}

impl<T: Lane> Kernel for EvalPlanes<'_, T> {
    type Output = usize;

    #[inline(always)]
    fn wide<S: Simd>(self, simd: S) -> usize {
        let stride = self.components[0].len();
        let mut places = Planes { values: self.out, stride, start: 0, first: 0 };
        let [x, y, z] = self.components;
        for ((x, y), z) in x.as_chunks().0.iter().zip(y.as_chunks().0).zip(z.as_chunks().0) {
            tile_basis(simd, self.constants, self.order, &[*x, *y, *z], &mut places);
            places.start += TILE;
        }
        places.start
    }

    fn plain(self) -> usize {
        0
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use alloc::vec::Vec;

    use super::*;
    use crate::basis::lane_sums::eval_sums;
    use crate::{coefficient_count, eval_basis_into};

    /// The error that single directions are tested for at order 20.
    const ERROR: f64 = 1.5e-6;

    /// Directions in general, and next to the poles, where errors are largest.
    pub(crate) fn directions() -> Vec<[f32; 3]> {
        let mut random = lobe_testkit::Random::new(20);
        let near_poles = (0..200).map(|_| {
            let [x, y, z] = random.direction();
            crate::Dir::new([0.05 * x, 0.05 * y, z.signum()]).unwrap().to_array()
        });
        let mut all: Vec<[f64; 3]> = lobe_testkit::directions().into_iter().chain(near_poles).collect();
        all.truncate(all.len() / TILE * TILE);
        all.into_iter().map(|s| s.map(|c| c as f32)).collect()
    }

    pub(crate) fn assert_close(found: f32, order: usize, i: usize, s: [f32; 3], what: &str) {
        let mut y = vec![0.0; coefficient_count(order)];
        eval_basis_into(s.map(f64::from), &mut y);
        let off = (f64::from(found) - y[i]).abs();
        assert!(off < ERROR, "{what}, order {order}, y_{i} towards {s:?}: {found} against {}", y[i]);
    }

    /// Orders with straight-line code and without.
    fn orders() -> impl Iterator<Item = usize> {
        (LOWEST_IN_PLANES..=HIGHEST_ORDER + 2).chain([20])
    }

    #[test]
    fn every_machine_evaluates_planes_as_single_directions() {
        let all = directions();
        let component = |axis: usize| all.iter().map(|s| s[axis]).collect::<Vec<f32>>();
        let (x, y, z) = (component(0), component(1), component(2));
        for order in orders() {
            let constants = Constants::new(order);
            for machine in Machine::available().filter(|machine| !machine.is_plain()) {
                let mut out = vec![f32::NAN; coefficient_count(order) * all.len()];
                let done = eval_planes(machine, &constants, order, [&x, &y, &z], &mut out);
                assert_eq!(done, all.len(), "whole tiles");
                for (k, s) in all.iter().enumerate() {
                    for i in 0..coefficient_count(order) {
                        assert_close(out[i * all.len() + k], order, i, *s, machine.name());
                    }
                }
            }
        }
    }

    #[test]
    fn every_machine_evaluates_planes_and_sums_in_double_precision() {
        let all: Vec<[f64; 3]> =
            directions().into_iter().map(|s| crate::Dir::new(s.map(f64::from)).unwrap().to_array()).collect();
        let component = |axis: usize| all.iter().map(|s| s[axis]).collect::<Vec<f64>>();
        let (x, y, z) = (component(0), component(1), component(2));
        for order in orders() {
            let (constants, count) = (Constants::new(order), coefficient_count(order));
            let c = lobe_testkit::Random::new(8).signed_vec(count);
            for machine in Machine::available().filter(|machine| !machine.is_plain()) {
                let (mut out, mut sums) = (vec![f64::NAN; count * all.len()], vec![f64::NAN; all.len()]);
                let done = eval_planes(machine, &constants, order, [&x, &y, &z], &mut out);
                let summed = eval_sums(machine, &constants, &c, order, [&x, &y, &z], &mut sums);
                assert_eq!([done, summed], [all.len(); 2], "whole tiles");
                let mut expected = vec![0.0; count];
                for (k, s) in all.iter().enumerate() {
                    eval_basis_into(*s, &mut expected);
                    for (i, y) in expected.iter().enumerate() {
                        let found = out[i * all.len() + k];
                        assert!((found - y).abs() < 1e-13, "{}, y_{i} towards {s:?}: {found}, {y}", machine.name());
                    }
                    let sum: f64 = expected.iter().zip(&c).map(|(y, c)| y * c).sum();
                    assert!(
                        (sums[k] - sum).abs() < 1e-12,
                        "{}, order {order}, {s:?}: {}, {sum}",
                        machine.name(),
                        sums[k]
                    );
                }
            }
        }
    }
}
