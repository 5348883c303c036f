//! `lobe env convert`: a map in another mapping, size or kind of file.

use clap::Args;
use lobe::env::{CubeMap, LoadedMap, MappedMap, Mapping, Resample, resample};

use crate::args::map_input::{MapInput, OF_LARGER, OF_SMALLER, mapping};
use crate::args::map_output::MapOutput;
use crate::args::values;
use crate::run::talk::Talk;

#[derive(Args)]
pub(crate) struct EnvConvert {
    #[command(flatten)]
    input: MapInput,
    #[command(flatten)]
    output: MapOutput,
    /// How the new map shows the surroundings [default: cube for .ktx2, .dds, .ktx, six files
    /// and with --layout; else as IN does]
    #[arg(long, value_name = "MAPPING", value_parser = mapping())]
    to: Option<Mapping>,
    /// The height of the new picture, or of one face of a cube, 1 to 8192
    /// [default: about as many texels as IN has; a power of two for cubes]
    #[arg(long, value_name = "N", value_parser = values::rows)]
    size: Option<usize>,
}

impl EnvConvert {
    /// Refuses a conversion that takes more memory than allowed.
    fn check_memory(&self, map: &MappedMap, target: &Resample) -> anyhow::Result<()> {
        let texels = |width: usize, height: usize| (width as u64).saturating_mul(height as u64);
        let (from, to) = (texels(map.width(), map.height()), texels(target.width, target.height));
        let converted = OF_LARGER.saturating_mul(from.max(to)).saturating_add(OF_SMALLER * from.min(to));
        let written = self.output.bytes_of_texel(target.mapping).saturating_mul(to);
        let what = format!(
            "a map of {} x {} texels from one of {} x {}",
            target.width,
            target.height,
            map.width(),
            map.height()
        );
        self.input.memory().check(&what, converted.max(written), "a smaller --size")
    }

    pub(crate) fn run(&self, talk: Talk) -> anyhow::Result<()> {
        let is_cube = self.output.is_cube_only() || self.output.has_layout();
        let said = self.to.or(is_cube.then_some(Mapping::Cube));
        let inputs = self.input.files()?;
        if let Some(mapping) = said {
            self.output.check(mapping, &inputs)?;
        }
        let levels = self.input.read_levels(talk)?;
        let mapping = said.unwrap_or_else(|| levels.base().mapping());
        self.output.check(mapping, &inputs)?;
        let keeps_size = |cube: &CubeMap| self.size.is_none_or(|size| size == cube.size());
        let map = match levels {
            LoadedMap::Chain(chain)
                if mapping == Mapping::Cube && keeps_size(chain.base()) && self.output.keeps_levels() =>
            {
                let written = self.output.bytes_of_texel(Mapping::Cube);
                self.input.check_work("writing", chain.base(), written)?;
                return self.output.write_chain(&chain, talk);
            }
            levels => self.input.base_of(levels, talk),
        };
        let size = self.size.unwrap_or_else(|| map.size_like(mapping));
        let [width, height] = mapping.picture_size(size);
        let target = Resample::to(mapping, width, height);
        self.check_memory(&map, &target)?;
        self.output.write(talk.watch("convert", |job| resample(map, &target, job))?, talk)
    }
}
