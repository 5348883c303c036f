//! Surroundings of the vertices of a moving scene: how open they are, and what other surfaces send them.

use lobe_prt::{AlbedoMode, Channels, Transfer};
use lobe_render::{Openness, RenderError, SceneHit, Surroundings};
use lobe_sh::{Coefficient as _, Dir, Rgb, ShVec};

use crate::light::moving_shading::{Ask, LightPart, MovingShading, Shaded};
use crate::scene::moment::Moment;

/// Bands in which the openness of vertices is known at most: each of their coefficients takes a shading of the scene.
const BANDS: usize = 3;

/// The surroundings of the fronts of all vertices.
pub(crate) struct MovingSurroundings {
    openness: Openness,
    /// Whether each vertex reflects any light in its transfer, without which nothing is known.
    is_known: Vec<bool>,
    /// What a white vertex sends back of the light that other surfaces of its part send.
    others: Vec<Rgb<f32>>,
}

impl MovingSurroundings {
    /// Those of a moment under a light. The transfer of visibility of a vertex is what it sends back, white, of each
    /// function of the basis:
    ///
    /// ```text
    ///   Dᵢ = B(yᵢ)/ρ        B(L) = Σ_j L_j (V D)_j
    /// ```
    pub(crate) fn new(
        shading: &MovingShading,
        moment: &Moment<'_>,
        light: &ShVec<Rgb<f64>>,
        ask: Ask<'_>,
    ) -> Result<Self, RenderError> {
        let bands = BANDS.min(shading.order());
        let count = bands * bands;
        let mut rows = vec![0.0; moment.scene().vertex_count() * count];
        let mut is_known = vec![true; moment.scene().vertex_count()];
        for i in 0..count {
            let mut one = ShVec::zero(shading.order());
            one[i] = Rgb::splat(1.0);
            let shaded = white(moment, shading.fronts_of(LightPart::SkyOnce, moment, &one.into(), ask)?);
            for ((row, is_known), (value, albedo)) in rows.chunks_exact_mut(count).zip(&mut is_known).zip(shaded) {
                let found = best(value, albedo);
                row[i] = found.unwrap_or(0.0);
                *is_known = found.is_some();
            }
        }
        let openness = Openness::new(Transfer::new(bands, Channels::Gray, rows)?, AlbedoMode::None);
        let light = light.clone().into();
        let whole = white(moment, shading.fronts_of(LightPart::Sky, moment, &light, ask)?);
        let direct = white(moment, shading.fronts_of(LightPart::SkyOnce, moment, &light, ask)?);
        let others = whole.zip(direct).map(|((all, albedo), (direct, _))| {
            let part = |all: f32, direct: f32, albedo: f32| if albedo > 0.0 { (all - direct) / albedo } else { 0.0 };
            Rgb::new(part(all.r, direct.r, albedo.r), part(all.g, direct.g, albedo.g), part(all.b, direct.b, albedo.b))
        });
        Ok(Self { openness, is_known, others: others.collect() })
    }

    /// What the lobe of this roughness about an axis meets around a hit.
    pub(crate) fn at(&self, hit: &SceneHit<'_>, axis: Dir, roughness: f64) -> Surroundings {
        if hit.corners().iter().any(|(corner, _)| !self.is_known[*corner]) {
            return Surroundings::UNKNOWN;
        }
        self.openness.surroundings(hit, (axis, roughness), hit.corners().into_iter(), hit.at_corners(&self.others))
    }
}

/// What each vertex sends back, and the albedo that is in it.
fn white(moment: &Moment<'_>, parts: Vec<Shaded>) -> impl Iterator<Item = (Rgb<f32>, Rgb<f32>)> {
    parts.into_iter().zip(&moment.placed).flat_map(|(Shaded { radiance, is_white }, placed)| {
        let albedo = move |[r, g, b]: [f32; 3]| if is_white { Rgb::splat(1.0) } else { Rgb::new(r, g, b) };
        radiance.into_iter().zip(&placed.surface.albedos).map(move |(value, rgb)| (value, albedo(*rgb)))
    })
}

/// The value of the channel with the largest albedo, for a white surface; none if all are black.
fn best(value: Rgb<f32>, albedo: Rgb<f32>) -> Option<f32> {
    let channels = value.to_array().into_iter().zip(albedo.to_array());
    let (value, albedo) = channels.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or_default();
    (albedo > 0.0).then(|| value / albedo)
}
