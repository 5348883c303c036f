//! The light of the room: the sky, turned, and the lamps.

use std::sync::Arc;

use lobe::env::{MappedMap, project_map};
use lobe::prt::Transfer;
use lobe::sh::{Coefficient as _, Rgb, ShVec};
use lobe_gpu::TurningLight;

use crate::loading::sky_source::OpenedSky;
use crate::rooms::light::Taming;
use crate::rooms::scene::edits::{SceneEdits, SceneLamp};

/// Expansions that remain while the sky turns: turning costs one rotation of `n²` colors.
#[derive(Debug, Default)]
pub(crate) struct SceneLight {
    /// The sky to the highest order, and the map of which it is.
    projected: Option<(Arc<MappedMap>, ShVec<Rgb<f64>>)>,
    sky: Option<(SkyKey, ShVec<Rgb<f64>>)>,
    lamps: Option<(LampKey, ShVec<Rgb<f64>>)>,
}

type SkyKey = (usize, Taming, f64);
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
    pub(crate) fn light(&mut self, edits: &SceneEdits, sky: Option<&OpenedSky>) -> ShVec<Rgb<f64>> {
        let mut light = self.turned_sky(edits, sky);
        light += self.tamed_lamps(edits);
        light
    }

    /// The same in its two parts, for a sky that turns on.
    pub(crate) fn turning(&mut self, edits: &SceneEdits, sky: Option<&OpenedSky>) -> TurningLight {
        let turned = self.turned_sky(edits, sky);
        TurningLight::new(turned, edits.rotation()).with_still(self.tamed_lamps(edits).clone())
    }

    fn turned_sky(&mut self, edits: &SceneEdits, sky: Option<&OpenedSky>) -> ShVec<Rgb<f64>> {
        match sky {
            Some(sky) => edits.rotation().rotated(self.tamed_sky(edits, sky)),
            None => ShVec::zero(edits.order),
        }
    }

    fn tamed_sky(&mut self, edits: &SceneEdits, sky: &OpenedSky) -> &ShVec<Rgb<f64>> {
        if self.projected.as_ref().is_none_or(|(map, _)| !Arc::ptr_eq(map, &sky.map)) {
            self.projected = Some((sky.map.clone(), project_map(&sky.map, Transfer::MAX_ORDER)));
            self.sky = None;
        }
        let key = (edits.order, edits.taming, edits.sky_strength);
        if self.sky.as_ref().is_some_and(|(kept, _)| *kept != key) {
            self.sky = None;
        }
        let projected =
            self.projected.as_ref().map_or_else(|| ShVec::zero(edits.order), |(_, f)| f.resized(edits.order));
        &self.sky.get_or_insert_with(|| (key, edits.taming.tamed(&projected).map(|c| c.scale(edits.sky_strength)))).1
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
