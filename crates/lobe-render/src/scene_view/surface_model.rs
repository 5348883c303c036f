//! Models of reflection of surfaces whose light is known: what a point sends to the eye of the light that reaches it.

use std::f64::consts::FRAC_1_PI;

use lobe_env::Sun;
use lobe_sh::{Coefficient as _, Dir, Rgb};

use crate::scene_view::scene_picture::SceneHit;

/// What a scene under a light says of its surfaces, suns left out.
pub trait LitSurfaces: Sync {
    /// The radiance that a hit sends to the eye if its surface is matte, of the base color.
    fn matte(&self, hit: &SceneHit<'_>) -> Rgb<f64>;

    /// What the lobe of GGX microfacets of this roughness about a direction meets around a hit.
    fn surroundings(&self, _hit: &SceneHit<'_>, _axis: Dir, _roughness: f64) -> Surroundings {
        Surroundings::UNKNOWN
    }

    /// Whether surfaces hide suns from each other.
    fn hide_suns(&self) -> bool {
        true
    }
}

impl<F: Fn(&SceneHit<'_>) -> Rgb<f64> + Sync> LitSurfaces for F {
    fn matte(&self, hit: &SceneHit<'_>) -> Rgb<f64> {
        self(hit)
    }
}

/// What is around a point of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surroundings {
    /// The part of the lobe that leaves the scene, 0 to 1.
    pub open: f64,
    /// The part of the hemisphere that does, by the cosine, 0 to 1: ambient occlusion. None where it is not known.
    pub ambient: Option<f64>,
    /// The mean radiance of the surfaces that hide the rest.
    pub others: Rgb<f64>,
}

impl Surroundings {
    /// Of a point of which nothing is known: the lobe leaves the scene.
    pub const UNKNOWN: Self = Self { open: 1.0, ambient: None, others: Rgb::ZERO };

    /// Of a point that nothing hides.
    pub const OPEN: Self = Self { ambient: Some(1.0), ..Self::UNKNOWN };
}

/// The light that reaches a hit.
pub struct SurfaceLight<'a> {
    /// What is known of it but for suns.
    pub lit: &'a dyn LitSurfaces,
    /// Suns that shine on it, with the irradiance by the part of their disc that is seen from there.
    pub suns: &'a [(Sun, Rgb<f64>)],
}

/// A model of reflection.
pub trait SurfaceModel: Sync {
    /// Whether it asks for [`LitSurfaces::surroundings`].
    fn looks_around(&self) -> bool;

    /// The radiance that a hit sends to the eye.
    fn radiance(&self, hit: &SceneHit<'_>, light: &SurfaceLight<'_>) -> Rgb<f64>;
}

/// Lambert's model with the base color as albedo: metals are matte, and nothing emits light.
#[derive(Clone, Copy, Debug)]
pub struct MatteSurfaces;

impl SurfaceModel for MatteSurfaces {
    fn looks_around(&self) -> bool {
        false
    }

    fn radiance(&self, hit: &SceneHit<'_>, light: &SurfaceLight<'_>) -> Rgb<f64> {
        let matte = light.lit.matte(hit);
        if light.suns.is_empty() { matte } else { matte + (hit.albedo * light.of_suns()).scale(FRAC_1_PI) }
    }
}

impl SurfaceLight<'_> {
    /// The irradiance by all suns.
    #[must_use]
    pub fn of_suns(&self) -> Rgb<f64> {
        self.suns.iter().fold(Rgb::ZERO, |all, (_, irradiance)| all + *irradiance)
    }
}
