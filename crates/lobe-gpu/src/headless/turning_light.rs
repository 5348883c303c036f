//! The light of a turntable.

use lobe_env::SceneLight;
use lobe_sh::{Rgb, Rotation, ShVec};

/// What lights a turntable: a sky that turns with the backdrop, and what stays where it is.
///
/// ```text
///   L_k = R_k sky + still        backdrop_k = R_k begin        R_k: k steps about +z
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct TurningLight {
    /// The sky as it stands in the first picture: its suns, and the expansion of the rest.
    pub sky: SceneLight,
    /// That of what does not turn, such as lamps, of the same order.
    pub still: Option<ShVec<Rgb<f64>>>,
    /// How the backdrop is turned in the first picture.
    pub begin: Rotation,
}

impl TurningLight {
    /// A sky that stands turned by `begin` in the first picture, as its backdrop does.
    #[must_use]
    pub fn new(sky: impl Into<SceneLight>, begin: Rotation) -> Self {
        Self { sky: sky.into(), still: None, begin }
    }

    /// The same with a light that does not turn, of the order of the sky.
    #[must_use]
    pub fn with_still(self, still: ShVec<Rgb<f64>>) -> Self {
        Self { still: Some(still), ..self }
    }

    /// The light after a turn.
    pub(crate) fn turned(&self, turn: &Rotation) -> SceneLight {
        let light = self.sky.rotated(turn);
        match &self.still {
            Some(still) => SceneLight::new(light.rest() + still, light.suns().to_vec()),
            None => light,
        }
    }
}

impl From<&ShVec<Rgb<f64>>> for TurningLight {
    /// A sky whose backdrop stands as its environment has it.
    fn from(sky: &ShVec<Rgb<f64>>) -> Self {
        Self::new(sky.clone(), Rotation::IDENTITY)
    }
}

impl From<&SceneLight> for TurningLight {
    /// A sky whose backdrop stands as its environment has it.
    fn from(sky: &SceneLight) -> Self {
        Self::new(sky.clone(), Rotation::IDENTITY)
    }
}
