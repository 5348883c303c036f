//! `lobe sh incident`: the light that arrives at a point of a grid of transfer.

use std::path::PathBuf;

use clap::Args;
use lobe::io::read_file;
use lobe::prt::read_neighborhood_bytes;
use lobe::sh::expansion::Quantity;
use lobe::sh::sh_json::{FileCoefficients, ShFile};
use lobe::sh::{Coefficient as _, Expansion as _, Rgb};

use crate::args::input::ShInput;
use crate::args::memory::MemoryLimit;
use crate::args::output::ShOutput;
use crate::args::values;
use crate::run::talk::Talk;

#[derive(Args)]
pub(crate) struct ShIncident {
    /// The transfer at the points of a grid, a .safetensors file of lobe bake --grid
    #[arg(value_name = "GRID")]
    grid: PathBuf,
    /// The light around the scene, a .sh.json file; - reads stdin. Lower bands than those of the grid are filled up with zeros, higher
    /// ones left out
    #[arg(long, value_name = "P")]
    light: ShInput,
    /// The place in the scene's world, z up; outside of the grid the nearest point of its box counts
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = values::numbers::<3>)]
    at: [f64; 3],
    #[command(flatten)]
    memory: MemoryLimit,
    /// The light that arrives there, a .sh.json file; - writes to stdout. lobe sh plot draws it
    #[arg(short, long, value_name = "Q")]
    output: ShOutput,
}

impl ShIncident {
    pub(crate) fn run(&self, talk: Talk) -> anyhow::Result<()> {
        self.output.check()?;
        self.memory.check_file(&self.grid, "a grid of fewer points, or of a lower order")?;
        let name = self.grid.display().to_string();
        let (neighborhood, _) = read_neighborhood_bytes(&read_file(&self.grid)?, &name)?;
        let order = neighborhood.matrices().order();
        let light = self.light.read()?;
        if light.coefficients.order() > order {
            let text = format!("the bands of the light from {order} on are left out: the grid has {order}");
            talk.note(&self.light.to_string(), &text);
        }
        let light = colors(&light.coefficients, order);
        let arrives = neighborhood.incident(self.at, &light);
        self.output.write(&ShFile::new(Quantity::Radiance, arrives))
    }
}

/// The coefficients of light in colors, of this order.
fn colors(light: &FileCoefficients, order: usize) -> Vec<Rgb<f64>> {
    let colors = light.to_rgb();
    (0..order * order).map(|i| colors.coefficients().get(i).copied().unwrap_or(Rgb::ZERO)).collect()
}
