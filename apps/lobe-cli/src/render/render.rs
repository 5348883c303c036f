//! `lobe render`: a scene under distant light, by transfer, by environment mapping or by path tracing.

use std::path::PathBuf;
use std::time::Instant;

use anyhow::bail;
use lobe::env::Sun;
use lobe::io::{Job, JobFiles, Progress, Shard, SharingOptions};
use lobe::motion::{MovingJob, MovingScene, MovingShading, OneBake, light_moving_surfaces};
use lobe::prt::{BakeMode, OpenScene};
use lobe::render::{
    Background, Camera, DistantLight, Emitter, EnvironmentMaps, MatteSurfaces, RenderError, SurfaceModel, Surfaces,
    TransferSource, TruthOptions, ViewOptions, light_baked_surfaces, light_by_environment_maps, light_by_irradiance,
    render_truth_shard,
};
use lobe::scene::{Bvh, Scene};
use lobe::sh::{Dir, Rotation};

use crate::args::memory::MemoryLimit;
use crate::args::output;
use crate::args::scene_input::SceneInput;
use crate::args::sharing;
use crate::render::environment::EnvironmentInput;
use crate::render::frames::{Frames, SECONDS_PER_FRAME};
use crate::render::light::{ExpansionInput, LightInput, ReadLight, Split, SunInput};
use crate::render::mode::Mode;
use crate::render::pictures::{Pictures, Rendered};
use crate::render::stage::{IRRADIANCE_ORDER, Lit, Stage, Work, moving_bounds};
use crate::render::surfaces::SurfaceInput;
use crate::render::time::TimeInput;
use crate::render::truth;
use crate::render::view::ViewInput;
use crate::run::bake_watch::{watched, watched_bake, watched_one};
use crate::run::job_watch::{Kept, heard, watched_job};
use crate::run::talk::Talk;

/// Rays of a pixel without --samples.
const RAYS: usize = 4;

/// So many times as many where surfaces end.
const EDGE_RAYS: usize = 4;

/// Bounces without --bounces, as in the bake.
const BOUNCES: usize = 3;

/// Why glossy transfer has no model of reflection.
const OF_GLOSSY: &str = "--surfaces: glossy transfer has the lobe of --lobe; leave the option out";

/// What all pictures are made of, and the files of the bakes that it took.
type Staged = (Stage, Camera, Option<Split>, Vec<JobFiles>);

/// A picture as it was asked for, by any method.
pub(crate) struct Render {
    pub(crate) scene: SceneInput,
    pub(crate) light: LightInput,
    pub(crate) expansion: ExpansionInput,
    pub(crate) suns: SunInput,
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
    pub(crate) transfer: TransferSource,
    pub(crate) time: TimeInput,
    pub(crate) moving: MovingJob,
    pub(crate) fresh: bool,
    pub(crate) sharing: SharingOptions,
}

impl Render {
    pub(crate) fn run(&self, talk: Talk) -> anyhow::Result<()> {
        self.check_options()?;
        self.check_memory()?;
        let inputs = [
            Some(self.scene.path()),
            Some(self.light.path()),
            self.transfer.transfer.as_deref(),
            self.moving.sphere_table.as_deref(),
            self.suns.path(),
        ];
        let inputs: Vec<_> =
            inputs.into_iter().flatten().chain(self.sharing.parts().iter().map(PathBuf::as_path)).collect();
        if self.sharing.shard.is_some() {
            output::check_safetensors(self.pictures.output())?;
            output::prepare_file(self.pictures.output(), &inputs)?;
        } else {
            self.pictures.check(&inputs)?;
        }
        // A file of suns that cannot be read is refused before anything takes time.
        self.suns.given()?;
        let light = self.light.read(&self.memory, talk)?;
        if let (None, Some(count @ 1..)) = (light.map(), self.suns.count()) {
            bail!("--suns {count}: an expansion holds no suns that can be taken out; give a map, or a file of suns");
        }
        let (stage, camera, split, kept) = self.stage(&light, talk)?;
        let maps = self.maps(&light, talk)?;
        let name = self.light.path().display().to_string();
        let reflect = |split: &Split| self.environment.reflections((split, &name), self.model(), &self.memory, talk);
        let reflections = split.as_ref().filter(|_| self.reflects_light()).map(reflect).transpose()?;
        let split = split.map(|split| split.light);
        // A map that is used as it was given has its own suns.
        let suns = match &split {
            Some(split) => split.suns().to_vec(),
            None => self.suns.given()?,
        };
        let mut work = Work { stage, camera, light: &light, split, suns, maps, reflections, tree: None };
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
        let files = self.sharing.files(Some(self.pictures.output()))?;
        let (parts, merges) = (self.sharing.parts(), self.sharing.merge.is_some());
        if merges {
            let merged = watched(talk, "merge", |job| files.merge(parts, job))?;
            merged
                .or_else(|at| bail!("stopped after {} of {} records, of which nothing is kept", at.done, at.total))?;
        }
        let rendered = frames.render(self.fresh && !merges, merges.then_some(&files), &mut |k, job| {
            let (turn, time) = (self.light.turn(k % count, count), self.time_of(k));
            self.render(&mut work, &turn, time, job)
        });
        files.outcome_of_merge(parts, rendered)?;
        kept.iter().for_each(JobFiles::finish);
        Ok(())
    }

    /// Traces a shard of the pixels of a picture, which is the file that they are kept in.
    fn trace_shard(&self, work: &Work<'_>, shard: Shard, talk: Talk) -> anyhow::Result<()> {
        let (lit, options, begin) = (self.lit(work, &self.light.turn(0, 1)), self.truth_options(), Instant::now());
        let files = self.sharing.files(Some(self.pictures.output()))?;
        if self.fresh {
            files.discard()?;
        }
        let trace = |(scene, bvh): (&Scene, &Bvh), lamps: Vec<Emitter>| {
            let emitters = &lit.emitters(lamps, scene)[..];
            let work = |job: Job<'_>| {
                render_truth_shard(scene, bvh, &work.camera, (&lit.shown, emitters), &options, shard, job)
            };
            watched_bake(&files, talk, work)
        };
        match &work.stage {
            Stage::Plain(scene, bvh) => trace((scene, bvh), Vec::new())?,
            Stage::Moving(moving, _) => {
                let moment = moving.at(self.scene.pose.seconds())?;
                trace((moment.scene(), moment.bvh()), moment.emitters())?;
            }
            Stage::Baked(_) => unreachable!("a picture of transfer is not shared"),
        }
        let (points_in_all, seconds) = (options.width * options.height, begin.elapsed().as_secs_f64());
        let points = shard.range(points_in_all).len();
        let done = sharing::Done { shard: shard.to_string(), points, points_in_all, seconds };
        done.tell(self.pictures.output(), false, talk)
    }

    /// The suns of the light and its expansion, of `order` bands unless others are asked for; none where the light is
    /// used as it was given.
    fn split(&self, light: &ReadLight, order: usize, suns: &SunInput, talk: Talk) -> anyhow::Result<Option<Split>> {
        let is_expansion = match self.mode {
            Mode::Trace => self.expansion.is_asked_of(light),
            Mode::Maps => false,
            _ => true,
        };
        if !is_expansion {
            if let Some(count) = self.suns.count() {
                bail!("--suns {count}: a map that paths look up keeps its suns; give --order, or leave the option out");
            }
            return Ok(None);
        }
        suns.check_memory(&self.light, light, &self.memory)?;
        let split = self.expansion.of(light, order, suns, self.reflects_light())?;
        suns.note(&split.light, light, &self.light.path().display().to_string(), talk);
        Ok(Some(split))
    }

    /// The scene as the mode needs it, the camera that sees it, the light, and the files of bakes.
    fn stage(&self, light: &ReadLight, talk: Talk) -> anyhow::Result<Staged> {
        let has_finish = self.model() != Surfaces::Matte;
        let open = OpenScene::new(self.scene.source()?.finish(has_finish), self.memory.bytes())?;
        if self.is_moving() || (self.mode == Mode::Trace && open.has_poses()) {
            return self.moving_stage(open, light, talk);
        }
        self.scene.expect_no_time_unless_gltf()?;
        if self.mode == Mode::Baked {
            let (order, memory) = (self.expansion.order, self.memory.limit());
            let mut found = watched_job(talk, Kept::Nowhere, |work| self.transfer.prepare(open, order, memory, work))?;
            found.baked = self.surfaces.applied_to_baked(found.baked)?;
            self.note_materials(found.baked.scene(), talk);
            if found.baked.is_glossy() && has_finish {
                bail!("{OF_GLOSSY}");
            }
            let (camera, view) = (self.view.camera(found.baked.scene())?, self.view_options());
            // Transfer matrices hold direct and reflected light as one.
            let none = SunInput::none();
            let suns = if found.baked.is_glossy() { &none } else { &self.suns };
            if found.baked.is_glossy() && !self.suns.are_none() && light.has_sun() {
                let text = "the sun stays in the expansion of glossy surfaces, whose matrices have no direct part";
                talk.note(&self.light.path().display().to_string(), text);
            }
            let split = self.split(light, found.baked.order(), suns, talk)?;
            let has_suns = split.as_ref().is_some_and(|split| !split.light.suns().is_empty());
            let completed = |work: Job<'_>| found.completed((&camera, &view), (has_suns, has_finish), work);
            let baked = watched_job(talk, Kept::Nowhere, completed)?;
            return Ok((Stage::Baked(Box::new(baked)), camera, split, Vec::new()));
        }
        let scene = self.surfaces.applied(heard(talk, |work| open.scene(work))?)?;
        self.note_materials(&scene, talk);
        let (bvh, camera) = (Bvh::new(&scene), self.view.camera(&scene)?);
        Ok((Stage::Plain(scene, bvh), camera, self.split(light, IRRADIANCE_ORDER, &self.suns, talk)?, Vec::new()))
    }

    /// Notes that materials shine or emit light where nobody said that surfaces are matte.
    fn note_materials(&self, scene: &Scene, talk: Talk) {
        let is_matte = self.model() == Surfaces::Matte && self.mode.surfaces().is_some();
        let is_lobe = self.transfer.lobe.is_some() || self.transfer.mode == Some(BakeMode::Glossy);
        if is_matte && self.surfaces.is_left_open() && !is_lobe && (scene.has_metals() || scene.is_emissive()) {
            let text = "has materials that shine or emit light, shown as matte by their base color, which may be \
                        black; --surfaces gltf shows them";
            talk.note(&self.scene.name(), text);
        }
    }

    fn moving_stage(&self, open: OpenScene, light: &ReadLight, talk: Talk) -> anyhow::Result<Staged> {
        self.surfaces.expect_own_finish(&self.scene.name())?;
        let (name, memory, is_shaded) = (self.scene.name(), self.memory.limit(), self.mode == Mode::Moving);
        let keeps = (self.expansion.order, is_shaded);
        let read = heard(talk, |work| self.moving.read(open, keeps, memory, work))?;
        let mut moving = read.moving.looped(self.time.is_looped);
        let has_some = |scene: &&Scene| scene.has_metals() || scene.is_emissive();
        if let Some(scene) = moving.parts().iter().map(|part| &part.scene).find(has_some) {
            self.note_materials(scene, talk);
        }
        let times: Vec<f64> = (0..self.pictures.count()).map(|k| self.time_of(k)).collect();
        if self.pictures.is_turn() && moving.span()[0] < moving.span()[1] {
            talk.note(&name, "stands still while the light turns; --frames A..B lets it move");
        } else if !read.is_endless {
            self.time.note_end(&moving, &times, &name, talk);
        }
        if self.pictures.is_range() && self.time.seconds_in_animation().is_none() {
            let text = "no animation of the pictures is written, which cannot show each for so short or so long";
            talk.note(&self.pictures.name(), text);
        }
        let camera = self.view.camera_around(moving_bounds(&moving, &times)?)?;
        if !is_shaded {
            let split = self.split(light, IRRADIANCE_ORDER, &self.suns, talk)?;
            return Ok((Stage::Moving(Box::new(moving), None), camera, split, Vec::new()));
        }
        let paths = self.moving.light(&moving, self.expansion.order);
        let split = self.split(light, paths.order, &self.suns, talk)?;
        watched_job(talk, Kept::Nowhere, |work| self.moving.split(&mut moving, &paths, &name, work))?;
        let files = JobFiles::beside(self.pictures.output().to_path_buf());
        let mut bake_one = |what: &str, own: Option<&JobFiles>, bake: &mut OneBake<'_>| {
            let Some(own) = own else { return Ok(()) };
            if self.fresh {
                own.discard()?;
            }
            watched_one(own, talk, what, bake)
        };
        let has_suns = split.as_ref().is_some_and(|split| !split.light.suns().is_empty());
        let (shading, kept) = self.moving.prepare::<anyhow::Error>(
            &mut moving,
            &paths,
            has_suns || self.reflects_light(),
            (memory, Some(&files)),
            &mut bake_one,
        )?;
        for name in moving.hides_nothing(self.moving.method) {
            talk.note(name, "encloses no volume and changes its shape: it hides no light from other parts");
        }
        Ok((Stage::Moving(Box::new(moving), Some(shading)), camera, split, kept))
    }

    fn render(&self, work: &mut Work<'_>, turn: &Rotation, time: f64, job: Job<'_>) -> Result<Rendered, RenderError> {
        let lit = self.lit(work, turn);
        let Work { stage, camera, tree, maps, reflections, .. } = work;
        let shiny = reflections.as_ref().map(|reflections| reflections.turned(turn));
        match stage {
            Stage::Plain(scene, bvh) if self.mode == Mode::Trace => {
                let suns = lit.emitters(Vec::new(), scene);
                truth::traced((scene, bvh), (&lit.shown, &suns), camera, &self.truth_options(), job)
            }
            Stage::Moving(moving, None) => {
                let moment = moving.at(time)?;
                let lights = (&lit.shown, &lit.emitters(moment.emitters(), moment.scene())[..]);
                truth::traced((moment.scene(), moment.bvh()), lights, camera, &self.truth_options(), job)
            }
            Stage::Moving(moving, Some(shading)) => {
                let model: &dyn SurfaceModel = shiny.as_ref().map_or(&MatteSurfaces, |shiny| shiny);
                self.shaded((moving, tree), (shading, model), time, camera, &lit, job)
            }
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
                let (background, view) = (|s: Dir| lit.shown.seen(s), self.view_options());
                let model: &dyn SurfaceModel = shiny.as_ref().map_or(&MatteSurfaces, |shiny| shiny);
                let picture = light_baked_surfaces(baked, (lit.light(), model), camera, &view, background, job)?;
                Ok(Rendered::Shaded(lit.finished(picture)))
            }
        }
    }

    /// The light of a picture, turned.
    fn lit(&self, work: &Work<'_>, turn: &Rotation) -> Lit {
        let shown = match &work.split {
            Some(split) => DistantLight::from_expansion(split.rest().clone()).showing(split.suns()),
            None => work.light.as_it_is(),
        };
        let shown = shown.before(work.light.backdrop(self.background)).turned(turn);
        let turned = |sun: &Sun| Sun { direction: turn.rotate_dir(sun.direction), ..*sun };
        let suns = work.suns.iter().map(turned).collect();
        Lit { shown, split: work.split.as_ref().map(|split| split.rotated(turn)), suns }
    }

    /// A moment of a scene that moves, the backs that it shows baked before; its tree is that of the moment before, refit.
    fn shaded(
        &self,
        (moving, tree): (&mut MovingScene, &mut Option<Bvh>),
        (shading, model): (&MovingShading, &dyn SurfaceModel),
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
            let bake = self.moving.light(moving, Some(shading.order()));
            moving.bake_backs(&seen, &bake, Job::default().watched_by(&mut quiet))?;
            moment = moving.at_with(time, Some(bvh))?;
        }
        let background = |s: Dir| lit.shown.seen(s);
        let shaded = light_moving_surfaces(&moment, shading, (lit.light(), model), camera, &view, background, job)?;
        *tree = Some(moment.into_bvh());
        Ok(Rendered::Shaded(lit.finished(shaded)))
    }

    /// The model of reflection.
    fn model(&self) -> Surfaces {
        self.surfaces.model(self.mode.surfaces().unwrap_or(Surfaces::Matte))
    }

    /// Whether surfaces whose light is known by transfer reflect a map of it, too.
    fn reflects_light(&self) -> bool {
        matches!(self.mode, Mode::Baked | Mode::Moving) && self.model() != Surfaces::Matte
    }

    fn truth_options(&self) -> TruthOptions {
        let surfaces = self.model();
        truth::options(self.view.size(), self.samples, (self.bounces.unwrap_or(BOUNCES), self.seed), surfaces)
    }

    /// The maps of environment mapping; none of other methods.
    fn maps(&self, light: &ReadLight, talk: Talk) -> anyhow::Result<Option<EnvironmentMaps>> {
        let (Mode::Maps, Some(map)) = (self.mode, light.map()) else { return Ok(None) };
        let name = self.light.path().display().to_string();
        self.environment.maps((map, &name), self.model(), &self.memory, talk).map(Some)
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
        self.mode == Mode::Moving
            || (self.mode == Mode::Trace && self.scene.pose.asked().is_some())
            || self.time.asked().is_some()
            || self.pictures.is_range()
            || self.scene.has_extension(&["json"])
            || self.scene.is_built_in_motion()
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
        let shows_motion = matches!(self.mode, Mode::Trace | Mode::Moving);
        if self.pictures.is_range() && !shows_motion {
            bail!("--frames A..B: of lobe render moving and lobe render trace; --frames N turns the light");
        }
        if !shows_motion && self.is_moving() {
            let name = self.scene.name();
            if name.ends_with(".sh.json") {
                bail!("{name}: an expansion is light and no scene; give it to --env");
            }
            bail!("{name}: moves; show it by lobe render moving or lobe render trace");
        }
        if self.mode == Mode::Moving {
            MovingJob::check_order(self.expansion.order)?;
        }
        if let Some(default) = self.mode.surfaces() {
            self.surfaces.check(default)?;
        }
        if self.reflects_light() && (self.transfer.lobe.is_some() || self.transfer.mode == Some(BakeMode::Glossy)) {
            bail!("{OF_GLOSSY}");
        }
        if self.mode == Mode::Maps {
            self.light.expect_map()?;
            self.environment.check(self.model())?;
        }
        if self.sharing.asked().is_some() && self.pictures.count() > 1 {
            bail!("--shard and --merge: only of a single picture; several pictures are shared by --frames A..B");
        }
        Ok(())
    }
}
