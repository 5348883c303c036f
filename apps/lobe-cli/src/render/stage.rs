//! The stage of `lobe render`, which all pictures share: the scene as the mode needs it, the camera, and the light.

use lobe::motion::{MovingScene, MovingShading};
use lobe::render::{BakedScene, Camera, DistantLight, EnvironmentMaps, LitPicture, RenderError};
use lobe::scene::{Bvh, Scene};
use lobe::sh::{Rgb, ShVec};

use crate::render::light::ReadLight;

/// The order of irradiance without --order: higher bands hardly show.
const IRRADIANCE_ORDER: usize = 3;

/// The scene, with transfer where the mode needs it.
pub(crate) enum Stage {
    Plain(Scene, Bvh),
    Baked(Box<BakedScene>),
    /// Its parts move; how they are shaded, unless they are traced.
    Moving(Box<MovingScene>, Option<MovingShading>),
}

impl Stage {
    /// The bands that the light needs, unless it is asked for others.
    pub(crate) fn order(&self) -> usize {
        match self {
            Self::Plain(..) | Self::Moving(_, None) => IRRADIANCE_ORDER,
            Self::Baked(baked) => baked.order(),
            Self::Moving(_, Some(shading)) => shading.order(),
        }
    }
}

/// The inputs that all frames share.
pub(crate) struct Work<'a> {
    pub(crate) stage: Stage,
    pub(crate) camera: Camera,
    pub(crate) light: &'a ReadLight,
    /// None where the light is used as it was given.
    pub(crate) expansion: Option<ShVec<Rgb<f64>>>,
    /// Of environment mapping.
    pub(crate) maps: Option<EnvironmentMaps>,
    /// Of the moment that was shaded before.
    pub(crate) tree: Option<Bvh>,
}

/// How one picture is lit.
pub(crate) struct Lit {
    /// What lights the truth, before what is behind the scene.
    pub(crate) shown: DistantLight,
    /// None where the light is used as it was given.
    pub(crate) expansion: Option<ShVec<Rgb<f64>>>,
}

impl Lit {
    /// The picture with an alpha, if nothing is behind the scene.
    pub(crate) fn finished(&self, picture: LitPicture) -> LitPicture {
        if self.shown.is_transparent() { picture.before_nothing() } else { picture }
    }

    /// The light as an expansion.
    pub(crate) fn light(&self) -> &ShVec<Rgb<f64>> {
        match &self.expansion {
            Some(expansion) => expansion,
            None => unreachable!("all modes but truth and environment light with an expansion"),
        }
    }
}

/// A box around a scene at some of its times.
pub(crate) fn moving_bounds(moving: &MovingScene, times: &[f64]) -> Result<[[f64; 3]; 2], RenderError> {
    let mut all = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
    for &time in times {
        let [min, max] = moving.world_bounds(time)?;
        for k in 0..3 {
            all[0][k] = all[0][k].min(min[k]);
            all[1][k] = all[1][k].max(max[k]);
        }
    }
    Ok(all)
}
