//! Order-3 irradiance as seven vectors for a shader, after Sloan.

use core::f64::consts::PI;

#[cfg(not(feature = "std"))]
use num_traits::Float as _;

#[cfg(feature = "batch")]
use crate::encoding::packed_lanes::EvalPacked;
use crate::encoding::{coefficient, irradiance_under};
use crate::expansion::Expansion;
use crate::scalar::{Coefficient, Rgb};
#[cfg(feature = "batch")]
use crate::simd::Machine;
use crate::sphere::Dir;

/// The polynomial form of nine coefficients in color: seven vectors of four numbers for three dot products for each
/// channel.
///
/// ```text
///   E(n) = A·(x, y, z, 1) + B·(xy, yz, z², zx) + C (x² - y²)        for each channel
///
///   A = (-k_1 E_3, -k_1 E_1, k_1 E_2, k_0 E_0 - k_3 E_6)        k_0 = 1/(2√π)      k_1 = √(3/4π)
///   B = (k_2 E_4, -k_2 E_5, 3 k_3 E_6, -k_2 E_7)                k_2 = √(15/4π)     k_3 = √(5/16π)
///   C = k_4 E_8                                                 k_4 = k_2/2
/// ```
///
/// Signs are those of the basis with the Condon-Shortley phase. Made from radiance, `E_l = A_l L_l`, and divided by π
/// ([`PackedIrradiance::scaled`]) the constants are those of [Sloan 2008] A10 (`c_0 = 1/(2√π)`, `c_1 = √3/(3√π)`,
/// `c_2 = √15/(8√π)`, `c_3 = √5/(16√π)`, `c_4 = c_2/2`), and the result is the radiance reflected by a white diffuse
/// surface.
///
/// [Sloan 2008]: https://www.ppsloan.org/publications/StupidSH36.pdf
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PackedIrradiance {
    /// `A` of red, green and blue: `cAr`, `cAg`, `cAb`.
    pub a: [[f64; 4]; 3],
    /// `B` of red, green and blue: `cBr`, `cBg`, `cBb`.
    pub b: [[f64; 4]; 3],
    /// `C` of red, green and blue: `cC`.
    pub c: [f64; 3],
}

impl PackedIrradiance {
    /// Packs the first three bands of an irradiance, or of any other function.
    #[must_use]
    pub fn from_irradiance_sh<T: Coefficient<Wide = Rgb<f64>>>(irradiance: &impl Expansion<T>) -> Self {
        let (k_0, k_1) = (0.5 / PI.sqrt(), (0.75 / PI).sqrt());
        let (k_2, k_3) = ((3.75 / PI).sqrt(), (5.0 / (16.0 * PI)).sqrt());
        let e = |i: usize, c: usize| coefficient(irradiance, i).channel(c);
        let a = |c| [-k_1 * e(3, c), -k_1 * e(1, c), k_1 * e(2, c), k_0 * e(0, c) - k_3 * e(6, c)];
        let b = |c| [k_2 * e(4, c), -k_2 * e(5, c), 3.0 * k_3 * e(6, c), -k_2 * e(7, c)];
        Self { a: [0, 1, 2].map(a), b: [0, 1, 2].map(b), c: [0, 1, 2].map(|c| 0.5 * k_2 * e(8, c)) }
    }

    /// The irradiance under the first three bands of a radiance.
    #[must_use]
    pub fn from_radiance_sh<T: Coefficient<Wide = Rgb<f64>>>(radiance: &impl Expansion<T>) -> Self {
        Self::from_irradiance_sh(&irradiance_under::<9, _>(radiance))
    }

    /// Every number times `s`; with `1/π` the values are the radiance reflected by a white diffuse surface.
    #[must_use]
    pub fn scaled(self, s: f64) -> Self {
        Self { a: self.a.map(|v| v.map(|x| x * s)), b: self.b.map(|v| v.map(|x| x * s)), c: self.c.map(|x| x * s) }
    }

    /// The value for a normal, as a shader computes it.
    #[must_use]
    pub fn eval(&self, n: Dir) -> Rgb<f64> {
        let [x, y, z] = n.to_array();
        let (linear, quadratic) = ([x, y, z, 1.0], [x * y, y * z, z * z, z * x]);
        let dot4 = |a: [f64; 4], b: [f64; 4]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        Rgb::from_channels(|c| dot4(self.a[c], linear) + dot4(self.b[c], quadratic) + self.c[c] * (x * x - y * y))
    }

    /// [`PackedIrradiance::eval`] for many normals, in single precision: within 2e-6 where the coefficients are at most 1 (test
    /// `every_machine_has_the_value_of_each_normal`).
    ///
    /// # Panics
    /// If the numbers of normals and values differ.
    #[cfg(feature = "batch")]
    pub fn eval_into(&self, normals: &crate::batch::DirBatch, out: &mut [Rgb<f32>]) {
        assert_eq!(normals.len(), out.len(), "normals against values");
        Machine::detect().run(EvalPacked { vectors: self.to_vectors(), normals: normals.blocks(), out });
    }

    /// The vectors in the order of the paper's shader, ready for upload: `cAr cAg cAb cBr cBg cBb cC`; the last number
    /// is 1.
    #[must_use]
    pub fn to_vectors(&self) -> [[f32; 4]; 7] {
        let [r, g, b] = self.c;
        let all = [self.a[0], self.a[1], self.a[2], self.b[0], self.b[1], self.b[2], [r, g, b, 1.0]];
        all.map(|v| v.map(|x| x as f32))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::encoding::irradiance_matrix::IrradianceMatrix;
    use crate::expansion::{ShL2, ShVec, Zonal};
    use lobe_testkit::{Random, directions};

    fn random_radiance() -> ShVec<Rgb<f64>> {
        let values = Random::new(4).signed_vec(27);
        ShVec::from_vec((0..9).map(|i| Rgb::new(values[i], values[9 + i], values[18 + i])).collect()).unwrap()
    }

    fn worst(a: Rgb<f64>, b: Rgb<f64>) -> f64 {
        (0..3).map(|c| (a.channel(c) - b.channel(c)).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn vectors_matrix_and_harmonics_are_one_function() {
        let radiance = random_radiance();
        let irradiance = radiance.convolved(&Zonal::clamped_cosine(3));
        let (packed, again) =
            (PackedIrradiance::from_radiance_sh(&radiance), PackedIrradiance::from_irradiance_sh(&irradiance));
        let (matrix, by_matrix) =
            (IrradianceMatrix::from_radiance_sh(&radiance), IrradianceMatrix::from_irradiance_sh(&irradiance));
        for v in directions() {
            let n = Dir::from_unit(v);
            let e = irradiance.eval(n);
            for (what, found) in [
                ("vectors of radiance", packed.eval(n)),
                ("vectors of irradiance", again.eval(n)),
                ("matrix of radiance", matrix.eval(n)),
                ("matrix of irradiance", by_matrix.eval(n)),
            ] {
                assert!(worst(found, e) < 2e-15, "{what} towards {v:?}: {found:?} against {e:?}");
            }
        }
    }

    #[test]
    fn the_constants_are_those_of_sloan_2008() {
        let constant = |i: usize| {
            let mut radiance = ShL2::<Rgb<f64>>::zero();
            radiance[i].g = 1.0;
            PackedIrradiance::from_radiance_sh(&radiance).scaled(1.0 / PI)
        };
        for (what, found, expected) in [
            ("c0", constant(0).a[1][3], 0.282094791773878),
            ("c1", constant(2).a[1][2], 0.325735007935280),
            ("c2", constant(4).b[1][0], 0.273137107648020),
            ("c3", -constant(6).a[1][3], 0.078847891313130),
            ("3 c3", constant(6).b[1][2], 3.0 * 0.078847891313130),
            ("c4", constant(8).c[1], 0.136568553824010),
            ("-c1 of x", constant(3).a[1][0], -0.325735007935280),
        ] {
            assert!((found - expected).abs() < 1e-15, "{what}: {found} against {expected}");
        }
    }

    #[test]
    fn the_upload_keeps_the_order_and_the_value() {
        let packed = PackedIrradiance::from_radiance_sh(&random_radiance());
        let v = packed.to_vectors();
        for s in directions() {
            let [x, y, z] = s.map(|c| c as f32);
            let dot4 = |a: [f32; 4], b: [f32; 4]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
            let channel = |c: usize| {
                let sum = dot4(v[c], [x, y, z, 1.0]) + dot4(v[3 + c], [x * y, y * z, z * z, z * x]);
                f64::from(sum + v[6][c] * (x * x - y * y))
            };
            let found = Rgb::from_channels(channel);
            let expected = packed.eval(Dir::from_unit(s));
            assert!(worst(found, expected) < 1e-6, "towards {s:?}: {found:?} against {expected:?}");
        }
        assert_eq!(v[6][3], 1.0, "the number nobody uses");
    }

    #[test]
    fn white_light_gives_exactly_pi_and_the_paper_white_one() {
        let packed = PackedIrradiance::from_radiance_sh(&ShL2::constant(Rgb::splat(1.0)));
        let e = packed.eval(Dir::from_angles(0.5, 1.0));
        assert!(worst(e, Rgb::splat(PI)) < 1e-15, "{e:?}");
        let paper = packed.scaled(1.0 / PI).eval(Dir::Y);
        assert!(worst(paper, Rgb::splat(1.0)) < 1e-15, "{paper:?}");
    }
}
