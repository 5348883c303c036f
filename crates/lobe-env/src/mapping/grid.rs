//! The grid of texels of a picture: which of them lie around a direction.

use lobe_sh::Dir;

use crate::mapping::form::Pair;
use crate::mapping::mapping::Mapping;
use crate::mapping::taps::Taps;

/// The grid of texels of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Grid {
    pub(crate) mapping: Mapping,
    pub(crate) width: usize,
    pub(crate) height: usize,
}

impl Grid {
    pub(crate) fn new(mapping: Mapping, width: usize, height: usize) -> Self {
        Self { mapping, width, height }
    }

    pub(crate) fn size(&self) -> Pair {
        [self.width, self.height]
    }

    pub(crate) fn len(&self) -> usize {
        self.width * self.height
    }

    /// The point of the picture in the direction `s`, in texels from the upper left corner.
    #[inline]
    pub(crate) fn point(&self, s: Dir) -> [f64; 2] {
        self.mapping.form().point(self.size(), s)
    }

    /// The index of the texel that contains the point.
    #[inline]
    pub(crate) fn texel(&self, [x, y]: [f64; 2]) -> usize {
        (x as usize).min(self.width - 1) + self.width * (y as usize).min(self.height - 1)
    }

    /// The range of columns and rows around the point `p` in which the four texels around each point are neighbors in
    /// the picture; `None` in a picture with rims.
    pub(crate) fn inner_part(&self, p: [f64; 2]) -> Option<[[f64; 2]; 2]> {
        self.mapping.form().inner_part(self.size(), p)
    }

    /// The taps of the value at the point `p`.
    #[inline]
    pub(crate) fn taps(&self, p: [f64; 2]) -> Taps {
        self.mapping.form().taps(self.size(), p)
    }

    /// The taps of the value in the direction `s`.
    #[inline]
    pub(crate) fn taps_towards(&self, s: Dir) -> Taps {
        self.mapping.form().taps_towards(self.size(), s)
    }
}
