//! The placement of a rigid entity: turned, scaled alike in all directions, and moved.

use lobe_sh::Rotation;

/// The place of a rigid entity: a point p of its own frame is at `t + s R p` of the world.
///
/// ```
/// use lobe_sh::Rotation;
/// use lobe_shadow::Placement;
///
/// let twice_as_large = Placement::new([1.0, 0.0, 0.0], Rotation::IDENTITY, 2.0);
/// assert_eq!(twice_as_large.to_world([0.0, 1.0, 0.0]), [1.0, 2.0, 0.0]);
/// assert_eq!(twice_as_large.to_own([1.0, 2.0, 0.0]), [0.0, 1.0, 0.0]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    translation: [f64; 3],
    rotation: Rotation,
    scale: f64,
}

impl Placement {
    /// At the origin, not turned, and as large as it is.
    pub const IDENTITY: Self = Self { translation: [0.0; 3], rotation: Rotation::IDENTITY, scale: 1.0 };

    /// A place by its translation, rotation and scale.
    ///
    /// # Panics
    /// If a number is not finite, or the scale is not positive.
    #[must_use]
    pub fn new(translation: [f64; 3], rotation: Rotation, scale: f64) -> Self {
        assert!(translation.iter().all(|t| t.is_finite()), "a translation is finite, it is not {translation:?}");
        assert!(scale.is_finite() && scale > 0.0, "a scale is finite and positive, it is not {scale}");
        Self { translation, rotation, scale }
    }

    /// The place of the entity's own frame in the world.
    #[must_use]
    pub fn translation(&self) -> [f64; 3] {
        self.translation
    }

    /// From the entity's own directions to those of the world.
    #[must_use]
    pub fn rotation(&self) -> &Rotation {
        &self.rotation
    }

    /// Length in the world per length in the entity's own frame.
    #[must_use]
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// The rows `[s R, t]` of the map to the world.
    #[must_use]
    pub fn rows(&self) -> [[f64; 4]; 3] {
        let r = self.rotation.matrix();
        std::array::from_fn(|k| [self.scale * r[k][0], self.scale * r[k][1], self.scale * r[k][2], self.translation[k]])
    }

    /// `t + s R p`.
    #[must_use]
    pub fn to_world(&self, p: [f64; 3]) -> [f64; 3] {
        let r = self.rotation.matrix();
        std::array::from_fn(|k| self.translation[k] + self.scale * (0..3).map(|c| r[k][c] * p[c]).sum::<f64>())
    }

    /// `Rᵀ (q - t) / s`.
    #[must_use]
    pub fn to_own(&self, q: [f64; 3]) -> [f64; 3] {
        let r = self.rotation.matrix();
        std::array::from_fn(|k| (0..3).map(|c| r[c][k] * (q[c] - self.translation[c])).sum::<f64>() / self.scale)
    }
}
