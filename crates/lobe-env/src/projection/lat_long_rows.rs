//! The rows of a lat-long picture, of numbers or of colors, where they lie.

use lobe_sh::Coefficient;

use crate::map::mapped_map::MappedMap;

/// Texels row after row.
#[derive(Clone, Copy)]
pub(crate) struct LatLongRows<'a, C> {
    texels: &'a [C],
    width: usize,
}

impl<'a, C: Coefficient> LatLongRows<'a, C> {
    /// Panics if the texels are not whole rows, or there are none.
    pub(crate) fn new(texels: &'a [C], width: usize) -> Self {
        assert!(
            width > 0 && !texels.is_empty() && texels.len().is_multiple_of(width),
            "{} texels are no rows of {width}",
            texels.len()
        );
        Self { texels, width }
    }

    pub(crate) fn width(self) -> usize {
        self.width
    }

    pub(crate) fn height(self) -> usize {
        self.texels.len() / self.width
    }

    /// Row `y`, from the top.
    pub(crate) fn row(self, y: usize) -> &'a [C] {
        &self.texels[y * self.width..][..self.width]
    }
}

impl<'a> From<&'a MappedMap> for LatLongRows<'a, lobe_sh::Rgb<f32>> {
    fn from(map: &'a MappedMap) -> Self {
        Self { texels: map.texels(), width: map.width() }
    }
}
