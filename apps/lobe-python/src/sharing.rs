//! Sharing long work among machines: shards of it, and putting them together.

use std::fs;
use std::path::{Path, PathBuf};

use lobe::io::{Shard, merge_shards};
use pyo3::prelude::*;

use crate::job::watched;
use crate::outputs::prepare;
use crate::rows::value_error;

/// A shard of work in a file, its number from 1 on and how many there are; or a file for what is put together, and the shards.
#[derive(FromPyObject)]
pub(crate) enum Share {
    Shard(PathBuf, (u32, u32)),
    Merge(PathBuf, Vec<PathBuf>),
}

impl Share {
    /// Refuses what cannot be written, and puts shards together.
    pub(crate) fn begin(&self, py: Python<'_>, inputs: &[&Path], progress: Option<&Py<PyAny>>) -> PyResult<()> {
        match self {
            Self::Shard(output, _) => prepare(output, &["safetensors"], inputs),
            Self::Merge(checkpoint, parts) => merge(py, parts, checkpoint, progress),
        }
    }

    /// The shard, if it is one.
    pub(crate) fn shard(&self) -> PyResult<Option<Shard>> {
        match self {
            Self::Shard(_, (number, count)) => shard_of(*number, *count).map(Some),
            Self::Merge(..) => Ok(None),
        }
    }

    /// The file that results are kept in.
    pub(crate) fn file(&self) -> &Path {
        match self {
            Self::Shard(file, _) | Self::Merge(file, _) => file,
        }
    }

    /// The outcome of work on shards. Where those that were put together are of other work, the first of them is named.
    pub(crate) fn outcome<T>(&self, py: Python<'_>, outcome: PyResult<T>) -> PyResult<T> {
        match self {
            Self::Shard(..) => outcome,
            Self::Merge(checkpoint, parts) => outcome.map_err(|error| of_merged(py, error, parts, checkpoint)),
        }
    }
}

pub(crate) fn shard_of(number: u32, count: u32) -> PyResult<Shard> {
    Shard::new(number, count)
        .ok_or_else(|| value_error(format!("shard: expected one of {count} from 1 on, found {number}")))
}

/// Puts shards together as a checkpoint.
pub(crate) fn merge(
    py: Python<'_>,
    parts: &[PathBuf],
    checkpoint: &Path,
    progress: Option<&Py<PyAny>>,
) -> PyResult<()> {
    watched(py, progress, None, |job| merge_shards(parts, checkpoint, job))
}

/// The error of work that took up shards, whose checkpoint is of no use then: it is made again in no time, and would be in the way of other work.
pub(crate) fn of_merged(py: Python<'_>, error: PyErr, parts: &[PathBuf], checkpoint: &Path) -> PyErr {
    let _ = fs::remove_file(checkpoint);
    let at_checkpoint = format!("{}: ", checkpoint.display());
    match parts.first() {
        Some(part) if error.value(py).to_string().starts_with(&at_checkpoint) => value_error(format!(
            "{}: this shard and the others are not of this work: the scene, options that decide the numbers or the version of Lobe differ",
            part.display()
        )),
        _ => error,
    }
}
