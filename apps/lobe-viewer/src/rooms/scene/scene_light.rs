//! The light of the room: the sky, turned, and the lamps.

use lobe::env::{SceneLight as Light, Sun};
use lobe::sh::{Coefficient as _, Rgb, ShVec};
use lobe_gpu::TurningLight;

use crate::loading::backdrop::Behind;
use crate::loading::sky_source::OpenedSky;
use crate::rooms::light::TamedSky;
use crate::rooms::scene::edits::{SceneEdits, SceneLamp};
use crate::rooms::taming::Taming;

/// Expansions that remain while the sky turns: turning costs one rotation of `n²` colors.
#[derive(Debug, Default)]
pub(crate) struct SceneLight {
    sky: TamedSky,
    lamps: Option<(LampKey, ShVec<Rgb<f64>>)>,
}

type LampKey = (usize, Taming, Vec<SceneLamp>);

impl SceneLight {
    /// The light in the world:
    ///
    /// ```text
    ///   L = R tame(sky) + tame(Σ lamps)
    /// ```
    ///
    /// Sky and lamps are tamed apart, so that neither is tamed again while the sky turns; what is nowhere negative remains so in
    /// the sum.
    ///
    /// With suns apart, the expansion of the sky is that of the rest of it.
    pub(crate) fn light(&mut self, edits: &SceneEdits, sky: Option<&OpenedSky>, has_suns: bool) -> Light {
        let light = self.turned_sky(edits, sky, has_suns);
        Light::new(light.rest() + self.tamed_lamps(edits), light.suns().to_vec())
    }

    /// The same in its two parts, for a sky that turns on.
    pub(crate) fn turning(&mut self, edits: &SceneEdits, sky: Option<&OpenedSky>, has_suns: bool) -> TurningLight {
        let turned = self.turned_sky(edits, sky, has_suns);
        TurningLight::new(turned, edits.rotation()).with_still(self.tamed_lamps(edits).clone())
    }

    /// What is behind the scene, before it is turned as the sky is.
    pub(crate) fn behind(&mut self, edits: &SceneEdits, sky: Option<&OpenedSky>) -> Behind {
        Behind::new(edits.background, || match sky {
            Some(sky) => self.sky.of(sky, (edits.order, false), edits.taming).map(|c| c.scale(edits.sky_strength)),
            None => ShVec::zero(edits.order),
        })
    }

    fn turned_sky(&mut self, edits: &SceneEdits, sky: Option<&OpenedSky>, has_suns: bool) -> Light {
        let Some(sky) = sky else { return ShVec::zero(edits.order).into() };
        let tamed = self.sky.of(sky, (edits.order, has_suns), edits.taming).map(|c| c.scale(edits.sky_strength));
        let scaled = |sun: &Sun| Sun { irradiance: sun.irradiance.scale(edits.sky_strength), ..*sun };
        let suns = if has_suns { sky.split.suns().iter().map(scaled).collect() } else { Vec::new() };
        Light::new(tamed, suns).rotated(&edits.rotation())
    }

    fn tamed_lamps(&mut self, edits: &SceneEdits) -> &ShVec<Rgb<f64>> {
        let key = (edits.order, edits.taming, edits.lamps.clone());
        if self.lamps.as_ref().is_some_and(|(kept, _)| *kept != key) {
            self.lamps = None;
        }
        &self.lamps.get_or_insert_with(|| (key, sum_of_lamps(edits))).1
    }
}

fn sum_of_lamps(edits: &SceneEdits) -> ShVec<Rgb<f64>> {
    let mut sum = ShVec::zero(edits.order);
    for lamp in edits.lamps.iter().filter(|lamp| lamp.is_on) {
        // The sliders keep lamps in their range.
        if let Ok(light) = lamp.project(edits.order) {
            sum += &light;
        }
    }
    if edits.lamps.iter().any(|lamp| lamp.is_on) { edits.taming.tamed(&sum) } else { sum }
}
