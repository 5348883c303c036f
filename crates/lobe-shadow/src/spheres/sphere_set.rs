//! Sets of spheres that stand for a solid.

use crate::error::ShadowError;
use crate::spheres::morphs::SphereMorphs;
use crate::spheres::skeleton::Skeleton;
use crate::spheres::skin::Skin;

/// The most spheres of a set: more than a fit makes, and few enough that a file of them takes a moment.
const MOST_SPHERES: usize = 1 << 16;

/// Spheres in the frame of the mesh that they stand for, and the joints they move with, if any.
///
/// Centers count from the [origin](Self::origin) of the set, which is that of the scene it was fitted to: far from the origin
/// of the mesh's own frame, numbers of `f32` are coarse. A sphere of radius 0 is a point and covers nothing; a set may have
/// no spheres.
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
    origin: [f64; 3],
    skin: Option<Skin>,
    skeleton: Option<Skeleton>,
    morphs: Option<SphereMorphs>,
}

impl SphereSet {
    /// A set by centers and radii, about the origin of the mesh's frame.
    ///
    /// # Errors
    /// [`ShadowError::Options`] if there are not as many of both, or more than 65536, or one is not finite, or a radius is negative.
    pub fn new(centers: Vec<[f32; 3]>, radii: Vec<f32>) -> Result<Self, ShadowError> {
        check(&centers, &radii).map_err(ShadowError::Options)?;
        Ok(Self { centers, radii, origin: [0.0; 3], skin: None, skeleton: None, morphs: None })
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

    /// The same set about another origin: all of it is moved.
    ///
    /// # Errors
    /// [`ShadowError::Options`] if it is not finite.
    pub fn with_origin(self, origin: [f64; 3]) -> Result<Self, ShadowError> {
        if !origin.iter().all(|c| c.is_finite()) {
            return Err(ShadowError::Options(format!("expected a finite origin of spheres, found {origin:?}")));
        }
        Ok(Self { origin, ..self })
    }

    /// The point of the mesh's own frame from which centers count; zero unless the mesh is far from there.
    #[must_use]
    pub fn origin(&self) -> [f64; 3] {
        self.origin
    }

    /// The center of a sphere in the mesh's own frame.
    ///
    /// # Panics
    /// If there is no such sphere.
    #[must_use]
    pub fn center(&self, sphere: usize) -> [f64; 3] {
        std::array::from_fn(|k| self.origin[k] + f64::from(self.centers[sphere][k]))
    }

    /// The centers, from the [origin](Self::origin).
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

    /// The entity that it was [bound to](Self::bind_to), if any.
    #[must_use]
    pub fn skeleton(&self) -> Option<&Skeleton> {
        self.skeleton.as_ref()
    }

    /// How it follows morph targets, if it does.
    #[must_use]
    pub fn morphs(&self) -> Option<&SphereMorphs> {
        self.morphs.as_ref()
    }

    /// The set following morph targets so.
    ///
    /// # Errors
    /// [`ShadowError::Options`] if they are not of as many spheres.
    pub fn with_morphs(self, morphs: Option<SphereMorphs>) -> Result<Self, ShadowError> {
        let expected = self.len() * morphs.as_ref().map_or(0, |morphs| morphs.weights().len());
        let found = morphs.as_ref().map_or(0, |morphs| morphs.changes().len());
        if found != expected {
            return Err(ShadowError::Options(format!(
                "expected {expected} changes of spheres by morph targets, found {found}"
            )));
        }
        Ok(Self { morphs, ..self })
    }

    /// The set with other joints, of no entity that it would know.
    ///
    /// # Errors
    /// [`ShadowError::Options`] if they are not of as many spheres.
    pub fn with_skin(mut self, skin: Skin) -> Result<Self, ShadowError> {
        if skin.joints().len() != self.len() {
            let (found, expected) = (skin.joints().len(), self.len());
            return Err(ShadowError::Options(format!("expected joints of {expected} spheres, found those of {found}")));
        }
        (self.skin, self.skeleton) = (Some(skin), None);
        Ok(self)
    }

    /// The set as it stands at weights of the morph targets that it follows, which it then follows no longer.
    #[must_use]
    pub fn morphed_to(mut self, weights: &[f64]) -> Self {
        let Some(morphs) = self.morphs.take() else { return self };
        for (k, (center, radius)) in self.centers.iter_mut().zip(&mut self.radii).enumerate() {
            let (there, factor) = morphs.at(k, center.map(f64::from), weights);
            (*center, *radius) = (there.map(|c| c as f32), (factor * f64::from(*radius)) as f32);
        }
        self
    }

    /// The same spheres about their own centers, their radii multiplied by a factor from 0 to 1.
    pub(crate) fn scaled(mut self, factor: f64) -> Self {
        self.radii.iter_mut().for_each(|radius| *radius = (factor * f64::from(*radius)) as f32);
        self
    }

    /// The set as one of an entity whose joints it moves with.
    ///
    /// # Errors
    /// [`ShadowError::Options`] if the entity has no such joint.
    pub fn with_skeleton(mut self, skeleton: Skeleton) -> Result<Self, ShadowError> {
        // The node counts as one joint more.
        let node = skeleton.joints().len();
        for (k, (four, weights)) in
            self.skin.iter().flat_map(|skin| skin.joints().iter().zip(skin.weights())).enumerate()
        {
            let beyond = four.iter().zip(weights).find(|(j, w)| **w > 0.0 && usize::from(**j) > node);
            if let Some((joint, _)) = beyond {
                let of = skeleton.label();
                return Err(ShadowError::Options(format!(
                    "expected joints of {of}, which has {node}, found number {joint} at sphere {k}"
                )));
            }
        }
        self.skeleton = Some(skeleton);
        Ok(self)
    }
}

/// What is wrong with centers and radii.
pub(crate) fn check(centers: &[[f32; 3]], radii: &[f32]) -> Result<(), String> {
    if centers.len() != radii.len() {
        return Err(format!("expected as many radii as centers, found {} and {}", radii.len(), centers.len()));
    }
    if radii.len() > MOST_SPHERES {
        return Err(format!("expected at most {MOST_SPHERES} spheres of a set, found {}: fit fewer", radii.len()));
    }
    if let Some(k) = centers.iter().position(|c| c.iter().any(|x| !x.is_finite())) {
        return Err(format!("expected finite centers, found {:?} at sphere {k}", centers[k]));
    }
    if let Some(k) = radii.iter().position(|r| !(r.is_finite() && *r >= 0.0)) {
        return Err(format!("expected finite radii of at least 0, found {} at sphere {k}", radii[k]));
    }
    Ok(())
}
