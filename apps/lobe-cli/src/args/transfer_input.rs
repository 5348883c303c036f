//! Transfer as an input: baked scenes and .safetensors files.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::bail;
use clap::Args;
use lobe::prt::{BYTES_FOR_EACH, Recipe, Transfer, read_baked, read_transfer};

use crate::args::memory::MemoryLimit;
use crate::args::output::has_extension;
use crate::args::scene_limits::SceneLimits;

/// A file that carries transfer.
#[derive(Args)]
pub(crate) struct TransferInput {
    /// A baked scene (.glb), or transfer alone (.safetensors)
    #[arg(value_name = "IN")]
    path: PathBuf,
    #[command(flatten)]
    limits: SceneLimits,
    #[command(flatten)]
    memory: MemoryLimit,
}

impl TransferInput {
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Reads it, of a scene the transfer of its vertices, mesh by mesh; and the recipe of its bake. `bytes_of_work` is what the work
    /// on it takes in memory, all that was read included.
    pub(crate) fn read(&self, bytes_of_work: impl Fn(&Transfer) -> usize) -> anyhow::Result<(Transfer, Recipe)> {
        let name = self.path.display().to_string();
        let check = |bytes: u64| self.memory.check(&name, bytes, "a bake of fewer receivers or a lower order");
        // Of a file that is not there, reading says so.
        check(BYTES_FOR_EACH.saturating_mul(fs::metadata(&self.path).map_or(0, |file| file.len())))?;
        let (transfer, recipe) = if has_extension(&self.path, "safetensors") {
            if let Some(option) = self.limits.given() {
                bail!("{option}: only of baked scenes; leave the option out");
            }
            read_transfer(&self.path)?
        } else {
            let baked = read_baked(&self.path, &self.limits.options(&self.memory))?;
            (baked.transfer, baked.recipe)
        };
        check(bytes_of_work(&transfer) as u64)?;
        Ok((transfer, recipe))
    }
}
