//! Places: transforms from an own frame to the scene.

use glam::{DMat3, DMat4, DQuat, DVec3};

use crate::scene::transform::unit;
use crate::scene::up::{Up, z_up_from_y_up};

/// The place of a frame in a posed scene, such as that of a rigid entity or of a joint: an affine map from points of the
/// frame, z up, to points of the scene, which count from [`Scene::origin`](crate::Scene::origin).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    matrix: DMat4,
}

/// A place that only moves, turns and scales by one number: a point p of the frame is at `t + s R p`.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
#[non_exhaustive]
pub struct Similarity {
    /// `t`.
    pub translation: [f64; 3],
    /// R as a unit quaternion x, y, z, w.
    pub rotation: [f64; 4],
    /// R as a matrix, row by row.
    pub rotation_matrix: [[f64; 3]; 3],
    /// `s`, above zero.
    pub scale: f64,
}

/// The largest deviation of lengths and of angles from a similarity, relative to the scale, that passes for rounding.
/// Keys of animations are numbers of `f32`, of which a few roundings add up along a chain of nodes.
pub(crate) const ROUNDING: f64 = 1e-5;

impl Place {
    /// The place of a frame of the file, in whose axes the matrix is.
    pub(crate) fn new(matrix: DMat4, up: Up) -> Self {
        if up == Up::Z {
            return Self { matrix };
        }
        // C M C⁻¹, where C turns y up to z up: it only exchanges axes and signs, so nothing is rounded.
        let turned = |v: DVec3| DVec3::from(z_up_from_y_up(v.to_array()));
        let [x, y, z, w] = [matrix.x_axis, matrix.y_axis, matrix.z_axis, matrix.w_axis].map(|c| turned(c.truncate()));
        Self { matrix: DMat4::from_cols(x.extend(0.0), (-z).extend(0.0), y.extend(0.0), w.extend(1.0)) }
    }

    /// The rows of the map: `q_k = Σ m[k][j] p_j + m[k][3]`.
    #[must_use]
    pub fn rows(&self) -> [[f64; 4]; 3] {
        let rows = self.matrix.transpose();
        [rows.x_axis, rows.y_axis, rows.z_axis].map(|row| row.to_array())
    }

    /// The origin of the frame.
    #[must_use]
    pub fn translation(&self) -> [f64; 3] {
        self.matrix.w_axis.truncate().to_array()
    }

    /// A point of the frame in the scene.
    #[must_use]
    pub fn to_scene(&self, p: [f64; 3]) -> [f64; 3] {
        self.matrix.transform_point3(DVec3::from(p)).to_array()
    }

    /// The lengths in the scene of the frame's unit vectors.
    #[must_use]
    pub fn scales(&self) -> [f64; 3] {
        let linear = DMat3::from_mat4(self.matrix);
        [linear.x_axis, linear.y_axis, linear.z_axis].map(DVec3::length)
    }

    /// The place as translation, rotation and one scale; `None` if it scales axes by different numbers, shears, mirrors, or
    /// scales by zero. Deviations of 10⁻⁵ count as rounding.
    #[must_use]
    pub fn similarity(&self) -> Option<Similarity> {
        self.nearest_similarity().filter(|_| is_conformal(DMat3::from_mat4(self.matrix)))
    }

    /// The place as translation, rotation and one scale, that of its volume, where it is known to be a similarity but for
    /// rounding; `None` only if it mirrors, or scales by zero.
    #[must_use]
    pub fn nearest_similarity(&self) -> Option<Similarity> {
        let linear = DMat3::from_mat4(self.matrix);
        let scale = linear.determinant().cbrt();
        if !(scale.is_finite() && scale > 0.0) {
            return None;
        }
        let rotation = unit(DQuat::from_mat3(&(linear * (1.0 / scale))));
        // Of entries beyond all bounds nothing is left.
        let rotation = if rotation.is_finite() { rotation } else { DQuat::IDENTITY };
        let rows = DMat3::from_quat(rotation).transpose().to_cols_array_2d();
        Some(Similarity {
            translation: self.translation(),
            rotation: rotation.to_array(),
            rotation_matrix: rows,
            scale,
        })
    }
}

/// Whether a map keeps angles but for rounding, mirrors among them: `MᵀM = s² 1`. So does one that takes all to a point.
pub(crate) fn is_conformal(linear: DMat3) -> bool {
    let product = linear.transpose() * linear;
    let square = (product.x_axis.x + product.y_axis.y + product.z_axis.z) / 3.0;
    if square == 0.0 {
        return true;
    }
    let off = (product * (1.0 / square) - DMat3::IDENTITY).to_cols_array();
    // No number, of squares that overflow, is above everything too.
    off.iter().all(|c| c.abs() <= 2.0 * ROUNDING)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_of_a_y_up_frame_maps_z_up_points_as_the_file_maps_its_own() {
        let turn = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), 0.8);
        let matrix = DMat4::from_scale_rotation_translation(DVec3::new(1.0, 2.0, 3.0), turn, DVec3::new(5.0, 6.0, 7.0));
        let place = Place::new(matrix, Up::Y);
        let p = [0.3, -0.7, 1.1];
        let expected = z_up_from_y_up(matrix.transform_point3(DVec3::from(p)).to_array());
        let found = place.to_scene(z_up_from_y_up(p));
        assert!((0..3).all(|k| (found[k] - expected[k]).abs() < 1e-14), "{found:?}, expected {expected:?}");
        let scales = place.scales();
        assert!((0..3).all(|k| (scales[k] - [1.0, 3.0, 2.0][k]).abs() < 1e-14), "y and z change places: {scales:?}");
    }

    #[test]
    fn a_similarity_is_found_and_nothing_else_is_taken_for_one() {
        let turn = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), 2.8);
        let place = |scale: DVec3| {
            Place::new(DMat4::from_scale_rotation_translation(scale, turn, DVec3::new(1.0, 2.0, 3.0)), Up::Z)
        };
        let found = place(DVec3::splat(2.5)).similarity().unwrap();
        assert!((found.scale - 2.5).abs() < 1e-14, "{found:?}");
        assert!(DQuat::from_array(found.rotation).angle_between(turn) < 1e-7, "{found:?}, expected {turn:?}");
        for scale in [DVec3::new(1.0, 1.0, 1.001), DVec3::new(-1.0, 1.0, 1.0), DVec3::ZERO] {
            assert_eq!(place(scale).similarity(), None, "scaled by {scale:?}");
        }
        assert_eq!(place(DVec3::ZERO).nearest_similarity(), None, "a point");
        let near = place(DVec3::new(1.0, 1.0, 1.001)).nearest_similarity().unwrap();
        assert!((near.scale - 1.001_f64.cbrt()).abs() < 1e-14, "that of its volume: {near:?}");
        assert!(DQuat::from_array(near.rotation).angle_between(turn) < 1e-3, "{near:?}, expected {turn:?}");
        assert!(place(DVec3::new(1.0, 1.0, 1.000_001)).similarity().is_some(), "a rounding of f32");
    }
}
