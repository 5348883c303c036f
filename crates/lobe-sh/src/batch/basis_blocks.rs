//! The basis towards the directions of a batch.

use crate::basis::basis::Basis;
use crate::basis::index::coefficient_count;
#[cfg(feature = "simd")]
use crate::basis::lane_basis::{HIGHEST_ORDER, basis};
#[cfg(feature = "simd")]
use crate::basis::places::Places;
use crate::simd::{Kernel, Lanes, Machine};
#[cfg(feature = "simd")]
use crate::simd::{Wide, past_caches};

/// Part `part` of blocks, one for each function.
#[cfg(feature = "simd")]
struct Blocks<'a> {
    blocks: &'a mut [Lanes],
    part: usize,
}

#[cfg(feature = "simd")]
impl<S: pulp::Simd> Places<S> for Blocks<'_> {
    #[inline(always)]
    fn put(&mut self, i: usize, value: Wide<S>) {
        value.store(&mut self.blocks[i], self.part);
    }
}

/// The values of all functions of `order` towards sixteen directions after the other: `out` has `order²` blocks for each.
pub(crate) fn eval_blocks(machine: Machine, order: usize, directions: &[[Lanes; 3]], out: &mut [Lanes]) {
    let count = coefficient_count(order);
    assert_eq!(out.len(), count * directions.len(), "blocks of values against those of directions");
    if count > 0 {
        machine.run(EvalBlocks {
            order,
            directions,
            #[cfg(feature = "simd")]
            leaves: past_caches::are_many(out),
            out,
        });
    }
}

struct EvalBlocks<'a> {
    order: usize,
    directions: &'a [[Lanes; 3]],
    /// Whether results are so many that they go past the caches.
    #[cfg(feature = "simd")]
    leaves: bool,
    out: &'a mut [Lanes],
}

impl Kernel for EvalBlocks<'_> {
    type Output = ();

    #[cfg(feature = "simd")]
    #[inline(always)]
    fn wide<S: pulp::Simd>(self, simd: S) {
        if self.order > HIGHEST_ORDER {
            return self.plain();
        }
        let count = coefficient_count(self.order);
        // They stay in the nearest cache.
        let mut room = vec![Lanes::ZERO; if self.leaves { count } else { 0 }];
        for (s, out) in self.directions.iter().zip(self.out.chunks_exact_mut(count)) {
            let blocks = if self.leaves { &mut *room } else { &mut *out };
            for part in 0..Wide::<S>::PARTS {
                let s = [Wide::load(simd, &s[0], part), Wide::load(simd, &s[1], part), Wide::load(simd, &s[2], part)];
                basis(simd, self.order, s, &mut Blocks { blocks, part });
            }
            if self.leaves {
                for (block, out) in room.iter().zip(out) {
                    past_caches::copy(&block.0, &mut out.0);
                }
            }
        }
        if self.leaves {
            past_caches::finish();
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

#[cfg(all(test, feature = "simd"))]
mod tests {
    use super::*;
    use crate::basis::lane_basis::tests::{assert_close, directions};
    use crate::simd::LANES;

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
                if count > 0 {
                    let mut past = vec![Lanes::ZERO; out.len()];
                    machine.run(EvalBlocks { order, directions: &blocks, out: &mut past, leaves: true });
                    assert_eq!(past, out, "{}, order {order}: past the caches", machine.name());
                }
                for (k, s) in all.iter().enumerate() {
                    for i in 0..count {
                        assert_close(out[k / LANES * count + i].0[k % LANES], order, i, *s, machine.name());
                    }
                }
            }
        }
    }
}
