//! The room: what it knows of the scene, its keys, and its panel.

use std::path::Path;
use std::sync::Arc;

use eframe::egui::{CentralPanel, Context, Id, Key, Label, Panel, ScrollArea, Ui};
use lobe::env::SceneLight;
use lobe::motion::MovingMethod;
use lobe::sh::{Rgb, ShVec};
use lobe::shadow::WorldSphere;
use lobe_gpu::SunsApart;

use crate::loading::backdrop::Behind;
use crate::loading::file_kind::FileKind;
use crate::loading::limits::ReadLimits;
use crate::loading::place::IN_PAGE;
use crate::loading::sky_source::OpenedSky;
use crate::loading::task::TaskEvent;
use crate::rooms::formulas::formulas;
use crate::rooms::light::TamedSky;
use crate::rooms::motion::before::{Before, InHand};
use crate::rooms::motion::cast::Cast;
use crate::rooms::motion::clock::{Clock, passed};
use crate::rooms::motion::controls::{self, Wish};
use crate::rooms::motion::edits::{MotionEdits, MotionView};
use crate::rooms::motion::panes::Panes;
use crate::rooms::motion::player::{Asked, MOST_ORDER, News, Player, Shown, Source};
use crate::rooms::room::Room;
use crate::rooms::steer;
use crate::widgets::gpu::Gpu;
use crate::widgets::history::{Can, History, Step};
use crate::widgets::orbit::Orbit;

/// What a page shows in place of the room of motion.
const NO_MOTION: &str =
    "What moves needs compute shaders and threads, which a page with WebGL 2 has not: start the program lobe-viewer.";

/// Radians a second by which the sky keeps turning.
const SKY_SPEED: f64 = 0.5;

/// What moves.
pub struct MotionRoom {
    pub(super) edits: MotionEdits,
    history: History<MotionEdits>,
    pub(super) player: Option<(Source, Player)>,
    limits: ReadLimits,
    /// That of the window.
    pub(super) device: Option<lobe_gpu::Context>,
    /// The scene that is left, until a moment of this one is lit.
    pub(super) before: Option<Before>,
    /// Where the parts were in the last frame, for a scene that is left and comes back.
    pub(super) in_hand: InHand,
    /// Whether the scene is to be opened although it is open.
    pub(super) wants_start: bool,
    /// Whether changes of the scene that is left are no longer to be taken back when this one is there.
    pub(super) forgets_history: bool,
    pub(super) cast: Option<Cast>,
    pub(super) chosen: usize,
    pub(super) clock: Clock,
    pub(super) orbit: Orbit,
    /// Whether the scene is to be in the picture as soon as it is seen.
    pub(super) wants_frame: bool,
    pub(super) sky: Option<OpenedSky>,
    light: TamedSky,
    pub(super) is_sky_turning: bool,
    pub(super) asked: Option<Asked>,
    pub(super) lit: Option<Shown>,
    pub(super) is_waiting: bool,
    /// Whether the work on the scene has ended: it was cancelled, or went wrong.
    pub(super) is_stopped: bool,
    pub(super) panes: Panes,
    pub(super) picture_ids: Vec<Id>,
    pub(super) message: Option<String>,
    wants_file: bool,
}

impl MotionRoom {
    /// The room as it was left, or as it is first.
    #[must_use]
    pub fn new(edits: MotionEdits) -> Self {
        Self {
            edits,
            history: History::default(),
            player: None,
            limits: ReadLimits::default(),
            device: None,
            before: None,
            in_hand: InHand::default(),
            wants_start: false,
            forgets_history: false,
            cast: None,
            chosen: 0,
            clock: Clock::default(),
            orbit: Orbit::default(),
            wants_frame: true,
            sky: None,
            light: TamedSky::default(),
            is_sky_turning: false,
            asked: None,
            lit: None,
            is_waiting: false,
            is_stopped: false,
            panes: Panes::default(),
            picture_ids: Vec::new(),
            message: None,
            wants_file: false,
        }
    }

    /// The same with the camera that was left there, for the scene that it opens first.
    pub(crate) fn seen_from(self, orbit: Option<Orbit>) -> Self {
        Self { wants_frame: orbit.is_none(), orbit: orbit.unwrap_or(self.orbit), ..self }
    }

    /// What a user changed.
    #[must_use]
    pub fn edits(&self) -> &MotionEdits {
        &self.edits
    }

    /// The same, to change it from a program.
    pub fn edits_mut(&mut self) -> &mut MotionEdits {
        &mut self.edits
    }

    /// Whether a moment is lit and shown.
    #[must_use]
    pub fn is_ready(&self) -> bool {
        self.lit.is_some()
    }

    /// Whether the scene is being opened, baked or lit.
    #[must_use]
    pub fn is_at_work(&self) -> bool {
        self.player.as_ref().is_some_and(|(_, player)| player.task().is_at_work())
    }

    /// The scene.
    #[must_use]
    pub fn source(&self) -> &Path {
        &self.edits.source
    }

    /// The names of its parts; none before it is opened.
    #[must_use]
    pub fn parts(&self) -> &[String] {
        self.cast.as_ref().map_or(&[], |cast| &cast.names)
    }

    /// The number of spheres that hid the sky in the last moment.
    #[must_use]
    pub fn spheres(&self) -> usize {
        self.spheres_of_moment().len()
    }

    pub(super) fn spheres_of_moment(&self) -> &[WorldSphere] {
        let way = self.lit.as_ref().and_then(|lit| lit.way(MovingMethod::Exponentials));
        way.map_or(&[], |way| way.spheres.as_slice())
    }

    /// The exit radiance of all vertices in the last moment by a way; none before it is lit so.
    #[must_use]
    pub fn radiance(&self, method: MovingMethod) -> Option<&[Rgb<f32>]> {
        self.lit.as_ref()?.way(method).map(|way| way.radiance.as_slice())
    }

    /// The light of the last moment, turned and tamed.
    #[must_use]
    pub fn light(&self) -> Option<&ShVec<Rgb<f64>>> {
        self.lit.as_ref().map(|lit| &lit.asked.light)
    }

    /// How far the shadow fields, or the exponentials, are from the truth as far as it is traced: the root mean square of the
    /// difference over the mean.
    #[must_use]
    pub fn error(&self, view: MotionView) -> Option<f64> {
        self.panes.error(view)
    }

    /// Stops the animation at a time, in seconds.
    pub fn pause_at(&mut self, time: f64) {
        self.clock.pause_at(time);
    }

    /// The camera.
    #[must_use]
    pub fn orbit(&self) -> &Orbit {
        &self.orbit
    }

    /// The camera as it is kept for the scene; none before that was seen.
    pub(crate) fn orbit_of_scene(&self) -> Option<Orbit> {
        (!self.wants_frame).then_some(self.orbit)
    }

    /// What went wrong last, in one line.
    #[must_use]
    pub fn message(&self) -> Option<&str> {
        self.message.as_deref()
    }

    /// Opens a moving scene, as [`open_moving`](crate::open_moving), also one that is open, for what has changed in its file. One that
    /// cannot be opened leaves that which is there.
    pub fn open(&mut self, path: &Path) {
        let is_left = self.before.as_ref().is_some_and(|before| before.source.path == path);
        if path == self.edits.source || is_left {
            // Places of the parts that the file had are none of those that it has.
            (self.wants_start, self.forgets_history) = (true, true);
        }
        self.change_to(path);
    }

    pub(super) fn change_to(&mut self, path: &Path) {
        self.wants_frame |= path != self.edits.source;
        self.edits = self.edits.of_scene(path.into());
        self.message = None;
    }

    /// Opens a file of an occlusion field or of spheres, for the part of the scene that it was made of; also one that is open, for what
    /// has changed in it.
    pub fn open_part_file(&mut self, path: &Path) {
        let count = self.edits.files.len();
        self.edits.files.retain(|file| file != path);
        self.wants_start |= self.edits.files.len() < count;
        self.edits.files.push(path.into());
        self.message = None;
    }

    /// Whether the user asked for the list of files, once.
    pub(crate) fn take_wish_for_file(&mut self) -> bool {
        std::mem::take(&mut self.wants_file)
    }

    /// Gives the pictures back to the device, before the room is dropped.
    pub(crate) fn forget_pictures(&mut self, gpu: &Gpu) {
        self.panes.forget(gpu);
    }

    /// Takes the last change back, or makes it again.
    pub fn step(&mut self, step: Step) {
        self.history.step(step, &mut self.edits);
    }

    pub(crate) fn can(&self) -> Can {
        self.history.can(&self.edits)
    }

    /// Shows the room under a sky.
    pub fn ui(&mut self, ui: &mut Ui, gpu: Option<&Gpu>, sky: Option<&OpenedSky>) {
        let ctx = ui.ctx().clone();
        self.device = gpu.map(|gpu| gpu.context().clone());
        self.take_news();
        self.keys(&ctx);
        self.advance(&ctx, sky);
        Panel::left("motion controls").default_size(300.0).size_range(220.0..=480.0).show(ui, |ui| {
            ScrollArea::vertical().auto_shrink(false).show(ui, |ui| self.panel(ui));
        });
        Panel::bottom("motion status").resizable(false).show(ui, |ui| {
            if let Some(message) = &self.message {
                ui.colored_label(ui.visuals().error_fg_color, message);
            }
            let told = self.lit.as_ref().map_or_else(|| self.unlit().into(), |lit| lit.describe());
            ui.add(Label::new(told).wrap());
            self.panes.status.show(ui);
        });
        CentralPanel::no_frame().show(ui, |ui| self.picture(ui, gpu));
        self.remember_hands();
    }

    /// Remembers where the parts of the scene are, unless it is being left.
    fn remember_hands(&mut self) {
        let is_open = !self.wants_start && self.is_open(&self.edits.wanted(self.limits));
        if let Some(cast) = &self.cast
            && is_open
            && self.edits.hands.len() == cast.hands.len()
        {
            self.in_hand.hands.clone_from(&self.edits.hands);
            (self.in_hand.is_by_hand, self.in_hand.chosen) = (self.edits.is_by_hand, self.chosen);
        }
    }

    /// Whether this is the scene that is there, or on its way.
    fn is_open(&self, wanted: &Source) -> bool {
        self.player.as_ref().is_some_and(|(source, _)| source == wanted)
    }

    /// What is said before a moment is lit.
    pub(super) fn unlit(&self) -> &'static str {
        if self.is_stopped { "Nothing is baked" } else { "Preparing" }
    }

    /// Keys of the room, where no control has the keyboard.
    fn keys(&mut self, ctx: &Context) {
        if !steer::has_keys(ctx, &self.picture_ids) {
            return;
        }
        let most_order = self.most_order();
        let steered = steer::keys(ctx, &mut self.orbit, &mut self.edits.light(most_order));
        self.is_sky_turning ^= steered.turning;
        if steered.frame {
            self.frame();
        }
        let pressed = |key: Key| ctx.input(|input| input.modifiers.is_none() && input.key_pressed(key));
        for (key, view) in [Key::Num1, Key::Num2, Key::Num3, Key::Num4].into_iter().zip(MotionView::ALL) {
            if pressed(key) {
                self.edits.view = view;
            }
        }
        if pressed(Key::Escape) && self.is_at_work() {
            self.cancel();
        }
        if pressed(Key::Space) && !self.edits.is_by_hand {
            self.clock.toggle();
        }
    }

    /// Stops the bakes that are under way: the last moment that was lit remains. Before there was one, the scene is left unbaked.
    fn cancel(&mut self) {
        match (&self.lit, &self.player) {
            (Some(lit), _) => self.edits.return_to(&lit.asked_as_lit()),
            (None, Some((_, player))) => player.task().cancel(),
            (None, None) => {}
        }
    }

    /// Brings the whole scene into the picture.
    fn frame(&mut self) {
        if let Some(lit) = &self.lit {
            self.orbit = self.orbit.framing(lit.data.scene.world_bounds());
        }
    }

    /// The most bands that can be had of the scene.
    pub(super) fn most_order(&self) -> usize {
        self.cast.as_ref().map_or(MOST_ORDER, |cast| cast.most_order)
    }

    fn take_news(&mut self) {
        // Of a scene that is being left, nothing is told any more.
        let player = self.player.as_ref().filter(|(source, _)| *source == self.edits.wanted(self.limits));
        let player = player.filter(|_| !self.wants_start);
        let events = player.map(|(_, player)| player.events()).unwrap_or_default();
        for event in events {
            match event {
                TaskEvent::Result(News::Ready(cast)) => {
                    // Places that were taken back or made again belong to this scene already.
                    if self.edits.hands.len() != cast.hands.len() {
                        self.edits.hands.clone_from(&cast.hands);
                    }
                    self.edits.is_by_hand &= cast.is_rigid;
                    if std::mem::take(&mut self.forgets_history) {
                        self.history = History::default();
                    }
                    self.take_cast(cast);
                }
                TaskEvent::Result(News::Lit(lit)) => {
                    if std::mem::take(&mut self.wants_frame) {
                        self.orbit = self.orbit.framing(lit.data.scene.world_bounds());
                    }
                    self.lit = Some(Arc::from(lit));
                    self.before = None;
                    // Of several ways the one that was baked already comes first.
                    self.is_waiting = self.lit.as_ref().is_some_and(|lit| lit.ways.len() < lit.asked.methods.len());
                }
                TaskEvent::Failed(message) => self.fail(message),
                TaskEvent::Cancelled => self.stop(),
                TaskEvent::Done => {}
            }
        }
    }

    /// Starts the player, lets time pass, and asks for the moment that is to be seen.
    fn advance(&mut self, ctx: &Context, sky: Option<&OpenedSky>) {
        let wanted = self.edits.wanted(self.limits);
        if self.wants_start || !self.is_open(&wanted) {
            // A change of the scene that is taken back before the other one is there leaves it as it was.
            let is_kept = |before: &mut Before| before.player.is_some() && before.source == wanted;
            match self.before.take_if(|before| !self.wants_start && is_kept(before)) {
                Some(before) => self.put_back(before),
                None => self.start(ctx, wanted),
            }
        }
        // Hands that come with the scene are no change of a user, and those of a file as it was before do not fit it now.
        if let Some(cast) = &self.cast {
            if self.edits.hands.len() != cast.hands.len() {
                self.edits.hands.clone_from(&cast.hands);
            }
            self.history.watch(ctx, &self.edits);
        }
        if let Some(sky) = sky
            && self.sky.as_ref().is_none_or(|before| !Arc::ptr_eq(&before.map, &sky.map))
        {
            self.sky = Some(sky.clone());
            self.panes.fit_exposure();
        }
        if self.is_sky_turning {
            self.edits.turn = (self.edits.turn + SKY_SPEED * passed(ctx)).rem_euclid(std::f64::consts::TAU);
            ctx.request_repaint();
        }
        let (Some(cast), Some(sky)) = (&self.cast, &self.sky) else { return };
        if !self.edits.is_by_hand {
            self.clock.advance(ctx, cast.span);
        }
        let order = self.edits.order.min(cast.most_order);
        let has_suns = self.edits.has_suns && cast.parts_suns && !sky.split.suns().is_empty();
        let tamed = self.light.of(sky, (order, has_suns), self.edits.taming).clone();
        let suns = if has_suns { sky.split.suns().to_vec() } else { Vec::new() };
        let light = SceneLight::new(tamed, suns).rotated(&self.edits.rotation());
        let light = SunsApart::Shadowed(SunsApart::MOST).split(&light);
        let asked = self.edits.asks(self.clock.time, light.rest().clone(), light.suns().to_vec());
        // What needs other bakes need not wait for those that are under way.
        let is_free = !self.is_waiting || self.asked.as_ref().is_some_and(|before| before.needs_other_bakes(&asked));
        if is_free
            && self.asked.as_ref() != Some(&asked)
            && let Some((_, player)) = &self.player
        {
            player.ask(asked.clone());
            self.asked = Some(asked);
            self.is_waiting = true;
        }
    }

    /// What is behind the scene, before it is turned as the sky is.
    pub(super) fn behind(&mut self) -> Behind {
        let MotionEdits { background, order, taming, .. } = self.edits;
        let (light, most) = (&mut self.light, self.cast.as_ref().map_or(order, |cast| cast.most_order));
        Behind::new(background, || match &self.sky {
            Some(sky) => light.of(sky, (order.min(most), false), taming).clone(),
            None => ShVec::zero(order),
        })
    }

    fn panel(&mut self, ui: &mut Ui) {
        ui.spacing_mut().slider_width = 120.0;
        if let Some(source) = controls::scene(ui, &self.edits.source) {
            self.change_to(&source);
        }
        let hint = "A .glb that moves, or a description of a scene; or drop it on the window (Ctrl+O)";
        self.wants_file |= ui.button("Open a file").on_hover_text(hint).clicked();
        if ui.button("Frame").on_hover_text("The whole scene in the picture (F)").clicked() {
            self.frame();
        }
        ui.separator();
        controls::view(ui, &mut self.edits, &self.panes);
        formulas(ui, self.edits.formulas());
        ui.separator();
        let most_order = self.most_order();
        controls::light(ui, &mut self.edits, most_order, &mut self.is_sky_turning);
        ui.separator();
        let task = self.player.as_ref().map(|(_, player)| player.task());
        match task.and_then(|task| controls::progress(ui, task, self.is_stopped)) {
            Some(Wish::Cancel) => self.cancel(),
            Some(Wish::Bake) => (self.wants_start, self.message) = (true, None),
            None => {}
        }
        let Some(cast) = self.cast.clone() else { return };
        ui.add_enabled_ui(!self.edits.is_by_hand, |ui| {
            self.clock.controls(ui, cast.span);
        });
        controls::by_hand(ui, &mut self.edits, &mut self.chosen, &cast);
    }
}

impl Room for MotionRoom {
    fn ui(&mut self, ui: &mut Ui, gpu: Option<&Gpu>, sky: Option<&OpenedSky>) {
        if IN_PAGE {
            drop(CentralPanel::default().show(ui, |ui| ui.centered_and_justified(|ui| ui.label(NO_MOTION))));
        } else {
            self.ui(ui, gpu, sky);
        }
    }

    fn can(&self) -> Can {
        self.can()
    }

    fn step(&mut self, step: Step) {
        self.step(step);
    }

    fn shows(&self) -> &'static [FileKind] {
        &[FileKind::Description, FileKind::Scene, FileKind::Field, FileKind::Spheres, FileKind::Sky]
    }

    fn open(&mut self, path: &Path, kind: FileKind) -> anyhow::Result<bool> {
        match kind {
            FileKind::Sky => return Ok(false),
            FileKind::Field | FileKind::Spheres => self.open_part_file(path),
            _ => self.open(path),
        }
        Ok(true)
    }

    fn take_wish_for_file(&mut self) -> bool {
        self.take_wish_for_file()
    }

    fn forget_pictures(&mut self, gpu: &Gpu) {
        self.forget_pictures(gpu);
    }

    fn read_within(&mut self, limits: ReadLimits) {
        self.limits = limits;
    }
}
