//! Order-3 irradiance as nine coefficients of light and five constants, after Ramamoorthi and Hanrahan.

use core::f64::consts::PI;

#[cfg(not(feature = "std"))]
use num_traits::Float as _;

use crate::encoding::{LINEAR_SHARE, QUADRATIC_SHARE, coefficient};
use crate::expansion::Expansion;
use crate::scalar::{Coefficient, Rgb};
use crate::sphere::Dir;

/// The nine coefficients of light in color, as many shaders expect them, and the polynomial that makes irradiance of
/// them.
///
/// ```text
///   E(n) = c_1 L_22 (x² - y²) + c_3 L_20 z² + c_4 L_00 - c_5 L_20
///        + 2 c_1 (L_2-2 xy + L_21 xz + L_2-1 yz) + 2 c_2 (L_11 x + L_1-1 y + L_10 z)
///
///   c_1 = √(15π)/16   c_2 = √(3π)/6   c_3 = 3√(5π)/16   c_4 = √π/2   c_5 = √(5π)/16
/// ```
///
/// After [Ramamoorthi and Hanrahan 2001]. `L` are coefficients of **radiance** in a basis without the
/// Condon-Shortley phase: `L_1±1` and `L_2±1` are those of Lobe's basis with the other sign. The constants are printed
/// with six digits, 0.429043, 0.511664, 0.743125, 0.886227, 0.247708, of which the second and the third are one unit too
/// high in the last; [`constants`](Self::constants) has them exact. The same function as
/// [`IrradianceMatrix`](crate::encoding::IrradianceMatrix) and [`PackedIrradiance`](crate::encoding::PackedIrradiance), to rounding (test
/// `the_published_formula_yields_the_irradiance`).
///
/// [Ramamoorthi and Hanrahan 2001]: https://cseweb.ucsd.edu/~ravir/papers/envmap/envmap.pdf
///
/// ```
/// use lobe_sh::encoding::IrradiancePolynomial;
/// use lobe_sh::{Coefficient as _, Rgb, ShL2};
///
/// // A sky that is brighter towards +x than towards -x: L_11 is positive, though Lobe's coefficient 3 is negative.
/// let mut sky = ShL2::constant(Rgb::splat(1.0_f64));
/// sky[3] = Rgb::splat(-0.5);
/// assert_eq!(IrradiancePolynomial::from_radiance_sh(&sky).l[3], Rgb::splat(0.5));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct IrradiancePolynomial {
    /// `L_00`, `L_1-1`, `L_10`, `L_11`, `L_2-2` to `L_22`.
    pub l: [Rgb<f64>; 9],
}

/// The signs of the Condon-Shortley phase, `(-1)^m`.
const SIGNS: [f64; 9] = [1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0];

/// The band of each coefficient.
const BANDS: [usize; 9] = [0, 1, 1, 1, 2, 2, 2, 2, 2];

impl IrradiancePolynomial {
    /// The names of the coefficients in the paper, in order.
    pub const NAMES: [&'static str; 9] = ["L00", "L1-1", "L10", "L11", "L2-2", "L2-1", "L20", "L21", "L22"];

    /// `c_1` to `c_5`.
    #[must_use]
    pub fn constants() -> [f64; 5] {
        let c_5 = (5.0 * PI).sqrt() / 16.0;
        [(15.0 * PI).sqrt() / 16.0, (3.0 * PI).sqrt() / 6.0, 3.0 * c_5, 0.5 * PI.sqrt(), c_5]
    }

    /// The first three bands of a radiance.
    #[must_use]
    pub fn from_radiance_sh<T: Coefficient<Wide = Rgb<f64>>>(radiance: &impl Expansion<T>) -> Self {
        Self { l: core::array::from_fn(|i| coefficient(radiance, i).scale(SIGNS[i])) }
    }

    /// The first three bands of the radiance that has this irradiance, `E_l / A_l`.
    #[must_use]
    pub fn from_irradiance_sh<T: Coefficient<Wide = Rgb<f64>>>(irradiance: &impl Expansion<T>) -> Self {
        let of_radiance = [1.0, LINEAR_SHARE, QUADRATIC_SHARE].map(|share| 1.0 / (PI * share));
        Self { l: core::array::from_fn(|i| coefficient(irradiance, i).scale(SIGNS[i] * of_radiance[BANDS[i]])) }
    }

    /// The irradiance of a surface with normal `n`.
    #[must_use]
    pub fn eval(&self, n: Dir) -> Rgb<f64> {
        let [c_1, c_2, c_3, c_4, c_5] = Self::constants();
        let [l_00, l_1m1, l_10, l_11, l_2m2, l_2m1, l_20, l_21, l_22] = self.l;
        let [x, y, z] = n.to_array();
        let linear = l_11.scale(x) + l_1m1.scale(y) + l_10.scale(z);
        let mixed = l_2m2.scale(x * y) + l_21.scale(x * z) + l_2m1.scale(y * z);
        let pure = l_22.scale(c_1 * (x * x - y * y)) + l_20.scale(c_3 * z * z - c_5);
        pure + l_00.scale(c_4) + mixed.scale(2.0 * c_1) + linear.scale(2.0 * c_2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expansion::{ShVec, Zonal};
    use lobe_testkit::{Random, directions};

    fn worst(a: Rgb<f64>, b: Rgb<f64>) -> f64 {
        (0..3).map(|c| (a.channel(c) - b.channel(c)).abs()).fold(0.0, f64::max)
    }

    fn random_radiance(order: usize) -> ShVec<Rgb<f64>> {
        let values = Random::new(order as u64).signed_vec(3 * order * order);
        ShVec::from_vec(values.chunks(3).map(|c| Rgb::new(c[0], c[1], c[2])).collect()).unwrap()
    }

    /// The formula as it is printed, term by term, of one channel.
    fn published(l: &[Rgb<f64>; 9], channel: usize, [x, y, z]: [f64; 3]) -> f64 {
        let [l00, l1_1, l10, l11, l2_2, l2_1, l20, l21, l22] = l.map(|l| l.channel(channel));
        // To 15 digits; printed to six.
        let (c1, c2) = (0.429042765404892, 0.511663353973244);
        let (c3, c4, c5) = (0.743123868301127, 0.886226925452758, 0.247707956100376);
        c1 * l22 * (x * x - y * y) + c3 * l20 * z * z + c4 * l00 - c5 * l20
            + 2.0 * c1 * (l2_2 * x * y + l21 * x * z + l2_1 * y * z)
            + 2.0 * c2 * (l11 * x + l1_1 * y + l10 * z)
    }

    #[test]
    fn the_published_formula_yields_the_irradiance() {
        for order in [1, 2, 3, 5] {
            let radiance = random_radiance(order);
            let irradiance = radiance.resized(3).convolved(&Zonal::clamped_cosine(3));
            let light = IrradiancePolynomial::from_radiance_sh(&radiance);
            let again = IrradiancePolynomial::from_irradiance_sh(&irradiance);
            for v in directions() {
                let n = Dir::from_unit(v);
                let by_hand = Rgb::from_channels(|c| published(&light.l, c, v));
                for (what, found) in [("radiance", light.eval(n)), ("irradiance", again.eval(n)), ("by hand", by_hand)]
                {
                    let expected = irradiance.eval(n);
                    assert!(worst(found, expected) < 1e-14, "{what}, order {order}, {v:?}: {found:?}, {expected:?}");
                }
            }
        }
    }

    #[test]
    fn the_constants_are_the_published_ones_but_for_two_last_digits() {
        let published = [0.429043, 0.511664 - 1e-6, 0.743125 - 1e-6, 0.886227, 0.247708];
        for (k, (found, expected)) in IrradiancePolynomial::constants().iter().zip(published).enumerate() {
            assert!((found - expected).abs() <= 0.5e-6, "c{}: {found}, published {expected}", k + 1);
        }
    }

    #[test]
    fn light_from_an_axis_has_positive_coefficients_of_that_axis() {
        for (axis, i) in [(Dir::X, 3), (Dir::Y, 1), (Dir::Z, 2)] {
            let light = ShVec::impulse(3, axis, Rgb::splat(1.0_f64));
            let found = IrradiancePolynomial::from_radiance_sh(&light);
            assert!(found.l[i].g > 0.0, "{}: {found:?}", IrradiancePolynomial::NAMES[i]);
        }
    }
}
