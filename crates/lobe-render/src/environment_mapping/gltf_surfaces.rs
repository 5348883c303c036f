//! The metallic-roughness model of glTF, where the light of surfaces is known by transfer or by maps.

use std::f64::consts::FRAC_1_PI;

use lobe_env::{EnvMap, Sun, reconstruct};
use lobe_io::Job;
use lobe_scene::Finish;
use lobe_sh::sphere::vector::{dot, tangents_along_z};
use lobe_sh::{Coefficient as _, Dir, Rgb, Rotation, ShVec};

use crate::environment_mapping::options::EnvironmentMapOptions;
use crate::environment_mapping::reflection_maps::ReflectionMaps;
use crate::error::RenderError;
use crate::path_tracer::bsdf::{DIELECTRIC, fresnel};
use crate::path_tracer::ggx::Facets;
use crate::path_tracer::surfaces::Surfaces;
use crate::scene_view::scene_picture::SceneHit;
use crate::scene_view::surface_model::{SurfaceLight, SurfaceModel};

/// Columns of the map that an expansion is made: the finest waves of order 8 are 36 texels long.
const OF_EXPANSION: usize = 256;

/// What shiny surfaces reflect of a light: it is prefiltered once for all of its turns.
#[derive(Clone, Debug)]
pub struct Reflections {
    maps: ReflectionMaps,
    is_separable: bool,
}

impl Reflections {
    /// Prefilters a light, without its suns where they stand apart; `options` name the model, which is not matte.
    ///
    /// The job hears of one step after the other; it cannot be kept in a file. The same bits for any number of threads.
    ///
    /// # Errors
    /// As [`EnvironmentMaps::new`](crate::EnvironmentMaps::new); [`RenderError::Options`] for matte surfaces.
    pub fn new(light: EnvMap, options: &EnvironmentMapOptions, job: Job<'_>) -> Result<Self, RenderError> {
        job.expect_no_checkpoint().map_err(RenderError::Options)?;
        options.check()?;
        if options.surfaces == Surfaces::Matte {
            return Err(RenderError::Options("expected surfaces that reflect, found matte ones".to_owned()));
        }
        let is_separable = options.surfaces == Surfaces::MetallicRoughnessSeparable;
        Ok(Self { maps: ReflectionMaps::new(light, options, job)?, is_separable })
    }

    /// The same of an expansion, as a map of it.
    ///
    /// # Errors
    /// As [`Reflections::new`].
    pub fn of_expansion(
        light: &ShVec<Rgb<f64>>,
        options: &EnvironmentMapOptions,
        job: Job<'_>,
    ) -> Result<Self, RenderError> {
        Self::new(reconstruct(light, OF_EXPANSION, OF_EXPANSION / 2), options, job)
    }

    /// The surfaces under the light turned: what was towards `s` is towards `R s`.
    #[must_use]
    pub fn turned(&self, rotation: &Rotation) -> GltfSurfaces<'_> {
        self.turned_back(rotation.inverse())
    }

    /// The surfaces under the light turned, by the rotation from directions of the world to its own.
    pub(crate) fn turned_back(&self, light_from_world: Rotation) -> GltfSurfaces<'_> {
        GltfSurfaces { reflections: self, light_from_world }
    }
}

/// Surfaces of the metallic-roughness model of glTF 2.0 under a light that is turned.
///
/// ```text
///   B = o (1 - F₀) (1 - metallic) B_matte + (F₀ scale + bias) (o O P(a, roughness) + (1 - O) B_others) + emission
///       + Σ_suns E_sun ((1 - F) (1 - metallic) c/π + F D V)
///   F₀ = 0.04 + (c - 0.04) metallic
/// ```
///
/// `B_matte` is what a matte surface of the base color `c` would send, such as by transfer; `P` the light prefiltered
/// for the roughness, about the mean direction `a` of the lobe, and `F₀ scale + bias` the reflectance in even light:
/// the split sum of [`EnvironmentMaps`](crate::EnvironmentMaps). `O` is the open part of the lobe and `B_others` the
/// mean radiance of the surfaces that hide the rest ([`Surroundings`](crate::Surroundings)). `E_sun` is the irradiance
/// by what is seen of a sun. For `F D V` its disc is a direction, and the lobe is as much wider as the half vectors `h`
/// of the disc are:
///
/// ```text
///   α² = roughness⁴ + sin²(radius) / (4 v·h)
/// ```
///
/// A mirror shows the middle of the sun at its radiance, therefore. `o` is the occlusion of the material's texture
/// where that hides more than the triangles do, their ratio, else 1.
///
/// A surface seen from below its shading normal has no mirror.
#[derive(Clone, Copy, Debug)]
pub struct GltfSurfaces<'a> {
    reflections: &'a Reflections,
    light_from_world: Rotation,
}

impl SurfaceModel for GltfSurfaces<'_> {
    fn looks_around(&self) -> bool {
        true
    }

    fn radiance(&self, hit: &SceneHit<'_>, light: &SurfaceLight<'_>) -> Rgb<f64> {
        let finish = hit.finish();
        let [metallic, roughness] = [finish.metallic, finish.roughness].map(f64::from);
        let cos_view = hit.normal.dot(hit.view);
        let maps = &self.reflections.maps;
        let axis = if cos_view > 0.0 { maps.axis(hit.reflected(), hit.normal, roughness) } else { hit.normal };
        let around = light.lit.surroundings(hit, axis, roughness);
        // Hidden by what triangles do not show alone; unknown shadows are in the matte part already.
        let own = f64::from(finish.occlusion);
        let occlusion = around.ambient.map_or(own, |ambient| (own / ambient.max(f64::MIN_POSITIVE)).min(1.0));
        let of_matte = if around.ambient.is_some() { occlusion } else { 1.0 };
        let matte = light.lit.matte(hit).scale(of_matte * (1.0 - metallic));
        let emission = Rgb::from(finish.emission).widen();
        if cos_view <= 0.0 {
            let suns = (hit.albedo * light.of_suns()).scale((1.0 - metallic) * FRAC_1_PI);
            return matte + suns + emission;
        }
        let f0 = Rgb::from(hit.albedo.to_array().map(|c| DIELECTRIC + (c - DIELECTRIC) * metallic));
        let prefiltered = maps.radiance(self.light_from_world.rotate_dir(axis), roughness);
        let seen = prefiltered.scale(occlusion * around.open) + around.others.scale(1.0 - around.open);
        let mirrored = maps.reflectance(cos_view, roughness, f0) * seen;
        let suns = light.suns.iter().map(|sun| self.of_sun(hit, &finish, f0, sun));
        let suns = suns.fold(Rgb::ZERO, |all, sun| all + sun);
        (Rgb::splat(1.0) - f0) * matte + mirrored + suns + emission
    }
}

impl GltfSurfaces<'_> {
    fn of_sun(
        &self,
        hit: &SceneHit<'_>,
        finish: &Finish,
        f0: Rgb<f64>,
        (sun, irradiance): &(Sun, Rgb<f64>),
    ) -> Rgb<f64> {
        let (n, v, l) = (hit.normal.to_array(), hit.view.to_array(), sun.direction.to_array());
        let [t, b] = tangents_along_z(n);
        let in_frame = |s: [f64; 3]| [dot(t, s), dot(b, s), dot(n, s)];
        let half = Dir::new([v[0] + l[0], v[1] + l[1], v[2] + l[2]]);
        let cos = half.map_or(1.0, |half| hit.view.dot(half).clamp(0.0, 1.0));
        let f = fresnel(f0, cos);
        let radius = (0.5 * sun.angular_diameter).sin();
        let wide = 0.25 * radius * radius / cos.max(radius);
        let alpha = (f64::from(finish.roughness).powi(4) + wide).sqrt().min(1.0);
        let facets = Facets { alpha, is_separable: self.reflections.is_separable };
        let matte = hit.albedo.scale((1.0 - f64::from(finish.metallic)) * FRAC_1_PI);
        let reflected = (Rgb::splat(1.0) - f) * matte + f.scale(facets.reflectance(in_frame(v), in_frame(l)));
        reflected * *irradiance
    }
}
