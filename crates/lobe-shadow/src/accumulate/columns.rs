//! The basis in lanes: one direction for each receiver.

use lobe_sh::simd::{Wide, constant};
use pulp::Simd;

/// Bands at most: eight of expansions, and the ninth of the clamped cosine.
pub(crate) const MOST_BANDS: usize = 9;

/// The constants of the basis in single precision, column by column of equal `m`:
/// `P̄_m^m` and the steps `P̄_l^m = a z P̄_{l-1}^m - b P̄_{l-2}^m`; see [`lobe_sh::Basis`].
///
/// The plain recurrence, half the operations of the one there, is within 3e-6 to order 8 (test
/// `polynomials_of_leading_coefficient_1_are_the_basis`, for the same recurrence).
#[derive(Clone, Debug)]
pub(crate) struct Columns {
    pub(crate) diagonal: [f32; MOST_BANDS],
    pub(crate) steps: [[[f32; 2]; MOST_BANDS]; MOST_BANDS],
}

impl Columns {
    pub(crate) fn new() -> Self {
        let mut columns = Self { diagonal: [0.0; MOST_BANDS], steps: [[[0.0; 2]; MOST_BANDS]; MOST_BANDS] };
        let mut diagonal = (4.0 * std::f64::consts::PI).sqrt().recip();
        for m in 0..MOST_BANDS {
            if m > 0 {
                // √2 of the real basis comes in with m = 1.
                let first = if m == 1 { 2.0 } else { 1.0 };
                diagonal *= -(first * (2 * m + 1) as f64 / (2 * m) as f64).sqrt();
            }
            columns.diagonal[m] = diagonal as f32;
            let mut before = f64::INFINITY;
            for l in m + 1..MOST_BANDS {
                let a = ((4 * l * l - 1) as f64 / (l * l - m * m) as f64).sqrt();
                columns.steps[m][l] = [a as f32, (a / before) as f32];
                before = a;
            }
        }
        columns
    }

    /// The functions of the first `bands` bands in the directions of lanes; of others zero.
    #[inline(always)]
    pub(crate) fn eval<S: Simd>(
        &self,
        simd: S,
        bands: usize,
        [x, y, z]: [Wide<S>; 3],
    ) -> [Wide<S>; MOST_BANDS * MOST_BANDS] {
        let mut out = [constant(simd, 0.0); MOST_BANDS * MOST_BANDS];
        let splat = |value| constant(simd, value);
        let (mut cos, mut sin) = (splat(1.0), splat(0.0));
        for m in 0..bands.min(MOST_BANDS) {
            let (mut before, mut p) = (splat(0.0), splat(self.diagonal[m]));
            for l in m..bands.min(MOST_BANDS) {
                if l > m {
                    let [a, b] = self.steps[m][l];
                    (before, p) = (p, (splat(a) * z).times_plus(p, splat(-b) * before));
                }
                let middle = l * (l + 1);
                out[middle + m] = p * cos;
                if m > 0 {
                    out[middle - m] = p * sin;
                }
            }
            (cos, sin) = if m == 0 { (x, y) } else { (x * cos - y * sin, x * sin + y * cos) };
        }
        out
    }
}
