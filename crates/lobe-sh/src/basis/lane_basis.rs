//! The basis towards sixteen directions at once, orders 1 to 10, in `f32`.

#[cfg(feature = "std")]
use crate::basis::lanes;
use crate::simd::{Kernel, LANES, Lanes, Machine};
#[cfg(feature = "std")]
use crate::simd::Wide;
use crate::{Basis, coefficient_count};

/// The highest order that has code for lanes.
pub(crate) const HIGHEST_ORDER: usize = 10;

/// Values of a tile that is written before it is copied to its places: they stay in the first-level cache.
#[cfg(feature = "std")]
const TILE: usize = 6144;

/// Values of all functions of order 10 or less in a row of `out` that the machine writes in place: no more than fit the
/// caches with their planes.
#[cfg(feature = "std")]
const IN_PLACE: usize = 1 << 16;

/// Where the values of sixteen directions go.
#[cfg(feature = "std")]
pub(crate) trait Places<S: pulp::Simd> {
    /// Takes the values of `y_i`.
    fn put(&mut self, i: usize, value: Wide<S>);
}

/// Part `part` of blocks, one for each function.
#[cfg(feature = "std")]
struct Blocks<'a> {
    blocks: &'a mut [Lanes],
    part: usize,
}

#[cfg(feature = "std")]
impl<S: pulp::Simd> Places<S> for Blocks<'_> {
    #[inline(always)]
    fn put(&mut self, i: usize, value: Wide<S>) {
        value.store(&mut self.blocks[i], self.part);
    }
}

/// Part `part` of the sixteen values from `start` on in planes of `stride` values, one for each function.
#[cfg(feature = "std")]
struct Planes<'a> {
    values: &'a mut [f32],
    stride: usize,
    start: usize,
    part: usize,
}

#[cfg(feature = "std")]
impl<S: pulp::Simd> Places<S> for Planes<'_> {
    #[inline(always)]
    fn put(&mut self, i: usize, value: Wide<S>) {
        if let Some(place) = self.values[i * self.stride + self.start..].first_chunk_mut() {
            value.store_array(place, self.part);
        }
    }
}

#[cfg(feature = "std")]
#[inline(always)]
fn basis<S: pulp::Simd>(simd: S, order: usize, s: [Wide<S>; 3], out: &mut impl Places<S>) {
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

/// The values of all functions of `order` towards sixteen directions after the other: `out` has `order²` blocks for each.
pub(crate) fn eval_blocks(machine: Machine, order: usize, directions: &[[Lanes; 3]], out: &mut [Lanes]) {
    let count = coefficient_count(order);
    assert_eq!(out.len(), count * directions.len(), "blocks of values against those of directions");
    if count > 0 {
        machine.run(EvalBlocks { order, directions, out });
    }
}

struct EvalBlocks<'a> {
    order: usize,
    directions: &'a [[Lanes; 3]],
    out: &'a mut [Lanes],
}

impl Kernel for EvalBlocks<'_> {
    type Output = ();

    #[cfg(feature = "std")]
    #[inline(always)]
    fn wide<S: pulp::Simd>(self, simd: S) {
        if self.order > HIGHEST_ORDER {
            return self.plain();
        }
        let count = coefficient_count(self.order);
        for (s, blocks) in self.directions.iter().zip(self.out.chunks_exact_mut(count)) {
            for part in 0..Wide::<S>::PARTS {
                let s = [0, 1, 2].map(|axis| Wide::load(simd, &s[axis], part));
                basis(simd, self.order, s, &mut Blocks { blocks, part });
            }
        }
    }

    fn plain(self) {
        let count = coefficient_count(self.order);
        Basis::<f32>::with_shared(self.order, |basis| {
            for (s, blocks) in self.directions.iter().zip(self.out.chunks_exact_mut(count)) {
                basis.for_each_in_block(s.map(|axis| axis.0), self.order, |i, y| blocks[i] = Lanes(*y));
            }
        });
    }
}

/// [`Basis::eval_many_into`] of as many directions as are whole blocks, if the machine and the order have code for it; the
/// number of directions that are done.
pub(crate) fn eval_planes(machine: Machine, order: usize, components: [&[f32]; 3], out: &mut [f32]) -> usize {
    if order == 0 || order > HIGHEST_ORDER || machine.is_plain() {
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

    #[cfg(feature = "std")]
    #[inline(always)]
    fn wide<S: pulp::Simd>(self, simd: S) -> usize {
        let [x, y, z] = self.components.map(|component| component.as_chunks::<LANES>().0);
        let (count, stride, blocks) = (coefficient_count(self.order), self.components[0].len(), x.len());
        let eval = |block: usize, values: &mut [f32], stride: usize, start: usize| {
            for part in 0..Wide::<S>::PARTS {
                let s = [x, y, z].map(|component| Wide::load_array(simd, &component[block], part));
                basis(simd, self.order, s, &mut Planes { values, stride, start, part });
            }
        };
        if self.out.len() <= IN_PLACE {
            (0..blocks).for_each(|block| eval(block, self.out, stride, block * LANES));
            return blocks * LANES;
        }
        // Tiles first, then runs of them to the planes, which lie so far apart that single blocks would find none of them
        // in a cache.
        let together = (TILE / (count * LANES)).max(1);
        let mut tile = [0.0; TILE.next_multiple_of(HIGHEST_ORDER * HIGHEST_ORDER * LANES)];
        for first in (0..blocks).step_by(together) {
            let run = LANES * together.min(blocks - first);
            for block in 0..run / LANES {
                eval(first + block, &mut tile[..count * run], run, block * LANES);
            }
            for (i, values) in tile[..count * run].chunks_exact(run).enumerate() {
                self.out[i * stride + first * LANES..][..run].copy_from_slice(values);
            }
        }
        blocks * LANES
    }

    fn plain(self) -> usize {
        0
    }
}

#[cfg(test)]
mod tests {
    use alloc::vec;
    use alloc::vec::Vec;

    use super::*;
    use crate::eval_basis_into;

    /// The error that single directions are tested for at order 20.
    const ERROR: f64 = 1.5e-6;

    /// Directions in general, and next to the poles, where errors are largest.
    fn directions() -> Vec<[f32; 3]> {
        let mut random = lobe_testkit::Random::new(20);
        let near_poles = (0..200).map(|_| {
            let [x, y, z] = random.direction();
            crate::Dir::new([0.05 * x, 0.05 * y, z.signum()]).unwrap().to_array()
        });
        let mut all: Vec<[f64; 3]> = lobe_testkit::directions().into_iter().chain(near_poles).collect();
        all.truncate(all.len() / LANES * LANES);
        all.into_iter().map(|s| s.map(|c| c as f32)).collect()
    }

    fn assert_close(found: f32, order: usize, i: usize, s: [f32; 3], what: &str) {
        let mut y = vec![0.0; coefficient_count(order)];
        eval_basis_into(s.map(f64::from), &mut y);
        let off = (f64::from(found) - y[i]).abs();
        assert!(off < ERROR, "{what}, order {order}, y_{i} towards {s:?}: {found} against {}", y[i]);
    }

    #[test]
    fn every_machine_evaluates_blocks_as_single_directions() {
        let all = directions();
        let blocks: Vec<[Lanes; 3]> = all
            .chunks_exact(LANES)
            .map(|block| [0, 1, 2].map(|axis| Lanes(core::array::from_fn(|lane| block[lane][axis]))))
            .collect();
        for order in 0..=HIGHEST_ORDER + 2 {
            let count = coefficient_count(order);
            for machine in Machine::available() {
                let mut out = vec![Lanes([f32::NAN; LANES]); count * blocks.len()];
                eval_blocks(machine, order, &blocks, &mut out);
                for (k, s) in all.iter().enumerate() {
                    for i in 0..count {
                        assert_close(out[k / LANES * count + i].0[k % LANES], order, i, *s, machine.name());
                    }
                }
            }
        }
    }

    #[test]
    #[cfg(feature = "std")]
    fn planes_are_written_in_place_and_by_tiles() {
        let few = directions();
        // More than fit in place at the higher orders, and not a whole number of tiles.
        let many: Vec<[f32; 3]> = few.iter().copied().cycle().take(130 * LANES).collect();
        for all in [&few, &many] {
            let component = |axis: usize| all.iter().map(|s| s[axis]).collect::<Vec<f32>>();
            let (x, y, z) = (component(0), component(1), component(2));
            for order in 1..=HIGHEST_ORDER {
                for machine in Machine::available().filter(|machine| !machine.is_plain()) {
                    let mut out = vec![f32::NAN; coefficient_count(order) * all.len()];
                    assert_eq!(eval_planes(machine, order, [&x, &y, &z], &mut out), all.len(), "whole blocks");
                    for (k, s) in all.iter().enumerate().step_by(7) {
                        for i in 0..coefficient_count(order) {
                            assert_close(out[i * all.len() + k], order, i, *s, machine.name());
                        }
                    }
                }
            }
        }
    }
}
