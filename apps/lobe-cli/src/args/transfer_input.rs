//! Transfer as an input: baked scenes and .safetensors files.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use lobe::prt::{Recipe, Transfer, read_baked, read_transfer};
use lobe::scene::SceneReadOptions;

use crate::args::output::has_extension;

/// A file that carries transfer: a baked scene, or `.safetensors`.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct TransferInput(PathBuf);

impl From<OsString> for TransferInput {
    fn from(text: OsString) -> Self {
        Self(text.into())
    }
}

impl TransferInput {
    pub(crate) fn path(&self) -> &Path {
        &self.0
    }

    /// Reads it, of a scene the transfer of its vertices, mesh by mesh; and the recipe of its bake.
    pub(crate) fn read(&self) -> anyhow::Result<(Transfer, Recipe)> {
        if has_extension(&self.0, "safetensors") {
            return Ok(read_transfer(&self.0)?);
        }
        let baked = read_baked(&self.0, &SceneReadOptions::default())?;
        Ok((baked.transfer, baked.recipe))
    }
}
