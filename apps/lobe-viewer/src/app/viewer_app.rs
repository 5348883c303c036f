//! The application: the bar, and the room that is open.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use eframe::egui::{
    Align2, Area, Context, Frame, Id, Key, KeyboardShortcut, Modifiers, Panel, ThemePreference, Ui, ViewportCommand,
};
use lobe::env::SunChoice;
use lobe::image::FileFormat;
use lobe::scene::SceneFormat;

use crate::app::bar::{BarAsked, bar};
#[cfg(not(target_arch = "wasm32"))]
use crate::app::drops::Drops;
use crate::app::exports::Exports;
use crate::app::help::help;
use crate::app::kept::{Kept, Theme, ZOOMS, is_window};
#[cfg(target_arch = "wasm32")]
use crate::app::page_drops::Drops;
use crate::loading::cache::UserFolder;
use crate::loading::export::ExportPlan;
use crate::loading::file_kind::{self, FileKind, TENSORS};
use crate::loading::limits::ReadLimits;
use crate::loading::place::IN_PAGE;
use crate::rooms::functions::functions_room::FunctionsRoom;
use crate::rooms::motion::motion_room::MotionRoom;
use crate::rooms::rooms::{RoomName, Rooms};
use crate::rooms::scene::scene_room::SceneRoom;
use crate::rooms::sky::sky_room::SkyRoom;
use crate::widgets::file_list::FileList;
use crate::widgets::gpu::Gpu;
use crate::widgets::history::Step;
use crate::widgets::notice::Notice;
use lobe::render::Surfaces;

/// Seconds between two times at which what changed is kept.
const KEEP_EVERY: f64 = 3.0;

/// The viewer.
pub struct ViewerApp {
    kept: Kept,
    written: Kept,
    written_at: f64,
    folder: UserFolder,
    gpu: Option<Gpu>,
    rooms: Rooms,
    files: FileList,
    drops: Drops,
    limits: ReadLimits,
    suns: SunChoice,
    exports: Exports,
    notice: Notice,
    lost: Arc<AtomicBool>,
    is_help_open: bool,
    applied: Option<(Theme, f32)>,
}

impl ViewerApp {
    /// The viewer as it was left, with files to open. Without a device the rooms show what needs none.
    #[must_use]
    pub fn new(gpu: Option<Gpu>, folder: UserFolder, files: &[PathBuf]) -> Self {
        let kept = Kept::read(&folder);
        let mut app = Self::with(kept, gpu, folder);
        files.iter().for_each(|file| app.open(file));
        app
    }

    fn with(kept: Kept, gpu: Option<Gpu>, folder: UserFolder) -> Self {
        let exports = Exports::new(&kept.export);
        Self {
            rooms: Rooms::new(kept.rooms.clone(), folder.clone()),
            written: kept.clone(),
            written_at: 0.0,
            kept,
            folder,
            gpu,
            files: FileList::default(),
            drops: Drops::default(),
            limits: ReadLimits::default(),
            suns: SunChoice::Auto,
            exports,
            notice: Notice::default(),
            lost: Arc::default(),
            is_help_open: false,
            applied: None,
        }
    }

    /// The room of scenes.
    #[must_use]
    pub fn scene(&self) -> &SceneRoom {
        &self.rooms.scene
    }

    /// The room of functions.
    #[must_use]
    pub fn functions(&self) -> &FunctionsRoom {
        &self.rooms.functions
    }

    /// The room of skies.
    #[must_use]
    pub fn sky(&self) -> &SkyRoom {
        &self.rooms.sky
    }

    /// The room that is open.
    #[must_use]
    pub fn room(&self) -> RoomName {
        self.kept.room
    }

    /// Where pictures are written to, and how large they are.
    pub fn export_plan_mut(&mut self) -> &mut ExportPlan {
        &mut self.kept.export
    }

    /// What was done or went wrong last, in one line.
    #[must_use]
    pub fn notice(&self) -> Option<&str> {
        self.notice.text()
    }

    fn open(&mut self, path: &Path) {
        let is_on_disk = path.exists();
        // Built-in scenes and skies have no ending.
        let text = path.to_string_lossy();
        if text.starts_with("built-in:") {
            self.rooms.scene.edits_mut().scene = path.into();
        } else if text.starts_with("made:") || text.starts_with("bundled:") {
            self.rooms.scene.edits_mut().sky = path.into();
        } else {
            self.open_file(path);
        }
        if is_on_disk {
            self.kept.remember(path);
        }
    }

    /// Opens a file in the room that shows it.
    fn open_file(&mut self, path: &Path) {
        let kind = match FileKind::of(path) {
            Ok(kind) => kind,
            Err(message) => return self.notice.fail(message),
        };
        match self.rooms.open(self.kept.room, path, kind) {
            Ok(room) => self.kept.room = room,
            Err(error) => self.notice.fail(error.to_string()),
        }
    }

    /// The same viewer with other limits of reading.
    #[must_use]
    pub fn reading_within(mut self, limits: ReadLimits) -> Self {
        self.rooms.each(|room| room.read_within(limits));
        Self { limits, ..self }
    }

    /// The same viewer with surfaces by another model, if any.
    #[must_use]
    pub fn reflecting_by(mut self, surfaces: Option<Surfaces>) -> Self {
        surfaces.into_iter().for_each(|surfaces| self.rooms.each(|room| room.reflect_by(surfaces)));
        self
    }

    /// The same viewer with other suns that are looked for in skies.
    #[must_use]
    pub fn looking_for_suns(mut self, suns: SunChoice) -> Self {
        self.rooms.each(|room| room.look_for_suns(&suns));
        Self { suns, ..self }
    }

    /// The room of motion.
    #[must_use]
    pub fn motion(&self) -> &MotionRoom {
        &self.rooms.motion
    }

    fn answer(&mut self, ctx: &Context, asked: BarAsked) {
        match asked {
            BarAsked::Open => self.list_files(),
            BarAsked::OpenRecent(path) => self.open(&path),
            BarAsked::Step(step) => self.rooms.get_mut(self.kept.room).step(step),
            BarAsked::Export => self.exports.toggle(),
            BarAsked::Shoot => self.exports.shoot(ctx),
            BarAsked::Help => self.is_help_open = !self.is_help_open,
            BarAsked::Reset => self.reset(ctx),
        }
    }

    /// Makes everything as at the first start. What is being written is written to its end, and what was said remains.
    fn reset(&mut self, ctx: &Context) {
        if let Some(gpu) = &self.gpu {
            self.rooms.each(|room| room.forget_pictures(gpu));
        }
        let kept = Kept { recent: self.kept.recent.clone(), room: self.kept.room, ..Kept::default() };
        let (lost, limits, suns) = (self.lost.clone(), self.limits, self.suns.clone());
        let first = Self::with(kept, self.gpu.take(), self.folder.clone());
        let first = first.reporting_loss_to(lost).reading_within(limits).looking_for_suns(suns);
        let before = std::mem::replace(self, first);
        self.exports = before.exports.with_plan(&self.kept.export);
        self.notice = before.notice;
        ctx.request_repaint();
    }

    /// Opens the list of files; a page has none.
    fn list_files(&mut self) {
        if IN_PAGE {
            self.notice.fail("Drop a file on the page to open it");
        } else {
            self.files.open(&endings());
        }
    }

    fn keys(&mut self, ctx: &Context) {
        self.files.keys(ctx);
        let pressed = |modifiers: Modifiers, key: Key| {
            ctx.input_mut(|input| input.consume_shortcut(&KeyboardShortcut::new(modifiers, key)))
        };
        for room in RoomName::ALL {
            if pressed(Modifiers::COMMAND, room.key()) {
                self.kept.room = room;
            }
        }
        let redo = pressed(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z) || pressed(Modifiers::COMMAND, Key::Y);
        let asked = [
            (redo, BarAsked::Step(Step::Redo)),
            (pressed(Modifiers::COMMAND, Key::Z), BarAsked::Step(Step::Undo)),
            (pressed(Modifiers::COMMAND, Key::O), BarAsked::Open),
            (!IN_PAGE && pressed(Modifiers::COMMAND, Key::E), BarAsked::Export),
            (!IN_PAGE && pressed(Modifiers::NONE, Key::F12), BarAsked::Shoot),
            (pressed(Modifiers::NONE, Key::F1), BarAsked::Help),
        ];
        asked.into_iter().filter(|(is_pressed, _)| *is_pressed).for_each(|(_, asked)| self.answer(ctx, asked));
        if pressed(Modifiers::COMMAND, Key::Plus) || pressed(Modifiers::COMMAND, Key::Equals) {
            self.kept.zoom = (self.kept.zoom + 0.25).min(*ZOOMS.end() as f32);
        }
        if ctx.input(|input| input.key_pressed(Key::Escape)) {
            self.exports.cancel();
        }
        if pressed(Modifiers::COMMAND, Key::Minus) {
            self.kept.zoom = (self.kept.zoom - 0.25).max(*ZOOMS.start() as f32);
        }
    }

    fn apply_looks(&mut self, ctx: &Context) {
        let looks = (self.kept.theme, self.kept.zoom);
        if self.applied == Some(looks) {
            return;
        }
        ctx.set_theme(match self.kept.theme {
            Theme::System => ThemePreference::System,
            Theme::Dark => ThemePreference::Dark,
            Theme::Light => ThemePreference::Light,
        });
        // Ctrl and plus are keys of the viewer, which remembers the size.
        ctx.options_mut(|options| options.zoom_with_keyboard = false);
        ctx.set_zoom_factor(self.kept.zoom);
        self.applied = Some(looks);
    }

    fn take_drops(&mut self, ctx: &Context) {
        self.drops.begin(ctx, ctx.input(|input| input.raw.dropped_files.clone()));
        for read in self.drops.take() {
            let path = match read {
                Ok(path) => path,
                Err(message) => {
                    self.notice.fail(message);
                    continue;
                }
            };
            self.open(&path);
        }
        if ctx.input(|input| !input.raw.hovered_files.is_empty()) {
            Area::new(Id::unique("drop")).anchor(Align2::CENTER_CENTER, [0.0, 0.0]).show(ctx, |ui| {
                Frame::popup(ui.style()).show(ui, |ui| ui.heading("Drop a scene, a sky, an expansion or a bake"));
            });
        }
    }

    fn keep(&mut self, ctx: &Context) {
        let (now, size) = ctx.input(|input| (input.time, input.viewport_rect().size()));
        let size = [size.x, size.y].map(|points| points * ctx.zoom_factor());
        // A window that is being closed or laid aside has no size of its own.
        self.kept.size = Some(size).filter(|size| is_window(*size)).or(self.kept.size);
        self.kept.rooms = self.rooms.kept();
        if now - self.written_at >= KEEP_EVERY && self.kept != self.written {
            self.write();
            self.written_at = now;
        }
    }

    fn write(&mut self) {
        self.kept.write(&self.folder);
        self.written = self.kept.clone();
    }

    /// Says by `lost` that the device of the window is gone, whereupon the window closes, to be opened again.
    #[must_use]
    pub fn reporting_loss_to(self, lost: Arc<AtomicBool>) -> Self {
        Self { lost, ..self }
    }

    /// Says what went wrong, until it is closed. A page has no other window that was lost.
    #[cfg(not(target_arch = "wasm32"))]
    pub(crate) fn complain(&mut self, text: impl Into<String>) {
        self.notice.fail(text);
    }

    /// Whether the device is gone. Then nothing may be drawn: the library of the window panics on triangles without a device.
    fn gives_up(&self, ctx: &Context) -> bool {
        let is_lost = self.gpu.as_ref().is_some_and(|gpu| gpu.context().is_lost());
        if is_lost {
            self.lost.store(true, Ordering::Relaxed);
            ctx.send_viewport_cmd(ViewportCommand::Close);
        }
        is_lost
    }

    /// Shows all of it in a window; nothing on a device that was lost.
    pub fn show(&mut self, ui: &mut Ui) {
        let ctx = ui.ctx().clone();
        if self.gives_up(&ctx) {
            return;
        }
        self.apply_looks(&ctx);
        self.keys(&ctx);
        self.take_drops(&ctx);
        if let Some(gpu) = &self.gpu {
            self.rooms.scene.fit_skies(gpu);
        }
        self.rooms.scene.advance(&ctx);
        self.exports.advance(&ctx, &self.kept.export, &mut self.notice);
        let mut wants_file = false;
        self.rooms.each(|room| wants_file |= room.take_wish_for_file());
        if wants_file {
            self.list_files();
        }
        let can = self.rooms.get_mut(self.kept.room).can();
        let mut asked = None;
        Panel::top("bar").show(ui, |ui| asked = bar(ui, &mut self.kept, can));
        if let Some(asked) = asked {
            self.answer(&ctx, asked);
        }
        self.rooms.ui(self.kept.room, ui, self.gpu.as_ref());
        help(&ctx, &mut self.is_help_open);
        let (scene, plan, gpu) = (&mut self.rooms.scene, &mut self.kept.export, self.gpu.as_ref());
        self.exports.show(&ctx, plan, gpu, || scene.export(), &mut self.notice);
        self.notice.show(&ctx);
        if let Some(path) = self.files.show(&ctx, &endings()) {
            self.open(&path);
        }
        self.keep(&ctx);
    }
}

/// Endings of all files that can be opened.
fn endings() -> Vec<&'static str> {
    let scenes = SceneFormat::ALL.into_iter().flat_map(SceneFormat::endings);
    let skies = FileFormat::ALL.into_iter().flat_map(FileFormat::endings);
    scenes.chain([&file_kind::DESCRIPTION]).chain(skies).chain([&TENSORS]).copied().collect()
}

impl eframe::App for ViewerApp {
    fn ui(&mut self, ui: &mut Ui, _frame: &mut eframe::Frame) {
        self.show(ui);
    }

    fn on_exit(&mut self) {
        self.write();
        self.exports.finish(&self.kept.export);
    }
}
