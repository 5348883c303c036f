//! Cropped panoramas: pictures that show a part of a lat-long map.

use std::f64::consts::{FRAC_PI_2, PI};

use lobe_image::{Picture, PictureReadOptions};
use lobe_sh::{Coefficient, Rgb};

use crate::error::EnvError;
use crate::map::env_map::EnvMap;

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

/// The part of a lat-long map of the whole sphere that a picture shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Shown {
    /// The left edge and the width, in parts of the whole width. What reaches beyond the right edge goes on at the left
    /// one.
    pub(crate) columns: [f64; 2],
    /// The lowest and the highest elevation, in radians.
    pub(crate) elevations: [f64; 2],
}

impl Shown {
    /// All around, between two elevations in radians.
    pub(crate) fn around([low, high]: [f64; 2], place: &str) -> Result<Self, EnvError> {
        let (lowest, highest) = (-FRAC_PI_2 - SAME_ANGLE, FRAC_PI_2 + SAME_ANGLE);
        if !(lowest..highest).contains(&low) || !(low..=highest).contains(&high) || low == high {
            let [low, high] = [low, high].map(f64::to_degrees);
            let message = format!("{place}: elevations rise within -90° to 90°, and {low}° to {high}° do not");
            return Err(EnvError::Options(message));
        }
        Ok(Self { columns: [0.0, 1.0], elevations: [low, high] })
    }

    /// Columns and rows of the whole map, whose texels are as large as those of a picture of this size.
    fn whole_size(&self, [width, height]: [usize; 2]) -> [usize; 2] {
        let [low, high] = self.elevations;
        [(width as f64 / self.columns[1]).round() as usize, (PI * height as f64 / (high - low)).round() as usize]
    }
}

/// The lat-long map of the whole sphere of a panorama that shows a part of it.
///
/// ```text
///   d = (high - low)/h                 the height of one of h rows
///   H = round(π/d)                     the rows of the map
///   r = (high - e)/d - 1/2             the row of the picture at the elevation e of the center of a row of the map
///   W = round(w/s)                     the columns of the map, of which w columns are the part s
///   c = w (u - left)/s - 1/2           the column of the picture at the part u of the width of the map, counted around
/// ```
///
/// This follows from the definition of the [lat-long mapping](crate::mapping::lat_long). Cameras note the same in whole
/// texels: the picture begins at row `CroppedAreaTopPixels` of `FullPanoHeightPixels` [Google 2013].
///
/// A texel of the map is interpolated between the two rows at `r` and the two columns at `c`; where these are whole it
/// is one of the picture.
pub(crate) fn whole_map(
    picture: &Picture,
    shown: &Shown,
    padding: Padding,
    limits: &PictureReadOptions,
    place: &str,
) -> Result<EnvMap, EnvError> {
    let stored = [picture.width(), picture.height()];
    let [width, height] = shown.whole_size(stored);
    limits.check_made([width, height], place)?;
    let row_height = (shown.elevations[1] - shown.elevations[0]) / stored[1] as f64;
    let columns: Vec<Option<Between>> =
        (0..width).map(|x| column((x as f64 + 0.5) / width as f64, shown, stored[0], padding)).collect();
    let mut texels: Vec<Rgb<f32>> = Vec::with_capacity(width * height);
    for y in 0..height {
        let elevation = FRAC_PI_2 - (y as f64 + 0.5) * PI / height as f64;
        let r = (shown.elevations[1] - elevation) / row_height - 0.5;
        let last = (stored[1] - 1) as f64;
        let is_shown = (-0.5 - SAME_ROW..=last + 0.5 + SAME_ROW).contains(&r);
        if !is_shown && padding == Padding::Black {
            texels.resize(texels.len() + width, Rgb::ZERO);
            continue;
        }
        let rows = Between::clamped(r, stored[1]);
        let texel = |at: &Option<Between>| at.as_ref().map_or(Rgb::ZERO, |at| mixed(picture, at, &rows));
        texels.extend(columns.iter().map(texel));
    }
    EnvMap::new(width, height, texels)
}

/// Two neighbors, and the share of the second.
struct Between {
    places: [usize; 2],
    share: f64,
}

impl Between {
    /// At `at`, of `count` places that end.
    fn clamped(at: f64, count: usize) -> Self {
        let at = snapped(at.clamp(0.0, (count - 1) as f64));
        let first = at as usize;
        Self { places: [first, (first + 1).min(count - 1)], share: at.fract() }
    }

    /// At `at`, of `count` places the last of which is beside the first.
    fn around(at: f64, count: usize) -> Self {
        let at = snapped(at);
        let first = at.floor();
        let places = [first, first + 1.0].map(|place| place.rem_euclid(count as f64) as usize % count);
        Self { places, share: at - first }
    }
}

/// The place itself, or the whole number that it is but for rounding.
fn snapped(at: f64) -> f64 {
    if (at - at.round()).abs() < SAME_ROW { at.round() } else { at }
}

/// The columns of a picture at the part `u` of the width of the map; none where it shows nothing and that stays black.
fn column(u: f64, shown: &Shown, width: usize, padding: Padding) -> Option<Between> {
    let [left, part] = shown.columns;
    let turn = width as f64 / part;
    let at = (u - left).rem_euclid(1.0) * turn - 0.5;
    if (part - 1.0).abs() * turn < SAME_ROW {
        return Some(Between::around(at, width));
    }
    let last = (width - 1) as f64;
    // What lies before the left edge is found behind the right one.
    let before = at - turn;
    let nearest = if at - last <= -before { at } else { before };
    let is_shown = (-0.5 - SAME_ROW..=last + 0.5 + SAME_ROW).contains(&nearest);
    (is_shown || padding == Padding::Edge).then(|| Between::clamped(nearest, width))
}

/// The texel between two columns and two rows.
fn mixed(picture: &Picture, columns: &Between, rows: &Between) -> Rgb<f32> {
    let [left, right] = columns.places;
    let along = |y: usize| {
        let [a, b] = [left, right].map(|x| Rgb::from(picture.pixel(x, y)).widen());
        a.scale(1.0 - columns.share) + b.scale(columns.share)
    };
    Rgb::narrow(along(rows.places[0]).scale(1.0 - rows.share) + along(rows.places[1]).scale(rows.share))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(picture: &Picture, degrees: [f64; 2], padding: Padding) -> Result<EnvMap, EnvError> {
        let shown = Shown::around(degrees.map(f64::to_radians), "test")?;
        whole_map(picture, &shown, padding, &PictureReadOptions::default().max_texels(1 << 20), "test")
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
        assert!(matches!(error, EnvError::Image(lobe_image::ImageError::Refused { .. })), "{error:?}");
    }

    #[test]
    fn a_crop_lies_where_it_is_said_to_lie_around_the_seam_too() {
        let picture = Picture::from_fn(4, 2, |x, y| [1.0 + x as f32, 1.0 + y as f32, 0.5]);
        for left in 0..16_usize {
            let shown = Shown { columns: [left as f64 / 16.0, 0.25], elevations: [0.0, 0.25 * PI] };
            let whole =
                whole_map(&picture, &shown, Padding::Black, &PictureReadOptions::default().max_texels(1 << 20), "test")
                    .unwrap();
            assert_eq!((whole.width(), whole.height()), (16, 8), "the whole sphere");
            for (x, y) in (0..16).flat_map(|x| (0..8).map(move |y| (x, y))) {
                let column = (x + 16 - left) % 16;
                let is_shown = column < 4 && (2..4).contains(&y);
                let expected = if is_shown { picture.pixel(column, y - 2) } else { [0.0; 3] };
                assert_eq!(whole.texel(x, y).to_array(), expected, "left {left}, column {x}, row {y}");
            }
        }
        let shown = Shown { columns: [0.25, 0.25], elevations: [0.0, 0.25 * PI] };
        let whole =
            whole_map(&picture, &shown, Padding::Edge, &PictureReadOptions::default().max_texels(1 << 20), "test")
                .unwrap();
        let reds: Vec<f32> = (0..16).map(|x| whole.texel(x, 0).r).collect();
        assert_eq!(reds, [1., 1., 1., 1., 1., 2., 3., 4., 4., 4., 4., 4., 4., 4., 1., 1.], "the nearest columns");
    }

    #[test]
    fn a_crop_between_texels_keeps_its_light() {
        let picture = Picture::filled(30, 20, [1.0; 3]);
        let shown = Shown { columns: [0.113, 0.37], elevations: [-0.4, 0.3] };
        let whole =
            whole_map(&picture, &shown, Padding::Black, &PictureReadOptions::default().max_texels(1 << 20), "test")
                .unwrap();
        let light: f64 = (0..whole.height())
            .map(|y| {
                let row: f64 = (0..whole.width()).map(|x| f64::from(whole.texel(x, y).r)).sum();
                row * (FRAC_PI_2 - (y as f64 + 0.5) * PI / whole.height() as f64).cos()
            })
            .sum::<f64>()
            * 2.0
            * PI
            * PI
            / (whole.width() * whole.height()) as f64;
        let expected = 0.37 * 2.0 * PI * (0.3_f64.sin() + 0.4_f64.sin());
        // The edges lie up to half a texel from where they are: of 30 columns and 20 rows.
        assert!((light / expected - 1.0).abs() < 0.5 / 30.0 + 0.5 / 20.0, "{light} for {expected}");
    }
}
