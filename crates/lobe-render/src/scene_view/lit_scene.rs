//! A baked scene under one light.

use lobe_env::SceneLight;
use lobe_prt::{AlbedoMode, BakeMode, Transfer};
use lobe_sh::{Coefficient as _, Dir, Rgb};

use crate::scene_view::baked_scene::BakedScene;
use crate::scene_view::openness::Openness;
use crate::scene_view::placed_transfer::PlacedTransfer;
use crate::scene_view::prt_shading::{LitReceivers, SurfaceTransfer};
use crate::scene_view::scene_picture::SceneHit;
use crate::scene_view::surface_model::{LitSurfaces, Surroundings};

/// A [`BakedScene`] under one light.
pub struct LitScene<'a> {
    baked: &'a BakedScene,
    front: LitReceivers,
    back: Option<(&'a PlacedTransfer, LitReceivers)>,
    suns: SunsApart,
    /// What fronts and backs see around them, where that is known.
    around: [Option<Around<'a>>; 2],
    light: SceneLight,
}

/// What receivers of one side see around them.
struct Around<'a> {
    openness: Openness<&'a Transfer>,
    /// The receivers of places; without it, they are the places.
    placed: Option<&'a PlacedTransfer>,
    /// What all other surfaces send to each: of fronts by place, of backs by receiver. None where nothing reflects.
    others: Option<Vec<Rgb<f32>>>,
}

impl<'a> LitScene<'a> {
    /// The light whose suns are to be added to [`LitScene::radiance`]: as they shine between surfaces, or past them if
    /// [nothing hides them](LitSurfaces::hide_suns). It has none if the radiance has all light.
    #[must_use]
    pub fn by_rays(&self) -> SceneLight {
        match self.suns {
            SunsApart::No => self.light.whole().into(),
            SunsApart::Apart | SunsApart::Reflected => self.light.clone(),
        }
    }

    /// The radiance towards the eye at a hit, interpolated between vertices or texels; black for backs that are not
    /// baked.
    #[must_use]
    pub fn radiance(&self, hit: &SceneHit<'_>) -> Rgb<f64> {
        let BakedScene { scene, places, gloss, options, .. } = self.baked;
        let mut sum = Rgb::ZERO;
        for (place, weight) in places.around(scene, hit) {
            let of_receiver = match &self.back {
                _ if hit.is_front => Some((&self.front, place)),
                Some((backs, lit)) => backs.receiver(place).map(|receiver| (lit, receiver)),
                None => None,
            };
            if let Some((lit, receiver)) = of_receiver {
                sum += lit.radiance(receiver, hit).scale(weight);
            }
        }
        match gloss {
            Some(gloss) => gloss.albedo(hit) * sum,
            None if options.albedo == AlbedoMode::None => hit.albedo * sum,
            None => sum,
        }
    }

    /// The same, and what hides reflections of its surfaces: of matte transfer that is not compressed, where the direct
    /// part is [known](BakedScene::bake_direct).
    #[must_use]
    pub fn with_surroundings(self) -> Self {
        let around = self.around().unwrap_or_default();
        Self { around, ..self }
    }

    fn around(&self) -> Option<[Option<Around<'a>>; 2]> {
        let BakedScene { front, back, direct, options, .. } = self.baked;
        if self.baked.is_glossy() || options.mode == BakeMode::Unshadowed {
            return None;
        }
        let of = |transfer: &'a SurfaceTransfer, placed, others| {
            Some(Around { openness: Openness::of(transfer, options.albedo)?, placed, others })
        };
        if options.most_bounces() == 0 {
            let back = back.as_ref().and_then(|back| of(&back.transfer, Some(back), None));
            return Some([of(front, None, None), back]);
        }
        // What other surfaces send is all less what the light sends.
        let (whole, direct) = (self.light.whole(), direct.as_ref()?);
        let mut others = front.lit(&whole, None);
        direct.front.subtract_from(&mut others, &whole);
        let front = of(&direct.front.transfer, Some(&direct.front), others.into_matte());
        let back = back.as_ref().zip(direct.back.as_ref()).and_then(|(back, direct)| {
            let mut others = back.transfer.lit(&whole, None);
            others.subtract_each(&direct.transfer.lit(&whole, None));
            of(&direct.transfer, Some(direct), others.into_matte())
        });
        Some([front, back])
    }
}

impl LitSurfaces for LitScene<'_> {
    fn matte(&self, hit: &SceneHit<'_>) -> Rgb<f64> {
        self.radiance(hit)
    }

    fn surroundings(&self, hit: &SceneHit<'_>, axis: Dir, roughness: f64) -> Surroundings {
        let Some(around) = &self.around[usize::from(!hit.is_front)] else { return Surroundings::UNKNOWN };
        let (mut receivers, mut others, mut whole) = (Vec::with_capacity(4), Rgb::<f64>::ZERO, 0.0);
        for (place, weight) in self.baked.places.around(&self.baked.scene, hit) {
            let receiver = around.placed.map_or(Some(place), |placed| placed.receiver(place));
            let Some(receiver) = receiver else { continue };
            receivers.push((receiver, weight));
            whole += weight;
            if let Some(of) = &around.others {
                others += of[if hit.is_front { place } else { receiver }].widen().scale(weight);
            }
        }
        if whole <= 0.0 {
            return Surroundings::UNKNOWN;
        }
        // Backs may lack some.
        let part = f64::recip(whole);
        let receivers = receivers.into_iter().map(|(receiver, weight)| (receiver, part * weight));
        around.openness.surroundings(hit, (axis, roughness), receivers, others.scale(part))
    }

    fn hide_suns(&self) -> bool {
        self.baked.options.mode != BakeMode::Unshadowed
    }
}

impl BakedScene {
    /// Lights the scene: the exit radiance of every receiver is computed here, once for each light, without the direct
    /// light of suns that are [lit by rays](LitScene::by_rays).
    ///
    /// `light` is the radiance of the surroundings in the world, of any order.
    #[must_use]
    pub fn lit(&self, light: &SceneLight) -> LitScene<'_> {
        let (gloss, suns) = (self.gloss.as_ref(), self.suns_apart(light));
        let all = match suns {
            SunsApart::Apart => light.rest(),
            SunsApart::No | SunsApart::Reflected => &light.whole(),
        };
        let mut front = self.front.lit(all, gloss);
        let mut back = self.back.as_ref().map(|back| (back, back.transfer.lit(all, gloss)));
        if let (SunsApart::Reflected, Some(direct)) = (&suns, &self.direct) {
            let of_suns = light.of_suns();
            direct.front.subtract_from(&mut front, &of_suns);
            if let (Some((places, back)), Some(direct)) = (&mut back, &direct.back) {
                back.subtract_each(&direct.transfer.lit(&of_suns, None));
                debug_assert_eq!(places.places(), direct.places(), "the same backs");
            }
        }
        LitScene { baked: self, front, back, suns, around: [None, None], light: light.clone() }
    }

    fn suns_apart(&self, light: &SceneLight) -> SunsApart {
        match self.options.mode {
            _ if light.suns().is_empty() || self.is_glossy() => SunsApart::No,
            BakeMode::Unshadowed => SunsApart::Apart,
            _ if self.options.most_bounces() == 0 => SunsApart::Apart,
            _ if self.knows_direct() => SunsApart::Reflected,
            _ => SunsApart::No,
        }
    }
}

/// How suns light a scene.
enum SunsApart {
    /// They are in the expansion.
    No,
    /// By themselves; transfer has no other light of theirs.
    Apart,
    /// By themselves, and what surfaces reflect of them by transfer.
    Reflected,
}
