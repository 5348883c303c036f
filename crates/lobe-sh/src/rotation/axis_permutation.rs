//! Reflections along the axes and quarter turns about z, and with them the 48 symmetries of the cube.

use crate::basis::index::{coefficient_index, order_of_slice};
use crate::rotation::Rotation;
use crate::rotation::yz_exchange::exchange_yz_in_place;
use crate::scalar::Coefficient;
use crate::sphere::Dir;

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
                let c = &mut coefficients[coefficient_index(l, m)];
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
            let (minus, plus) = (coefficient_index(l, -(m as isize)), coefficient_index(l, m as isize));
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

/// A permutation of the axes with some of them reversed: a matrix with one ±1 in each row and column.
///
/// Like a rotation it moves the function: `g(s) = f(P⁻¹ s)`. Of the 48, 24 are rotations and 24 contain a reflection.
/// Those that keep the z axis only permute coefficients and change signs, and are exact; the others take one
/// multiplication by the fixed matrix that exchanges y and z.
///
/// ```
/// use lobe_sh::rotation::AxisPermutation;
/// use lobe_sh::{Dir, Expansion as _, ShL2};
///
/// // A light from above in a glTF file, where up is +y.
/// let light = ShL2::<f64>::impulse(Dir::Y, 1.0);
/// let here = light.permuted(&AxisPermutation::Z_UP_FROM_Y_UP);
/// assert!((here.eval(Dir::Z) - light.eval(Dir::Y)).abs() < 1e-14);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AxisPermutation {
    matrix: [[i8; 3]; 3],
}

impl AxisPermutation {
    /// Every axis stays.
    pub const IDENTITY: Self = Self { matrix: [[1, 0, 0], [0, 1, 0], [0, 0, 1]] };

    /// From y-up data, as in glTF, to Lobe's z-up frame: `(x, y, z)` of Lobe is `(x, -z, y)` of glTF.
    ///
    /// ```text
    ///   0' = 0     1' = 2    2' = -1     3' = 3     4' = 7     5' = -5
    ///   6' = -6/2 - √3/2 8     7' = -4     8' = -√3/2 6 + 8/2        (flat indices of bands 0 to 2)
    /// ```
    pub const Z_UP_FROM_Y_UP: Self = Self { matrix: [[1, 0, 0], [0, 0, -1], [0, 1, 0]] };

    /// From Lobe's z-up frame to y-up data, as in glTF: `(x, y, z)` of glTF is `(x, z, -y)` of Lobe.
    pub const Y_UP_FROM_Z_UP: Self = Self { matrix: [[1, 0, 0], [0, 0, 1], [0, -1, 0]] };

    /// The permutation of a matrix, given row by row, that multiplies column vectors; `None` unless each row and each
    /// column holds one 1 or -1 and two zeros.
    #[must_use]
    pub fn from_matrix(matrix: [[i8; 3]; 3]) -> Option<Self> {
        let is_unit = |line: [i8; 3]| line.iter().map(|c| c.unsigned_abs() as u16).sum::<u16>() == 1;
        let p = Self { matrix };
        let all_units = matrix.into_iter().chain(p.inverse().matrix).all(is_unit);
        all_units.then_some(p)
    }

    /// The mirror that reverses one axis.
    #[must_use]
    pub fn mirror(axis: Axis) -> Self {
        let mut matrix = Self::IDENTITY.matrix;
        let k = match axis {
            Axis::X => 0,
            Axis::Y => 1,
            Axis::Z => 2,
        };
        matrix[k][k] = -1;
        Self { matrix }
    }

    /// All 48 of them.
    pub fn all() -> impl Iterator<Item = Self> {
        let orders = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]];
        orders.into_iter().flat_map(|columns| {
            (0..8).map(move |signs| {
                let mut matrix = [[0; 3]; 3];
                for (row, column) in columns.into_iter().enumerate() {
                    matrix[row][column] = if signs >> row & 1 == 0 { 1 } else { -1 };
                }
                Self { matrix }
            })
        })
    }

    /// The matrix, row by row, that multiplies column vectors.
    #[must_use]
    pub const fn matrix(&self) -> [[i8; 3]; 3] {
        self.matrix
    }

    /// 1 for a rotation, -1 for one that mirrors.
    #[must_use]
    pub fn determinant(&self) -> i8 {
        let m = &self.matrix;
        let minor = |i: usize, j: usize| m[1][i] * m[2][j] - m[1][j] * m[2][i];
        m[0][0] * minor(1, 2) - m[0][1] * minor(0, 2) + m[0][2] * minor(0, 1)
    }

    /// The permutation as a rotation; `None` if it mirrors.
    #[must_use]
    pub fn rotation(&self) -> Option<Rotation> {
        Rotation::from_matrix(self.matrix.map(|row| row.map(f64::from))).ok()
    }

    /// The permutation that undoes this one.
    #[must_use]
    pub fn inverse(&self) -> Self {
        let m = &self.matrix;
        Self { matrix: [0, 1, 2].map(|i| [m[0][i], m[1][i], m[2][i]]) }
    }

    /// The permutation that does `self` first and `next` afterwards.
    #[must_use]
    pub fn then(&self, next: Self) -> Self {
        let m = &self.matrix;
        Self { matrix: next.matrix.map(|row| [0, 1, 2].map(|j| (0..3).map(|k| row[k] * m[k][j]).sum())) }
    }

    /// The moved direction `P s`.
    #[must_use]
    pub fn apply_to_dir(&self, s: Dir) -> Dir {
        let v = s.to_array();
        Dir::from_unit(self.matrix.map(|row| (0..3).map(|k| f64::from(row[k]) * v[k]).sum()))
    }

    /// Moves the function whose coefficients these are.
    ///
    /// # Panics
    /// If the length is no perfect square.
    //
    // If P keeps the z axis, it consists of mirrors and a quarter turn. Otherwise, P e_z = ±e_x or ±e_y = A e_y for a
    // quarter turn A about z, and with the exchange J of y and z, B = J A⁻¹ P keeps +z: P = A J B.
    pub fn apply_in_place<T: Coefficient>(&self, coefficients: &mut [T]) {
        if self.matrix[2][2] != 0 {
            self.apply_keeping_z(coefficients);
            return;
        }
        const EXCHANGE_YZ: AxisPermutation = AxisPermutation { matrix: [[1, 0, 0], [0, 0, 1], [0, 1, 0]] };
        let quarters = match (self.matrix[0][2], self.matrix[1][2]) {
            (0, 1) => 0,
            (-1, _) => 1,
            (0, _) => 2,
            _ => 3,
        };
        let a = (0..quarters).fold(Self::IDENTITY, |a, _| a.then(Self::QUARTER_TURN));
        self.then(a.inverse()).then(EXCHANGE_YZ).apply_keeping_z(coefficients);
        exchange_yz_in_place(coefficients);
        quarter_turn_in_place(coefficients, quarters);
    }

    /// By +90° about +z.
    const QUARTER_TURN: Self = Self { matrix: [[0, -1, 0], [1, 0, 0], [0, 0, 1]] };

    /// [`AxisPermutation::apply_in_place`] for one that takes +z to ±z.
    fn apply_keeping_z<T: Coefficient>(&self, coefficients: &mut [T]) {
        let [[xx, xy, _], [yx, yy, _], [_, _, zz]] = self.matrix;
        if zz < 0 {
            mirror_in_place(coefficients, Axis::Z);
        }
        // Mirroring y first leaves a proper rotation of the plane, which takes +x to (xx, yx).
        if xx * yy - xy * yx < 0 {
            mirror_in_place(coefficients, Axis::Y);
        }
        let quarters = match (xx, yx) {
            (1, _) => 0,
            (0, 1) => 1,
            (-1, _) => 2,
            _ => 3,
        };
        quarter_turn_in_place(coefficients, quarters);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expansion::Expansion as _;
    use crate::expansion::ShVec;

    const ORDER: usize = 8;

    fn random() -> ShVec<f64> {
        ShVec::from_vec(lobe_testkit::Random::new(21).signed_vec(ORDER * ORDER)).unwrap()
    }

    #[test]
    fn all_forty_eight_move_the_function() {
        let f = random();
        let mut seen = Vec::new();
        for p in AxisPermutation::all() {
            assert!(!seen.contains(&p), "{p:?} occurs twice");
            seen.push(p);
            let g = f.permuted(&p);
            for v in lobe_testkit::directions() {
                let s = Dir::from_unit(v);
                let (got, expected) = (g.eval(p.apply_to_dir(s)), f.eval(s));
                assert!((got - expected).abs() < 1e-12, "{p:?}, towards {v:?}: {got} against {expected}");
            }
        }
        assert_eq!(seen.len(), 48, "the symmetries of the cube");
    }

    #[test]
    fn the_proper_ones_are_rotations() {
        let f = random();
        let mut rotations = 0;
        for p in AxisPermutation::all() {
            let Some(rotation) = p.rotation() else {
                assert_eq!(p.determinant(), -1, "{p:?} is no rotation");
                continue;
            };
            rotations += 1;
            assert_eq!(p.determinant(), 1, "{p:?} is a rotation");
            let (a, b) = (f.permuted(&p), f.rotated(&rotation));
            let worst = (&a - &b).coefficients().iter().fold(0.0_f64, |worst, c| worst.max(c.abs()));
            assert!(worst < 1e-13, "{p:?}: permutation and rotation differ by {worst}");
        }
        assert_eq!(rotations, 24, "half of them");
    }

    #[test]
    fn permutations_that_keep_the_z_axis_are_exact() {
        let f = random();
        for p in AxisPermutation::all().filter(|p| p.matrix()[2][2] != 0) {
            assert_eq!(f.permuted(&p).permuted(&p.inverse()), f, "{p:?} and back");
            let sorted = |f: &ShVec<f64>| {
                let mut sizes: Vec<f64> = f.coefficients().iter().map(|c| c.abs()).collect();
                sizes.sort_by(f64::total_cmp);
                sizes
            };
            assert_eq!(sorted(&f.permuted(&p)), sorted(&f), "{p:?} only moves coefficients and changes signs");
        }
    }

    #[test]
    fn permutations_compose_and_invert() {
        for p in AxisPermutation::all() {
            assert_eq!(p.then(p.inverse()), AxisPermutation::IDENTITY, "{p:?}");
            for q in AxisPermutation::all() {
                let s = Dir::from_unit([0.48, -0.6, 0.64]);
                let (a, b) = (p.then(q).apply_to_dir(s), q.apply_to_dir(p.apply_to_dir(s)));
                assert_eq!(a, b, "{p:?} then {q:?}");
            }
        }
    }

    #[test]
    fn y_up_becomes_z_up_by_the_closed_formula() {
        let f = random();
        let half_root_3 = 0.75_f64.sqrt();
        // Without the Condon-Shortley phase: 0, -2, 1, 3, -7, -5, -6/2 - √3/2 8, 4, -√3/2 6 + 8/2.
        let expected = [
            f[0],
            f[2],
            -f[1],
            f[3],
            f[7],
            -f[5],
            -0.5 * f[6] - half_root_3 * f[8],
            -f[4],
            -half_root_3 * f[6] + 0.5 * f[8],
        ];
        let by_permutation = f.permuted(&AxisPermutation::Z_UP_FROM_Y_UP);
        let by_rotation = f.rotated(&Rotation::Z_UP_FROM_Y_UP);
        for i in 0..9 {
            for (route, g) in [("permutation", &by_permutation), ("rotation", &by_rotation)] {
                assert!((g[i] - expected[i]).abs() < 1e-15, "{route}, {i}: {} against {}", g[i], expected[i]);
            }
        }
        let back = by_permutation.permuted(&AxisPermutation::Y_UP_FROM_Z_UP);
        let worst = (&back - &f).coefficients().iter().fold(0.0_f64, |worst, c| worst.max(c.abs()));
        assert!(worst < 1e-14, "there and back changes {worst}");
    }

    #[test]
    fn other_matrices_are_no_permutations() {
        for matrix in [[[1, 0, 0], [1, 0, 0], [0, 0, 1]], [[0; 3]; 3], [[2, 0, 0], [0, 1, 0], [0, 0, 1]]] {
            assert_eq!(AxisPermutation::from_matrix(matrix), None, "{matrix:?}");
        }
        let p = AxisPermutation::from_matrix([[0, -1, 0], [0, 0, 1], [1, 0, 0]]);
        assert_eq!(p.map(|p| p.determinant()), Some(-1), "a permutation that mirrors");
        assert_eq!(AxisPermutation::mirror(Axis::Y).matrix()[1], [0, -1, 0], "mirror of y");
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
