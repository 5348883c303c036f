//! The room: the panel, the clock, and the picture.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use eframe::egui::{CentralPanel, ComboBox, Context, Id, Key, Label, Panel, Rect, Response, ScrollArea, Sense, Ui};
use lobe::render::MovingMethod;
use lobe::scene::built_in;
use lobe::sh::{Expansion as _, Rgb, ShVec};
use lobe::shadow::WorldSphere;

use crate::loading::limits::ReadLimits;
use crate::loading::moving_source::built_in_moving;
use crate::loading::scene_source::BUILT_IN;
use crate::loading::sky_source::OpenedSky;
use crate::loading::task::TaskEvent;
use crate::rooms::formulas::formulas;
use crate::rooms::light::TamedSky;
use crate::rooms::motion::clock::{Clock, passed};
use crate::rooms::motion::controls::{self, Wish};
use crate::rooms::motion::edits::{MotionEdits, MotionView};
use crate::rooms::motion::hands;
use crate::rooms::motion::panes::{Panes, Scenery};
use crate::rooms::motion::player::{Asked, Cast, MOST_ORDER, News, Player, Shown, Source, Way};
use crate::rooms::motion::spheres::rings;
use crate::rooms::motion::stage::Frame;
use crate::rooms::steer;
use crate::widgets::gpu::Gpu;
use crate::widgets::history::{Can, History, Step};
use crate::widgets::named::name_image;
use crate::widgets::orbit::Orbit;

/// Radians a second by which the sky keeps turning.
const SKY_SPEED: f64 = 0.5;

/// What moves.
pub struct MotionRoom {
    edits: MotionEdits,
    history: History<MotionEdits>,
    player: Option<(Source, Player)>,
    limits: ReadLimits,
    /// That of the window.
    device: Option<lobe_gpu::Context>,
    /// The files of the last scene that was opened.
    good_files: Vec<PathBuf>,
    /// The source of the last scene that was opened.
    good: PathBuf,
    cast: Option<Cast>,
    chosen: usize,
    clock: Clock,
    orbit: Orbit,
    /// Whether the scene is to be in the picture as soon as it is seen.
    wants_frame: bool,
    sky: Option<OpenedSky>,
    light: TamedSky,
    is_sky_turning: bool,
    asked: Option<Asked>,
    lit: Option<Shown>,
    is_waiting: bool,
    /// Whether the bakes of the scene were cancelled before a moment was lit.
    is_stopped: bool,
    panes: Panes,
    picture_ids: Vec<Id>,
    message: Option<String>,
    wants_file: bool,
}

impl MotionRoom {
    /// The room as it was left, or as it is first.
    #[must_use]
    pub fn new(edits: MotionEdits) -> Self {
        Self {
            edits,
            good: PathBuf::new(),
            history: History::default(),
            player: None,
            limits: ReadLimits::default(),
            device: None,
            good_files: Vec::new(),
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
    #[must_use]
    pub fn seen_from(self, orbit: Option<Orbit>) -> Self {
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

    /// Milliseconds that the light of the last moment took, by all ways that are seen; none before there is one.
    #[must_use]
    pub fn milliseconds(&self) -> Option<f64> {
        self.lit.as_ref().map(|lit| lit.ways.iter().map(|way| way.milliseconds).sum())
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

    fn spheres_of_moment(&self) -> &[WorldSphere] {
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

    /// Opens a moving scene, as [`open_moving`](crate::open_moving). One that cannot be opened leaves that which is there.
    pub fn open(&mut self, path: &Path) {
        self.wants_frame |= path != self.edits.source;
        self.edits = self.edits.of_scene(path.into());
        self.message = None;
    }

    /// Opens a file of an occlusion field or of spheres, for the part of the scene that it was made of.
    pub fn open_part_file(&mut self, path: &Path) {
        self.edits.files.retain(|file| file != path);
        self.edits.files.push(path.into());
        self.message = None;
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
            ui.add(Label::new(self.describe()).wrap());
            self.panes.status.show(ui);
        });
        CentralPanel::no_frame().show(ui, |ui| self.picture(ui, gpu));
    }

    /// How the last moment was lit, in one line.
    fn describe(&self) -> String {
        let Some(lit) = &self.lit else { return "Preparing".into() };
        let by = |way: &Way| match way.method {
            MovingMethod::Exponentials => {
                format!("exponentials of {} spheres in {:.0} ms {}", way.spheres.len(), way.milliseconds, way.place)
            }
            _ => format!("products of shadow fields in {:.0} ms {}", way.milliseconds, way.place),
        };
        let ways: Vec<String> = lit.ways.iter().map(by).collect();
        let (vertices, order) = (lit.data.scene.vertex_count(), lit.asked.light.order());
        [format!("{vertices} vertices, order {order}")].into_iter().chain(ways).collect::<Vec<_>>().join(", ")
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
            (Some(lit), _) => self.edits.return_to(&lit.asked),
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
    fn most_order(&self) -> usize {
        self.cast.as_ref().map_or(MOST_ORDER, |cast| cast.most_order)
    }

    fn take_news(&mut self) {
        let events = self.player.as_ref().map(|(_, player)| player.events()).unwrap_or_default();
        for event in events {
            match event {
                TaskEvent::Result(News::Ready(cast)) => {
                    // Places that were taken back or made again belong to this scene already.
                    if self.edits.hands.len() != cast.hands.len() {
                        self.edits.hands.clone_from(&cast.hands);
                    }
                    self.clock.keep_within(cast.span);
                    self.chosen = cast.is_still.iter().position(|still| !still).unwrap_or(0);
                    self.edits.is_by_hand &= cast.is_rigid;
                    self.good.clone_from(&self.edits.source);
                    self.good_files.clone_from(&self.edits.files);
                    self.cast = Some(cast);
                }
                TaskEvent::Result(News::Lit(lit)) => {
                    if std::mem::take(&mut self.wants_frame) {
                        self.orbit = self.orbit.framing(lit.data.scene.world_bounds());
                    }
                    self.lit = Some(Arc::from(lit));
                    // Of several ways the one that was baked already comes first.
                    self.is_waiting = self.lit.as_ref().is_some_and(|lit| lit.ways.len() < lit.asked.methods.len());
                }
                TaskEvent::Failed(message) => self.fail(message),
                TaskEvent::Cancelled => {
                    self.is_stopped = true;
                    self.fail("Stopped before the scene was baked. Bake begins again.".into());
                }
                TaskEvent::Done => {}
            }
        }
    }

    /// Says what went wrong; of a scene that could not be opened the one before is opened again.
    fn fail(&mut self, message: String) {
        self.is_waiting = false;
        let is_good = self.good == self.edits.source && self.good_files == self.edits.files;
        if self.cast.is_none() && !is_good {
            // A file that was kept may have gone: before any other was open, that is the first one of the program.
            let is_first = self.good.as_os_str().is_empty();
            let good = if is_first { MotionEdits::default().source } else { self.good.clone() };
            self.open(&good);
            self.edits.files.clone_from(&self.good_files);
        }
        self.message = Some(message);
    }

    /// Starts the player, lets time pass, and asks for the moment that is to be seen.
    fn advance(&mut self, ctx: &Context, sky: Option<&OpenedSky>) {
        if self.player.as_ref().is_none_or(|(source, _)| *source != self.wanted()) {
            self.start(ctx);
        }
        // Hands that come with the scene are no change of a user.
        if self.cast.is_some() {
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
        let hands = self.edits.is_by_hand.then(|| self.edits.hands.clone());
        let order = self.edits.order.min(cast.most_order);
        let light = self.edits.rotation().rotated(self.light.of(sky, order, self.edits.taming));
        let asked = Asked {
            time: self.clock.time,
            methods: self.edits.methods(),
            light,
            fit: self.edits.fit,
            lit_on: self.edits.lit_on,
            hands,
        };
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

    /// The scene of the edits.
    fn wanted(&self) -> Source {
        let MotionEdits { source, files, .. } = &self.edits;
        Source { path: source.clone(), files: files.clone(), limits: self.limits }
    }

    /// Starts on the scene of the edits, which nothing of the one before belongs to.
    fn start(&mut self, ctx: &Context) {
        let ctx = ctx.clone();
        let source = self.wanted();
        // Also where a change of the scene was taken back.
        self.wants_frame |= self.player.as_ref().is_some_and(|(before, _)| before.path != source.path);
        let player = Player::start(&source, self.edits.order, self.device.clone(), move || ctx.request_repaint());
        self.player = Some((source, player));
        (self.cast, self.asked, self.lit) = (None, None, None);
        (self.is_waiting, self.is_stopped) = (false, false);
        if self.wants_frame {
            self.orbit = Orbit::default();
        }
        self.panes.clear();
    }

    fn panel(&mut self, ui: &mut Ui) {
        ui.spacing_mut().slider_width = 120.0;
        let mut source = self.edits.source.clone();
        let name = source.file_name().unwrap_or_default().to_string_lossy().into_owned();
        ComboBox::from_label("Scene").selected_text(name.trim_start_matches(BUILT_IN)).show_ui(ui, |ui| {
            for known in built_in::MOVING_NAMES {
                ui.selectable_value(&mut source, built_in_moving(known), known);
            }
        });
        if source != self.edits.source {
            self.open(&source);
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
            Some(Wish::Bake) => (self.player, self.message) = (None, None),
            None => {}
        }
        let Some(cast) = self.cast.clone() else { return };
        ui.add_enabled_ui(!self.edits.is_by_hand, |ui| {
            self.clock.controls(ui, cast.span);
        });
        ui.add_enabled_ui(cast.is_rigid, |ui| {
            let response = ui.checkbox(&mut self.edits.is_by_hand, "Move objects by hand");
            response.on_disabled_hover_text("What changes its shape is moved by its animation only");
        });
        if self.edits.is_by_hand {
            controls::hands(ui, &mut self.edits, &mut self.chosen, &cast);
        }
    }

    fn picture(&mut self, ui: &mut Ui, gpu: Option<&Gpu>) {
        let whole = ui.available_rect_before_wrap();
        let places = Panes::places(self.edits.view, whole);
        self.picture_ids.clear();
        ui.painter().rect_filled(whole, 0.0, ui.visuals().panel_fill);
        for (number, (pane, rect)) in places.iter().enumerate() {
            let response = ui.interact(*rect, ui.scope_id().with(("picture", number)), Sense::click_and_drag());
            name_image(&response, &format!("Picture of what moves: {}", pane.title()));
            self.follow(ui, &response);
            self.picture_ids.push(response.id);
            steer::hold_keys(ui, &response);
        }
        let (Some(gpu), Some(lit)) = (gpu, self.lit.clone()) else {
            let text = if gpu.is_none() { "No graphics device: the picture is not drawn." } else { "Preparing" };
            ui.centered_and_justified(|ui| ui.label(text));
            return;
        };
        let scale = ui.ctx().pixels_per_point();
        let side = |points: f32| (points.max(0.0) * scale).round() as u32;
        let size = places.first().map_or([0, 0], |(_, rect)| [side(rect.width()), side(rect.height())]);
        let is_playing = self.clock.is_playing && !self.edits.is_by_hand;
        let is_still = !is_playing && !self.is_sky_turning && !self.is_waiting;
        let sky = self.sky.as_ref().map(|sky| &sky.map);
        let scenery = Scenery { lit: &lit, sky, is_still };
        let orbit = places.first().map_or(self.orbit, |(_, rect)| self.seen(*rect));
        let frame = Frame { orbit, size, turn: self.edits.rotation(), exposure: self.edits.exposure };
        if let Err(error) = self.panes.show(ui, gpu, &places, &scenery, &frame) {
            let text = format!("The graphics device failed: {error}. Restart the viewer; what you changed is kept.");
            ui.centered_and_justified(|ui| ui.label(text));
        }
        if self.edits.has_spheres {
            for (_, rect) in places.iter().filter(|(pane, _)| pane.method() == Some(MovingMethod::Exponentials)) {
                rings(&ui.painter_at(*rect), *rect, &orbit, self.spheres_of_moment());
            }
        }
    }

    /// The camera of a picture at a place: what is in the picture remains there beside others.
    fn seen(&self, place: Rect) -> Orbit {
        self.orbit.fitting(f64::from(place.width()), f64::from(place.height()))
    }

    /// A drag on an object moves, turns or scales it; elsewhere it changes the camera and the light.
    fn follow(&mut self, ui: &Ui, response: &Response) {
        if response.drag_started() {
            let at = ui.input(|input| input.pointer.press_origin());
            let found = at.zip(self.cast.as_ref()).filter(|_| self.edits.is_by_hand).and_then(|(at, cast)| {
                hands::object_at(&self.edits.hands, cast, &self.seen(response.rect), response.rect, at)
            });
            if let Some(found) = found {
                self.chosen = found;
            }
            ui.data_mut(|data| data.insert_temp(response.id, found.is_some()));
        }
        if response.dragged() && ui.data(|data| data.get_temp(response.id)).unwrap_or(false) {
            let orbit = self.seen(response.rect);
            let modifiers = ui.input(|input| input.modifiers);
            hands::drag(&mut self.edits.hands[self.chosen], &orbit, modifiers, steer::drag_of(response));
            steer::zoom(ui, response, &mut self.orbit);
        } else {
            let most_order = self.most_order();
            steer::pointer(ui, response, &mut self.orbit, &mut self.edits.light(most_order));
        }
    }
}
