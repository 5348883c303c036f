//! The room: what it holds, and what is shown.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use eframe::egui::{CentralPanel, Color32, Context, Id, Key, Panel, Rect, ScrollArea, Sense, Ui, pos2};
use lobe::env::SunChoice;
use lobe::prt::{BakeMode, Transfer};
use lobe_gpu::SplitSum;

use crate::loading::backdrop::Behind;
use crate::loading::bake::{BOUNCES, GlossyBake, SceneData, SceneNews};
use crate::loading::cache::UserFolder;
use crate::loading::export::SceneExport;
use crate::loading::file_kind::FileKind;
use crate::loading::limits::ReadLimits;
use crate::loading::materials::Materials;
use crate::loading::mode::Mode;
use crate::loading::places::Places;
use crate::loading::sky_source::OpenedSky;
use crate::loading::suns::ShownSuns;
use crate::rooms::formulas::formulas;
use crate::rooms::room::Room;
use crate::rooms::scene::baked::{Baked, DirectPart};
use crate::rooms::scene::controls::{self, Asked, BakePlan, Known};
use crate::rooms::scene::edits::{Comparison, SceneEdits, paths};
use crate::rooms::scene::lamps::lamps;
use crate::rooms::scene::probe::Probe;
use crate::rooms::scene::scene_light::SceneLight;
use crate::rooms::scene::still::still;
use crate::rooms::scene::viewport::{Frame, REST, Viewport, Wanted};
use crate::rooms::scene::work::{News, Work};
use crate::rooms::steer;
use crate::rooms::truth::{Shows, Truth};
use crate::widgets::gpu::{Gpu, failure};
use crate::widgets::history::{Can, History, Step};
use crate::widgets::named::name_image;
use crate::widgets::orbit::Orbit;
use lobe::render::Surfaces;

/// Radians a second by which the sky keeps turning.
const SPEED: f64 = 0.5;

/// A baked scene under a turning sky.
pub struct SceneRoom {
    edits: SceneEdits,
    orbit: Orbit,
    history: History<SceneEdits>,
    work: Work,
    bakes: HashMap<BakeMode, Baked>,
    direct: DirectPart,
    glossy: Vec<GlossyBake>,
    /// What shiny surfaces reflect, while they are shown.
    reflections: Option<Arc<SplitSum>>,
    shown: Option<(Mode, Arc<Transfer>)>,
    truth: Truth,
    bake_order: usize,
    light: SceneLight,
    viewport: Viewport,
    probe: Probe,
    picture_id: Option<Id>,
    is_turning: bool,
    /// The scene that the camera was set for; none before one is to be framed.
    framed: Option<PathBuf>,
    wants_file: bool,
}

impl SceneRoom {
    /// The room as it was left, or as it is first. `folder` keeps the bakes of built-in scenes.
    #[must_use]
    pub fn new(edits: SceneEdits, orbit: Option<Orbit>, folder: UserFolder) -> Self {
        Self {
            bake_order: edits.order.clamp(1, Transfer::MAX_ORDER),
            framed: orbit.is_some().then(|| edits.scene.clone()),
            edits,
            orbit: orbit.unwrap_or_default(),
            history: History::default(),
            work: Work::new(folder),
            bakes: HashMap::new(),
            direct: DirectPart::default(),
            glossy: Vec::new(),
            reflections: None,
            shown: None,
            truth: Truth::default(),
            light: SceneLight::default(),
            viewport: Viewport::default(),
            probe: Probe::default(),
            picture_id: None,
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
        self.work.sky()
    }

    /// The transfer that lights the scene; none before it is there, and where none is needed.
    #[must_use]
    pub fn transfer(&self) -> Option<&Arc<Transfer>> {
        self.shown.as_ref().map(|(_, transfer)| transfer)
    }

    /// Whether nothing is being opened or baked.
    #[must_use]
    pub fn is_idle(&self) -> bool {
        self.work.is_idle()
    }

    /// What went wrong last, in one line.
    #[must_use]
    pub fn message(&self) -> Option<&str> {
        self.work.message.as_deref()
    }

    /// How far the picture is from the truth as far as that is traced: the root mean square of the difference over the mean.
    #[must_use]
    pub fn error(&self) -> Option<f64> {
        self.truth.error()
    }

    /// Opens a scene, an environment, or transfer for the scene that is open, as the file says; also one that is open, for what has
    /// changed in its file.
    pub fn open(&mut self, path: &Path) {
        match FileKind::of(path) {
            Ok(FileKind::Scene) => {
                self.edits.scene = path.into();
                self.framed = None;
                self.work.read_scene_anew();
            }
            Ok(FileKind::Sky) => {
                self.edits.sky = path.into();
                self.work.read_sky_anew();
            }
            Ok(FileKind::Transfer | FileKind::Matrices) => self.work.adopt(path.into()),
            Ok(_) => self.work.message = Some(format!("{}: of another room", path.display())),
            Err(message) => self.work.message = Some(message),
        }
    }

    /// Has skies that are opened from now on fit the device.
    pub(crate) fn fit_skies(&mut self, gpu: &Gpu) {
        self.work.most_side = gpu.context().max_texture_side() as usize;
    }

    /// Whether the user asked for the list of files, once.
    pub(crate) fn take_wish_for_file(&mut self) -> bool {
        std::mem::take(&mut self.wants_file)
    }

    /// Gives the picture back to the device, before the room is dropped.
    pub(crate) fn forget_picture(&mut self, gpu: &Gpu) {
        self.viewport.forget(gpu);
    }

    /// What the room shows, for a picture in a file; none before a scene is open.
    pub fn export(&mut self) -> Option<SceneExport> {
        let data = self.work.scene().cloned()?;
        self.choose_transfer();
        let (sky, suns) = (self.work.sky().cloned(), self.suns());
        Some(SceneExport {
            transfer: self.shown.as_ref().map(|(_, transfer)| transfer.clone()),
            places: self.places(),
            order: self.edits.order,
            glossy: self.shining().to_vec(),
            materials: self.materials(),
            strength: self.edits.sky_strength,
            light: self.light.turning(&self.edits, sky.as_ref(), suns.is_any()),
            behind: self.light.behind(&self.edits, sky.as_ref()),
            camera: self.orbit.on_device()?,
            tone: self.viewport.tone(self.edits.look()),
            suns,
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
        self.work.start(ctx, &self.edits, self.plan());
        for news in self.work.news(&mut self.edits) {
            match news {
                News::Scene(news) => self.take_scene_news(news),
                News::Sky => self.viewport.fit_exposure(),
            }
        }
        self.work.let_bake(ctx);
        self.reflections = match self.edits.has_materials() {
            true => self.work.reflections(ctx, self.count_suns() > 0),
            false => None,
        };
        if (self.count_suns() > 0 || self.edits.has_materials())
            && self.is_idle()
            && let Some(wish) = self.direct.wish(self.shown.as_ref(), &self.bakes)
        {
            self.work.bake_direct(ctx, wish);
        }
        if self.is_turning {
            let seconds = ctx.input(|input| f64::from(input.stable_dt.min(0.1)));
            self.edits.turn = (self.edits.turn + SPEED * seconds).rem_euclid(std::f64::consts::TAU);
            ctx.request_repaint();
        } else {
            // A sky that turns by itself is not a change to take back.
            self.history.watch(ctx, &self.edits);
        }
    }

    fn take_scene_news(&mut self, news: SceneNews) {
        match news {
            SceneNews::Opened(data) => {
                // Also one that was chosen in the list, or that stands in for a file which is gone.
                if self.framed.as_ref() != Some(&self.edits.scene) {
                    self.orbit = self.orbit.framing(data.scene.world_bounds());
                    self.framed = Some(self.edits.scene.clone());
                }
                self.bakes.clear();
                self.direct = DirectPart::default();
                self.glossy.clear();
                self.shown = None;
                self.probe.forget();
                self.viewport.fit_exposure();
            }
            SceneNews::Baked { mode, samples, bounces, places, transfer, recipe } => {
                self.bakes.insert(mode, Baked { transfer, samples, bounces, places, recipe });
                self.shown = None;
            }
            SceneNews::Direct(transfer) => self.direct.take(transfer),
            SceneNews::Glossy(glossy) => self.glossy = glossy,
            SceneNews::AskBeforeBake => {}
        }
    }

    /// Finds the transfer that the mode needs among what was baked.
    fn choose_transfer(&mut self) {
        let mode = self.edits.mode;
        if self.shown.as_ref().is_some_and(|(shown, _)| *shown == mode) {
            return;
        }
        let of = |wanted: BakeMode| self.bakes.get(&wanted).map(|baked| &*baked.transfer);
        let mut places = mode.bakes().iter().filter_map(|mode| self.bakes.get(mode)).map(|baked| &baked.places);
        if places.next().is_some_and(|first| places.any(|other| !other.is_alike(first))) {
            // A difference of unlike things.
            self.work.message = Some(
                "one of the two bakes leaves out the albedo (--albedo none) or is of texels; bake both alike".into(),
            );
            self.shown = None;
            return;
        }
        self.shown = match mode {
            Mode::Shadowed | Mode::Interreflected => {
                let baked = mode.bakes().first().and_then(|mode| self.bakes.get(mode));
                baked.map(|baked| (mode, baked.transfer.clone()))
            }
            _ => match mode.transfer(of) {
                Ok(made) => made.map(|made| (mode, Arc::new(made))),
                Err(error) => {
                    self.work.message = Some(error.to_string());
                    None
                }
            },
        };
    }

    /// The first bake of the mode.
    fn baked(&self) -> Option<&Baked> {
        self.edits.mode.bakes().first().and_then(|mode| self.bakes.get(mode))
    }

    /// The meshes that shine where interreflections are shown.
    #[must_use]
    pub fn glossy(&self) -> &[GlossyBake] {
        &self.glossy
    }

    /// What the transfer that is shown is of.
    #[must_use]
    pub fn places(&self) -> Places {
        self.baked().map_or(Places::Vertices, |baked| baked.places.clone())
    }

    /// The meshes that shine in what is shown: metals, by paths with interreflections, among vertices with their albedo.
    fn shining(&self) -> &[GlossyBake] {
        let is_shown = self.edits.has_gloss
            && !self.edits.has_materials()
            && self.edits.mode == Mode::Interreflected
            && self.shown.is_some();
        if is_shown && matches!(self.places(), Places::Vertices) { &self.glossy } else { &[] }
    }

    /// What surfaces need that shine by their materials; none where they are matte.
    fn materials(&self) -> Option<Materials> {
        let (mode, transfer) = self.shown.as_ref()?;
        let reflections = self.reflections.clone().filter(|_| !matches!(self.places(), Places::Texels(_)))?;
        let direct = match mode {
            Mode::Shadowed => Some(transfer),
            _ => self.direct.of(self.shown.as_ref(), &self.bakes),
        };
        Some(Materials { reflections, direct: direct.cloned() })
    }

    /// Suns of the sky that are to be apart.
    fn count_suns(&self) -> usize {
        let suns = |sky: &OpenedSky| sky.split.suns().len();
        self.work.sky().filter(|_| self.edits.has_suns).map_or(0, suns)
    }

    /// The suns of what is shown.
    fn suns(&self) -> ShownSuns {
        let direct = self.direct.of(self.shown.as_ref(), &self.bakes);
        ShownSuns::new(self.count_suns(), self.edits.mode, self.shown.is_some(), direct)
    }

    fn plan(&self) -> BakePlan {
        BakePlan { order: self.bake_order, samples: paths(self.edits.samples) }
    }

    fn known(&self) -> Known {
        let samples = self.baked().and_then(|baked| baked.samples);
        Known { order: self.transfer().map(|t| t.order()), samples, has_scene: self.work.scene().is_some() }
    }

    fn answer(&mut self, ctx: &Context, asked: Asked) {
        match asked {
            Asked::OpenFile => self.wants_file = true,
            Asked::Cancel => self.work.cancel(&mut self.edits),
            Asked::Frame => {
                if let Some(data) = self.work.scene() {
                    self.orbit = self.orbit.framing(data.scene.world_bounds());
                }
            }
            Asked::Bake => self.work.bake(ctx, self.plan()),
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
            if let Some(message) = &self.work.message {
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
        formulas(ui, self.edits.formulas());
        ui.separator();
        controls::sky_and_exposure(ui, &mut self.edits, &mut self.is_turning);
        ui.separator();
        ui.strong("Lamps");
        lamps(ui, &mut self.edits.lamps);
        ui.separator();
        ui.strong("Bake");
        let mut plan = self.plan();
        let bake = match (self.work.scene_task(), self.work.sky_task()) {
            (None, Some(task)) => controls::bake(ui, &mut plan, &known, Some(task)),
            (task, _) => controls::bake(ui, &mut plan, &known, task),
        };
        (self.bake_order, self.edits.samples) = (plan.order, plan.samples);
        asked = asked.or(bake);
        ui.separator();
        let transfer = match (&self.shown, self.places()) {
            (_, Places::Texels(_)) => Err("The transfer is of texels, not of vertices."),
            (Some((_, transfer)), _) => Ok(&**transfer),
            (None, _) => Err("This mode needs no transfer."),
        };
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
        let Some(data) = self.work.scene().cloned() else {
            ui.centered_and_justified(|ui| ui.label(if self.is_idle() { "No scene" } else { "Opening" }));
            return;
        };
        let Some(gpu) = gpu else {
            ui.centered_and_justified(|ui| ui.label("No graphics device: the picture is not drawn."));
            return;
        };
        let scale = ui.ctx().pixels_per_point();
        let size = [rect.width(), rect.height()].map(|points| (points.max(0.0) * scale).round() as u32);
        let suns = self.suns();
        let light = self.light.light(&self.edits, self.work.sky(), suns.is_any());
        let behind = self.light.behind(&self.edits, self.work.sky());
        let turn = self.edits.rotation();
        let frame =
            Frame { size, orbit: self.orbit, light, turn, look: self.edits.look(), strength: self.edits.sky_strength };
        let transfer = self.shown.as_ref().map(|(_, transfer)| transfer);
        let (glossy, places) = (self.shining().to_vec(), self.places());
        let materials = self.materials();
        let has_gloss = !glossy.is_empty() || materials.is_some();
        let wanted = Wanted {
            data: &data,
            transfer,
            places: &places,
            glossy: &glossy,
            materials: materials.as_ref(),
            suns: &suns,
            sky: self.work.sky(),
            behind: &behind,
            order: self.edits.order,
        };
        match self.viewport.draw(gpu, &wanted, &frame) {
            Ok(Some(texture)) => {
                let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
                ui.painter().image(texture, rect, whole, Color32::WHITE);
            }
            Ok(None) => {}
            Err(error) => {
                ui.centered_and_justified(|ui| ui.label(failure(&error)));
            }
        }
        if self.viewport.is_coarse() {
            ui.ctx().request_repaint_after(REST);
        }
        self.compare(ui, rect, (&data, behind), size, has_gloss);
        steer::hold_keys(ui, &response);
        self.probe.look(&ui.painter_at(rect), rect, response.hover_pos(), &data, &self.orbit);
    }

    /// Shows the truth over the picture, which is at rest, or the difference of both.
    fn compare(&mut self, ui: &Ui, rect: Rect, (data, behind): (&SceneData, Behind), size: [u32; 2], has_gloss: bool) {
        let (comparison, is_at_rest) = (self.edits.comparison, !self.viewport.is_coarse());
        if comparison == Comparison::Off || !is_at_rest || size.contains(&0) {
            self.truth.stop();
            return;
        }
        let sky = self.work.sky().map(|sky| &sky.map);
        // With as many reflections as what it is compared with.
        let bounces = self.edits.mode.bakes().last().and_then(|mode| self.bakes.get(mode));
        let bounces = bounces.map_or(BOUNCES, |baked| baked.bounces);
        let still = still(data, (sky, behind), &self.edits, (self.orbit, size), (has_gloss, bounces));
        self.truth.follow(ui.ctx(), &still);
        let viewport = &self.viewport;
        let found = || viewport.picture_at_rest();
        let shows = if comparison == Comparison::Truth { Shows::Truth } else { Shows::Difference };
        if let Some(texture) = self.truth.texture(ui.ctx(), shows, found, self.edits.look()) {
            let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
            ui.painter().image(texture, rect, whole, Color32::WHITE);
        }
    }
}

impl Room for SceneRoom {
    fn ui(&mut self, ui: &mut Ui, gpu: Option<&Gpu>, _: Option<&OpenedSky>) {
        self.ui(ui, gpu);
    }

    fn can(&self) -> Can {
        self.can()
    }

    fn step(&mut self, step: Step) {
        self.step(step);
    }

    fn shows(&self) -> &'static [FileKind] {
        &[FileKind::Scene, FileKind::Sky, FileKind::Transfer, FileKind::Matrices]
    }

    fn open(&mut self, path: &Path, _: FileKind) -> anyhow::Result<bool> {
        self.open(path);
        Ok(true)
    }

    fn take_wish_for_file(&mut self) -> bool {
        self.take_wish_for_file()
    }

    fn forget_pictures(&mut self, gpu: &Gpu) {
        self.forget_picture(gpu);
    }

    fn read_within(&mut self, limits: ReadLimits) {
        self.work.limits = limits;
    }

    fn look_for_suns(&mut self, suns: &SunChoice) {
        self.work.suns = suns.clone();
    }

    fn reflect_by(&mut self, surfaces: Surfaces) {
        self.edits.surfaces = surfaces;
    }
}
