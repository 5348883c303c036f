//! Environment mapping in `lobe render`: its options, the maps of the light, and a picture by them.

use std::str::FromStr;

use anyhow::bail;
use clap::Args;
use lobe::env::{EnvMap, Mapping};
use lobe::render::{EnvironmentMapOptions, EnvironmentMaps, Reflections, Surfaces};

use crate::args::memory::MemoryLimit;
use crate::args::values;
use crate::render::light::Split;
use crate::run::bake_watch::watched;
use crate::run::talk::Talk;

/// What only environment mapping knows.
#[derive(Args, Default)]
pub(crate) struct EnvironmentInput {
    /// Look reflections up in a picture of this mapping, as --from of lobe project names it, of SIZE rows (of a cube,
    /// of a face), which shows its seams and its resolution; rougher levels have no more rows [default: mirrors show
    /// the texels of the environment, rough surfaces cubes; SIZE: about as many texels as the environment has]
    #[arg(long, value_name = "MAPPING[:SIZE]")]
    reflect_through: Option<Through>,
}

/// The pictures in which reflections are looked up.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Through {
    mapping: Mapping,
    rows: Option<usize>,
}

impl FromStr for Through {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (name, size) = text.split_once(':').map_or((text, None), |(name, size)| (name, Some(size)));
        let Some(mapping) = Mapping::from_name(name) else {
            return Err(format!("expected {}, found {name:?}", Mapping::ALL.map(Mapping::name).join(", ")));
        };
        Ok(Self { mapping, rows: size.map(values::rows).transpose()? })
    }
}

impl EnvironmentInput {
    /// Refuses the option of surfaces that mirror nothing.
    pub(crate) fn check(&self, surfaces: Surfaces) -> anyhow::Result<()> {
        if self.reflect_through.is_some() && surfaces == Surfaces::Matte {
            bail!("--reflect-through: matte surfaces reflect no picture; leave the option out");
        }
        Ok(())
    }

    /// The maps of the light.
    pub(crate) fn maps(
        &self,
        (light, name): (&EnvMap, &str),
        surfaces: Surfaces,
        memory: &MemoryLimit,
        talk: Talk,
    ) -> anyhow::Result<EnvironmentMaps> {
        let options = self.options(surfaces);
        expect_memory((light, name), &options, memory)?;
        let maps = watched(talk, "filter", |job| EnvironmentMaps::new(light.clone(), &options, job))?;
        maps.or_else(|_| bail!("stopped before the first picture; nothing is kept"))
    }

    /// What shiny surfaces reflect of the light.
    pub(crate) fn reflections(
        &self,
        (split, name): (&Split, &str),
        surfaces: Surfaces,
        memory: &MemoryLimit,
        talk: Talk,
    ) -> anyhow::Result<Reflections> {
        let options = self.options(surfaces);
        if let Some(rest) = &split.rest {
            expect_memory((rest, name), &options, memory)?;
        }
        let maps = watched(talk, "filter", |job| match &split.rest {
            Some(rest) => Reflections::new(rest.clone(), &options, job),
            None => Reflections::of_expansion(split.light.rest(), &options, job),
        })?;
        maps.or_else(|_| bail!("stopped before the first picture; nothing is kept"))
    }

    fn options(&self, surfaces: Surfaces) -> EnvironmentMapOptions {
        let through = self.reflect_through;
        EnvironmentMapOptions::default()
            .surfaces(surfaces)
            .mapping(through.map(|through| through.mapping))
            .rows(through.and_then(|through| through.rows))
    }
}

/// Refuses a light whose filtering takes more memory than allowed.
fn expect_memory(
    (light, name): (&EnvMap, &str),
    options: &EnvironmentMapOptions,
    memory: &MemoryLimit,
) -> anyhow::Result<()> {
    let bytes = options.bytes(light.width(), light.height());
    memory.check(&format!("filtering {name}"), bytes, "a smaller one, by lobe env convert --size")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_for_reflections_has_a_mapping_and_may_have_a_size() {
        let of = |mapping, rows| Ok(Through { mapping, rows });
        assert_eq!("sphere".parse(), of(Mapping::Sphere, None), "a mapping");
        assert_eq!("dual-paraboloid:64".parse(), of(Mapping::DualParaboloid, Some(64)), "its rows");
        for (text, part) in
            [("ball", "expected lat-long, sphere, "), ("", "found \"\""), ("cube:", "rows"), ("cube:0", "from 1 to")]
        {
            let error = text.parse::<Through>().unwrap_err();
            assert!(error.contains(part), "{text:?}: {error}");
        }
    }
}
