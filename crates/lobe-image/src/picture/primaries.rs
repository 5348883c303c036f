//! Primaries of a color space, and the change to those of Rec. 709.
//!
//! ```text
//!   N = [x/y, 1, (1-x-y)/y] of red, green and blue as columns      the primaries, of luminance 1
//!   M = N diag(N⁻¹ w)                                              XYZ of a color; w is XYZ of the white
//!   A = B⁻¹ diag(B w₇₀₉ / B w) B                                   Bradford's adaptation of one white to the other
//!   color in Rec. 709 = M₇₀₉⁻¹ A M color                           white stays white
//! ```
//!
//! `M` and the product of two of them are those of [SMPTE 1993], §3.3 and §4. `B` is the linear form of the transform that
//! [Lam 1985] found by experiment, with the digits of [Finlayson and Süsstrunk 2000]; the ICC's profiles adapt by the same.

use lobe_io::parallel;

use crate::pixel::Pixel;

pub(crate) type Matrix = [[f64; 3]; 3];

/// Bradford's matrix: XYZ to the responses that are scaled from white to white.
const BRADFORD: Matrix = [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]];

/// Chromaticities that differ by less are the same: files round to three digits.
const SAME: f64 = 2e-3;

/// Primaries that span less than this, of 0.11 of Rec. 709, lie on a line.
const LEAST_AREA: f64 = 1e-4;

/// Texels that a thread converts at a time; one takes some nanoseconds.
const TOGETHER: usize = 1 << 12;

/// The chromaticities `(x, y)` of red, green, blue and white.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Primaries {
    colors: [[f64; 2]; 3],
    white: [f64; 2],
}

impl Primaries {
    /// Those of Rec. 709 and sRGB [ITU 2015], table 1; the white is D65.
    pub(crate) const REC_709: Self =
        Self { colors: [[0.64, 0.33], [0.30, 0.60], [0.15, 0.06]], white: [0.3127, 0.3290] };

    /// Those of Radiance where a picture names no others; the white has equal energy at all wavelengths.
    pub(crate) const RADIANCE: Self =
        Self { colors: [[0.640, 0.330], [0.290, 0.600], [0.150, 0.060]], white: [1.0 / 3.0, 1.0 / 3.0] };

    /// Primaries with the white; none if they are no numbers, lie on a line, or one has no luminance.
    pub(crate) fn new(red: [f64; 2], green: [f64; 2], blue: [f64; 2], white: [f64; 2]) -> Option<Self> {
        let [a, b] = [[green[0] - red[0], green[1] - red[1]], [blue[0] - red[0], blue[1] - red[1]]];
        let spans = (a[0] * b[1] - a[1] * b[0]).abs() > LEAST_AREA;
        let is_usable = |[x, y]: &[f64; 2]| x.is_finite() && y.is_finite() && y.abs() > LEAST_AREA;
        let colors = [red, green, blue];
        (spans && colors.iter().chain([&white]).all(is_usable)).then_some(Self { colors, white })
    }

    /// Those of a color profile: XYZ of red, green and blue, which are adapted to the white D50 there by Bradford's matrix.
    pub(crate) fn of_profile(colors: [[f64; 3]; 3]) -> Option<Self> {
        // The white of profiles, ICC.1:2022, 7.2.16.
        const D50: [f64; 3] = [0.9642, 1.0, 0.8249];
        let to_d65 = adaptation(D50, xyz_of(Self::REC_709.white));
        let chromaticity = |color: [f64; 3]| {
            let [x, y, z] = transformed(&to_d65, color);
            [x / (x + y + z), y / (x + y + z)]
        };
        let [red, green, blue] = colors.map(chromaticity);
        Self::new(red, green, blue, Self::REC_709.white)
    }

    /// Whether these are the primaries of Rec. 709, to the digits found in files.
    pub(crate) fn are_rec_709(&self) -> bool {
        let same = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).abs() < SAME && (a[1] - b[1]).abs() < SAME;
        same(self.white, Self::REC_709.white) && (0..3).all(|k| same(self.colors[k], Self::REC_709.colors[k]))
    }

    /// XYZ of a color.
    fn xyz(&self) -> Matrix {
        let columns = transposed(self.colors.map(xyz_of));
        let scale = transformed(&inverse(&columns), xyz_of(self.white));
        columns.map(|row| [0, 1, 2].map(|k| row[k] * scale[k]))
    }

    /// The color in these primaries of one in XYZ.
    pub(crate) fn of_xyz(&self) -> Matrix {
        inverse(&self.xyz())
    }

    /// The color in Rec. 709 of a color in these primaries, the white adapted.
    pub(crate) fn to_rec_709(self) -> Matrix {
        let adapted = adaptation(xyz_of(self.white), xyz_of(Self::REC_709.white));
        product(&inverse(&Self::REC_709.xyz()), &product(&adapted, &self.xyz()))
    }

    /// Converts texels to Rec. 709; colors outside of its gamut get negative channels.
    pub(crate) fn convert(self, texels: &mut [Pixel]) {
        let matrix = self.to_rec_709();
        parallel::rows(texels, TOGETHER, &|_, texels| {
            for texel in texels {
                *texel = transformed(&matrix, texel.map(f64::from)).map(|c| c as f32);
            }
        });
    }
}

/// Bradford's adaptation of XYZ from one white to another.
fn adaptation(from: [f64; 3], to: [f64; 3]) -> Matrix {
    let [from, to] = [from, to].map(|white| transformed(&BRADFORD, white));
    let scaled = [0, 1, 2].map(|k| BRADFORD[k].map(|c| c * to[k] / from[k]));
    product(&inverse(&BRADFORD), &scaled)
}

/// XYZ of a chromaticity at luminance 1.
fn xyz_of([x, y]: [f64; 2]) -> [f64; 3] {
    [x / y, 1.0, (1.0 - x - y) / y]
}

pub(crate) fn transformed(matrix: &Matrix, v: [f64; 3]) -> [f64; 3] {
    matrix.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

fn transposed(m: Matrix) -> Matrix {
    [0, 1, 2].map(|row| m.map(|column| column[row]))
}

fn product(a: &Matrix, b: &Matrix) -> Matrix {
    transposed(transposed(*b).map(|column| transformed(a, column)))
}

/// The inverse, by the cross products of the rows.
pub(crate) fn inverse(m: &Matrix) -> Matrix {
    let cross =
        |a: [f64; 3], b: [f64; 3]| [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    let columns = [cross(m[1], m[2]), cross(m[2], m[0]), cross(m[0], m[1])];
    let determinant: f64 = m[0].iter().zip(columns[0]).map(|(a, b)| a * b).sum();
    transposed(columns.map(|column| column.map(|c| c / determinant)))
}

#[cfg(test)]
mod tests {
    use super::*;

    const REC_2020: [[f64; 2]; 4] = [[0.708, 0.292], [0.170, 0.797], [0.131, 0.046], [0.3127, 0.3290]];
    const ACES_2065: [[f64; 2]; 4] = [[0.7347, 0.2653], [0.0, 1.0], [0.0001, -0.0770], [0.32168, 0.33767]];

    fn of([red, green, blue, white]: [[f64; 2]; 4]) -> Primaries {
        Primaries::new(red, green, blue, white).unwrap()
    }

    fn assert_near(found: Matrix, expected: Matrix, tolerance: f64, what: &str) {
        for (found, expected) in found.as_flattened().iter().zip(expected.as_flattened()) {
            assert!((found - expected).abs() < tolerance, "{what}: {found} for {expected}");
        }
    }

    #[test]
    fn rec_709_is_itself_and_white_stays_white() {
        let one = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        assert_near(Primaries::REC_709.to_rec_709(), one, 1e-12, "Rec. 709");
        for primaries in [REC_2020, ACES_2065] {
            let white = transformed(&of(primaries).to_rec_709(), [1.0; 3]);
            assert!(white.iter().all(|c| (c - 1.0).abs() < 1e-12), "{primaries:?}: white becomes {white:?}");
        }
    }

    #[test]
    fn the_matrix_of_rec_2020_is_that_of_its_report() {
        // ITU-R BT.2087, the inverse of its M2, to the digits printed there.
        let expected = [[1.6605, -0.5876, -0.0728], [-0.1246, 1.1329, -0.0083], [-0.0182, -0.1006, 1.1187]];
        assert_near(of(REC_2020).to_rec_709(), expected, 1e-4, "Rec. 2020");
    }

    #[test]
    fn what_is_no_color_space_is_none() {
        let [red, green, blue, white] = REC_2020;
        assert_eq!(Primaries::new(red, green, green, white), None, "on a line");
        assert_eq!(Primaries::new(red, green, blue, [0.3, 0.0]), None, "a white without luminance");
        assert_eq!(Primaries::new([f64::NAN; 2], green, blue, white), None, "no number");
        assert!(!of(REC_2020).are_rec_709() && Primaries::REC_709.are_rec_709(), "which is which");
    }
}
