//! `lobe render`: a scene under distant light, by transfer or by path tracing.

use std::path::PathBuf;

use anyhow::bail;
use clap::{Args, ValueEnum};
use lobe::io::Job;
use lobe::prt::{BakeMode, BakeOptions};
use lobe::render::{
    BakedScene, Camera, DistantLight, GlossyLobe, MovingMethod, MovingScene, MovingShading, PathOptions, RenderError,
    SampleCount, Surfaces, TruthOptions, ViewOptions, light_baked_scene, light_by_irradiance, light_moving_scene,
    render_truth,
};
use lobe::scene::{Bvh, Scene};
use lobe::sh::{Dir, Rgb, Rotation, ShVec};

use crate::args::memory::MemoryLimit;
use crate::args::scene_input::SceneInput;
use crate::args::values;
use crate::render::frames::{Frames, SECONDS_PER_FRAME};
use crate::render::light::{LightInput, ReadLight};
use crate::render::moving::MovingInput;
use crate::render::pictures::{Pictures, Rendered};
use crate::render::transfer::{Asked, parse_lobe};
use crate::render::view::ViewInput;
use crate::run::talk::Talk;

/// The most samples; larger numbers are taken for typing errors.
const MAX_SAMPLES: usize = 1 << 20;

/// Samples of a pixel without --samples: paths of the truth, rays of all else.
const PATHS: usize = 64;
const RAYS: usize = 4;

/// Bounces without --bounces, as in the bake.
const BOUNCES: usize = 3;

/// The order of irradiance without --order: higher bands hardly show.
const IRRADIANCE_ORDER: usize = 3;

/// The lobe without --lobe: about the sharpest that order 4 can show.
const LOBE: GlossyLobe = GlossyLobe::Ggx(0.3);

const NOTES: &str = "\
Surfaces seen from behind: single-sided ones are black, in every mode, and stop light all the same. Double-sided ones show the light \
that falls on their back. Baked files hold fronts; backs are baked on the way, with as many paths, as far as the view shows them: of a \
closed body seen from outside there are none.

Memory: 224 bytes for each pixel of the truth, 60 else, for one picture at a time; transfer that is baked on the way, twice 4 n² bytes \
for each vertex and channel, of glossy 4 n⁴. Scene, light and transfer from a file come on top and are as large as their files.";

#[derive(Args)]
#[command(after_help = NOTES)]
pub(crate) struct Render {
    #[command(flatten)]
    scene: SceneInput,
    #[command(flatten)]
    light: LightInput,
    /// The method that makes the picture
    #[arg(long, value_enum)]
    mode: Mode,
    #[command(flatten)]
    pictures: Pictures,
    #[command(flatten)]
    view: ViewInput,
    /// Paths (truth) or rays (else) for each pixel [default: 64, 4]
    #[arg(long, value_name = "N", value_parser = samples)]
    samples: Option<usize>,
    /// truth, interreflected, glossy: the number of reflections before that of the surface that is seen [default: 3]
    #[arg(long, value_name = "B", value_parser = bounces)]
    bounces: Option<usize>,
    /// truth: the model of reflection [default: matte, as in a bake]
    #[arg(long, value_enum)]
    surfaces: Option<SurfaceModel>,
    /// truth: another seed gives other paths [default: 0]
    #[arg(long, value_name = "S")]
    seed: Option<u64>,
    /// Paths from each vertex where the scene is not baked yet, 1 to 1048576 [default: 1024]
    #[arg(long, value_name = "N", value_parser = samples)]
    bake_samples: Option<usize>,
    /// All but truth and irradiance: the transfer of this scene that lobe bake, compress or fit-lobes wrote without the scene, a
    /// .safetensors file, or an .exr file of lobe bake --texels
    #[arg(long, value_name = "FILE")]
    transfer: Option<PathBuf>,
    #[command(flatten)]
    moving: MovingInput,
    /// glossy: the lobe of reflection about the mirrored view, tinted by the base color [default: ggx:0.3]. For metals of α 0.3
    /// the picture differs by 18 % from --mode truth --surfaces gltf, for rougher ones by more
    #[arg(long, value_name = "phong:E|ggx:ALPHA", value_parser = parse_lobe)]
    lobe: Option<GlossyLobe>,
    /// All but truth, which shows the light that it uses: the background behind the scene; light, to compare with a truth of
    /// the same --order [default: env]
    #[arg(long, value_enum)]
    background: Option<Background>,
    #[command(flatten)]
    memory: MemoryLimit,
    /// truth: start anew, even if there is a checkpoint of a picture that was stopped
    #[arg(long)]
    fresh: bool,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Mode {
    /// Path tracing: shadows and reflections between surfaces
    Truth,
    /// The irradiance of the expansion by shading normal, times albedo/π
    Irradiance,
    /// Transfer without shadows
    Unshadowed,
    /// Transfer with shadows
    Shadowed,
    /// Transfer with shadows and reflections between surfaces
    Interreflected,
    /// Transfer matrices with shadows and reflections between surfaces, and rough mirrors
    Glossy,
    /// A scene that moves: transfer of its parts, which hide the sky from each other by precomputed shadow fields
    Fields,
    /// The same by exponentials of sums of spheres (SHEXP)
    Shexp,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum SurfaceModel {
    /// Lambert with the base color as albedo
    Matte,
    /// The metallic-roughness model of glTF, Smith's masking height-correlated, as renderers have it
    Gltf,
    /// The same with separable masking, as the specification of glTF prints it
    GltfSeparable,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Background {
    /// The environment as it was given
    Env,
    /// The expansion that lights the scene
    Light,
}

fn samples(text: &str) -> Result<usize, String> {
    values::whole(text, 1, MAX_SAMPLES, "a number of samples")
}

fn bounces(text: &str) -> Result<usize, String> {
    values::whole(text, 0, BakeOptions::MAX_BOUNCES, "a number of reflections")
}

/// The scene, with transfer where the mode needs it.
enum Stage {
    Plain(Scene, Bvh),
    Baked(Box<BakedScene>),
    /// Its parts move; how they are shaded, unless they are traced.
    Moving(Box<MovingScene>, Option<MovingShading>),
}

impl Stage {
    /// The bands that the light needs, unless it is asked for others.
    fn order(&self) -> usize {
        match self {
            Self::Plain(..) | Self::Moving(_, None) => IRRADIANCE_ORDER,
            Self::Baked(baked) => baked.order(),
            Self::Moving(_, Some(shading)) => shading.order(),
        }
    }
}

/// A box around a scene at some of its times.
fn moving_bounds(moving: &MovingScene, times: &[f64]) -> Result<[[f64; 3]; 2], RenderError> {
    let mut all = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
    for &time in times {
        let [min, max] = moving.at(time)?.scene().world_bounds();
        for k in 0..3 {
            all[0][k] = all[0][k].min(min[k]);
            all[1][k] = all[1][k].max(max[k]);
        }
    }
    Ok(all)
}

/// The inputs that all frames share.
struct Work<'a> {
    stage: Stage,
    camera: Camera,
    light: &'a ReadLight,
    /// None where the light is used as it was given.
    expansion: Option<ShVec<Rgb<f64>>>,
}

impl Render {
    pub(crate) fn run(&self, talk: Talk) -> anyhow::Result<()> {
        self.check_options()?;
        self.check_memory()?;
        let inputs = [Some(self.scene.path()), Some(self.light.path()), self.transfer.as_deref()];
        self.pictures.check(&inputs.into_iter().flatten().collect::<Vec<_>>())?;
        let light = self.light.read(talk)?;
        let (stage, camera) = self.stage(talk)?;
        let order = stage.order();
        let is_expansion = self.mode != Mode::Truth || self.light.asks_for_expansion(&light);
        let expansion = is_expansion.then(|| self.light.expansion(&light, order));
        let work = Work { stage, camera, light: &light, expansion };
        let is_kept = self.mode == Mode::Truth;
        let is_range = self.pictures.is_range();
        let seconds_per_frame = if is_range { self.moving.seconds_per_frame() } else { SECONDS_PER_FRAME };
        let frames = Frames { pictures: &self.pictures, size: self.view.size(), is_kept, seconds_per_frame, talk };
        let count = if is_range { 1 } else { self.pictures.count() };
        frames.render(self.fresh, &mut |k, job| {
            let (turn, time) = (self.light.turn(k % count, count), self.moving.time_of(self.pictures.frame(k)));
            self.render(&work, &turn, time, job)
        })
    }

    /// The scene as the mode needs it, and the camera that sees it.
    fn stage(&self, talk: Talk) -> anyhow::Result<(Stage, Camera)> {
        if self.is_moving() {
            let mut moving = self.moving.read(&self.scene, &self.memory, talk)?;
            let camera = self.view.camera_around(moving_bounds(&moving, &self.times())?)?;
            let shading = match self.moving_method() {
                Some(method) => Some(self.moving.prepare(&mut moving, method, &self.bake_options(), talk)?),
                None => None,
            };
            return Ok((Stage::Moving(Box::new(moving), shading), camera));
        }
        Ok(match self.asked() {
            None => {
                let scene = self.scene.read(&self.memory, talk)?;
                let (bvh, camera) = (Bvh::new(&scene), self.view.camera(&scene)?);
                (Stage::Plain(scene, bvh), camera)
            }
            Some(asked) => {
                let view = |scene: &Scene| Ok((self.view.camera(scene)?, self.view_options()));
                let (baked, camera) = asked.prepare(&self.scene, view, &self.memory, talk)?;
                (Stage::Baked(Box::new(baked)), camera)
            }
        })
    }

    fn render(&self, work: &Work<'_>, turn: &Rotation, time: f64, job: Job<'_>) -> Result<Rendered, RenderError> {
        let moment = match &work.stage {
            Stage::Moving(moving, _) => Some(moving.at(time)?),
            _ => None,
        };
        let traced = match (&work.stage, &moment) {
            (Stage::Plain(scene, bvh), _) => Some((scene, bvh)),
            (Stage::Moving(..), Some(moment)) => Some((moment.scene(), moment.bvh())),
            _ => None,
        };
        match (traced, &work.expansion) {
            (Some((scene, bvh)), expansion) if self.mode == Mode::Truth => {
                let light = match expansion {
                    Some(f) => DistantLight::from_expansion(f.clone()),
                    None => work.light.as_it_is(),
                };
                let (light, options) = (light.turned(turn), self.truth_options());
                let truth = render_truth(scene, bvh, &work.camera, &light, &options, job)?;
                Ok(Rendered::Traced(Box::new(truth)))
            }
            (traced, Some(f)) => {
                let behind = match self.background.unwrap_or(Background::Env) {
                    Background::Env => work.light.as_it_is(),
                    Background::Light => DistantLight::from_expansion(f.clone()),
                };
                let (behind, f) = (behind.turned(turn), turn.rotated(f));
                let background = |s: Dir| behind.radiance(s);
                let (camera, options) = (&work.camera, self.view_options());
                let lit = match (&work.stage, &moment, traced) {
                    (Stage::Baked(baked), ..) => light_baked_scene(baked, &f, camera, &options, background, job),
                    (Stage::Moving(_, Some(shading)), Some(moment), _) => {
                        light_moving_scene(moment, shading, &f, camera, &options, background, job)
                    }
                    (.., Some((scene, bvh))) => light_by_irradiance(scene, bvh, &f, camera, &options, background, job),
                    _ => unreachable!("a scene without transfer is as it is or moves"),
                };
                lit.map(Rendered::Shaded)
            }
            (_, None) => unreachable!("all modes but truth light with an expansion"),
        }
    }

    fn truth_options(&self) -> TruthOptions {
        let (width, height) = self.view.size();
        let count = SampleCount::of(self.samples.unwrap_or(PATHS));
        TruthOptions::default().width(width).height(height).count(count).paths(self.path_options())
    }

    /// The options of the view of all modes but truth.
    fn view_options(&self) -> ViewOptions {
        let (width, height) = self.view.size();
        let rays = (self.samples.unwrap_or(RAYS) as f64).sqrt().ceil() as usize;
        ViewOptions::default().width(width).height(height).rays(rays)
    }

    fn path_options(&self) -> PathOptions {
        let surfaces = match self.surfaces {
            None | Some(SurfaceModel::Matte) => Surfaces::Matte,
            Some(SurfaceModel::Gltf) => Surfaces::MetallicRoughness,
            Some(SurfaceModel::GltfSeparable) => Surfaces::MetallicRoughnessSeparable,
        };
        let bounces = self.bounces.unwrap_or(BOUNCES);
        PathOptions::default().bounces(bounces).surfaces(surfaces).seed(self.seed.unwrap_or(0))
    }

    /// Whether the scene is asked for at a time.
    fn is_moving(&self) -> bool {
        self.moving_method().is_some()
            || self.moving.asked().is_some()
            || self.pictures.is_range()
            || self.scene.has_extension(&["json"])
            || self.scene.is_built_in_motion()
    }

    /// How parts that move hide the sky from others; `None` in other modes.
    fn moving_method(&self) -> Option<MovingMethod> {
        match self.mode {
            Mode::Fields => Some(MovingMethod::Fields),
            Mode::Shexp => Some(MovingMethod::Exponentials),
            _ => None,
        }
    }

    /// The times of the first picture, the one in the middle and the last.
    fn times(&self) -> [f64; 3] {
        let last = self.pictures.count() - 1;
        [0, last / 2, last].map(|k| self.moving.time_of(self.pictures.frame(k)))
    }

    /// The bake of parts that move.
    fn bake_options(&self) -> BakeOptions {
        let defaults = BakeOptions::default();
        defaults
            .clone()
            .order(self.light.order().unwrap_or(defaults.order))
            .samples(self.bake_samples.map_or(defaults.samples, |n| n as u32))
            .bounces(self.bounces.unwrap_or(defaults.bounces))
    }

    /// The transfer that the mode needs.
    fn asked(&self) -> Option<Asked> {
        let mode = match self.mode {
            Mode::Truth | Mode::Irradiance | Mode::Fields | Mode::Shexp => return None,
            Mode::Unshadowed => BakeMode::Unshadowed,
            Mode::Shadowed => BakeMode::Shadowed,
            Mode::Interreflected => BakeMode::Interreflected,
            Mode::Glossy => BakeMode::Glossy,
        };
        let lobe = (self.mode == Mode::Glossy).then(|| self.lobe.unwrap_or(LOBE));
        let (order, samples, file) = (self.light.order(), self.bake_samples, self.transfer.clone());
        Some(Asked { mode, order, samples, bounces: self.bounces, lobe, file })
    }

    /// Refuses a picture that takes too much memory.
    fn check_memory(&self) -> anyhow::Result<()> {
        let (width, height) = self.view.size();
        let is_truth = self.mode == Mode::Truth;
        let bytes = if is_truth { self.truth_options().bytes() } else { self.view_options().bytes() };
        self.memory.check(&format!("--size {width}x{height}"), bytes, "a smaller picture")
    }

    /// Refuses options that would be ignored.
    fn check_options(&self) -> anyhow::Result<()> {
        let is_truth = self.mode == Mode::Truth;
        let method = self.moving_method();
        let bakes = !matches!(self.mode, Mode::Truth | Mode::Irradiance);
        let bounces = matches!(self.mode, Mode::Truth | Mode::Interreflected | Mode::Glossy) || method.is_some();
        self.moving.check(self.pictures.is_range(), method)?;
        if self.is_moving() && !is_truth && method.is_none() {
            bail!(
                "a scene that moves is shown by --mode truth, fields or shexp; leave out --time and its like for others"
            );
        }
        if let Some(option) = self.moving.asked_of_shading().filter(|_| method.is_none()) {
            bail!("{option}: only of --mode fields and shexp; leave the option out");
        }
        let ignored = [
            (self.bounces.is_some() && !bounces, "--bounces: only of --mode truth, interreflected and glossy"),
            (self.surfaces.is_some() && !is_truth, "--surfaces: only of --mode truth; all others are matte"),
            (self.seed.is_some() && !is_truth, "--seed: only --mode truth is random"),
            (self.bake_samples.is_some() && !bakes, "--bake-samples: only of modes with transfer"),
            (
                self.transfer.is_some() && (!bakes || method.is_some()),
                "--transfer: only of modes with transfer that do not move",
            ),
            (self.lobe.is_some() && self.mode != Mode::Glossy, "--lobe: only of --mode glossy"),
            (self.background.is_some() && is_truth, "--background: --mode truth shows the light it uses"),
            (self.fresh && !is_truth, "--fresh: only --mode truth keeps a checkpoint"),
        ];
        if let Some((_, message)) = ignored.into_iter().find(|(is_ignored, _)| *is_ignored) {
            bail!("{message}; leave the option out");
        }
        Ok(())
    }
}
