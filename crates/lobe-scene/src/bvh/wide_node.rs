//! BVH8 nodes: eight boxes, or up to eight triangles.

use crate::bvh::lanes::{Lanes, WIDTH};
use crate::bvh::ray_frame::RayFrame;
use crate::bvh::watertight::ShearedRay;
use crate::scene::ray::Hit;
use crate::scene::scene::Bounds;

/// A node's child is the index of a node, or with this bit set that of a [`Block`].
pub(crate) const BLOCK_BIT: u32 = 1 << 31;

/// Eight boxes and their children. Rows are the smallest x, y, z, the largest x, y, z, the children as bits, and
/// padding.
///
/// One array of eight rows, so that a row's index needs three bits and no bounds check.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(crate) struct Node {
    rows: [[f32; WIDTH]; 8],
}

/// Rows of the smallest and the largest coordinates.
pub(crate) const SMALLEST: [usize; 3] = [0, 1, 2];
pub(crate) const LARGEST: [usize; 3] = [3, 4, 5];

const CHILDREN: usize = 6;

impl Node {
    /// Eight boxes that no ray meets.
    pub(crate) fn empty() -> Self {
        let mut rows = [[0.0; WIDTH]; 8];
        rows[..3].fill([f32::INFINITY; WIDTH]);
        rows[3..6].fill([f32::NEG_INFINITY; WIDTH]);
        Self { rows }
    }

    pub(crate) fn set_box(&mut self, slot: usize, bounds: &Bounds) {
        for axis in 0..3 {
            self.rows[axis][slot] = bounds.min[axis];
            self.rows[axis + 3][slot] = bounds.max[axis];
        }
    }

    /// The box of a child; `None` where there is none.
    pub(crate) fn bounds(&self, slot: usize) -> Option<Bounds> {
        let at = |axes: [usize; 3]| axes.map(|row| self.rows[row][slot]);
        (self.rows[SMALLEST[0]][slot] <= self.rows[LARGEST[0]][slot])
            .then(|| Bounds { min: at(SMALLEST), max: at(LARGEST) })
    }

    pub(crate) fn set_child(&mut self, slot: usize, child: u32) {
        self.rows[CHILDREN][slot] = f32::from_bits(child);
    }

    /// Gives the children that there are other indices.
    pub(crate) fn move_children(&mut self, moved: impl Fn(u32) -> u32) {
        for slot in 0..WIDTH {
            if self.bounds(slot).is_some() {
                self.set_child(slot, moved(self.child(slot)));
            }
        }
    }

    /// One coordinate of all eight boxes.
    #[inline(always)]
    pub(crate) fn row<L: Lanes>(&self, lanes: L, row: usize) -> L::Vector {
        lanes.load(&self.rows[row & 7])
    }

    #[inline(always)]
    pub(crate) fn child(&self, slot: usize) -> u32 {
        self.rows[CHILDREN][slot % WIDTH].to_bits()
    }

    #[inline(always)]
    pub(crate) fn children(&self) -> [u32; WIDTH] {
        self.rows[CHILDREN].map(f32::to_bits)
    }
}

/// Up to eight triangles: corner by corner, axis and lane. Unused lanes repeat the first triangle, which changes no
/// answer and keeps the block at five cache lines.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(crate) struct Block {
    corners: [[[f32; WIDTH]; 3]; 3],
    triangles: [u32; WIDTH],
}

impl Block {
    /// The block of one to eight triangles.
    pub(crate) fn new(triangles: impl Iterator<Item = (u32, [[f32; 3]; 3])> + Clone) -> Self {
        let mut block = Self { corners: [[[0.0; WIDTH]; 3]; 3], triangles: [0; WIDTH] };
        let first = triangles.clone().next();
        for (lane, (triangle, corners)) in triangles.chain(first.into_iter().cycle()).take(WIDTH).enumerate() {
            for (corner, p) in corners.iter().enumerate() {
                for axis in 0..3 {
                    block.corners[corner][axis][lane] = p[axis];
                }
            }
            block.triangles[lane] = triangle;
        }
        block
    }

    /// Moves the corners of the triangles, and returns the box around them.
    pub(crate) fn refit(&mut self, corners: &[[[f32; 3]; 3]]) -> Bounds {
        let mut bounds = Bounds { min: [f32::INFINITY; 3], max: [f32::NEG_INFINITY; 3] };
        for (lane, &triangle) in self.triangles.iter().enumerate() {
            for (corner, p) in corners[triangle as usize].iter().enumerate() {
                for axis in 0..3 {
                    self.corners[corner][axis][lane] = p[axis];
                    bounds.min[axis] = bounds.min[axis].min(p[axis]);
                    bounds.max[axis] = bounds.max[axis].max(p[axis]);
                }
            }
        }
        bounds
    }

    /// Corner by corner, axis and lane.
    #[inline(always)]
    pub(crate) fn corners(&self) -> &[[[f32; WIDTH]; 3]; 3] {
        &self.corners
    }

    /// The hit of the triangle in a lane.
    #[inline(always)]
    pub(crate) fn hit(&self, ray: &ShearedRay, lane: usize) -> Option<Hit> {
        let lane = lane % WIDTH;
        let corners = std::array::from_fn(|c| std::array::from_fn(|axis| self.corners[c][axis][lane]));
        ray.hit(corners, self.triangles[lane])
    }

    /// Calls `found` with hits of the block's triangles, in no order, some of them twice, until it returns true;
    /// returns whether it did.
    #[inline(always)]
    pub(crate) fn hits<L: Lanes>(&self, lanes: L, ray: &ShearedRay, mut found: impl FnMut(Hit) -> bool) -> bool {
        let mut mask = ray.candidates(lanes, &self.corners);
        while mask != 0 {
            let lane = mask.trailing_zeros() as usize;
            mask &= mask - 1;
            if let Some(hit) = self.hit(ray, lane)
                && found(hit)
            {
                return true;
            }
        }
        false
    }
}

/// The slab test of a ray against eight boxes.
///
/// A ray is in a box from where it enters the last of three slabs to where it leaves the first:
///
/// ```text
///   t = (b - o ∓ e) / d  =  b r - c_∓,      r = 1 / d,   c_∓ = (o ± e) r
/// ```
///
/// The margin `e` widens each box by the rounding errors: the sheared corners of a triangle are moved by
/// [`SHEAR_ERROR`](crate::bvh::ray_frame::SHEAR_ERROR) · (`|A_i| + |A_z|`); `r`, the product and the difference add the
/// rest. So whatever a ray hits lies in boxes that it meets, and the tree adds no gaps.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SlabRay<L: Lanes> {
    reciprocal: [L::Vector; 3],
    near_shift: [L::Vector; 3],
    far_shift: [L::Vector; 3],
    /// Rows of [`Node`] of the entry and exit planes.
    near_row: [usize; 3],
    far_row: [usize; 3],
}

impl<L: Lanes> SlabRay<L> {
    #[inline(always)]
    pub(crate) fn new(lanes: L, frame: &RayFrame) -> Self {
        let splat = |numbers: [f32; 3]| numbers.map(|n| lanes.splat(n));
        let is_backwards = frame.reciprocal.map(|r| usize::from(r < 0.0));
        Self {
            reciprocal: splat(frame.reciprocal),
            near_shift: splat(frame.shift[0]),
            far_shift: splat(frame.shift[1]),
            near_row: std::array::from_fn(|k| k + 3 * is_backwards[k]),
            far_row: std::array::from_fn(|k| k + 3 * (1 - is_backwards[k])),
        }
    }

    /// The lanes whose box is met up to `t_max` (in lengths of the scaled direction), and the entry distance of each.
    #[inline(always)]
    pub(crate) fn meets(&self, lanes: L, node: &Node, t_max: L::Vector) -> (u32, L::Vector) {
        let row = |r: usize| node.row(lanes, r);
        let near = |k: usize| lanes.mul_sub(row(self.near_row[k]), self.reciprocal[k], self.near_shift[k]);
        let far = |k: usize| lanes.mul_sub(row(self.far_row[k]), self.reciprocal[k], self.far_shift[k]);
        let enter = lanes.max(lanes.max(near(0), near(1)), lanes.max(near(2), lanes.splat(0.0)));
        let leave = lanes.min(lanes.min(far(0), far(1)), lanes.min(far(2), t_max));
        (lanes.less_or_equal(enter, leave), enter)
    }
}
