//! HDR-FLIP metric: the perceived difference of two HDR pictures over a series of exposures.

use crate::compare::flip::{Flip, check, flip};
use crate::error::ImageError;
use crate::picture::picture::Picture;
use crate::pixel::{luminance, widened};

/// The largest [`flip()`] error at each pixel over a series of exposures, from one where the brightest pixel of the
/// reference is not yet white to one where half of it is ([Andersson et al. 2021]).
///
/// ```text
///   c_start = log₂(x / max Y)      c_stop = log₂(x / median Y)      T(x) = 0.85
///   ⌈c_stop - c_start⌉ exposures, at least 2;  shown is T(2^c L)
/// ```
///
/// `T` is the curve of the Academy Color Encoding System as fitted by Narkowicz. Negative light is black. A black
/// reference is compared at exposure 1.
///
/// [Andersson et al. 2021]: https://research.nvidia.com/publication/2021-05_HDR-FLIP
///
/// # Errors
/// As [`flip()`].
pub fn hdr_flip(image: &Picture, reference: &Picture, pixels_per_degree: f64) -> Result<Flip, ImageError> {
    check(image, reference, pixels_per_degree)?;
    let mut worst: Option<Flip> = None;
    for exposure in exposures(reference) {
        let shown = |p: &Picture| p.map(|c| c.map(|c| tone(f64::from(c) * exposure) as f32));
        let errors = flip(&shown(image), &shown(reference), pixels_per_degree)?;
        match &mut worst {
            Some(worst) => worst.raise(&errors),
            None => worst = Some(errors),
        }
    }
    worst.ok_or_else(|| ImageError::Options("no exposure to compare at".to_owned()))
}

/// Numerator and denominator of the curve, from the square down, exposed by 0.6 as the paper has it.
const CURVE: [[f64; 3]; 2] = [[0.36 * 2.51, 0.6 * 0.03, 0.0], [0.36 * 2.43, 0.6 * 0.59, 0.14]];

/// The paper's `t`: the displayed level at the ends of the series.
const LEVEL: f64 = 0.85;

/// A bound for infinite and tiny luminances; no other picture needs as many.
const MOST_EXPOSURES: usize = 64;

/// The factors of the series.
fn exposures(reference: &Picture) -> Vec<f64> {
    let mut luminances: Vec<f64> =
        reference.pixels().iter().map(|c| luminance(widened(*c))).filter(|y| y.is_finite() && *y >= 0.0).collect();
    luminances.sort_by(f64::total_cmp);
    let Some(&most) = luminances.last().filter(|y| **y > 0.0) else { return vec![1.0] };
    // Where half of the picture is black, use the least positive luminance for the median.
    let median = luminances[luminances.len() / 2];
    let median = if median > 0.0 { median } else { luminances.iter().copied().find(|y| *y > 0.0).unwrap_or(most) };
    let (start, stop) = ((level_input() / most).log2(), (level_input() / median).log2());
    let count = ((stop - start).ceil() as usize).clamp(2, MOST_EXPOSURES);
    (0..count).map(|i| (start + (stop - start) * i as f64 / (count - 1) as f64).exp2()).collect()
}

/// The luminance that the curve maps to [`LEVEL`]: the larger root of a quadratic.
fn level_input() -> f64 {
    let [a, b, c] = std::array::from_fn(|k| CURVE[0][k] - LEVEL * CURVE[1][k]);
    (-b + (b * b - 4.0 * a * c).sqrt() * a.signum()) / (2.0 * a)
}

fn tone(light: f64) -> f64 {
    let x = if light.is_nan() { 0.0 } else { light.clamp(0.0, 1e12) };
    let [above, below] = CURVE.map(|k| (k[0] * x + k[1]) * x + k[2]);
    (above / below).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::flip::FLIP_PIXELS_PER_DEGREE;
    use crate::pixel::{narrowed, scaled};

    #[test]
    fn the_error_is_that_of_the_authors_program() {
        // Computed with the authors' program of version 1.7 (package flip-evaluator) on the same formula.
        let light = |x: f64, y: f64| {
            let common = 2.0 * (0.15 * y).cos();
            [1.0, 0.9, 0.8].map(|k| (3.0 * (0.2 * x).sin() * k + common).exp())
        };
        let reference = Picture::from_fn(48, 36, |x, y| narrowed(light(x as f64, y as f64)));
        let image = Picture::from_fn(48, 36, |x, y| {
            let (x, y) = (x as f64, y as f64);
            narrowed(scaled(light(x, y), 1.0 + 0.3 * (1.1 * x + 0.7 * y).sin()))
        });
        assert_eq!(exposures(&reference).len(), 7, "exposures");
        let found = hdr_flip(&image, &reference, FLIP_PIXELS_PER_DEGREE).unwrap().mean();
        assert!((found - 0.121_076).abs() < 2e-5, "mean {found}");
    }

    #[test]
    fn the_curve_shows_the_level_where_it_should() {
        assert!((tone(level_input()) - LEVEL).abs() < 1e-12, "{}", tone(level_input()));
        assert!((level_input() - 2.118_872).abs() < 1e-6, "{}", level_input());
        assert_eq!([tone(f64::NAN), tone(-1.0), tone(f64::INFINITY)], [0.0, 0.0, 1.0], "no light, and too much");
    }

    #[test]
    fn black_references_are_compared() {
        let black = Picture::filled(4, 4, [0.0; 3]);
        assert_eq!(hdr_flip(&black, &black, 67.0).unwrap().mean(), 0.0, "equal");
        assert!(hdr_flip(&Picture::filled(4, 4, [1.0; 3]), &black, 67.0).unwrap().mean() > 0.5, "white");
    }
}
