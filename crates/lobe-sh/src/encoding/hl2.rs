//! The basis of radiosity normal mapping in Half-Life 2: three colors along perpendicular directions.

use core::f64::consts::PI;

#[cfg(not(feature = "std"))]
use num_traits::Float as _;

use crate::encoding::hemisphere::hemisphere_points;
use crate::expansion::Expansion;
use crate::rotation::Rotation;
use crate::scalar::Coefficient;
use crate::scalar::weighted_sum;
use crate::sphere::Dir;

/// The weights of the colors of [`Hl2`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
pub enum Hl2Weights {
    /// The squares of the cosines: colors are irradiances, a constant is kept, nothing is negative.
    Squared,
    /// The cosines themselves: the least-squares fit of a linear function of the normal without a constant.
    Linear,
}

/// Irradiance of the normals on one side of a surface as three colors.
///
/// ```text
///   b_1 = (-1/√6, -1/√2, 1/√3)        b_2 = (-1/√6, 1/√2, 1/√3)        b_3 = (√(2/3), 0, 1/√3)
///
///   squared:  E(n) = Σ_i c_i w_i / Σ_i w_i      w_i = max(n'·b_i, 0)²        n' = R⁻¹ n
///   linear:   E(n) = Σ_i c_i n'·b_i
/// ```
///
/// `R` is the surface's [`frame`](Self::frame), `world_from_tangent`: it takes +z to the geometric normal. The three
/// directions are perpendicular to one another and 54.7° from it. The squared form is the published one, after
/// [Mitchell, McTaggart and Green 2006]. The linear form cannot represent a constant: `E = 1` becomes 3/2 along the
/// geometric normal and 0 at the horizon.
///
/// [Mitchell, McTaggart and Green 2006]: https://doi.org/10.1145/1185657.1185832
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Hl2<T = f32> {
    /// `c_1, c_2, c_3`.
    pub colors: [T; 3],
    /// Their weights.
    pub weights: Hl2Weights,
    /// `R`, which takes +z to the geometric normal.
    pub frame: Rotation,
}

impl<T: Coefficient> Hl2<T> {
    /// The squared form as published: each color is the irradiance towards its direction.
    #[must_use]
    pub fn from_directions(frame: Rotation, mut irradiance: impl FnMut(Dir) -> T) -> Self {
        let colors = basis().map(|b| irradiance(frame.rotate_dir(b)));
        Self { colors, weights: Hl2Weights::Squared, frame }
    }

    /// The linear form by least squares over the hemisphere.
    ///
    /// ```text
    ///   c_i = 3/(2π) ∫_{z > 0} E(R n') n'·b_i dn'
    /// ```
    #[must_use]
    pub fn linear(irradiance: &impl Expansion<T>, frame: Rotation) -> Self {
        let mut sums = [T::Wide::ZERO; 3];
        for (s, weight) in hemisphere_points(irradiance.order() + 1) {
            let e = irradiance.eval(frame.rotate_dir(s)).widen();
            for (sum, b) in sums.iter_mut().zip(basis()) {
                *sum += e.scale(1.5 / PI * weight * s.dot(b));
            }
        }
        Self { colors: sums.map(T::narrow), weights: Hl2Weights::Linear, frame }
    }

    /// The irradiance of a surface with normal `n`, given in the world, at most 90° from the geometric normal.
    ///
    /// The squared form is zero for a normal that faces away from all three directions.
    #[must_use]
    pub fn eval(&self, n: Dir) -> T {
        let n = self.frame.inverse().rotate_dir(n);
        let cosines = basis().map(|b| n.dot(b));
        let weights = match self.weights {
            Hl2Weights::Linear => cosines,
            Hl2Weights::Squared => {
                let squares = cosines.map(|t| t.max(0.0).powi(2));
                match squares.iter().sum::<f64>() {
                    0.0 => squares,
                    sum => squares.map(|w| w / sum),
                }
            }
        };
        T::narrow(weighted_sum(self.colors.into_iter().zip(weights)))
    }
}

/// `b_1, b_2, b_3` in the tangent frame.
fn basis() -> [Dir; 3] {
    let (z, back, side) = ((1.0_f64 / 3.0).sqrt(), (1.0_f64 / 6.0).sqrt(), 0.5_f64.sqrt());
    [[-back, -side, z], [-back, side, z], [2.0 * back, 0.0, z]].map(Dir::from_unit)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expansion::ShVec;
    use crate::rotation::rotation::tangent_frame;
    use crate::scalar::Rgb;
    use lobe_testkit::{Random, directions};

    #[test]
    fn the_three_directions_are_perpendicular_and_equally_steep() {
        for (i, a) in basis().into_iter().enumerate() {
            for (j, b) in basis().into_iter().enumerate() {
                let expected = f64::from(u8::from(i == j));
                assert!((a.dot(b) - expected).abs() < 1e-15, "{i} {j}: {}", a.dot(b));
            }
            assert!((a.z() - 1.0 / 3.0_f64.sqrt()).abs() < 1e-15, "height of {i}: {}", a.z());
        }
    }

    #[test]
    fn the_squared_form_keeps_a_constant_and_its_three_irradiances_and_is_not_negative() {
        let mut random = Random::new(1);
        for v in directions() {
            let frame = tangent_frame(Dir::from_unit(v));
            let flat = Hl2::from_directions(frame, |_| Rgb::new(PI, 1.0, 0.0));
            let values = [random.unit(), random.unit(), random.unit()];
            let mut next = values.into_iter();
            let any = Hl2::from_directions(frame, |_| next.next().unwrap());
            for (b, value) in basis().into_iter().zip(values) {
                let found = any.eval(frame.rotate_dir(b));
                assert!((found - value).abs() < 1e-14, "{v:?}: {found} against {value}");
            }
            for (s, _) in hemisphere_points(8) {
                let n = frame.rotate_dir(s);
                let e = flat.eval(n);
                assert!((e.r - PI).abs() < 1e-14 && (e.g - 1.0).abs() < 1e-14 && e.b == 0.0, "{v:?}: {e:?}");
                assert!(any.eval(n) >= 0.0, "{v:?} towards {n:?}: {}", any.eval(n));
            }
        }
    }

    #[test]
    fn the_linear_form_keeps_linear_functions_and_misses_a_constant_as_stated() {
        let mut f = ShVec::<f64>::zero(2);
        (f[1], f[2], f[3]) = (0.3, -0.7, 0.2);
        for v in directions() {
            let frame = tangent_frame(Dir::from_unit(v));
            let found = Hl2::linear(&f, frame);
            let flat = Hl2::linear(&ShVec::constant(3, 1.0), frame);
            for s in directions() {
                let n = Dir::from_unit(s);
                let (a, b) = (found.eval(n), f.eval(n));
                assert!((a - b).abs() < 1e-13, "normal {v:?}, towards {s:?}: {a} against {b}");
                let (a, b) = (flat.eval(n), 1.5 * n.dot(Dir::from_unit(v)));
                assert!((a - b).abs() < 1e-13, "constant, normal {v:?}, towards {s:?}: {a} against {b}");
            }
        }
    }

    #[test]
    fn a_normal_that_faces_away_gets_nothing() {
        let flat = Hl2::from_directions(Rotation::IDENTITY, |_| 1.0);
        assert_eq!(flat.eval(-Dir::Z), 0.0, "from behind");
    }
}
