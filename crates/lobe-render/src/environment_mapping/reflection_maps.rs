//! Maps of what shiny surfaces reflect: the light for mirrors, prefiltered levels for rough ones, and the table that goes with
//! them.

use lobe_env::{
    EnvError, EnvMap, LobeTable, MappedMap, Mapping, PrefilterOptions, Resample, RoughnessLevels, cube_source,
    prefilter_ggx, resample,
};
use lobe_io::Job;
use lobe_sh::{Coefficient as _, Dir, Rgb};

use crate::environment_mapping::options::EnvironmentMapOptions;
use crate::path_tracer::sphere_table::cell;
use crate::path_tracer::surfaces::Surfaces;

/// The light by direction and roughness, and the reflectance by angle and roughness.
#[derive(Clone, Debug)]
pub(crate) struct ReflectionMaps {
    mirror: Mirror,
    /// The levels after that of the mirror.
    rough: Vec<MappedMap>,
    lobes: LobeTable,
    /// The roughness of the levels.
    spacing: RoughnessLevels,
}

/// What a mirror shows.
#[derive(Clone, Debug)]
enum Mirror {
    /// The light itself, constant over each texel, as it is seen behind the scene.
    Texels(EnvMap),
    /// A picture of it, interpolated between texels.
    Stored(MappedMap),
}

impl ReflectionMaps {
    pub(crate) fn new(light: EnvMap, options: &EnvironmentMapOptions, mut job: Job<'_>) -> Result<Self, EnvError> {
        // Prefilter the light as cubes.
        let source = cube_source(&light, options.size, job.reborrow())?;
        let prefilter = PrefilterOptions::of_reflections(options.size);
        let chain = prefilter_ggx(&source, &prefilter, job.reborrow())?;
        drop(source);
        let rough: Vec<MappedMap> = chain.levels()[1..].iter().cloned().map(MappedMap::from).collect();
        let is_separable = options.surfaces == Surfaces::MetallicRoughnessSeparable;
        let spacing = prefilter.roughness;
        let lobes = if is_separable { LobeTable::separable() } else { LobeTable::correlated() };
        // Store the light and the levels in the mapping that is asked for.
        let Some(mapping) = options.mapping else {
            return Ok(Self { mirror: Mirror::Texels(light), rough, lobes, spacing });
        };
        let rows = options.rows.unwrap_or_else(|| rows_like(&light, mapping));
        let mirror = Mirror::Stored(stored(light.into(), mapping, rows, job.reborrow())?);
        let mut levels = Vec::with_capacity(rough.len());
        for level in rough {
            let rows = rows.min(level.size_like(mapping));
            levels.push(stored(level, mapping, rows, job.reborrow())?);
        }
        Ok(Self { mirror, rough: levels, lobes, spacing })
    }

    /// `P(r, roughness)`: the light under the lobe about `r`, linear between the two nearest levels.
    pub(crate) fn radiance(&self, r: Dir, roughness: f64) -> Rgb<f64> {
        let level = self.spacing.level_for_roughness(roughness, self.rough.len() + 1);
        let sharper = level as usize;
        let t = level - sharper as f64;
        let radiance = self.level(sharper, r);
        if t == 0.0 { radiance } else { radiance.scale(1.0 - t) + self.level(sharper + 1, r).scale(t) }
    }

    fn level(&self, level: usize, r: Dir) -> Rgb<f64> {
        match (level, &self.mirror) {
            (0, Mirror::Texels(map)) => map.texels()[cell(map.width(), map.height(), r)].widen(),
            (0, Mirror::Stored(map)) => map.radiance(r).widen(),
            _ => self.rough[level - 1].radiance(r).widen(),
        }
    }

    /// The direction about which a surface of this roughness looks its light up: [`LobeTable::axis`].
    pub(crate) fn axis(&self, mirrored: Dir, normal: Dir, roughness: f64) -> Dir {
        self.lobes.axis(mirrored, normal, roughness)
    }

    /// `F₀ scale + bias`: the part of even light that is reflected towards an eye at the angle of this cosine, above 0.
    pub(crate) fn reflectance(&self, cos_view: f64, roughness: f64, f0: Rgb<f64>) -> Rgb<f64> {
        self.lobes.dfg(cos_view, roughness).reflectance(f0)
    }
}

/// The rows of a picture in a mapping that has about as many texels as a light, which may be of any width and height.
fn rows_like(light: &EnvMap, mapping: Mapping) -> usize {
    if mapping != Mapping::LatLong {
        return light.size_like(mapping);
    }
    // Twice as wide as high.
    let texels = light.width() as f64 * light.height() as f64;
    ((0.5 * texels).sqrt().round() as usize).max(1)
}

/// A map in a mapping, of so many rows.
fn stored(map: MappedMap, mapping: Mapping, rows: usize, job: Job<'_>) -> Result<MappedMap, EnvError> {
    let [width, height] = mapping.picture_size(rows);
    resample(map, &Resample::to(mapping, width, height), job)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_have_about_as_many_texels_as_the_light_whatever_its_shape() {
        for (width, height) in [(1000, 10), (10, 1000), (64, 32), (1, 1)] {
            let light = EnvMap::from_fn(width, height, |_| Rgb::splat(1.0));
            let rows = rows_like(&light, Mapping::LatLong);
            let (texels, expected) = ((2 * rows * rows) as f64, (width * height) as f64);
            assert!(texels < 2.1 * expected && 1.1 * texels > expected, "{width} x {height}: {rows} rows");
        }
        let usual = EnvMap::from_fn(64, 32, |_| Rgb::splat(1.0));
        assert_eq!(rows_like(&usual, Mapping::LatLong), 32, "a light that is twice as wide as high");
    }
}
