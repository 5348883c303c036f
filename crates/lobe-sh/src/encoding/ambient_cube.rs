//! The ambient cube: six colors, one for each axis direction.

use core::f64::consts::PI;

use crate::expansion::sh_vec::widened;
use crate::expansion::{Expansion, Sh, Zonal};
use crate::prelude::*;
use crate::scalar::weighted_sum;
use crate::scalar::{Coefficient, Real};
use crate::solver::matrix::Matrix;
use crate::solver::singular_values::SingularValues;
use crate::sphere::Dir;

/// The axes of the faces, in their order.
pub(crate) const AXES: [[f64; 3]; 6] =
    [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]];

/// Singular values of the normal equations below this fraction of the largest count as zero; for samples spread evenly
/// over the sphere the ratio is 1/2.5.
const RANK_TOLERANCE: f64 = 1e-12;

/// Irradiance as six colors, mixed by the squares of the normal's components.
///
/// ```text
///   E(n) = Σ_f c_f V_f(n)        V_f(n) = max(n·a_f, 0)²        a_f = +x, -x, +y, -y, +z, -z
/// ```
///
/// Three faces contribute to any normal, and their weights sum to 1: a constant is kept exactly, and colors that are
/// not negative give no negative irradiance. The cube is not rotation invariant: the products `xy`, `yz`, `xz` are
/// lost, so the error for one directional light depends on its direction. The RMS error of the irradiance of a light
/// that gives 1 to a surface facing it is 0.081 for a light on an axis and 0.161 for one on a diagonal of space; within
/// three bands, for light of which they leave 1 (`16π/17`), 0.0679 and 0.1480 (test
/// `the_cube_wobbles_under_rotation_by_a_factor_of_two`). After McTaggart 2004.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct AmbientCube<T = f32> {
    /// `c_f`, in the order +x, -x, +y, -y, +z, -z.
    pub faces: [T; 6],
}

impl<T: Coefficient> AmbientCube<T> {
    /// The cube as published: each face has the irradiance towards its axis.
    #[must_use]
    pub fn from_axes(mut irradiance: impl FnMut(Dir) -> T) -> Self {
        Self { faces: AXES.map(|a| irradiance(Dir::from_unit(a))) }
    }

    /// The cube nearest to a function given by its expansion, in the mean square over the sphere.
    ///
    /// ```text
    ///   c = G⁻¹ b        b_f = ∫ V_f E ds
    ///   G   (∫ V_f V_g): same 2π/5,    opposite 0,       perpendicular π/15
    ///   G⁻¹            : same 11/(4π), opposite 1/(4π),  perpendicular -3/(8π)
    /// ```
    ///
    /// `V_f` has no even band above 2 and irradiance no odd one above 1, so that the first three bands of an
    /// irradiance decide (test `three_bands_of_irradiance_decide_the_cube`). For them this is [Sloan 2008] A9.
    ///
    /// [Sloan 2008]: https://www.ppsloan.org/publications/StupidSH36.pdf
    #[must_use]
    pub fn from_irradiance_sh(irradiance: &impl Expansion<T>) -> Self {
        let b = widened(irradiance).convolved(&squared_cosine(irradiance.order()));
        let b = AXES.map(|a| b.eval(Dir::from_unit(a)));
        let all = b.into_iter().fold(T::Wide::ZERO, |sum, b| sum + b);
        let face = |f: usize| {
            let (same, opposite) = (b[f], b[f ^ 1]);
            let perpendicular = all - same - opposite;
            let sum = same.scale(11.0) + opposite - perpendicular.scale(1.5);
            T::narrow(sum.scale(0.25 / PI))
        };
        Self { faces: [0, 1, 2, 3, 4, 5].map(face) }
    }

    /// The cube nearest to weighted samples `(s_k, E_k, w_k)`, finite `w_k >= 0`.
    ///
    /// ```text
    ///   minimize Σ_k w_k (Σ_f c_f V_f(s_k) - E_k)²
    /// ```
    ///
    /// If the samples do not determine the faces, the best cube of least norm is taken. Without samples all faces are
    /// zero. A value that is not finite makes its channel NaN.
    #[must_use]
    pub fn fit(samples: impl IntoIterator<Item = (Dir, T, f64)>) -> Self {
        let mut normal = [[0.0; 6]; 6];
        let mut right = vec![[0.0; 6]; T::CHANNELS];
        for (s, value, weight) in samples {
            let v = weights(s);
            for (row, a) in normal.iter_mut().zip(v) {
                row.iter_mut().zip(v).for_each(|(entry, b)| *entry += a * b * weight);
            }
            for (c, right) in right.iter_mut().enumerate() {
                let scale = weight * value.widen().channel(c);
                right.iter_mut().zip(v).for_each(|(right, v)| *right += v * scale);
            }
        }
        let solved = solutions(&normal, &right);
        Self { faces: [0, 1, 2, 3, 4, 5].map(|f| T::from_channels(|c| T::Scalar::from_f64(solved[c][f]))) }
    }

    /// The irradiance of a surface with normal `n`.
    #[must_use]
    pub fn eval(&self, n: Dir) -> T {
        T::narrow(weighted_sum(self.faces.into_iter().zip(weights(n))))
    }

    /// The expansion of order 3 that is nearest to the cube, its projection. Bands 3, 5, 7 .. of the cube are left out.
    ///
    /// ```text
    ///   E_00 = √π/3 Σ_f c_f        E_1 = ±√(3π)/4 per face        E_20 = -√(5π)/15 (x, y), 2√(5π)/15 (z)
    ///   E_22 = ±√(15π)/15 (x, y)   others 0
    /// ```
    #[must_use]
    pub fn to_sh(&self) -> Sh<9, T> {
        let v = squared_cosine(3);
        let mut sum = Sh::<9, T::Wide>::zero();
        for (face, axis) in self.faces.iter().zip(AXES) {
            let mut lobe = [T::Wide::ZERO; 9];
            v.towards_into(Dir::from_unit(axis), face.widen(), &mut lobe);
            sum += Sh::<9, T::Wide>::from(lobe);
        }
        sum.map(T::narrow)
    }
}

/// The faces of [`AmbientCube::fit`], one right-hand side of the normal equations after the other; NaN where one is not
/// finite. Not generic, so that the solver is compiled in this crate alone.
fn solutions(normal: &[[f64; 6]; 6], right: &[[f64; 6]]) -> Vec<[f64; 6]> {
    let svd = SingularValues::new(Matrix::from_fn(6, 6, |i, j| normal[i][j]));
    let threshold = RANK_TOLERANCE * svd.largest();
    let solve = |right: &[f64; 6]| {
        if !right.iter().all(|x| x.is_finite()) {
            return [f64::NAN; 6];
        }
        let solution = svd.solve(right, threshold);
        [0, 1, 2, 3, 4, 5].map(|f| solution[f])
    };
    right.iter().map(solve).collect()
}

/// `V_f(n)` of every face.
fn weights(n: Dir) -> [f64; 6] {
    AXES.map(|a| n.dot(Dir::from_unit(a)).max(0.0).powi(2))
}

/// `max(cos θ, 0)²` to an order.
fn squared_cosine(order: usize) -> Zonal {
    Zonal::project(order, &[0.0], order / 2 + 2, |t| t.max(0.0).powi(2))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expansion::ShVec;
    use crate::light::normalization::directional_normalization;
    use crate::rotation::Rotation;
    use crate::scalar::Rgb;
    use crate::sphere::quadrature::SphereQuadrature;
    use lobe_testkit::{Random, directions};

    fn random_cube(seed: u64) -> AmbientCube<f64> {
        let values = Random::new(seed).signed_vec(6);
        AmbientCube { faces: core::array::from_fn(|f| values[f]) }
    }

    fn assert_same(found: &AmbientCube<f64>, expected: &AmbientCube<f64>, tolerance: f64, what: &str) {
        for f in 0..6 {
            let (a, b) = (found.faces[f], expected.faces[f]);
            assert!((a - b).abs() < tolerance, "{what}, face {f}: {a} against {b}");
        }
    }

    #[test]
    fn a_constant_is_kept_by_every_route() {
        let flat = Rgb::new(1.0_f64, 0.5, 2.0);
        let samples = directions().into_iter().map(|v| (Dir::from_unit(v), flat, 1.0));
        for (what, cube) in [
            ("axes", AmbientCube::from_axes(|_| flat)),
            ("expansion", AmbientCube::from_irradiance_sh(&ShVec::constant(5, flat))),
            ("samples", AmbientCube::fit(samples)),
        ] {
            for v in directions() {
                let e = cube.eval(Dir::from_unit(v));
                let error = (0..3).map(|c| (e.channel(c) - flat.channel(c)).abs()).fold(0.0, f64::max);
                assert!(error < 1e-13, "{what}, towards {v:?}: {e:?}");
            }
        }
    }

    #[test]
    fn cubes_come_back_from_samples_and_from_enough_bands() {
        let cube = random_cube(1);
        let samples = directions().into_iter().enumerate().map(|(k, v)| {
            let s = Dir::from_unit(v);
            (s, cube.eval(s), 0.5 + k as f64)
        });
        assert_same(&AmbientCube::fit(samples), &cube, 1e-12, "samples");
        let published = AmbientCube::from_axes(|s| cube.eval(s));
        assert_same(&published, &cube, 1e-15, "axes");
        // Every band of V_f is needed: the expansion converges with the order to the power -3.
        let mut all_bands = ShVec::zero(40);
        for (face, axis) in cube.faces.iter().zip(AXES) {
            all_bands += &squared_cosine(40).towards(Dir::from_unit(axis), *face);
        }
        assert_same(&AmbientCube::from_irradiance_sh(&all_bands), &cube, 1e-4, "order 40");
    }

    #[test]
    fn the_matrices_are_those_of_sloan_2008() {
        let unit = |i: usize| {
            let mut f = ShVec::zero(3);
            f[i] = 1.0;
            AmbientCube::from_irradiance_sh(&f).faces
        };
        let (dc, linear) = (0.5 / PI.sqrt(), 5.0 * 3.0_f64.sqrt() / (8.0 * PI.sqrt()));
        let (z2, xy2) = (5.0_f64.sqrt() / (4.0 * PI.sqrt()), 15.0_f64.sqrt() / (4.0 * PI.sqrt()));
        let expected = [
            [dc; 6],
            [0.0, 0.0, -linear, linear, 0.0, 0.0],
            [0.0, 0.0, 0.0, 0.0, linear, -linear],
            [-linear, linear, 0.0, 0.0, 0.0, 0.0],
            [0.0; 6],
            [0.0; 6],
            [-z2, -z2, -z2, -z2, 2.0 * z2, 2.0 * z2],
            [0.0; 6],
            [xy2, xy2, -xy2, -xy2, 0.0, 0.0],
        ];
        for (i, expected) in expected.into_iter().enumerate() {
            for (f, (a, b)) in unit(i).into_iter().zip(expected).enumerate() {
                assert!((a - b).abs() < 1e-14, "coefficient {i} to face {f}: {a} against {b}");
            }
        }
        let root = |x: f64| (x * PI).sqrt();
        for (f, sign) in [(0, 1.0), (1, -1.0)] {
            let mut cube = AmbientCube { faces: [0.0; 6] };
            cube.faces[f] = 1.0;
            let (x2, z2) = (root(15.0) / 15.0, -root(5.0) / 15.0);
            let expected = [root(1.0) / 3.0, 0.0, 0.0, -sign * root(3.0) / 4.0, 0.0, 0.0, z2, 0.0, x2];
            for (i, (a, b)) in cube.to_sh().to_array().into_iter().zip(expected).enumerate() {
                assert!((a - b).abs() < 1e-14, "face {f} to coefficient {i}: {a} against {b}");
            }
        }
    }

    #[test]
    fn three_bands_of_irradiance_decide_the_cube() {
        let sun = Dir::from_angles(1.1, 0.7);
        let exact = |order| Zonal::clamped_cosine(order).towards(sun, 1.0);
        let three = AmbientCube::from_irradiance_sh(&exact(3));
        assert_same(&AmbientCube::from_irradiance_sh(&exact(12)), &three, 1e-13, "order 12 against 3");
        let rule = SphereQuadrature::of_degree(400);
        let sampled = AmbientCube::fit(rule.points().map(|(s, w)| (s, s.dot(sun).max(0.0), w)));
        // The kink of the cosine leaves the rule an error of its degree to the power -2.
        assert_same(&sampled, &three, 1e-4, "samples of the exact irradiance");
    }

    #[test]
    fn the_cube_wobbles_under_rotation_by_a_factor_of_two() {
        let rule = SphereQuadrature::of_degree(120);
        let rms = |sun: Dir| {
            let cube = AmbientCube::from_irradiance_sh(&Zonal::clamped_cosine(3).towards(sun, 1.0));
            (rule.integrate(|n| (cube.eval(n) - n.dot(sun).max(0.0)).powi(2)) / (4.0 * PI)).sqrt()
        };
        for (sun, expected) in [([1.0, 0.0, 0.0], 0.0811), ([1.0, 1.0, 0.0], 0.1455), ([1.0, 1.0, 1.0], 0.1614)] {
            let found = rms(Dir::new(sun).unwrap());
            assert!((found - expected).abs() < 5e-4, "light from {sun:?}: {found} against {expected}");
        }
        let unit = directional_normalization(3);
        let within_three_bands = |sun: Dir| {
            let e = ShVec::impulse(3, sun, unit / PI).convolved(&Zonal::clamped_cosine(3));
            let cube = AmbientCube::from_irradiance_sh(&e);
            (rule.integrate(|n| (cube.eval(n) - e.eval(n)).powi(2)) / (4.0 * PI)).sqrt()
        };
        for (sun, expected) in [([0.0, 0.0, -1.0], 0.06793), ([1.0, 1.0, -1.0], 0.14804)] {
            let found = within_three_bands(Dir::new(sun).unwrap());
            assert!((found - expected).abs() < 1e-4, "three bands of {sun:?}: {found} against {expected}");
        }
        let wobble = |axis: Dir| {
            let all = (0..24).map(|k| Rotation::from_axis_angle(axis, f64::from(k) * PI / 12.0).rotate_dir(Dir::X));
            let errors: Vec<f64> = all.map(rms).collect();
            errors.iter().copied().fold(0.0, f64::max) / errors.iter().copied().fold(f64::INFINITY, f64::min)
        };
        let found = wobble(Dir::Z);
        assert!((found - 0.1455 / 0.0811).abs() < 0.01, "turned about z, the error changes by a factor of {found}");
    }

    #[test]
    fn degenerate_samples_have_defined_cubes() {
        assert_eq!(AmbientCube::<f64>::fit([]), AmbientCube { faces: [0.0; 6] }, "no samples");
        let one = AmbientCube::fit([(Dir::Z, 3.0, 1.0)]);
        assert_same(&one, &AmbientCube { faces: [0.0, 0.0, 0.0, 0.0, 3.0, 0.0] }, 1e-14, "one sample");
        let samples = directions().into_iter().map(|v| (Dir::from_unit(v), Rgb::new(f64::NAN, 1.0, 0.0), 1.0));
        let spoiled = AmbientCube::fit(samples).eval(Dir::Y);
        assert!(spoiled.r.is_nan() && (spoiled.g - 1.0).abs() < 1e-12 && spoiled.b == 0.0, "{spoiled:?}");
        assert_eq!(AmbientCube::from_irradiance_sh(&ShVec::<f64>::zero(0)).faces, [0.0; 6], "order 0");
    }
}
