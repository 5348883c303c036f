//! `lobe sh lights`: directional lights and ambient light in place of an expansion.

use std::fmt::Write as _;

use anyhow::bail;
use clap::{Args, ValueEnum};
use lobe::sh::{
    Coefficient, Expansion, FileCoefficients, LightFit, LightMetric, LightOptions, Quantity, extract_lights,
};
use serde::Serialize;

use crate::input::ShInput;
use crate::{output, values};

/// More lights than any expansion has maxima; asking for more is a slip of the finger.
const MAX_LIGHTS: usize = 100;

#[derive(Args)]
pub(crate) struct ShLights {
    /// The expansion of radiance, a .sh.json file; - reads stdin
    #[arg(value_name = "P")]
    input: ShInput,
    /// The most lights to find
    #[arg(long, value_name = "K", default_value = "1", value_parser = count)]
    count: usize,
    /// Move the directions to where the lights explain most, together with the intensities
    #[arg(long)]
    refine: bool,
    /// What the lights shall reproduce
    #[arg(long, value_enum, default_value = "irradiance")]
    metric: Metric,
    /// Print {"lights": [{"dir", "intensity"}], "ambient", "residual"} instead of lines
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, ValueEnum)]
enum Metric {
    /// What diffuse surfaces reflect
    Irradiance,
    /// The radiance itself
    Radiance,
}

fn count(text: &str) -> Result<usize, String> {
    values::whole(text, 0, MAX_LIGHTS, "a number of lights")
}

/// What `--json` prints.
#[derive(Serialize)]
struct Lights {
    lights: Vec<Found>,
    ambient: Vec<f64>,
    residual: Vec<f64>,
}

#[derive(Serialize)]
struct Found {
    dir: [f64; 3],
    intensity: Vec<f64>,
}

impl ShLights {
    pub(crate) fn run(&self) -> anyhow::Result<()> {
        let file = self.input.read()?;
        if file.quantity != Quantity::Radiance {
            bail!("{}: lights are found in radiance, this is {}", self.input, file.quantity);
        }
        let lights = match file.coefficients {
            FileCoefficients::Scalar(f) => self.find(&f),
            FileCoefficients::Rgb(f) => self.find(&f),
        };
        let lights = lights.map_err(|error| anyhow::anyhow!("{}: {error}", self.input))?;
        if self.json { output::print_json(&lights) } else { output::print(&lights.text()) }
    }

    fn find<T: Coefficient>(&self, f: &impl Expansion<T>) -> anyhow::Result<Lights> {
        let metric = match self.metric {
            Metric::Irradiance => LightMetric::Irradiance,
            Metric::Radiance => LightMetric::Radiance,
        };
        let options = LightOptions { count: self.count, refine: self.refine, metric, ..LightOptions::default() };
        let LightFit { lights, ambient, residual, .. } = extract_lights(f, &options)?;
        let found = lights.iter().map(|l| Found { dir: l.dir.to_array(), intensity: channels(l.intensity) });
        Ok(Lights { lights: found.collect(), ambient: channels(ambient), residual: channels(residual) })
    }
}

fn channels<T: Coefficient<Scalar = f64>>(value: T) -> Vec<f64> {
    (0..T::CHANNELS).map(|c| value.channel(c)).collect()
}

impl Lights {
    fn text(&self) -> String {
        let mut text = String::new();
        let numbers = |values: &[f64]| values.iter().map(|x| format!("{x:.6}")).collect::<Vec<_>>().join(" ");
        for light in &self.lights {
            let _ = writeln!(text, "light from {}  intensity {}", numbers(&light.dir), numbers(&light.intensity));
        }
        let residual = self.residual.iter().map(|x| format!("{x:.3e}")).collect::<Vec<_>>().join(" ");
        let _ = writeln!(text, "ambient {}\nresidual energy {residual}", numbers(&self.ambient));
        text
    }
}
