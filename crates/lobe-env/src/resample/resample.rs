//! Resampling of a map: to any mapping, at any size, turned by any rotation.

use std::borrow::Cow;

use lobe_io::Job;
use lobe_sh::Rotation;

use crate::error::EnvError;
use crate::map::env_map::EnvMap;
use crate::map::finite::{all_finite, expect_finite};
use crate::map::mapped_map::MappedMap;
use crate::mapping::grid::Grid;
use crate::mapping::mapping::Mapping;
use crate::resample::balance::Balance;
use crate::resample::passes::Passes;
use crate::resample::sample_points::Sampler;

/// Two texel centers coincide if they are no farther apart than this, in texels: the rounding of a quarter turn.
const SAME_POINT: f64 = 1e-6;

/// The target of a resampling.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Resample {
    /// The mapping of the target.
    pub mapping: Mapping,
    /// The number of columns.
    pub width: usize,
    /// The number of rows.
    pub height: usize,
    /// The rotation `R` of the surroundings: the target shows towards `R s` what the source shows towards `s`.
    pub rotation: Option<Rotation>,
}

impl Resample {
    /// To `width` x `height` texels of `mapping`, without rotation.
    #[must_use]
    pub fn to(mapping: Mapping, width: usize, height: usize) -> Self {
        Self { mapping, width, height, rotation: None }
    }

    /// With this rotation of the surroundings.
    #[must_use]
    pub fn rotated(self, rotation: Rotation) -> Self {
        Self { rotation: Some(rotation), ..self }
    }
}

/// Resamples a map: to another mapping or size, or turned.
///
/// ```text
///   L'_t = (1/Ω_t) ∫_{texel t} L(R⁻¹ s) ds
/// ```
///
/// One rule for shrinking and enlarging: each texel is the mean of the source, interpolated bilinearly across every
/// seam ([`MappedMap::radiance`]), over its solid angle Ω; and the weights are balanced so that each texel of the
/// source keeps its energy wherever it lies:
///
/// ```text
///   L'_t = b Σ_s V_ts (L_s + q_s max(0, L_s - m_s))      Σ_s V_ts = 1
///   q_s = Ω_s / (Σ_t Ω_t V_ts) - 1                       |1 - 1/b| <= 1e-3
/// ```
///
/// where `m_s` is the mean of the texel's neighbors in the picture and V the weights of the interpolation, with rows
/// and columns scaled [Sinkhorn and Knopp 1967] until the mean lacks little beyond q. The factor b
/// of each channel gives it back: 1 where less than 5e-6 of the light that is no excess is lacking, else at
/// most a thousandth of all light of the channel, which a sun of many texels may lose to the sky: more than a
/// thousandth of a sun that has little of the light
/// (`suns_of_many_texels_take_few_passes_stay_even_and_keep_their_energy`). So
///
/// * a constant stays constant, to 1e-6 (`constant_maps_stay_constant_at_every_size`);
/// * the mean of every channel is kept to 1e-4 through chains of ten and twelve conversions
///   (`the_mean_is_kept_through_chains_of_mappings`, `the_mean_is_kept_through_any_chain`);
/// * a sun of one texel keeps its energy to 1 %, and its place to a texel: its center moves by no more than the
///   distance to the farthest point of its texel, in the source or the target
///   (`a_sun_of_one_texel_keeps_energy_and_place_through_every_pair_of_mappings`);
/// * interpolation blurs: with texels of the width δ, band l loses about l(l+1) δ²/8 in each conversion, more at the
///   rim of a ball, whose texels are long (`band_limited_maps_keep_their_coefficients_through_every_pair`).
///
/// Where the two grids coincide, texels are copied: a map of the same mapping and size without rotation, a cube turned
/// by quarter turns about its axes. In parallel over fixed chunks: the same bits for any number of threads
/// (`any_number_of_threads_gives_the_same_bits`).
///
/// An owned map, `resample(map, ..)`, is changed in place; a borrowed one, `resample(&map, ..)`, is copied.
///
/// Texels should be finite; one that is not spreads to those whose footprints touch it or its neighbors, and no further
/// (`a_texel_that_is_not_finite_takes_no_more_passes_and_spreads_no_further_than_its_footprint`).
///
/// Progress counts rows of the target, in each pass over them, on the calling thread: three passes at least, and
/// [`total`](lobe_io::Progress::total) grows where the weights need more. The job cannot be resumed.
///
/// ```
/// use lobe_env::{Mapping, Resample, bundled, resample};
/// use lobe_io::Job;
///
/// let sunset = bundled::sunset().map();
/// let cube = resample(&sunset, &Resample::to(Mapping::Cube, 32, 192), Job::default())?;
/// assert!((cube.mean().g / sunset.mean().g - 1.0).abs() < 1e-3);
/// # Ok::<(), lobe_env::EnvError>(())
/// ```
///
/// # Errors
/// [`EnvError::Options`] if a side is 0 or a cube's picture is not six times as high as wide, if finite light becomes
/// more than `f32` holds, or for a job with a checkpoint; [`EnvError::Cancelled`] if the watch of the job said to stop.
pub fn resample<'a>(map: impl Into<Cow<'a, MappedMap>>, to: &Resample, job: Job<'_>) -> Result<MappedMap, EnvError> {
    let map = map.into();
    MappedMap::check(to.mapping, to.width, to.height)?;
    let was_finite = all_finite(map.texels());
    let mut passes = Passes::new(job, to.height)?;
    let (source, target) = (map.grid(), Grid::new(to.mapping, to.width, to.height));
    let sampler = Sampler::new(source, target, to.rotation.as_ref());
    // Copy texels where the grids coincide; integrate over footprints elsewhere.
    let texels = match copied(&sampler, to.rotation.is_some()) {
        Some(numbers) => numbers.iter().map(|&k| map.texels()[k as usize]).collect(),
        None => Balance::resample(&sampler, map.into_owned(), &mut passes)?,
    };
    passes.finish()?;
    // A texel that is alone among dark ones is brightened by what it would lose.
    expect_finite(&texels, "the resampled light", || was_finite)?;
    Ok(MappedMap::from_rows(to.mapping, to.width, to.height, texels))
}

impl MappedMap {
    /// The number of rows at which a map of `mapping` has about as many texels on the sphere as this one; of a cube map
    /// the size of a face, a power of two.
    #[must_use]
    pub fn size_like(&self, mapping: Mapping) -> usize {
        if self.mapping() == mapping {
            return self.height() / mapping.faces();
        }
        let texels = shown(self.mapping()) * (self.width() * self.height()) as f64;
        let [across, down] = mapping.picture_size(1);
        mapping.form().usual_size((texels / (shown(mapping) * (across * down) as f64)).sqrt())
    }

    /// The map as a lat-long one: itself if it is one, or else [resampled](resample()) to about as many texels.
    ///
    /// # Errors
    /// [`EnvError::Options`] if those are more than a map may have, and the errors of [`resample()`].
    pub fn into_lat_long(self, job: Job<'_>) -> Result<EnvMap, EnvError> {
        if self.mapping() == Mapping::LatLong {
            return self.into_env_map();
        }
        let rows = self.size_like(Mapping::LatLong);
        resample(self, &Resample::to(Mapping::LatLong, 2 * rows, rows), job)?.into_env_map()
    }
}

/// The fraction of a picture's area that shows the sphere: the inscribed discs, or all of it.
fn shown(mapping: Mapping) -> f64 {
    if mapping.form().discs() > 0 { std::f64::consts::FRAC_PI_4 } else { 1.0 }
}

/// Rotates a map, keeping mapping and size: the result shows towards `R s` what `map` shows towards `s`.
///
/// # Errors
/// Those of [`resample()`] for its job.
pub fn rotate_map(map: &MappedMap, rotation: &Rotation, job: Job<'_>) -> Result<MappedMap, EnvError> {
    resample(map, &Resample::to(map.mapping(), map.width(), map.height()).rotated(*rotation), job)
}

/// For each target texel the index of the source texel to copy, where the two grids coincide.
fn copied(sampler: &Sampler, is_turned: bool) -> Option<Vec<u32>> {
    let grid = sampler.target;
    if sampler.source != grid {
        return None;
    }
    if !is_turned {
        return Some((0..grid.len() as u32).collect());
    }
    let number = |index: usize| {
        let at = |i: usize, n: usize| (i as f64 + 0.5) / n as f64;
        let center =
            grid.mapping.dir_from_uv(at(index % grid.width, grid.width), at(index / grid.width, grid.height))?;
        let p = grid.point(sampler.to_source(center));
        let is_center = p.iter().all(|c| (c - c.floor() - 0.5).abs() < SAME_POINT);
        is_center.then(|| grid.texel(p) as u32)
    };
    (0..grid.len()).map(number).collect()
}
