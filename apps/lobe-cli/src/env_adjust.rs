//! `lobe env adjust`: brighter, darker, clamped.

use anyhow::bail;
use clap::Args;
use lobe::env::{ClampReport, clamp_in_place, expose_in_place, scale_in_place};
use lobe::sh::Rgb;
use serde::Serialize;

use crate::map_input::MapInput;
use crate::map_output::MapOutput;
use crate::talk::Talk;
use crate::{output, values};

#[derive(Args)]
pub(crate) struct EnvAdjust {
    #[command(flatten)]
    input: MapInput,
    #[command(flatten)]
    output: MapOutput,
    /// Multiply by 2^STOPS
    #[arg(long, value_name = "STOPS", allow_hyphen_values = true, value_parser = values::finite)]
    exposure: Option<f64>,
    /// Multiply each channel
    #[arg(long, value_name = "R,G,B", allow_hyphen_values = true, value_parser = values::colour)]
    scale: Option<Rgb<f64>>,
    /// After that, darken every pixel with a channel above V until none is, and say how much light is lost
    #[arg(long, value_name = "V", allow_hyphen_values = true, value_parser = values::positive)]
    clamp: Option<f64>,
    /// With --clamp: print {"texels", "largest", "removed"} instead of text; removed is the part of each channel's light
    #[arg(long, requires = "clamp")]
    json: bool,
}

/// What `--json` prints.
#[derive(Serialize)]
struct Clamped {
    texels: usize,
    largest: f32,
    removed: Rgb<f64>,
}

impl EnvAdjust {
    pub(crate) fn run(&self, talk: Talk) -> anyhow::Result<()> {
        if self.exposure.is_none() && self.scale.is_none() && self.clamp.is_none() {
            bail!("nothing to adjust: --exposure, --scale or --clamp says what");
        }
        let mut map = self.input.read(talk)?;
        self.output.check(map.mapping())?;
        if let Some(stops) = self.exposure {
            expose_in_place(&mut map, stops)?;
        }
        if let Some(factor) = self.scale {
            scale_in_place(&mut map, factor)?;
        }
        let report = self.clamp.map(|limit| clamp_in_place(&mut map, limit as f32)).transpose()?;
        self.output.write(map, talk)?;
        report.map_or(Ok(()), |report| self.print(&report))
    }

    fn print(&self, report: &ClampReport) -> anyhow::Result<()> {
        let found = Clamped { texels: report.texels, largest: report.largest, removed: report.removed() };
        if self.json {
            return output::print_json(&found);
        }
        let [r, g, b] = found.removed.to_array().map(|c| 100.0 * c);
        output::print(&format!(
            "clamped  {} texels, the brightest channel was {:?}\nremoved  {r:.4} % {g:.4} % {b:.4} % of the light\n",
            found.texels, found.largest
        ))
    }
}
