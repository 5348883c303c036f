//! Ray frame: the quantities of a ray that are computed once for all boxes and triangles; and bundles, rays from one point that
//! are traversed together.

use crate::scene::ray::Ray;
use crate::scene::scene::Bounds;

/// Half a unit in the last place of 1: the relative error of one rounded operation on `f32`.
pub(crate) const ROUNDING: f32 = 1.0 / 16_777_216.0;

/// A ray's shear, for [`ShearedRay`](crate::bvh::watertight::ShearedRay), and its reciprocals, for
/// [`SlabRay`](crate::bvh::wide_node::SlabRay).
///
/// Computed without branches, so that the compiler vectorizes a loop over rays.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct RayFrame {
    /// The direction with its longest component scaled to ±1.
    pub(crate) direction: [f32; 3],
    /// The absolute value of the longest component of the ray's direction; 0 if the ray hits nothing.
    pub(crate) longest: f32,
    /// The axis of the longest component.
    pub(crate) kz: u32,
    /// `(d_x, d_y) / d_z` of the axes after `kz`.
    pub(crate) shear: [f32; 2],
    /// `r = 1 / d`.
    pub(crate) reciprocal: [f32; 3],
    /// `c₊ = (o + e) r` and `c₋ = (o - e) r`, for the entry and exit planes.
    pub(crate) shift: [[f32; 3]; 2],
}

/// Bound of the error of a sheared coordinate: the roundings of `A_x` (1), of `S` (1), of `A_z` (1), of their product
/// (1) and of the last difference, whose size is at most `|A_x| + |A_z|` (1), with one to spare.
pub(crate) const SHEAR_ERROR: f32 = 6.0 * ROUNDING;

/// Error of a plane relative to the distances to the farthest planes along its axis and the ray's: that of a sheared
/// corner, and four roundings of the slab test.
const BOX_ERROR: f32 = SHEAR_ERROR + 4.0 * ROUNDING;

/// Error of a plane relative to the origin's coordinate: the rounding of `c`, twice.
const ORIGIN_ERROR: f32 = 4.0 * ROUNDING;

/// Components of a direction below this, relative to the longest, are replaced by it. Along the whole scene that moves
/// a ray by less than the boxes are widened, and no reciprocal becomes infinite, whose products with 0 are NaN.
const SMALLEST_COMPONENT: f32 = 1e-10;

/// The origin of rays.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RayOrigin {
    pub(crate) origin: [f32; 3],
    /// The distance to the farther of the scene's planes along each axis.
    extent: [f32; 3],
    is_finite: bool,
}

impl RayOrigin {
    #[inline(always)]
    pub(crate) fn new(origin: [f32; 3], bounds: &Bounds) -> Self {
        let farther = |k: usize| (bounds.min[k] - origin[k]).abs().max((bounds.max[k] - origin[k]).abs());
        let is_finite = origin.iter().all(|o| o.is_finite());
        Self { origin, extent: std::array::from_fn(farther), is_finite }
    }

    /// The largest distance to one of the scene's planes.
    #[inline(always)]
    pub(crate) fn farthest(&self) -> f32 {
        self.extent[0].max(self.extent[1]).max(self.extent[2])
    }

    /// The most by which the boxes of any ray are widened along an axis.
    #[inline(always)]
    pub(crate) fn widest(&self, axis: usize) -> f32 {
        self.room(axis, self.farthest())
    }

    /// The widening of boxes along an axis, for the extent along the ray's longest axis.
    #[inline(always)]
    fn room(&self, axis: usize, longest_extent: f32) -> f32 {
        BOX_ERROR * (self.extent[axis] + longest_extent) + ORIGIN_ERROR * self.origin[axis].abs()
    }

    /// The frame of a ray from here. Its `longest` is 0 if the direction is 0 or anything is NaN.
    #[inline(always)]
    pub(crate) fn frame(&self, d: [f32; 3]) -> RayFrame {
        let size = d.map(f32::abs);
        let is_x = size[0] >= size[1] && size[0] >= size[2];
        let is_y = !is_x & (size[1] >= size[2]);
        // The component of the axis `n` after kz.
        let after = |v: [f32; 3], n: usize| {
            let [x, y, z] = std::array::from_fn(|k| v[(k + n) % 3]);
            if is_x {
                x
            } else if is_y {
                y
            } else {
                z
            }
        };
        let longest = after(size, 0);
        // NaN if any component is NaN, infinite if any is infinite.
        let is_valid = self.is_finite & (longest > 0.0) & (size[0] + size[1] + size[2] < f32::INFINITY);
        let direction = d.map(|c| c / longest);
        // Division by ±1.
        let sign = after(direction, 0);
        let shear = [after(direction, 1) * sign, after(direction, 2) * sign];
        let mut frame = RayFrame {
            direction,
            longest: if is_valid { longest } else { 0.0 },
            kz: if is_x { 0 } else { 2 - u32::from(is_y) },
            shear,
            ..RayFrame::default()
        };
        for k in 0..3 {
            let c = if direction[k].abs() < SMALLEST_COMPONENT {
                SMALLEST_COMPONENT.copysign(direction[k])
            } else {
                direction[k]
            };
            let r = 1.0 / c;
            let widened = self.room(k, after(self.extent, 0)).copysign(r);
            frame.reciprocal[k] = r;
            frame.shift[0][k] = (self.origin[k] + widened) * r;
            frame.shift[1][k] = (self.origin[k] - widened) * r;
        }
        frame
    }

    /// The frame of a ray that starts here; `None` if it hits nothing.
    #[inline(always)]
    pub(crate) fn frame_of(&self, ray: &Ray) -> Option<RayFrame> {
        let frame = self.frame(ray.direction);
        (frame.longest > 0.0 && ray.t_max >= 0.0).then_some(frame)
    }
}

/// The most rays of a bundle: the bits of a set.
pub(crate) const BUNDLE: usize = 64;

/// A ray in a bundle.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(32))]
pub(crate) struct BundledRay {
    /// As in [`RayFrame`].
    pub(crate) reciprocal: [f32; 3],
    /// With its longest component scaled to ±1.
    pub(crate) direction: [f32; 3],
    /// The index in its batch.
    pub(crate) place: u32,
    pub(crate) key: u32,
}

/// The numbers in a set.
#[inline(always)]
pub(crate) fn numbers(set: u64) -> impl Iterator<Item = usize> {
    let mut rest = set;
    std::iter::from_fn(move || {
        let number = (rest != 0).then(|| rest.trailing_zeros() as usize);
        rest &= rest.wrapping_sub(1);
        number
    })
}
