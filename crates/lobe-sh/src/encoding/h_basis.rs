//! The H-basis: orthonormal polynomials of the upper hemisphere.

use core::f64::consts::PI;

#[cfg(not(feature = "std"))]
use num_traits::Float as _;

use crate::encoding::hemisphere::hemisphere_points;
use crate::expansion::Expansion;
use crate::rotation::Rotation;
use crate::scalar::Coefficient;
use crate::scalar::weighted_sum;
use crate::sphere::Dir;

/// Irradiance of the normals on one side of a surface, in `N` = 4 or 6 numbers for each channel.
///
/// ```text
///   E(n) = Σ_{j<N} c_j H_j(n')        n' = R⁻¹ n
///
///   H_1 = 1/√(2π)             H_2 = -√(3/2π) y       H_3 = √(3/2π) (2z - 1)       H_4 = -√(3/2π) x
///   H_5 = √(15/2π) x y        H_6 = ½ √(15/2π) (x² - y²)
/// ```
///
/// `R` is the surface's [`frame`](Self::frame), `world_from_tangent`: it takes +z to the geometric normal, from which
/// `n'` is at most 90° away. The basis is orthonormal there, so that the least-squares coefficients are plain
/// integrals. The first four functions span the same space as bands 0 and 1. For one directional light that gives 1 to
/// a surface facing it, the RMS error over normals and lights is 0.108 with four and 0.062 with six numbers (test
/// `four_and_six_have_the_known_errors`). After [Habel and Wimmer 2010].
///
/// [Habel and Wimmer 2010]: https://www.cg.tuwien.ac.at/research/publications/2010/Habel-2010-EIN/
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HBasis<const N: usize, T = f32> {
    /// `c_1 .. c_N`.
    pub coefficients: [T; N],
    /// `R`, which takes +z to the geometric normal.
    pub frame: Rotation,
}

/// Four numbers for each channel: a constant and a linear function.
pub type HBasis4<T = f32> = HBasis<4, T>;

/// Six numbers for each channel.
pub type HBasis6<T = f32> = HBasis<6, T>;

impl<const N: usize, T: Coefficient> HBasis<N, T> {
    /// The irradiance of the hemisphere around `frame`'s +z, by least squares.
    ///
    /// ```text
    ///   c_j = ∫_{z > 0} E(R n') H_j(n') dn'
    /// ```
    ///
    /// Integrated exactly for the bands that the expansion has. For order 3 and `N` = 6 this is the published matrix
    /// (test `nine_harmonics_go_to_six_by_the_published_matrix`).
    #[must_use]
    pub fn from_irradiance_sh(irradiance: &impl Expansion<T>, frame: Rotation) -> Self {
        const { assert!(N == 4 || N == 6, "the H-basis has 4 or 6 functions") }
        let mut sums = [T::Wide::ZERO; N];
        for (s, weight) in hemisphere_points(irradiance.order() + 2) {
            let e = irradiance.eval(frame.rotate_dir(s)).widen();
            for (sum, h) in sums.iter_mut().zip(functions(s)) {
                *sum += e.scale(weight * h);
            }
        }
        Self { coefficients: sums.map(T::narrow), frame }
    }

    /// The irradiance of a surface with normal `n`, given in the world, at most 90° from the geometric normal.
    #[must_use]
    pub fn eval(&self, n: Dir) -> T {
        T::narrow(weighted_sum(self.coefficients.into_iter().zip(functions(self.frame.inverse().rotate_dir(n)))))
    }
}

/// `H_1 .. H_6`.
fn functions(n: Dir) -> [f64; 6] {
    let [x, y, z] = n.to_array();
    let (linear, quadratic) = ((1.5 / PI).sqrt(), (7.5 / PI).sqrt());
    [
        (0.5 / PI).sqrt(),
        -linear * y,
        linear * (2.0 * z - 1.0),
        -linear * x,
        quadratic * x * y,
        0.5 * quadratic * (x * x - y * y),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::encoding::hemisphere::hemisphere_least_squares;
    use crate::expansion::{ShVec, Zonal};
    use crate::rotation::rotation::tangent_frame;
    use crate::scalar::Rgb;
    use crate::sphere::quadrature::SphereQuadrature;
    use lobe_testkit::{Random, directions};

    #[test]
    fn the_functions_are_orthonormal_on_the_hemisphere() {
        for i in 0..6 {
            for j in 0..6 {
                let product = |(s, w): (Dir, f64)| w * functions(s)[i] * functions(s)[j];
                let found: f64 = hemisphere_points(4).into_iter().map(product).sum();
                let expected = f64::from(u8::from(i == j));
                assert!((found - expected).abs() < 1e-14, "H_{} H_{}: {found}", i + 1, j + 1);
            }
        }
    }

    #[test]
    fn a_constant_is_kept_in_any_frame() {
        let flat = Rgb::new(PI, 1.0, 0.25);
        for v in directions() {
            let frame = tangent_frame(Dir::from_unit(v));
            let e = ShVec::constant(3, flat);
            let (four, six) = (HBasis4::from_irradiance_sh(&e, frame), HBasis6::from_irradiance_sh(&e, frame));
            for (s, _) in hemisphere_points(6) {
                let n = frame.rotate_dir(s);
                for found in [four.eval(n), six.eval(n)] {
                    let error = (0..3).map(|c| (found.channel(c) - flat.channel(c)).abs()).fold(0.0, f64::max);
                    assert!(error < 1e-13, "normal {v:?}, towards {n:?}: {found:?}");
                }
            }
        }
    }

    #[test]
    fn nine_harmonics_go_to_six_by_the_published_matrix() {
        let root = f64::sqrt;
        let (same, h3_from_2, h1_from_2) = (root(2.0) / 2.0, root(2.0) / 4.0, root(6.0) / 4.0);
        // (SH index, H index from 0, factor); all others are zero.
        let published = [
            (0, 0, same),
            (1, 1, same),
            (3, 3, same),
            (4, 4, same),
            (8, 5, same),
            (2, 0, h1_from_2),
            (2, 2, h3_from_2),
            (6, 2, root(30.0) / 8.0),
            (5, 1, 3.0 * root(10.0) / 16.0),
            (7, 3, 3.0 * root(10.0) / 16.0),
        ];
        for i in 0..9 {
            let mut f = ShVec::<f64>::zero(3);
            f[i] = 1.0;
            let found = HBasis6::from_irradiance_sh(&f, Rotation::IDENTITY).coefficients;
            for (j, found) in found.into_iter().enumerate() {
                let expected = published.iter().find(|p| (p.0, p.1) == (i, j)).map_or(0.0, |p| p.2);
                assert!((found - expected).abs() < 1e-14, "Y_{i} to H_{}: {found} against {expected}", j + 1);
            }
        }
    }

    #[test]
    fn four_are_the_linear_least_squares_of_the_hemisphere() {
        let e = ShVec::from_vec(Random::new(2).signed_vec(36)).unwrap();
        for v in directions().into_iter().step_by(7) {
            let normal = Dir::from_unit(v);
            let frame = tangent_frame(normal);
            let (four, linear) = (HBasis4::from_irradiance_sh(&e, frame), hemisphere_least_squares(2, normal, &e));
            for s in directions() {
                let s = Dir::from_unit(s);
                let (a, b) = (four.eval(s), linear.eval(s));
                assert!((a - b).abs() < 1e-11, "normal {v:?}, towards {s:?}: {a} against {b}");
            }
        }
    }

    #[test]
    fn four_and_six_have_the_known_errors() {
        let points = hemisphere_points(60);
        let [mut four, mut six, mut total] = [0.0; 3];
        for (sun, weight) in SphereQuadrature::of_degree(12).points() {
            let e = Zonal::clamped_cosine(24).towards(sun, 1.0);
            let h4 = HBasis4::from_irradiance_sh(&e, Rotation::IDENTITY);
            let h6 = HBasis6::from_irradiance_sh(&e, Rotation::IDENTITY);
            for (n, w) in &points {
                let truth = n.dot(sun).max(0.0);
                four += weight * w * (h4.eval(*n) - truth).powi(2);
                six += weight * w * (h6.eval(*n) - truth).powi(2);
                total += weight * w;
            }
        }
        for (what, found, expected) in [("four", four, 0.1079), ("six", six, 0.0619)] {
            let found = f64::sqrt(found / total);
            assert!((found - expected).abs() < 2e-4, "{what}: {found} against {expected}");
        }
    }
}
