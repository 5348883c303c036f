//! A rotation of the sphere, and of functions on it.

#[cfg(not(feature = "std"))]
use num_traits::Float as _;

use crate::basis::index::order_of_slice;
use crate::by_type::{by_type, of_each_type};
use crate::error::ShError;
use crate::rotation::cos_sin::{CosSin, zyz_of};
use crate::rotation::low_bands::{FIRST_BAND_BY_TABLES, LOW_COUNT, rotate_low_bands};
use crate::rotation::zyz::rotate_bands_by_tables;
use crate::scalar::Coefficient;
use crate::sphere::Dir;

/// The tolerance of the entries of `RᵀR` against the identity: matrices printed with four decimals, which are up to `√3 1e-4` off, and long
/// products of `f32` matrices pass, a scale of 0.1 % or a shear does not.
const ORTHONORMAL_TOLERANCE: f64 = 2e-4;

/// The tolerance of the length of a quaternion: components quantized to eight bits, as glTF allows them, pass; a
/// quaternion that is not normalized does not.
const QUATERNION_TOLERANCE: f64 = 1e-2;

/// Steps of Newton's method towards the nearest rotation. The residual `e` becomes `3/4 e²`, so that two steps from
/// [`ORTHONORMAL_TOLERANCE`] reach rounding; one more is margin.
const NEWTON_STEPS: usize = 3;

/// A rotation about the origin. It rotates the function itself:
///
/// ```text
///   g = R f      g(s) = f(R⁻¹ s)      g(R s) = f(s)
/// ```
///
/// Coefficients of any order are rotated about z between fixed exchanges of y and z, without a matrix for each band;
/// bands 1 and 2 have closed forms. To apply one rotation to many expansions, see
/// [`RotationMatrices`](crate::rotation::RotationMatrices).
///
/// ```
/// use lobe_sh::{Dir, Expansion as _, Rotation, ShL2};
///
/// // A light towards +x, turned by +90° about +z, lies towards +y.
/// let light = ShL2::<f64>::impulse(Dir::X, 1.0);
/// let turned = light.rotated(&Rotation::from_axis_angle(Dir::Z, 90.0_f64.to_radians()));
/// assert!((turned.eval(Dir::Y) - light.eval(Dir::X)).abs() < 1e-15);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rotation {
    /// Row by row; orthonormal to rounding.
    matrix: [[f64; 3]; 3],
}

impl Rotation {
    /// The rotation that changes nothing.
    pub const IDENTITY: Self = Self { matrix: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] };

    /// From y-up data, as in glTF, to Lobe's z-up frame: `(x, y, z)` of Lobe is `(x, -z, y)` of glTF.
    pub const Z_UP_FROM_Y_UP: Self = Self { matrix: [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]] };

    /// The rotation of a matrix, given row by row, that multiplies column vectors.
    ///
    /// The nearest rotation is kept, found with Newton's method for the polar decomposition, `R ← R (3 - RᵀR) / 2`;
    /// that removes rounding. Exact matrices stay exact.
    ///
    /// # Errors
    /// If an entry is not finite, an entry of `RᵀR` is more than 2e-4 away from the identity, or the determinant
    /// is -1.
    pub fn from_matrix(matrix: [[f64; 3]; 3]) -> Result<Self, ShError> {
        Self::from_matrix_within(matrix, 0.0)
    }

    /// [`Rotation::from_matrix`], keeping a matrix as it is whose entries of `RᵀR` are within `rounding` of the
    /// identity.
    pub(crate) fn from_matrix_within(matrix: [[f64; 3]; 3], rounding: f64) -> Result<Self, ShError> {
        if !matrix.iter().flatten().all(|c| c.is_finite()) {
            return Err(not_finite());
        }
        let residual = orthonormality_residual(&matrix);
        if residual.is_nan() || residual > ORTHONORMAL_TOLERANCE {
            return Err(ShError::Options(format!(
                "expected a rotation matrix, found one that scales or shears (RᵀR is {residual:.3e} off the identity)"
            )));
        }
        let determinant = determinant(&matrix);
        if determinant < 0.0 {
            return Err(ShError::Mirror { determinant });
        }
        Ok(Self { matrix: if residual < rounding { matrix } else { nearest_orthonormal(matrix) } })
    }

    /// The rotation of the quaternion `[x, y, z, w]`, `w` its real part; `q` and `-q` are the same rotation.
    ///
    /// # Errors
    /// If a component is not finite, or the length is more than 1 % away from 1.
    pub fn from_quaternion(q: [f64; 4]) -> Result<Self, ShError> {
        if !q.iter().all(|c| c.is_finite()) {
            return Err(not_finite());
        }
        let length = q.iter().fold(0.0_f64, |length, c| length.hypot(*c));
        if (length - 1.0).abs() > QUATERNION_TOLERANCE {
            return Err(ShError::Options(format!("expected a unit quaternion, found length {length:.6}")));
        }
        let [x, y, z, w] = q.map(|c| c / length);
        let matrix = [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ];
        Ok(Self { matrix: nearest_orthonormal(matrix) })
    }

    /// The rotation by `angle` radians about `axis`, counter-clockwise seen against the axis (right-hand rule).
    ///
    /// ```text
    ///   R = cos a + (1 - cos a) n nᵀ + sin a [n]×        1 - cos a = 2 sin²(a/2)
    /// ```
    ///
    /// # Panics
    /// If the angle is not finite.
    #[must_use]
    pub fn from_axis_angle(axis: Dir, angle: f64) -> Self {
        assert!(angle.is_finite(), "an angle must be finite, not {angle}");
        let (sin, cos) = angle.sin_cos();
        let versine = 2.0 * (0.5 * angle).sin().powi(2);
        let [x, y, z] = axis.to_array();
        let matrix = [
            [cos + versine * x * x, versine * x * y - sin * z, versine * x * z + sin * y],
            [versine * x * y + sin * z, cos + versine * y * y, versine * y * z - sin * x],
            [versine * x * z - sin * y, versine * y * z + sin * x, cos + versine * z * z],
        ];
        Self { matrix: nearest_orthonormal(matrix) }
    }

    /// The rotation by `gamma` about z, then by `beta` about y, then by `alpha` about z, all about fixed axes and in
    /// radians: `R = R_z(α) R_y(β) R_z(γ)`. It takes +z to `(θ, φ) = (β, α)`.
    ///
    /// # Panics
    /// If an angle is not finite.
    #[must_use]
    pub fn from_euler_zyz(alpha: f64, beta: f64, gamma: f64) -> Self {
        let [about_alpha, about_gamma] = [alpha, gamma].map(|angle| Self::from_axis_angle(Dir::Z, angle));
        about_gamma.then(Self::from_axis_angle(Dir::Y, beta)).then(about_alpha)
    }

    /// The attitude of a vehicle that looks along +x with its left towards +y: `R = R_z(yaw) R_y(pitch) R_x(roll)`,
    /// in radians. Yaw turns left, pitch turns the nose **down**, roll sinks the right side: all three follow the
    /// right-hand rule about the axes of Lobe's frame.
    ///
    /// # Panics
    /// If an angle is not finite.
    #[must_use]
    pub fn from_yaw_pitch_roll(yaw: f64, pitch: f64, roll: f64) -> Self {
        Self::from_axis_angle(Dir::X, roll)
            .then(Self::from_axis_angle(Dir::Y, pitch))
            .then(Self::from_axis_angle(Dir::Z, yaw))
    }

    /// The matrix, row by row, that multiplies column vectors.
    #[must_use]
    pub const fn matrix(&self) -> [[f64; 3]; 3] {
        self.matrix
    }

    /// The unit quaternion `[x, y, z, w]` with `w >= 0`.
    ///
    /// The largest of the four components comes from a square root, the others from it, so that no angle loses
    /// digits (Shepperd 1978).
    #[must_use]
    pub fn to_quaternion(&self) -> [f64; 4] {
        let m = &self.matrix;
        let (xx, yy, zz) = (m[0][0], m[1][1], m[2][2]);
        // Rows of 4 q qᵀ, in the order x, y, z, w.
        let (xy, xz, yz) = (m[0][1] + m[1][0], m[0][2] + m[2][0], m[1][2] + m[2][1]);
        let (xw, yw, zw) = (m[2][1] - m[1][2], m[0][2] - m[2][0], m[1][0] - m[0][1]);
        let rows = [
            [1.0 + xx - yy - zz, xy, xz, xw],
            [xy, 1.0 - xx + yy - zz, yz, yw],
            [xz, yz, 1.0 - xx - yy + zz, zw],
            [xw, yw, zw, 1.0 + xx + yy + zz],
        ];
        let largest = (1..4).fold(0, |best, k| if rows[k][k] > rows[best][best] { k } else { best });
        let length = rows[largest].iter().fold(0.0_f64, |length, c| length.hypot(*c));
        let sign = if rows[largest][3] < 0.0 { -1.0 } else { 1.0 };
        rows[largest].map(|c| sign * c / length)
    }

    /// The angles `(α, β, γ)` of [`Rotation::from_euler_zyz`], `β` in `[0, π]`.
    ///
    /// At `β = 0` and `β = π` only `α + γ` or `α - γ` is determined. Their division then follows the rounding of the
    /// matrix (`α = 0` if it has none), and the three angles together still give the rotation to rounding.
    #[must_use]
    pub fn to_euler_zyz(&self) -> (f64, f64, f64) {
        let [alpha, beta, gamma] = self.zyz_cos_sin().map(|turn| turn.sin.atan2(turn.cos));
        (alpha, beta, gamma)
    }

    /// The inverse rotation.
    #[must_use]
    pub fn inverse(&self) -> Self {
        let m = &self.matrix;
        Self { matrix: [0, 1, 2].map(|i| [m[0][i], m[1][i], m[2][i]]) }
    }

    /// The rotation that does `self` first and `next` afterwards: its matrix is that of `next` times that of `self`.
    #[must_use]
    pub fn then(&self, next: Self) -> Self {
        Self { matrix: nearest_orthonormal(multiply(&next.matrix, &self.matrix)) }
    }

    /// The rotated direction `R s`.
    #[inline]
    #[must_use]
    pub fn rotate_dir(&self, s: Dir) -> Dir {
        let [x, y, z] = s.to_array();
        Dir::from_unit(self.matrix.map(|row| row[0] * x + row[1] * y + row[2] * z))
    }

    /// The coefficients of the rotated function, `dst = R src`. Any order; both slices have the same `n²` places.
    ///
    /// # Panics
    /// If the lengths differ or are no perfect square.
    pub fn apply_into<T: Coefficient>(&self, src: &[T], dst: &mut [T]) {
        assert_eq!(src.len(), dst.len(), "the rotated expansion has as many coefficients as the given one");
        by_type!(T: src; mut dst => apply_into(self, src, dst));
    }

    /// Rotates the function whose coefficients these are.
    ///
    /// Each band is rotated separately and in the same way at every order. By AVX2, bands 3 to 7 of `f32` more than a
    /// thousandth of a radian from the poles are turned in registers, to 6 roundings of the length of a band (test
    /// `rotations_in_single_precision_are_those_in_double_to_a_few_roundings`). The first call above order 64 makes
    /// constants of 1 MB for all calls to order [`MAX_ORDER`](crate::basis::MAX_ORDER). The error in `f64` is that of a few
    /// roundings: the tests `every_route_agrees_at_every_order` and `every_route_agrees_at_order_64` bound it by 1e-12.
    ///
    /// # Panics
    /// If the length is no perfect square.
    pub fn apply_in_place<T: Coefficient>(&self, coefficients: &mut [T]) {
        by_type!(T: mut coefficients => apply_in_place(self, coefficients));
    }

    /// [`zyz_of`] the matrix.
    pub(crate) fn zyz_cos_sin(&self) -> [CosSin; 3] {
        zyz_of(&self.matrix)
    }
}

of_each_type! {
    pub(super) fn apply_into(rotation: &Rotation, src: &[T], dst: &mut [T]) {
        let order = order_of_slice(src);
        rotate_low_bands(&rotation.matrix, src, dst);
        if order > FIRST_BAND_BY_TABLES {
            dst[LOW_COUNT..].copy_from_slice(&src[LOW_COUNT..]);
            rotate_bands_by_tables(rotation.zyz_cos_sin(), FIRST_BAND_BY_TABLES, dst);
        }
    }

    pub(super) fn apply_in_place(rotation: &Rotation, coefficients: &mut [T]) {
        let order = order_of_slice(coefficients);
        let mut low = [T::ZERO; LOW_COUNT];
        let low = &mut low[..coefficients.len().min(LOW_COUNT)];
        low.copy_from_slice(&coefficients[..low.len()]);
        rotate_low_bands(&rotation.matrix, low, coefficients);
        if order > FIRST_BAND_BY_TABLES {
            rotate_bands_by_tables(rotation.zyz_cos_sin(), FIRST_BAND_BY_TABLES, coefficients);
        }
    }
}

impl Default for Rotation {
    fn default() -> Self {
        Self::IDENTITY
    }
}

/// The rotation that takes +z to `normal`: a tangent frame, `world_from_tangent`. Continuous but for the poles, where
/// it turns about +z by any angle (none at exactly ±z, but for -z the half turn about +y).
///
/// ```text
///   R = R_z(φ) R_y(θ)
/// ```
#[must_use]
pub fn tangent_frame(normal: Dir) -> Rotation {
    Rotation::from_euler_zyz(normal.phi(), normal.theta(), 0.0)
}

fn not_finite() -> ShError {
    ShError::Options("expected a rotation, found a number that is not finite".into())
}

fn multiply(a: &[[f64; 3]; 3], b: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    a.map(|row| [0, 1, 2].map(|j| row[0] * b[0][j] + row[1] * b[1][j] + row[2] * b[2][j]))
}

fn determinant(m: &[[f64; 3]; 3]) -> f64 {
    let minor = |i: usize, j: usize| m[1][i] * m[2][j] - m[1][j] * m[2][i];
    m[0][0] * minor(1, 2) - m[0][1] * minor(0, 2) + m[0][2] * minor(0, 1)
}

/// `mᵀm`.
fn gram(m: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| m[0][i] * m[0][j] + m[1][i] * m[1][j] + m[2][i] * m[2][j]))
}

/// The largest entry of `|mᵀm - 1|`; NaN if one is.
fn orthonormality_residual(m: &[[f64; 3]; 3]) -> f64 {
    let gram = gram(m);
    let mut residual = 0.0_f64;
    for i in 0..3 {
        for j in 0..3 {
            let error = (gram[i][j] - if i == j { 1.0 } else { 0.0 }).abs();
            residual = if error.is_nan() || error > residual { error } else { residual };
        }
    }
    residual
}

/// The orthonormal matrix nearest to an almost orthonormal one.
fn nearest_orthonormal(mut m: [[f64; 3]; 3]) -> [[f64; 3]; 3] {
    for _ in 0..NEWTON_STEPS {
        let gram = gram(&m);
        let half = [0, 1, 2].map(|i| [0, 1, 2].map(|j| 0.5 * (if i == j { 3.0 } else { 0.0 } - gram[i][j])));
        m = multiply(&m, &half);
    }
    m
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A few roundings in each entry.
    const ROUNDING: f64 = 1e-15;

    fn distance(a: &[[f64; 3]; 3], b: &[[f64; 3]; 3]) -> f64 {
        a.iter().flatten().zip(b.iter().flatten()).fold(0.0, |worst, (a, b)| worst.max((a - b).abs()))
    }

    fn random(count: usize) -> impl Iterator<Item = Rotation> {
        let mut random = lobe_testkit::Random::new(31);
        (0..count).map(move |_| Rotation::from_quaternion(random.quaternion()).unwrap())
    }

    #[test]
    fn every_description_of_one_rotation_gives_one_matrix() {
        // 120° about (1, 1, 1): x to y to z to x.
        let expected = [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let quarter = core::f64::consts::FRAC_PI_2;
        let diagonal = Dir::new([1.0, 1.0, 1.0]).unwrap();
        for (name, rotation) in [
            ("matrix", Rotation::from_matrix(expected).unwrap()),
            ("quaternion", Rotation::from_quaternion([0.5; 4]).unwrap()),
            ("axis and angle", Rotation::from_axis_angle(diagonal, 2.0 * core::f64::consts::FRAC_PI_3)),
            ("Euler angles", Rotation::from_euler_zyz(0.0, quarter, quarter)),
            ("yaw, pitch, roll", Rotation::from_yaw_pitch_roll(quarter, 0.0, quarter)),
        ] {
            let error = distance(&rotation.matrix(), &expected);
            assert!(error < ROUNDING, "{name}: {:?}, off by {error}", rotation.matrix());
        }
    }

    #[test]
    fn yaw_turns_left_and_pitch_turns_down() {
        let nose = Rotation::from_yaw_pitch_roll(0.3, 0.0, 0.0).rotate_dir(Dir::X);
        assert!((nose.phi() - 0.3).abs() < ROUNDING, "yaw 0.3 leads to {nose:?}");
        let nose = Rotation::from_yaw_pitch_roll(0.0, 0.3, 0.0).rotate_dir(Dir::X);
        assert!((nose.z() + 0.3_f64.sin()).abs() < ROUNDING, "pitch 0.3 leads to {nose:?}");
        let right = Rotation::from_yaw_pitch_roll(0.0, 0.0, 0.3).rotate_dir(-Dir::Y);
        assert!((right.z() + 0.3_f64.sin()).abs() < ROUNDING, "roll 0.3 takes the right side to {right:?}");
    }

    #[test]
    fn quaternions_and_matrices_round_trip() {
        let half_turns = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.6, 0.0, -0.8, 0.0]];
        let half_turns = half_turns.map(|q| Rotation::from_quaternion(q).unwrap());
        for rotation in random(200).chain(half_turns) {
            let q = rotation.to_quaternion();
            assert!(q[3] >= 0.0, "{q:?}");
            let back = Rotation::from_quaternion(q).unwrap();
            let error = distance(&back.matrix(), &rotation.matrix());
            assert!(error < 2.0 * ROUNDING, "{q:?}: off by {error}");
        }
    }

    #[test]
    fn matrices_of_four_decimals_are_rotations_and_scaled_ones_are_none() {
        for rotation in random(500) {
            let printed = rotation.matrix().map(|row| row.map(|x| (1e4 * x).round() / 1e4));
            let found = Rotation::from_matrix(printed).unwrap();
            assert!(distance(&found.matrix(), &rotation.matrix()) < 2e-4, "{printed:?}");
            let scaled = rotation.matrix().map(|row| row.map(|x| 1.001 * x));
            assert!(Rotation::from_matrix(scaled).is_err(), "a thousandth larger");
        }
    }

    #[test]
    fn euler_angles_round_trip_at_gimbal_lock_too() {
        let pi = core::f64::consts::PI;
        for alpha in [-3.0, -1.0, 0.0, 0.7, pi] {
            for beta in [0.0, 1e-17, 1e-9, 1e-4, 1.0, pi - 1e-9, pi] {
                for gamma in [-2.0, 0.0, 1.9] {
                    let rotation = Rotation::from_euler_zyz(alpha, beta, gamma);
                    let (a, b, c) = rotation.to_euler_zyz();
                    let back = Rotation::from_euler_zyz(a, b, c);
                    let error = distance(&back.matrix(), &rotation.matrix());
                    assert!(
                        error < 2.0 * ROUNDING,
                        "({alpha}, {beta}, {gamma}) became ({a}, {b}, {c}): off by {error}"
                    );
                    let axis = rotation.rotate_dir(Dir::Z).angle_to(Dir::from_angles(beta, alpha));
                    assert!(axis < ROUNDING, "+z goes to (β, α), not {axis} away");
                }
            }
        }
    }

    #[test]
    fn then_does_the_first_first() {
        let (first, second) = (Rotation::from_axis_angle(Dir::X, 1.0), Rotation::from_axis_angle(Dir::Z, 0.4));
        for v in lobe_testkit::directions() {
            let s = Dir::from_unit(v);
            let (one, two) = (first.then(second).rotate_dir(s), second.rotate_dir(first.rotate_dir(s)));
            assert!(one.angle_to(two) < 1e-15, "towards {v:?}: {one:?} against {two:?}");
        }
    }

    #[test]
    fn long_products_stay_rotations() {
        let step = Rotation::from_axis_angle(Dir::new([1.0, 2.0, 3.0]).unwrap(), 1e-3);
        let product = (0..100_000).fold(Rotation::IDENTITY, |product, _| product.then(step));
        let residual = orthonormality_residual(&product.matrix());
        assert!(residual < ROUNDING, "after 100000 steps RᵀR is {residual} off the identity");
    }

    #[test]
    fn rounding_is_removed_from_matrices() {
        for rotation in random(20) {
            let rough = rotation.matrix().map(|row| row.map(|c| (c * 2e4).round() / 2e4));
            let cleaned = Rotation::from_matrix(rough).unwrap();
            let residual = orthonormality_residual(&cleaned.matrix());
            assert!(residual < ROUNDING, "RᵀR is {residual} off the identity");
            let moved = distance(&cleaned.matrix(), &rotation.matrix());
            assert!(moved < 5e-5, "rounding by 2.5e-5 moved an entry by {moved}");
        }
    }

    #[test]
    fn what_is_no_rotation_is_refused_with_what_was_found() {
        let refused = |m: [[f64; 3]; 3]| Rotation::from_matrix(m).unwrap_err().to_string();
        let cases = [
            ([[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]], "mirror (determinant -1.000000)"),
            ([[2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0]], "3.000e0 off the identity"),
            ([[1.0, 0.1, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], "1.000e-1 off the identity"),
            ([[0.0; 3]; 3], "1.000e0 off the identity"),
            ([[1e200; 3]; 3], "off the identity"),
            ([[f64::NAN, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], "not finite"),
        ];
        for (matrix, expected) in cases {
            let message = refused(matrix);
            assert!(message.contains(expected) && !message.contains('\n'), "{matrix:?}: {message:?}");
        }
        for (q, expected) in [
            ([0.0; 4], "length 0.000000"),
            ([0.0, 0.0, 1.0, 1.0], "length 1.414214"),
            ([0.0, f64::INFINITY, 0.0, 1.0], "not finite"),
        ] {
            let message = Rotation::from_quaternion(q).unwrap_err().to_string();
            assert!(message.contains(expected), "{q:?}: {message:?}");
        }
        let nearly = Rotation::from_quaternion([0.0, 0.0, 0.71, 0.71]).unwrap();
        let error = nearly.rotate_dir(Dir::X).angle_to(Dir::Y);
        assert!(error < ROUNDING, "a nearly unit quaternion is normalized, not {error} off");
    }

    #[test]
    fn y_up_becomes_z_up() {
        let up = Rotation::Z_UP_FROM_Y_UP.rotate_dir(Dir::Y);
        assert_eq!(up, Dir::Z, "up stays up");
        let s = Rotation::Z_UP_FROM_Y_UP.rotate_dir(Dir::from_unit([0.48, -0.6, 0.64]));
        assert_eq!(s.to_array(), [0.48, -0.64, -0.6], "(x, -z, y)");
        let back = Rotation::Z_UP_FROM_Y_UP.inverse().then(Rotation::Z_UP_FROM_Y_UP);
        assert_eq!(back, Rotation::IDENTITY, "there and back");
    }
}
