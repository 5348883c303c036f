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
    task: Option<Task<PathBuf>>,
    window: Option<Task<PathBuf>>,
    shots: (Sender<WindowShot>, Receiver<WindowShot>),
}

/// The window as it was shown.
type WindowShot = std::sync::Arc<eframe::egui::ColorImage>;

impl Exports {
    pub(crate) fn new(plan: &ExportPlan) -> Self {
        let folder = plan.folder.display().to_string();
        Self { is_open: false, folder, task: None, window: None, shots: channel() }
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
        if let Ok(image) = self.shots.1.try_recv() {
            match next_free(&plan.folder, NAMES[0]) {
                Ok(path) => {
                    self.window = Some(Task::start("Window", wake(ctx), move |control| {
                        write_window(&path, &image).map_err(|error| error.to_string())?;
                        control.send(path);
                        Ok(())
                    }));
                }
                Err(message) => notice.fail(message),
            }
        }
        for task in [&mut self.task, &mut self.window] {
            for event in task.as_ref().map(Task::events).unwrap_or_default() {
                match event {
                    TaskEvent::Result(path) => {
                        notice.tell(format!("Written: {}", path.display()));
                        continue;
                    }
                    TaskEvent::Failed(message) => notice.fail(message),
                    TaskEvent::Cancelled => notice.tell("Cancelled; nothing was written"),
                    TaskEvent::Done => {}
                }
                *task = None;
            }
        }
    }

    /// Stops what is being written.
    pub(crate) fn cancel(&self) {
        self.task.iter().for_each(Task::cancel);
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
        self.task = Some(Task::start("Export", wake(ctx), move |control| {
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
        }));
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
        if let Some(task) = &self.task {
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
