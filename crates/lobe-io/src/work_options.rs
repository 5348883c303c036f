//! Options that all long work has: limits, what is left of earlier runs, and sharing among machines.

use std::path::{Path, PathBuf};

use crate::error::IoError;
use crate::job_files::JobFiles;
use crate::memory_limit::MemoryLimit;
use crate::options;
use crate::options::field::{OptionError, OptionField};
use crate::options::job_options::{Given, GivenPaths, JobOptions};
use crate::options::kind::{NumberRange, OptionKind};
use crate::shard::Shard;

options! {
    /// How work is run on this machine.
    pub struct WorkOptions {
        /// The most memory, in GiB, of the scene with its instances and its tree, and of work and files beside it. More
        /// is refused. 4 hold some 12 million triangles, which take about a minute to read; each instance counts
        max_memory: f64 = MemoryLimit::DEFAULT_GIB, OptionKind::Number(NumberRange::Positive), "GIB", "";
        /// Start anew, even if there is a checkpoint of work that was stopped
        fresh: bool = false, OptionKind::Flag, "", "";
    }
}

options! {
    /// How work is shared among machines.
    pub struct SharingOptions {
        /// Do part I of N of the work, and write it as a shard, a .safetensors file. A stop leaves what is done, and
        /// the same job goes on from there
        shard: Option<Shard> = None, OptionKind::Shard, "I/N", "";
        /// Take the work from these files, which are all shards of the same job on any machines: the output has the
        /// bytes that one machine alone gives it
        #[serde(serialize_with = "crate::as_texts")]
        merge: Option<Vec<PathBuf>> = None, OptionKind::Files, "PART", "";
    }
}

impl JobOptions for WorkOptions {
    fn fields() -> Vec<&'static OptionField> {
        Self::FIELDS.iter().collect()
    }
}

impl WorkOptions {
    /// The limit of memory.
    #[must_use]
    pub fn memory(&self) -> MemoryLimit {
        MemoryLimit::of(self.max_memory)
    }
}

impl JobOptions for SharingOptions {
    fn fields() -> Vec<&'static OptionField> {
        Self::FIELDS.iter().collect()
    }

    fn heading_of(_name: &str) -> Option<&'static str> {
        Some("Sharing among machines")
    }

    fn set_paths(&mut self, given: GivenPaths<'_>) {
        self.merge = given("merge").or(self.merge.take());
    }

    fn check_together(&self, _given: &Given<'_>) -> Result<(), OptionError> {
        match (&self.shard, &self.merge) {
            (Some(_), Some(_)) => Err(OptionError::new("merge", "not with @shard; leave one of them out")),
            _ => Ok(()),
        }
    }
}

impl SharingOptions {
    /// The option that is given, if one is.
    #[must_use]
    pub fn asked(&self) -> Option<&'static str> {
        self.shard.map(|_| "shard").or(self.merge.as_ref().map(|_| "merge"))
    }

    /// The shards that are put together.
    #[must_use]
    pub fn parts(&self) -> &[PathBuf] {
        self.merge.as_deref().unwrap_or_default()
    }

    /// The files of work with this output.
    ///
    /// # Errors
    /// [`IoError::OfJob`] without an output.
    pub fn files(&self, output: Option<&Path>) -> Result<JobFiles, IoError> {
        JobFiles::of(output, self.shard, self.merge.is_some())
    }
}
