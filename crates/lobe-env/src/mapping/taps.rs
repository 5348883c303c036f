//! Taps of bilinear interpolation: the texels and weights that make up a picture's value at a point.

/// The most taps: four texels on each side of a rim.
const MAX_TAPS: usize = 8;

/// A tap: the index of a texel in the picture, and its weight.
pub(crate) type Share = (u32, f32);

/// Taps whose weights sum to 1.
///
/// A texel may occur twice. Pictures have fewer than 2³² texels: those would be 48 GiB.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Taps {
    list: [Share; MAX_TAPS],
    len: usize,
}

impl Taps {
    pub(crate) const NONE: Self = Self { list: [(0, 0.0); MAX_TAPS], len: 0 };

    /// Two texels beside each other and the two below, in the fractions `[s, t]` between their centers.
    #[inline(always)]
    pub(crate) fn of_four(upper: usize, lower: usize, [s, t]: [f32; 2]) -> Self {
        let mut taps = Self { len: 4, ..Self::NONE };
        taps.list[..4].copy_from_slice(&[
            (upper as u32, (1.0 - s) * (1.0 - t)),
            (upper as u32 + 1, s * (1.0 - t)),
            (lower as u32, (1.0 - s) * t),
            (lower as u32 + 1, s * t),
        ]);
        taps
    }

    #[inline(always)]
    pub(crate) fn iter(&self) -> impl Iterator<Item = (usize, f32)> + '_ {
        self.list[..self.len].iter().map(|&(index, weight)| (index as usize, weight))
    }

    #[inline(always)]
    pub(crate) fn push(&mut self, index: usize, weight: f32) {
        if weight > 0.0 {
            self.list[self.len] = (index as u32, weight);
            self.len += 1;
        }
    }
}

/// Calls `corner(column, row, weight)` for the four texels whose centers surround a point.
#[inline(always)]
pub(crate) fn for_each_corner([x, y]: [f64; 2], mut corner: impl FnMut(isize, isize, f32)) {
    let (column, row) = (x - 0.5, y - 0.5);
    let (left, above) = (column.floor(), row.floor());
    let (s, t) = ((column - left) as f32, (row - above) as f32);
    let (x, y) = (left as isize, above as isize);
    corner(x, y, (1.0 - s) * (1.0 - t));
    corner(x + 1, y, s * (1.0 - t));
    corner(x, y + 1, (1.0 - s) * t);
    corner(x + 1, y + 1, s * t);
}
