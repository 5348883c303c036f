//! The maps of a light by which surfaces are lit, and what a surface sends to the eye by them.

use std::f64::consts::FRAC_1_PI;

use lobe_env::{EnvError, EnvMap, Mapping, Resample, irradiance_map_brute_force, resample};
use lobe_io::Job;
use lobe_sh::{Coefficient as _, Dir, Rgb, Rotation};

use crate::environment_mapping::gltf_surfaces::Reflections;
use crate::environment_mapping::options::EnvironmentMapOptions;
use crate::error::RenderError;
use crate::path_tracer::surfaces::Surfaces;
use crate::scene_view::scene_picture::SceneHit;
use crate::scene_view::surface_model::{LitSurfaces, SurfaceLight, SurfaceModel as _, Surroundings};

/// Rows of the map of irradiance, whose texels are 3° wide: interpolated between them, a white surface under a light of three bands and
/// of the mean 1 is within 0.001 (test `matte_surfaces_show_the_irradiance_of_the_light_in_closed_form`).
const ROWS: usize = 64;

/// A light of more rows, or of more than twice as many columns, is averaged to these before its irradiance is summed up, which takes
/// each of its texels once for each of the map.
const LIGHT_ROWS: usize = 2 * ROWS;

/// Environment mapping, the classic form: a light as a map of irradiance and, for shiny surfaces, as maps prefiltered for rising
/// roughness. Surfaces look them up by their normal and by the mirrored view; they neither shade nor mirror each other.
///
/// ```text
///   matte     B = c/π E(n)                                              c: base color
///   glTF      B = o (1 - F₀) (1 - metallic) c/π E(n) + o (F₀ scale + bias) P(a, roughness) + emission
///             F₀ = 0.04 + (c - 0.04) metallic
/// ```
///
/// `E` is the irradiance, `P` the light under the lobe of GGX with view and normal taken for one direction
/// ([`prefilter_ggx`](lobe_env::prefilter_ggx), test `each_level_keeps_of_each_band_what_its_lobe_keeps`), `F₀ scale + bias` the reflectance in
/// even light ([`Dfg`](lobe_env::Dfg) at `n·v` and the roughness): the split sum of [Karis 2013]. He looks `P` up about
/// the mirrored direction; `a` is the mean direction of the lobe, which leans from there to the normal. For a convex
/// body and the same [`Surfaces`] this is the picture of [`render_truth`](crate::render_truth) without bounces, but for
///
/// * the split sum, whose lobe is round. Balls of white metal under smooth light are off by 0.4 % at roughness 0.29,
///   1.1 % at 0.5 and 1.6 % at 1 (RMS), about the mirrored direction by 1.6, 7 and 25 %; a mirror is exact (test
///   `a_ball_is_as_the_truth_but_for_the_split_sum`);
/// * `1 - F₀` in place of the mean of `1 - F` over the light, which is less by 0.0001 along the normal, 0.005 at 60° and 0.02 at
///   84°;
/// * roughness between 0, 0.13, 0.29, 0.5 and 1, where two levels are mixed.
///
/// A surface seen from below its shading normal has no mirror, as in the truth.
///
/// [Karis 2013]: https://blog.selfshadow.com/publications/s2013-shading-course/karis/s2013_pbs_epic_notes_v2.pdf
#[derive(Clone, Debug)]
pub struct EnvironmentMaps {
    irradiance: EnvMap,
    /// None if surfaces are matte.
    reflections: Option<Reflections>,
}

impl EnvironmentMaps {
    /// Makes the maps of a light.
    ///
    /// The job hears of one step after the other, each from 0 to its own total; it cannot be kept in a file. The same bits for any
    /// number of threads.
    ///
    /// # Errors
    /// [`RenderError::Options`] for options out of their range and for a job with a file, [`RenderError::Env`] if a map would have
    /// more texels than there can be, or light beyond what `f32` holds, [`RenderError::Cancelled`] if the watch of the job said
    /// to stop.
    pub fn new(light: EnvMap, options: &EnvironmentMapOptions, mut job: Job<'_>) -> Result<Self, RenderError> {
        job.expect_no_checkpoint().map_err(RenderError::Options)?;
        options.check()?;
        let irradiance = irradiance_of(&light, job.reborrow())?;
        let reflections = match options.surfaces {
            Surfaces::Matte => None,
            Surfaces::MetallicRoughness | Surfaces::MetallicRoughnessSeparable => {
                Some(Reflections::new(light, options, job)?)
            }
        };
        Ok(Self { irradiance, reflections })
    }

    /// The light turned: what was towards `s` is towards `R s`. The maps stay as they are.
    #[must_use]
    pub fn turned(&self, rotation: &Rotation) -> TurnedMaps<'_> {
        TurnedMaps { maps: self, light_from_world: rotation.inverse() }
    }
}

/// [`EnvironmentMaps`] of a light that is turned.
#[derive(Clone, Copy, Debug)]
pub struct TurnedMaps<'a> {
    maps: &'a EnvironmentMaps,
    light_from_world: Rotation,
}

impl TurnedMaps<'_> {
    /// The radiance that a surface sends to the eye, as [`EnvironmentMaps`] has the formula.
    #[must_use]
    pub fn radiance(&self, hit: &SceneHit<'_>) -> Rgb<f64> {
        let Some(reflections) = &self.maps.reflections else { return self.matte(hit) };
        reflections.turned_back(self.light_from_world).radiance(hit, &SurfaceLight { lit: self, suns: &[] })
    }

    fn irradiance(&self, normal: Dir) -> Rgb<f64> {
        self.maps.irradiance.radiance(self.light_from_world.rotate_dir(normal)).widen()
    }
}

impl LitSurfaces for TurnedMaps<'_> {
    fn matte(&self, hit: &SceneHit<'_>) -> Rgb<f64> {
        (hit.albedo * self.irradiance(hit.normal)).scale(FRAC_1_PI)
    }

    fn surroundings(&self, _hit: &SceneHit<'_>, _axis: Dir, _roughness: f64) -> Surroundings {
        Surroundings::OPEN
    }
}

/// The irradiance of every normal, as a lat-long map.
fn irradiance_of(light: &EnvMap, mut job: Job<'_>) -> Result<EnvMap, EnvError> {
    if light.width() <= 2 * LIGHT_ROWS && light.height() <= LIGHT_ROWS {
        return irradiance_map_brute_force(light, 2 * ROWS, ROWS, job);
    }
    let to = Resample::to(Mapping::LatLong, 2 * LIGHT_ROWS, LIGHT_ROWS);
    let averaged = resample(light, &to, job.reborrow())?.into_env_map()?;
    irradiance_map_brute_force(&averaged, 2 * ROWS, ROWS, job)
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use lobe_io::Progress;

    use super::*;

    #[test]
    fn a_light_that_is_wide_or_high_is_averaged_before_its_irradiance_is_summed_up() {
        let (most_wide, most_high) = (2 * LIGHT_ROWS, LIGHT_ROWS);
        for (width, height, is_averaged) in
            [(most_wide, 1, false), (1, most_high, false), (most_wide + 1, 1, true), (1, most_high + 1, true)]
        {
            let light = EnvMap::from_fn(width, height, |_| Rgb::splat(1.0));
            // What the job hears of first: of the sums, each texel of the irradiance.
            let mut first = None;
            let mut watch = |progress: &Progress| {
                first = first.or(Some(progress.total));
                ControlFlow::Break(())
            };
            let stopped = irradiance_of(&light, Job::default().watched_by(&mut watch));
            assert!(matches!(stopped, Err(EnvError::Cancelled)), "{width} x {height}: stopped");
            assert_eq!(first != Some(2 * ROWS * ROWS), is_averaged, "{width} x {height}: {first:?} steps");
        }
    }
}
