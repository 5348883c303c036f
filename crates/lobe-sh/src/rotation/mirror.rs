//! Reflections along the axes and quarter turns about z: they only permute coefficients and change signs, exactly.

use crate::Coefficient;
use crate::basis::index::{index, order_of_slice};

/// One of the three coordinate axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
pub enum Axis {
    /// x.
    X,
    /// y.
    Y,
    /// z, up.
    Z,
}

/// Mirrors the function along one axis, for example `g(x, y, z) = f(-x, y, z)` for [`Axis::X`].
///
/// ```text
///   f_l^m is multiplied by      X: (-1)^m for m >= 0, -(-1)^m for m < 0
///                               Y: 1 for m >= 0, -1 for m < 0
///                               Z: (-1)^(l+m)
/// ```
///
/// No rotation does this: a rotation has determinant +1.
///
/// # Panics
/// If the length is no perfect square.
pub fn mirror_in_place<T: Coefficient>(coefficients: &mut [T], axis: Axis) {
    for l in 0..order_of_slice(coefficients) {
        for m in -(l as isize)..=l as isize {
            let odd = match axis {
                Axis::X => (m < 0) != (m % 2 != 0),
                Axis::Y => m < 0,
                Axis::Z => (l as isize + m) % 2 != 0,
            };
            if odd {
                let c = &mut coefficients[index(l, m)];
                *c = -*c;
            }
        }
    }
}

/// Turns the function by `quarters` times +90° about +z; a light towards +x then lies towards +y.
///
/// ```text
///   f_-m' =  cos ma f_-m + sin ma f_m        f_m' = -sin ma f_-m + cos ma f_m        a = quarters · 90°
/// ```
///
/// # Panics
/// If the length is no perfect square.
pub fn quarter_turn_in_place<T: Coefficient>(coefficients: &mut [T], quarters: i32) {
    let quarters = quarters.rem_euclid(4) as usize;
    for l in 0..order_of_slice(coefficients) {
        for m in 1..=l {
            let (minus, plus) = (index(l, -(m as isize)), index(l, m as isize));
            let (f, g) = (coefficients[minus], coefficients[plus]);
            let (f, g) = match m * quarters % 4 {
                0 => (f, g),
                1 => (g, -f),
                2 => (-f, -g),
                _ => (-g, f),
            };
            coefficients[minus] = f;
            coefficients[plus] = g;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Dir, Expansion as _, ShVec};

    const ORDER: usize = 9;

    fn random() -> ShVec<f64> {
        ShVec::from_vec(lobe_testkit::Random::new(11).signed_vec(ORDER * ORDER)).unwrap()
    }

    #[test]
    fn mirrors_negate_one_component_of_the_direction() {
        let f = random();
        for (axis, k) in [(Axis::X, 0), (Axis::Y, 1), (Axis::Z, 2)] {
            let mut g = f.clone();
            mirror_in_place(g.coefficients_mut(), axis);
            for v in lobe_testkit::directions() {
                let mut mirrored = v;
                mirrored[k] = -v[k];
                let (got, expected) = (g.eval(Dir::from_unit(v)), f.eval(Dir::from_unit(mirrored)));
                assert!((got - expected).abs() < 1e-12, "{axis:?}, towards {v:?}: {got} against {expected}");
            }
        }
    }

    #[test]
    fn quarter_turns_take_x_to_y() {
        let f = random();
        for quarters in -5..=5 {
            let mut g = f.clone();
            quarter_turn_in_place(g.coefficients_mut(), quarters);
            for [x, y, z] in lobe_testkit::directions() {
                let mut turned = [x, y, z];
                for _ in 0..quarters.rem_euclid(4) {
                    turned = [-turned[1], turned[0], turned[2]];
                }
                let (got, expected) = (g.eval(Dir::from_unit(turned)), f.eval(Dir::from_unit([x, y, z])));
                assert!((got - expected).abs() < 1e-12, "{quarters} quarters: {got} against {expected}");
            }
        }
    }

    #[test]
    fn mirroring_twice_and_four_quarters_change_no_bit() {
        let f = random();
        let mut g = f.clone();
        for axis in [Axis::X, Axis::Y, Axis::Z, Axis::Z, Axis::Y, Axis::X] {
            mirror_in_place(g.coefficients_mut(), axis);
        }
        for _ in 0..4 {
            quarter_turn_in_place(g.coefficients_mut(), 1);
        }
        assert_eq!(f, g, "mirrors and quarter turns are exact");
    }
}
