//! The sub-commands of `lobe render`, one for each method, and their options.

use clap::{Args, Subcommand};
use lobe::io::{JobArgs, SharingOptions};
use lobe::motion::MovingJob;
use lobe::prt::BakeOptions;
use lobe::render::{Background, TransferSource};

use crate::args::memory::MemoryLimit;
use crate::args::scene_input::SceneInput;
use crate::args::values;
use crate::render::environment::EnvironmentInput;
use crate::render::light::{ExpansionInput, LightInput, SunInput};
use crate::render::mode::Mode;
use crate::render::pictures::Pictures;
use crate::render::render::Render;
use crate::render::surfaces::SurfaceInput;
use crate::render::time::TimeInput;
use crate::render::view::ViewInput;
use crate::run::talk::Talk;

/// The most samples; larger numbers are taken for typing errors.
const MAX_SAMPLES: usize = 1 << 20;

const OF_BAKED: &str = "\
Surfaces seen from behind: single-sided ones are black and stop light all the same. Gaps of an open body no wider than \
two pixels take the light around them. Double-sided ones show the light that falls on their back. Baked files hold \
fronts, and backs by lobe bake --backs. Other backs are baked on the way, with as many paths, as far as the view shows \
them: of a closed body seen from outside there are none.

Memory: 80 bytes for each pixel; transfer that is baked on the way, twice 4 n² bytes for each vertex and channel, of \
glossy 4 n⁴. Scene, light and transfer from a file come on top and are as large as their files.";

const OF_TRACE: &str = "\
Memory: 224 bytes for each pixel, for one picture at a time. Scene and light come on top and are as large as their \
files. Results are kept in OUT.checkpoint until the picture is done: the same command goes on after Ctrl-C.";

const OF_MOVING: &str = "\
Parts of a scene that moves are baked first, which takes minutes, unless its description names files of lobe bake, \
field and spheres. Results are kept in OUT.checkpoint... until all pictures are done: the same command goes on after \
Ctrl-C.

Memory: 80 bytes for each pixel, 192 + 16 n² for each vertex and 320 for each triangle, and what is baked of the parts.";

const OF_MAPS: &str = "\
Memory: 80 bytes for each pixel, up to 96 for each texel of the light, and 160 MB.";

#[derive(Subcommand)]
pub(crate) enum RenderCommand {
    /// By transfer, from a baked file or baked on the way: `lobe render SCENE` means this
    #[command(after_help = OF_BAKED)]
    Baked(Box<Baked>),
    /// By path tracing, the reference: shadows and reflections between surfaces
    #[command(after_help = OF_TRACE)]
    Trace(Box<Trace>),
    /// A scene that moves: transfer of its parts, which hide the sky from each other
    #[command(after_help = OF_MOVING)]
    Moving(Box<Moving>),
    /// By environment mapping: reflections and irradiance looked up in the map, without shadows
    #[command(after_help = OF_MAPS)]
    Maps(Box<Maps>),
    /// By the irradiance of the shading normal times albedo/π, without shadows
    Irradiance(Box<Irradiance>),
}

impl RenderCommand {
    pub(crate) fn run(self, talk: Talk) -> anyhow::Result<()> {
        match self {
            Self::Baked(args) => args.render()?,
            Self::Trace(args) => args.render()?,
            Self::Moving(args) => args.render()?,
            Self::Maps(args) => args.render(),
            Self::Irradiance(args) => args.render(),
        }
        .run(talk)
    }
}

/// What all methods take.
#[derive(Args)]
struct Common {
    #[command(flatten)]
    scene: SceneInput,
    #[command(flatten)]
    light: LightInput,
    #[command(flatten)]
    pictures: Pictures,
    #[command(flatten)]
    view: ViewInput,
    /// What is behind the scene, which lights nothing. env: the environment as it was given, a map interpolated between
    /// its texels; light: the light that lights the scene, which may be an expansion; none: nothing, so that .png has
    /// straight alpha and .exr a channel A beside premultiplied colors; or a color, #rrggbb of sRGB or r,g,b of linear
    /// radiance
    #[arg(long, value_name = "env|light|none|COLOR", default_value_t = Background::Env)]
    background: Background,
    #[command(flatten)]
    memory: MemoryLimit,
}

impl Common {
    fn render(self, mode: Mode) -> Render {
        let Self { scene, light, pictures, view, background, memory } = self;
        Render {
            scene,
            light,
            expansion: ExpansionInput::default(),
            suns: SunInput::default(),
            mode,
            pictures,
            view,
            background,
            memory,
            samples: None,
            bounces: None,
            surfaces: SurfaceInput::default(),
            seed: 0,
            environment: EnvironmentInput::default(),
            transfer: TransferSource::default(),
            time: TimeInput::default(),
            moving: MovingJob::default(),
            fresh: false,
            sharing: SharingOptions::default(),
        }
    }
}

/// Rays of a pixel, of all methods that shade what they hit.
#[derive(Args)]
struct Rays {
    /// Rays for each pixel, four times as many where surfaces end [default: 4]
    #[arg(long, value_name = "N", value_parser = samples)]
    samples: Option<usize>,
}

#[derive(Args)]
pub(crate) struct Baked {
    #[command(flatten)]
    common: Common,
    #[command(flatten)]
    expansion: ExpansionInput,
    #[command(flatten)]
    suns: SunInput,
    #[command(flatten)]
    rays: Rays,
    #[command(flatten)]
    surfaces: SurfaceInput,
    #[command(flatten)]
    transfer: JobArgs<TransferSource>,
}

#[derive(Args)]
pub(crate) struct Trace {
    #[command(flatten)]
    common: Common,
    #[command(flatten)]
    expansion: ExpansionInput,
    #[command(flatten)]
    suns: SunInput,
    /// Paths for each pixel [default: 64]
    #[arg(long, value_name = "N", value_parser = samples)]
    samples: Option<usize>,
    /// Reflections before that of the surface that is seen [default: 3]
    #[arg(long, value_name = "B", value_parser = bounces)]
    bounces: Option<usize>,
    /// Another seed gives other paths
    #[arg(long, value_name = "S", default_value_t = 0)]
    seed: u64,
    #[command(flatten)]
    surfaces: SurfaceInput,
    #[command(flatten)]
    time: TimeInput,
    /// Start anew, even if there is a checkpoint of what was stopped
    #[arg(long)]
    fresh: bool,
    #[command(flatten)]
    sharing: JobArgs<SharingOptions>,
}

#[derive(Args)]
pub(crate) struct Moving {
    #[command(flatten)]
    common: Common,
    #[command(flatten)]
    expansion: ExpansionInput,
    #[command(flatten)]
    suns: SunInput,
    #[command(flatten)]
    rays: Rays,
    #[command(flatten)]
    surfaces: SurfaceInput,
    #[command(flatten)]
    time: TimeInput,
    #[command(flatten)]
    moving: JobArgs<MovingJob>,
    /// Start anew, even if there are checkpoints of bakes that were stopped
    #[arg(long)]
    fresh: bool,
}

#[derive(Args)]
pub(crate) struct Maps {
    #[command(flatten)]
    common: Common,
    #[command(flatten)]
    rays: Rays,
    #[command(flatten)]
    surfaces: SurfaceInput,
    #[command(flatten)]
    environment: EnvironmentInput,
}

#[derive(Args)]
pub(crate) struct Irradiance {
    #[command(flatten)]
    common: Common,
    #[command(flatten)]
    expansion: ExpansionInput,
    #[command(flatten)]
    suns: SunInput,
    #[command(flatten)]
    rays: Rays,
}

fn samples(text: &str) -> Result<usize, String> {
    values::whole(text, 1, MAX_SAMPLES, "a number of samples")
}

fn bounces(text: &str) -> Result<usize, String> {
    values::whole(text, 0, BakeOptions::MAX_BOUNCES, "a number of reflections")
}

impl Baked {
    fn render(self) -> anyhow::Result<Render> {
        let Self { common, expansion, suns, rays, surfaces, transfer } = self;
        let transfer = transfer.job()?;
        Ok(Render { expansion, suns, samples: rays.samples, surfaces, transfer, ..common.render(Mode::Baked) })
    }
}

impl Trace {
    fn render(self) -> anyhow::Result<Render> {
        let Self { common, expansion, suns, samples, bounces, seed, surfaces, time, fresh, sharing } = self;
        let render = common.render(Mode::Trace);
        let sharing = sharing.job()?;
        Ok(Render { expansion, suns, samples, bounces, seed, surfaces, time, fresh, sharing, ..render })
    }
}

impl Moving {
    fn render(self) -> anyhow::Result<Render> {
        let Self { common, expansion, suns, rays, surfaces, time, moving, fresh } = self;
        let moving = moving.job()?;
        Ok(Render {
            expansion,
            suns,
            samples: rays.samples,
            surfaces,
            time,
            moving,
            fresh,
            ..common.render(Mode::Moving)
        })
    }
}

impl Maps {
    fn render(self) -> Render {
        let Self { common, rays, surfaces, environment } = self;
        Render { samples: rays.samples, surfaces, environment, ..common.render(Mode::Maps) }
    }
}

impl Irradiance {
    fn render(self) -> Render {
        let Self { common, expansion, suns, rays } = self;
        Render { expansion, suns, samples: rays.samples, ..common.render(Mode::Irradiance) }
    }
}
