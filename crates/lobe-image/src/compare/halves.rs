//! Error against a noisy reference: two independent halves of it leave out its noise.

use crate::error::ImageError;
use crate::pixel::{IntoPixel, widened};

/// The part of the pixels that may be brighter than the peak of the PSNR: single paths that find a sun are.
const BRIGHTER_THAN_PEAK: f64 = 0.001;

/// A pixel is dark below this part of its reference, if that is not dark itself.
const DARK: f64 = 0.1;

/// A reference is seen bright above this part of the mean of all.
const BRIGHT: f64 = 0.25;

/// The error of a picture P against a reference of which there are two independent estimates A and B, such as path
/// traced pictures of different seeds.
///
/// ```text
///   e² = mean (P - A)(P - B)      E e² = mean (P - R)²,  R = E A = E B
///   relative_rms = e / √(mean A B)
/// ```
///
/// The noise of A is independent of that of B, and the mean of its product with anything else is zero: unlike the mean
/// of (P - A)², this has no noise of the reference in it (test
/// `the_error_is_found_under_noise_that_is_larger_than_it`). What noise P has counts. Below zero, which chance can lead
/// to where P is better than the estimate, e is zero.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct HalvesReport {
    /// The number of pixels that count.
    pub pixels: usize,
    /// The root mean square error as a part of that of the reference.
    pub relative_rms: f64,
    /// How far `relative_rms` may be raised by chance: one standard error of the mean of all pixels.
    pub uncertainty: f64,
    /// The mean of the picture divided by that of the reference.
    pub mean_ratio: f64,
    /// `20 log₁₀(peak / e)` in decibels. The peak is a value that a thousandth of the reference's values exceed.
    pub psnr: f64,
    /// The noise of the mean of both halves as a part of the reference, both as root mean squares.
    pub noise: f64,
    /// The part of the pixels that are below a tenth of a reference that is above a quarter of its mean.
    pub dark: f64,
}

impl HalvesReport {
    /// Compares a picture with both halves of its reference, where `counts` says so of a pixel's index.
    ///
    /// # Errors
    /// [`ImageError::Options`] if the three differ in length, no pixel counts or a value that counts is not finite.
    pub fn new<P: IntoPixel>(
        picture: &[P],
        halves: [&[P]; 2],
        counts: impl Fn(usize) -> bool,
    ) -> Result<Self, ImageError> {
        let [a, b] = halves;
        if a.len() != picture.len() || b.len() != picture.len() {
            let (found, first, second) = (picture.len(), a.len(), b.len());
            let message = format!("expected halves of {found} pixels, as the picture has, found {first} and {second}");
            return Err(ImageError::Options(message));
        }
        let of = |p: &P| widened((*p).into());
        let counted = (0..picture.len()).filter(|&i| counts(i));
        let values: Vec<[[f64; 3]; 3]> = counted.map(|i| [of(&picture[i]), of(&a[i]), of(&b[i])]).collect();
        if values.is_empty() {
            return Err(ImageError::Options("expected pixels that show surfaces, found none".to_owned()));
        }
        if !values.as_flattened().as_flattened().iter().all(|value| value.is_finite()) {
            return Err(ImageError::Options("expected finite values, found others".to_owned()));
        }
        Ok(Self::of(&values))
    }

    /// The report of pixels, each of the picture and of both halves.
    fn of(pixels: &[[[f64; 3]; 3]]) -> Self {
        let count = pixels.len() as f64;
        let mean = |of: &dyn Fn(&[[f64; 3]; 3]) -> f64| pixels.iter().map(of).sum::<f64>() / count;
        let over = |of: &dyn Fn(f64, f64, f64) -> f64, [p, a, b]: &[[f64; 3]; 3]| {
            (0..3).map(|c| of(p[c], a[c], b[c])).sum::<f64>() / 3.0
        };
        let product = |pixel: &[[f64; 3]; 3]| over(&|p, a, b| (p - a) * (p - b), pixel);
        let (error, power) = (mean(&product), mean(&|pixel| over(&|_, a, b| a * b, pixel)));
        let spread = (mean(&|pixel| (product(pixel) - error).powi(2)) / count).sqrt();
        let noise = mean(&|pixel| over(&|_, a, b| 0.25 * (a - b) * (a - b), pixel));
        let reference = mean(&|pixel| over(&|_, a, b| 0.5 * (a + b), pixel));
        let error = error.max(0.0);
        let relative = |square: f64| if square == 0.0 { 0.0 } else { (square / power.max(0.0)).sqrt() };
        let is_dark = |[p, a, b]: &[[f64; 3]; 3]| {
            let largest = |of: &dyn Fn(usize) -> f64| (0..3).map(of).fold(f64::MIN, f64::max);
            let seen = largest(&|c| 0.5 * (a[c] + b[c]));
            seen > BRIGHT * reference && largest(&|c| p[c]) < DARK * seen
        };
        Self {
            pixels: pixels.len(),
            relative_rms: relative(error),
            uncertainty: relative(error + spread) - relative(error),
            mean_ratio: mean(&|pixel| over(&|p, _, _| p, pixel)) / reference,
            psnr: if error == 0.0 { f64::INFINITY } else { 20.0 * (peak(pixels) / error.sqrt()).log10() },
            noise: relative(noise),
            dark: mean(&|pixel| if is_dark(pixel) { 1.0 } else { 0.0 }),
        }
    }
}

/// The value of the reference that few exceed.
fn peak(pixels: &[[[f64; 3]; 3]]) -> f64 {
    let mut values: Vec<f64> = pixels.iter().flat_map(|[_, a, b]| (0..3).map(|c| 0.5 * (a[c] + b[c]))).collect();
    let place = ((values.len() - 1) as f64 * (1.0 - BRIGHTER_THAN_PEAK)).round() as usize;
    *values.select_nth_unstable_by(place, f64::total_cmp).1
}

#[cfg(test)]
mod tests {
    use lobe_testkit::Random;

    use super::*;
    use crate::pixel::Pixel;

    const COUNT: usize = 40_000;

    /// A reference between 0.5 and 1.5, a picture that is off by ±`error`, and halves whose noise is 0.3.
    fn noisy(error: f64) -> (Vec<Pixel>, [Vec<Pixel>; 2]) {
        let mut random = Random::new(7);
        let mut noise = move || 0.3 * 12.0_f64.sqrt() * (random.unit() - 0.5);
        let truth = |i: usize| 0.5 + i as f64 / COUNT as f64;
        let picture =
            (0..COUNT).map(|i| [truth(i) + if i % 2 == 0 { error } else { -error }; 3].map(|c| c as f32)).collect();
        let mut half = || (0..COUNT).map(|i| [0; 3].map(|_| (truth(i) + noise()) as f32)).collect();
        (picture, [half(), half()])
    }

    #[test]
    fn the_error_is_found_under_noise_that_is_larger_than_it() {
        let power = 1.0 + 1.0 / 12.0;
        for error in [0.0, 0.05, 0.2] {
            let (picture, [a, b]) = noisy(error);
            let report = HalvesReport::new(&picture, [&a, &b], |_| true).unwrap();
            let expected = error / f64::sqrt(power);
            // Three standard errors.
            let slack = 3.0 * report.uncertainty;
            assert!((report.relative_rms - expected).abs() < slack, "error {error}: {report:?}, expected {expected}");
            assert!(error == 0.0 || report.uncertainty < 0.02, "error {error}: {report:?} is certain");
            assert!((report.mean_ratio - 1.0).abs() < 0.01, "error {error}: {report:?}");
            let noise = 0.3 / f64::sqrt(2.0 * power);
            assert!((report.noise / noise - 1.0).abs() < 0.02, "error {error}: {report:?}, expected noise {noise}");
        }
    }

    #[test]
    fn the_numbers_are_those_of_a_hand_computed_case() {
        let gray = |values: [f32; 4]| values.map(|value| [value; 3]);
        let (p, a, b) = (gray([1.0, 2.0, 0.05, 9.0]), gray([2.0, 2.0, 1.0, 5.0]), gray([2.0, 2.0, 1.0, 5.0]));
        let report = HalvesReport::new(&p, [&a, &b], |i| i < 3).unwrap();
        let (error, power) = ((1.0 + (1.0 - f64::from(0.05_f32)).powi(2)) / 3.0, 3.0);
        assert_eq!(report.pixels, 3, "the last one does not count");
        assert!((report.relative_rms - f64::sqrt(error / power)).abs() < 1e-8, "{report:?}");
        assert!((report.mean_ratio - 3.05 / 5.0).abs() < 1e-8, "{report:?}");
        assert!((report.psnr - 10.0 * (4.0 / error).log10()).abs() < 1e-8, "{report:?}");
        assert_eq!((report.noise, report.dark), (0.0, 1.0 / 3.0), "no noise, one dark pixel of three");
        let same = HalvesReport::new(&a, [&a, &b], |_| true).unwrap();
        assert_eq!((same.relative_rms, same.psnr, same.dark), (0.0, f64::INFINITY, 0.0), "equal pictures");
    }

    #[test]
    fn what_cannot_be_compared_is_refused() {
        let pixels = [[1.0_f32; 3]; 4];
        let refusal = |picture: &[Pixel], counts: bool| {
            HalvesReport::new(picture, [&pixels, &pixels], |_| counts).unwrap_err().to_string()
        };
        let expected = "expected halves of 3 pixels, as the picture has, found 4 and 4";
        assert_eq!(refusal(&pixels[..3], true), expected, "another length");
        assert_eq!(refusal(&pixels, false), "expected pixels that show surfaces, found none", "no surface");
        assert_eq!(refusal(&[[f32::NAN; 3]; 4], true), "expected finite values, found others", "no number");
    }
}
