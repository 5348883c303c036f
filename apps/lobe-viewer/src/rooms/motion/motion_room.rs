//! The room: the panel, the clock, and the picture.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use eframe::egui::{
    CentralPanel, Color32, ComboBox, Context, Panel, ProgressBar, Rect, Response, ScrollArea, Sense, Slider, Ui, pos2,
    vec2,
};
use lobe::env::project_map;
use lobe::render::MovingMethod;
use lobe::scene::built_in;
use lobe::sh::{Rgb, ShVec};
use lobe::shadow::SphereFitMethod;

use crate::loading::moving_source::built_in_moving;
use crate::loading::scene_source::BUILT_IN;
use crate::loading::sky_source::OpenedSky;
use crate::loading::task::TaskEvent;
use crate::rooms::motion::edits::{MOST_SPHERES, MotionEdits};
use crate::rooms::motion::player::{Asked, Cast, Fit, News, ORDER, Player, Shown};
use crate::rooms::motion::spheres::rings;
use crate::rooms::motion::stage::Stage;
use crate::widgets::gpu::Gpu;
use crate::widgets::history::{Can, History, Step};
use crate::widgets::named::name_image;
use crate::widgets::orbit::Orbit;

/// What moves.
pub struct MotionRoom {
    edits: MotionEdits,
    history: History<MotionEdits>,
    player: Option<(PathBuf, Player)>,
    /// The source of the last scene that was opened.
    good: PathBuf,
    cast: Option<Cast>,
    chosen: usize,
    is_playing: bool,
    time: f64,
    orbit: Orbit,
    light: Option<(OpenedSky, ShVec<Rgb<f64>>)>,
    asked: Option<Asked>,
    lit: Option<Shown>,
    is_waiting: bool,
    stage: Stage,
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
            cast: None,
            chosen: 0,
            is_playing: true,
            time: 0.0,
            orbit: Orbit::default(),
            light: None,
            asked: None,
            lit: None,
            is_waiting: false,
            stage: Stage::default(),
            message: None,
            wants_file: false,
        }
    }

    /// What a user changed.
    #[must_use]
    pub fn edits(&self) -> &MotionEdits {
        &self.edits
    }

    /// Whether a moment is lit and shown.
    #[must_use]
    pub fn is_ready(&self) -> bool {
        self.lit.is_some()
    }

    /// Milliseconds that the light of the last moment took; none before there is one.
    #[must_use]
    pub fn milliseconds(&self) -> Option<f64> {
        self.lit.as_ref().map(|lit| lit.milliseconds)
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
        self.lit.as_ref().map_or(0, |lit| lit.spheres.len())
    }

    /// What went wrong last, in one line.
    #[must_use]
    pub fn message(&self) -> Option<&str> {
        self.message.as_deref()
    }

    /// Opens a moving scene, as [`open_moving`](crate::open_moving). One that cannot be opened leaves that which is there.
    pub fn open(&mut self, path: &Path) {
        let MotionEdits { fit, has_exponentials, has_spheres, .. } = self.edits;
        self.edits = MotionEdits { fit, has_exponentials, has_spheres, ..MotionEdits::of_scene(path.into()) };
        self.message = None;
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
        self.take_news();
        self.advance(&ctx, sky);
        Panel::left("motion controls").default_size(300.0).size_range(220.0..=480.0).show(ui, |ui| {
            ScrollArea::vertical().auto_shrink(false).show(ui, |ui| self.panel(ui));
        });
        Panel::bottom("motion status").resizable(false).show(ui, |ui| {
            if let Some(message) = &self.message {
                ui.colored_label(ui.visuals().error_fg_color, message);
            }
            ui.label(self.status());
        });
        CentralPanel::no_frame().show(ui, |ui| self.picture(ui, gpu));
    }

    fn status(&self) -> String {
        let Some(lit) = &self.lit else { return "Preparing".into() };
        let (vertices, spheres) = (lit.radiance.len(), lit.spheres.len());
        let by = match lit.asked.method {
            MovingMethod::Exponentials => format!("exponentials of {spheres} spheres"),
            _ => "products of shadow fields".into(),
        };
        format!("{vertices} vertices, {by}, order {ORDER}: {:.0} ms of light", lit.milliseconds)
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
                    self.chosen = cast.is_still.iter().position(|still| !still).unwrap_or(0);
                    self.edits.is_by_hand &= cast.is_rigid;
                    self.good.clone_from(&self.edits.source);
                    self.cast = Some(cast);
                }
                TaskEvent::Result(News::Lit(lit)) => {
                    if self.lit.is_none() {
                        self.orbit = self.orbit.framing(lit.scene.world_bounds());
                    }
                    self.lit = Some(Arc::from(lit));
                    self.is_waiting = false;
                }
                TaskEvent::Failed(message) => self.fail(message),
                TaskEvent::Done | TaskEvent::Cancelled => {}
            }
        }
    }

    /// Says what went wrong; of a scene that could not be opened the one before is opened again.
    fn fail(&mut self, message: String) {
        self.is_waiting = false;
        if self.cast.is_none() && self.good != self.edits.source {
            // A file that was kept may have gone: before any other was open, that is the first one of the program.
            let is_first = self.good.as_os_str().is_empty();
            let good = if is_first { MotionEdits::default().source } else { self.good.clone() };
            self.open(&good);
        }
        self.message = Some(message);
    }

    /// Starts the player, lets time pass, and asks for the moment that is to be seen.
    fn advance(&mut self, ctx: &Context, sky: Option<&OpenedSky>) {
        if self.player.as_ref().is_none_or(|(source, _)| *source != self.edits.source) {
            self.start(ctx);
        }
        // Hands that come with the scene are no change of a user.
        if self.cast.is_some() {
            self.history.watch(ctx, &self.edits);
        }
        if let Some(sky) = sky
            && self.light.as_ref().is_none_or(|(before, _)| !Arc::ptr_eq(&before.map, &sky.map))
        {
            self.light = Some((sky.clone(), project_map(&sky.map, ORDER)));
        }
        let (Some(cast), Some((_, light))) = (&self.cast, &self.light) else { return };
        if self.is_playing && !self.edits.is_by_hand {
            let [begin, end] = cast.span;
            let passed = ctx.input(|input| f64::from(input.stable_dt.min(0.1)));
            self.time = begin + (self.time + passed - begin).rem_euclid((end - begin).max(1e-3));
            ctx.request_repaint();
        }
        let hands = self.edits.is_by_hand.then(|| self.edits.hands.clone());
        let (method, fit) = (self.edits.method(), self.edits.fit);
        let asked = Asked { time: self.time, method, light: light.clone(), fit, hands };
        if !self.is_waiting
            && self.asked.as_ref() != Some(&asked)
            && let Some((_, player)) = &self.player
        {
            player.ask(asked.clone());
            self.asked = Some(asked);
            self.is_waiting = true;
        }
    }

    /// Starts on the scene of the edits, which nothing of the one before belongs to.
    fn start(&mut self, ctx: &Context) {
        let ctx = ctx.clone();
        let player = Player::start(&self.edits.source, move || ctx.request_repaint());
        self.player = Some((self.edits.source.clone(), player));
        (self.cast, self.asked, self.lit) = (None, None, None);
        (self.time, self.is_waiting, self.orbit) = (0.0, false, Orbit::default());
        self.stage.clear();
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
        ui.separator();
        ui.radio_value(&mut self.edits.has_exponentials, false, "Shadow fields");
        ui.radio_value(&mut self.edits.has_exponentials, true, "Spheres, SH exponentials");
        ui.checkbox(&mut self.edits.has_spheres, "Draw the spheres");
        let is_by_spheres = self.edits.has_exponentials;
        ui.add_enabled_ui(is_by_spheres, |ui| fit_controls(ui, &mut self.edits.fit));
        ui.separator();
        let player = self.player.as_ref().map(|(_, player)| player);
        if let Some(player) = player.filter(|player| player.task().is_at_work()) {
            ui.label(player.task().describe());
            match player.task().progress() {
                Some(part) => ui.add(ProgressBar::new(part).show_percentage()),
                None => ui.spinner(),
            };
        }
        let Some(cast) = self.cast.clone() else { return };
        ui.add_enabled_ui(!self.edits.is_by_hand, |ui| {
            ui.checkbox(&mut self.is_playing, "Play");
            let [begin, end] = cast.span;
            ui.add(Slider::new(&mut self.time, begin..=end).text("Time").suffix(" s").fixed_decimals(2));
        });
        ui.add_enabled_ui(cast.is_rigid, |ui| {
            let response = ui.checkbox(&mut self.edits.is_by_hand, "Move objects by hand");
            response.on_disabled_hover_text("What changes its shape is moved by its animation only");
        });
        if self.edits.is_by_hand {
            self.hand_controls(ui, &cast);
        }
    }

    fn hand_controls(&mut self, ui: &mut Ui, cast: &Cast) {
        ComboBox::from_label("Object").selected_text(cast.names[self.chosen].as_str()).show_ui(ui, |ui| {
            for (number, name) in cast.names.iter().enumerate().filter(|(k, _)| !cast.is_still[*k]) {
                ui.selectable_value(&mut self.chosen, number, name.as_str());
            }
        });
        let hand = &mut self.edits.hands[self.chosen];
        for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
            ui.add(Slider::new(&mut hand.position[axis], -4.0..=4.0).text(name).suffix(" m").fixed_decimals(2));
        }
        let mut degrees = hand.turn.to_degrees();
        if ui.add(Slider::new(&mut degrees, -180.0..=180.0).text("Turn").suffix("°").fixed_decimals(0)).changed() {
            hand.turn = degrees.to_radians();
        }
        ui.add(Slider::new(&mut hand.scale, 0.3..=2.0).text("Size").fixed_decimals(2));
        if ui.button("Put back").clicked() {
            self.edits.hands.clone_from(&cast.hands);
        }
        ui.weak("Drag an object in the picture to move it, with Shift to turn it.");
    }

    fn picture(&mut self, ui: &mut Ui, gpu: Option<&Gpu>) {
        let rect = ui.available_rect_before_wrap();
        let response = ui.interact(rect, ui.scope_id().with("picture"), Sense::click_and_drag());
        name_image(&response, "Picture of what moves");
        self.follow(ui, &response);
        ui.painter().rect_filled(rect, 0.0, ui.visuals().panel_fill);
        let (Some(gpu), Some(lit)) = (gpu, self.lit.clone()) else {
            let text = if gpu.is_none() { "No graphics device: the picture is not drawn." } else { "Preparing" };
            ui.centered_and_justified(|ui| ui.label(text));
            return;
        };
        let scale = ui.ctx().pixels_per_point();
        let size = [rect.width(), rect.height()].map(|points| (points.max(0.0) * scale).round() as u32);
        let sky = self.light.as_ref().map(|(sky, _)| &sky.map);
        match self.stage.draw(gpu, &lit, sky, &self.orbit, size) {
            Ok(Some(texture)) => {
                let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
                ui.painter().image(texture, rect, whole, Color32::WHITE);
            }
            Ok(None) => {}
            Err(error) => {
                ui.centered_and_justified(|ui| {
                    ui.label(format!("The graphics device failed: {error}. Restart the viewer."))
                });
            }
        }
        if self.edits.has_spheres {
            rings(&ui.painter_at(rect), rect, &self.orbit, &lit.spheres);
        }
    }

    /// A drag on an object moves it, with Shift turns it; elsewhere it turns the view.
    fn follow(&mut self, ui: &Ui, response: &Response) {
        let height = f64::from(response.rect.height().max(1.0));
        let by = [response.drag_delta().x, response.drag_delta().y].map(|c| f64::from(c) / height);
        if response.drag_started() {
            let at = ui.input(|input| input.pointer.press_origin());
            let found = at.filter(|_| self.edits.is_by_hand).and_then(|at| self.object_at(response.rect, at));
            if let Some(found) = found {
                self.chosen = found;
            }
            ui.data_mut(|data| data.insert_temp(response.id, found.is_some()));
        }
        if response.dragged() {
            if ui.data(|data| data.get_temp(response.id)).unwrap_or(false) {
                self.drag_object(ui.input(|input| input.modifiers.shift), by);
            } else {
                self.orbit.turn(by[0], by[1]);
            }
        }
        if response.hovered() {
            self.orbit.scroll(f64::from(ui.input(|input| input.smooth_scroll_delta.y)));
        }
    }

    fn drag_object(&mut self, is_turn: bool, [right, down]: [f64; 2]) {
        let hand = &mut self.edits.hands[self.chosen];
        if is_turn {
            hand.turn += std::f64::consts::TAU * right;
            return;
        }
        let (Some(size), Some(camera)) = (self.orbit.size_at(hand.position), self.orbit.camera()) else { return };
        let by = camera.view().point([2.0 * right / size, -2.0 * down / size, 0.0]);
        (0..3).for_each(|k| hand.position[k] += by[k]);
    }

    /// The object whose ball is under a point, the nearest to the eye.
    fn object_at(&self, rect: Rect, at: eframe::egui::Pos2) -> Option<usize> {
        let cast = self.cast.as_ref()?;
        let half = 0.5 * rect.height();
        let hit = |k: &usize| {
            let (Some([right, up]), Some(size)) =
                (self.orbit.project(self.edits.hands[*k].position), self.orbit.size_at(self.edits.hands[*k].position))
            else {
                return false;
            };
            let place = rect.center() + vec2(right as f32, -up as f32) * half;
            place.distance(at) <= (cast.radii[*k] * self.edits.hands[*k].scale * size) as f32 * half
        };
        let size = |k: &usize| self.orbit.size_at(self.edits.hands[*k].position).unwrap_or(0.0);
        (0..self.edits.hands.len())
            .filter(|k| !cast.is_still[*k])
            .filter(hit)
            .max_by(|a, b| size(a).total_cmp(&size(b)))
    }
}

/// The number of spheres, and how they are fitted.
fn fit_controls(ui: &mut Ui, fit: &mut Fit) {
    let slider = Slider::new(&mut fit.count, 1..=MOST_SPHERES).text("Spheres of a part");
    // Each number is a fit of its own: while the handle is held, none is asked for.
    ui.add(slider.update_while_editing(false)).on_hover_text("Four times as many of a part that changes its shape");
    let ways = [
        (SphereFitMethod::Variational, "Variational", "The least volume outside of the part"),
        (SphereFitMethod::MedialAxis, "Medial axis", "Quicker, and worse"),
    ];
    for (method, title, hint) in ways {
        ui.radio_value(&mut fit.method, method, title).on_hover_text(hint);
    }
}
