//! Order-5 irradiance as fourteen vectors for a shader.

use core::f64::consts::PI;

#[cfg(not(feature = "std"))]
use num_traits::Float as _;

use crate::encoding::{coefficient, irradiance_under};
use crate::expansion::Expansion;
use crate::scalar::{Coefficient, Rgb};
use crate::sphere::Dir;

/// The polynomial form of irradiance of order 5 in color: 18 numbers for each channel, as many as its bands 0, 1, 2 and 4
/// have.
///
/// ```text
///   E(n) = A·(x, y, z, 1) + (B + z² D + d F)·(xy, yz, z², zx) + (C + d G) d        d = x² - y², for each channel
///
///   A = (-k_1 E_3, -k_1 E_1, k_1 E_2, k_0 E_0 - k_3 E_6 + 3 h_0 E_20 - h_4 E_24)
///   B = (k_2 E_4 - 2 h_2 E_18, -k_2 E_5 + 3 h_1 E_19 - h_3 E_17,
///        3 k_3 E_6 - 30 h_0 E_20 + 2 h_4 E_24, -k_2 E_7 + 3 h_1 E_21 + h_3 E_23)
///   C = k_4 E_8 - h_2 E_22
///   D = (14 h_2 E_18, -7 h_1 E_19 + h_3 E_17, 35 h_0 E_20 - h_4 E_24, -7 h_1 E_21 - h_3 E_23)
///   F = (4 h_4 E_16, -2 h_3 E_17, 7 h_2 E_22, -2 h_3 E_23)
///   G = 2 h_4 E_24
///
///   h_0 = 3/16 √(1/π)   h_1 = 3/4 √(5/2π)   h_2 = 3/8 √(5/π)   h_3 = 3/4 √(35/2π)   h_4 = 3/16 √(35/π)
/// ```
///
/// `A`, `B`, `C` and `k` are those of [`PackedIrradiance`](crate::encoding::PackedIrradiance), to which band 4 is added: with `d`
/// and `z²` at hand its nine functions take no further products of coordinates. Band 3 has no part in irradiance, for
/// `A_3 = 0`, and is not read.
///
/// Where lights are much brighter than the sky, order 3 is too coarse ([Sloan 2008]): the error of a single lamp halves,
/// from 0.036084 to 0.018042 (RMS, in units of its irradiance on a surface that faces it; test
/// `errors_are_those_of_their_definition`). The form is derived here; it equals the expansion to rounding (test
/// `order_5_is_the_irradiance_of_four_bands_towards_every_normal`).
///
/// [Sloan 2008]: https://www.ppsloan.org/publications/StupidSH36.pdf
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PackedIrradiance5 {
    /// `A` of red, green and blue: `cAr`, `cAg`, `cAb`.
    pub a: [[f64; 4]; 3],
    /// `B` of red, green and blue: `cBr`, `cBg`, `cBb`.
    pub b: [[f64; 4]; 3],
    /// `C` of red, green and blue: `cC`.
    pub c: [f64; 3],
    /// `D` of red, green and blue: `cDr`, `cDg`, `cDb`.
    pub d: [[f64; 4]; 3],
    /// `F` of red, green and blue: `cFr`, `cFg`, `cFb`.
    pub f: [[f64; 4]; 3],
    /// `G` of red, green and blue: `cG`.
    pub g: [f64; 3],
}

// The functions of band 4 in z², d = x² - y² and the products of two coordinates. With x² + y² = 1 - z² on the sphere,
//   3x² - y² = 1 - z² + 2d,   x² - 3y² = z² - 1 + 2d,   x⁴ - 6x²y² + y⁴ = d² - 4x²y² = 2d² - (1 - z²)²,
// so that
//   y_16 =  4 h_4 xy d            y_17 = -h_3 yz (1 - z² + 2d)    y_18 = 2 h_2 xy (7z² - 1)    y_19 = -h_1 yz (7z² - 3)
//   y_20 =  h_0 (35z⁴ - 30z² + 3)
//   y_21 = -h_1 zx (7z² - 3)      y_22 = h_2 d (7z² - 1)          y_23 = -h_3 zx (z² - 1 + 2d)
//   y_24 =  h_4 (2d² - 1 + 2z² - z⁴)
impl PackedIrradiance5 {
    /// Packs bands 0, 1, 2 and 4 of an irradiance.
    #[must_use]
    pub fn from_irradiance_sh<T: Coefficient<Wide = Rgb<f64>>>(irradiance: &impl Expansion<T>) -> Self {
        let (k_0, k_1) = (0.5 / PI.sqrt(), (0.75 / PI).sqrt());
        let (k_2, k_3) = ((3.75 / PI).sqrt(), (5.0 / (16.0 * PI)).sqrt());
        let (h_0, h_1, h_2) = (0.1875 / PI.sqrt(), 0.75 * (2.5 / PI).sqrt(), 0.375 * (5.0 / PI).sqrt());
        let (h_3, h_4) = (0.75 * (17.5 / PI).sqrt(), 0.1875 * (35.0 / PI).sqrt());
        let e = |i: usize, c: usize| coefficient(irradiance, i).channel(c);
        let constant = |c| k_0 * e(0, c) - k_3 * e(6, c) + 3.0 * h_0 * e(20, c) - h_4 * e(24, c);
        let a = |c| [-k_1 * e(3, c), -k_1 * e(1, c), k_1 * e(2, c), constant(c)];
        let b = |c| {
            let (xy, yz) =
                (k_2 * e(4, c) - 2.0 * h_2 * e(18, c), -k_2 * e(5, c) + 3.0 * h_1 * e(19, c) - h_3 * e(17, c));
            let zz = 3.0 * k_3 * e(6, c) - 30.0 * h_0 * e(20, c) + 2.0 * h_4 * e(24, c);
            [xy, yz, zz, -k_2 * e(7, c) + 3.0 * h_1 * e(21, c) + h_3 * e(23, c)]
        };
        let d = |c| {
            let (yz, zx) = (-7.0 * h_1 * e(19, c) + h_3 * e(17, c), -7.0 * h_1 * e(21, c) - h_3 * e(23, c));
            [14.0 * h_2 * e(18, c), yz, 35.0 * h_0 * e(20, c) - h_4 * e(24, c), zx]
        };
        let f = |c| [4.0 * h_4 * e(16, c), -2.0 * h_3 * e(17, c), 7.0 * h_2 * e(22, c), -2.0 * h_3 * e(23, c)];
        Self {
            a: [0, 1, 2].map(a),
            b: [0, 1, 2].map(b),
            c: [0, 1, 2].map(|c| 0.5 * k_2 * e(8, c) - h_2 * e(22, c)),
            d: [0, 1, 2].map(d),
            f: [0, 1, 2].map(f),
            g: [0, 1, 2].map(|c| 2.0 * h_4 * e(24, c)),
        }
    }

    /// The irradiance under the first five bands of a radiance.
    #[must_use]
    pub fn from_radiance_sh<T: Coefficient<Wide = Rgb<f64>>>(radiance: &impl Expansion<T>) -> Self {
        Self::from_irradiance_sh(&irradiance_under::<25, _>(radiance))
    }

    /// Every number times `s`; with `1/π` the values are the radiance reflected by a white diffuse surface.
    #[must_use]
    pub fn scaled(self, s: f64) -> Self {
        let vectors = |v: [[f64; 4]; 3]| v.map(|v| v.map(|x| x * s));
        Self {
            a: vectors(self.a),
            b: vectors(self.b),
            c: self.c.map(|x| x * s),
            d: vectors(self.d),
            f: vectors(self.f),
            g: self.g.map(|x| x * s),
        }
    }

    /// The value for a normal, as a shader computes it.
    #[must_use]
    pub fn eval(&self, n: Dir) -> Rgb<f64> {
        let [x, y, z] = n.to_array();
        let (linear, quadratic, d) = ([x, y, z, 1.0], [x * y, y * z, z * z, z * x], x * x - y * y);
        let dot4 = |a: [f64; 4], b: [f64; 4]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        Rgb::from_channels(|c| {
            let quartic = [0, 1, 2, 3].map(|k| self.b[c][k] + z * z * self.d[c][k] + d * self.f[c][k]);
            dot4(self.a[c], linear) + dot4(quartic, quadratic) + (self.c[c] + d * self.g[c]) * d
        })
    }

    /// The vectors ready for upload: `cAr cAg cAb cBr cBg cBb cC cDr cDg cDb cFr cFg cFb cG`, of which the first seven are
    /// in the order of [`PackedIrradiance::to_vectors`](crate::encoding::PackedIrradiance::to_vectors); the last numbers of `cC` and
    /// `cG` are 1.
    #[must_use]
    pub fn to_vectors(&self) -> [[f32; 4]; 14] {
        let last = |[r, g, b]: [f64; 3]| [r, g, b, 1.0];
        let ([a_r, a_g, a_b], [b_r, b_g, b_b]) = (self.a, self.b);
        let ([d_r, d_g, d_b], [f_r, f_g, f_b]) = (self.d, self.f);
        let all = [a_r, a_g, a_b, b_r, b_g, b_b, last(self.c), d_r, d_g, d_b, f_r, f_g, f_b, last(self.g)];
        all.map(|v| v.map(|x| x as f32))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::basis::eval_basis;
    use crate::encoding::packed_irradiance::PackedIrradiance;
    use crate::expansion::{ShL4, ShVec, Zonal};
    use lobe_testkit::{Random, directions};

    fn random_radiance() -> ShVec<Rgb<f64>> {
        let values = Random::new(5).signed_vec(75);
        ShVec::from_vec(values.chunks(3).map(|c| Rgb::new(c[0], c[1], c[2])).collect()).unwrap()
    }

    fn worst(a: Rgb<f64>, b: Rgb<f64>) -> f64 {
        (0..3).map(|c| (a.channel(c) - b.channel(c)).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn each_function_of_four_bands_is_its_own_polynomial() {
        for i in (0..9).chain(16..25) {
            let mut irradiance = ShL4::<Rgb<f64>>::zero();
            irradiance[i].g = 1.0;
            let packed = PackedIrradiance5::from_irradiance_sh(&irradiance);
            for v in directions() {
                let n = Dir::from_unit(v);
                let (found, expected) = (packed.eval(n).g, eval_basis(n, 5)[i]);
                assert!((found - expected).abs() < 1e-14, "y_{i} towards {v:?}: {found} against {expected}");
            }
        }
    }

    #[test]
    fn radiance_and_irradiance_are_packed_alike_and_band_3_is_not_read() {
        let radiance = random_radiance();
        let mut irradiance = radiance.convolved(&Zonal::clamped_cosine(5));
        let packed = PackedIrradiance5::from_radiance_sh(&radiance);
        let e = irradiance.clone();
        irradiance.band_mut(3).fill(Rgb::splat(7.0));
        let again = PackedIrradiance5::from_irradiance_sh(&irradiance);
        for v in directions() {
            let n = Dir::from_unit(v);
            for (what, found) in [("of radiance", packed.eval(n)), ("of irradiance", again.eval(n))] {
                assert!(worst(found, e.eval(n)) < 1e-14, "{what} towards {v:?}: {found:?} against {:?}", e.eval(n));
            }
        }
    }

    #[test]
    fn without_band_4_the_vectors_are_those_of_order_3() {
        let order_3 = random_radiance().resized(3);
        let (five, three) =
            (PackedIrradiance5::from_radiance_sh(&order_3), PackedIrradiance::from_radiance_sh(&order_3));
        let (upload, expected) = (five.to_vectors(), three.to_vectors());
        assert_eq!(upload[..7], expected[..], "the first seven vectors");
        let zeros = [[0.0_f32; 4]; 6];
        assert_eq!(upload[7..13], zeros[..], "cD and cF");
        assert_eq!(upload[13], [0.0_f32, 0.0, 0.0, 1.0], "cG");
    }

    #[test]
    fn the_upload_keeps_the_value() {
        let packed = PackedIrradiance5::from_radiance_sh(&random_radiance()).scaled(1.0 / PI);
        let v = packed.to_vectors();
        for s in directions() {
            let [x, y, z] = s.map(|c| c as f32);
            let d = x * x - y * y;
            let dot4 = |a: [f32; 4], b: [f32; 4]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
            let channel = |c: usize| {
                let sum = [0, 1, 2, 3].map(|k| v[3 + c][k] + z * z * v[7 + c][k] + d * v[10 + c][k]);
                let quartic = dot4(sum, [x * y, y * z, z * z, z * x]) + (v[6][c] + d * v[13][c]) * d;
                f64::from(dot4(v[c], [x, y, z, 1.0]) + quartic)
            };
            let (found, expected) = (Rgb::from_channels(channel), packed.eval(Dir::from_unit(s)));
            assert!(worst(found, expected) < 2e-6, "towards {s:?}: {found:?} against {expected:?}");
        }
    }
}
