//! The kernels of the basis for each kind of number.

use crate::basis::lane_basis::TILE;
use crate::basis::lane_planes::EvalPlanes;
use crate::basis::lane_sums::{Directions, EvalSums};
use crate::basis::recurrence::Constants;
use crate::simd::{Lane, Machine, past_caches};

/// `f32` or `f64`, for which the kernels of the basis are compiled in this crate, once, and not in every crate that calls what is generic.
pub trait LaneKernels: Lane {
    #[doc(hidden)]
    fn planes(machine: Machine, kernel: EvalPlanes<'_, Self>) -> usize;

    #[doc(hidden)]
    fn sums(machine: Machine, kernel: EvalSums<'_, Self, 1>) -> bool;

    #[doc(hidden)]
    fn color_sums(machine: Machine, kernel: EvalSums<'_, Self, 3>) -> bool;
}

macro_rules! kernels {
    ($($number:ty),*) => {$(
        impl LaneKernels for $number {
            fn planes(machine: Machine, kernel: EvalPlanes<'_, Self>) -> usize {
                machine.run(kernel)
            }

            fn sums(machine: Machine, kernel: EvalSums<'_, Self, 1>) -> bool {
                machine.run(kernel)
            }

            fn color_sums(machine: Machine, kernel: EvalSums<'_, Self, 3>) -> bool {
                machine.run(kernel)
            }
        }
    )*};
}

kernels!(f32, f64);

/// The lowest order that planes have code for: below, the plain code is as quick.
const LOWEST_ORDER: usize = 3;

/// `Basis::eval_many_into` of as many directions as are whole tiles, if the machine and the order have code for it; the
/// number of directions that are done.
pub(crate) fn eval_planes<T: LaneKernels>(
    machine: Machine,
    constants: &Constants<T>,
    order: usize,
    components: [&[T]; 3],
    out: &mut [T],
) -> usize {
    if order < LOWEST_ORDER || components[0].len() < TILE || machine.is_plain() {
        return 0;
    }
    constants.assert_reaches(order);
    let leaves = past_caches::are_many(out);
    T::planes(machine, EvalPlanes { constants, order, components, out, leaves })
}

/// `Basis::eval_expansion_into` of as many directions as are whole tiles, if the machine has code for it; the number of directions that are
/// done.
pub(crate) fn eval_sums<T: LaneKernels>(
    machine: Machine,
    constants: &Constants<T>,
    coefficients: &[T],
    order: usize,
    components: [&[T]; 3],
    out: &mut [T],
) -> usize {
    if order == 0 || machine.is_plain() {
        return 0;
    }
    constants.assert_reaches(order);
    let done = out.len() / TILE * TILE;
    let directions = Directions::Planes(components);
    T::sums(machine, EvalSums { constants, coefficients, order, directions, out: &mut out[..done] });
    done
}

#[cfg(test)]
mod tests {
    use alloc::vec::Vec;

    use super::*;
    use crate::basis::basis::eval_basis_into;
    use crate::basis::index::coefficient_count;
    use crate::basis::lane_basis::HIGHEST_ORDER;
    use crate::basis::lane_basis::tests::{assert_close, directions};

    /// Orders with straight-line code and without.
    fn orders() -> impl Iterator<Item = usize> {
        (LOWEST_ORDER..=HIGHEST_ORDER + 2).chain([20])
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

    /// As [`eval_planes`] of tables larger than the caches.
    fn planes_past_caches<T: LaneKernels>(machine: Machine, order: usize, components: [&[T]; 3]) -> Vec<T> {
        let constants = &Constants::new(order);
        let mut out = vec![T::ZERO; coefficient_count(order) * components[0].len()];
        let done = T::planes(machine, EvalPlanes { constants, order, components, out: &mut out, leaves: true });
        assert_eq!(done, components[0].len() / TILE * TILE, "whole tiles");
        out
    }

    #[test]
    fn planes_past_the_caches_are_the_same() {
        // More than one run of the lowest order, and of no whole number of tiles: the planes lie anywhere in their lines.
        let all: Vec<[f32; 3]> = directions().into_iter().cycle().take(130 * TILE + 5).collect();
        let single = [0, 1, 2].map(|axis| all.iter().map(|s| s[axis]).collect::<Vec<f32>>());
        let double = [0, 1, 2].map(|axis| all.iter().map(|s| f64::from(s[axis])).collect::<Vec<f64>>());
        for order in [3, 6, 7, 20] {
            for machine in Machine::available().filter(|machine| !machine.is_plain()) {
                let mut near = vec![0.0; coefficient_count(order) * all.len()];
                let [x, y, z] = &single;
                eval_planes(machine, &Constants::new(order), order, [x, y, z], &mut near);
                assert_eq!(planes_past_caches(machine, order, [x, y, z]), near, "{}, order {order}", machine.name());
                let mut near = vec![0.0; coefficient_count(order) * all.len()];
                let [x, y, z] = &double;
                eval_planes(machine, &Constants::new(order), order, [x, y, z], &mut near);
                assert_eq!(planes_past_caches(machine, order, [x, y, z]), near, "{}, order {order}", machine.name());
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
