//! Ray streams: many rays from one point, for which each node and block is read once.

use crate::bvh::edge_planes::EdgePlanes;
use crate::bvh::lanes::{Lanes, WIDTH, Work};
use crate::bvh::octant_slabs::OctantSlabs;
use crate::bvh::ray_frame::{BUNDLE, BundledRay, RayOrigin, numbers};
use crate::bvh::traverse::{AnyHit, Stack, Tree};
use crate::bvh::watertight::ShearedRay;
use crate::bvh::wide_node::{BLOCK_BIT, Block};
use crate::scene::ray::Ray;

/// Finds which of many rays from one point are occluded.
///
/// ```text
///   rays of the point ─ by the signs of their directions ─→ octants ─→ bundles of at most 64
///   bundle: one traversal of the tree, each child on the stack with the set of rays that meet its box
/// ```
///
/// Sets of rays that traverse the tree together are the streams of [Barringer and Akenine-Möller 2014]; here they also
/// have a common origin. Rays of an octant meet the planes of every box in the same order, so a node is prepared once
/// for all of them; edge functions of triangles need three products each once the planes through the origin are known
/// ([`EdgePlanes`]). The tests of different rays at a node are independent, unlike the successive nodes of one ray.
///
/// A set is 64 bits. Rays that have hit leave all sets that wait on the stack. Boxes and planes are conservative, and
/// where planes are uncertain, [`ShearedRay::hit`] decides: the answers are those of one ray at a time, bit by bit,
/// whatever the instructions and however rays are bundled.
pub(crate) struct RayStream<'a, 'r> {
    pub(crate) tree: Tree<'a>,
    pub(crate) origin: [f32; 3],
    pub(crate) directions: &'r [[f32; 3]],
    pub(crate) occluded: &'r mut [bool],
}

/// The number of rays sorted at once: 16 KiB of them.
const BATCH: usize = 256;

/// Sort keys: three bits of signs and two of the longest axis, so that the parts of a large octant are compact; the
/// last key marks rays that are traced alone.
const KEYS: usize = 33;
const SINGLE: u32 = KEYS as u32 - 1;

/// Longer directions are traced alone: the depth of a certain hit divided by this is still above 0 in `f32`.
const LONGEST: f32 = 1e18;

/// Rays whose origin is farther from a part of the scene are traced alone: squares of larger numbers are infinite.
const FARTHEST: f32 = 1e18;

impl Work for RayStream<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn work<L: Lanes>(self, lanes: L) {
        let mut query = Occlusion { occluded: self.occluded, stack: Stack::new() };
        for_each_bundle(lanes, &self.tree, self.origin, self.directions, &mut query);
    }
}

/// What is asked about rays, those of a bundle together and the others alone.
pub(crate) trait BundleQuery {
    /// To be marked `#[inline(always)]`, as all that takes lanes.
    fn bundle<L: Lanes>(&mut self, lanes: L, bundle: &Bundle<'_, L>);

    /// The ray at a place among all.
    fn single<L: Lanes>(&mut self, lanes: L, tree: &Tree<'_>, ray: &Ray, place: usize);
}

/// Asks about many rays from one point.
#[inline(always)]
pub(crate) fn for_each_bundle<L: Lanes>(
    lanes: L,
    tree: &Tree<'_>,
    origin: [f32; 3],
    directions: &[[f32; 3]],
    query: &mut impl BundleQuery,
) {
    let start = RayOrigin::new(origin, tree.bounds);
    for (batch, directions) in directions.chunks(BATCH).enumerate() {
        let mut rays = [BundledRay::default(); BATCH];
        let ends = sort(&start, directions, &mut rays);
        for octant in 0..8 {
            let first = if octant == 0 { 0 } else { ends[4 * octant - 1] };
            let rays = &rays[first..ends[4 * octant + 3]];
            let slabs = OctantSlabs::new(lanes, &start, octant);
            let parts = rays.len().div_ceil(BUNDLE);
            for part in 0..parts {
                let rays = &rays[part * rays.len() / parts..(part + 1) * rays.len() / parts];
                query.bundle(
                    lanes,
                    &Bundle { tree, start: &start, directions, first: batch * BATCH, rays, slabs: &slabs },
                );
            }
        }
        for ray in &rays[ends[KEYS - 2]..directions.len()] {
            let place = ray.place as usize;
            query.single(lanes, tree, &Ray::new(origin, directions[place]), batch * BATCH + place);
        }
    }
}

/// Whether anything is hit.
struct Occlusion<'r> {
    occluded: &'r mut [bool],
    stack: Stack<(u32, u64)>,
}

impl BundleQuery for Occlusion<'_> {
    #[inline(always)]
    fn bundle<L: Lanes>(&mut self, lanes: L, bundle: &Bundle<'_, L>) {
        let hit = bundle.trace(lanes, &mut self.stack);
        for k in 0..bundle.rays.len() {
            self.occluded[bundle.place(k)] = hit >> k & 1 != 0;
        }
    }

    #[inline(always)]
    fn single<L: Lanes>(&mut self, lanes: L, tree: &Tree<'_>, ray: &Ray, place: usize) {
        self.occluded[place] = lanes.run(AnyHit { tree: *tree, ray, accept: &mut |_| true });
    }
}

/// Sorts the rays by their keys; returns the end of each key.
#[inline(always)]
fn sort(start: &RayOrigin, directions: &[[f32; 3]], sorted: &mut [BundledRay; BATCH]) -> [usize; KEYS] {
    let mut rays = [BundledRay::default(); BATCH];
    let is_near = start.farthest() <= FARTHEST;
    for (ray, &direction) in rays.iter_mut().zip(directions) {
        let frame = start.frame(direction);
        let [x, y, z] = frame.reciprocal.map(|r| u32::from(r < 0.0));
        let is_usual = is_near & (frame.longest > 0.0) & (frame.longest <= LONGEST);
        let key = if is_usual { x << 4 | y << 3 | z << 2 | frame.kz } else { SINGLE };
        *ray = BundledRay { reciprocal: frame.reciprocal, direction: frame.direction, place: 0, key };
    }
    let rays = &rays[..directions.len()];
    let mut ends = [0; KEYS];
    for ray in rays {
        ends[ray.key as usize] += 1;
    }
    for k in 1..KEYS {
        ends[k] += ends[k - 1];
    }
    let mut places = [0; KEYS];
    places[1..].copy_from_slice(&ends[..KEYS - 1]);
    for (place, ray) in rays.iter().enumerate() {
        let next = &mut places[ray.key as usize];
        sorted[*next] = BundledRay { place: place as u32, ..*ray };
        *next += 1;
    }
    ends
}

/// Up to 64 rays of one octant.
pub(crate) struct Bundle<'a, L: Lanes> {
    pub(crate) tree: &'a Tree<'a>,
    pub(crate) start: &'a RayOrigin,
    /// Those of the batch, whose first ray has this place among all.
    directions: &'a [[f32; 3]],
    first: usize,
    pub(crate) rays: &'a [BundledRay],
    pub(crate) slabs: &'a OctantSlabs<L>,
}

impl<L: Lanes> Bundle<'_, L> {
    /// The place of a ray among all.
    #[inline(always)]
    pub(crate) fn place(&self, k: usize) -> usize {
        self.first + self.rays[k].place as usize
    }

    /// The set of all its rays.
    #[inline(always)]
    pub(crate) fn all(&self) -> u64 {
        !0 >> (BUNDLE - self.rays.len())
    }

    pub(crate) fn ray(&self, k: usize) -> Ray {
        Ray::new(self.start.origin, self.directions[self.rays[k].place as usize])
    }

    /// The set of rays that are occluded.
    #[inline(always)]
    fn trace(&self, lanes: L, stack: &mut Stack<(u32, u64)>) -> u64 {
        let all = self.all();
        let mut free = all;
        stack.clear();
        let mut next = Some((0, all));
        while let Some((item, set)) = next {
            let set = set & free;
            if set == 0 {
                // All of them have been found occluded since.
            } else if item & BLOCK_BIT == 0 {
                let node = &self.tree.nodes[item as usize];
                let sets = self.slabs.meets(lanes, node, self.rays, set);
                let mut met = (0..WIDTH).fold(0_u32, |met, k| met | u32::from(sets[k] != 0) << k);
                while met != 0 {
                    let slot = met.trailing_zeros() as usize % WIDTH;
                    met &= met - 1;
                    self.tree.prefetch(lanes, node.child(slot));
                    stack.push((node.child(slot), sets[slot]));
                }
            } else {
                free &= !self.hits(lanes, &self.tree.blocks[(item & !BLOCK_BIT) as usize], set);
            }
            next = stack.pop();
        }
        all & !free
    }

    /// The rays of a set that hit a triangle of a block.
    #[inline(always)]
    fn hits(&self, lanes: L, block: &Block, set: u64) -> u64 {
        let planes = EdgePlanes::new(lanes, block.corners(), self.start.origin);
        let (mut hit, unsure) = planes.hits(lanes, self.rays, set);
        for (lane, unsure) in unsure.into_iter().enumerate() {
            for k in numbers(unsure) {
                if hit >> k & 1 == 0 && self.is_hit(block, lane, k) {
                    hit |= 1 << k;
                }
            }
        }
        hit
    }

    /// Whether a ray hits a triangle.
    #[cold]
    fn is_hit(&self, block: &Block, lane: usize, k: usize) -> bool {
        let ray = self.ray(k);
        let hit = |frame| block.hit(&ShearedRay::new(ray.origin, &frame, ray.t_max), lane);
        self.start.frame_of(&ray).and_then(hit).is_some()
    }
}
