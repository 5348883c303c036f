//! The places of coefficients in an array.

use crate::basis::{coefficient_count, order_of};
use crate::prelude::*;

/// The places of the coefficients of order `n` in an array of a library.
///
/// ```text
///   Bands        (n²)            [l(l+1) + m]                       sphericart, e3nn, ACN of Ambisonics
///   NegativeEnd  (n, 2n-1)       [l, m], m < 0 from the end         scipy.special.sph_harm_y_all
///   Cilm         (2, n, n)       [0, l, m] and [1, l, |m|], m < 0   pyshtools
///   OrderMajor   (n(n+1)/2)      [m(2n-1-m)/2 + l], m >= 0 alone    healpy, SHTns
///   FuMa         (n²), n <= 4    W X Y Z R S T U V K L M N O P Q    Ambisonics before AmbiX
/// ```
///
/// Places that belong to no coefficient hold zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
pub enum CoefficientLayout {
    /// One band after the other, m from -l to l.
    Bands,
    /// A row for each band, m = 0, 1, .. and then the negative ones, as an index from the end finds them.
    NegativeEnd,
    /// Two squares: cosines, or m >= 0, and sines, or m < 0.
    Cilm,
    /// One m after the other, each with l from m on; m < 0 follows from a real function.
    OrderMajor,
    /// The letters of `FuMa`.
    FuMa,
}

/// The letter of each coefficient by its place in W X Y Z R S T U V K L M N O P Q.
const OF_FUMA: [usize; 16] = [0, 2, 3, 1, 8, 6, 4, 5, 7, 15, 13, 11, 9, 10, 12, 14];

impl CoefficientLayout {
    /// The shape of the array of order `n`.
    #[must_use]
    pub fn shape(self, order: usize) -> Vec<usize> {
        match self {
            Self::Bands | Self::FuMa => vec![coefficient_count(order)],
            Self::NegativeEnd => vec![order, (2 * order).saturating_sub(1)],
            Self::Cilm => vec![2, order, order],
            Self::OrderMajor => vec![order * (order + 1) / 2],
        }
    }

    /// The shape in letters, for messages.
    pub(crate) const fn shape_in_words(self) -> &'static str {
        match self {
            Self::Bands | Self::FuMa => "(n²)",
            Self::NegativeEnd => "(n, 2n-1)",
            Self::Cilm => "(2, n, n)",
            Self::OrderMajor => "(n(n+1)/2)",
        }
    }

    /// The number of axes.
    pub(crate) const fn axes(self) -> usize {
        match self {
            Self::Bands | Self::FuMa | Self::OrderMajor => 1,
            Self::NegativeEnd => 2,
            Self::Cilm => 3,
        }
    }

    /// The order of an array of this shape; none if there is none.
    #[must_use]
    pub fn order_of_shape(self, shape: &[usize]) -> Option<usize> {
        let order = match (self, shape) {
            (Self::NegativeEnd, &[order, _]) | (Self::Cilm, &[_, order, _]) => order,
            (_, &[count]) => self.order_of_count(count)?,
            _ => return None,
        };
        (order < usize::from(u16::MAX) && self.shape(order) == shape).then_some(order)
    }

    /// The order of so many numbers without a shape; none if there is none.
    #[must_use]
    pub fn order_of_count(self, count: usize) -> Option<usize> {
        let order = match self {
            Self::Bands | Self::FuMa => order_of(count)?,
            // 8 n(n+1)/2 + 1 = (2n+1)², and 8 n(2n-1) + 1 = (4n-1)².
            Self::OrderMajor => count.checked_mul(8)?.isqrt() / 2,
            Self::NegativeEnd => (count.checked_mul(8)?.checked_add(1)?.isqrt() + 1) / 4,
            Self::Cilm => (count / 2).isqrt(),
        };
        let found = self.shape(order).into_iter().try_fold(1_usize, usize::checked_mul)?;
        (found == count).then_some(order)
    }

    /// The place of a coefficient of order `n` in C order; none if it follows from that of `-m`.
    pub(crate) fn place(self, order: usize, l: usize, m: isize) -> Option<usize> {
        let k = m.unsigned_abs();
        match self {
            Self::Bands => Some(l * (l + 1)).and_then(|middle| middle.checked_add_signed(m)),
            Self::NegativeEnd => {
                let width = 2 * order - 1;
                Some(l * width + if m < 0 { width - k } else { k })
            }
            Self::Cilm => Some(if m < 0 { order * order } else { 0 } + l * order + k),
            Self::OrderMajor if m < 0 => None,
            Self::OrderMajor => Some(k * (2 * order - 1 - k) / 2 + l),
            Self::FuMa => OF_FUMA.get((l * (l + 1)).checked_add_signed(m)?).copied(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [CoefficientLayout; 5] = [
        CoefficientLayout::Bands,
        CoefficientLayout::NegativeEnd,
        CoefficientLayout::Cilm,
        CoefficientLayout::OrderMajor,
        CoefficientLayout::FuMa,
    ];

    #[test]
    fn every_coefficient_has_a_place_of_its_own_inside_the_array() {
        for layout in ALL {
            for order in 1..=4 {
                let count: usize = layout.shape(order).iter().product();
                let mut seen = vec![false; count];
                for (l, m) in (0..order).flat_map(|l| (-(l as isize)..=l as isize).map(move |m| (l, m))) {
                    let Some(place) = layout.place(order, l, m) else { continue };
                    assert!(place < count && !seen[place], "{layout:?}, order {order}, {l} {m}: {place} of {count}");
                    seen[place] = true;
                }
                let places = seen.into_iter().filter(|seen| *seen).count();
                let expected = if layout == CoefficientLayout::OrderMajor { count } else { order * order };
                assert_eq!(places, expected, "{layout:?}, order {order}");
            }
        }
    }

    #[test]
    fn the_order_is_found_by_the_shape_and_by_the_count() {
        for layout in ALL {
            for order in 1..=86 {
                let shape = layout.shape(order);
                let count = shape.iter().product();
                assert_eq!(layout.order_of_shape(&shape), Some(order), "{layout:?}: {shape:?}");
                assert_eq!(layout.order_of_count(count), Some(order), "{layout:?}: {count}");
                assert_eq!(layout.axes(), shape.len(), "{layout:?}");
            }
            for wrong in [&[5][..], &[2, 3, 4], &[3, 3], &[], &[usize::MAX], &[2, usize::MAX, usize::MAX]] {
                assert_eq!(layout.order_of_shape(wrong), None, "{layout:?}: {wrong:?}");
            }
            assert_eq!(layout.order_of_count(usize::MAX), None, "{layout:?}");
        }
    }

    #[test]
    fn letters_of_fuma_stand_in_the_published_order() {
        let letters: Vec<char> = "WXYZRSTUVKLMNOPQ".chars().collect();
        let by_acn = "WYZXVTRSUQOMKLNP".chars().enumerate();
        for (i, letter) in by_acn {
            let (l, m) = crate::basis::band_and_m(i);
            let place = CoefficientLayout::FuMa.place(4, l, m).unwrap();
            assert_eq!(letters[place], letter, "l {l}, m {m}");
        }
    }

    #[test]
    fn the_order_major_index_is_that_of_healpix() {
        let mut i = 0;
        for m in 0..7_isize {
            for l in m as usize..7 {
                assert_eq!(CoefficientLayout::OrderMajor.place(7, l, m), Some(i), "l {l}, m {m}");
                i += 1;
            }
        }
    }
}
