//! Transforms of nodes and meshes, composed in `f64`.

use glam::{DMat3, DMat4, DQuat, DVec3};

/// Translation, rotation and scale: a point p is moved to `t + R (s p)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Trs {
    pub(crate) translation: DVec3,
    /// Of any length: zero stands for no rotation.
    pub(crate) rotation: DQuat,
    pub(crate) scale: DVec3,
}

impl Trs {
    pub(crate) const IDENTITY: Self = Self { translation: DVec3::ZERO, rotation: DQuat::IDENTITY, scale: DVec3::ONE };

    /// The same as a matrix.
    pub(crate) fn matrix(&self) -> DMat4 {
        DMat4::from_scale_rotation_translation(self.scale, unit(self.rotation), self.translation)
    }
}

/// The rotation of a quaternion of any length; none of one that has no length.
pub(crate) fn unit(rotation: DQuat) -> DQuat {
    if rotation.length_squared() > 0.0 { rotation.normalize() } else { DQuat::IDENTITY }
}

/// The transform of a node relative to its parent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Local {
    Trs(Trs),
    Matrix(DMat4),
}

impl Local {
    pub(crate) fn matrix(&self) -> DMat4 {
        match self {
            Self::Trs(trs) => trs.matrix(),
            Self::Matrix(matrix) => *matrix,
        }
    }
}

/// An affine map of points, with the maps of normals and tangents that belong to it.
///
/// ```text
///   p' = M p + t,      n' = ± cof(M) n / |cof(M) n|,      T' = M T / |M T|
/// ```
///
/// The cofactors are the inverse transpose times the determinant, and exist where the inverse does not; the sign is the
/// determinant's, so that the outside of a mirrored mesh stays outside.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Affine {
    matrix: DMat4,
    cofactors: DMat3,
    is_mirror: bool,
}

impl Affine {
    pub(crate) fn new(matrix: DMat4) -> Self {
        let linear = DMat3::from_mat4(matrix);
        let (x, y, z) = (linear.x_axis, linear.y_axis, linear.z_axis);
        let is_mirror = linear.determinant() < 0.0;
        let sign = if is_mirror { -1.0 } else { 1.0 };
        Self { matrix, cofactors: DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y)) * sign, is_mirror }
    }

    pub(crate) fn point(&self, p: DVec3) -> DVec3 {
        self.matrix.transform_point3(p)
    }

    /// The unit vector along a tangent of the surface; zero where it has no direction.
    pub(crate) fn tangent(&self, t: DVec3) -> DVec3 {
        self.matrix.transform_vector3(t).normalize_or_zero()
    }

    /// The unit normal; zero where it has no direction.
    pub(crate) fn normal(&self, n: DVec3) -> DVec3 {
        (self.cofactors * n).normalize_or_zero()
    }

    /// Whether triangles run around the other way.
    pub(crate) fn is_mirror(&self) -> bool {
        self.is_mirror
    }
}
