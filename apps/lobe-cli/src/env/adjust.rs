//! `lobe env adjust`: exposure, scaling, clamping and removal of negative values of a map.

use anyhow::bail;
use clap::Args;
use lobe::env::{
    BlackenReport, ClampReport, blacken_negative_in_place, clamp_in_place, expose_in_place, scale_in_place,
};
use lobe::sh::Rgb;
use serde::Serialize;

use crate::args::map_input::MapInput;
use crate::args::map_output::MapOutput;
use crate::args::output;
use crate::args::values;
use crate::run::talk::Talk;

#[derive(Args)]
pub(crate) struct EnvAdjust {
    #[command(flatten)]
    input: MapInput,
    #[command(flatten)]
    output: MapOutput,
    /// Multiply by 2^STOPS
    #[arg(long, value_name = "STOPS", allow_hyphen_values = true, value_parser = values::finite)]
    exposure: Option<f64>,
    /// Multiply each channel, or all by one number
    #[arg(long, value_name = "R,G,B|X", allow_hyphen_values = true, value_parser = values::gray_or_color)]
    scale: Option<Rgb<f64>>,
    /// After that, make negative channels black, and say how much light that adds; beside a bright sun, take the sun out
    /// first (lobe env sun), which then pays for them
    #[arg(long)]
    non_negative: bool,
    /// After that, darken every pixel with a channel above V until none is, and say how much light is lost
    #[arg(long, value_name = "V", allow_hyphen_values = true, value_parser = values::positive)]
    clamp: Option<f64>,
    /// With --non-negative or --clamp: print {"blackened": {"texels", "lowest", "added"}, "clamped": {"texels", "largest",
    /// "removed"}} instead of text, null for what was not asked; added is in radiance, removed the part of each channel's
    /// light
    #[arg(long)]
    json: bool,
}

/// The JSON of `--json`.
#[derive(Serialize)]
struct Adjusted {
    blackened: Option<Blackened>,
    clamped: Option<Clamped>,
}

#[derive(Serialize)]
struct Blackened {
    texels: usize,
    lowest: f32,
    added: Rgb<f64>,
}

#[derive(Serialize)]
struct Clamped {
    texels: usize,
    largest: f32,
    removed: Rgb<f64>,
}

impl From<BlackenReport> for Blackened {
    fn from(report: BlackenReport) -> Self {
        Self { texels: report.texels, lowest: report.lowest, added: report.added }
    }
}

impl From<ClampReport> for Clamped {
    fn from(report: ClampReport) -> Self {
        Self { texels: report.texels, largest: report.largest, removed: report.removed() }
    }
}

impl EnvAdjust {
    pub(crate) fn run(&self, talk: Talk) -> anyhow::Result<()> {
        if self.exposure.is_none() && self.scale.is_none() && self.clamp.is_none() && !self.non_negative {
            bail!("nothing to adjust: --exposure, --scale, --non-negative or --clamp says what");
        }
        if self.json && self.clamp.is_none() && !self.non_negative {
            bail!("--json: only with --non-negative or --clamp; leave it out");
        }
        let mut map = self.input.read(talk)?;
        self.output.check(map.mapping(), &self.input.files()?)?;
        self.input.check_work("writing", &map, self.output.bytes_of_texel(map.mapping()))?;
        if let Some(stops) = self.exposure {
            expose_in_place(&mut map, stops).map_err(|e| anyhow::anyhow!("--exposure: {e}"))?;
        }
        if let Some(factor) = self.scale {
            scale_in_place(&mut map, factor).map_err(|e| anyhow::anyhow!("--scale: {e}"))?;
        }
        let blackened = self.non_negative.then(|| blacken_negative_in_place(&mut map).into());
        let clamped = self.clamp.map(|limit| clamp_in_place(&mut map, limit as f32)).transpose()?.map(Clamped::from);
        self.output.write(map, talk)?;
        let adjusted = Adjusted { blackened, clamped };
        if self.json { output::print_json(&adjusted) } else { output::print(&adjusted.to_text()) }
    }
}

impl Adjusted {
    fn to_text(&self) -> String {
        let mut text = String::new();
        if let Some(Blackened { texels, lowest, added }) = &self.blackened {
            let [r, g, b] = added.to_array().map(|c| c as f32);
            text += &format!(
                "blackened  {texels} texels, the lowest channel was {lowest:?}\nadded      {r:?} {g:?} {b:?} of mean radiance\n"
            );
        }
        if let Some(Clamped { texels, largest, removed }) = &self.clamped {
            let [r, g, b] = removed.to_array().map(|c| 100.0 * c);
            text += &format!(
                "clamped    {texels} texels, the brightest channel was {largest:?}\nremoved    {r:.4} % {g:.4} % {b:.4} % of the light\n"
            );
        }
        text
    }
}
