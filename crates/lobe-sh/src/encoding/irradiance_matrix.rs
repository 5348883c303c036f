//! Order-3 irradiance as a quadratic form.

use core::f64::consts::PI;

#[cfg(not(feature = "std"))]
use num_traits::Float as _;

use crate::encoding::{coefficient, irradiance_under};
use crate::expansion::Expansion;
use crate::scalar::{Coefficient, Rgb};
use crate::sphere::Dir;

/// The quadratic form of nine coefficients in color, one symmetric matrix for each channel.
///
/// ```text
///   E(n) = N̂ᵀ M N̂        N̂ = (x, y, z, 1)
///
///       [ c_1 L_22   c_1 L_2-2   c_1 L_21   c_2 L_11              ]      c_1 = √(15π)/16 = 0.429042765404892
///   M = [ c_1 L_2-2 -c_1 L_22    c_1 L_2-1  c_2 L_1-1             ]      c_2 = √(3π)/6   = 0.511663353973244
///       [ c_1 L_21   c_1 L_2-1   c_3 L_20   c_2 L_10              ]      c_3 = 3√(5π)/16 = 0.743123868301127
///       [ c_2 L_11   c_2 L_1-1   c_2 L_10   c_4 L_00 - c_5 L_20   ]      c_4 = √π/2      = 0.886226925452758
///                                                                        c_5 = √(5π)/16  = 0.247707956100376
/// ```
///
/// The form of [Ramamoorthi and Hanrahan 2001], whose `L` are those of radiance in a basis without the Condon-Shortley
/// phase: here `L_1±1` and `L_2±1` of Lobe's basis enter with the other sign. The constants are printed there with six
/// digits, two of them wrongly rounded (0.511664, 0.743125).
///
/// [Ramamoorthi and Hanrahan 2001]: https://cseweb.ucsd.edu/~ravir/papers/envmap/envmap.pdf
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct IrradianceMatrix {
    /// `M` of red, green and blue, row after row.
    pub m: [[[f64; 4]; 4]; 3],
}

impl IrradianceMatrix {
    /// The irradiance given by the first three bands of its expansion.
    #[must_use]
    pub fn from_irradiance_sh<T: Coefficient<Wide = Rgb<f64>>>(irradiance: &impl Expansion<T>) -> Self {
        // The constants divided by A_l = π, 2π/3, π/4.
        let (c_1, c_3) = ((15.0 / PI).sqrt() / 4.0, 3.0 * (5.0 / PI).sqrt() / 4.0);
        let (c_2, c_4) = ((3.0 / PI).sqrt() / 4.0, 0.5 / PI.sqrt());
        let c_5 = c_3 / 3.0;
        let channel = |c: usize| {
            let e = |i: usize| coefficient(irradiance, i).channel(c);
            let (xy, yz, zx, x2) = (c_1 * e(4), -c_1 * e(5), -c_1 * e(7), c_1 * e(8));
            let (x, y, z) = (-c_2 * e(3), -c_2 * e(1), c_2 * e(2));
            [[x2, xy, zx, x], [xy, -x2, yz, y], [zx, yz, c_3 * e(6), z], [x, y, z, c_4 * e(0) - c_5 * e(6)]]
        };
        Self { m: [0, 1, 2].map(channel) }
    }

    /// The irradiance under the first three bands of a radiance.
    #[must_use]
    pub fn from_radiance_sh<T: Coefficient<Wide = Rgb<f64>>>(radiance: &impl Expansion<T>) -> Self {
        Self::from_irradiance_sh(&irradiance_under::<9, _>(radiance))
    }

    /// The irradiance of a surface with normal `n`.
    #[must_use]
    pub fn eval(&self, n: Dir) -> Rgb<f64> {
        let [x, y, z] = n.to_array();
        let n = [x, y, z, 1.0];
        let row = |row: &[f64; 4]| row.iter().zip(n).map(|(m, n)| m * n).sum::<f64>();
        Rgb::from_channels(|c| self.m[c].iter().zip(n).map(|(m, n)| n * row(m)).sum())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expansion::ShL2;

    #[test]
    fn the_constants_are_the_exact_ones() {
        let unit = |i: usize| {
            let mut radiance = ShL2::<Rgb<f64>>::zero();
            radiance[i].b = 1.0;
            IrradianceMatrix::from_radiance_sh(&radiance).m[2]
        };
        for (what, found, expected) in [
            ("c1 of x²", unit(8)[0][0], 0.429042765404892),
            ("c1 of y²", unit(8)[1][1], -0.429042765404892),
            ("c1 of xy", unit(4)[0][1], 0.429042765404892),
            ("c1 of zx, our sign", unit(7)[2][0], -0.429042765404892),
            ("c2 of x, our sign", unit(3)[3][0], -0.511663353973244),
            ("c2 of z", unit(2)[2][3], 0.511663353973244),
            ("c3", unit(6)[2][2], 0.743123868301127),
            ("c4", unit(0)[3][3], 0.886226925452758),
            ("c5", unit(6)[3][3], -0.247707956100376),
        ] {
            assert!((found - expected).abs() < 1e-15, "{what}: {found} against {expected}");
        }
    }

    #[test]
    fn the_matrix_is_symmetric() {
        let radiance = ShL2::impulse(Dir::from_angles(1.0, 2.0), Rgb::new(1.0, 2.0, 3.0));
        for (c, m) in IrradianceMatrix::from_radiance_sh(&radiance).m.iter().enumerate() {
            for i in 0..4 {
                for j in 0..4 {
                    assert_eq!(m[i][j], m[j][i], "channel {c}, entry {i} {j}");
                }
            }
        }
    }
}
