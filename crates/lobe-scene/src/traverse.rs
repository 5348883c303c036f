//! The way of a ray through the tree.

use crate::lanes::{Lanes, WIDTH, Work};
use crate::watertight::ShearedRay;
use crate::wide_node::{BLOCK_BIT, Block, Node, SlabRay};
use crate::{Bounds, Hit, Ray};

/// Relative room for the rounding of a ray's end, and of the distance of a hit, beside boxes.
const END_ROOM: f32 = 1.0 + 1e-6;

/// The parts of a tree that rays meet.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tree<'a> {
    pub(crate) nodes: &'a [Node],
    pub(crate) blocks: &'a [Block],
    pub(crate) bounds: &'a Bounds,
}

/// The children that wait to be looked at. Its first part needs no allocation.
struct Stack<T> {
    near: [T; STACK],
    far: Vec<T>,
    count: usize,
}

const STACK: usize = 128;

impl<T: Copy + Default> Stack<T> {
    #[inline(always)]
    fn new() -> Self {
        Self { near: [T::default(); STACK], far: Vec::new(), count: 0 }
    }

    #[inline(always)]
    fn push(&mut self, item: T) {
        if self.count < STACK {
            self.near[self.count] = item;
            self.count += 1;
        } else {
            self.far.push(item);
        }
    }

    #[inline(always)]
    fn pop(&mut self) -> Option<T> {
        if let Some(item) = self.far.pop() {
            return Some(item);
        }
        self.count = self.count.checked_sub(1)?;
        Some(self.near[self.count % STACK])
    }
}

/// Whether any hit is accepted.
pub(crate) struct AnyHit<'a, 'r, F> {
    pub(crate) tree: Tree<'a>,
    pub(crate) ray: &'r Ray,
    pub(crate) accept: F,
}

impl<F: FnMut(Hit) -> bool> Work for AnyHit<'_, '_, F> {
    type Output = bool;

    #[inline(always)]
    fn work<L: Lanes>(mut self, lanes: L) -> bool {
        ShearedRay::new(self.ray)
            .is_some_and(|ray| any_hit(lanes, &self.tree, &ray, self.ray.t_max, &mut self.accept).is_some())
    }
}

/// The block of a hit that is accepted. Blocks are tested as soon as they are met: for one hit is enough, they come before
/// what waits on the stack.
#[inline(always)]
fn any_hit<L: Lanes>(
    lanes: L,
    tree: &Tree<'_>,
    ray: &ShearedRay,
    t_max: f32,
    accept: &mut impl FnMut(Hit) -> bool,
) -> Option<u32> {
    let slabs = SlabRay::new(lanes, ray, tree.bounds);
    let t_max = lanes.splat(t_max * ray.longest * END_ROOM);
    let mut stack = Stack::new();
    let mut next = Some(0_u32);
    while let Some(item) = next {
        let node = &tree.nodes[item as usize];
        let (mut mask, _) = slabs.meets(lanes, node, t_max);
        while mask != 0 {
            let child = node.child(mask.trailing_zeros() as usize);
            mask &= mask - 1;
            if child & BLOCK_BIT == 0 {
                stack.push(child);
            } else {
                let block = child & !BLOCK_BIT;
                if tree.blocks[block as usize].hits(lanes, ray, &mut *accept) {
                    return Some(block);
                }
            }
        }
        next = stack.pop();
    }
    None
}

/// Which of many rays from one point hit anything.
pub(crate) struct AnyHits<'a, 'r> {
    pub(crate) tree: Tree<'a>,
    pub(crate) origin: [f32; 3],
    pub(crate) directions: &'r [[f32; 3]],
    pub(crate) occluded: &'r mut [bool],
}

impl Work for AnyHits<'_, '_> {
    type Output = ();

    /// What stopped a ray often stops the next one, and is asked first.
    #[inline(always)]
    fn work<L: Lanes>(self, lanes: L) {
        let mut last: Option<u32> = None;
        for (direction, occluded) in self.directions.iter().zip(self.occluded) {
            let ray = Ray::new(self.origin, *direction);
            *occluded = ShearedRay::new(&ray).is_some_and(|ray| {
                let again = last.is_some_and(|block| self.tree.blocks[block as usize].hits(lanes, &ray, |_| true));
                let hit = if again { last } else { any_hit(lanes, &self.tree, &ray, f32::INFINITY, &mut |_| true) };
                last = hit.or(last);
                hit.is_some()
            });
        }
    }
}

/// The accepted hit that is closest; of equally close ones that of the triangle with the smallest number.
pub(crate) struct Closest<'a, 'r, F> {
    pub(crate) tree: Tree<'a>,
    pub(crate) ray: &'r Ray,
    pub(crate) accept: F,
}

impl<F: FnMut(&Hit) -> bool> Work for Closest<'_, '_, F> {
    type Output = Option<Hit>;

    #[inline(always)]
    fn work<L: Lanes>(mut self, lanes: L) -> Option<Hit> {
        let ray = self.ray;
        let sheared = ShearedRay::new(ray)?;
        let slabs = SlabRay::new(lanes, &sheared, self.tree.bounds);
        let end_of = |t: f32| t * sheared.longest * END_ROOM;
        let mut best: Option<Hit> = None;
        let mut end = end_of(ray.t_max);
        let mut stack = Stack::new();
        let mut next = Some((0.0, 0_u32));
        while let Some((enter, item)) = next {
            if enter > end {
                // Something closer was found since.
            } else if item & BLOCK_BIT != 0 {
                self.tree.blocks[(item & !BLOCK_BIT) as usize].hits(lanes, &sheared, |hit| {
                    let is_closer = best.is_none_or(|best| (hit.t, hit.triangle) < (best.t, best.triangle));
                    if is_closer && (self.accept)(&hit) {
                        best = Some(hit);
                        end = end_of(hit.t);
                    }
                    false
                });
            } else {
                let node = &self.tree.nodes[item as usize];
                let (mask, enters) = slabs.meets(lanes, node, lanes.splat(end));
                push_farthest_first(node, mask, &lanes.store(enters), &mut stack);
            }
            next = stack.pop();
        }
        best
    }
}

/// Pushes the children of a mask so that the nearest comes out first.
#[inline(always)]
fn push_farthest_first(node: &Node, mask: u32, enters: &[f32; WIDTH], stack: &mut Stack<(f32, u32)>) {
    let mut sorted = [(0.0_f32, 0_u32); WIDTH];
    let mut count = 0;
    let mut mask = mask;
    while mask != 0 {
        let slot = mask.trailing_zeros() as usize % WIDTH;
        mask &= mask - 1;
        // Insertion from the far end: most masks have two or three children.
        let mut place = count;
        while place > 0 && sorted[place - 1].0 < enters[slot] {
            sorted[place] = sorted[place - 1];
            place -= 1;
        }
        sorted[place] = (enters[slot], node.child(slot));
        count += 1;
    }
    for &item in &sorted[..count] {
        stack.push(item);
    }
}
