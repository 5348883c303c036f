//! The room: the panel, and the pictures.

use std::f64::consts::TAU;
use std::sync::Arc;
use std::time::Duration;

use eframe::egui::{
    Button, CentralPanel, Checkbox, ComboBox, Context, Id, Key, Panel, Response, ScrollArea, Slider, Ui,
};
use lobe::env::{Mapping, Sun};
use lobe::figures::{Shading, SurfacePoint};
use lobe::sh::{Coefficient as _, Dir, Expansion as _, Rgb, Rotation};

use crate::loading::file_kind::FileKind;
use crate::loading::place::IN_PAGE;
use crate::loading::sky_source::OpenedSky;
use crate::rooms::formulas::formulas;
use crate::rooms::room::Room;
use crate::rooms::sky::balls::{BallView, Balls};
use crate::rooms::sky::edits::{MOST_LIGHTS, MOST_SUNS, Shelf, SkyEdits};
use crate::rooms::sky::findings::Findings;
use crate::rooms::sky::panels::Panels;
use crate::rooms::sky::stage::{Scenery, SkyStage, first_orbit, framed, seen_behind};
use crate::rooms::sky::suns::{Suns, meant, place_of};
use crate::rooms::sky::surfaces::{Relief, Surface, Turned};
use crate::rooms::sky::techniques::Techniques;
use crate::rooms::steer;
use crate::widgets::bars::bars;
use crate::widgets::coefficient_table::CoefficientTable;
use crate::widgets::gpu::Gpu;
use crate::widgets::history::{Can, History, Step};
use crate::widgets::orbit::Orbit;
use crate::widgets::status::Status;
use crate::widgets::tone::fitting;
use std::path::Path;

/// Steps of a turn of the sky that changes every second: 15 degrees each.
const STEPS: f64 = 24.0;

/// Radians a second by which the sky keeps turning.
const SPEED: f64 = 0.5;

/// An environment and its expansions.
pub struct SkyRoom {
    edits: SkyEdits,
    history: History<SkyEdits>,
    orbit: Orbit,
    /// The sky as it is open, without what was taken out.
    opened: Option<OpenedSky>,
    found: Option<Findings>,
    suns: Suns,
    techniques: Techniques,
    stage: SkyStage,
    panels: Panels,
    balls: Balls,
    table: CoefficientTable,
    /// Since when the sky turns by a step each second, in seconds of the window.
    looping: Option<f64>,
    is_turning: bool,
    picture_ids: Vec<Id>,
    status: Status,
}

impl SkyRoom {
    /// The room as it was left.
    #[must_use]
    pub fn new(mut edits: SkyEdits) -> Self {
        edits.check();
        Self {
            edits,
            history: History::default(),
            orbit: first_orbit(),
            opened: None,
            found: None,
            suns: Suns::default(),
            techniques: Techniques::default(),
            stage: SkyStage::default(),
            panels: Panels::default(),
            balls: Balls::default(),
            table: CoefficientTable::default(),
            looping: None,
            is_turning: false,
            picture_ids: Vec::new(),
            status: Status::default(),
        }
    }

    /// The same with the camera that was left there.
    pub(crate) fn seen_from(self, orbit: Option<Orbit>) -> Self {
        Self { orbit: orbit.unwrap_or(self.orbit), ..self }
    }

    /// What a user changed.
    #[must_use]
    pub fn edits(&self) -> &SkyEdits {
        &self.edits
    }

    /// The same, to change it from a program.
    pub fn edits_mut(&mut self) -> &mut SkyEdits {
        &mut self.edits
    }

    /// The camera.
    #[must_use]
    pub fn orbit(&self) -> &Orbit {
        &self.orbit
    }

    /// Whether it is known which suns the sky has that is open.
    #[must_use]
    pub fn has_looked_for_suns(&self) -> bool {
        self.opened.as_ref().is_some_and(|sky| self.suns.found(sky).is_some())
    }

    /// The suns that were taken out of the sky that is open.
    #[must_use]
    pub fn suns(&self) -> &[Sun] {
        let found = self.opened.as_ref().and_then(|sky| self.suns.found(sky));
        found.map_or(&[], |found| found.taken.as_slice())
    }

    /// Takes the last change back, or makes it again.
    pub fn step(&mut self, step: Step) {
        self.history.step(step, &mut self.edits);
    }

    pub(crate) fn can(&self) -> Can {
        self.history.can(&self.edits)
    }

    /// Shows the room on an environment.
    pub fn ui(&mut self, ui: &mut Ui, sky: Option<&OpenedSky>) {
        let ctx = ui.ctx().clone();
        self.keys(&ctx);
        self.advance(&ctx, sky);
        Panel::left("sky controls").default_size(320.0).size_range(240.0..=480.0).show(ui, |ui| {
            ScrollArea::vertical().auto_shrink(false).show(ui, |ui| self.panel(ui, sky));
        });
        Panel::bottom("sky status").resizable(false).show(ui, |ui| {
            let message = self.suns.message.as_ref().or(self.techniques.message.as_ref());
            if let Some(message) = message {
                ui.colored_label(ui.visuals().error_fg_color, message);
            }
            self.status.show(ui);
        });
        CentralPanel::default_margins().show(ui, |ui| {
            ScrollArea::vertical().auto_shrink(false).show(ui, |ui| match self.found.take() {
                Some(found) => {
                    self.pictures(ui, &found);
                    self.found = Some(found);
                }
                None => {
                    ui.label("Opening the sky");
                }
            });
        });
        self.status.note_drawn(&ctx);
    }

    /// Lets time pass, takes what was found beside the window, and finds what follows from the edits.
    fn advance(&mut self, ctx: &Context, sky: Option<&OpenedSky>) {
        if self.is_turning {
            let seconds = ctx.input(|input| f64::from(input.stable_dt.min(0.1)));
            self.edits.turn = (self.edits.turn + SPEED * seconds).rem_euclid(TAU);
            ctx.request_repaint();
        } else {
            // A sky that turns by itself is not a change to take back.
            self.history.watch(ctx, &self.edits);
        }
        let Some(sky) = sky else { return };
        if self.opened.as_ref().is_some_and(|before| !Arc::ptr_eq(&before.map, &sky.map)) {
            self.edits.forget_sky();
        }
        self.opened = Some(sky.clone());
        let wake = |ctx: &Context| {
            let ctx = ctx.clone();
            move || ctx.request_repaint()
        };
        self.suns.follow(wake(ctx), sky, &self.edits.suns);
        let rest = self.suns.found(sky).and_then(|found| found.rest.as_ref()).unwrap_or(sky);
        // A page has one thread, in which rough balls would stop the window.
        if !IN_PAGE && self.edits.needs_techniques() {
            self.techniques.follow(wake(ctx), rest);
        }
        let turn = self.edits.rotation().then(Rotation::from_axis_angle(Dir::Z, self.turn(ctx)));
        self.found = Some(Findings::of(self.found.take(), rest, &self.edits, turn));
    }

    /// The turn of the sky in radians by its loop: a step for each second that has passed, 0 at rest.
    fn turn(&self, ctx: &Context) -> f64 {
        let Some(since) = self.looping else { return 0.0 };
        let passed = (ctx.input(|input| input.time) - since).max(0.0);
        ctx.request_repaint_after(Duration::from_secs_f64(1.0 - passed.fract()));
        TAU * (passed.floor() % STEPS) / STEPS
    }

    /// Keys of the room, where no control has the keyboard.
    fn keys(&mut self, ctx: &Context) {
        if !steer::has_keys(ctx, &self.picture_ids) {
            return;
        }
        let steered = steer::keys(ctx, &mut self.orbit, &mut self.edits.light());
        self.is_turning ^= steered.turning;
        if steered.frame {
            self.orbit = framed(self.orbit);
        }
        let pressed = |key: Key| ctx.input(|input| input.modifiers.is_none() && input.key_pressed(key));
        for (key, shelf) in [Key::Num1, Key::Num2, Key::Num3].into_iter().zip(Shelf::ALL) {
            if pressed(key) {
                self.edits.shelf = shelf;
            }
        }
    }

    fn pictures(&mut self, ui: &mut Ui, found: &Findings) {
        let tone = self.edits.look().of(fitting(&found.picture));
        let key = [vec![found.version], self.edits.look().key()].concat();
        let suns = self.suns().to_vec();
        let mut responses = vec![self.show_stage(ui, found, (tone, &key), &suns)];
        let at = responses[0].interact_pointer_pos().filter(|_| responses[0].clicked());
        let mut clicked = at.and_then(|at| seen_behind(&self.orbit, responses[0].rect, at));
        ui.horizontal_wrapped(|ui| {
            for (number, shelf) in Shelf::ALL.into_iter().enumerate() {
                ui.selectable_value(&mut self.edits.shelf, shelf, shelf.title())
                    .on_hover_text(format!("{}", number + 1));
            }
        });
        match self.edits.shelf {
            Shelf::Maps => clicked = self.panels.show(ui, found, &suns, &self.edits).or(clicked),
            Shelf::Techniques => {
                if let Some(text) = self.techniques.describe() {
                    ui.weak(text);
                }
                let key = [key, vec![self.techniques.ready.len() as u64]].concat();
                let view = BallView { found, orbit: &self.orbit, tone, key: &key };
                responses.extend(self.balls.techniques(ui, &view, &self.techniques.ready));
            }
            Shelf::Encodings => {
                let view = BallView { found, orbit: &self.orbit, tone, key: &key };
                let whole = found.whole_light();
                responses.extend(self.balls.encodings(ui, &view, &whole));
            }
        }
        self.picture_ids.clear();
        for response in &responses {
            steer::pointer(ui, response, &mut self.orbit, &mut self.edits.light());
            steer::hold_keys(ui, response);
            self.picture_ids.push(response.id);
        }
        if let Some(s) = clicked {
            self.take_sun(found.back().rotate_dir(s));
        }
    }

    fn show_stage(
        &mut self,
        ui: &mut Ui,
        found: &Findings,
        (tone, key): (lobe::image::Tone, &[u64]),
        suns: &[Sun],
    ) -> Response {
        let by_expansion = self.edits.has_expansion;
        let mirrored = |p: &SurfacePoint| -> Rgb<f32> {
            let r = p.reflected();
            Rgb::narrow(if by_expansion { found.light.eval(r) } else { found.radiance(r) })
        };
        let matte = |p: &SurfacePoint| -> Rgb<f32> {
            Rgb::narrow(found.irradiance.eval(p.normal).scale(std::f64::consts::FRAC_1_PI))
        };
        let glossy_light = self.balls.glossy(found);
        let blurred = |p: &SurfacePoint| -> Rgb<f32> { glossy_light.radiance(p) };
        let technique = |surface: Surface| {
            let found_one = self.techniques.of(surface).filter(|_| !by_expansion);
            found_one.map(|technique| Turned {
                shading: &*technique.shading,
                relief: Relief::Smooth,
                back: found.back(),
            })
        };
        let (glossy, dull) = (technique(Surface::Glossy), technique(Surface::Matte));
        let (has_glossy, has_dull) = (glossy.is_some(), dull.is_some());
        let glossy: &dyn Shading = glossy.as_ref().map_or(&blurred, |turned| turned);
        let dull: &dyn Shading = dull.as_ref().map_or(&matte, |turned| turned);
        let key = [key, &[by_expansion, has_glossy, has_dull].map(u64::from)].concat();
        let scenery = Scenery { found, balls: [&mirrored, glossy, dull], suns, tone, key };
        self.stage.show(ui, &self.orbit, &scenery)
    }

    /// Takes out the sun that a click towards `s` means, in the frame of the sky, or says that there is none.
    fn take_sun(&mut self, s: Dir) {
        let Some(found) = self.opened.as_ref().and_then(|sky| self.suns.found(sky)) else { return };
        let (clicked, mut message) = (meant(&found.all, s).copied(), None);
        let is_new = clicked.is_some_and(|sun| !found.taken.contains(&sun));
        if clicked.is_none() {
            let [azimuth, height] = place_of(s);
            let there = match found.all.first().map(|sun| place_of(sun.direction)) {
                Some([a, h]) => format!("the brightest is at azimuth {a:.0}°, height {h:.0}°"),
                None => "nothing in this sky is as small and as bright as a sun".into(),
            };
            message = Some(format!("No sun at azimuth {azimuth:.0}°, height {height:.0}°: {there}"));
        }
        self.suns.message = message;
        if let Some(sun) = clicked.filter(|_| is_new && self.edits.suns.len() < MOST_SUNS) {
            self.edits.suns.push(place_of(sun.direction));
        }
    }

    fn panel(&mut self, ui: &mut Ui, sky: Option<&OpenedSky>) {
        ui.spacing_mut().slider_width = 120.0;
        let edits = &mut self.edits;
        ui.strong(sky.map_or("No sky", |sky| &sky.name));
        ui.weak("It is chosen in the room of scenes, or dropped on the window.");
        if ui.button("Frame").on_hover_text("All three balls in the picture (F)").clicked() {
            self.orbit = framed(self.orbit);
        }
        edits.light().expansion_controls(ui);
        edits.light().sky_controls(ui);
        ui.checkbox(&mut self.is_turning, "Keep turning (T)");
        ui.add(Checkbox::new(&mut edits.has_expansion, "Balls lit by the expansion"))
            .on_hover_text("The three balls before the sky; else they are lit by the sky itself");
        ui.add(Slider::new(&mut edits.lights, 0..=MOST_LIGHTS).text("Lights"))
            .on_hover_text("Lights that stand for the expansion: yellow arrows");
        ComboBox::from_label("Mapping").selected_text(edits.mapping.as_str()).show_ui(ui, |ui| {
            for mapping in Mapping::ALL {
                ui.selectable_value(&mut edits.mapping, mapping.name().to_owned(), mapping.name());
            }
        });
        formulas(ui, edits.formulas());
        ui.separator();
        let Some(found) = self.found.take() else { return };
        self.numbers(ui, &found);
        ui.separator();
        self.sun_controls(ui);
        ui.separator();
        self.coefficients(ui, &found);
        self.found = Some(found);
    }

    /// What the library says of the expansion.
    fn numbers(&self, ui: &mut Ui, found: &Findings) {
        ui.label(format!("RMS error: {:.2} times the mean", found.error));
        ui.label(format!("Minimum of the luminance: {:.4} (blue cross)", found.minimum.lo));
        if let Some(fit) = &found.lights {
            for (number, light) in fit.lights.iter().enumerate() {
                let [r, g, b] = <[f64; 3]>::from(light.intensity);
                let (azimuth, height) = (light.dir.phi().to_degrees(), 90.0 - light.dir.theta().to_degrees());
                let number = number + 1;
                ui.label(format!("Light {number}: azimuth {azimuth:.0}°, height {height:.0}°, {r:.2} {g:.2} {b:.2}"));
            }
            let [r, g, b] = <[f64; 3]>::from(fit.ambient);
            ui.label(format!("Ambient: {r:.2} {g:.2} {b:.2}"));
        }
    }

    /// The coefficients as bars and as a table to type into.
    fn coefficients(&mut self, ui: &mut Ui, found: &Findings) {
        ui.strong("Coefficients of the luminance");
        bars(ui, "Coefficients of the luminance", &found.luminance);
        let mut is_looping = self.looping.is_some();
        let hint = "The sky turns by 15 degrees each second; its coefficients change, the energy of each band does not";
        if ui.checkbox(&mut is_looping, "Change every second").on_hover_text(hint).changed() {
            self.looping = is_looping.then(|| ui.input(|input| input.time));
        }
        ui.strong("Coefficients, red, green and blue");
        ui.weak(if is_looping { "They can be typed while they are at rest." } else { "Type into a cell, then Enter." });
        if let Some(typed) = self.table.show(ui, &found.light, !is_looping) {
            self.replace(found, typed);
        }
        let count = self.edits.own.len();
        if ui.add_enabled(count > 0, Button::new("Those of the sky again")).clicked() {
            self.edits.own.clear();
        }
    }

    /// Puts a coefficient of the expansion as it is shown in the place of that of the sky. Of a sky that is turned its whole band changes.
    fn replace(&mut self, found: &Findings, (number, value): (usize, Rgb<f64>)) {
        if (self.edits.turn, self.edits.tilt) == (0.0, 0.0) {
            self.edits.replace(number, value);
            return;
        }
        let mut light = found.light.clone();
        light.coefficients_mut()[number] = value;
        let (light, l) = (light.rotated(&found.back()), number.isqrt());
        for k in l * l..(l + 1) * (l + 1) {
            self.edits.replace(k, light.coefficients()[k]);
        }
    }

    /// The suns that were taken out, and how.
    fn sun_controls(&mut self, ui: &mut Ui) {
        ui.strong("Suns");
        let taken = self.suns().to_vec();
        if taken.is_empty() {
            let all = self.opened.as_ref().and_then(|sky| self.suns.found(sky)).map(|found| found.all.clone());
            match all.as_deref() {
                None => ui.weak("Looking for suns"),
                Some([]) => ui.weak("This sky has none."),
                Some(_) => ui.weak("Click on a sun in the sky to take it out."),
            };
            if let Some(sun) = all.as_deref().and_then(|all| all.first())
                && ui.button("Take out the brightest").clicked()
            {
                self.edits.suns.push(place_of(sun.direction));
            }
            return;
        }
        for sun in &taken {
            let [azimuth, height] = place_of(sun.direction);
            let [r, g, b] = <[f64; 3]>::from(sun.irradiance);
            let diameter = sun.angular_diameter.to_degrees();
            ui.label(format!("Sun: azimuth {azimuth:.1}°, height {height:.1}°, {diameter:.2}° wide"));
            ui.label(format!("Irradiance {r:.3} {g:.3} {b:.3}, from {} texels", sun.texels));
        }
        ui.weak("All pictures and numbers are of the sky without them.");
        if ui.button("Put the suns back").clicked() {
            self.edits.suns.clear();
        }
    }
}

impl Room for SkyRoom {
    fn ui(&mut self, ui: &mut Ui, _: Option<&Gpu>, sky: Option<&OpenedSky>) {
        self.ui(ui, sky);
    }

    fn can(&self) -> Can {
        self.can()
    }

    fn step(&mut self, step: Step) {
        self.step(step);
    }

    fn shows(&self) -> &'static [FileKind] {
        &[FileKind::Sky]
    }

    fn open(&mut self, _: &Path, _: FileKind) -> anyhow::Result<bool> {
        // The sky is that of the room of scenes.
        Ok(false)
    }
}
