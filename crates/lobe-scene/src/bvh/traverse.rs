//! BVH8 traversal of one ray: closest hit and any hit.

use crate::bvh::lanes::{Lanes, WIDTH, Work};
use crate::bvh::ray_frame::{RayFrame, RayOrigin};
use crate::bvh::watertight::ShearedRay;
use crate::bvh::wide_node::{BLOCK_BIT, Block, Node, SlabRay};
use crate::scene::ray::{Hit, Ray};
use crate::scene::scene::Bounds;

/// The factor that covers the rounding of a ray's end, and of the distance of a hit, against boxes.
pub(crate) const END_ROOM: f32 = 1.0 + 1e-6;

/// The parts of a tree needed for traversal.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tree<'a> {
    pub(crate) nodes: &'a [Node],
    pub(crate) blocks: &'a [Block],
    pub(crate) bounds: &'a Bounds,
}

impl Tree<'_> {
    /// Has a child read ahead, which waits on the stack while others are tested.
    #[inline(always)]
    pub(crate) fn prefetch<L: Lanes>(&self, lanes: L, item: u32) {
        let index = (item & !BLOCK_BIT) as usize;
        if item & BLOCK_BIT == 0 {
            lanes.prefetch(&self.nodes[index]);
        } else {
            lanes.prefetch(&self.blocks[index]);
        }
    }
}

/// The stack of children to visit. Its first part needs no allocation.
pub(crate) struct Stack<T> {
    near: [T; STACK],
    far: Vec<T>,
    count: usize,
}

/// Twice the 35 that were the most among a million triangles (`peers/embree`). All of it is cleared for every ray.
const STACK: usize = 64;

impl<T: Copy + Default> Stack<T> {
    #[inline(always)]
    pub(crate) fn new() -> Self {
        Self { near: [T::default(); STACK], far: Vec::new(), count: 0 }
    }

    #[inline(always)]
    pub(crate) fn push(&mut self, item: T) {
        if self.count < STACK {
            self.near[self.count] = item;
            self.count += 1;
        } else {
            self.far.push(item);
        }
    }

    #[inline(always)]
    pub(crate) fn clear(&mut self) {
        self.far.clear();
        self.count = 0;
    }

    /// Pushes the first `count` items, the last of them on top.
    #[inline(always)]
    pub(crate) fn push_front(&mut self, items: &[T; WIDTH], count: usize) {
        if let Some(place) = self.near.get_mut(self.count..self.count + WIDTH)
            && self.far.is_empty()
        {
            place.copy_from_slice(items);
            self.count += count;
        } else {
            items[..count].iter().for_each(|&item| self.push(item));
        }
    }

    #[inline(always)]
    pub(crate) fn pop(&mut self) -> Option<T> {
        if let Some(item) = self.far.pop() {
            return Some(item);
        }
        self.count = self.count.checked_sub(1)?;
        Some(self.near[self.count % STACK])
    }
}

/// What accepts a hit of one ray: asked a few times for each ray, so that a call costs next to nothing. The code of
/// rays is compiled once for each kind of instructions, and not for every question again.
pub(crate) type Accept<'r> = &'r mut dyn FnMut(&Hit) -> bool;

/// The query for any accepted hit.
pub(crate) struct AnyHit<'a, 'r> {
    pub(crate) tree: Tree<'a>,
    pub(crate) ray: &'r Ray,
    pub(crate) accept: Accept<'r>,
}

impl Work for AnyHit<'_, '_> {
    type Output = bool;

    #[inline(always)]
    fn work<L: Lanes>(self, lanes: L) -> bool {
        let Ray { origin, t_max, .. } = *self.ray;
        let start = RayOrigin::new(origin, self.tree.bounds);
        start.frame_of(self.ray).is_some_and(|frame| {
            let ray = ShearedRay::new(origin, &frame, t_max);
            any_hit(lanes, &self.tree, &frame, &ray, t_max, self.accept)
        })
    }
}

/// Whether any hit is accepted.
///
/// In every node, blocks stand after inner nodes, so they come off the stack first: one hit is enough.
#[inline(always)]
fn any_hit<L: Lanes>(
    lanes: L,
    tree: &Tree<'_>,
    frame: &RayFrame,
    ray: &ShearedRay,
    t_max: f32,
    accept: Accept<'_>,
) -> bool {
    let slabs = SlabRay::new(lanes, frame);
    let t_max = lanes.splat(t_max * frame.longest * END_ROOM);
    let mut stack = Stack::new();
    let mut next = Some(0_u32);
    while let Some(item) = next {
        if item & BLOCK_BIT == 0 {
            let node = &tree.nodes[item as usize];
            // Intersect the eight boxes, go on with the last that is met, and push the others.
            let (mask, _) = slabs.meets(lanes, node, t_max);
            if mask != 0 {
                let last = mask.ilog2();
                let others = mask ^ 1 << last;
                if others != 0 {
                    let (met, count) = (lanes.compress(&node.children(), others), others.count_ones() as usize);
                    met[..count].iter().for_each(|&item| tree.prefetch(lanes, item));
                    stack.push_front(&met, count);
                }
                next = Some(node.child(last as usize));
                continue;
            }
        } else if tree.blocks[(item & !BLOCK_BIT) as usize].hits(lanes, ray, |hit| accept(&hit)) {
            return true;
        }
        next = stack.pop();
    }
    false
}

/// The query for the closest accepted hit; of equally close ones that of the triangle with the smallest index.
pub(crate) struct Closest<'a, 'r> {
    pub(crate) tree: Tree<'a>,
    pub(crate) ray: &'r Ray,
    pub(crate) accept: Accept<'r>,
}

impl Work for Closest<'_, '_> {
    type Output = Option<Hit>;

    #[inline(always)]
    fn work<L: Lanes>(self, lanes: L) -> Option<Hit> {
        let ray = self.ray;
        let frame = RayOrigin::new(ray.origin, self.tree.bounds).frame_of(ray)?;
        let sheared = ShearedRay::new(ray.origin, &frame, ray.t_max);
        let slabs = SlabRay::new(lanes, &frame);
        let end_of = |t: f32| t * frame.longest * END_ROOM;
        let mut best: Option<Hit> = None;
        let mut end = end_of(ray.t_max);
        let mut stack = Stack::new();
        let mut next = Some((0.0, 0_u32));
        while let Some((enter, item)) = next {
            if enter > end {
                // Skip a child behind the closest hit.
            } else if item & BLOCK_BIT != 0 {
                // Intersect the triangles of a block, and shorten the ray at an accepted hit.
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
                // Intersect the eight boxes, go on with the nearest that is met, and push the others.
                let (mask, enters) = slabs.meets(lanes, node, lanes.splat(end));
                let nearest = push_all_but_nearest(node, mask, &lanes.store(enters), &mut stack, |item| {
                    self.tree.prefetch(lanes, item);
                });
                if nearest.is_some() {
                    next = nearest;
                    continue;
                }
            }
            next = stack.pop();
        }
        best
    }
}

/// The nearest child of a mask, if there is one; pushes the others so that the nearest comes out first.
#[inline(always)]
pub(crate) fn push_all_but_nearest(
    node: &Node,
    mask: u32,
    enters: &[f32; WIDTH],
    stack: &mut Stack<(f32, u32)>,
    prefetch: impl Fn(u32),
) -> Option<(f32, u32)> {
    let child = |mask: u32| {
        let slot = mask.trailing_zeros() as usize % WIDTH;
        (enters[slot], node.child(slot))
    };
    if mask == 0 {
        return None;
    }
    let mut nearest = child(mask);
    let mut others = mask & (mask - 1);
    // One or two are met most often: without a place to sort them in.
    if others == 0 {
        return Some(nearest);
    }
    let mut farther = child(others);
    if farther.0 < nearest.0 {
        std::mem::swap(&mut nearest, &mut farther);
    }
    prefetch(farther.1);
    others &= others - 1;
    if others == 0 {
        stack.push(farther);
        return Some(nearest);
    }
    // Insertion sort of those that wait, the farthest first.
    let mut sorted = [(0.0_f32, 0_u32); WIDTH];
    sorted[0] = farther;
    let mut count = 1;
    while others != 0 {
        let mut next = child(others);
        others &= others - 1;
        if next.0 < nearest.0 {
            std::mem::swap(&mut nearest, &mut next);
        }
        let mut place = count;
        while place > 0 && sorted[place - 1].0 < next.0 {
            sorted[place] = sorted[place - 1];
            place -= 1;
        }
        prefetch(next.1);
        sorted[place] = next;
        count += 1;
    }
    sorted[..count].iter().for_each(|&item| stack.push(item));
    Some(nearest)
}
