//! Bins along each axis, and the split between bins that the surface area heuristic prefers.

use glam::{Vec3A, Vec4};

/// A box and the index of what it is around. The index is in the fourth lane of `min`, as bits, so that both corners are
/// loaded as they lie in memory.
///
/// The fourth lane enters the arithmetic of the other three. Below 2²³ the bits alone are a denormal number, for each
/// of which processors of Intel leave their pipeline: [`NORMAL`] makes the lane 2 or more.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Primitive {
    min: Vec4,
    max: Vec4,
}

/// The bit of the exponent that makes a number normal, whatever its others. Indices are below it.
const NORMAL: u32 = 1 << 30;

/// The most primitives of a tree: those with an index below [`NORMAL`].
pub(crate) const MOST_PRIMITIVES: usize = NORMAL as usize;

impl Primitive {
    pub(crate) fn new(index: u32, corners: &[[f32; 3]; 3]) -> Self {
        let [a, b, c] = corners.map(Vec3A::from);
        let (min, max) = (a.min(b).min(c), a.max(b).max(c));
        Self { min: Vec4::from((min, f32::from_bits(index | NORMAL))), max: Vec4::from((max, 0.0)) }
    }

    pub(crate) fn index(&self) -> u32 {
        self.min.w.to_bits() & !NORMAL
    }

    #[inline(always)]
    pub(crate) fn min(&self) -> Vec3A {
        Vec3A::from_vec4(self.min)
    }

    #[inline(always)]
    pub(crate) fn max(&self) -> Vec3A {
        Vec3A::from_vec4(self.max)
    }

    /// Twice the center of the box: halves would only cost time.
    #[inline(always)]
    pub(crate) fn center(&self) -> Vec3A {
        self.min() + self.max()
    }
}

/// A box that grows.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Extent {
    pub(crate) min: Vec3A,
    pub(crate) max: Vec3A,
}

impl Extent {
    pub(crate) const NOTHING: Self = Self { min: Vec3A::INFINITY, max: Vec3A::NEG_INFINITY };

    #[inline(always)]
    pub(crate) fn with(self, min: Vec3A, max: Vec3A) -> Self {
        Self { min: self.min.min(min), max: self.max.max(max) }
    }

    #[inline(always)]
    pub(crate) fn and(self, other: Self) -> Self {
        self.with(other.min, other.max)
    }

    /// The box around twice the centers of some primitives.
    #[inline(always)]
    pub(crate) fn of_centers(primitives: &[Primitive]) -> Self {
        primitives.iter().fold(Self::NOTHING, |all, p| all.with(p.center(), p.center()))
    }

    #[inline(always)]
    pub(crate) fn half_area(&self) -> f32 {
        let size = self.max - self.min;
        (size.x + size.y) * size.z + size.x * size.y
    }
}

/// The box around some primitives, and that around twice their centers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Volume {
    pub(crate) boxes: Extent,
    pub(crate) centers: Extent,
}

impl Volume {
    pub(crate) const NOTHING: Self = Self { boxes: Extent::NOTHING, centers: Extent::NOTHING };

    pub(crate) fn around(primitives: &[Primitive]) -> Self {
        primitives.iter().fold(Self::NOTHING, |all, p| Self {
            boxes: all.boxes.with(p.min(), p.max()),
            centers: all.centers.with(p.center(), p.center()),
        })
    }

    pub(crate) fn and(self, other: Self) -> Self {
        Self { boxes: self.boxes.and(other.boxes), centers: self.centers.and(other.centers) }
    }
}

/// The most bins along an axis.
const MOST_BINS: usize = 32;

/// Bins along an axis for few boxes, and for how many boxes there is one more. More bins for few boxes fill blocks better, and take
/// longer to look through than they save.
const FEWEST_BINS: usize = 8;
const BOXES_OF_A_BIN: usize = 8;

/// 2²³: adding it to a number from 0 to 2²² leaves the nearest whole number in the lowest bits.
const WHOLE: f32 = 8_388_608.0;

/// The bins of the centers of some primitives: as wide along each axis as they spread there, those at both ends half as wide.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Grid {
    start: Vec3A,
    scale: Vec3A,
    /// Bins along each axis.
    count: usize,
}

impl Grid {
    /// The bins of so many boxes, with the box around twice their centers.
    pub(crate) fn new(centers: &Extent, boxes: usize) -> Self {
        let count = (FEWEST_BINS + boxes / BOXES_OF_A_BIN).min(MOST_BINS);
        let size = centers.max - centers.min;
        let scale = Vec3A::splat((count - 1) as f32) / size;
        // An axis without extent, or with one whose reciprocal is infinite, has one bin.
        let scale = Vec3A::from(scale.to_array().map(|s| if s.is_finite() { s } else { 0.0 }));
        Self { start: centers.min, scale, count }
    }

    /// The bins of a primitive along the three axes.
    #[inline(always)]
    pub(crate) fn bins(&self, primitive: &Primitive) -> [usize; 3] {
        let places = (primitive.center() - self.start) * self.scale + WHOLE;
        places.to_array().map(|place| place.to_bits() as usize % MOST_BINS)
    }

    /// Whether a primitive is before a split.
    #[inline(always)]
    pub(crate) fn is_left(&self, primitive: &Primitive, split: &Split) -> bool {
        let axis = split.axis;
        // As in `bins`, whose whole numbers are in the order of these.
        let place = (primitive.min[axis] + primitive.max[axis] - self.start[axis]) * self.scale[axis] + WHOLE;
        place < split.bin as f32 + WHOLE
    }
}

/// What lies in each bin of a [`Grid`].
#[derive(Clone, Debug)]
pub(crate) struct Bins {
    boxes: [[Extent; MOST_BINS]; 3],
    counts: [[u32; MOST_BINS]; 3],
}

/// A split: of the bins along an axis, those before one go left.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Split {
    pub(crate) axis: usize,
    pub(crate) bin: usize,
    pub(crate) left_count: usize,
    pub(crate) left: Extent,
    pub(crate) right: Extent,
}

impl Bins {
    pub(crate) fn new() -> Self {
        Self { boxes: [[Extent::NOTHING; MOST_BINS]; 3], counts: [[0; MOST_BINS]; 3] }
    }

    /// Empties the bins of a grid.
    pub(crate) fn clear(&mut self, grid: &Grid) {
        for axis in 0..3 {
            self.boxes[axis][..grid.count].fill(Extent::NOTHING);
            self.counts[axis][..grid.count].fill(0);
        }
    }

    pub(crate) fn add(&mut self, grid: &Grid, primitives: &[Primitive]) {
        for primitive in primitives {
            let (min, max) = (primitive.min(), primitive.max());
            for (axis, bin) in grid.bins(primitive).into_iter().enumerate() {
                let place = &mut self.boxes[axis][bin];
                *place = place.with(min, max);
                self.counts[axis][bin] += 1;
            }
        }
    }

    /// Adds what another has in its bins of the same grid.
    pub(crate) fn and(mut self, other: &Self) -> Self {
        for axis in 0..3 {
            for bin in 0..MOST_BINS {
                self.boxes[axis][bin] = self.boxes[axis][bin].and(other.boxes[axis][bin]);
                self.counts[axis][bin] += other.counts[axis][bin];
            }
        }
        self
    }

    /// The split of least cost, of equal ones the most balanced; `None` if all are in one bin or the costs are no numbers.
    pub(crate) fn best_split(&self, grid: &Grid, cost_of: impl Fn(f32, u32) -> f32) -> Option<Split> {
        let mut best: Option<(f32, u32, Split)> = None;
        for axis in (0..3).filter(|&axis| grid.scale[axis] > 0.0) {
            let (boxes, counts) = (&self.boxes[axis], &self.counts[axis]);
            let mut rights = [(Extent::NOTHING, 0_u32, 0.0_f32); MOST_BINS];
            let (mut right, mut count) = (Extent::NOTHING, 0);
            for bin in (1..grid.count).rev() {
                (right, count) = (right.and(boxes[bin]), count + counts[bin]);
                rights[bin] = (right, count, cost_of(right.half_area(), count));
            }
            let (mut left, mut count) = (Extent::NOTHING, 0);
            for bin in 1..grid.count {
                (left, count) = (left.and(boxes[bin - 1]), count + counts[bin - 1]);
                let (right, right_count, right_cost) = rights[bin];
                if count == 0 || right_count == 0 {
                    continue;
                }
                let cost = cost_of(left.half_area(), count) + right_cost;
                let larger = count.max(right_count);
                let is_better =
                    best.as_ref().is_none_or(|(least, least_larger, _)| (cost, larger) < (*least, *least_larger));
                if is_better && cost.is_finite() {
                    best = Some((cost, larger, Split { axis, bin, left_count: count as usize, left, right }));
                }
            }
        }
        best.map(|(_, _, split)| split)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lane_of_an_index_is_a_normal_number_and_gives_it_back() {
        let most = MOST_PRIMITIVES as u32 - 1;
        // Above 0x3f7f_ffff the lane is infinite or no number, which costs nothing either.
        let indices = (0..24).map(|bit| 1 << bit).flat_map(|i| [i - 1, i]).chain([0x3f7f_ffff, most]);
        for index in indices {
            let primitive = Primitive::new(index, &[[0.0; 3]; 3]);
            assert_eq!(primitive.index(), index, "what comes back");
            let lane = primitive.min.w;
            assert!(lane.abs() >= 2.0 || lane.is_nan(), "index {index}: {lane:e}");
        }
    }
}
