//! `lobe sh lights`: light extraction, directional lights and ambient light in place of an expansion.

use std::fmt::Write as _;

use anyhow::bail;
use clap::Args;
use lobe::sh::expansion::Quantity;
use lobe::sh::light::directional_normalization;
use lobe::sh::light_extraction::{
    LightChoice, LightFit, LightFitOptions, LightMetric, extract_light, extract_lights, fit_lights,
};
use lobe::sh::sh_json::FileCoefficients;
use lobe::sh::{Coefficient, Dir, Expansion as _, ShVec};
use serde::Serialize;

use crate::args::input::ShInput;
use crate::args::names::names;
use crate::args::output;
use crate::args::values;
use crate::run::talk::Talk;

/// More lights than any expansion has maxima. A larger number is taken for a typing error.
const MAX_LIGHTS: usize = 100;

const UNITS: &str = "\
Intensity 1 is the light of which a facing white matte surface leaves 1, as the bands of this order show it: what
lobe light directional makes. Irradiance is that of a surface facing the light itself, what an engine's directional light
has, in the unit of radiance times steradians (divide by π where it counts what white leaves).";

#[derive(Args)]
#[command(after_help = UNITS)]
pub(crate) struct ShLights {
    /// The expansion of radiance, a .sh.json file; - reads stdin
    #[arg(value_name = "P")]
    input: ShInput,
    /// The most lights to find
    #[arg(long, value_name = "K", default_value = "1", value_parser = count)]
    count: usize,
    /// Refine directions and intensities together, to the least residual
    #[arg(long)]
    refine: bool,
    /// The function that the lights reproduce
    #[arg(long, value_enum, default_value = "irradiance")]
    metric: Metric,
    /// Which of the maxima become lights
    #[arg(long, value_enum, default_value = "residual")]
    choose: Choose,
    /// One light in closed form, from where the linear band points; light and ambient light may come out negative
    #[arg(long, conflicts_with_all = ["count", "refine", "metric", "choose"])]
    closed: bool,
    /// The direction towards a light that is known, a vector of any length but 0; may be given many times. Finds the
    /// intensities of these lights and the ambient light, in this order, dark lights too
    #[arg(long = "direction", value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = values::dir)]
    #[arg(conflicts_with_all = ["count", "refine", "choose", "closed", "per_channel"])]
    directions: Vec<Dir>,
    /// Give every channel directions of its own, instead of those of the luminance to all
    #[arg(long)]
    per_channel: bool,
    /// Print {"lights": [{"dir", "intensity", "irradiance"}], "ambient", "residual"} instead of lines; with --per-channel
    /// {"channels": [..]} with one such object for each
    #[arg(long)]
    json: bool,
}

names! {
    enum Metric for LightMetric {
        /// What diffuse surfaces reflect
        Irradiance,
        /// The radiance itself
        Radiance,
    }
}

names! {
    enum Choose for LightChoice {
        /// One after the other, that with the least residual
        Residual,
        /// The highest
        Height,
    }
}

fn count(text: &str) -> Result<usize, String> {
    values::whole(text, 0, MAX_LIGHTS, "a number of lights")
}

/// The JSON of `--json`.
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
    irradiance: Vec<f64>,
}

impl ShLights {
    pub(crate) fn run(&self, talk: Talk) -> anyhow::Result<()> {
        if self.directions.len() > MAX_LIGHTS {
            bail!("--direction: expected {MAX_LIGHTS} lights at most, found {}; leave some out", self.directions.len());
        }
        let file = self.input.read_to_search()?;
        if file.quantity != Quantity::Radiance {
            bail!("{}: lights are found in radiance, this is {}", self.input, file.quantity);
        }
        if self.per_channel {
            return self.print_channels(&file.coefficients, talk);
        }
        let lights = talk.while_waiting("search", || match &file.coefficients {
            FileCoefficients::Scalar(f) => self.find(f),
            FileCoefficients::Rgb(f) => self.find(f),
        })?;
        if self.json { output::print_json(&lights) } else { output::print(&lights.text("")) }
    }

    fn print_channels(&self, coefficients: &FileCoefficients, talk: Talk) -> anyhow::Result<()> {
        let find = || match coefficients {
            FileCoefficients::Scalar(f) => Ok(vec![self.find(f)?]),
            FileCoefficients::Rgb(f) => {
                (0..3).map(|c| self.find(&f.map(|rgb| rgb.channel(c)))).collect::<anyhow::Result<Vec<Lights>>>()
            }
        };
        let channels = talk.while_waiting("search", find)?;
        if self.json {
            return output::print_json_list("channels", channels);
        }
        let names: &[&str] = if channels.len() == 1 { &[""] } else { &["red: ", "green: ", "blue: "] };
        output::print(&names.iter().zip(&channels).map(|(name, lights)| lights.text(name)).collect::<String>())
    }

    fn find<T: Coefficient>(&self, f: &ShVec<T>) -> anyhow::Result<Lights> {
        let fit = match &self.directions[..] {
            [] if self.closed => extract_light(f),
            [] => extract_lights(f, &self.options()),
            known => fit_lights(f, known, &self.options()),
        };
        let LightFit { lights, ambient, residual, .. } =
            fit.map_err(|error| anyhow::anyhow!("{}: {error}", self.input))?;
        let unit = directional_normalization(f.order());
        let found = lights.iter().map(|l| Found {
            dir: l.dir.to_array(),
            intensity: channels(l.intensity),
            irradiance: channels(l.intensity.scale(unit)),
        });
        Ok(Lights { lights: found.collect(), ambient: channels(ambient), residual: channels(residual) })
    }

    fn options(&self) -> LightFitOptions {
        LightFitOptions::default()
            .count(self.count)
            .refine(self.refine)
            .metric(self.metric.into())
            .choice(self.choose.into())
    }
}

fn channels<T: Coefficient<Scalar = f64>>(value: T) -> Vec<f64> {
    (0..T::CHANNELS).map(|c| value.channel(c)).collect()
}

impl Lights {
    /// In lines, each after the name of its channel.
    fn text(&self, name: &str) -> String {
        let mut text = String::new();
        let numbers = |values: &[f64]| values.iter().map(|x| format!("{x:.6}")).collect::<Vec<_>>().join(" ");
        for light in &self.lights {
            let [dir, intensity, irradiance] = [&light.dir[..], &light.intensity, &light.irradiance].map(numbers);
            let _ = writeln!(text, "{name}light from {dir}  intensity {intensity}  irradiance {irradiance}");
        }
        let residual = self.residual.iter().map(|x| format!("{x:.3e}")).collect::<Vec<_>>().join(" ");
        let _ = writeln!(text, "{name}ambient {}\n{name}residual energy {residual}", numbers(&self.ambient));
        text
    }
}
