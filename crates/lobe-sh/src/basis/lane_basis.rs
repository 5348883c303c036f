//! The basis towards sixteen directions at once, orders 1 to 10, in `f32`.

use crate::basis::lanes;
use crate::basis::places::Places;
use crate::simd::{Kernel, Machine};
use crate::simd::{LANES, Wide};

/// The highest order that has code for lanes.
pub(crate) const HIGHEST_ORDER: usize = 10;

/// The lowest order that planes have code for: below, the plain code is as quick.
const LOWEST_IN_PLANES: usize = 3;

/// Part `part` of the sixteen values from `start` on in planes of `stride` values, one for each function.
struct Planes<'a> {
    values: &'a mut [f32],
    stride: usize,
    start: usize,
    part: usize,
}

impl<S: pulp::Simd> Places<S> for Planes<'_> {
    #[inline(always)]
    fn put(&mut self, i: usize, value: Wide<S>) {
        if let Some(place) = self.values[i * self.stride + self.start..].first_chunk_mut() {
            value.store_array(place, self.part);
        }
    }
}

#[inline(always)]
pub(crate) fn basis<S: pulp::Simd>(simd: S, order: usize, s: [Wide<S>; 3], out: &mut impl Places<S>) {
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

/// `Basis::eval_many_into` of as many directions as are whole blocks, if the machine and the order have code for it; the
/// number of directions that are done.
pub(crate) fn eval_planes(machine: Machine, order: usize, components: [&[f32]; 3], out: &mut [f32]) -> usize {
    if !(LOWEST_IN_PLANES..=HIGHEST_ORDER).contains(&order) || machine.is_plain() {
        return 0;
    }
    machine.run(EvalPlanes { order, components, out })
}

struct EvalPlanes<'a> {
    order: usize,
    components: [&'a [f32]; 3],
    out: &'a mut [f32],
}

impl Kernel for EvalPlanes<'_> {
    type Output = usize;

    #[inline(always)]
    fn wide<S: pulp::Simd>(self, simd: S) -> usize {
        let [x, y, z] = self.components.map(|component| component.as_chunks::<LANES>().0);
        let stride = self.components[0].len();
        for block in 0..x.len() {
            for part in 0..Wide::<S>::PARTS {
                let s = [
                    Wide::load_array(simd, &x[block], part),
                    Wide::load_array(simd, &y[block], part),
                    Wide::load_array(simd, &z[block], part),
                ];
                let places = &mut Planes { values: &mut *self.out, stride, start: block * LANES, part };
                basis(simd, self.order, s, places);
            }
        }
        x.len() * LANES
    }

    fn plain(self) -> usize {
        0
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use alloc::vec::Vec;

    use super::*;
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
        all.truncate(all.len() / LANES * LANES);
        all.into_iter().map(|s| s.map(|c| c as f32)).collect()
    }

    pub(crate) fn assert_close(found: f32, order: usize, i: usize, s: [f32; 3], what: &str) {
        let mut y = vec![0.0; coefficient_count(order)];
        eval_basis_into(s.map(f64::from), &mut y);
        let off = (f64::from(found) - y[i]).abs();
        assert!(off < ERROR, "{what}, order {order}, y_{i} towards {s:?}: {found} against {}", y[i]);
    }

    #[test]
    fn every_machine_evaluates_planes_as_single_directions() {
        let all = directions();
        let component = |axis: usize| all.iter().map(|s| s[axis]).collect::<Vec<f32>>();
        let (x, y, z) = (component(0), component(1), component(2));
        for order in LOWEST_IN_PLANES..=HIGHEST_ORDER {
            for machine in Machine::available().filter(|machine| !machine.is_plain()) {
                let mut out = vec![f32::NAN; coefficient_count(order) * all.len()];
                assert_eq!(eval_planes(machine, order, [&x, &y, &z], &mut out), all.len(), "whole blocks");
                for (k, s) in all.iter().enumerate() {
                    for i in 0..coefficient_count(order) {
                        assert_close(out[i * all.len() + k], order, i, *s, machine.name());
                    }
                }
            }
        }
    }
}
