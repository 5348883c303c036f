//! Lightmaps: options of unwrapping and of what is done with texels, and the scene that is baked at them.

use std::path::Path;

use anyhow::{anyhow, bail};
use clap::Args;
use lobe::prt::{BakeOptions, FinishOptions, LightmapGlb, TexelReceivers};
use lobe::scene::{GltfDocument, Scene, UnwrapOptions, is_gltf};

use crate::args::memory::MemoryLimit;
use crate::args::values;
use crate::run::bake_watch::watched;
use crate::run::talk::Talk;

#[derive(Args)]
pub(crate) struct LightmapOptions {
    /// With --texels: whether to unwrap the scene into texture coordinates of its own
    #[arg(long, value_enum, default_value = "auto", requires = "texels")]
    unwrap: UnwrapMode,
    /// With --texels: empty texels around each chart of a scene that is unwrapped, 0 to 256 [default: 2]
    #[arg(long, value_name = "TEXELS", value_parser = padding, requires = "texels")]
    padding: Option<u32>,
    /// With --texels: the side of a texel on the surfaces of a scene that is unwrapped, in its unit of length [default:
    /// the smallest with which all charts fit]
    #[arg(long, value_name = "L", value_parser = values::positive, requires = "texels")]
    texel_size: Option<f64>,
    /// With --texels: the largest angle in degrees between a triangle and its chart where the scene is unwrapped:
    /// smaller ones distort less and cut more [default: 60]
    #[arg(long, value_name = "DEGREES", value_parser = chart_angle, requires = "texels")]
    chart_angle: Option<f64>,
    /// With --texels: whether to average texels that differ by their noise alone
    #[arg(long, value_enum, default_value = "on", requires = "texels")]
    denoise: Switch,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum UnwrapMode {
    /// Where its own coordinates, in set 1 or else 0, overlap or are missing
    Auto,
    /// In any case
    Always,
    /// Never: coordinates that overlap or are missing are refused
    Never,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Switch {
    /// Yes
    On,
    /// No
    Off,
}

/// A length with three digits that count.
fn three_digits(length: f64) -> String {
    let before = length.log10().floor();
    if before.abs() > 6.0 { format!("{length:.2e}") } else { format!("{length:.*}", (2.0 - before).max(0.0) as usize) }
}

fn padding(text: &str) -> Result<u32, String> {
    values::whole(text, 0, UnwrapOptions::MOST_PADDING as usize, "a number of texels").map(|n| n as u32)
}

fn chart_angle(text: &str) -> Result<f64, String> {
    match values::finite(text)? {
        x if x > 0.0 && x < 90.0 => Ok(x),
        x => Err(format!("expected an angle above 0 and below 90 degrees, found {x}")),
    }
}

/// The lightmap that is baked, if one is.
#[derive(Default)]
pub(crate) struct Lightmap {
    /// How the scene was unwrapped, if it was.
    pub(crate) options: Option<UnwrapOptions>,
    /// The .glb that waits for its texels, if that is the output.
    pub(crate) glb: Option<LightmapGlb>,
}

impl LightmapOptions {
    /// What is done with the texels.
    pub(crate) fn finish(&self) -> FinishOptions {
        FinishOptions::default().denoise(self.denoise == Switch::On)
    }

    /// How a scene is unwrapped into so many texels.
    fn unwrapping(&self, width: usize) -> UnwrapOptions {
        let defaults = UnwrapOptions::default();
        defaults
            .clone()
            .texels(width)
            .padding(self.padding.unwrap_or(defaults.padding))
            .texel_size(self.texel_size)
            .chart_angle(self.chart_angle.unwrap_or(defaults.chart_angle))
    }

    /// The scene with texture coordinates for a lightmap of this width; `name` is that of the scene. For a .glb, that
    /// which waits for its texels: all that the file holds, or the scene alone.
    pub(crate) fn unwrapped(
        &self,
        (scene, document): (Scene, Option<GltfDocument>),
        (width, is_glb): (usize, bool),
        (name, memory, talk): (&str, &MemoryLimit, Talk),
    ) -> anyhow::Result<(Scene, Lightmap)> {
        let whole = |unwrapped: &Scene| {
            document.and_then(|document| LightmapGlb::of_document(document, &scene, unwrapped, width))
        };
        let (found, options) = self.with_coordinates(&scene, width, (name, memory, talk))?;
        let unwrapped = found.as_ref().unwrap_or(&scene);
        let glb = is_glb.then(|| whole(unwrapped));
        if let Some(None) = glb
            && is_gltf(Path::new(name))
        {
            let text = "unwrapped, so what the file holds beside its triangles, base colors, normals and their \
                        textures is left out";
            talk.note(name, text);
        }
        let glb = glb.map(|glb| glb.unwrap_or_else(|| LightmapGlb::of_scene(unwrapped, width)));
        Ok((found.unwrap_or(scene), Lightmap { options, glb }))
    }

    /// The scene, if it is to be unwrapped, and how.
    fn with_coordinates(
        &self,
        scene: &Scene,
        width: usize,
        (name, memory, talk): (&str, &MemoryLimit, Talk),
    ) -> anyhow::Result<(Option<Scene>, Option<UnwrapOptions>)> {
        let what = format!("--texels {width}");
        memory.check(&what, TexelReceivers::bytes_for(width), "fewer --texels")?;
        let own = TexelReceivers::check(scene, width);
        let why = match (self.unwrap, own) {
            (UnwrapMode::Never, own) => {
                own.map_err(|error| anyhow!("{error}; --unwrap auto makes others"))?;
                return Ok((None, None));
            }
            (UnwrapMode::Auto, Ok(())) if !self.is_shaped() => return Ok((None, None)),
            (UnwrapMode::Auto, Err(error)) => format!("its own coordinates hold no lightmap ({error})"),
            _ => "as asked for".to_owned(),
        };
        let options = self.unwrapping(width);
        memory.check(&format!("unwrapping {name}"), scene.bytes_to_unwrap(&options), "a scene of fewer triangles")?;
        let result = watched(talk, "unwrap", |job| scene.unwrapped(&options, job))?;
        let Ok((unwrapped, report)) = result else { bail!("stopped while the scene was unwrapped") };
        // What is wrong with coordinates that were just made is no fault of the scene.
        TexelReceivers::check(&unwrapped, width)?;
        let text = format!(
            "unwrapped into {} charts, {why}; a texel is {} wide and {:.0} % of them show surfaces; vertices: {}, {} before",
            report.charts,
            three_digits(report.texel_size),
            100.0 * report.coverage,
            report.vertices,
            report.vertices_before
        );
        talk.note(name, &text);
        Ok((Some(unwrapped), Some(options)))
    }

    /// Whether an option says how to unwrap.
    fn is_shaped(&self) -> bool {
        self.padding.is_some() || self.texel_size.is_some() || self.chart_angle.is_some()
    }

    /// Refuses a lightmap that takes too much memory, more as an .exr.
    pub(crate) fn check(
        &self,
        (scene, width): (&Scene, usize),
        bake: &BakeOptions,
        memory: &MemoryLimit,
        is_exr: bool,
    ) -> anyhow::Result<()> {
        let channels = bake.channels_for(scene, scene.is_gray());
        let texels = (width as u64).saturating_pow(2);
        let numbers = texels.saturating_mul((bake.order.pow(2) * channels.count()) as u64);
        // Of a picture all numbers, and the file while it grows.
        let picture = if is_exr { 8 * numbers } else { 0 };
        let finish = if self.finish().is_asked() { TexelReceivers::BYTES_TO_FINISH * numbers } else { 0 };
        let bytes = (picture + finish).saturating_add(TexelReceivers::bytes_for(width));
        memory.check(&format!("--texels {width}"), bytes, "fewer --texels, or a lower --order")?;
        Ok(())
    }
}
