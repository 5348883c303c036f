//! `lobe env sun`: sun extraction, the suns of a map as directional lights and the sky without them.

use anyhow::bail;
use clap::Args;
use lobe::env::{SunOptions, SunRecord, extract_suns};
use lobe::sh::expansion::Quantity;
use lobe::sh::light::Normalization;
use lobe::sh::sh_json::ShFile;
use lobe::sh::{Light, Rgb, ShVec};

use crate::args::map_input::{MapInput, OF_MAP};
use crate::args::map_output::MapOutput;
use crate::args::output::{self, ShOutput};
use crate::args::values;
use crate::run::failure::NotFound;
use crate::run::talk::Talk;

/// The order of `lobe project` without --order.
const DEFAULT_ORDER: usize = 3;

#[derive(Args)]
pub(crate) struct EnvSun {
    #[command(flatten)]
    input: MapInput,
    #[command(flatten)]
    output: MapOutput,
    /// The most suns or lamps to take out, from the brightest on, 1 to 1024; where there are fewer, a note says what
    /// was in the way
    #[arg(long, value_name = "N", default_value = "1", value_parser = count)]
    count: usize,
    /// The largest radius of what may be a sun, in degrees
    #[arg(long, value_name = "DEG", default_value = "2.5", value_parser = values::quarter_turn)]
    max_radius: f64,
    /// How many times as bright as what surrounds it the brightest texel of a sun is at least
    #[arg(long, value_name = "X", default_value = "20", value_parser = values::positive)]
    min_contrast: f64,
    /// How many times as bright as the mean of the map the brightest texel of a sun is at least
    #[arg(long, value_name = "X", default_value = "100", value_parser = values::positive)]
    min_peak: f64,
    /// Write the suns as an expansion, too, a .sh.json file: lobe sh add makes the light of the whole map of it and the
    /// expansion of OUT
    #[arg(long, value_name = "P")]
    light: Option<ShOutput>,
    /// With --light: the order (number of bands), 1 to 256 [default: 3]
    #[arg(long, value_name = "N", value_parser = values::order, requires = "light")]
    order: Option<usize>,
    /// Print {"direction", "irradiance", "radiance", "diameter", "texels"} instead of text, with --count {"suns": [..]}
    /// of them; the diameter is in degrees
    #[arg(long)]
    json: bool,
}

impl EnvSun {
    pub(crate) fn run(&self, talk: Talk) -> anyhow::Result<()> {
        match &self.light {
            // What is found is printed to stdout.
            Some(ShOutput::Stdout) => bail!("--light: expected a .sh.json file, found -"),
            Some(light) => light.check_as("--light")?,
            None => {}
        }
        let map = self.input.read(talk)?;
        self.output.check(map.mapping(), &self.input.files()?)?;
        // The map, what is left of it, and a copy while a sun is taken out; then what is left is written.
        let written = OF_MAP + self.output.bytes_of_texel(map.mapping());
        self.input.check_work("looking for suns in", &map, written.max(3 * OF_MAP))?;
        let mut options = SunOptions::default();
        options.max_radius = self.max_radius.to_radians();
        (options.min_contrast, options.min_peak) = (self.min_contrast, self.min_peak);
        let found = talk.while_waiting("look", || extract_suns(&map, self.count, &options));
        let why = found.end.map_or(String::new(), |end| format!(": {end}"));
        if found.suns.is_empty() {
            let name = self.input.name();
            let message = format!(
                "{name}: nothing in it is as small and bright as a sun{why}; --max-radius, --min-contrast and --min-peak say \
                 what counts as one"
            );
            return Err(NotFound(message).into());
        }
        if found.end.is_some() {
            talk.note(&self.input.name(), &format!("{} of {} suns were found{why}", found.suns.len(), self.count));
        }
        self.output.write(found.rest, talk)?;
        if let Some(output) = &self.light {
            let order = self.order.unwrap_or(DEFAULT_ORDER);
            let mut all: Option<ShVec<Rgb<f64>>> = None;
            for sun in &found.suns {
                let (dir, half_angle) = (sun.direction, 0.5 * sun.angular_diameter);
                let disc =
                    Light::Cone { dir, half_angle, color: sun.radiance() }.project(order, Normalization::None)?;
                all = Some(match all {
                    Some(all) => &all + &disc,
                    None => disc,
                });
            }
            if let Some(all) = all {
                output.write(&ShFile::new(Quantity::Radiance, all))?;
            }
        }
        self.print(found.suns.into_iter().map(SunRecord::from).collect())
    }

    fn print(&self, suns: Vec<SunRecord>) -> anyhow::Result<()> {
        match (&suns[..], self.json) {
            ([only], true) if self.count == 1 => output::print_json(only),
            (_, true) => output::print_json_list("suns", suns),
            (suns, false) => output::print(&suns.iter().map(text_of).collect::<Vec<_>>().join("\n")),
        }
    }
}

fn count(text: &str) -> Result<usize, String> {
    values::whole(text, 1, 1024, "a number of suns")
}

/// The lines of a sun.
fn text_of(found: &SunRecord) -> String {
    let [x, y, z] = found.direction;
    let channels = |[r, g, b]: [f64; 3]| format!("{:?} {:?} {:?}", r as f32, g as f32, b as f32);
    format!(
        "direction   {x:.6} {y:.6} {z:.6}\nirradiance  {}\nradiance    {}\ndiameter    {:.4}°\ntexels      {}\n",
        channels(found.irradiance),
        channels(found.radiance),
        found.diameter,
        found.texels
    )
}
