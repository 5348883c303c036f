//! Long work that is watched, stopped and continued.

use std::fs;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, bail};
use indicatif::ProgressBar;
use lobe::prt::{Progress, PrtError};

use crate::ctrl_c;
use crate::talk::Talk;

/// What a bake calls while it works.
pub(crate) type OnProgress<'a> = &'a mut dyn FnMut(&Progress) -> ControlFlow<()>;

/// Where a bake keeps what is done so far: beside its output.
pub(crate) struct Checkpoint {
    path: PathBuf,
}

impl Checkpoint {
    pub(crate) fn beside(output: &Path) -> Self {
        let mut name = output.to_path_buf().into_os_string();
        name.push(".checkpoint");
        Self { path: name.into() }
    }

    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Forgets earlier work.
    pub(crate) fn discard(&self) -> anyhow::Result<()> {
        if self.path.exists() {
            fs::remove_file(&self.path).with_context(|| format!("{}: cannot be removed", self.path.display()))?;
        }
        Ok(())
    }

    /// To be called when the results are safe.
    pub(crate) fn finish(&self) {
        // One that cannot be removed is found to be done by the next bake, which then takes no time.
        let _ = fs::remove_file(&self.path);
    }

    /// Does the work, with a bar where somebody is watching, until it is done or somebody presses Ctrl-C.
    pub(crate) fn watched<T>(
        &self,
        talk: Talk,
        work: impl FnOnce(&Path, OnProgress<'_>) -> Result<T, PrtError>,
    ) -> anyhow::Result<T> {
        ctrl_c::watch();
        let bar = talk.bar("bake", 1);
        let (mut done, mut total, mut is_told) = (0, 0, false);
        let result = work(&self.path, &mut |progress| {
            if !is_told && progress.resumed > 0 {
                let percent = 100 * progress.resumed / progress.total.max(1);
                talk.note(&self.path.display().to_string(), &format!("found; going on from {percent} %"));
            }
            (done, total, is_told) = (progress.done, progress.total, true);
            show(&bar, "bake", progress);
            ctrl_c::go_on()
        });
        bar.finish_and_clear();
        match result {
            Err(PrtError::Cancelled) => {
                bail!(
                    "stopped after {done} of {total} points; the same command goes on from there, --fresh starts anew"
                )
            }
            other => Ok(other?),
        }
    }

    /// Refuses to begin what could not be kept: an output of so many bytes beside a checkpoint of so many, of which it may have some.
    pub(crate) fn check_room(&self, output: &Path, bytes: u64, checkpoint: u64) -> anyhow::Result<()> {
        let folder = match output.parent() {
            Some(folder) if folder != Path::new("") => folder,
            _ => Path::new("."),
        };
        // Where the system does not say how much is left, writing shows it.
        let Ok(free) = fs4::available_space(folder) else { return Ok(()) };
        let there = fs::metadata(&self.path).map_or(0, |found| found.len());
        let needed = bytes.saturating_add(checkpoint.saturating_sub(there));
        if free < needed {
            let [needed, free] = [needed, free].map(|bytes| bytes.div_ceil(1 << 20));
            bail!(
                "{}: expected {needed} MiB of free space for it and its checkpoint, found {free}: make room, or write \
                 somewhere else",
                output.display()
            );
        }
        Ok(())
    }
}

pub(crate) fn show(bar: &ProgressBar, what: &str, progress: &Progress) {
    bar.set_length(progress.total as u64);
    bar.set_position(progress.done as u64);
    bar.set_message(format!("{what} {:.2} Mrays/s", progress.rays_per_second() / 1e6));
}
