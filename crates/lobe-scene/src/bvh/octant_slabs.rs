//! Slab test of eight boxes against many rays from one point in the same octant.

use crate::bvh::lanes::{Lanes, WIDTH};
use crate::bvh::ray_frame::{BUNDLE, BundledRay, RayOrigin, numbers};
use crate::bvh::wide_node::{LARGEST, Node, SMALLEST};

/// The slab test for rays of one octant from one point.
///
/// ```text
///   t = (b - (o ± e)) r,   r = 1 / d
/// ```
///
/// The rays meet the same plane of each pair first, so the difference is computed once for all of them. `e` is the
/// margin of [`SlabRay`](crate::bvh::wide_node::SlabRay) for the ray with the largest one; the difference, `r` and the
/// product round once each, one time less than there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OctantSlabs<L: Lanes> {
    /// Rows of [`Node`] of the entry and exit planes, and `o ± e` for them.
    near_row: [usize; 3],
    far_row: [usize; 3],
    near_shift: [L::Vector; 3],
    far_shift: [L::Vector; 3],
    /// 1 or -1, as directions have it.
    sign: [L::Vector; 3],
}

impl<L: Lanes> OctantSlabs<L> {
    /// The bits of `octant` are set where x (4), y (2) and z (1) of the directions are below 0.
    #[inline(always)]
    pub(crate) fn new(lanes: L, start: &RayOrigin, octant: usize) -> Self {
        let is_backwards = [octant & 4 != 0, octant & 2 != 0, octant & 1 != 0];
        let low = |k: usize| start.origin[k] + start.widest(k);
        let high = |k: usize| start.origin[k] - start.widest(k);
        let either = |k: usize, is_low: bool| {
            if is_low { (SMALLEST[k], lanes.splat(low(k))) } else { (LARGEST[k], lanes.splat(high(k))) }
        };
        let near = |k: usize| either(k, !is_backwards[k]);
        let far = |k: usize| either(k, is_backwards[k]);
        Self {
            near_row: std::array::from_fn(|k| near(k).0),
            far_row: std::array::from_fn(|k| far(k).0),
            near_shift: std::array::from_fn(|k| near(k).1),
            far_shift: std::array::from_fn(|k| far(k).1),
            sign: is_backwards.map(|is_backwards| lanes.splat(if is_backwards { -1.0 } else { 1.0 })),
        }
    }

    /// The near and the far planes of eight boxes, as seen from the point.
    #[inline(always)]
    fn planes(&self, lanes: L, node: &Node) -> [[L::Vector; 3]; 2] {
        let plane = |row: usize, shift| lanes.sub(node.row(lanes, row), shift);
        let near = std::array::from_fn(|k| plane(self.near_row[k], self.near_shift[k]));
        let far = std::array::from_fn(|k| plane(self.far_row[k], self.far_shift[k]));
        [near, far]
    }

    /// For each box the rays of a set that meet it.
    #[inline(always)]
    pub(crate) fn meets(&self, lanes: L, node: &Node, rays: &[BundledRay], set: u64) -> [u64; WIDTH] {
        let [near, far] = self.planes(lanes, node);
        let zero = lanes.splat(0.0);
        let mut sets = lanes.empty_sets();
        for number in numbers(set) {
            let r = rays[number].reciprocal.map(|r| lanes.splat(r));
            let enter = |k: usize| lanes.mul(near[k], r[k]);
            let leave = |k: usize| lanes.mul(far[k], r[k]);
            let first = lanes.max(lanes.max(enter(0), enter(1)), lanes.max(enter(2), zero));
            let last = lanes.min(lanes.min(leave(0), leave(1)), leave(2));
            sets = lanes.insert_where(sets, first, last, number);
        }
        lanes.store_sets(sets)
    }

    /// For each box the rays of a set that meet it up to their ends, in lengths of their scaled directions; and how far
    /// they go at least before that.
    ///
    /// ```text
    ///   t ≥ max_k (b - (o ± e)) / |d_k| ≥ max_k |b - (o ± e)|,   as |d_k| ≤ 1
    /// ```
    #[inline(always)]
    pub(crate) fn meets_before(
        &self,
        lanes: L,
        node: &Node,
        rays: &[BundledRay],
        ends: &[f32; BUNDLE],
        set: u64,
    ) -> ([u64; WIDTH], [f32; WIDTH]) {
        let [near, far] = self.planes(lanes, node);
        let zero = lanes.splat(0.0);
        let mut sets = lanes.empty_sets();
        for number in numbers(set) {
            let r = rays[number].reciprocal.map(|r| lanes.splat(r));
            let enter = |k: usize| lanes.mul(near[k], r[k]);
            let leave = |k: usize| lanes.mul(far[k], r[k]);
            let end = lanes.splat(ends[number % BUNDLE]);
            let first = lanes.max(lanes.max(enter(0), enter(1)), lanes.max(enter(2), zero));
            let last = lanes.min(lanes.min(leave(0), leave(1)), lanes.min(leave(2), end));
            sets = lanes.insert_where(sets, first, last, number);
        }
        let gap = |k: usize| lanes.mul(near[k], self.sign[k]);
        let gaps = lanes.max(lanes.max(gap(0), gap(1)), lanes.max(gap(2), zero));
        (lanes.store_sets(sets), lanes.store(gaps))
    }
}
