//! Error metrics of pictures: root mean square, relative error, peak signal-to-noise ratio.

use crate::error::ImageError;
use crate::picture::colormap::sequential;
use crate::picture::picture::Picture;
use crate::pixel::{IntoPixel, Pixel, widened};

/// Error metrics of an image against its reference, over all values and channels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct ErrorReport {
    /// The root of the mean squared difference, `√(mean (a - b)²)`, in the unit of the values.
    pub rmse: f64,
    /// The largest difference `max |a - b|`.
    pub max_abs: f64,
    /// The mean of the reference.
    pub mean: f64,
    /// `rmse / |mean|`; 0 for equal images, infinite if only the mean is 0.
    pub relative_rmse: f64,
    /// The peak signal-to-noise ratio `20 log10(max |b| / rmse)` in decibels; `∞` for equal images, `-∞` for a
    /// reference that is black.
    pub psnr: f64,
}

/// Compares an image `a` with its reference `b`, channel by channel.
///
/// Values are summed in order in `f64`. Empty images have zero errors and an infinite PSNR. A NaN in either makes
/// every number NaN, except the mean of a reference that has none. All pixels have the same weight: in a lat-long
/// picture the poles weigh more than their solid angle.
///
/// # Panics
/// If the two differ in length.
#[must_use]
pub fn compare<A: IntoPixel, B: IntoPixel>(image: &[A], reference: &[B]) -> ErrorReport {
    assert_eq!(image.len(), reference.len(), "the images to compare differ in size");
    report(channels(image), channels(reference), 3 * image.len())
}

/// All channels of all pixels.
fn channels<P: IntoPixel>(pixels: &[P]) -> impl Iterator<Item = f64> {
    pixels.iter().flat_map(|p| widened((*p).into()))
}

fn report(image: impl Iterator<Item = f64>, reference: impl Iterator<Item = f64>, count: usize) -> ErrorReport {
    let (mut squares, mut sum, mut max_abs, mut peak) = (0.0, 0.0, 0.0_f64, 0.0_f64);
    for (a, b) in image.zip(reference) {
        squares += (a - b) * (a - b);
        sum += b;
        max_abs = larger(max_abs, (a - b).abs());
        peak = larger(peak, b.abs());
    }
    let count = count.max(1) as f64;
    let (rmse, mean) = ((squares / count).sqrt(), sum / count);
    let relative_rmse = if rmse == 0.0 { 0.0 } else { rmse / mean.abs() };
    let psnr = if rmse == 0.0 { f64::INFINITY } else { 20.0 * (peak / rmse).log10() };
    ErrorReport { rmse, max_abs, mean, relative_rmse, psnr }
}

/// The mean of squared differences relative to the reference, over all values and channels.
///
/// ```text
///   mean (a - b)² / (b² + 0.01 (mean |b|)²)
/// ```
///
/// The second term limits the weight of black pixels; relative to the mean, it does not depend on the unit of the
/// light. Equal images give 0; a black reference and an image that is not, infinity.
///
/// # Panics
/// If the two differ in length.
#[must_use]
pub fn relative_mse<A: IntoPixel, B: IntoPixel>(image: &[A], reference: &[B]) -> f64 {
    assert_eq!(image.len(), reference.len(), "the images to compare differ in size");
    relative_error(&channels(image).collect::<Vec<_>>(), &channels(reference).collect::<Vec<_>>())
}

fn relative_error(a: &[f64], b: &[f64]) -> f64 {
    let count = b.len().max(1) as f64;
    let mean = b.iter().map(|b| b.abs()).sum::<f64>() / count;
    let error = |(a, b): (&f64, &f64)| if a == b { 0.0 } else { (a - b) * (a - b) / (b * b + 0.01 * mean * mean) };
    a.iter().zip(b).map(error).sum::<f64>() / count
}

/// The larger of two numbers; NaN, which `max` would skip, if either is.
fn larger(a: f64, b: f64) -> f64 {
    if a.is_nan() || a > b { a } else { b }
}

/// The difference of two colors as one number: the root of the mean squared difference of the channels.
#[must_use]
pub fn error_of(a: impl IntoPixel, b: impl IntoPixel) -> f64 {
    let (a, b) = (widened(a.into()), widened(b.into()));
    ((0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>() / 3.0).sqrt()
}

/// A picture of [`error_of`] at every pixel in the colors of [`sequential`]: black for none, white for `full_scale`
/// and more. No error is black on every scale, a full scale of 0 included; NaN is white.
///
/// # Errors
/// [`ImageError::Options`] if the two pictures differ in size.
pub fn error_map(image: &Picture, reference: &Picture, full_scale: f64) -> Result<Picture, ImageError> {
    let size = |p: &Picture| (p.width(), p.height());
    if size(image) != size(reference) {
        let ((w, h), (v, g)) = (size(image), size(reference));
        return Err(ImageError::Options(format!("cannot compare a {w} x {h} picture with one of {v} x {g}")));
    }
    let color = |(&a, &b): (&Pixel, &Pixel)| match error_of(a, b) {
        0.0 => sequential(0.0),
        error => sequential(error / full_scale),
    };
    let pixels: Vec<Pixel> = image.pixels().iter().zip(reference.pixels()).map(color).collect();
    Picture::new(image.width(), image.height(), pixels)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(image: &[f64], reference: &[f64]) -> ErrorReport {
        report(image.iter().copied(), reference.iter().copied(), image.len())
    }

    #[test]
    fn the_numbers_are_those_of_a_hand_computed_case() {
        let report = values(&[1.0, 2.0, 3.0, 6.0], &[1.0, 2.0, 5.0, 4.0]);
        let expected = ErrorReport {
            rmse: 2.0_f64.sqrt(),
            max_abs: 2.0,
            mean: 3.0,
            relative_rmse: 2.0_f64.sqrt() / 3.0,
            psnr: 0.0,
        };
        assert!((report.psnr - 20.0 * (5.0 / 2.0_f64.sqrt()).log10()).abs() < 1e-12, "{report:?}");
        assert_eq!(ErrorReport { psnr: 0.0, ..report }, expected, "differences 0, 0, 2, 2; mean 3");
    }

    #[test]
    fn equal_images_have_no_error() {
        let a = [[0.5, 1.0, -2.0_f32]; 7];
        let report = compare(&a, &a);
        assert_eq!((report.rmse, report.max_abs, report.relative_rmse), (0.0, 0.0, 0.0), "{report:?}");
        assert_eq!(report.psnr, f64::INFINITY, "{report:?}");
    }

    #[test]
    fn the_relative_error_does_not_depend_on_the_unit_of_light() {
        let (a, b) = ([1.0, 2.5, 0.1, 6.0], [1.0, 2.0, 0.0, 5.0]);
        let expected = (0.25 / 4.04 + 0.01 / 0.04 + 1.0 / 25.04) / 4.0;
        for unit in [1e-6, 1.0, 1e6] {
            let found = relative_error(&a.map(|x| x * unit), &b.map(|x| x * unit));
            assert!((found / expected - 1.0).abs() < 1e-12, "unit {unit}: {found} against {expected}");
        }
        assert_eq!(relative_error(&[0.0], &[0.0]), 0.0, "black and black");
        assert_eq!(relative_error(&[1.0], &[0.0]), f64::INFINITY, "black reference");
        assert!(relative_error(&[f64::NAN], &[1.0]).is_nan(), "NaN");
    }

    #[test]
    fn a_nan_is_in_every_number_that_it_concerns() {
        for k in 0..3 {
            let mut image = [1.0, 2.0, 3.0];
            image[k] = f64::NAN;
            let report = values(&image, &[1.0, 2.0, 4.0]);
            let numbers = [report.rmse, report.max_abs, report.relative_rmse, report.psnr];
            assert!(numbers.iter().all(|v| v.is_nan()), "NaN at {k}: {report:?}");
        }
    }

    #[test]
    fn a_black_reference_has_no_peak_and_no_scale() {
        let report = values(&[0.5], &[0.0]);
        assert_eq!((report.relative_rmse, report.psnr), (f64::INFINITY, f64::NEG_INFINITY), "{report:?}");
        let nothing = values(&[], &[]);
        assert_eq!((nothing.rmse, nothing.psnr), (0.0, f64::INFINITY), "{nothing:?}");
    }

    #[test]
    fn equal_pictures_have_a_black_error_map_on_the_scale_of_their_largest_error() {
        let picture = Picture::filled(3, 2, [0.7; 3]);
        let report = compare(picture.pixels(), picture.pixels());
        let map = error_map(&picture, &picture, report.max_abs).unwrap();
        assert!(map.pixels().iter().all(|&c| c == sequential(0.0)), "{:?}", map.pixels());
    }

    #[test]
    fn the_error_map_is_black_where_pictures_agree_and_white_at_full_scale() {
        let reference = Picture::filled(3, 1, [0.0; 3]);
        let mut image = reference.clone();
        image.pixels_mut()[1] = [0.5; 3];
        image.pixels_mut()[2] = [-2.0; 3];
        let map = error_map(&image, &reference, 2.0).unwrap();
        assert_eq!(map.pixels(), [sequential(0.0), sequential(0.25), sequential(1.0)], "errors 0, 0.5 and 2");
        let error = error_map(&image, &Picture::filled(1, 3, [0.0; 3]), 1.0).unwrap_err().to_string();
        assert_eq!(error, "cannot compare a 3 x 1 picture with one of 1 x 3", "{error}");
    }
}
