//! `lobe env vector-irradiance`: the vector irradiance (net flux) of a map, and its flux through surfaces.

use clap::Args;
use lobe::env::{VectorIrradiance, irradiance_at, vector_irradiance};
use lobe::sh::{Coefficient as _, Dir, Rgb};
use serde::Serialize;

use crate::args::map_input::MapInput;
use crate::args::output;
use crate::args::values;
use crate::run::talk::Talk;

const CHANNELS: [&str; 3] = ["red", "green", "blue"];

#[expect(clippy::doc_markdown, reason = "the keys of the JSON are shown on a terminal")]
#[derive(Args)]
pub(crate) struct EnvVectorIrradiance {
    #[command(flatten)]
    input: MapInput,
    /// Also print the net irradiance n·e through a surface of this normal, beside the irradiance E of its two sides; may
    /// be given many times
    #[arg(long = "normal", value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = values::dir)]
    normals: Vec<Dir>,
    /// Print {"vector", "magnitude", "dir", "luminance_dir", "net"}: one row for each channel, null where light comes
    /// evenly from everywhere; "net" has {"normal", "net", "front", "back"} for each --normal
    #[arg(long)]
    json: bool,
}

/// The JSON of `--json`.
#[derive(Serialize)]
struct Found {
    vector: Vec<[f64; 3]>,
    magnitude: Vec<f64>,
    dir: Vec<Option<[f64; 3]>>,
    luminance_dir: Option<[f64; 3]>,
    net: Vec<Net>,
}

/// The light through one surface.
#[derive(Serialize)]
struct Net {
    normal: [f64; 3],
    net: Rgb<f64>,
    front: Rgb<f64>,
    back: Rgb<f64>,
}

impl EnvVectorIrradiance {
    pub(crate) fn run(&self, talk: Talk) -> anyhow::Result<()> {
        let map = self.input.read(talk)?;
        let e = vector_irradiance(&map);
        let sides: Vec<Dir> = self.normals.iter().flat_map(|n| [*n, -*n]).collect();
        let irradiance =
            if sides.is_empty() { Vec::new() } else { irradiance_at(&self.input.to_lat_long(map, talk)?, &sides) };
        let net = self.normals.iter().zip(irradiance.chunks_exact(2));
        let net = net.map(|(n, sides)| Net { normal: n.to_array(), net: e.net(*n), front: sides[0], back: sides[1] });
        let found = Found::new(e, net.collect());
        if self.json { output::print_json(&found) } else { output::print(&found.to_text()) }
    }
}

impl Found {
    fn new(e: VectorIrradiance, net: Vec<Net>) -> Self {
        let channels = 0..CHANNELS.len();
        Self {
            vector: channels.clone().map(|c| e.to_array().map(|component| component.channel(c))).collect(),
            magnitude: channels.clone().map(|c| e.magnitude(c)).collect(),
            dir: channels.map(|c| e.dir(c).map(Dir::to_array)).collect(),
            luminance_dir: e.luminance_dir().map(Dir::to_array),
            net,
        }
    }

    fn to_text(&self) -> String {
        let towards = |dir: Option<[f64; 3]>| dir.map_or("nowhere".to_owned(), |d| numbers(&d));
        let mut text = String::new();
        for (c, name) in CHANNELS.into_iter().enumerate() {
            text += &format!("{name:9}  {} towards {}\n", number(self.magnitude[c]), towards(self.dir[c]));
        }
        text += &format!("luminance  towards {}\n", towards(self.luminance_dir));
        for Net { normal, net, front, back } in &self.net {
            let [net, front, back] = [net, front, back].map(|c| numbers(&c.to_array()));
            text += &format!("normal {}  net {net}  front {front}  back {back}\n", numbers(normal));
        }
        text
    }
}

/// As many digits as a picture has.
fn number(x: f64) -> String {
    format!("{:?}", x as f32)
}

fn numbers(values: &[f64]) -> String {
    values.iter().map(|x| number(*x)).collect::<Vec<_>>().join(" ")
}
