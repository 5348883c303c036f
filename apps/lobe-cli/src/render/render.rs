//! `lobe render`: a scene under distant light, by transfer, by environment mapping or by path tracing.

use std::path::PathBuf;
use std::time::Instant;

use anyhow::bail;
use lobe::io::{Job, Progress, Shard};
use lobe::prt::{BakeMode, BakeOptions, GlossyLobe, Recipe, Transfer};
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
use crate::args::vertex_budget::VertexBudget;
use crate::render::environment::EnvironmentInput;
use crate::render::frames::{Frames, SECONDS_PER_FRAME};
use crate::render::light::{ExpansionInput, LightInput, ReadLight};
use crate::render::mode::Mode;
use crate::render::moving::{AskedBake, Keep, MovingInput, Prepared};
use crate::render::pictures::{Pictures, Rendered};
use crate::render::stage::{Lit, Stage, Work, moving_bounds};
use crate::render::surfaces::SurfaceInput;
use crate::render::time::TimeInput;
use crate::render::transfer::Asked;
use crate::render::truth;
use crate::render::view::ViewInput;
use crate::run::bake_watch::Checkpoint;
use crate::run::talk::Talk;

/// Rays of a pixel without --samples.
const RAYS: usize = 4;

/// So many times as many where surfaces end.
const EDGE_RAYS: usize = 4;

/// Bounces without --bounces, as in the bake.
const BOUNCES: usize = 3;

/// The lobe without --lobe: about the sharpest that order 4 can show.
const LOBE: GlossyLobe = GlossyLobe::Ggx(0.3);

/// A picture as it was asked for, by any method.
pub(crate) struct Render {
    pub(crate) scene: SceneInput,
    pub(crate) light: LightInput,
    pub(crate) expansion: ExpansionInput,
    pub(crate) mode: Mode,
    pub(crate) pictures: Pictures,
    pub(crate) view: ViewInput,
    pub(crate) background: Background,
    pub(crate) memory: MemoryLimit,
    pub(crate) samples: Option<usize>,
    pub(crate) bounces: Option<usize>,
    pub(crate) surfaces: SurfaceInput,
    pub(crate) seed: u64,
    pub(crate) environment: EnvironmentInput,
    pub(crate) bake_samples: Option<usize>,
    pub(crate) budget: VertexBudget,
    pub(crate) transfer: Option<PathBuf>,
    pub(crate) time: TimeInput,
    pub(crate) moving: MovingInput,
    pub(crate) lobe: Option<GlossyLobe>,
    pub(crate) fresh: bool,
    pub(crate) sharing: Sharing,
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
            Mode::Trace => self.expansion.is_asked_of(&light),
            Mode::Maps => false,
            _ => true,
        };
        let expansion = is_expansion.then(|| self.expansion.of(&light, order));
        let maps = self.maps(&light, talk)?;
        let mut work = Work { stage, camera, light: &light, expansion, maps, tree: None };
        if let Some(shard) = self.sharing.shard {
            return self.trace_shard(&work, shard, talk);
        }
        let is_range = self.pictures.is_range();
        let frames = Frames {
            pictures: &self.pictures,
            size: self.view.size(),
            is_kept: self.mode == Mode::Trace,
            keeps_bakes: !kept.is_empty(),
            seconds_per_frame: if is_range { self.time.seconds_in_animation() } else { Some(SECONDS_PER_FRAME) },
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
        if self.is_moving() || (self.mode == Mode::Trace && open.has_poses()) {
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
        let asked = AskedBake { order: self.expansion.order, bounces: self.bounces };
        let asked = self.moving_method().map(|_| asked);
        let talk = open.talk;
        let (mut moving, is_endless) = self.moving.read(open, self.time.is_looped, asked.as_ref())?;
        let name = self.scene.name();
        let times: Vec<f64> = (0..self.pictures.count()).map(|k| self.time_of(k)).collect();
        if self.pictures.is_turn() && moving.span()[0] < moving.span()[1] {
            talk.note(&name, "stands still while the light turns; --frames A..B lets it move");
        } else if !is_endless {
            self.time.note_end(&moving, &times, &name, talk);
        }
        if self.pictures.is_range() && self.time.seconds_in_animation().is_none() {
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
            Stage::Plain(scene, bvh) if self.mode == Mode::Trace => {
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
        Lit { shown, expansion: work.expansion.as_ref().map(|f| f.rotated(turn)) }
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
        truth::options(self.view.size(), self.samples, (self.bounces.unwrap_or(BOUNCES), self.seed), surfaces)
    }

    /// The maps of environment mapping; none of other methods.
    fn maps(&self, light: &ReadLight, talk: Talk) -> anyhow::Result<Option<EnvironmentMaps>> {
        let (Mode::Maps, Some(map)) = (self.mode, light.map()) else { return Ok(None) };
        let surfaces = self.surfaces.model(Surfaces::MetallicRoughness);
        let name = self.light.path().display().to_string();
        self.environment.maps((map, &name), surfaces, &self.memory, talk).map(Some)
    }

    /// The options of the view of all methods that shade what they hit.
    fn view_options(&self) -> ViewOptions {
        let (width, height) = self.view.size();
        let rays = (self.samples.unwrap_or(RAYS) as f64).sqrt().ceil() as usize;
        ViewOptions::default().width(width).height(height).rays(rays).edge_rays(EDGE_RAYS * rays * rays)
    }

    /// The time of a picture, in seconds.
    fn time_of(&self, picture: usize) -> f64 {
        self.time.time_of(&self.scene.pose, self.pictures.frame(picture))
    }

    /// Whether the scene is asked for at times.
    fn is_moving(&self) -> bool {
        self.moving_method().is_some()
            || (self.mode == Mode::Trace && self.scene.pose.asked().is_some())
            || self.time.asked().is_some()
            || self.pictures.is_range()
            || self.scene.has_extension(&["json"])
            || self.scene.is_built_in_motion()
    }

    /// Whether machines share the work.
    fn is_shared(&self) -> bool {
        self.sharing.shard.is_some() || !self.sharing.merge.is_empty()
    }

    /// How parts that move hide the sky from others; `None` of other methods.
    fn moving_method(&self) -> Option<MovingMethod> {
        match self.mode {
            Mode::Moving(method) => Some(method),
            _ => None,
        }
    }

    /// The bake of parts that move, of as many bands as those have that are baked.
    fn bake_options(&self, moving: &MovingScene) -> BakeOptions {
        let defaults = BakeOptions::default();
        let order = self.expansion.order.or_else(|| moving.order()).unwrap_or(defaults.order);
        let mut options = defaults.clone().order(order).bounces(self.bounces.unwrap_or(defaults.bounces));
        options.samples = self.bake_samples.map(|n| n as u32);
        options
    }

    /// The transfer that the method needs.
    fn asked(&self) -> Option<Asked> {
        let Mode::Baked(asked) = self.mode else { return None };
        let of_lobe = self.lobe.map(|_| BakeMode::Glossy);
        let mode = asked.or(of_lobe).or_else(|| self.mode_of_file()).unwrap_or(BakeOptions::default().mode);
        let lobe = (mode == BakeMode::Glossy).then(|| self.lobe.unwrap_or(LOBE));
        let (order, samples, file) = (self.expansion.order, self.bake_samples, self.transfer.clone());
        Some(Asked { mode, order, samples, bounces: self.bounces, lobe, budget: self.budget, file })
    }

    /// The light paths that a baked file says, if it can be read within the limits.
    fn mode_of_file(&self) -> Option<BakeMode> {
        let file = self.transfer.as_deref().or(self.scene.is_gltf().then(|| self.scene.path()))?;
        let may_be_read = file.is_file() && self.memory.check_file(file, "").is_ok();
        may_be_read.then(|| Recipe::of_file(file).ok())??.mode
    }

    /// Refuses a picture that takes too much memory.
    fn check_memory(&self) -> anyhow::Result<()> {
        let (width, height) = self.view.size();
        let is_truth = self.mode == Mode::Trace;
        let bytes = if is_truth { self.truth_options().bytes() } else { self.view_options().bytes() };
        self.memory.check(&format!("--size {width}x{height}"), bytes, "a smaller picture")
    }

    /// Refuses options that would be ignored.
    fn check_options(&self) -> anyhow::Result<()> {
        self.view.check()?;
        self.time.check(&self.scene.pose, &self.pictures)?;
        let method = self.moving_method();
        self.moving.check(method)?;
        if self.pictures.is_range() && self.mode != Mode::Trace && method.is_none() {
            bail!("--frames A..B: of lobe render moving and lobe render trace; --frames N turns the light");
        }
        if self.mode != Mode::Trace && method.is_none() && self.is_moving() {
            let name = self.scene.name();
            bail!("{name}: moves; show it by lobe render moving or lobe render trace");
        }
        if method.is_some() && self.expansion.order.is_some_and(|order| order > Transfer::MAX_ORDER) {
            bail!("--order: shadows of what moves have an order of 1 to {}", Transfer::MAX_ORDER);
        }
        if let Some(default) = self.mode.surfaces() {
            self.surfaces.check(default)?;
        }
        if self.mode == Mode::Maps {
            self.light.expect_map()?;
            self.environment.check(self.surfaces.model(Surfaces::MetallicRoughness))?;
        }
        let ignored = [
            (
                self.budget.asked().is_some() && self.transfer.is_some(),
                "--max-vertices and --no-split: not with --transfer, whose vertices are there",
            ),
            (
                self.bounces.is_some() && matches!(self.mode, Mode::Baked(Some(mode)) if !mode.reflects()),
                "--bounces: only of --mode interreflected and glossy",
            ),
            (
                self.lobe.is_some() && matches!(self.mode, Mode::Baked(Some(mode)) if mode != BakeMode::Glossy),
                "--lobe: only of --mode glossy",
            ),
            (
                self.is_shared() && self.pictures.count() > 1,
                "--shard and --merge: only of a single picture; several pictures are shared by --frames A..B",
            ),
        ];
        if let Some((_, message)) = ignored.into_iter().find(|(is_ignored, _)| *is_ignored) {
            bail!("{message}; leave the option out");
        }
        Ok(())
    }
}
