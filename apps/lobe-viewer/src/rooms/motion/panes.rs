//! The pictures of a moment beside each other: by fields, by exponentials, and the truth.

use std::sync::Arc;

use eframe::egui::{Align2, Color32, FontId, Painter, Rect, Ui, pos2, vec2};
use lobe::render::Surfaces;
use lobe_gpu::GpuError;
use web_time::{Duration, Instant};

use crate::loading::backdrop::Behind;
use crate::loading::sky_source::OpenedSky;
use crate::rooms::motion::edits::MotionView;
use crate::rooms::motion::player::Shown;
use crate::rooms::motion::stage::{Drawn, Frame, Stage};
use crate::rooms::truth::{Shows, Still, Truth};
use crate::widgets::gpu::Gpu;
use crate::widgets::status::Status;

/// Points between two pictures.
const GAP: f32 = 4.0;

/// After so long without a change the truth is traced.
pub(crate) const REST: Duration = Duration::from_millis(400);

/// How often times on the device are measured, which waits for it.
const MEASURE: Duration = Duration::from_secs(1);

/// What all pictures show.
pub(crate) struct Scenery<'a> {
    pub(crate) lit: &'a Shown,
    pub(crate) sky: Option<&'a OpenedSky>,
    pub(crate) behind: &'a Behind,
}

/// The views of both ways, the truth, and what is known of their difference.
#[derive(Default)]
pub(crate) struct Panes {
    stages: [Stage; 2],
    truth: Truth,
    /// The exposure that fits the first picture.
    fits: Option<f64>,
    /// What was shown last, and since when.
    still: Option<(Shown, Frame, Instant)>,
    /// Paths of the truth that both ways were compared with, and how far they are from it.
    errors: Option<(u64, [Option<f64>; 2])>,
    measured: Option<Instant>,
    pub(crate) status: Status,
}

impl Panes {
    /// Forgets the scene, for another one.
    pub(crate) fn clear(&mut self) {
        self.stages.iter_mut().for_each(Stage::clear);
        self.truth.stop();
        (self.fits, self.still, self.errors) = (None, None, None);
    }

    /// Forgets all that is on the device.
    pub(crate) fn forget(&mut self, gpu: &Gpu) {
        self.stages.iter_mut().for_each(|stage| stage.forget(gpu));
    }

    /// Fits the exposure again, for another sky.
    pub(crate) fn fit_exposure(&mut self) {
        self.fits = None;
        self.stages.iter_mut().for_each(Stage::clear);
    }

    /// How far a way is from the truth: the root mean square of the difference over the mean.
    pub(crate) fn error(&self, pane: MotionView) -> Option<f64> {
        let (_, errors) = self.errors?;
        number_of(pane).and_then(|number| errors[number])
    }

    /// What is known of the truth, in one line.
    pub(crate) fn describe(&self) -> String {
        match self.truth.refined().filter(|_| self.errors.is_some()) {
            Some(refined) => format!("{} paths a pixel", refined.paths),
            None => self.truth.describe(),
        }
    }

    /// The places of the pictures of a view.
    pub(crate) fn places(view: MotionView, whole: Rect) -> Vec<(MotionView, Rect)> {
        let panes = view.panes();
        let width = (whole.width() - GAP * (panes.len() - 1) as f32) / panes.len() as f32;
        let place = |(k, pane): (usize, &MotionView)| {
            let corner = whole.min + vec2(k as f32 * (width + GAP), 0.0);
            (*pane, Rect::from_min_size(corner, vec2(width.max(0.0), whole.height())))
        };
        panes.iter().enumerate().map(place).collect()
    }

    /// Draws the pictures at their places.
    pub(crate) fn show(
        &mut self,
        ui: &Ui,
        gpu: &Gpu,
        places: &[(MotionView, Rect)],
        scenery: &Scenery<'_>,
        frame: &Frame,
    ) -> Result<(), GpuError> {
        let (begin, mut is_new) = (Instant::now(), false);
        self.watch(scenery, frame);
        for (pane, rect) in places {
            let (texture, title) = match number_of(*pane) {
                Some(number) => {
                    let method = pane.method().unwrap_or_default();
                    let moment = (scenery.lit, method);
                    let behind = (scenery.behind, scenery.sky.map(|sky| &sky.shown));
                    let drawn = self.stages[number].draw(gpu, moment, behind, frame, &mut self.fits)?;
                    is_new |= drawn.is_some_and(|drawn| drawn.is_new);
                    (drawn.map(|Drawn { texture, .. }| texture), self.title(*pane, scenery.lit))
                }
                None => (self.truth(ui, scenery, frame), self.truth_title(frame)),
            };
            if let Some(texture) = texture {
                let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
                ui.painter().image(texture, *rect, whole, Color32::WHITE);
            }
            if places.len() > 1 || *pane == MotionView::Truth {
                caption(&ui.painter_at(*rect), *rect, &title);
            }
        }
        if is_new {
            self.measure(scenery, frame, begin);
        }
        Ok(())
    }

    /// Notes whether anything is another than before.
    fn watch(&mut self, scenery: &Scenery<'_>, frame: &Frame) {
        let is_same = self.still.as_ref().is_some_and(|(lit, at, _)| {
            // How light is shown changes none.
            Arc::ptr_eq(lit, scenery.lit) && Frame { look: frame.look, ..*at } == *frame
        });
        if !is_same {
            self.still = Some((scenery.lit.clone(), *frame, Instant::now()));
            self.truth.stop();
            self.errors = None;
        }
    }

    fn title(&self, pane: MotionView, lit: &Shown) -> String {
        let title = pane.title();
        match (pane.method().and_then(|method| lit.way(method)), self.error(pane)) {
            (None, _) => format!("{title}: baking"),
            (Some(_), None) => title.into(),
            (Some(_), Some(error)) => format!("{title}: {:.1} % from the truth", 100.0 * error),
        }
    }

    fn truth_title(&self, frame: &Frame) -> String {
        match frame.is_still {
            true => format!("{}: {}", MotionView::Truth.title(), self.describe()),
            false => format!("{}: traced while nothing moves", MotionView::Truth.title()),
        }
    }

    /// The truth of what has rested for a moment, and how far both ways are from it.
    fn truth(&mut self, ui: &Ui, scenery: &Scenery<'_>, frame: &Frame) -> Option<eframe::egui::TextureId> {
        let (_, _, since) = self.still.as_ref()?;
        if !frame.is_still || frame.size.contains(&0) {
            return None;
        }
        let rested = since.elapsed();
        if rested < REST {
            ui.ctx().request_repaint_after(REST - rested);
            return None;
        }
        self.truth.follow(ui.ctx(), &still(scenery, frame));
        let paths = self.truth.refined()?.paths;
        if self.errors.is_none_or(|(known, _)| known != paths) {
            let refined = self.truth.refined();
            let error = |stage: &Stage| refined.zip(stage.picture()).and_then(|(truth, found)| truth.error_of(&found));
            self.errors = Some((paths, [error(&self.stages[0]), error(&self.stages[1])]));
        }
        let fits = self.fits;
        let found = || {
            let picture = self.stages.iter().find_map(Stage::picture);
            picture.map(|picture| (picture, fits))
        };
        let (picture, fits) = match found() {
            Some(found) => found,
            None => (self.truth.refined()?.mean.clone(), None),
        };
        let fits = *self.fits.get_or_insert_with(|| fits.unwrap_or_else(|| crate::widgets::tone::fitting(&picture)));
        self.truth.texture(ui.ctx(), Shows::Truth, || Some((picture, fits)), frame.look)
    }

    fn measure(&mut self, scenery: &Scenery<'_>, frame: &Frame, begin: Instant) {
        let now = Instant::now();
        self.status.cpu = 1e3 * now.duration_since(begin).as_secs_f64();
        self.status.drew(now);
        if self.measured.is_none_or(|measured| now.duration_since(measured) >= MEASURE) {
            self.status.gpu = self.stages.iter().filter_map(Stage::milliseconds).reduce(|a, b| a + b);
            self.measured = Some(now);
        }
        let scene = &scenery.lit.data.scene;
        (self.status.vertices, self.status.triangles) = (scene.vertex_count(), scene.triangle_count());
        let loads = self.stages.iter().map(Stage::load);
        (self.status.draw_calls, self.status.bytes) = loads.fold((0, 0), |(a, b), (c, d)| (a + c, b + d));
        self.status.size = frame.size;
    }
}

/// The place of a way among the stages.
fn number_of(pane: MotionView) -> Option<usize> {
    MotionView::Beside.panes().iter().position(|known| *known == pane).filter(|number| *number < 2)
}

/// What the truth of a moment depends on: shadows alone, as parts are baked.
fn still(scenery: &Scenery<'_>, frame: &Frame) -> Still {
    Still {
        data: scenery.lit.data.clone(),
        emitters: scenery.lit.emitters.clone(),
        sky: scenery.sky.map(|sky| sky.map.clone()),
        behind: scenery.behind.clone(),
        orbit: frame.orbit,
        size: frame.size,
        turn: frame.turn,
        strength: 1.0,
        lamps: Vec::new(),
        bounces: 0,
        surfaces: Surfaces::Matte,
    }
}

/// A title over a picture, in one or more lines.
fn caption(painter: &Painter, rect: Rect, text: &str) {
    let font = FontId::proportional(13.0);
    let laid = painter.layout(text.into(), font, Color32::WHITE, (rect.width() - 16.0).max(1.0));
    let at = Align2::LEFT_TOP.anchor_size(rect.min + vec2(8.0, 6.0), laid.size());
    painter.rect_filled(at.expand(4.0), 3.0, Color32::from_black_alpha(150));
    painter.galley(at.min, laid, Color32::WHITE);
}
