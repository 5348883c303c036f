//! The cache of bakes of built-in scenes.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};

use lobe::io::{Fingerprint, Job};
use lobe::prt::{BakeOptions, Recipe, Transfer, read_transfer, scene_hash, write_transfer};
use lobe::scene::Scene;

/// Says where files of the viewer are instead of the user's own folder.
const FOLDER_VARIABLE: &str = "LOBE_VIEWER_FOLDER";

/// The name of the viewer among programs.
const OWN: &str = "lobe-viewer";

/// The kind of these fingerprints.
const KIND: u64 = 0x1e3;

/// Files of the viewer: bakes, and what the window remembers. Everything in it can be removed at any time.
#[derive(Clone, Debug, PartialEq)]
pub struct UserFolder {
    folder: Option<PathBuf>,
}

impl UserFolder {
    /// The folder of the user: `$LOBE_VIEWER_FOLDER`, or `lobe-viewer` in `$XDG_CACHE_HOME`, `~/.cache`, `~/Library/Caches` or
    /// `%LOCALAPPDATA%`. Where there is none of these, nothing is kept.
    #[must_use]
    pub fn of_user() -> Self {
        let own = env::var_os(FOLDER_VARIABLE).map(PathBuf::from);
        let set = |name: &str| env::var_os(name).map(PathBuf::from).filter(|path| path.is_absolute());
        let home =
            || set("HOME").map(|home| home.join(if cfg!(target_os = "macos") { "Library/Caches" } else { ".cache" }));
        let caches = || set("XDG_CACHE_HOME").or_else(|| set("LOCALAPPDATA")).or_else(home);
        Self { folder: own.or_else(|| caches().map(|caches| caches.join(OWN))) }
    }

    /// This folder.
    #[must_use]
    pub fn at(folder: impl Into<PathBuf>) -> Self {
        Self { folder: Some(folder.into()) }
    }

    /// No folder: nothing is kept.
    #[must_use]
    pub fn none() -> Self {
        Self { folder: None }
    }

    /// A file in it; makes the folder.
    pub(crate) fn file(&self, name: &str) -> Option<PathBuf> {
        let folder = self.folder.as_deref()?;
        fs::create_dir_all(folder).ok()?;
        Some(folder.join(name))
    }

    /// The bake of a scene with these options, if it was kept.
    pub(crate) fn kept_bake(&self, scene: &Scene, options: &BakeOptions) -> Option<Transfer> {
        let path = self.bake_file(scene, options)?;
        let (transfer, _) = read_transfer(path).ok()?;
        (transfer.receivers() == scene.vertex_count() && transfer.order() == options.order).then_some(transfer)
    }

    /// Keeps a bake. That it cannot is no error: it is made again.
    pub(crate) fn keep_bake(&self, scene: &Scene, options: &BakeOptions, transfer: &Transfer, recipe: &Recipe) {
        if let Some(path) = self.bake_file(scene, options) {
            drop(write_transfer(path, transfer, recipe, Job::default()));
        }
    }

    fn bake_file(&self, scene: &Scene, options: &BakeOptions) -> Option<PathBuf> {
        let mut fingerprint = Fingerprint::of_kind(KIND);
        fingerprint.bytes(scene_hash(scene).as_bytes());
        fingerprint.bytes(serde_json::to_string(options).ok()?.as_bytes());
        fingerprint.bytes(env!("CARGO_PKG_VERSION").as_bytes());
        self.file(&format!("{fingerprint}.safetensors"))
    }
}

/// The text of a file of the viewer; none if there is none.
pub(crate) fn read_text(path: &Path) -> Option<String> {
    fs::read_to_string(path).ok()
}
