//! One light in the parts that engines take: the whole map, the map without its suns, suns, nine colors, chains.

use std::f64::consts::{FRAC_1_PI, FRAC_PI_2};

use lobe_io::Job;
use lobe_sh::{Coefficient as _, Dir, Rgb, Rotation, ShL2};

use crate::engines::engine::Engine;
use crate::engines::export_options::ExportOptions;
use crate::error::EnvError;
use crate::map::adjust::scale_in_place;
use crate::map::cube_average::averaged_to;
use crate::map::cube_map::CubeMap;
use crate::map::cube_mip_chain::CubeMipChain;
use crate::map::env_map::EnvMap;
use crate::map::mapped_map::MappedMap;
use crate::prefilter::options::PrefilterOptions;
use crate::prefilter::prefilter::prefilter_ggx;
use crate::prefilter::roughness_levels::RoughnessLevels;
use crate::projection::irradiance::irradiance_cube;
use crate::resample::cube_source::cube_source;
use crate::resample::resample::rotate_map;
use crate::sky::scene_light::SceneLight;
use crate::sky::sun_choice::SunChoice;
use crate::sky::sun_extraction::{Sun, SunOptions};
use crate::sky::suns::extract_suns;

/// Bands of nine colors.
const ORDER: usize = 3;

/// Which part of a light a picture shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Part {
    /// All of it: what is seen behind a scene.
    Whole,
    /// All but the suns that are lights of their own: what lights the scene beside them.
    WithoutSuns,
}

/// A light, and what several engines share of it.
pub(crate) struct LightParts<'a> {
    whole: &'a MappedMap,
    /// The map without the suns that were taken out; none if there are none.
    rest: Option<MappedMap>,
    suns: Vec<Sun>,
    /// Whether suns were taken out of the map, not added to it.
    are_of_map: bool,
    light: ShL2<Rgb<f64>>,
    source: Option<CubeMap>,
    chains: Vec<((RoughnessLevels, usize), CubeMipChain)>,
    size: usize,
    tolerance: f64,
}

impl<'a> LightParts<'a> {
    pub(crate) fn new(map: &'a MappedMap, suns: &SunChoice, size: usize, tolerance: f64) -> Result<Self, EnvError> {
        let split = SceneLight::of_map(map, ORDER, suns)?;
        let taken = if suns.looks() { split.suns().len() } else { 0 };
        let rest = (taken > 0).then(|| extract_suns(map, taken, &SunOptions::default()).rest);
        Ok(Self {
            whole: map,
            light: split.rest().to_fixed(),
            suns: split.suns().to_vec(),
            are_of_map: suns.looks(),
            rest,
            source: None,
            chains: Vec::new(),
            size,
            tolerance,
        })
    }

    /// The same with no more suns apart than an engine has lights for; none if these are no more.
    ///
    /// # Errors
    /// [`EnvError::Options`] if there are more suns in a file than the engine has lights for.
    pub(crate) fn limited<'b>(
        &self,
        engine: Engine,
        map: &'b MappedMap,
        options: &ExportOptions,
    ) -> Result<Option<LightParts<'b>>, EnvError> {
        let Some(most) = engine.facts().most_suns.filter(|most| *most < self.suns.len()) else { return Ok(None) };
        if !self.are_of_map {
            let text = format!("suns: {engine} has lights for {most}, found {}; give it fewer", self.suns.len());
            return Err(EnvError::Options(text));
        }
        let suns = if most == 0 { SunChoice::None } else { SunChoice::Count(most) };
        LightParts::new(map, &suns, options.size, options.tolerance).map(Some)
    }

    /// The suns that are lights of their own for an engine.
    pub(crate) fn suns(&self, traces_paths: bool) -> &[Sun] {
        if traces_paths && self.are_of_map { &[] } else { &self.suns }
    }

    /// The radiance of all but the suns.
    pub(crate) fn light(&self) -> &ShL2<Rgb<f64>> {
        &self.light
    }

    fn map(&self, part: Part) -> &MappedMap {
        match part {
            Part::Whole => self.whole,
            Part::WithoutSuns => self.rest.as_ref().unwrap_or(self.whole),
        }
    }

    /// A lat-long picture, turned by quarters about the vertical.
    pub(crate) fn panorama(&self, part: Part, quarters: i32, mut job: Job<'_>) -> Result<EnvMap, EnvError> {
        let map = self.map(part).clone().into_lat_long(job.reborrow())?;
        if quarters == 0 {
            return Ok(map);
        }
        let turn = Rotation::from_axis_angle(Dir::Z, f64::from(quarters) * FRAC_PI_2);
        rotate_map(&map, &turn, job)?.into_env_map()
    }

    /// The mirror, as a cube of the size of the chains.
    pub(crate) fn cube(&mut self, part: Part, job: Job<'_>) -> Result<CubeMap, EnvError> {
        if part == Part::Whole && self.rest.is_some() {
            let source = cube_source(self.whole, self.size, job)?;
            return Ok(self.averaged(&source));
        }
        self.prepare_source(job)?;
        let source = self.source.take();
        let cube = source.as_ref().map(|source| self.averaged(source));
        self.source = source;
        cube.ok_or(EnvError::Cancelled)
    }

    fn averaged(&self, source: &CubeMap) -> CubeMap {
        averaged_to(source, self.size)
    }

    fn prepare_source(&mut self, job: Job<'_>) -> Result<(), EnvError> {
        if self.source.is_none() {
            self.source = Some(cube_source(self.map(Part::WithoutSuns), self.size, job)?);
        }
        Ok(())
    }

    /// The prefiltered chain of all but the suns.
    pub(crate) fn chain(
        &mut self,
        (roughness, last_size): (RoughnessLevels, usize),
        mut job: Job<'_>,
    ) -> Result<&CubeMipChain, EnvError> {
        let wanted = (roughness, last_size.min(self.size));
        if !self.chains.iter().any(|(key, _)| *key == wanted) {
            self.prepare_source(job.step("convert"))?;
            let options = PrefilterOptions::default().size(self.size).roughness(wanted.0).last_size(wanted.1);
            let Some(source) = &self.source else { return Err(EnvError::Cancelled) };
            let chain = prefilter_ggx(source, &options.tolerance(self.tolerance), job.step("prefilter"))?;
            self.chains.push((wanted, chain));
        }
        let found = self.chains.iter().find(|(key, _)| *key == wanted);
        found.map(|(_, chain)| chain).ok_or(EnvError::Cancelled)
    }

    /// What a white surface sends back of all but the suns, `E/π`, for each direction that it may face.
    pub(crate) fn diffuse(&self, size: usize) -> Result<CubeMap, EnvError> {
        let mut cube = MappedMap::from(irradiance_cube(self.map(Part::WithoutSuns), ORDER, size)?);
        scale_in_place(&mut cube, Rgb::splat(FRAC_1_PI))?;
        cube.into_cube_map()
    }
}
