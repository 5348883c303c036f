//! FLIP metric: the perceived difference of two pictures that alternate on a display.

use std::f64::consts::PI;

use lobe_io::parallel;

use crate::error::ImageError;
use crate::picture::colormap::sequential;
use crate::picture::picture::Picture;

type Vec3 = [f64; 3];

/// The result of FLIP, the perceived difference of two pictures: 0 where they look alike, 1 for the largest difference.
///
/// The pictures alternate on a display, seen at a given number of pixels per degree of visual angle. The error of each
/// pixel is
///
/// ```text
///   ΔE = ΔE_c^(1 - ΔE_f)
/// ```
///
/// `ΔE_c` compares colors after the contrast sensitivity of the eye has blurred them (`HyAB` distance in L*a*b* with
/// Hunt's adjustment), `ΔE_f` edges and points of the luminance ([Andersson et al. 2020]).
///
/// [Andersson et al. 2020]: https://research.nvidia.com/publication/2020-07_FLIP
#[derive(Clone, Debug, PartialEq)]
pub struct Flip {
    width: usize,
    height: usize,
    errors: Vec<f64>,
}

/// A display 0.7 m wide with 3840 pixels, seen from 0.7 m: the paper's default, in pixels per degree.
pub const FLIP_PIXELS_PER_DEGREE: f64 = 3840.0 * PI / 180.0;

/// The range of pixels per degree: at one pixel per degree a picture has no detail left to blur, and at 1000 the
/// filters are some hundred pixels wide. Our choice.
const PIXELS_PER_DEGREE: std::ops::RangeInclusive<f64> = 1.0..=1000.0;

/// The paper's exponent `q_c` of color differences.
const COLOR_EXPONENT: f64 = 0.7;

/// The paper's `p_c` and `p_t`: differences below this fraction of the largest one fill this fraction of the scale.
const KNEE: (f64, f64) = (0.4, 0.95);

/// The paper's `w`: the width in degrees of the features to which the eye is most sensitive.
const FEATURE_WIDTH: f64 = 0.082;

/// The standard deviation of the paper's feature filters, relative to that width.
const SIGMA_OF_FEATURE: f64 = 0.5;

/// The paper's exponent `q_f` of feature differences.
const FEATURE_EXPONENT: f64 = 0.5;

/// The paper's bound of the difference of two features: each is the length of two filters' results of at most 1.
const MOST_FEATURE: f64 = std::f64::consts::SQRT_2;

/// The radius of the paper's filters, blurs and features alike, in standard deviations.
const REACH: f64 = 3.0;

/// Contrast sensitivity as a point spread function, `Σ a √(π/b) exp(-π² d²/b)`, `d` in degrees: `(a, b)` for luminance,
/// red-green and blue-yellow (the paper's table 1).
const SENSITIVITIES: [&[(f64, f64)]; 3] = [&[(1.0, 0.0047)], &[(1.0, 0.0053)], &[(34.1, 0.04), (13.5, 0.025)]];

/// The largest `b` of [`SENSITIVITIES`], which determines the radius of all filters.
const WIDEST: f64 = 0.04;

/// The paper's form of Hunt's effect: chroma is scaled by this for each unit of lightness, thus by 1 at white (100).
const HUNT: f64 = 0.01;

/// The pair of display colors with the paper's largest color difference.
const MOST_DIFFERENT: [Vec3; 2] = [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// L*a*b* of CIE 1976, with roots of X, Y and Z relative to white:
/// `L* = 116 Y - 16`, `a* = 500 (X - Y)`, `b* = 200 (Y - Z)`.
const LIGHTNESS: (f64, f64) = (116.0, 16.0);
const RED_GREEN: f64 = 500.0;
const BLUE_YELLOW: f64 = 200.0;

/// CIE 1976 replaces the cube root by a line below the cube of this.
const LINE_BELOW: f64 = 6.0 / 29.0;

/// XYZ of linear Rec. 709 colors, as ratios that follow from the primaries and D65 at (0.31271, 0.32902).
const XYZ_FROM_RGB: [Vec3; 3] = [
    [10135552.0 / 24577794.0, 8788810.0 / 24577794.0, 4435075.0 / 24577794.0],
    [2613072.0 / 12288897.0, 8788810.0 / 12288897.0, 887015.0 / 12288897.0],
    [1425312.0 / 73733382.0, 8788810.0 / 73733382.0, 70074185.0 / 73733382.0],
];

/// Compares a picture with its reference as displayed: linear light, clamped to `[0, 1]`.
///
/// # Errors
/// [`ImageError::Options`] if the two differ in size or have no pixels, or `pixels_per_degree` is not 1 to 1000.
pub fn flip(image: &Picture, reference: &Picture, pixels_per_degree: f64) -> Result<Flip, ImageError> {
    check(image, reference, pixels_per_degree)?;
    let shown = |p: &Picture| -> Vec<Vec3> {
        let clamped = |c: f64| if c.is_nan() { 0.0 } else { c.clamp(0.0, 1.0) };
        p.pixels().iter().map(|c| c.map(f64::from).map(clamped)).collect()
    };
    let width = image.width();
    let eye = Eye::new(width, pixels_per_degree);
    let (a, b) = (eye.look(&shown(image)), eye.look(&shown(reference)));
    let error = |i: usize| {
        let color = eye.color_error(a.colors[i], b.colors[i]);
        let [edges, points] = [0, 1].map(|k| (a.features[k][i] - b.features[k][i]).abs());
        let feature = (edges.max(points) / MOST_FEATURE).min(1.0).powf(FEATURE_EXPONENT);
        color.powf(1.0 - feature)
    };
    let mut errors = vec![0.0; a.colors.len()];
    parallel::fill(&mut errors, width, &error);
    Ok(Flip { width, height: image.height(), errors })
}

/// Refuses pictures of different or empty size, and a resolution out of range.
pub(crate) fn check(image: &Picture, reference: &Picture, pixels_per_degree: f64) -> Result<(), ImageError> {
    let ((w, h), (v, g)) = ((image.width(), image.height()), (reference.width(), reference.height()));
    if (w, h) != (v, g) {
        return Err(ImageError::Options(format!("cannot compare a {w} x {h} picture with one of {v} x {g}")));
    }
    if w == 0 || h == 0 {
        return Err(ImageError::Options(format!("pictures of {w} x {h} have no pixels to compare")));
    }
    if !PIXELS_PER_DEGREE.contains(&pixels_per_degree) {
        let (least, most) = (PIXELS_PER_DEGREE.start(), PIXELS_PER_DEGREE.end());
        let message = format!("expected {least} to {most} pixels per degree, found {pixels_per_degree}");
        return Err(ImageError::Options(message));
    }
    Ok(())
}

impl Flip {
    /// The errors of all pixels, row by row, each from 0 to 1.
    #[must_use]
    pub fn errors(&self) -> &[f64] {
        &self.errors
    }

    /// The mean over all pixels.
    #[must_use]
    pub fn mean(&self) -> f64 {
        self.errors.iter().sum::<f64>() / self.errors.len() as f64
    }

    /// The errors in the colors of [`sequential`]: black for none, white for 1.
    #[must_use]
    pub fn picture(&self) -> Picture {
        Picture::from_fn(self.width, self.height, |x, y| sequential(self.errors[y * self.width + x]))
    }

    /// Replaces every error by the larger one of both.
    pub(crate) fn raise(&mut self, other: &Self) {
        for (error, other) in self.errors.iter_mut().zip(&other.errors) {
            *error = error.max(*other);
        }
    }
}

/// The perceptual representation of a picture.
struct Look {
    /// In L*a*b* with Hunt's adjustment, blurred.
    colors: Vec<Vec3>,
    /// Strength of edges and of points.
    features: [Vec<f64>; 2],
}

/// The filters for a viewing distance.
struct Eye {
    width: usize,
    /// For each opponent channel, kernels along one axis with their weights.
    blurs: [Vec<(f64, Vec<f64>)>; 3],
    /// A Gaussian of sum 1, its derivative and its second derivative, whose positive and negative parts sum to 1 and
    /// -1.
    bell: Vec<f64>,
    slope: Vec<f64>,
    bend: Vec<f64>,
    /// XYZ of white.
    white: Vec3,
    rgb_from_xyz: [Vec3; 3],
    largest: f64,
}

impl Eye {
    fn new(width: usize, pixels_per_degree: f64) -> Self {
        // exp(-π² d²/b) is a Gaussian of the standard deviation √(b/2)/π.
        let reach = (REACH * (WIDEST / (2.0 * PI * PI)).sqrt() * pixels_per_degree).ceil() as i32;
        let blurs = SENSITIVITIES.map(|terms| blur(terms, reach, pixels_per_degree));
        let sigma = SIGMA_OF_FEATURE * FEATURE_WIDTH * pixels_per_degree;
        let reach = (REACH * sigma).ceil() as i32;
        let kernel = |f: &dyn Fn(f64) -> f64| -> Vec<f64> {
            let values: Vec<f64> = (-reach..=reach).map(|i| f(f64::from(i) / sigma)).collect();
            let part = |sign: f64| values.iter().map(|v| (sign * v).max(0.0)).sum::<f64>();
            let (up, down) = (part(1.0), part(-1.0));
            values.iter().map(|&v| if v > 0.0 { v / up } else { v / down.max(f64::MIN_POSITIVE) }).collect()
        };
        let bell = |x: f64| (-0.5 * x * x).exp();
        let mut eye = Self {
            width,
            blurs,
            bell: kernel(&bell),
            slope: kernel(&|x| -x * bell(x)),
            bend: kernel(&|x| (x * x - 1.0) * bell(x)),
            white: XYZ_FROM_RGB.map(|row| row.iter().sum()),
            rgb_from_xyz: inverse(XYZ_FROM_RGB),
            largest: 1.0,
        };
        let [a, b] = MOST_DIFFERENT.map(|c| eye.adjusted_lab(c));
        eye.largest = hyab(a, b).powf(COLOR_EXPONENT);
        eye
    }

    fn look(&self, rgb: &[Vec3]) -> Look {
        let width = self.width;
        let mut opponent = vec![[0.0; 3]; rgb.len()];
        parallel::rows(&mut opponent, width, &|y, row| {
            row.iter_mut().zip(&rgb[y * width..]).for_each(|(out, c)| *out = self.opponent(*c));
        });
        let plane = |k: usize| -> Vec<f64> { opponent.iter().map(|c| c[k]).collect() };
        let blurred = [0, 1, 2].map(|k| {
            let (source, mut sum) = (plane(k), vec![0.0; rgb.len()]);
            for (weight, kernel) in &self.blurs[k] {
                let part = self.filtered(&source, kernel, kernel);
                sum.iter_mut().zip(&part).for_each(|(sum, part)| *sum += weight * part);
            }
            sum
        });
        let color = |i: usize| {
            let seen = self.rgb_of_opponent([blurred[0][i], blurred[1][i], blurred[2][i]]);
            self.adjusted_lab(seen.map(|c| c.clamp(0.0, 1.0)))
        };
        let mut colors = vec![[0.0; 3]; rgb.len()];
        parallel::fill(&mut colors, width, &color);
        let luminance: Vec<f64> = opponent.iter().map(|c| (c[0] + LIGHTNESS.1) / LIGHTNESS.0).collect();
        let features = [&self.slope, &self.bend].map(|kernel| {
            let across = self.filtered(&luminance, kernel, &self.bell);
            let down = self.filtered(&luminance, &self.bell, kernel);
            across.iter().zip(&down).map(|(a, d)| a.hypot(*d)).collect()
        });
        Look { colors, features }
    }

    /// The difference of two blurred colors, compressed to 0 to 1.
    fn color_error(&self, a: Vec3, b: Vec3) -> f64 {
        let difference = hyab(a, b).powf(COLOR_EXPONENT);
        let knee = KNEE.0 * self.largest;
        if difference < knee {
            return KNEE.1 / knee * difference;
        }
        (KNEE.1 + (difference - knee) / (self.largest - knee) * (1.0 - KNEE.1)).min(1.0)
    }

    /// Linear `Y C_x C_z` of the paper: L*a*b* without its roots.
    fn opponent(&self, rgb: Vec3) -> Vec3 {
        lab(self.relative_xyz(rgb))
    }

    fn rgb_of_opponent(&self, [y, cx, cz]: Vec3) -> Vec3 {
        let y = (y + LIGHTNESS.1) / LIGHTNESS.0;
        let xyz = [y + cx / RED_GREEN, y, y - cz / BLUE_YELLOW];
        times(self.rgb_from_xyz, std::array::from_fn(|k| xyz[k] * self.white[k]))
    }

    /// L*a*b* with `a` and `b` scaled by the lightness: dark colors look less colorful (Hunt).
    fn adjusted_lab(&self, rgb: Vec3) -> Vec3 {
        let [l, a, b] = lab(self.relative_xyz(rgb).map(root));
        [l, HUNT * l * a, HUNT * l * b]
    }

    fn relative_xyz(&self, rgb: Vec3) -> Vec3 {
        let xyz = times(XYZ_FROM_RGB, rgb);
        std::array::from_fn(|k| xyz[k] / self.white[k])
    }

    /// Filters along rows and columns; the picture is extended by its outermost pixels.
    fn filtered(&self, plane: &[f64], across: &[f64], down: &[f64]) -> Vec<f64> {
        let (width, height) = (self.width, plane.len() / self.width);
        let at =
            |i: usize, k: usize, kernel: &[f64], count: usize| (i + k).saturating_sub(kernel.len() / 2).min(count - 1);
        let mut rows = vec![0.0; plane.len()];
        parallel::rows(&mut rows, width, &|y, row| {
            let source = &plane[y * width..][..width];
            for (x, out) in row.iter_mut().enumerate() {
                *out = across.iter().enumerate().map(|(k, weight)| weight * source[at(x, k, across, width)]).sum();
            }
        });
        let mut out = vec![0.0; plane.len()];
        parallel::rows(&mut out, width, &|y, row| {
            for (k, weight) in down.iter().enumerate() {
                let source = &rows[at(y, k, down, height) * width..][..width];
                row.iter_mut().zip(source).for_each(|(out, value)| *out += weight * value);
            }
        });
        out
    }
}

/// The kernels along one axis of a point spread function, and the weights of their products; it sums to 1.
fn blur(terms: &[(f64, f64)], reach: i32, pixels_per_degree: f64) -> Vec<(f64, Vec<f64>)> {
    let kernel = |b: f64| -> Vec<f64> {
        (-reach..=reach).map(|i| (-(PI * f64::from(i) / pixels_per_degree).powi(2) / b).exp()).collect()
    };
    let parts: Vec<(f64, Vec<f64>)> = terms.iter().map(|&(a, b)| (a * (PI / b).sqrt(), kernel(b))).collect();
    let whole: f64 = parts.iter().map(|(weight, k)| weight * k.iter().sum::<f64>().powi(2)).sum();
    parts.into_iter().map(|(weight, k)| (weight / whole, k)).collect()
}

/// The `HyAB` distance for large color differences: city block in lightness, Euclidean in chroma.
fn hyab(a: Vec3, b: Vec3) -> f64 {
    (a[0] - b[0]).abs() + (a[1] - b[1]).hypot(a[2] - b[2])
}

/// L*a*b*: lightness and two color differences.
fn lab([x, y, z]: Vec3) -> Vec3 {
    [LIGHTNESS.0 * y - LIGHTNESS.1, RED_GREEN * (x - y), BLUE_YELLOW * (y - z)]
}

/// The cube root, below [`LINE_BELOW`]³ its tangent there.
fn root(t: f64) -> f64 {
    const D: f64 = LINE_BELOW;
    // (t - D³) / (3 D²) + D
    if t > D * D * D { t.cbrt() } else { t / (3.0 * D * D) + 2.0 / 3.0 * D }
}

fn times(m: [Vec3; 3], v: Vec3) -> Vec3 {
    m.map(|row| dot(row, v))
}

fn dot(a: Vec3, b: Vec3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: Vec3, b: Vec3) -> Vec3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// The inverse of a matrix by its adjugate.
fn inverse(m: [Vec3; 3]) -> [Vec3; 3] {
    let columns = [cross(m[1], m[2]), cross(m[2], m[0]), cross(m[0], m[1])];
    let determinant = dot(m[0], columns[0]);
    std::array::from_fn(|i| std::array::from_fn(|j| columns[j][i] / determinant))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::srgb::srgb_decode;

    fn gray(value: f64) -> [f32; 3] {
        [value as f32; 3]
    }

    /// Two pictures by formula, given as display values: waves, and the same with ripples and a red rectangle.
    fn waves() -> [Picture; 2] {
        let reference = |x: f64, y: f64| {
            [0.5 + 0.5 * (0.31 * x + 0.17 * y).sin(), 0.5 + 0.4 * (0.23 * x - 0.4 * y).cos(), 0.3 + 0.01 * x]
        };
        let image = |x: f64, y: f64| {
            if (10.0..20.0).contains(&y) && (15.0..30.0).contains(&x) {
                return [0.9, 0.1, 0.2];
            }
            let ripple = [(1.3 * x * y / 20.0).sin(), (0.9 * y).cos(), (0.5 * x + 2.0 * y).sin()];
            let r = reference(x, y);
            std::array::from_fn(|k| (r[k] + 0.2 * ripple[k]).clamp(0.0, 1.0))
        };
        let picture = |f: &(dyn Fn(f64, f64) -> Vec3 + Sync)| {
            Picture::from_fn(48, 36, |x, y| f(x as f64, y as f64).map(|c| srgb_decode(c) as f32))
        };
        [picture(&reference), picture(&image)]
    }

    #[test]
    fn the_error_is_that_of_the_authors_program() {
        // Computed with the authors' program of version 1.7 (package flip-evaluator) on the same formula.
        let [reference, image] = waves();
        let found = flip(&image, &reference, FLIP_PIXELS_PER_DEGREE).unwrap();
        assert!((found.mean() - 0.444_415).abs() < 2e-6, "mean {}", found.mean());
        assert!((found.errors()[5 * 48 + 7] - 0.453_457).abs() < 5e-6, "waves: {}", found.errors()[5 * 48 + 7]);
        assert!((found.errors()[12 * 48 + 20] - 0.978_208).abs() < 5e-6, "red: {}", found.errors()[12 * 48 + 20]);
    }

    #[test]
    fn black_and_white_and_green_and_blue_are_as_different_as_the_authors_say() {
        let compare = |a: [f32; 3], b: [f32; 3]| {
            flip(&Picture::filled(16, 16, a), &Picture::filled(16, 16, b), FLIP_PIXELS_PER_DEGREE).unwrap().mean()
        };
        let black_white = compare(gray(0.0), gray(1.0));
        assert!((black_white - 0.967_385).abs() < 1e-5, "black and white: {black_white}");
        let green_blue = compare([0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
        assert!((green_blue - 1.0).abs() < 1e-6, "green and blue: {green_blue}");
    }

    #[test]
    fn equal_pictures_look_alike_and_larger_differences_look_larger() {
        let [reference, _] = waves();
        let mut before = -1e-12;
        for noise in [0.0, 0.001, 0.003, 0.01, 0.03, 0.1, 0.3] {
            let brighter = reference.map(|c| c.map(|c| c + noise as f32));
            let error = flip(&brighter, &reference, FLIP_PIXELS_PER_DEGREE).unwrap().mean();
            assert!(error > before && (noise > 0.0 || error == 0.0), "{noise}: {error} after {before}");
            before = error;
        }
    }

    #[test]
    fn xyz_follows_from_the_primaries_and_white() {
        // x/y, 1 and z/y of a color by its chromaticity.
        let of = |(x, y): (f64, f64)| [x / y, 1.0, (1.0 - x - y) / y];
        let primaries = [(0.64, 0.33), (0.30, 0.60), (0.15, 0.06)].map(of);
        let white = of((0.31271, 0.32902));
        let columns = std::array::from_fn(|row| primaries.map(|p| p[row]));
        let amounts = times(inverse(columns), white);
        for (row, found) in XYZ_FROM_RGB.iter().enumerate() {
            for (k, found) in found.iter().enumerate() {
                let expected = columns[row][k] * amounts[k];
                assert!((found - expected).abs() < 1e-14, "row {row}, column {k}: {found}, not {expected}");
            }
        }
    }

    #[test]
    fn the_cube_root_goes_on_as_its_tangent() {
        let (t, h) = (LINE_BELOW.powi(3), 1e-9);
        assert!((root(t) - LINE_BELOW).abs() < 1e-15, "value {}", root(t));
        let slopes = [(root(t) - root(t - h)) / h, (root(t + h) - root(t)) / h];
        // Of differences of 1e-9 the last seven digits are rounding.
        assert!((slopes[0] / slopes[1] - 1.0).abs() < 1e-5, "slopes {slopes:?}");
    }

    #[test]
    fn pictures_of_other_sizes_are_refused() {
        let error = flip(&Picture::filled(2, 1, gray(0.0)), &Picture::filled(1, 2, gray(0.0)), 67.0).unwrap_err();
        assert_eq!(error.to_string(), "cannot compare a 2 x 1 picture with one of 1 x 2", "size");
        let empty = Picture::filled(0, 0, gray(0.0));
        assert!(flip(&empty, &empty, 67.0).is_err(), "no pixels");
        let one = Picture::filled(1, 1, gray(0.0));
        assert!(flip(&one, &one, f64::NAN).is_err(), "no distance");
    }
}
