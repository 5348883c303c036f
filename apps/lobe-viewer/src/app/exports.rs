//! Pictures as files: the window as it is, and the scene as a picture or a turntable.

use std::path::PathBuf;
use std::sync::mpsc::{Receiver, Sender, channel};

use eframe::egui::{Button, Context, DragValue, ProgressBar, TextEdit, Ui, Window};
use lobe::io::Job;
use lobe_gpu::GpuError;

use crate::loading::export::{ExportPlan, MOST_FRAMES, MOST_PIXELS, MOST_RAYS, SceneExport, next_free, write_window};
use crate::loading::task::{Task, TaskEvent};
use crate::widgets::gpu::Gpu;
use crate::widgets::notice::Notice;

/// The name of pictures of the window, of the scene, and of turntables, before their numbers.
const NAMES: [&str; 3] = ["lobe-window", "lobe-scene", "lobe-turntable"];

/// Where the window comes up, in points: below the bar, beside the controls of a room.
const PLACE: [f32; 2] = [340.0, 60.0];

/// What a user asks for in the window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ExportAsked {
    Window,
    Picture,
    Turntable,
    Cancel,
}

/// What is being written, and the window that asks for it.
pub(crate) struct Exports {
    is_open: bool,
    folder: String,
    task: Option<Writing>,
    window: Option<Writing>,
    shots: (Sender<WindowShot>, Receiver<WindowShot>),
}

/// The window as it was shown.
type WindowShot = std::sync::Arc<eframe::egui::ColorImage>;

/// A file that is being written.
struct Writing {
    task: Task<PathBuf>,
    /// Whether it was written, though its task has not ended.
    is_written: bool,
}

impl Writing {
    fn new(task: Task<PathBuf>) -> Self {
        Self { task, is_written: false }
    }

    /// Says what has become of it. Whether it has ended.
    fn tell(&mut self, notice: &mut Notice) -> bool {
        let mut has_ended = false;
        for event in self.task.events() {
            match event {
                TaskEvent::Result(path) => {
                    self.is_written = true;
                    notice.tell(format!("Written: {}", path.display()));
                    continue;
                }
                TaskEvent::Failed(message) => notice.fail(message),
                TaskEvent::Cancelled if !self.is_written => notice.tell("Cancelled; nothing was written"),
                TaskEvent::Cancelled | TaskEvent::Done => {}
            }
            has_ended = true;
        }
        has_ended
    }
}

impl Exports {
    pub(crate) fn new(plan: &ExportPlan) -> Self {
        let folder = plan.folder.display().to_string();
        Self { is_open: false, folder, task: None, window: None, shots: channel() }
    }

    /// The same with another plan, and its window closed.
    pub(crate) fn with_plan(self, plan: &ExportPlan) -> Self {
        Self { is_open: false, folder: plan.folder.display().to_string(), ..self }
    }

    pub(crate) fn toggle(&mut self) {
        self.is_open = !self.is_open;
    }

    /// Whether nothing is being written.
    pub(crate) fn is_idle(&self) -> bool {
        self.task.is_none() && self.window.is_none()
    }

    /// Asks for a picture of the window as it is shown next.
    pub(crate) fn shoot(&mut self, ctx: &Context) {
        let (sender, ctx_of_shot) = (self.shots.0.clone(), ctx.clone());
        ctx.request_screenshot(move |image| {
            // A window that was closed needs no picture.
            drop(sender.send(image));
            ctx_of_shot.request_repaint();
        });
    }

    /// Writes what was shot, and says what was written. Called for each frame.
    pub(crate) fn advance(&mut self, ctx: &Context, plan: &ExportPlan, notice: &mut Notice) {
        for writing in [&mut self.task, &mut self.window] {
            if writing.as_mut().is_some_and(|writing| writing.tell(notice)) {
                *writing = None;
            }
        }
        // One after the other: the next number that is free is known when the file before is there.
        while self.window.is_none()
            && let Ok(image) = self.shots.1.try_recv()
        {
            match next_free(&plan.folder, NAMES[0]) {
                Ok(path) => {
                    self.window = Some(Writing::new(Task::start("Window", wake(ctx), move |control| {
                        write_window(&path, &image).map_err(|error| error.to_string())?;
                        control.send(path);
                        Ok(())
                    })));
                }
                Err(message) => notice.fail(message),
            }
        }
    }

    /// Stops what is being written.
    pub(crate) fn cancel(&self) {
        self.task.iter().for_each(|writing| writing.task.cancel());
    }

    /// Writes what was shot to its end, for a program that ends.
    pub(crate) fn finish(&mut self, plan: &ExportPlan) {
        if let Some(writing) = self.window.take() {
            drop(writing.task.finish());
        }
        for image in self.shots.1.try_iter() {
            // There is no window any more that would say that it is not.
            drop(next_free(&plan.folder, NAMES[0]).map(|path| write_window(&path, &image)));
        }
    }

    /// Shows the window. `scene` makes what is to be rendered; none if there is no scene yet.
    pub(crate) fn show(
        &mut self,
        ctx: &Context,
        plan: &mut ExportPlan,
        gpu: Option<&Gpu>,
        scene: impl FnOnce() -> Option<SceneExport>,
        notice: &mut Notice,
    ) {
        let (mut is_open, mut asked) = (self.is_open, None);
        Window::new("Export").open(&mut is_open).resizable(false).default_width(360.0).default_pos(PLACE).show(
            ctx,
            |ui| {
                asked = self.content(ui, plan, gpu.is_some());
            },
        );
        self.is_open = is_open;
        match asked {
            Some(ExportAsked::Window) => {
                self.is_open = false;
                self.shoot(ctx);
            }
            Some(ExportAsked::Cancel) => self.cancel(),
            Some(ExportAsked::Picture) => self.start(ctx, plan, (gpu, scene()), (1, NAMES[1]), notice),
            Some(ExportAsked::Turntable) => self.start(ctx, plan, (gpu, scene()), (plan.frames, NAMES[2]), notice),
            None => {}
        }
    }

    fn start(
        &mut self,
        ctx: &Context,
        plan: &ExportPlan,
        (gpu, scene): (Option<&Gpu>, Option<SceneExport>),
        (frames, name): (usize, &str),
        notice: &mut Notice,
    ) {
        let Some(scene) = scene else { return notice.fail("No scene yet: open one in the room of scenes") };
        let Some(gpu) = gpu else {
            return notice.fail("No graphics device: lobe-viewer --headless says what it needs");
        };
        let path = match next_free(&plan.folder, name) {
            Ok(path) => path,
            Err(message) => return notice.fail(message),
        };
        let (context, plan) = (gpu.context().clone(), plan.clone());
        self.task = Some(Writing::new(Task::start("Export", wake(ctx), move |control| {
            control.stage(path.file_name().unwrap_or_default().to_string_lossy());
            let mut watch = control.watch();
            match scene.write(&context, &plan, frames, &path, Job::default().watched_by(&mut watch)) {
                Err(GpuError::Cancelled) => Ok(()),
                Err(error) => Err(error.to_string()),
                Ok(()) => {
                    control.send(path);
                    Ok(())
                }
            }
        })));
    }

    fn content(&mut self, ui: &mut Ui, plan: &mut ExportPlan, has_device: bool) -> Option<ExportAsked> {
        let label = ui.label("Folder");
        let typed = TextEdit::singleline(&mut self.folder).desired_width(f32::INFINITY);
        if ui.add(typed).labelled_by(label.id).changed() {
            plan.folder = self.folder.trim().into();
        }
        if !plan.folder.is_dir() {
            ui.colored_label(ui.visuals().error_fg_color, "There is no such folder.");
        }
        let is_idle = self.is_idle();
        let mut asked = None;
        let mut button = |ui: &mut Ui, is_on: bool, text: &str, hint: &str, what: ExportAsked| {
            if ui.add_enabled(is_on, Button::new(text)).on_hover_text(hint).clicked() {
                asked = Some(what);
            }
        };
        button(ui, is_idle, "Window", "The window as it is, without this list (F12)", ExportAsked::Window);
        ui.separator();
        let [width, height] = &mut plan.size;
        number(ui, "Columns", DragValue::new(width).range(1..=MOST_PIXELS));
        number(ui, "Rows", DragValue::new(height).range(1..=MOST_PIXELS));
        number(ui, "Samples along each axis of a pixel", DragValue::new(&mut plan.rays).range(1..=MOST_RAYS));
        number(ui, "Pictures of a turntable", DragValue::new(&mut plan.frames).range(2..=MOST_FRAMES));
        let is_ready = is_idle && has_device;
        button(ui, is_ready, "Picture", "The scene, its light and its view, as PNG", ExportAsked::Picture);
        let hint = "An animated PNG in which the sky turns once around";
        button(ui, is_ready, "Turntable", hint, ExportAsked::Turntable);
        if let Some(Writing { task, .. }) = &self.task {
            ui.label(task.describe());
            match task.progress() {
                Some(part) => ui.add(ProgressBar::new(part).show_percentage()),
                None => ui.spinner(),
            };
            button(ui, true, "Cancel the export", "Nothing is written (Esc)", ExportAsked::Cancel);
        }
        asked
    }
}

/// A number beside its name.
fn number(ui: &mut Ui, name: &str, value: DragValue<'_>) {
    ui.horizontal(|ui| {
        let response = ui.add(value);
        let label = ui.label(name);
        response.labelled_by(label.id);
    });
}

fn wake(ctx: &Context) -> impl Fn() + Send + 'static {
    let ctx = ctx.clone();
    move || ctx.request_repaint()
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::thread::sleep;
    use std::time::Duration;

    use eframe::egui::{Color32, ColorImage};

    use super::*;

    #[test]
    fn what_was_written_before_it_was_cancelled_is_told_as_written() {
        for (is_written, expected) in [(true, "Written: picture.png"), (false, "Cancelled; nothing was written")] {
            let (plan, mut notice, ctx) = (ExportPlan::default(), Notice::default(), Context::default());
            let mut exports = Exports::new(&plan);
            let (go, wait) = channel::<()>();
            exports.task = Some(Writing::new(Task::start("Export", wake(&ctx), move |control| {
                if is_written {
                    control.send(PathBuf::from("picture.png"));
                }
                wait.recv().map_err(|error| error.to_string())
            })));
            exports.cancel();
            // The file is told in a frame, the end in another.
            while is_written && notice.text().is_none() {
                exports.advance(&ctx, &plan, &mut notice);
                sleep(Duration::from_millis(1));
            }
            go.send(()).unwrap();
            while !exports.is_idle() {
                exports.advance(&ctx, &plan, &mut notice);
                sleep(Duration::from_millis(1));
            }
            assert_eq!(notice.text(), Some(expected), "written: {is_written}");
        }
    }

    #[test]
    fn all_pictures_of_the_window_are_whole_when_the_program_ends() {
        let folder = tempfile::tempdir().unwrap();
        let plan = ExportPlan { folder: folder.path().into(), ..ExportPlan::default() };
        let mut exports = Exports::new(&plan);
        for color in [Color32::RED, Color32::GREEN, Color32::BLUE] {
            exports.shots.0.send(Arc::new(ColorImage::filled([3, 2], color))).unwrap();
        }
        exports.advance(&Context::default(), &plan, &mut Notice::default());
        exports.finish(&plan);
        for number in 1..=3 {
            let path = folder.path().join(format!("lobe-window-{number:04}.png"));
            assert!(lobe::image::read_picture(&path, &Default::default()).is_ok(), "{}", path.display());
        }
    }
}
