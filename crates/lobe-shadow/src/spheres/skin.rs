//! The joints that spheres move with.

use crate::error::ShadowError;

/// How far from 1 the weights of a file may sum: what is written with four digits still counts, a forgotten joint does not.
const SUM_TOLERANCE: f32 = 1e-4;

/// The joints that spheres move with: four for each, with weights that sum to 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Skin {
    joints: Vec<[u16; 4]>,
    weights: Vec<[f32; 4]>,
}

impl Skin {
    /// Joints and weights, which are scaled to sum to 1.
    ///
    /// # Errors
    /// [`ShadowError::Options`] if there are not as many of both, a weight is negative or not finite, or all of a
    /// sphere are 0.
    pub fn new(joints: Vec<[u16; 4]>, weights: Vec<[f32; 4]>) -> Result<Self, ShadowError> {
        let (mut weights, refuse) = (weights, |message: String| Err(ShadowError::Options(message)));
        if joints.len() != weights.len() {
            return refuse(format!("expected as many weights as joints, found {} and {}", weights.len(), joints.len()));
        }
        for (k, four) in weights.iter_mut().enumerate() {
            let sum: f32 = four.iter().sum();
            if !(sum.is_finite() && sum > 0.0 && four.iter().all(|w| *w >= 0.0)) {
                return refuse(format!("expected weights of at least 0, some more, found {four:?} at sphere {k}"));
            }
            four.iter_mut().for_each(|w| *w /= sum);
        }
        Ok(Self { joints, weights })
    }

    /// Joints and weights of a file, which must sum to 1. Those that do to rounding are taken as they are, so that what is read is
    /// what was written.
    pub(crate) fn from_normalized(joints: Vec<[u16; 4]>, weights: Vec<[f32; 4]>) -> Result<Self, ShadowError> {
        let skin = Self::new(joints, weights.clone())?;
        let off = |four: &[f32; 4]| (four.iter().sum::<f32>() - 1.0).abs();
        if let Some(k) = weights.iter().position(|four| off(four) > SUM_TOLERANCE) {
            let four = weights[k];
            return Err(ShadowError::Options(format!("expected weights that sum to 1, found {four:?} at sphere {k}")));
        }
        let is_normalized = weights.iter().all(|four| off(four) <= 4.0 * f32::EPSILON);
        Ok(if is_normalized { Self { weights, ..skin } } else { skin })
    }

    /// The same weights of joints with other numbers, as many as there were.
    pub(crate) fn with_joints(self, joints: Vec<[u16; 4]>) -> Self {
        Self { joints, ..self }
    }

    /// Four joints for each sphere.
    #[must_use]
    pub fn joints(&self) -> &[[u16; 4]] {
        &self.joints
    }

    /// Their weights, which sum to 1.
    #[must_use]
    pub fn weights(&self) -> &[[f32; 4]] {
        &self.weights
    }
}
