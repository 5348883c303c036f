//! The stage of `lobe render`, which all pictures share: the scene as the mode needs it, the camera, and the light.

use lobe::env::{SceneLight, Sun};
use lobe::motion::{MovingScene, MovingShading};
use lobe::render::{BakedScene, Camera, DistantLight, Emitter, EnvironmentMaps, LitPicture, Reflections, RenderError};
use lobe::scene::{Bvh, Scene};

use crate::render::light::ReadLight;

/// The order of irradiance without --order: higher bands hardly show.
pub(crate) const IRRADIANCE_ORDER: usize = 3;

/// The scene, with transfer where the mode needs it.
pub(crate) enum Stage {
    Plain(Scene, Bvh),
    Baked(Box<BakedScene>),
    /// Its parts move; how they are shaded, unless they are traced.
    Moving(Box<MovingScene>, Option<MovingShading>),
}

/// The inputs that all frames share.
pub(crate) struct Work<'a> {
    pub(crate) stage: Stage,
    pub(crate) camera: Camera,
    pub(crate) light: &'a ReadLight,
    /// None where the light is used as it was given.
    pub(crate) split: Option<SceneLight>,
    /// Suns beside the expansion, or beside the light as it was given.
    pub(crate) suns: Vec<Sun>,
    /// Of environment mapping.
    pub(crate) maps: Option<EnvironmentMaps>,
    /// What surfaces of transfer reflect that are not matte.
    pub(crate) reflections: Option<Reflections>,
    /// Of the moment that was shaded before.
    pub(crate) tree: Option<Bvh>,
}

/// How one picture is lit.
pub(crate) struct Lit {
    /// What lights the truth, before what is behind the scene.
    pub(crate) shown: DistantLight,
    /// None where the light is used as it was given.
    pub(crate) split: Option<SceneLight>,
    /// Suns beside that, or beside the light as it was given.
    pub(crate) suns: Vec<Sun>,
}

impl Lit {
    /// The picture with an alpha, if nothing is behind the scene.
    pub(crate) fn finished(&self, picture: LitPicture) -> LitPicture {
        if self.shown.is_transparent() { picture.before_nothing() } else { picture }
    }

    /// Lamps, and the suns as lamps of a scene.
    pub(crate) fn emitters(&self, mut lamps: Vec<Emitter>, scene: &Scene) -> Vec<Emitter> {
        let bounds = scene.world_bounds();
        lamps.extend(self.suns.iter().map(|sun| Emitter::of_sun(sun, bounds)));
        lamps
    }

    /// The light as suns and an expansion.
    pub(crate) fn light(&self) -> &SceneLight {
        match &self.split {
            Some(light) => light,
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
