//! Traversal of many independent rays, some at a time in turns.

use crate::bvh::lanes::{Lanes, Work};
use crate::bvh::ray_frame::{RayFrame, RayOrigin};
use crate::bvh::traverse::{END_ROOM, Stack, Tree, push_all_but_nearest};
use crate::bvh::watertight::ShearedRay;
use crate::bvh::wide_node::{BLOCK_BIT, SlabRay};
use crate::scene::ray::{Hit, Ray};

/// The number of rays that are traversed in turns.
///
/// The nodes that one ray comes to follow from each other: the next is known when the boxes of one have been tested,
/// and then has to be read. The nodes of different rays do not, so each ray takes one step, has its next node read, and
/// leaves the turn to the next ray. Answers are those of one ray at a time, bit by bit: each takes the same steps.
const IN_TURNS: usize = 8;

/// A ray on its way.
struct Walker<L: Lanes, Item> {
    /// Among all rays.
    place: usize,
    ray: ShearedRay,
    slabs: SlabRay<L>,
    longest: f32,
    end: f32,
    next: Item,
    stack: Stack<Item>,
    best: Option<Hit>,
}

impl<L: Lanes, Item: Copy + Default> Walker<L, Item> {
    #[inline(always)]
    fn new(lanes: L) -> Self {
        let frame = RayFrame::default();
        Self {
            place: 0,
            ray: ShearedRay::new([0.0; 3], &frame, 0.0),
            slabs: SlabRay::new(lanes, &frame),
            longest: 0.0,
            end: 0.0,
            next: Item::default(),
            stack: Stack::new(),
            best: None,
        }
    }

    /// Starts with the next of the rays that can hit something; false if there is none.
    #[inline(always)]
    fn start(&mut self, lanes: L, tree: &Tree<'_>, rays: &[Ray], first: &mut usize) -> bool {
        while let Some(ray) = rays.get(*first) {
            self.place = *first;
            *first += 1;
            if let Some(frame) = RayOrigin::new(ray.origin, tree.bounds).frame_of(ray) {
                self.ray = ShearedRay::new(ray.origin, &frame, ray.t_max);
                self.slabs = SlabRay::new(lanes, &frame);
                self.longest = frame.longest;
                self.end = ray.t_max * frame.longest * END_ROOM;
                self.next = Item::default();
                self.stack.clear();
                self.best = None;
                return true;
            }
        }
        false
    }
}

/// A step of the ray of a walker.
trait Step<L: Lanes> {
    type Item: Copy + Default;

    /// Takes a step; true if the ray is at its end, and its answer is known.
    fn step(&mut self, lanes: L, tree: &Tree<'_>, walker: &mut Walker<L, Self::Item>) -> bool;
}

/// Traverses all rays.
#[inline(always)]
fn in_turns<L: Lanes, S: Step<L>>(lanes: L, tree: &Tree<'_>, rays: &[Ray], mut step: S) {
    let mut walkers: [Walker<L, S::Item>; IN_TURNS] = std::array::from_fn(|_| Walker::new(lanes));
    let mut order: [usize; IN_TURNS] = std::array::from_fn(|k| k);
    let (mut going, mut first) = (0, 0);
    while going < IN_TURNS && walkers[going].start(lanes, tree, rays, &mut first) {
        going += 1;
    }
    while going > 0 {
        let mut k = 0;
        while k < going {
            let walker = &mut walkers[order[k] % IN_TURNS];
            if step.step(lanes, tree, walker) && !walker.start(lanes, tree, rays, &mut first) {
                going -= 1;
                order.swap(k, going);
            } else {
                k += 1;
            }
        }
    }
}

/// The query which of many rays have any accepted hit.
pub(crate) struct AnyHits<'a, 'r, F> {
    pub(crate) tree: Tree<'a>,
    pub(crate) rays: &'r [Ray],
    pub(crate) occluded: &'r mut [bool],
    /// Whether a ray, told by its place, stops at a hit.
    pub(crate) accept: F,
}

struct AnyHitStep<'r, F> {
    occluded: &'r mut [bool],
    accept: F,
}

impl<F: FnMut(usize, &Hit) -> bool> Work for AnyHits<'_, '_, F> {
    type Output = ();

    #[inline(always)]
    fn work<L: Lanes>(self, lanes: L) {
        self.occluded.fill(false);
        in_turns(lanes, &self.tree, self.rays, AnyHitStep { occluded: self.occluded, accept: self.accept });
    }
}

impl<L: Lanes, F: FnMut(usize, &Hit) -> bool> Step<L> for AnyHitStep<'_, F> {
    type Item = u32;

    #[inline(always)]
    fn step(&mut self, lanes: L, tree: &Tree<'_>, walker: &mut Walker<L, u32>) -> bool {
        let item = walker.next;
        if item & BLOCK_BIT == 0 {
            let node = &tree.nodes[item as usize];
            let (mask, _) = walker.slabs.meets(lanes, node, lanes.splat(walker.end));
            // Without a branch on what is met: the last on top, as of one ray at a time.
            let met = lanes.compress(&node.children(), mask);
            walker.stack.push_front(&met, mask.count_ones() as usize);
        } else {
            let block = &tree.blocks[(item & !BLOCK_BIT) as usize];
            let (place, accept) = (walker.place, &mut self.accept);
            if block.hits(lanes, &walker.ray, |hit| accept(place, &hit)) {
                self.occluded[place] = true;
                return true;
            }
        }
        let next = walker.stack.pop();
        walker.next = next.unwrap_or(0);
        tree.prefetch(lanes, walker.next);
        next.is_none()
    }
}

/// The query for the closest accepted hit of each of many rays.
pub(crate) struct ClosestHits<'a, 'r, F> {
    pub(crate) tree: Tree<'a>,
    pub(crate) rays: &'r [Ray],
    pub(crate) hits: &'r mut [Option<Hit>],
    /// Whether a ray, told by its place, stops at a hit.
    pub(crate) accept: F,
}

struct ClosestStep<'r, F> {
    hits: &'r mut [Option<Hit>],
    accept: F,
}

impl<F: FnMut(usize, &Hit) -> bool> Work for ClosestHits<'_, '_, F> {
    type Output = ();

    #[inline(always)]
    fn work<L: Lanes>(self, lanes: L) {
        self.hits.fill(None);
        in_turns(lanes, &self.tree, self.rays, ClosestStep { hits: self.hits, accept: self.accept });
    }
}

impl<L: Lanes, F: FnMut(usize, &Hit) -> bool> Step<L> for ClosestStep<'_, F> {
    type Item = (f32, u32);

    #[inline(always)]
    fn step(&mut self, lanes: L, tree: &Tree<'_>, walker: &mut Walker<L, (f32, u32)>) -> bool {
        let item = walker.next.1;
        if item & BLOCK_BIT != 0 {
            let Walker { place, ray, longest, end, best, .. } = walker;
            let accept = &mut self.accept;
            tree.blocks[(item & !BLOCK_BIT) as usize].hits(lanes, ray, |hit| {
                let is_closer = best.is_none_or(|best| (hit.t, hit.triangle) < (best.t, best.triangle));
                if is_closer && accept(*place, &hit) {
                    *best = Some(hit);
                    *end = hit.t * *longest * END_ROOM;
                }
                false
            });
        } else {
            let node = &tree.nodes[item as usize];
            let (mask, enters) = walker.slabs.meets(lanes, node, lanes.splat(walker.end));
            let nearest = push_all_but_nearest(node, mask, &lanes.store(enters), &mut walker.stack, |item| {
                tree.prefetch(lanes, item);
            });
            if let Some(nearest) = nearest {
                walker.next = nearest;
                tree.prefetch(lanes, nearest.1);
                return false;
            }
        }
        // Children behind the closest hit are skipped.
        while let Some(next) = walker.stack.pop() {
            if next.0 <= walker.end {
                walker.next = next;
                tree.prefetch(lanes, next.1);
                return false;
            }
        }
        self.hits[walker.place] = walker.best;
        true
    }
}

#[cfg(test)]
mod tests {
    use lobe_testkit::Random;

    use super::*;
    use crate::built_in;
    use crate::bvh::bvh::Bvh;
    use crate::bvh::lanes::Simd;

    #[test]
    fn rays_in_turns_find_what_they_find_alone() {
        let bvh = Bvh::new(&built_in::columns_hall(4));
        let mut random = Random::new(8);
        let numbers = |random: &mut Random| random.direction().map(|c| c as f32);
        let mut rays: Vec<_> = (0..500)
            .map(|k| {
                let t_max = if k % 3 == 0 { 1.5 } else { f32::INFINITY };
                Ray { t_max, ..Ray::new(numbers(&mut random).map(|c| 3.0 * c), numbers(&mut random)) }
            })
            .collect();
        // Those that hit nothing leave their turn.
        for k in [0, 3, 4, 250, 499] {
            rays[k].direction = [0.0; 3];
        }
        // All triangles but some stop a ray, others for each.
        let accept = |place: usize, triangle: u32| !(place as u32 + triangle).is_multiple_of(3);
        for simd in Simd::ALL {
            let Some(bvh) = bvh.clone().with_simd(simd) else {
                lobe_testkit::skipped(&format!("this machine has no {simd:?}"));
                continue;
            };
            for count in [0, 1, IN_TURNS - 1, IN_TURNS, rays.len()] {
                let (rays, tree) = (&rays[..count], bvh.tree());
                let mut occluded = vec![true; count];
                let accept_any = |place: usize, hit: &Hit| accept(place, hit.triangle);
                bvh.machine.run(AnyHits { tree, rays, occluded: &mut occluded, accept: accept_any });
                let mut hits = vec![None; count];
                let accept_closest = |place: usize, hit: &Hit| accept(place, hit.triangle);
                bvh.machine.run(ClosestHits { tree, rays, hits: &mut hits, accept: accept_closest });
                for (place, ray) in rays.iter().enumerate() {
                    let alone = bvh.is_occluded_where(ray, |hit| accept(place, hit.triangle));
                    assert_eq!(occluded[place], alone, "{simd:?}: ray {place} of {count}");
                    let alone = bvh.closest_where(ray, |hit| accept(place, hit.triangle));
                    assert_eq!(hits[place], alone, "{simd:?}: ray {place} of {count}");
                }
                assert!(count < 500 || hits.iter().flatten().count() > 200, "{count} rays hit little");
            }
        }
    }
}
