//! Bounding volume hierarchy with eight children per node (BVH8): construction and ray queries.

use crate::bvh::binned;
use crate::bvh::bins::MOST_PRIMITIVES;
use crate::bvh::closest_stream::{AcceptAt, ClosestStream};
use crate::bvh::collapse::collapse;
use crate::bvh::interleaved::{AnyHits, ClosestHits};
use crate::bvh::lanes::Machine;
use crate::bvh::lanes::Simd;
use crate::bvh::layers::LeftOut;
use crate::bvh::ray_frame::ROUNDING;
use crate::bvh::ray_stream::RayStream;
use crate::bvh::refit::{cost, refit};
use crate::bvh::traverse::{Accept, AnyHit, Closest, Tree};
use crate::bvh::wide_node::{Block, Node};
use crate::scene::mesh::LARGEST_COORDINATE;
use crate::scene::ray::{Hit, Ray};
use crate::scene::scene::{Bounds, Scene};

/// A bounding volume hierarchy over triangles, eight children to a node (BVH8), for ray queries.
///
/// Intersection is watertight: no ray passes between two triangles that share an edge or a vertex, wherever it comes
/// from. Triangles are hit from both sides. Hits do not depend on the machine: all of [`Simd`] find the same, bit by
/// bit.
///
/// # Examples
///
/// ```
/// use lobe_scene::{Bvh, Ray};
///
/// let bvh = Bvh::from_corners(&[[[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]]]);
/// let Some(hit) = bvh.closest(&Ray::new([0.25, 0.25, 0.0], [0.0, 0.0, 2.0])) else { panic!("it is above") };
/// assert_eq!((hit.t, hit.u, hit.v), (0.5, 0.25, 0.25));
/// assert!(!bvh.is_occluded(&Ray::new([0.6, 0.6, 0.0], [0.0, 0.0, 1.0])));
/// ```
#[derive(Clone, Debug)]
pub struct Bvh {
    nodes: Vec<Node>,
    blocks: Vec<Block>,
    bounds: Bounds,
    triangles: usize,
    pub(crate) machine: Machine,
    /// The expected cost when it was built; `None` until it is refit.
    built_cost: Option<f32>,
    /// Triangles that are at the place of others, and not in the tree.
    left_out: LeftOut,
}

/// A tree is built anew where refits have made its expected cost this many times that of when it was built. A walking figure
/// makes it 1.09 at most, of a tree over figure and ground, where rays at the figure take 1.03 to 1.08 times as long.
const WORN: f32 = 1.1;

/// The height above a surface at which a ray has to start so as not to hit it, relative to the largest coordinate of
/// the scene.
///
/// Triangles are hit as if their corners were moved by 6 roundings of their distances to the ray's origin along two
/// axes, which are at most twice the largest coordinate M: by 24 ε M, ε = 2⁻²⁴, along each of two axes, 34 ε M in all.
/// The point itself, a corner or between corners, is off by another 2 ε M, its sum with the offset by as much. A ray
/// that starts 64 ε M above a plane and does not go down therefore stays above all triangles in or below that plane as
/// they are hit.
const OFFSET: f32 = 64.0 * ROUNDING;

/// Bytes of a tree from which on independent rays are occluded in turns. Smaller ones lie in the caches near the
/// processor: there a ray alone is quicker (`peers/embree`: turns take 1.09 of its time at 10 thousand triangles, 0.87 at
/// 100 thousand and 0.64 at a million).
const OCCLUDED_IN_TURNS: usize = 2 << 20;

/// Bytes of a tree from which on closest hits of independent rays are found in turns, which cost more than those of
/// occlusion (`peers/embree`: 1.15 of the time of a ray alone at 100 thousand triangles, 1.0 at 400 thousand and 0.9 at
/// a million).
const CLOSEST_IN_TURNS: usize = 32 << 20;

impl Bvh {
    /// The BVH of all triangles of a scene, with the scene's indices.
    ///
    /// Of triangles at one place those are not in it that rays cannot reach: duplicates of one without holes that runs
    /// around the same way, and more than 64 that light goes through.
    #[must_use]
    pub fn new(scene: &Scene) -> Self {
        let corners: Vec<_> = scene.corners().collect();
        Self::of(&corners, LeftOut::of(scene, &corners))
    }

    /// The BVH of the triangles with these corners, with their indices in the slice. Without triangles nothing is hit.
    ///
    /// # Panics
    /// If a coordinate is not finite or above 10¹⁵, or there are more than 2³⁰ triangles.
    #[must_use]
    pub fn from_corners(corners: &[[[f32; 3]; 3]]) -> Self {
        Self::of(corners, LeftOut::default())
    }

    fn of(corners: &[[[f32; 3]; 3]], left_out: LeftOut) -> Self {
        assert!(corners.len() <= MOST_PRIMITIVES, "{} triangles", corners.len());
        let is_in_range = |c: &f32| c.abs() <= LARGEST_COORDINATE;
        assert!(
            corners.as_flattened().as_flattened().iter().all(is_in_range),
            "a coordinate is no number of at most 1e15"
        );
        let mut bounds = Bounds { min: [f32::INFINITY; 3], max: [f32::NEG_INFINITY; 3] };
        for p in corners.as_flattened() {
            for axis in 0..3 {
                bounds.min[axis] = bounds.min[axis].min(p[axis]);
                bounds.max[axis] = bounds.max[axis].max(p[axis]);
            }
        }
        let machine = Machine::detect();
        let triangles = corners.len();
        if triangles == 0 {
            let bounds = Bounds { min: [0.0; 3], max: [0.0; 3] };
            return Self {
                nodes: vec![Node::empty()],
                blocks: Vec::new(),
                bounds,
                triangles,
                machine,
                built_cost: None,
                left_out,
            };
        }
        let binary = match left_out.is_empty() {
            true => binned::build(corners),
            false => binned::build_of(corners, &left_out.others(triangles)),
        };
        let (nodes, blocks) = collapse(&binary, corners);
        Self { nodes, blocks, bounds, triangles, machine, built_cost: None, left_out }
    }

    /// Moves the triangles to where they are in another pose of the scene, in linear time: the tree stays, its boxes change.
    ///
    /// A tree that lacks triangles at the place of others is built anew where a pose parts them.
    ///
    /// Rays find the same as in a tree built anew. They take the longer the more the triangles have parted from those
    /// they share a box with, which [`expected_cost`](Self::expected_cost) tells.
    ///
    /// # Panics
    /// If the scene has another number of triangles.
    pub fn refit(&mut self, scene: &Scene) {
        assert_eq!(scene.triangle_count(), self.triangles, "triangles of the scene and of the tree");
        self.built_cost = Some(self.built_cost.unwrap_or_else(|| self.expected_cost()));
        if self.triangles > 0 {
            let corners: Vec<_> = scene.corners().collect();
            if !self.left_out.are_at_their_places(&corners) {
                let machine = self.machine;
                *self = Self { machine, ..Self::new(scene) };
                return;
            }
            self.bounds = refit(&mut self.nodes, &mut self.blocks, &corners);
        }
    }

    /// The tree of another pose of the scene: [refit](Self::refit), or built anew where the triangles have parted so far that
    /// its [expected cost](Self::expected_cost) is 1.1 times that of when it was built.
    ///
    /// On a walking figure of 11 and of 111 thousand triangles, one thread, a refit takes 1/14 and 1/12 of the time of building
    /// anew; half of the walk later rays at the figure take 1.08 and 1.03 times as long as in a new tree (`cargo bench -p
    /// lobe-scene --bench poses`). So a tree is refit for each frame, and built anew for a picture of many millions of rays.
    ///
    /// # Panics
    /// If the scene has another number of triangles.
    pub fn update(&mut self, scene: &Scene) {
        self.refit(scene);
        if self.built_cost.is_some_and(|built_cost| self.expected_cost() > WORN * built_cost) {
            let machine = self.machine;
            *self = Self { machine, ..Self::new(scene) };
        }
    }

    /// The expected number of nodes and blocks of triangles that a ray comes to which meets the box of all triangles: the
    /// areas of their boxes relative to that of the whole, a block counting 1.2. By it a tree that was
    /// [refit](Self::refit) is compared with the one that was built.
    #[must_use]
    pub fn expected_cost(&self) -> f32 {
        cost(&self.nodes, &self.bounds)
    }

    /// The same BVH, traversed with other vector instructions than the widest, which are the default; `None` if this
    /// machine does not have them.
    #[must_use]
    pub fn with_simd(self, simd: Simd) -> Option<Self> {
        Some(Self { machine: Machine::new(simd)?, ..self })
    }

    /// Number of triangles.
    #[must_use]
    pub fn triangle_count(&self) -> usize {
        self.triangles
    }

    /// The smallest box around all triangles.
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// The memory of the BVH in bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.nodes.len() * size_of::<Node>() + self.blocks.len() * size_of::<Block>()
    }

    /// The height to which [`Bvh::origin_above`] lifts a point above a surface: 2⁻¹⁸ of the largest coordinate of all
    /// triangles. That is little, because scenes are [near their origin](Scene::origin).
    #[must_use]
    pub fn offset(&self) -> f32 {
        OFFSET * self.bounds.min.iter().chain(&self.bounds.max).fold(0.0, |most: f32, c| most.max(c.abs()))
    }

    /// An offset ray origin: rays from it towards the side of `normal` do not hit the surface on which `point` lies.
    ///
    /// `normal` is the unit normal of the surface, on the side of the rays: a surface within the plane through the
    /// point, and everything behind that plane, is missed by all rays with `d · normal ≥ 0`. For a vertex, whose
    /// triangles lie in several planes, pass the shading normal.
    ///
    /// The lift is [`Bvh::offset`], derived from the error of the intersection, not tuned; the test
    /// `grazing_rays_do_not_hit_the_surface_they_start_from` shows that none of 10⁵ rays hits, and that without it some
    /// do.
    #[must_use]
    pub fn origin_above(&self, position: [f32; 3], normal: [f32; 3]) -> [f32; 3] {
        let offset = f64::from(self.offset());
        std::array::from_fn(|k| (f64::from(position[k]) + offset * f64::from(normal[k])) as f32)
    }

    /// Whether anything is hit.
    ///
    /// A ray whose direction is 0, or with a number that is not finite, hits nothing.
    #[must_use]
    pub fn is_occluded(&self, ray: &Ray) -> bool {
        self.is_occluded_where(ray, |_| true)
    }

    /// Whether any hit is accepted: with [`Scene::stops`], rays pass through the holes of alpha masks
    /// and through glass.
    #[must_use]
    pub fn is_occluded_where(&self, ray: &Ray, mut accept: impl FnMut(&Hit) -> bool) -> bool {
        self.is_occluded_by(ray, &mut accept)
    }

    /// Compiled here, and not in every crate that asks.
    #[inline(never)]
    fn is_occluded_by(&self, ray: &Ray, accept: Accept<'_>) -> bool {
        self.machine.run(AnyHit { tree: self.tree(), ray, accept })
    }

    /// Occlusion of many half lines from one point: the same answers as [`Bvh::is_occluded`].
    ///
    /// Up to 256 consecutive rays of the slice are traversed together, and rays of similar direction share the work:
    /// the more rays in a call, the less time for each.
    ///
    /// # Panics
    /// If the lengths differ.
    pub fn occluded_from_into(&self, origin: [f32; 3], directions: &[[f32; 3]], occluded: &mut [bool]) {
        assert_eq!(directions.len(), occluded.len(), "directions and answers");
        self.machine.run(RayStream { tree: self.tree(), origin, directions, occluded });
    }

    /// The closest hits of many half lines from one point: the same as of [`Bvh::closest`], bit by bit, in less time.
    ///
    /// # Panics
    /// If the lengths differ.
    pub fn closest_from_into(&self, origin: [f32; 3], directions: &[[f32; 3]], hits: &mut [Option<Hit>]) {
        self.closest_from_where_into(origin, directions, hits, |_, _| true);
    }

    /// The closest hits that are accepted, each for the ray at that place among the directions.
    ///
    /// # Panics
    /// If the lengths differ.
    pub fn closest_from_where_into(
        &self,
        origin: [f32; 3],
        directions: &[[f32; 3]],
        hits: &mut [Option<Hit>],
        mut accept: impl FnMut(usize, &Hit) -> bool,
    ) {
        self.closest_from_by(origin, directions, hits, &mut accept);
    }

    #[inline(never)]
    fn closest_from_by(
        &self,
        origin: [f32; 3],
        directions: &[[f32; 3]],
        hits: &mut [Option<Hit>],
        accept: AcceptAt<'_>,
    ) {
        assert_eq!(directions.len(), hits.len(), "directions and hits");
        self.machine.run(ClosestStream { tree: self.tree(), origin, directions, hits, accept });
    }

    /// The closest hit; of equally close ones that of the triangle with the smallest index.
    #[must_use]
    pub fn closest(&self, ray: &Ray) -> Option<Hit> {
        self.closest_where(ray, |_| true)
    }

    /// The closest hit that is accepted.
    #[must_use]
    pub fn closest_where(&self, ray: &Ray, mut accept: impl FnMut(&Hit) -> bool) -> Option<Hit> {
        self.closest_by(ray, &mut accept)
    }

    #[inline(never)]
    fn closest_by(&self, ray: &Ray, accept: Accept<'_>) -> Option<Hit> {
        self.machine.run(Closest { tree: self.tree(), ray, accept })
    }

    /// Occlusion of many independent rays: the same answers as [`Bvh::is_occluded`], in less time where the tree is
    /// large.
    ///
    /// Some rays are traversed in turns, so that they wait for memory together. Those of one point are quicker by
    /// [`Bvh::occluded_from_into`].
    ///
    /// # Panics
    /// If the lengths differ.
    pub fn occluded_into(&self, rays: &[Ray], occluded: &mut [bool]) {
        self.occluded_where_into(rays, occluded, |_, _| true);
    }

    /// Whether any hit of each ray is accepted, told by its place among the rays.
    ///
    /// # Panics
    /// If the lengths differ.
    pub fn occluded_where_into(
        &self,
        rays: &[Ray],
        occluded: &mut [bool],
        mut accept: impl FnMut(usize, &Hit) -> bool,
    ) {
        assert_eq!(rays.len(), occluded.len(), "rays and answers");
        if self.bytes() < OCCLUDED_IN_TURNS {
            for (place, (ray, occluded)) in rays.iter().zip(occluded).enumerate() {
                *occluded = self.is_occluded_where(ray, |hit| accept(place, hit));
            }
            return;
        }
        self.machine.run(AnyHits { tree: self.tree(), rays, occluded, accept });
    }

    /// The closest hits of many independent rays: the same as of [`Bvh::closest`], bit by bit, in less time where the
    /// tree is large.
    ///
    /// # Panics
    /// If the lengths differ.
    pub fn closest_into(&self, rays: &[Ray], hits: &mut [Option<Hit>]) {
        self.closest_where_into(rays, hits, |_, _| true);
    }

    /// The closest hits that are accepted, each for the ray at that place.
    ///
    /// # Panics
    /// If the lengths differ.
    pub fn closest_where_into(
        &self,
        rays: &[Ray],
        hits: &mut [Option<Hit>],
        mut accept: impl FnMut(usize, &Hit) -> bool,
    ) {
        assert_eq!(rays.len(), hits.len(), "rays and hits");
        if self.bytes() < CLOSEST_IN_TURNS {
            for (place, (ray, hit)) in rays.iter().zip(hits).enumerate() {
                *hit = self.closest_where(ray, |hit| accept(place, hit));
            }
            return;
        }
        self.machine.run(ClosestHits { tree: self.tree(), rays, hits, accept });
    }

    pub(crate) fn tree(&self) -> Tree<'_> {
        Tree { nodes: &self.nodes, blocks: &self.blocks, bounds: &self.bounds }
    }
}
