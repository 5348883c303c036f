//! The closest hits of many rays from one point, for which each node and block is read once.

use crate::bvh::edge_planes::EdgePlanes;
use crate::bvh::lanes::{Lanes, WIDTH, Work};
use crate::bvh::ray_frame::{BUNDLE, numbers};
use crate::bvh::ray_stream::{Bundle, BundleQuery, for_each_bundle};
use crate::bvh::traverse::{Accept, Closest, END_ROOM, Stack, Tree};
use crate::bvh::watertight::ShearedRay;
use crate::bvh::wide_node::{BLOCK_BIT, Block};
use crate::scene::ray::{Hit, Ray};

/// Finds the closest accepted hits of many rays from one point.
///
/// Rays traverse the tree in bundles as those of [`RayStream`](crate::bvh::ray_stream::RayStream) do. The boxes of a
/// node are visited in the order of their distances to the point, which is about that in which all rays meet them, and
/// a ray leaves the sets of boxes that lie beyond its hit. Planes through the point rule triangles out; those that are
/// left are hit where [`ShearedRay::hit`] says so. Hits are those of one ray at a time, bit by bit: the least by
/// distance and, of equal ones, by triangle.
pub(crate) struct ClosestStream<'a, 'r> {
    pub(crate) tree: Tree<'a>,
    pub(crate) origin: [f32; 3],
    pub(crate) directions: &'r [[f32; 3]],
    pub(crate) hits: &'r mut [Option<Hit>],
    /// Whether a ray, told by its place, stops at a hit.
    pub(crate) accept: AcceptAt<'r>,
}

/// What accepts a hit of a ray at a place among others.
pub(crate) type AcceptAt<'r> = &'r mut dyn FnMut(usize, &Hit) -> bool;

impl Work for ClosestStream<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn work<L: Lanes>(self, lanes: L) {
        let mut query = ClosestHits { hits: self.hits, accept: self.accept, stack: Stack::new(), found: Found::new() };
        for_each_bundle(lanes, &self.tree, self.origin, self.directions, &mut query);
    }
}

/// A child that waits: its index, how far all rays go at least before they meet it, and the rays that do.
type Waiting = (u32, f32, u64);

struct ClosestHits<'r> {
    hits: &'r mut [Option<Hit>],
    accept: AcceptAt<'r>,
    stack: Stack<Waiting>,
    found: Found,
}

impl BundleQuery for ClosestHits<'_> {
    #[inline(always)]
    fn bundle<L: Lanes>(&mut self, lanes: L, bundle: &Bundle<'_, L>) {
        let Self { hits, accept, stack, found } = self;
        found.clear(bundle.rays.len());
        stack.clear();
        let mut next = Some((0, 0.0, bundle.all()));
        while let Some((item, gap, set)) = next {
            let set = set & found.not_before(lanes, gap);
            if set == 0 {
                // All of them have hit something nearer since.
            } else if item & BLOCK_BIT == 0 {
                let node = &bundle.tree.nodes[item as usize];
                let (sets, gaps) = bundle.slabs.meets_before(lanes, node, bundle.rays, &found.ends, set);
                let mut waiting = [(0, 0.0, 0); WIDTH];
                let mut count = 0;
                for slot in 0..WIDTH {
                    if sets[slot] != 0 {
                        bundle.tree.prefetch(lanes, node.child(slot));
                        insert(&mut waiting, count, (node.child(slot), gaps[slot], sets[slot]));
                        count += 1;
                    }
                }
                waiting[..count].iter().for_each(|&child| stack.push(child));
            } else {
                let block = &bundle.tree.blocks[(item & !BLOCK_BIT) as usize];
                found.meet(lanes, bundle, block, set, accept);
            }
            next = stack.pop();
        }
        for (k, best) in found.best[..bundle.rays.len()].iter().enumerate() {
            hits[bundle.place(k)] = *best;
        }
    }

    #[inline(always)]
    fn single<L: Lanes>(&mut self, lanes: L, tree: &Tree<'_>, ray: &Ray, place: usize) {
        let accept: Accept<'_> = &mut |hit| (self.accept)(place, hit);
        self.hits[place] = lanes.run(Closest { tree: *tree, ray, accept });
    }
}

/// Inserts a child among `count` others, the farthest first.
#[inline(always)]
fn insert(sorted: &mut [Waiting; WIDTH], count: usize, child: Waiting) {
    let mut place = count;
    while place > 0 && sorted[place - 1].1 < child.1 {
        sorted[place % WIDTH] = sorted[place - 1];
        place -= 1;
    }
    sorted[place % WIDTH] = child;
}

/// What the rays of a bundle have found.
struct Found {
    /// Where they end, in lengths of their scaled directions.
    ends: [f32; BUNDLE],
    best: [Option<Hit>; BUNDLE],
    /// The rays that came near a triangle.
    rays: [Option<(ShearedRay, f32)>; BUNDLE],
}

impl Found {
    fn new() -> Self {
        Self { ends: [f32::INFINITY; BUNDLE], best: [None; BUNDLE], rays: [None; BUNDLE] }
    }

    /// Forgets what the first `count` rays have found.
    #[inline(always)]
    fn clear(&mut self, count: usize) {
        self.ends[..count].fill(f32::INFINITY);
        self.best[..count].fill(None);
        self.rays[..count].fill(None);
    }

    /// The rays that do not end before a distance.
    #[inline(always)]
    fn not_before<L: Lanes>(&self, lanes: L, gap: f32) -> u64 {
        let gap = lanes.splat(gap);
        let eights = self.ends.as_chunks::<WIDTH>().0.iter().enumerate();
        eights.fold(0, |set, (k, ends)| set | u64::from(lanes.less_or_equal(gap, lanes.load(ends))) << (k * WIDTH))
    }

    /// Intersects rays with the triangles of a block, and shortens those that hit.
    #[inline(always)]
    fn meet<L: Lanes>(&mut self, lanes: L, bundle: &Bundle<'_, L>, block: &Block, set: u64, accept: AcceptAt<'_>) {
        let planes = EdgePlanes::new(lanes, block.corners(), bundle.start.origin);
        for (lane, possible) in planes.may_hit(lanes, bundle.rays, set).into_iter().enumerate() {
            for k in numbers(possible) {
                let k = k % BUNDLE;
                let (ray, longest) = *self.rays[k].get_or_insert_with(|| sheared(bundle, k));
                if let Some(hit) = block.hit(&ray, lane)
                    && self.best[k].is_none_or(|best| (hit.t, hit.triangle) < (best.t, best.triangle))
                    && accept(bundle.place(k), &hit)
                {
                    self.best[k] = Some(hit);
                    self.ends[k] = hit.t * longest * END_ROOM;
                }
            }
        }
    }
}

/// A ray for the intersection of triangles, and the longest component of its direction.
#[inline(always)]
fn sheared<L: Lanes>(bundle: &Bundle<'_, L>, k: usize) -> (ShearedRay, f32) {
    let frame = bundle.start.frame(bundle.ray(k).direction);
    (ShearedRay::new(bundle.start.origin, &frame, f32::INFINITY), frame.longest)
}
