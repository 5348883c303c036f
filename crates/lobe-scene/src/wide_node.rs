//! The nodes of the tree: eight boxes, or up to eight triangles.

use crate::lanes::{Lanes, WIDTH};
use crate::watertight::{ROUNDING, ShearedRay};
use crate::{Bounds, Hit};

/// What a node's child is: the index of a node, or of a [`Block`] with this bit set.
pub(crate) const BLOCK_BIT: u32 = 1 << 31;

/// Eight boxes and what lies in each. Rows are the smallest x, y, z, the largest x, y, z, the children as bits, and nothing.
///
/// One array of eight rows, so that a row's number needs three bits and no check.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(crate) struct Node {
    rows: [[f32; WIDTH]; 8],
}

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

    pub(crate) fn set_child(&mut self, slot: usize, child: u32) {
        self.rows[CHILDREN][slot] = f32::from_bits(child);
    }

    #[inline(always)]
    pub(crate) fn child(&self, slot: usize) -> u32 {
        self.rows[CHILDREN][slot % WIDTH].to_bits()
    }
}

/// Up to eight triangles: corners by corner, axis and lane. Lanes left over repeat the first triangle, which changes no
/// answer and leaves the block at five cache lines.
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

    /// Calls `found` with hits of the block's triangles, in no order, some of them twice, until it returns true; whether
    /// it did.
    #[inline(always)]
    pub(crate) fn hits<L: Lanes>(&self, lanes: L, ray: &ShearedRay, mut found: impl FnMut(Hit) -> bool) -> bool {
        let mut mask = ray.candidates(lanes, &self.corners);
        while mask != 0 {
            let lane = mask.trailing_zeros() as usize % WIDTH;
            mask &= mask - 1;
            let corners = std::array::from_fn(|c| std::array::from_fn(|axis| self.corners[c][axis][lane]));
            if let Some(hit) = ray.hit(corners, self.triangles[lane])
                && found(hit)
            {
                return true;
            }
        }
        false
    }
}

/// What a ray brings along to be tested against eight boxes.
///
/// A box is passed between where the ray enters the last of three slabs and where it leaves the first:
///
/// ```text
///   t = (b - o ∓ e) / d  =  b r - c_∓,      r = 1 / d,   c_∓ = (o ± e) r
/// ```
///
/// `e` widens each box by what rounding may do to either side: the sheared corners of a triangle are moved by
/// [`ShearedRay::SHEAR_ERROR`] · (`|A_i| + |A_z|`); `r`, the product and the difference add the rest of [`BOX_ERROR`] and
/// [`ORIGIN_ERROR`]. So whatever a ray hits lies in boxes that it meets, and the tree adds no gaps.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SlabRay<L: Lanes> {
    reciprocal: [L::Vector; 3],
    near_shift: [L::Vector; 3],
    far_shift: [L::Vector; 3],
    /// Rows of [`Node`] of the planes that the ray meets first and last.
    near_row: [usize; 3],
    far_row: [usize; 3],
}

/// Error of a plane relative to the distances to the farthest planes along its axis and the ray's: that of a sheared
/// corner, and four roundings of the slab test.
const BOX_ERROR: f32 = ShearedRay::SHEAR_ERROR + 4.0 * ROUNDING;

/// Error of a plane relative to the origin's coordinate: the rounding of `c`, twice.
const ORIGIN_ERROR: f32 = 4.0 * ROUNDING;

/// Components of a direction below this part of the longest count as this. Along the whole scene it moves a ray by less
/// than the boxes are widened, and no reciprocal becomes infinite, whose products with 0 are no numbers.
const SMALLEST_COMPONENT: f32 = 1e-10;

impl<L: Lanes> SlabRay<L> {
    #[inline(always)]
    pub(crate) fn new(lanes: L, ray: &ShearedRay, bounds: &Bounds) -> Self {
        let o = ray.origin;
        let extent: [f32; 3] = std::array::from_fn(|k| (bounds.min[k] - o[k]).abs().max((bounds.max[k] - o[k]).abs()));
        let mut near_row = [0; 3];
        let mut far_row = [0; 3];
        let mut numbers = [[0.0; 3]; 3];
        for k in 0..3 {
            let d = if ray.direction[k].abs() < SMALLEST_COMPONENT {
                SMALLEST_COMPONENT.copysign(ray.direction[k])
            } else {
                ray.direction[k]
            };
            let error = BOX_ERROR * (extent[k] + extent[ray.kz % 3]) + ORIGIN_ERROR * o[k].abs();
            let r = 1.0 / d;
            let widened = error.copysign(r);
            numbers[k] = [r, (o[k] + widened) * r, (o[k] - widened) * r];
            let is_backwards = usize::from(r < 0.0);
            near_row[k] = k + 3 * is_backwards;
            far_row[k] = k + 3 * (1 - is_backwards);
        }
        let splat = |i: usize| numbers.map(|n| lanes.splat(n[i]));
        Self { reciprocal: splat(0), near_shift: splat(1), far_shift: splat(2), near_row, far_row }
    }

    /// The lanes whose box is met up to `t_max` (in lengths of the scaled direction), and where each is entered.
    #[inline(always)]
    pub(crate) fn meets(&self, lanes: L, node: &Node, t_max: L::Vector) -> (u32, L::Vector) {
        let row = |r: usize| lanes.load(&node.rows[r & 7]);
        let near = |k: usize| lanes.mul_sub(row(self.near_row[k]), self.reciprocal[k], self.near_shift[k]);
        let far = |k: usize| lanes.mul_sub(row(self.far_row[k]), self.reciprocal[k], self.far_shift[k]);
        let enter = lanes.max(lanes.max(near(0), near(1)), lanes.max(near(2), lanes.splat(0.0)));
        let leave = lanes.min(lanes.min(far(0), far(1)), lanes.min(far(2), t_max));
        (lanes.less_or_equal(enter, leave), enter)
    }
}
