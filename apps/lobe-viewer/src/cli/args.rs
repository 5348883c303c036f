//! The arguments.

use std::path::PathBuf;

use anyhow::{Context as _, anyhow, bail};
use clap::{ArgGroup, Parser, ValueEnum as _};
use lobe::env::SunChoice;
use lobe::image::{FileFormat, FrameSequence, Tone};
use lobe::io::{JobArgs, OptionError, flag, worded};
use lobe::motion::MovingMethod;
use lobe::prt::GlossyLobe;
use lobe::render::{Background, CameraOptions, RenderError, ToneOptions};
use lobe::scene::SceneFormat;
use lobe_gpu::{GpuCamera, SceneViewOptions, Storage, TurntableOptions};

use crate::loading::limits::ReadLimits;
use crate::loading::moving_light::LitOn;
use lobe::render::Surfaces;

/// Help of the files.
fn files() -> String {
    let (scenes, pictures) = (SceneFormat::names(|_| true), FileFormat::names(|_| true));
    format!("Scenes ({scenes}), environments ({pictures}) and scenes that move (.json) to open in the window")
}

/// See and steer spherical-harmonic lighting and precomputed radiance transfer in real time.
///
/// Without arguments a window opens on a built-in scene.
#[derive(Clone, Debug, Parser)]
#[command(name = "lobe-viewer", version, max_term_width = 100)]
#[command(group(ArgGroup::new("without_window").args(["headless", "bench"]).multiple(true)))]
pub(crate) struct Arguments {
    #[arg(value_name = "FILE", help = files(), conflicts_with_all = ["headless", "bench"])]
    pub(crate) files: Vec<PathBuf>,
    /// Render this scene to a file, without a window: a scene file, baked or not, or built-in:NAME
    #[arg(long, value_name = "SCENE", requires = "output")]
    pub(crate) headless: Option<PathBuf>,
    /// The environment: a picture, bundled:sunset, bundled:studio, made:evening, made:noon or made:even
    #[arg(long, value_name = "ENV", default_value = "made:evening")]
    pub(crate) env: PathBuf,
    /// Suns that cast shadows by themselves, beside the expansion: auto finds in a map up to four, each of a
    /// hundredth of its light at least; a number takes so many at most, of which a device shows four; a .json file of
    /// lobe env sun --json adds its own
    #[arg(long, value_name = "auto|none|N|FILE", default_value_t)]
    pub(crate) suns: SunChoice,
    /// Texels along each side of the map from which the shadow of a sun is found
    #[arg(
        long,
        value_name = "N",
        default_value_t = SceneViewOptions::default().shadow_side,
        requires = "without_window",
        value_parser = clap::value_parser!(u32).range(16..=8192)
    )]
    pub(crate) shadow_side: u32,
    /// What is behind the scene, as of `lobe render`: the environment; light, the bands that light the scene; none,
    /// with which pictures have an alpha; or a color, #rrggbb of sRGB or r,g,b of linear radiance
    #[arg(long, value_name = "env|light|none|COLOR", default_value_t = Background::Env, requires = "headless")]
    pub(crate) background: Background,
    /// The model of reflection, matte or gltf as of lobe render [default: matte, in the window as it was left]
    #[arg(long, value_name = "MODEL", value_parser = surfaces)]
    pub(crate) surfaces: Option<Surfaces>,
    /// The light paths that are shown; of a scene that moves, how its parts hide the sky
    #[arg(long, value_enum, default_value = "interreflected")]
    pub(crate) mode: ModeName,
    /// A file of transfer that was baked for this scene: vectors, clustered or zonal; a lightmap (.exr); with --mode glossy transfer
    /// matrices. Nothing is baked then
    #[arg(long, value_name = "FILE", requires = "without_window", conflicts_with = "parts")]
    pub(crate) transfer: Option<PathBuf>,
    /// glossy: the lobe of reflection about the mirrored view [default: ggx:0.3]
    #[arg(long, value_name = "phong:E|ggx:ALPHA", requires = "without_window")]
    pub(crate) lobe: Option<GlossyLobe>,
    /// specular: the roughness √α of microfacets, 0 to 1 [default: 0.5]
    #[arg(long, value_name = "X", requires = "without_window", value_parser = roughness)]
    pub(crate) roughness: Option<f64>,
    /// Spheres for each part, with --mode exponentials; four times as many of a part that changes its shape
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) spheres: u16,
    /// A file of an occlusion field or of spheres for a part of a scene that moves; once for each
    #[arg(long = "part", value_name = "FILE")]
    pub(crate) parts: Vec<PathBuf>,
    /// Number of bands of the light, 1 to 8 [default: of what is baked already those it has, else 4]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=8))]
    pub(crate) order: Option<u8>,
    /// Paths from each vertex, where the scene is baked first
    #[arg(long, value_name = "N", default_value_t = 128, value_parser = clap::value_parser!(u32).range(1..=1 << 20))]
    pub(crate) samples: u32,
    /// How the numbers of transfer are stored on the device: half precision is half of the bytes, and changes colors by 3e-4
    #[arg(long, value_enum, default_value = "f32")]
    pub(crate) storage: StorageName,
    /// Pictures, with the sky turning once around from the first to the last; of a scene that moves, moments of its time
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..))]
    pub(crate) frames: u16,
    /// Columns and rows [default: 512x384, and 1280x720 to measure]
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub(crate) size: Option<[u32; 2]>,
    /// Samples for a pixel along each axis [default: 2, and 1 to measure]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=8))]
    pub(crate) rays: Option<u8>,
    #[command(flatten)]
    pub(crate) camera: JobArgs<CameraOptions>,
    #[command(flatten)]
    pub(crate) tone: JobArgs<ToneOptions>,
    /// The file to write: .png, animated with several frames, or .exr and .hdr in linear light
    #[arg(short, long, value_name = "OUT", requires = "headless")]
    pub(crate) output: Option<PathBuf>,
    /// Measure what each pass takes, and the frames a second with the sky turning, as a table
    #[arg(long)]
    pub(crate) bench: bool,
    /// The scene to measure
    #[arg(long, value_name = "SCENE", requires = "bench")]
    pub(crate) scene: Option<PathBuf>,
    /// Measure the built-in still life with N cells along its ground, 128 as it is opened; 152 are 70000 vertices
    #[arg(long, value_name = "N", requires = "bench", conflicts_with = "scene", value_parser = clap::value_parser!(u16).range(16..=1024))]
    pub(crate) cells: Option<u16>,
    /// Receivers under 128 spheres that are measured beside the scene, 0 for none
    #[arg(long, value_name = "N", default_value_t = 100_000, value_parser = clap::value_parser!(u32).range(0..=1 << 24))]
    pub(crate) receivers: u32,
    /// Print the measurement as JSON
    #[arg(long, requires = "bench")]
    pub(crate) json: bool,
    /// Where what moves is lit, with --mode fields and exponentials
    #[arg(long, value_name = "WHERE", value_enum, default_value_t = LitOn::Auto, requires = "headless")]
    pub(crate) lit_on: LitOn,
    #[command(flatten)]
    pub(crate) limits: ReadLimits,
    /// Take the program that emulates a graphics card
    #[arg(long)]
    pub(crate) software: bool,
}

/// The models that the device shows.
fn surfaces(text: &str) -> Result<Surfaces, String> {
    match text.parse()? {
        Surfaces::MetallicRoughnessSeparable => Err("expected matte or gltf; lobe render shows gltf-separable".into()),
        shown => Ok(shown),
    }
}

impl Arguments {
    /// The tone mapping, whose exposure suits the first picture unless one was asked for.
    pub(crate) fn tone(&self) -> anyhow::Result<Tone> {
        Ok(self.tone.job().map_err(|error| refused(&error))?.of_any())
    }

    /// Refuses a picture that would be written over a file that it is made of.
    pub(crate) fn check_output(&self) -> anyhow::Result<()> {
        let Some(output) = &self.output else { return Ok(()) };
        let inputs = [Some(&self.env), self.headless.as_ref(), self.transfer.as_ref()];
        // By what they lead to: names may be links, or lead through other folders.
        let suns = if let SunChoice::File(path) = &self.suns { Some(path) } else { None };
        let inputs =
            inputs.into_iter().flatten().chain(suns).chain(&self.parts).filter_map(|input| input.canonicalize().ok());
        let inputs: Vec<PathBuf> = inputs.collect();
        let is_input = |output: &PathBuf| output.canonicalize().is_ok_and(|output| inputs.contains(&output));
        let (frames, seconds_per_frame) = (usize::from(self.frames), TurntableOptions::default().seconds);
        let sequence = FrameSequence { width: 1, height: 1, frames, seconds_per_frame };
        if let Some(lost) = (0..frames).map(|frame| sequence.path(output, frame)).find(is_input) {
            bail!("-o: {} is an input, which would be lost; give another name", lost.display());
        }
        Ok(())
    }

    /// The model of reflection.
    pub(crate) fn surfaces(&self) -> Surfaces {
        self.surfaces.unwrap_or_default()
    }

    /// Refuses what says how surfaces reflect where the mode does not ask for it.
    pub(crate) fn check_surfaces(&self) -> anyhow::Result<()> {
        use ModeName::{Glossy, Interreflected, Shadowed, Specular};
        let transfer = self.transfer.as_ref().map(|file| format!("--transfer {}", file.display()));
        let gltf = (self.surfaces() == Surfaces::MetallicRoughness).then(|| "--surfaces gltf".to_owned());
        for (given, modes) in [
            (gltf, &[Shadowed, Interreflected][..]),
            (self.lobe.map(|_| "--lobe".to_owned()), &[Glossy]),
            (self.roughness.map(|_| "--roughness".to_owned()), &[Specular]),
            (transfer, &[Shadowed, Interreflected, Glossy]),
        ] {
            if let Some(option) = given.filter(|_| !modes.contains(&self.mode)) {
                let modes: Vec<String> = modes.iter().map(|mode| mode.name()).collect();
                bail!("{option}: only with --mode {}; leave the option out", modes.join(", "));
            }
        }
        Ok(())
    }
}

/// The light paths of a scene that stands still, and the ways of one that moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum ModeName {
    /// Irradiance of the normal alone, which needs no bake
    Irradiance,
    /// Direct light with shadows
    Shadowed,
    /// Shadows, and the light that surfaces send each other
    Interreflected,
    /// Only the light that surfaces send each other
    Difference,
    /// All surfaces as rough mirrors with shadows and interreflections, by transfer matrices and --lobe
    Glossy,
    /// Microfacets of one --roughness that reflect the prefiltered environment, without shadows: split sum
    Specular,
    /// Parts that move hide the sky by shadow fields
    Fields,
    /// By exponentials of sums of spheres
    Exponentials,
}

impl ModeName {
    /// The name on the command line.
    pub(crate) fn name(self) -> String {
        self.to_possible_value().map(|value| value.get_name().to_owned()).unwrap_or_default()
    }

    /// Of one that moves.
    pub(crate) fn of_moving(self) -> Option<MovingMethod> {
        match self {
            Self::Fields => Some(MovingMethod::Fields),
            Self::Exponentials => Some(MovingMethod::Exponentials),
            _ => None,
        }
    }
}

/// The numbers of transfer on the device.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum StorageName {
    /// Single precision.
    F32,
    /// Half precision.
    F16,
}

impl From<StorageName> for Storage {
    fn from(name: StorageName) -> Self {
        match name {
            StorageName::F32 => Self::F32,
            StorageName::F16 => Self::F16,
        }
    }
}

/// Reads `WxH`.
fn size(text: &str) -> Result<[u32; 2], String> {
    let expected = || format!("expected WIDTHxHEIGHT, each 1 to 16384, found '{text}'");
    let (width, height) = text.split_once('x').ok_or_else(expected)?;
    let side = |text: &str| text.parse().ok().filter(|side| (1..=16384).contains(side));
    Ok([side(width).ok_or_else(expected)?, side(height).ok_or_else(expected)?])
}

/// Reads a number from 0 to 1.
fn roughness(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|x: &f64| (0.0..=1.0).contains(x));
    number.ok_or_else(|| format!("expected a roughness of 0 to 1, found '{text}'"))
}

/// The refusal of an option in the names of the command line.
fn refused(error: &OptionError) -> anyhow::Error {
    anyhow!("{}: {}", flag(&error.option), worded(&error.message, |name| Some(flag(name))))
}

/// The camera on the device for a box in the world.
pub(crate) fn camera_around(options: &JobArgs<CameraOptions>, bounds: [[f64; 3]; 2]) -> anyhow::Result<GpuCamera> {
    let camera = match options.job().map_err(|error| refused(&error))?.camera(bounds) {
        Err(RenderError::OfJob(error)) => return Err(refused(&error)),
        other => other?,
    };
    let on_device = camera.eye_target_angle().and_then(|(eye, target, angle)| GpuCamera::look_at(eye, target, angle));
    on_device.context("the scene has no extent")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        use clap::CommandFactory as _;
        Arguments::command().debug_assert();
    }

    #[test]
    fn sizes_and_roughness_are_numbers_in_range() {
        assert_eq!(size("640x400"), Ok([640, 400]), "a good one");
        for bad in ["640", "0x4", "4x0", "axb", "70000x1", "1x2x3", ""] {
            assert!(size(bad).is_err(), "{bad:?}");
        }
        assert_eq!((roughness("0"), roughness("1")), (Ok(0.0), Ok(1.0)), "mirror and rough");
        for bad in ["-0.1", "1.1", "nan", "inf", "rough"] {
            assert!(roughness(bad).is_err(), "{bad:?}");
        }
    }
}
