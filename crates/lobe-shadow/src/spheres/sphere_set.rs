//! Sets of spheres that stand for a solid.

use crate::ShadowError;
use crate::spheres::skin::Skin;

/// Spheres in the frame of the mesh that they stand for, and the joints they move with, if any.
///
/// A sphere of radius 0 is a point and covers nothing; a set may have no spheres.
///
/// ```
/// use lobe_shadow::SphereSet;
///
/// let set = SphereSet::new(vec![[0.0, 0.0, 1.0]], vec![0.5])?;
/// assert_eq!((set.len(), set.centers()[0], set.radii()[0]), (1, [0.0, 0.0, 1.0], 0.5));
/// assert!(SphereSet::new(vec![[0.0, 0.0, 1.0]], vec![-0.5]).is_err());
/// # Ok::<(), lobe_shadow::ShadowError>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SphereSet {
    centers: Vec<[f32; 3]>,
    radii: Vec<f32>,
    skin: Option<Skin>,
}

impl SphereSet {
    /// A set by centers and radii.
    ///
    /// # Errors
    /// [`ShadowError::Options`] if there are not as many of both, or one is not finite, or a radius is negative.
    pub fn new(centers: Vec<[f32; 3]>, radii: Vec<f32>) -> Result<Self, ShadowError> {
        check(&centers, &radii).map_err(ShadowError::Options)?;
        Ok(Self { centers, radii, skin: None })
    }

    /// The number of spheres.
    #[must_use]
    pub fn len(&self) -> usize {
        self.radii.len()
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.radii.is_empty()
    }

    /// The centers, in the mesh's own frame.
    #[must_use]
    pub fn centers(&self) -> &[[f32; 3]] {
        &self.centers
    }

    /// The radii, not negative.
    #[must_use]
    pub fn radii(&self) -> &[f32] {
        &self.radii
    }

    /// What the spheres move with.
    #[must_use]
    pub fn skin(&self) -> Option<&Skin> {
        self.skin.as_ref()
    }

    /// The set with other joints.
    ///
    /// # Errors
    /// [`ShadowError::Options`] if they are not of as many spheres.
    pub fn with_skin(mut self, skin: Skin) -> Result<Self, ShadowError> {
        if skin.joints().len() != self.len() {
            let (found, expected) = (skin.joints().len(), self.len());
            return Err(ShadowError::Options(format!("expected joints of {expected} spheres, found those of {found}")));
        }
        self.skin = Some(skin);
        Ok(self)
    }
}

/// What is wrong with centers and radii.
pub(crate) fn check(centers: &[[f32; 3]], radii: &[f32]) -> Result<(), String> {
    if centers.len() != radii.len() {
        return Err(format!("expected as many radii as centers, found {} and {}", radii.len(), centers.len()));
    }
    if let Some(k) = centers.iter().position(|c| c.iter().any(|x| !x.is_finite())) {
        return Err(format!("expected finite centers, found {:?} at sphere {k}", centers[k]));
    }
    if let Some(k) = radii.iter().position(|r| !(r.is_finite() && *r >= 0.0)) {
        return Err(format!("expected finite radii of at least 0, found {} at sphere {k}", radii[k]));
    }
    Ok(())
}
