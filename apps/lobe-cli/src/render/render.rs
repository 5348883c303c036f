//! `lobe render`: a scene under distant light, by transfer, by environment mapping or by path tracing.

use std::path::PathBuf;
use std::time::Instant;

use anyhow::bail;
use clap::Args;
use lobe::io::{Job, Progress, Shard};
use lobe::prt::{BakeMode, BakeOptions, GlossyLobe, Transfer};
use lobe::render::{
    Background, Camera, DistantLight, Emitter, EnvironmentMaps, MovingMethod, MovingScene, MovingShading, RenderError,
    Surfaces, TruthOptions, ViewOptions, light_baked_scene, light_by_environment_maps, light_by_irradiance,
    light_moving_scene, render_truth_shard,
};
use lobe::scene::{Bvh, Scene};
use lobe::sh::{Dir, Rotation};

use crate::args::memory::MemoryLimit;
use crate::args::open_scene::OpenScene;
use crate::args::output;
use crate::args::scene_input::SceneInput;
use crate::args::sharing::{self, Sharing};
use crate::args::values;
use crate::args::vertex_budget::VertexBudget;
use crate::render::environment::EnvironmentInput;
use crate::render::frames::{Frames, SECONDS_PER_FRAME};
use crate::render::light::{LightInput, ReadLight};
use crate::render::mode::Mode;
use crate::render::moving::{AskedBake, Keep, MovingInput, Prepared};
use crate::render::pictures::{Pictures, Rendered};
use crate::render::stage::{Lit, Stage, Work, moving_bounds};
use crate::render::surfaces::SurfaceInput;
use crate::render::transfer::Asked;
use crate::render::truth::{self, TruthInput};
use crate::render::view::ViewInput;
use crate::run::bake_watch::Checkpoint;
use crate::run::talk::Talk;

/// The most samples; larger numbers are taken for typing errors.
const MAX_SAMPLES: usize = 1 << 20;

/// Rays of a pixel without --samples, of all modes but truth.
const RAYS: usize = 4;

/// So many times as many where surfaces end.
const EDGE_RAYS: usize = 4;

/// Bounces without --bounces, as in the bake.
const BOUNCES: usize = 3;

/// The lobe without --lobe: about the sharpest that order 4 can show.
const LOBE: GlossyLobe = GlossyLobe::Ggx(0.3);

const NOTES: &str = "\
Surfaces seen from behind: single-sided ones are black, in every mode, and stop light all the same. In all modes \
except truth, gaps of an open body no wider than two pixels take the light around them. Double-sided ones show the \
light that falls on their back. Baked files hold fronts, and backs by lobe bake --backs; else backs are baked on the \
way, with as many paths, as far as the view shows them: of a closed body seen from outside there are none.

Memory: 224 bytes for each pixel of the truth, 80 else, for one picture at a time; transfer that is baked on the way, \
twice 4 n² bytes for each vertex and channel, of glossy 4 n⁴; environment mapping, up to 96 for each texel of the \
light and 160 MB. Scene, light and transfer from a file come on top and are as large as their files. A scene that \
moves takes 192 + 16 n² bytes more for each vertex, 320 for each triangle, and what is baked of its parts.

Parts of a scene that moves are baked first, which takes minutes, unless its description names files of lobe bake, \
field and spheres. Results are kept in OUT.checkpoint... until all pictures are done: the same command goes on after \
Ctrl-C.";

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
    /// Paths (truth) or rays (else) for each pixel; four times as many rays where surfaces end [default: 64, 4]
    #[arg(long, value_name = "N", value_parser = samples)]
    samples: Option<usize>,
    /// truth, interreflected, glossy: the number of reflections before that of the surface that is seen; fields, shexp: those within
    /// each part, 0 to compare them with a truth of 0 [default: 3]
    #[arg(long, value_name = "B", value_parser = bounces)]
    bounces: Option<usize>,
    #[command(flatten)]
    surfaces: SurfaceInput,
    #[command(flatten)]
    truth: TruthInput,
    #[command(flatten)]
    environment: EnvironmentInput,
    /// Paths from each vertex where the scene is not baked yet, 1 to 1048576 [default: 1024, or up to 4096 where
    /// their noise is above 2 %]
    #[arg(long, value_name = "N", value_parser = samples)]
    bake_samples: Option<usize>,
    #[command(flatten)]
    budget: VertexBudget,
    /// All but truth, irradiance and environment: the transfer of this scene that lobe bake, compress or fit-lobes wrote without
    /// the scene, a .safetensors file, or an .exr file of lobe bake --texels
    #[arg(long, value_name = "FILE")]
    transfer: Option<PathBuf>,
    #[command(flatten)]
    moving: MovingInput,
    /// glossy: the lobe of reflection about the mirrored view, tinted by the base color [default: ggx:0.3]. For metals of α 0.3
    /// the picture differs by 18 % from --mode truth --surfaces gltf, for rougher ones by more
    #[arg(long, value_name = "phong:E|ggx:ALPHA")]
    lobe: Option<GlossyLobe>,
    /// What is behind the scene, which lights nothing. env: the environment as it was given, a map interpolated between
    /// its texels; light: the light that lights the scene, its expansion in all modes but truth without --order and
    /// environment; none: nothing, so that .png has straight alpha and .exr a channel A beside premultiplied colors; or
    /// a color, #rrggbb of sRGB or r,g,b of linear radiance
    #[arg(long, value_name = "env|light|none|COLOR", default_value_t = Background::Env)]
    background: Background,
    #[command(flatten)]
    memory: MemoryLimit,
    /// truth, fields, shexp: start anew, even if there is a checkpoint of what was stopped
    #[arg(long)]
    fresh: bool,
    #[command(flatten)]
    sharing: Sharing,
}

fn samples(text: &str) -> Result<usize, String> {
    values::whole(text, 1, MAX_SAMPLES, "a number of samples")
}

fn bounces(text: &str) -> Result<usize, String> {
    values::whole(text, 0, BakeOptions::MAX_BOUNCES, "a number of reflections")
}

impl Render {
    pub(crate) fn run(&self, talk: Talk) -> anyhow::Result<()> {
        self.check_options()?;
        self.check_memory()?;
        let inputs =
            [Some(self.scene.path()), Some(self.light.path()), self.transfer.as_deref(), self.moving.table_path()];
        let inputs: Vec<_> = inputs.into_iter().flatten().chain(self.sharing.inputs()).collect();
        if self.sharing.shard.is_some() {
            self.sharing.check(self.pictures.output())?;
            output::prepare_file(self.pictures.output(), &inputs)?;
        } else {
            self.pictures.check(&inputs)?;
        }
        let light = self.light.read(&self.memory, talk)?;
        let (stage, camera, kept) = self.stage(talk)?;
        let order = stage.order();
        let is_expansion = match self.mode {
            Mode::Truth => self.light.asks_for_expansion(&light),
            Mode::Environment => false,
            _ => true,
        };
        let expansion = is_expansion.then(|| self.light.expansion(&light, order));
        let maps = self.maps(&light, talk)?;
        let mut work = Work { stage, camera, light: &light, expansion, maps, tree: None };
        if let Some(shard) = self.sharing.shard {
            return self.trace_shard(&work, shard, talk);
        }
        let is_range = self.pictures.is_range();
        let frames = Frames {
            pictures: &self.pictures,
            size: self.view.size(),
            is_kept: self.mode == Mode::Truth,
            keeps_bakes: !kept.is_empty(),
            seconds_per_frame: if is_range { self.moving.seconds_in_animation() } else { Some(SECONDS_PER_FRAME) },
            talk,
        };
        let count = if is_range { 1 } else { self.pictures.count() };
        let checkpoint = self.sharing.checkpoint(self.pictures.output());
        self.sharing.merge(&checkpoint, talk)?;
        let merges = !self.sharing.merge.is_empty();
        let rendered = frames.render(self.fresh && !merges, merges.then_some(checkpoint.path()), &mut |k, job| {
            let (turn, time) = (self.light.turn(k % count, count), self.time_of(k));
            self.render(&mut work, &turn, time, job)
        });
        self.sharing.merged(&checkpoint, rendered)?;
        kept.iter().for_each(Checkpoint::finish);
        Ok(())
    }

    /// Traces a shard of the pixels of a picture, which is the file that they are kept in.
    fn trace_shard(&self, work: &Work<'_>, shard: Shard, talk: Talk) -> anyhow::Result<()> {
        let (lit, options, begin) = (self.lit(work, &self.light.turn(0, 1)), self.truth_options(), Instant::now());
        let checkpoint = self.sharing.checkpoint(self.pictures.output());
        if self.fresh {
            checkpoint.discard()?;
        }
        let trace = |(scene, bvh): (&Scene, &Bvh), emitters: &[Emitter]| {
            let work = |job: Job<'_>| {
                render_truth_shard(scene, bvh, &work.camera, (&lit.shown, emitters), &options, shard, job)
            };
            checkpoint.watched(talk, work)
        };
        match &work.stage {
            Stage::Plain(scene, bvh) => trace((scene, bvh), &[])?,
            Stage::Moving(moving, _) => {
                let moment = moving.at(self.scene.pose.seconds())?;
                trace((moment.scene(), moment.bvh()), &moment.emitters())?;
            }
            Stage::Baked(_) => unreachable!("a picture of transfer is not shared"),
        }
        let (points_in_all, seconds) = (options.width * options.height, begin.elapsed().as_secs_f64());
        let points = shard.range(points_in_all).len();
        let done = sharing::Done { shard: shard.to_string(), points, points_in_all, seconds };
        done.tell(self.pictures.output(), false, talk)
    }

    /// The scene as the mode needs it, the camera that sees it, and the files of its bakes.
    fn stage(&self, talk: Talk) -> anyhow::Result<(Stage, Camera, Vec<Checkpoint>)> {
        let open = OpenScene::new(&self.scene, &self.memory, talk)?;
        if self.is_moving() || (self.mode == Mode::Truth && open.has_poses()) {
            return self.moving_stage(open);
        }
        self.scene.expect_no_time_unless_gltf()?;
        let (stage, camera) = match self.asked() {
            None => {
                let scene = self.surfaces.applied(open.scene()?)?;
                let (bvh, camera) = (Bvh::new(&scene), self.view.camera(&scene)?);
                (Stage::Plain(scene, bvh), camera)
            }
            Some(asked) => {
                let view = |scene: &Scene| Ok((self.view.camera(scene)?, self.view_options()));
                let (baked, camera) = asked.prepare(open, view)?;
                (Stage::Baked(Box::new(baked)), camera)
            }
        };
        Ok((stage, camera, Vec::new()))
    }

    fn moving_stage(&self, open: OpenScene<'_>) -> anyhow::Result<(Stage, Camera, Vec<Checkpoint>)> {
        self.surfaces.expect_own_finish(&self.scene.name())?;
        let asked = AskedBake { order: self.light.order(), bounces: self.bounces };
        let asked = self.moving_method().map(|_| asked);
        let talk = open.talk;
        let (mut moving, is_endless) = self.moving.read(open, asked.as_ref())?;
        let name = self.scene.name();
        let times: Vec<f64> = (0..self.pictures.count()).map(|k| self.time_of(k)).collect();
        if self.pictures.is_turn() && moving.span()[0] < moving.span()[1] {
            talk.note(&name, "stands still while the light turns; --frames A..B lets it move");
        } else if !is_endless {
            self.moving.note_end(&moving, &times, &name, talk);
        }
        if self.pictures.is_range() && self.moving.seconds_in_animation().is_none() {
            let text = "no animation of the pictures is written, which cannot show each for so short or so long";
            talk.note(&self.pictures.name(), text);
        }
        let camera = self.view.camera_around(moving_bounds(&moving, &times)?)?;
        let prepared = match self.moving_method() {
            Some(method) => {
                let keep = Keep { output: self.pictures.output(), is_fresh: self.fresh, talk };
                let bake = self.bake_options(&moving);
                MovingInput::split(&mut moving, &self.budget, &bake, &name, talk)?;
                Some(self.moving.prepare(&mut moving, method, &bake, &self.memory, &keep)?)
            }
            None => None,
        };
        let (shading, kept) = match prepared {
            Some(Prepared { shading, kept }) => (Some(shading), kept),
            None => (None, Vec::new()),
        };
        Ok((Stage::Moving(Box::new(moving), shading), camera, kept))
    }

    fn render(&self, work: &mut Work<'_>, turn: &Rotation, time: f64, job: Job<'_>) -> Result<Rendered, RenderError> {
        let lit = self.lit(work, turn);
        let Work { stage, camera, tree, maps, .. } = work;
        match stage {
            Stage::Plain(scene, bvh) if self.mode == Mode::Truth => {
                truth::traced((scene, bvh), (&lit.shown, &[]), camera, &self.truth_options(), job)
            }
            Stage::Moving(moving, None) => {
                let moment = moving.at(time)?;
                let lights = (&lit.shown, &moment.emitters()[..]);
                truth::traced((moment.scene(), moment.bvh()), lights, camera, &self.truth_options(), job)
            }
            Stage::Moving(moving, Some(shading)) => self.shaded((moving, tree), shading, time, camera, &lit, job),
            Stage::Plain(scene, bvh) => {
                let (background, view) = (|s: Dir| lit.shown.seen(s), self.view_options());
                let picture = match maps {
                    Some(maps) => {
                        light_by_environment_maps(scene, bvh, maps.turned(turn), camera, &view, background, job)?
                    }
                    None => light_by_irradiance(scene, bvh, lit.light(), camera, &view, background, job)?,
                };
                Ok(Rendered::Shaded(lit.finished(picture)))
            }
            Stage::Baked(baked) => {
                let background = |s: Dir| lit.shown.seen(s);
                let picture = light_baked_scene(baked, lit.light(), camera, &self.view_options(), background, job)?;
                Ok(Rendered::Shaded(lit.finished(picture)))
            }
        }
    }

    /// The light of a picture, turned.
    fn lit(&self, work: &Work<'_>, turn: &Rotation) -> Lit {
        let shown = match &work.expansion {
            Some(f) => DistantLight::from_expansion(f.clone()),
            None => work.light.as_it_is(),
        };
        let shown = shown.before(work.light.backdrop(self.background)).turned(turn);
        Lit { shown, expansion: work.expansion.as_ref().map(|f| turn.rotated(f)) }
    }

    /// A moment of a scene that moves, the backs that it shows baked before; its tree is that of the moment before, refit.
    fn shaded(
        &self,
        (moving, tree): (&mut MovingScene, &mut Option<Bvh>),
        shading: &MovingShading,
        time: f64,
        camera: &Camera,
        lit: &Lit,
        mut job: Job<'_>,
    ) -> Result<Rendered, RenderError> {
        let view = self.view_options();
        // The line of progress is that of the picture.
        let mut quiet = |_: &Progress| job.report(&Progress { total: 1, ..Progress::default() });
        let mut moment = moving.at_with(time, tree.take())?;
        let seen = MovingScene::backs_in_view(&moment, camera, &view, Job::default().watched_by(&mut quiet))?;
        if !seen.is_empty() {
            let bvh = moment.into_bvh();
            let bake = self.bake_options(moving).order(shading.order());
            moving.bake_backs(&seen, &bake, Job::default().watched_by(&mut quiet))?;
            moment = moving.at_with(time, Some(bvh))?;
        }
        let background = |s: Dir| lit.shown.seen(s);
        let shaded = light_moving_scene(&moment, shading, lit.light(), camera, &view, background, job)?;
        *tree = Some(moment.into_bvh());
        Ok(Rendered::Shaded(lit.finished(shaded)))
    }

    fn truth_options(&self) -> TruthOptions {
        let surfaces = self.surfaces.model(Surfaces::Matte);
        self.truth.options(self.view.size(), self.samples, self.bounces.unwrap_or(BOUNCES), surfaces)
    }

    /// The maps of environment mapping; none in other modes.
    fn maps(&self, light: &ReadLight, talk: Talk) -> anyhow::Result<Option<EnvironmentMaps>> {
        let (Mode::Environment, Some(map)) = (self.mode, light.map()) else { return Ok(None) };
        let surfaces = self.surfaces.model(Surfaces::MetallicRoughness);
        let name = self.light.path().display().to_string();
        self.environment.maps((map, &name), surfaces, &self.memory, talk).map(Some)
    }

    /// The options of the view of all modes but truth.
    fn view_options(&self) -> ViewOptions {
        let (width, height) = self.view.size();
        let rays = (self.samples.unwrap_or(RAYS) as f64).sqrt().ceil() as usize;
        ViewOptions::default().width(width).height(height).rays(rays).edge_rays(EDGE_RAYS * rays * rays)
    }

    /// The time of a picture, in seconds.
    fn time_of(&self, picture: usize) -> f64 {
        self.moving.time_of(&self.scene.pose, self.pictures.frame(picture))
    }

    /// Whether the scene is asked for at times.
    fn is_moving(&self) -> bool {
        self.moving_method().is_some()
            || (self.mode == Mode::Truth && self.scene.pose.asked().is_some())
            || self.moving.asked().is_some()
            || self.pictures.is_range()
            || self.scene.has_extension(&["json"])
            || self.scene.is_built_in_motion()
    }

    /// Whether machines share the work.
    fn is_shared(&self) -> bool {
        self.sharing.shard.is_some() || !self.sharing.merge.is_empty()
    }

    /// How parts that move hide the sky from others; `None` in other modes.
    fn moving_method(&self) -> Option<MovingMethod> {
        match self.mode {
            Mode::Fields => Some(MovingMethod::Fields),
            Mode::Shexp => Some(MovingMethod::Exponentials),
            _ => None,
        }
    }

    /// The bake of parts that move, of as many bands as those have that are baked.
    fn bake_options(&self, moving: &MovingScene) -> BakeOptions {
        let defaults = BakeOptions::default();
        let order = self.light.order().or_else(|| moving.order()).unwrap_or(defaults.order);
        let mut options = defaults.clone().order(order).bounces(self.bounces.unwrap_or(defaults.bounces));
        options.samples = self.bake_samples.map(|n| n as u32);
        options
    }

    /// The transfer that the mode needs.
    fn asked(&self) -> Option<Asked> {
        let mode = match self.mode {
            Mode::Truth | Mode::Irradiance | Mode::Environment | Mode::Fields | Mode::Shexp => return None,
            Mode::Unshadowed => BakeMode::Unshadowed,
            Mode::Shadowed => BakeMode::Shadowed,
            Mode::Interreflected => BakeMode::Interreflected,
            Mode::Glossy => BakeMode::Glossy,
        };
        let lobe = (self.mode == Mode::Glossy).then(|| self.lobe.unwrap_or(LOBE));
        let (order, samples, file) = (self.light.order(), self.bake_samples, self.transfer.clone());
        Some(Asked { mode, order, samples, bounces: self.bounces, lobe, budget: self.budget, file })
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
        let bakes = !matches!(self.mode, Mode::Truth | Mode::Irradiance | Mode::Environment);
        let bounces = matches!(self.mode, Mode::Truth | Mode::Interreflected | Mode::Glossy) || method.is_some();
        self.moving.check(&self.scene.pose, &self.pictures, method)?;
        if let Some(option) = self.moving.asked_of_shading().filter(|_| method.is_none()) {
            bail!("{option}: only of --mode fields and shexp; leave the option out");
        }
        if !is_truth && method.is_none() {
            let range = self.pictures.is_range().then_some("--frames A..B");
            if let Some(option) = self.moving.asked().or(range) {
                bail!(
                    "{option}: a scene that moves is shown by --mode truth, fields or shexp; leave the option out for others"
                );
            }
            if self.is_moving() {
                bail!("{}: moves; it is shown by --mode truth, fields or shexp", self.scene.name());
            }
        }
        if method.is_some() && self.light.order().is_some_and(|order| order > Transfer::MAX_ORDER) {
            bail!("--order: shadows of what moves have an order of 1 to {}", Transfer::MAX_ORDER);
        }
        if !is_truth {
            self.truth.refuse()?;
        }
        self.surfaces.check(self.mode.surfaces())?;
        let is_environment = self.mode == Mode::Environment;
        if is_environment {
            self.light.expect_map()?;
        }
        self.environment.check(is_environment.then(|| self.surfaces.model(Surfaces::MetallicRoughness)))?;
        let ignored = [
            (
                self.bounces.is_some() && !bounces,
                "--bounces: only of --mode truth, interreflected, glossy, fields and shexp",
            ),
            (self.bake_samples.is_some() && !bakes, "--bake-samples: only of modes with transfer"),
            (
                self.budget.asked().is_some() && (!bakes || self.transfer.is_some()),
                "--max-vertices and --no-split: only of modes that bake a scene",
            ),
            (
                self.transfer.is_some() && (!bakes || method.is_some()),
                "--transfer: only of modes with transfer that do not move",
            ),
            (self.lobe.is_some() && self.mode != Mode::Glossy, "--lobe: only of --mode glossy"),
            (
                self.is_shared() && (!is_truth || self.pictures.count() > 1),
                "--shard and --merge: only of a single picture of --mode truth; several pictures are shared by --frames A..B",
            ),
            (
                self.fresh && !is_truth && method.is_none(),
                "--fresh: only --mode truth, fields and shexp keep a checkpoint",
            ),
        ];
        if let Some((_, message)) = ignored.into_iter().find(|(is_ignored, _)| *is_ignored) {
            bail!("{message}; leave the option out");
        }
        Ok(())
    }
}
