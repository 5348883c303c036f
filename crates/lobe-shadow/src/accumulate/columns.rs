//! The basis in lanes: one direction for each receiver.

use lobe_sh::simd::{Wide, constant};
use pulp::Simd;

/// Bands at most: eight of expansions, and the ninth of the clamped cosine.
pub(crate) const MOST_BANDS: usize = 9;

/// The constants of the basis in single precision, column by column of equal `m`:
/// `P̄_m^m` and the steps `P̄_l^m = a z P̄_{l-1}^m - b P̄_{l-2}^m`; see [`lobe_sh::Basis`].
///
/// The plain recurrence, half the operations of the one there, is within 3e-6 to order 8 (test
/// `the_functions_in_lanes_are_the_basis`).
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

#[cfg(test)]
mod tests {
    use lobe_sh::eval_basis_into;
    use lobe_testkit::directions;
    use pulp::Scalar;

    use super::*;

    #[test]
    fn the_functions_in_lanes_are_the_basis() {
        let (columns, simd) = (Columns::new(), Scalar::new());
        let mut y = [0.0; MOST_BANDS * MOST_BANDS];
        for s in directions() {
            eval_basis_into(s, &mut y);
            let found = columns.eval(simd, MOST_BANDS, s.map(|c| constant(simd, c as f32)));
            for (i, (found, y)) in found.into_iter().zip(y).enumerate() {
                let mut number = [0.0_f32];
                found.store_array(&mut number, 0);
                assert!((f64::from(number[0]) - y).abs() < 3e-6, "y_{i} towards {s:?}: {} against {y}", number[0]);
            }
        }
    }
}
