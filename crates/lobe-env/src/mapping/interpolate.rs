//! Bilinear interpolation between the texel centers of any mapping, across its seams.

use lobe_sh::{Coefficient, Dir, Rgb};

use crate::mapping::taps::Grid;

/// A picture of a mapping, borrowed.
#[derive(Clone, Copy)]
pub(crate) struct Texels<'a> {
    pub(crate) grid: Grid,
    pub(crate) texels: &'a [Rgb<f32>],
}

impl Texels<'_> {
    /// The texel that contains the direction `s`.
    #[inline]
    pub(crate) fn nearest(&self, s: Dir) -> usize {
        self.grid.texel(self.grid.point(s))
    }

    /// The radiance from direction `s`, interpolated bilinearly between texel centers.
    pub(crate) fn radiance(&self, s: Dir) -> Rgb<f32> {
        let taps = self.grid.taps(self.grid.tap_point(s));
        taps.iter().fold(Rgb::ZERO, |sum, (index, weight)| sum + self.texels[index].scale(weight))
    }
}
