//! Tone mapping: from linear light to 8-bit display values.

use lobe_io::parallel;

use crate::picture::picture::Picture;
use crate::picture::srgb::srgb_encode;
use crate::picture::tone_curve::Curve;
use crate::pixel::{luminance, narrowed, scaled, widened};

/// Pixels whose bytes a thread finds at a time; one takes some tens of nanoseconds.
const TOGETHER: usize = 1 << 10;

/// The exposure applied to a picture before display.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Exposure {
    /// Multiply by this.
    Fixed(f64),
    /// Bring the log-average luminance `exp(mean(ln Y))` to `key`; 0.18 is the middle gray of photography.
    ///
    /// Pixels that are black, negative or not finite are left out of the average. (Reinhard et al. 2002 add a small
    /// constant to every luminance instead, which makes the result depend on the unit of the light.)
    LogAverage {
        /// The target log-average.
        key: f64,
    },
    /// Bring a percentile of the luminance to `level`.
    ///
    /// Pixels that are black, negative or not finite do not count.
    Percentile {
        /// The percentile, from 0 to 1.
        fraction: f64,
        /// The target luminance.
        level: f64,
    },
}

/// A tone mapping: exposure, curve, sRGB transfer function, 8 bits.
///
/// ```text
///   byte = round(255 srgb(curve(exposure × L)))
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Tone {
    /// The exposure.
    pub exposure: Exposure,
    /// The curve.
    pub curve: Curve,
}

impl Tone {
    /// For pictures that are already display-referred: exposure 1, clamped to 1.
    pub const PLAIN: Self = Self { exposure: Exposure::Fixed(1.0), curve: Curve::Clip };

    /// For photographs: middle gray at 0.18, highlights compressed up to 4 times white.
    pub const PHOTOGRAPH: Self = Self { exposure: Exposure::LogAverage { key: 0.18 }, curve: Curve::REINHARD };

    /// For lit objects, whose shading should not be compressed: one pixel in a hundred is brighter than 0.9.
    pub const OBJECT: Self = Self { exposure: Exposure::Percentile { fraction: 0.99, level: 0.9 }, curve: Curve::Clip };

    /// This tone mapping with its exposure fixed to that of `picture`, to show other pictures alike.
    #[must_use]
    pub fn fixed_for(&self, picture: &Picture) -> Self {
        Self { exposure: Exposure::Fixed(self.exposure.factor(picture)), ..*self }
    }

    /// The display light in `[0, 1]`, still linear.
    #[must_use]
    pub fn apply(&self, picture: &Picture) -> Picture {
        let factor = self.exposure.factor(picture);
        picture.map(|c| narrowed(self.curve.apply(scaled(widened(c), factor))))
    }

    /// The display bytes, three for each pixel; an alpha is left out, so that what is covered in part is shown before
    /// black.
    #[must_use]
    pub fn to_bytes(&self, picture: &Picture) -> Vec<u8> {
        let factor = self.exposure.factor(picture);
        self.bytes_of(picture, &|k| self.curve.apply(scaled(widened(picture.pixels()[k]), factor)).map(byte))
    }

    /// The display bytes with alpha, four for each pixel, as PNG has them: the color is that of what covers the pixel
    /// (straight, or not associated), and the alpha is linear.
    ///
    /// ```text
    ///   byte = round(255 srgb(curve(exposure × L/α)))        alpha = round(255 α)
    /// ```
    ///
    /// Where α is 0 the color is black. A picture without an alpha is opaque.
    #[must_use]
    pub fn to_rgba_bytes(&self, picture: &Picture) -> Vec<u8> {
        let factor = self.exposure.factor(picture);
        self.bytes_of(picture, &|k| {
            let alpha = picture.alpha().map_or(1.0, |alpha| f64::from(alpha[k]).clamp(0.0, 1.0));
            if alpha == 0.0 {
                return [0; 4];
            }
            let light = scaled(widened(picture.pixels()[k]), factor / alpha);
            let [r, g, b] = self.curve.apply(light).map(byte);
            [r, g, b, (255.0 * alpha).round() as u8]
        })
    }

    /// The bytes of all pixels, each by its number.
    fn bytes_of<const N: usize>(&self, picture: &Picture, shown: &(dyn Fn(usize) -> [u8; N] + Sync)) -> Vec<u8> {
        let mut bytes = vec![[0; N]; picture.pixels().len()];
        parallel::rows(&mut bytes, TOGETHER, &|k, bytes| {
            bytes.iter_mut().enumerate().for_each(|(i, bytes)| *bytes = shown(k * TOGETHER + i));
        });
        bytes.into_flattened()
    }
}

/// The nearest of 256 levels; NaN is black.
fn byte(linear: f64) -> u8 {
    (255.0 * srgb_encode(linear)).round() as u8
}

impl Exposure {
    /// The factor for `picture`; 1 where no pixel counts.
    #[must_use]
    pub fn factor(&self, picture: &Picture) -> f64 {
        if let Self::Fixed(factor) = *self {
            return factor;
        }
        let mut luminances: Vec<f64> =
            picture.pixels().iter().map(|c| luminance(widened(*c))).filter(|y| y.is_finite() && *y > 0.0).collect();
        if luminances.is_empty() {
            return 1.0;
        }
        match *self {
            Self::Fixed(factor) => factor,
            Self::LogAverage { key } => {
                let sum: f64 = luminances.iter().map(|y| y.ln()).sum();
                key / (sum / luminances.len() as f64).exp()
            }
            Self::Percentile { fraction, level } => {
                let rank = (fraction.clamp(0.0, 1.0) * (luminances.len() - 1) as f64).round() as usize;
                let (_, y, _) = luminances.select_nth_unstable_by(rank, f64::total_cmp);
                level / *y
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gray(values: &[f32]) -> Picture {
        Picture::new(values.len(), 1, values.iter().map(|&v| [v; 3]).collect::<Vec<_>>()).unwrap()
    }

    #[test]
    fn the_log_average_is_brought_to_the_key() {
        let picture = gray(&[0.01, 1.0, 100.0, 0.0, -5.0, f32::INFINITY]);
        let factor = Exposure::LogAverage { key: 0.18 }.factor(&picture);
        assert!((factor - 0.18).abs() < 1e-7, "the geometric mean of 0.01, 1 and 100 is 1: {factor}");
    }

    #[test]
    fn the_percentile_is_brought_to_its_level() {
        let picture = gray(&(1..=101).map(|v| v as f32).collect::<Vec<_>>());
        let factor = Exposure::Percentile { fraction: 0.9, level: 0.5 }.factor(&picture);
        assert!((factor - 0.5 / 91.0).abs() < 1e-9, "90 of 101 values lie below 91: {factor}");
    }

    #[test]
    fn a_black_picture_is_shown_as_it_is() {
        assert_eq!(Exposure::LogAverage { key: 0.18 }.factor(&gray(&[0.0, 0.0])), 1.0, "nothing to judge by");
    }

    #[test]
    fn the_curve_sends_white_to_one_and_keeps_chromaticity() {
        let curve = Curve::Reinhard { white: 4.0 };
        let white = curve.apply([4.0; 3]);
        assert!((white[1] - 1.0).abs() < 1e-12, "{white:?}");
        let orange = curve.apply([0.8, 0.4, 0.2]);
        assert!(
            (orange[0] / orange[1] - 2.0).abs() < 1e-12 && (orange[1] / orange[2] - 2.0).abs() < 1e-12,
            "{orange:?}"
        );
        assert_eq!(curve.apply([-1.0; 3]), [0.0; 3], "negative light is black");
    }

    #[test]
    fn infinite_light_is_white_and_not_black() {
        for tone in [Tone::PLAIN, Tone::PHOTOGRAPH, Tone::OBJECT] {
            let bytes = tone.to_bytes(&gray(&[0.1, f32::INFINITY, 0.2]));
            assert_eq!(bytes[3..6], [255; 3], "{tone:?}: {bytes:?}");
        }
    }

    #[test]
    fn a_pixel_that_is_covered_in_part_has_the_color_of_what_covers_it() {
        let covered = [1.0, 0.5, 0.25, 0.0];
        let picture = gray(&covered.map(|alpha| 0.215861 * alpha)).with_alpha(covered.to_vec()).unwrap();
        let bytes = Tone::PLAIN.to_rgba_bytes(&picture);
        let expected = [[128, 128, 128, 255], [128, 128, 128, 128], [128, 128, 128, 64], [0; 4]];
        assert_eq!(bytes, expected.as_flattened(), "{bytes:?}");
        let opaque = Tone::PLAIN.to_rgba_bytes(&gray(&[1.0]));
        assert_eq!(opaque, [255; 4], "without an alpha: {opaque:?}");
    }

    #[test]
    fn bytes_are_exact_srgb() {
        let picture = gray(&[0.0, 0.0031308, 0.215861, 1.0, 7.0, f32::NAN]);
        let bytes = Tone::PLAIN.to_bytes(&picture);
        assert_eq!(bytes.iter().step_by(3).copied().collect::<Vec<_>>(), [0, 10, 128, 255, 255, 0], "{bytes:?}");
    }
}
