//! Cropped panoramas: pictures that show all around, but not all of the height.

use std::f64::consts::{FRAC_PI_2, PI};

use lobe_image::{ImageError, Picture, ReadOption};
use lobe_sh::{Coefficient, Rgb};

use crate::{EnvError, EnvMap};

/// Rows that are no farther apart than this, in rows, are the same.
const SAME_ROW: f64 = 1e-6;

/// The rounding of an angle that was given in degrees.
const SAME_ANGLE: f64 = 1e-9;

/// What the directions get that a cropped panorama or a fisheye picture does not show.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Padding {
    /// No light.
    #[default]
    Black,
    /// The light of the nearest row, or of the nearest point of the circle, or of the last pixel of the picture towards there.
    Edge,
}

/// The lat-long map of a panorama whose rows cover the elevations from `low` to `high`, in radians.
///
/// ```text
///   d = (high - low)/h                 the height of one of h rows
///   H = round(π/d)                     the rows of the map
///   r = (high - e)/d - 1/2             the row of the picture at the elevation e of the center of a row of the map
/// ```
///
/// This follows from the definition of the [lat-long mapping](crate::mapping::lat_long). Cameras note the same in whole rows:
/// the picture begins at row `CroppedAreaTopPixels` of `FullPanoHeightPixels` [Google 2013].
///
/// A row of the map is interpolated between the two rows at `r`; where `π/d` and `(π/2 - high)/d` are whole it is one of
/// them. Columns stay.
pub(crate) fn whole_map(
    picture: &Picture,
    [low, high]: [f64; 2],
    padding: Padding,
    max_texels: usize,
    place: &str,
) -> Result<EnvMap, EnvError> {
    let (lowest, highest) = (-FRAC_PI_2 - SAME_ANGLE, FRAC_PI_2 + SAME_ANGLE);
    if !(lowest..highest).contains(&low) || !(low..=highest).contains(&high) || low == high {
        let [low, high] = [low, high].map(f64::to_degrees);
        let message = format!("{place}: elevations rise within -90° to 90°, and {low}° to {high}° do not");
        return Err(EnvError::Options(message));
    }
    let (width, stored) = (picture.width(), picture.height());
    let row_height = (high - low) / stored as f64;
    let height = (PI / row_height).round() as usize;
    if width.checked_mul(height).is_none_or(|texels| texels > max_texels) {
        let message = format!("the whole map is {width} x {height}, more than the limit of {max_texels} texels");
        return Err(ImageError::Refused { place: place.into(), message, option: ReadOption::MaxTexels }.into());
    }
    let row = |y: usize| &picture.pixels()[y * width..][..width];
    let last = (stored - 1) as f64;
    let mut texels: Vec<Rgb<f32>> = Vec::with_capacity(width * height);
    for y in 0..height {
        let elevation = FRAC_PI_2 - (y as f64 + 0.5) * PI / height as f64;
        let r = (high - elevation) / row_height - 0.5;
        let is_shown = (-0.5 - SAME_ROW..=last + 0.5 + SAME_ROW).contains(&r);
        if !is_shown && padding == Padding::Black {
            texels.resize(texels.len() + width, Rgb::ZERO);
            continue;
        }
        let r = r.clamp(0.0, last);
        let r = if (r - r.round()).abs() < SAME_ROW { r.round() } else { r };
        let (first, share) = (r as usize, r.fract());
        let below = row((first + 1).min(stored - 1));
        let mixed = |(a, b): (&[f32; 3], &[f32; 3])| {
            Rgb::narrow(Rgb::from(*a).widen().scale(1.0 - share) + Rgb::from(*b).widen().scale(share))
        };
        texels.extend(row(first).iter().zip(below).map(mixed));
    }
    EnvMap::new(width, height, texels)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(picture: &Picture, degrees: [f64; 2], padding: Padding) -> Result<EnvMap, EnvError> {
        whole_map(picture, degrees.map(f64::to_radians), padding, 1 << 20, "test")
    }

    #[test]
    fn rows_lie_at_the_elevations_that_they_show() {
        // Rows of 10 degrees: each is one of the map.
        let picture = Picture::from_fn(5, 6, |x, y| [y as f32 + 1.0, x as f32, 0.5]);
        let whole = map(&picture, [-20.0, 40.0], Padding::Black).unwrap();
        assert_eq!((whole.width(), whole.height()), (5, 18), "the whole sphere");
        for y in 0..18 {
            for x in 0..5 {
                let expected = if (5..11).contains(&y) { picture.pixel(x, y - 5) } else { [0.0; 3] };
                assert_eq!(whole.texel(x, y).to_array(), expected, "row {y}, column {x}");
            }
        }
        let whole = map(&picture, [-20.0, 40.0], Padding::Edge).unwrap();
        assert_eq!([whole.texel(0, 0).r, whole.texel(0, 17).r], [1.0, 6.0], "the nearest rows");
    }

    #[test]
    fn a_picture_of_the_whole_sphere_stays_as_it_is() {
        let picture = Picture::from_fn(8, 7, |x, y| [x as f32, y as f32, 1.0]);
        let whole = map(&picture, [-90.0, 90.0], Padding::Black).unwrap();
        assert!(whole.texels().iter().map(|t| t.to_array()).eq(picture.pixels().iter().copied()), "{whole:?}");
    }

    #[test]
    fn rows_between_those_of_the_map_are_interpolated() {
        // The elevation in degrees, at the centers of seven rows between -30 and 40.
        let picture = Picture::from_fn(2, 7, |_, y| [35.0 - 10.0 * y as f32, 0.0, 0.0]);
        let whole = map(&picture, [-31.0, 41.0], Padding::Edge).unwrap();
        assert_eq!(whole.height(), 18, "rows of 72/7 degrees, rounded");
        let slope = 72.0 / 70.0;
        for y in 6..12 {
            let elevation = 85.0 - 10.0 * y as f32;
            let expected = 5.0 + (elevation - 5.0) / slope;
            let found = whole.texel(1, y).r;
            assert!((found - expected).abs() < 1e-4, "row {y}: {found} for {expected}");
        }
    }

    #[test]
    fn impossible_ranges_and_endless_maps_are_refused() {
        let picture = Picture::filled(4, 2, [1.0; 3]);
        for degrees in [[10.0, 10.0], [20.0, 10.0], [-91.0, 0.0], [0.0, 90.5], [f64::NAN, 10.0], [0.0, f64::NAN]] {
            let error = map(&picture, degrees, Padding::Black);
            assert!(matches!(error, Err(EnvError::Options(_))), "{degrees:?}: {error:?}");
        }
        let error = map(&picture, [0.0, 1e-4], Padding::Black).unwrap_err();
        assert!(matches!(error, EnvError::Image(ImageError::Refused { .. })), "{error:?}");
    }
}
