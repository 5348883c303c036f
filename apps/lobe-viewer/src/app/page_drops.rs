//! Files that were dropped on a page, which a browser reads while the page goes on: as `drops` in a window.

use std::cell::RefCell;
use std::path::PathBuf;
use std::rc::Rc;

use eframe::egui::{Context, DroppedFileHandle};
use wasm_bindgen_futures::spawn_local;

use crate::loading::place::give_file;

/// Files that were dropped on the page, read while it goes on.
#[derive(Clone, Debug, Default)]
pub(crate) struct Drops {
    read: Rc<RefCell<Vec<Result<PathBuf, String>>>>,
}

impl Drops {
    /// Begins to read what was dropped.
    pub(crate) fn begin(&self, ctx: &Context, files: Vec<DroppedFileHandle>) {
        for file in files {
            let (read, ctx) = (self.read.clone(), ctx.clone());
            spawn_local(async move {
                let path = file.path().to_path_buf();
                let given = file.bytes_async().await;
                read.borrow_mut().push(given.map(|bytes| {
                    give_file(&path, bytes);
                    path
                }));
                ctx.request_repaint();
            });
        }
    }

    /// What has been read since this was asked last: the names of files that are [given](give_file).
    pub(crate) fn take(&self) -> Vec<Result<PathBuf, String>> {
        std::mem::take(&mut self.read.borrow_mut())
    }
}
