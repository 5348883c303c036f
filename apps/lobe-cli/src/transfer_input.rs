//! Transfer named on the command line.

use std::ffi::OsString;
use std::path::PathBuf;

use lobe::prt::{Transfer, read_baked, read_transfer};

/// A file that carries transfer: a baked scene, or `.safetensors`.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct TransferInput(PathBuf);

impl From<OsString> for TransferInput {
    fn from(text: OsString) -> Self {
        Self(text.into())
    }
}

impl TransferInput {
    /// Reads it; of a scene the transfer of its vertices, mesh by mesh.
    pub(crate) fn read(&self) -> anyhow::Result<Transfer> {
        let is_tensors = self.0.extension().is_some_and(|e| e.eq_ignore_ascii_case("safetensors"));
        Ok(if is_tensors { read_transfer(&self.0)?.0 } else { read_baked(&self.0)?.transfer })
    }
}
