//! Morph targets and what they do to spheres.
//!
//! A sphere follows the surface next to it. With places `p` of the surface nearest to points `c + R s` of the sphere,
//! in directions `s` over all of it, and `Δp_k` what target `k` adds there,
//!
//! ```text
//!   c' = c + Σ_k v_k D_k          R' = R |det(1 + Σ_k v_k A_k)|^{1/3}         v = w - w_0
//!   D_k = mean of Δp_k            A_k = 3/R · mean of Δp_k sᵀ
//! ```
//!
//! which is the affine map nearest to the displacements, with the volume that it makes of the sphere. `w_0` are the
//! weights of the shape that the spheres were fitted to.

use glam::{DMat3, DVec3};

use crate::error::ShadowError;

/// Numbers of a sphere and a target: `D`, and the rows of `A`.
pub(crate) const NUMBERS: usize = 12;

/// What the morph targets of an entity do to spheres that stand for it.
#[derive(Clone, Debug, PartialEq)]
pub struct SphereMorphs {
    /// `w_0`, a number for each target.
    weights: Vec<f64>,
    /// For each sphere and each target `D`, and the rows of `A`.
    changes: Vec<[f32; NUMBERS]>,
}

impl SphereMorphs {
    /// The weights of the shape that spheres were fitted to, and for each sphere and each of its targets twelve
    /// numbers: where its center goes, and the rows of a matrix.
    ///
    /// # Errors
    /// [`ShadowError::Options`] without targets, or if a number is not finite.
    pub fn new(weights: Vec<f64>, changes: Vec<[f32; NUMBERS]>) -> Result<Self, ShadowError> {
        if weights.is_empty() {
            return Err(ShadowError::Options("expected a morph target that spheres follow, found none".to_owned()));
        }
        let is_finite = weights.iter().all(|w| w.is_finite()) && changes.as_flattened().iter().all(|x| x.is_finite());
        if !is_finite {
            return Err(ShadowError::Options("expected finite numbers of morph targets".to_owned()));
        }
        Ok(Self { weights, changes })
    }

    /// The weights of the shape that the spheres were fitted to.
    #[must_use]
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// For each sphere and each target where its center goes, and the rows of a matrix.
    #[must_use]
    pub fn changes(&self) -> &[[f32; NUMBERS]] {
        &self.changes
    }

    /// The center of a sphere and the factor of its radius at weights; targets without a weight stay as they were
    /// fitted.
    pub(crate) fn at(&self, sphere: usize, center: [f64; 3], weights: &[f64]) -> ([f64; 3], f64) {
        let count = self.weights.len();
        let (mut moved, mut map) = (DVec3::from_array(center), DMat3::IDENTITY);
        for ((now, fitted), change) in weights.iter().zip(&self.weights).zip(&self.changes[sphere * count..][..count]) {
            let by = now - fitted;
            let [dx, dy, dz, a, b, c, d, e, f, g, h, i] = change.map(f64::from);
            moved += by * DVec3::new(dx, dy, dz);
            map += by * DMat3::from_cols(DVec3::new(a, d, g), DVec3::new(b, e, h), DVec3::new(c, f, i));
        }
        (moved.to_array(), map.determinant().abs().cbrt())
    }
}
