//! A room of the window, as the window handles all of them alike.

use std::path::Path;

use eframe::egui::Ui;
use lobe::env::SunChoice;

use crate::loading::file_kind::FileKind;
use crate::loading::limits::ReadLimits;
use crate::loading::sky_source::OpenedSky;
use crate::widgets::gpu::Gpu;
use crate::widgets::history::{Can, Step};
use lobe::render::Surfaces;

/// A room.
pub(crate) trait Room {
    /// Shows it, under the sky of the room of scenes.
    fn ui(&mut self, ui: &mut Ui, gpu: Option<&Gpu>, sky: Option<&OpenedSky>);

    /// What can be done with its changes.
    fn can(&self) -> Can;

    /// Takes a change back, or makes it again.
    fn step(&mut self, step: Step);

    /// Kinds of files that are seen in it.
    fn shows(&self) -> &'static [FileKind];

    /// Opens a file of a kind that it shows; false leaves it to the other rooms.
    fn open(&mut self, path: &Path, kind: FileKind) -> anyhow::Result<bool>;

    /// Whether the user asked for a file since the last time.
    fn take_wish_for_file(&mut self) -> bool {
        false
    }

    /// Frees what the device holds of its pictures.
    fn forget_pictures(&mut self, _: &Gpu) {}

    /// Looks for these suns in skies that are opened from now on.
    fn look_for_suns(&mut self, _: &SunChoice) {}

    /// Shows surfaces by this model.
    fn reflect_by(&mut self, _: Surfaces) {}

    /// Reads files within these limits from now on.
    fn read_within(&mut self, _: ReadLimits) {}
}
