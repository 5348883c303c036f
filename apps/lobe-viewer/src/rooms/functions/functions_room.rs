//! The room: the panel of the study, and what it shows.

use std::path::Path;

use eframe::egui::{CentralPanel, ComboBox, Context, Id, Key, Panel, ScrollArea, Slider, Ui};

use crate::loading::file_kind::FileKind;
use crate::loading::sky_source::OpenedSky;
use crate::rooms::formulas::formulas;
use crate::rooms::functions::edits::{FunctionsEdits, MAX_ORDER, OpenedFunction, Section, Shape, Study};
use crate::rooms::functions::figures::{Figures, Stand};
use crate::rooms::functions::{ambient_cube, multiply, ringing, rotate};
use crate::rooms::room::Room;
use crate::rooms::steer;
use crate::widgets::gpu::Gpu;
use crate::widgets::history::{Can, History, Step};
use crate::widgets::orbit::Orbit;
use crate::widgets::status::Status;

/// Functions on the sphere.
pub struct FunctionsRoom {
    edits: FunctionsEdits,
    history: History<FunctionsEdits>,
    eye: Orbit,
    figures: [Figures; 3],
    balloons: Vec<Id>,
    status: Status,
}

impl FunctionsRoom {
    /// The room as it was left.
    #[must_use]
    pub fn new(mut edits: FunctionsEdits) -> Self {
        edits.check();
        let (history, figures, status) = Default::default();
        Self { edits, history, eye: first_eye(), figures, balloons: Vec::new(), status }
    }

    /// The same with the camera that was left there.
    pub(crate) fn seen_from(self, orbit: Option<Orbit>) -> Self {
        Self { eye: orbit.unwrap_or(self.eye), ..self }
    }

    /// What a user changed.
    #[must_use]
    pub fn edits(&self) -> &FunctionsEdits {
        &self.edits
    }

    /// Takes the last change back, or makes it again.
    pub fn step(&mut self, step: Step) {
        self.history.step(step, &mut self.edits);
    }

    pub(crate) fn can(&self) -> Can {
        self.history.can(&self.edits)
    }

    /// The camera.
    #[must_use]
    pub fn orbit(&self) -> &Orbit {
        &self.eye
    }

    /// Shows the expansion of a .sh.json file, of any quantity, as the function that is turned.
    ///
    /// # Errors
    /// One line that says what is wrong with the file.
    pub fn open(&mut self, path: &Path) -> anyhow::Result<()> {
        let opened = OpenedFunction::read(path)?;
        self.edits.order = opened.coefficients.len().isqrt().clamp(1, MAX_ORDER);
        (self.edits.study, self.edits.shape) = (Study::Rotate, Shape::Opened);
        self.edits.angles = [0.0; 3];
        self.edits.opened = Some(opened);
        Ok(())
    }

    /// Shows the room.
    pub fn ui(&mut self, ui: &mut Ui) {
        let ctx = ui.ctx().clone();
        self.history.watch(&ctx, &self.edits);
        self.keys(&ctx);
        Panel::left("function controls").default_size(300.0).size_range(220.0..=480.0).show(ui, |ui| {
            ScrollArea::vertical().auto_shrink(false).show(ui, |ui| self.panel(ui));
        });
        Panel::bottom("function status").resizable(false).show(ui, |ui| self.status.show(ui));
        CentralPanel::default_margins().show(ui, |ui| {
            ScrollArea::vertical().auto_shrink(false).show(ui, |ui| self.study(ui));
        });
        self.status.note_drawn(&ctx);
    }

    /// Keys of the room, where no control has the keyboard.
    fn keys(&mut self, ctx: &Context) {
        if !steer::has_keys(ctx, &self.balloons) {
            return;
        }
        let Self { edits, eye, .. } = self;
        if edits.with_light(|hand| steer::keys(ctx, eye, hand)).frame {
            self.frame();
        }
        let pressed = |key: Key| ctx.input(|input| input.modifiers.is_none() && input.key_pressed(key));
        for (key, study) in [Key::Num1, Key::Num2, Key::Num3, Key::Num4].into_iter().zip(Study::ALL) {
            if pressed(key) {
                self.edits.study = study;
            }
        }
    }

    /// Shows balloons as large as fits.
    fn frame(&mut self) {
        let Orbit { target, distance, .. } = first_eye();
        self.eye = Orbit { target, distance, ..self.eye };
    }

    fn panel(&mut self, ui: &mut Ui) {
        ui.spacing_mut().slider_width = 120.0;
        for (number, study) in Study::ALL.into_iter().enumerate() {
            ui.radio_value(&mut self.edits.study, study, study.title()).on_hover_text(format!("{}", number + 1));
        }
        ui.separator();
        if self.edits.study != Study::AmbientCube {
            let slider = Slider::new(&mut self.edits.order, 1..=MAX_ORDER).text("Order");
            ui.add(slider).on_hover_text("Number of bands (comma, point)");
        }
        match self.edits.study {
            Study::Rotate => rotate::controls(ui, &mut self.edits),
            Study::Product => multiply::controls(ui, &mut self.edits),
            Study::Ringing => ringing::controls(ui, &mut self.edits),
            Study::AmbientCube => ambient_cube::controls(ui, &mut self.edits),
        }
        if let (Some(opened), Shape::Opened) = (&self.edits.opened, self.edits.shape) {
            ui.label(&opened.name);
        }
        formulas(ui, self.edits.formulas());
        ui.separator();
        ui.checkbox(&mut self.edits.has_crosses, "Unfolded cubes");
        ComboBox::from_label("Polar plots").selected_text(self.edits.section.title()).show_ui(ui, |ui| {
            for section in Section::ALL {
                ui.selectable_value(&mut self.edits.section, section, section.title());
            }
        });
        if ui.button("Frame").on_hover_text("Balloons as large as fits (F)").clicked() {
            self.frame();
        }
        ui.weak(
            "Balloons: r = |f(s)|, red where f is positive, blue where it is negative. Drag one to turn them all, with \
             Shift to turn what is shown.",
        );
    }

    fn study(&mut self, ui: &mut Ui) {
        let Self { edits, eye, figures, .. } = self;
        let mut stand = Stand::new(edits, eye, figures);
        match edits.study {
            Study::Rotate => rotate::show(ui, edits, &mut stand),
            Study::Product => multiply::show(ui, edits, &mut stand),
            Study::Ringing => ringing::show(ui, edits, &mut stand),
            Study::AmbientCube => ambient_cube::show(ui, edits, &mut stand),
        }
        let shown = stand.balloons;
        self.balloons.clear();
        for response in &shown {
            let Self { edits, eye, .. } = self;
            edits.with_light(|hand| steer::pointer(ui, response, eye, hand));
            steer::hold_keys(ui, response);
            self.balloons.push(response.id);
        }
    }
}

/// The camera of the first start.
fn first_eye() -> Orbit {
    Orbit { azimuth: 0.6, height: 0.45, target: [0.0; 3], ..Orbit::default() }
}

impl Room for FunctionsRoom {
    fn ui(&mut self, ui: &mut Ui, _: Option<&Gpu>, _: Option<&OpenedSky>) {
        self.ui(ui);
    }

    fn can(&self) -> Can {
        self.can()
    }

    fn step(&mut self, step: Step) {
        self.step(step);
    }

    fn shows(&self) -> &'static [FileKind] {
        &[FileKind::Function]
    }

    fn open(&mut self, path: &Path, _: FileKind) -> anyhow::Result<bool> {
        self.open(path).map(|()| true)
    }
}
