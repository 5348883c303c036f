//! Bands 3 to 7 by straight-line code.

use crate::basis::index::{band_range, order_of_slice};
use crate::rotation::cos_sin::CosSin;
use crate::rotation::generated::{band_3, band_4, band_5, band_6, band_7};
use crate::{Coefficient, Real};

/// The bands that have code of their own.
pub(crate) const MIDDLE_BANDS: core::ops::RangeInclusive<usize> = 3..=7;

/// Cosine and sine of `m` times an angle, from `m = 1` to the highest band.
const PLACES: usize = 2 * *MIDDLE_BANDS.end();

/// Rotates the middle bands from `first_band` on by `R_z(α) R_y(β) R_z(γ)`, by the formula of
/// `rotate_bands_zyz`.
pub(crate) fn rotate_middle_bands<T: Coefficient>(
    [alpha, beta, gamma]: [CosSin; 3],
    first_band: usize,
    coefficients: &mut [T],
) {
    let order = order_of_slice(coefficients);
    let highest = (order - 1).min(*MIDDLE_BANDS.end());
    let p = multiples::<T::Scalar>(gamma, highest);
    let q = multiples(CosSin { sin: -beta.sin, ..beta }, highest);
    let r = multiples(alpha, highest);
    macro_rules! band {
        ($l:literal, $band:ident) => {
            if (first_band..order).contains(&$l)
                && let Some(f) = coefficients[band_range($l)].first_chunk_mut()
            {
                let before = *f;
                $band::rotate(&p, &q, &r, &before, f);
            }
        };
    }
    band!(3, band_3);
    band!(4, band_4);
    band!(5, band_5);
    band!(6, band_6);
    band!(7, band_7);
}

/// Cosine and sine of `m a` for `m = 1` to `highest`, `e^{i(m+1)a} = e^{ia} e^{ima}` in `f64`; zero above.
#[inline(always)]
fn multiples<S: Real>(angle: CosSin, highest: usize) -> [S; PLACES] {
    let mut places = [S::ZERO; PLACES];
    let (mut cos, mut sin) = (angle.cos, angle.sin);
    for place in places.chunks_exact_mut(2).take(highest) {
        place.copy_from_slice(&[S::from_f64(cos), S::from_f64(sin)]);
        (cos, sin) = (angle.cos * cos - angle.sin * sin, angle.sin * cos + angle.cos * sin);
    }
    places
}
