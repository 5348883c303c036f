//! Files that were dropped on the window, which are there at once.

use std::cell::RefCell;
use std::path::PathBuf;

use eframe::egui::{Context, DroppedFileHandle};

/// Files that were dropped.
#[derive(Debug, Default)]
pub(crate) struct Drops {
    read: RefCell<Vec<Result<PathBuf, String>>>,
}

impl Drops {
    /// Takes what was dropped.
    pub(crate) fn begin(&self, _ctx: &Context, files: Vec<DroppedFileHandle>) {
        self.read.borrow_mut().extend(files.into_iter().map(|file| Ok(file.path().to_path_buf())));
    }

    /// What has come since this was asked last, by names.
    pub(crate) fn take(&self) -> Vec<Result<PathBuf, String>> {
        self.read.take()
    }
}
