//! The room: what it holds, what comes from tasks, and what is shown.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use eframe::egui::{CentralPanel, Color32, Context, Id, Key, Panel, Rect, ScrollArea, Sense, Ui, pos2};
use lobe::env::MappedMap;
use lobe::prt::{BakeMode, Transfer};
use lobe::render::Surfaces;

use crate::loading::bake::{self, BOUNCES, GlossyBake, KEPT_SAMPLES, SceneData, SceneNews};
use crate::loading::cache::UserFolder;
use crate::loading::export::SceneExport;
use crate::loading::file_kind::FileKind;
use crate::loading::limits::ReadLimits;
use crate::loading::mode::Mode;
use crate::loading::place::IN_PAGE;
use crate::loading::scene_source;
use crate::loading::sky_source::{self, OpenedSky};
use crate::loading::task::{Task, TaskEvent};
use crate::rooms::scene::controls::{self, Asked, BakePlan, Known};
use crate::rooms::scene::edits::{Comparison, SceneEdits, SceneLamp};
use crate::rooms::scene::lamps::lamps;
use crate::rooms::scene::opened::{Opened, failure, take_back};
use crate::rooms::scene::probe::Probe;
use crate::rooms::scene::scene_light::SceneLight;
use crate::rooms::scene::viewport::{Frame, REST, Viewport, Wanted};
use crate::rooms::steer;
use crate::rooms::truth::{Shows, Still, Truth};
use crate::widgets::gpu::Gpu;
use crate::widgets::history::{Can, History, Step};
use crate::widgets::named::name_image;
use crate::widgets::orbit::Orbit;

/// Radians a second by which the sky keeps turning.
const SPEED: f64 = 0.5;

/// What a page says in place of a bake.
const NO_BAKES: &str = "A page with one thread does not bake: drop a .glb that lobe bake wrote, for its shadows.";

/// What is known of the light of a scene.
struct Baked {
    transfer: Arc<Transfer>,
    samples: Option<u32>,
    is_demodulated: bool,
}

/// A baked scene under a turning sky.
pub struct SceneRoom {
    edits: SceneEdits,
    orbit: Orbit,
    history: History<SceneEdits>,
    folder: UserFolder,
    scene: Opened<SceneData>,
    sky: Opened<OpenedSky>,
    scene_task: Option<Task<SceneNews>>,
    sky_task: Option<Task<OpenedSky>>,
    limits: ReadLimits,
    /// A file of transfer, for the scene when that is open.
    adopting: Option<PathBuf>,
    bakes: HashMap<BakeMode, Baked>,
    glossy: Vec<GlossyBake>,
    shown: Option<(Mode, Arc<Transfer>)>,
    truth: Truth,
    plan: BakePlan,
    light: SceneLight,
    viewport: Viewport,
    probe: Probe,
    picture_id: Option<Id>,
    message: Option<String>,
    is_fallback: bool,
    is_turning: bool,
    wants_frame: bool,
    wants_file: bool,
}

impl SceneRoom {
    /// The room as it was left, or as it is first. `folder` keeps the bakes of built-in scenes.
    #[must_use]
    pub fn new(edits: SceneEdits, orbit: Option<Orbit>, folder: UserFolder) -> Self {
        Self {
            plan: BakePlan { order: edits.order.clamp(1, Transfer::MAX_ORDER), samples: KEPT_SAMPLES },
            edits,
            wants_frame: orbit.is_none(),
            orbit: orbit.unwrap_or_default(),
            history: History::default(),
            folder,
            scene: Opened::default(),
            sky: Opened::default(),
            scene_task: None,
            sky_task: None,
            limits: ReadLimits::default(),
            adopting: None,
            bakes: HashMap::new(),
            glossy: Vec::new(),
            shown: None,
            truth: Truth::default(),
            light: SceneLight::default(),
            viewport: Viewport::default(),
            probe: Probe::default(),
            picture_id: None,
            message: None,
            is_fallback: false,
            is_turning: false,
            wants_file: false,
        }
    }

    /// What a user changed.
    #[must_use]
    pub fn edits(&self) -> &SceneEdits {
        &self.edits
    }

    /// The same, to change it from a program.
    pub fn edits_mut(&mut self) -> &mut SceneEdits {
        &mut self.edits
    }

    /// The camera.
    #[must_use]
    pub fn orbit(&self) -> &Orbit {
        &self.orbit
    }

    /// The environment that is open.
    #[must_use]
    pub fn sky(&self) -> Option<&OpenedSky> {
        self.sky.found.as_ref()
    }

    /// The transfer that lights the scene; none before it is there, and where none is needed.
    #[must_use]
    pub fn transfer(&self) -> Option<&Arc<Transfer>> {
        self.shown.as_ref().map(|(_, transfer)| transfer)
    }

    /// Whether nothing is being opened or baked.
    #[must_use]
    pub fn is_idle(&self) -> bool {
        self.scene_task.is_none() && self.sky_task.is_none() && self.adopting.is_none()
    }

    /// What went wrong last, in one line.
    #[must_use]
    pub fn message(&self) -> Option<&str> {
        self.message.as_deref()
    }

    /// Opens a scene, an environment, or transfer for the scene that is open, as the file says.
    pub fn open(&mut self, path: &Path) {
        match FileKind::of(path) {
            Ok(FileKind::Scene) => {
                self.edits.scene = path.into();
                self.wants_frame = true;
            }
            Ok(FileKind::Sky) => self.edits.sky = path.into(),
            Ok(FileKind::Transfer) => self.adopting = Some(path.into()),
            Ok(_) => self.message = Some(format!("{}: of another room", path.display())),
            Err(message) => self.message = Some(message),
        }
    }

    /// The same room with other limits of reading.
    #[must_use]
    pub fn reading_within(self, limits: ReadLimits) -> Self {
        Self { limits, ..self }
    }

    /// Whether the user asked for the list of files, once.
    pub fn take_wish_for_file(&mut self) -> bool {
        std::mem::take(&mut self.wants_file)
    }

    /// What the room shows, for a picture in a file; none before a scene is open.
    pub fn export(&mut self) -> Option<SceneExport> {
        let data = self.scene.found.clone()?;
        self.choose_transfer();
        let sky = self.sky.found.clone();
        Some(SceneExport {
            transfer: self.shown.as_ref().map(|(_, transfer)| transfer.clone()),
            is_demodulated: self.is_demodulated(),
            order: self.edits.order,
            glossy: shining(&self.edits, self.shown.is_some(), &self.glossy).to_vec(),
            light: self.light.turning(&self.edits, sky.as_ref()),
            camera: self.orbit.on_device()?,
            tone: self.viewport.tone(self.edits.exposure),
            sky,
            data,
        })
    }

    /// Takes the last change back, or makes it again.
    pub fn step(&mut self, step: Step) {
        self.history.step(step, &mut self.edits);
    }

    /// Whether there is a change to take back.
    #[must_use]
    pub fn has_undo(&self) -> bool {
        self.can().undo
    }

    pub(crate) fn can(&self) -> Can {
        self.history.can(&self.edits)
    }

    /// Starts what the edits ask for, and takes what has come. Called for each frame.
    pub fn advance(&mut self, ctx: &Context) {
        self.start_tasks(ctx);
        self.take_news();
        if self.is_turning {
            let seconds = ctx.input(|input| f64::from(input.stable_dt.min(0.1)));
            self.edits.turn = (self.edits.turn + SPEED * seconds).rem_euclid(std::f64::consts::TAU);
            ctx.request_repaint();
        } else {
            // A sky that turns by itself is not a change to take back.
            self.history.watch(ctx, &self.edits);
        }
    }

    fn start_tasks(&mut self, ctx: &Context) {
        let wake = |ctx: &Context| {
            let ctx = ctx.clone();
            move || ctx.request_repaint()
        };
        if self.scene.source != self.edits.scene {
            self.scene.source.clone_from(&self.edits.scene);
            let (source, order) = (self.edits.scene.clone(), self.plan.order);
            let (folder, limits) = (self.folder.clone(), self.limits);
            let work = move |control: &_| bake::open(control, &source, order, (&folder, &limits));
            self.scene_task = Some(Task::start("Scene", wake(ctx), work));
            self.forget_message();
        }
        if self.sky.source != self.edits.sky {
            self.sky.source.clone_from(&self.edits.sky);
            let (source, limits) = (self.edits.sky.clone(), self.limits);
            let work = move |control: &_| sky_source::open(control, &source, &limits);
            self.sky_task = Some(Task::start("Sky", wake(ctx), work));
            self.forget_message();
        }
        if self.scene_task.is_none()
            && let (Some(path), Some(data)) = (&self.adopting, &self.scene.found)
        {
            let (path, data) = (path.clone(), data.clone());
            let work = move |control: &_| bake::adopt(control, &data, &path);
            self.scene_task = Some(Task::start("Transfer", wake(ctx), work));
            self.adopting = None;
            self.forget_message();
        }
    }

    /// Forgets what went wrong, unless what is opened now stands in for it.
    fn forget_message(&mut self) {
        if !std::mem::take(&mut self.is_fallback) {
            self.message = None;
        }
    }

    fn take_news(&mut self) {
        let events = self.scene_task.as_ref().map(Task::events).unwrap_or_default();
        for event in events {
            match event {
                TaskEvent::Result(news) => self.take_scene_news(news),
                ended => {
                    self.scene_task = None;
                    self.is_fallback |= take_back(&ended, &mut self.edits.scene, &mut self.scene, scene_source::FIRST);
                    self.message = self.message.take().or(failure(ended));
                }
            }
        }
        let events = self.sky_task.as_ref().map(Task::events).unwrap_or_default();
        for event in events {
            match event {
                TaskEvent::Result(sky) => {
                    self.sky.found = Some(sky);
                    self.sky.good.clone_from(&self.sky.source);
                    self.viewport.fit_exposure();
                }
                ended => {
                    self.sky_task = None;
                    self.is_fallback |= take_back(&ended, &mut self.edits.sky, &mut self.sky, sky_source::FIRST);
                    self.message = self.message.take().or(failure(ended));
                }
            }
        }
    }

    fn take_scene_news(&mut self, news: SceneNews) {
        match news {
            SceneNews::Opened(data) => {
                if self.wants_frame {
                    self.orbit = self.orbit.framing(data.scene.world_bounds());
                    self.wants_frame = false;
                }
                self.scene.found = Some(data);
                self.scene.good.clone_from(&self.scene.source);
                self.bakes.clear();
                self.glossy.clear();
                self.shown = None;
                self.probe.forget();
                self.viewport.fit_exposure();
            }
            SceneNews::Baked { mode, samples, is_demodulated, transfer } => {
                self.bakes.insert(mode, Baked { transfer, samples, is_demodulated });
                self.shown = None;
            }
            SceneNews::Glossy(glossy) => self.glossy = glossy,
            SceneNews::AskBeforeBake => {
                self.message =
                    Some(if IN_PAGE { NO_BAKES } else { "This scene is large: press Bake for its shadows." }.into());
            }
        }
    }

    /// Finds the transfer that the mode needs among what was baked.
    fn choose_transfer(&mut self) {
        let mode = self.edits.mode;
        if self.shown.as_ref().is_some_and(|(shown, _)| *shown == mode) {
            return;
        }
        let of = |wanted: BakeMode| self.bakes.get(&wanted).map(|baked| &*baked.transfer);
        self.shown = match mode {
            Mode::Shadowed | Mode::Interreflected => {
                let baked = mode.bakes().first().and_then(|mode| self.bakes.get(mode));
                baked.map(|baked| (mode, baked.transfer.clone()))
            }
            _ => match mode.transfer(of) {
                Ok(made) => made.map(|made| (mode, Arc::new(made))),
                Err(error) => {
                    self.message = Some(error.to_string());
                    None
                }
            },
        };
    }

    /// The first bake of the mode.
    fn baked(&self) -> Option<&Baked> {
        self.edits.mode.bakes().first().and_then(|mode| self.bakes.get(mode))
    }

    /// Whether the transfer that is shown leaves out the albedo.
    fn is_demodulated(&self) -> bool {
        self.baked().is_some_and(|baked| baked.is_demodulated)
    }

    fn known(&self) -> Known {
        let samples = self.baked().and_then(|baked| baked.samples);
        Known { order: self.transfer().map(|t| t.order()), samples, has_scene: self.scene.found.is_some() }
    }

    fn answer(&mut self, ctx: &Context, asked: Asked) {
        match asked {
            Asked::OpenFile => self.wants_file = true,
            Asked::Cancel => self.cancel(),
            Asked::Frame => {
                if let Some(data) = &self.scene.found {
                    self.orbit = self.orbit.framing(data.scene.world_bounds());
                }
            }
            Asked::Bake => {
                if IN_PAGE {
                    self.message = Some(NO_BAKES.into());
                    return;
                }
                let Some(data) = self.scene.found.clone() else { return };
                let (plan, ctx) = (self.plan, ctx.clone());
                let wake = move || ctx.request_repaint();
                self.scene_task = Some(Task::start("Bake", wake, move |control| {
                    bake::rounds(control, &data, plan.order, plan.samples, &UserFolder::none())
                }));
                self.message = None;
            }
        }
    }

    /// Stops what is under way. What cannot be interrupted goes on where nobody waits for it, and is forgotten: it is not shown.
    fn cancel(&mut self) {
        let was_at_work = self.scene_task.is_some() || self.sky_task.is_some();
        if self.scene_task.take().is_some() {
            let ended = TaskEvent::<SceneNews>::Cancelled;
            self.is_fallback |= take_back(&ended, &mut self.edits.scene, &mut self.scene, scene_source::FIRST);
        }
        if self.sky_task.take().is_some() {
            let ended = TaskEvent::<OpenedSky>::Cancelled;
            self.is_fallback |= take_back(&ended, &mut self.edits.sky, &mut self.sky, sky_source::FIRST);
        }
        if was_at_work {
            self.message = failure(TaskEvent::<()>::Cancelled);
        }
    }

    /// Keys of the room, where no control has the keyboard.
    fn keys(&mut self, ctx: &Context) {
        if !steer::has_keys(ctx, self.picture_id.as_slice()) {
            return;
        }
        let steered = steer::keys(ctx, &mut self.orbit, &mut self.edits.light());
        self.is_turning ^= steered.turning;
        if steered.frame {
            self.answer(ctx, Asked::Frame);
        }
        let pressed = |key: Key| ctx.input(|input| input.modifiers.is_none() && input.key_pressed(key));
        for (key, mode) in [Key::Num1, Key::Num2, Key::Num3, Key::Num4].into_iter().zip(Mode::ALL) {
            if pressed(key) {
                self.edits.mode = mode;
            }
        }
        if pressed(Key::R) {
            let number = Comparison::ALL.iter().position(|known| *known == self.edits.comparison).unwrap_or(0);
            self.edits.comparison = Comparison::ALL[(number + 1) % Comparison::ALL.len()];
        }
        if pressed(Key::P) {
            self.probe.is_on = !self.probe.is_on;
        }
        if pressed(Key::Escape) {
            self.answer(ctx, Asked::Cancel);
        }
    }

    /// Shows the room. Without a device there is no picture, and the room says so.
    pub fn ui(&mut self, ui: &mut Ui, gpu: Option<&Gpu>) {
        let ctx = ui.ctx().clone();
        self.keys(&ctx);
        self.choose_transfer();
        let mut asked = None;
        Panel::left("scene controls").default_size(300.0).size_range(220.0..=480.0).show(ui, |ui| {
            ScrollArea::vertical().auto_shrink(false).show(ui, |ui| asked = self.panel(ui));
        });
        if let Some(asked) = asked {
            self.answer(&ctx, asked);
        }
        Panel::bottom("scene status").resizable(false).show(ui, |ui| {
            if let Some(message) = &self.message {
                ui.colored_label(ui.visuals().error_fg_color, message);
            }
            self.viewport.status.show(ui);
        });
        CentralPanel::no_frame().show(ui, |ui| self.picture(ui, gpu));
    }

    fn panel(&mut self, ui: &mut Ui) -> Option<Asked> {
        ui.spacing_mut().slider_width = 120.0;
        let known = self.known();
        let mut asked = controls::scene_and_sky(ui, &mut self.edits);
        ui.separator();
        controls::modes(ui, &mut self.edits, &known);
        ui.separator();
        controls::comparison(ui, &mut self.edits, &self.truth.describe());
        ui.separator();
        controls::sky_and_exposure(ui, &mut self.edits, &mut self.is_turning);
        ui.separator();
        ui.strong("Lamps");
        lamps(ui, &mut self.edits.lamps);
        ui.separator();
        ui.strong("Bake");
        let bake = match &self.sky_task {
            Some(task) if self.scene_task.is_none() => controls::bake(ui, &mut self.plan, &known, Some(task)),
            _ => controls::bake(ui, &mut self.plan, &known, self.scene_task.as_ref()),
        };
        asked = asked.or(bake);
        ui.separator();
        let transfer = self.shown.as_ref().map(|(_, transfer)| &**transfer);
        self.probe.controls(ui, transfer, &mut self.orbit);
        asked
    }

    fn picture(&mut self, ui: &mut Ui, gpu: Option<&Gpu>) {
        let rect = ui.available_rect_before_wrap();
        let response = ui.interact(rect, ui.scope_id().with("picture"), Sense::click_and_drag());
        name_image(&response, "Picture of the scene");
        self.picture_id = Some(response.id);
        steer::pointer(ui, &response, &mut self.orbit, &mut self.edits.light());
        ui.painter().rect_filled(rect, 0.0, ui.visuals().panel_fill);
        let Some(data) = self.scene.found.clone() else {
            ui.centered_and_justified(|ui| ui.label(if self.is_idle() { "No scene" } else { "Opening" }));
            return;
        };
        let Some(gpu) = gpu else {
            ui.centered_and_justified(|ui| ui.label("No graphics device: the picture is not drawn."));
            return;
        };
        let scale = ui.ctx().pixels_per_point();
        let size = [rect.width(), rect.height()].map(|points| (points.max(0.0) * scale).round() as u32);
        let light = self.light.light(&self.edits, self.sky.found.as_ref());
        let turn = self.edits.rotation();
        let frame = Frame { size, orbit: self.orbit, light, turn, exposure: self.edits.exposure };
        let transfer = self.shown.as_ref().map(|(_, transfer)| transfer);
        let glossy = shining(&self.edits, transfer.is_some(), &self.glossy);
        let has_gloss = !glossy.is_empty();
        let is_demodulated = self.is_demodulated();
        let wanted = Wanted {
            data: &data,
            transfer,
            is_demodulated,
            glossy,
            sky: self.sky.found.as_ref(),
            order: self.edits.order,
        };
        match self.viewport.draw(gpu, &wanted, &frame) {
            Ok(Some(texture)) => {
                let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
                ui.painter().image(texture, rect, whole, Color32::WHITE);
            }
            Ok(None) => {}
            Err(error) => {
                let text =
                    format!("The graphics device failed: {error}. Restart the viewer; what you changed is kept.");
                ui.centered_and_justified(|ui| ui.label(text));
            }
        }
        if self.viewport.is_coarse() {
            ui.ctx().request_repaint_after(REST);
        }
        self.compare(ui, rect, &data, size, has_gloss);
        steer::hold_keys(ui, &response);
        self.probe.look(&ui.painter_at(rect), rect, response.hover_pos(), &data, &self.orbit);
    }

    /// Shows the truth over the picture, which is at rest, or the difference of both.
    fn compare(&mut self, ui: &Ui, rect: Rect, data: &SceneData, size: [u32; 2], has_gloss: bool) {
        let (comparison, is_at_rest) = (self.edits.comparison, !self.viewport.is_coarse());
        if comparison == Comparison::Off || !is_at_rest || size.contains(&0) {
            self.truth.stop();
            return;
        }
        let sky = self.sky.found.as_ref().map(|sky| &sky.map);
        let still = still(data, sky, &self.edits, (self.orbit, size), has_gloss);
        self.truth.follow(ui.ctx(), &still);
        let viewport = &self.viewport;
        let found = || viewport.picture_at_rest();
        let shows = if comparison == Comparison::Truth { Shows::Truth } else { Shows::Difference };
        if let Some(texture) = self.truth.texture(ui.ctx(), shows, found, self.edits.exposure) {
            let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
            ui.painter().image(texture, rect, whole, Color32::WHITE);
        }
    }
}

/// The meshes that shine in what is shown: metals, by paths with interreflections.
fn shining<'a>(edits: &SceneEdits, is_baked: bool, glossy: &'a [GlossyBake]) -> &'a [GlossyBake] {
    if edits.has_gloss && edits.mode == Mode::Interreflected && is_baked { glossy } else { &[] }
}

/// What the truth of a scene depends on. Metals shine where the picture has them shine; else all is matte, as transfer takes it.
fn still(
    data: &SceneData,
    sky: Option<&Arc<MappedMap>>,
    edits: &SceneEdits,
    (orbit, size): (Orbit, [u32; 2]),
    has_gloss: bool,
) -> Still {
    Still {
        data: data.clone(),
        emitters: Vec::new(),
        sky: sky.cloned(),
        orbit,
        size,
        turn: edits.rotation(),
        strength: edits.sky_strength,
        lamps: edits.lamps.iter().filter(|lamp| lamp.is_on).map(SceneLamp::disc).collect(),
        bounces: if edits.mode == Mode::Shadowed { 0 } else { BOUNCES },
        surfaces: if has_gloss { Surfaces::MetallicRoughness } else { Surfaces::Matte },
    }
}
