//! Long work and its results on disk: what several crates of Lobe need for running, stopping and keeping it.
//!
//! | to | use |
//! |---|---|
//! | write a file all or nothing | [`write_atomically`]; piece by piece [`StagedWriter`]; several at once [`StagedFile`] |
//! | read a file, and say which if that fails | [`read_file`] |
//! | watch, stop and continue long work | [`Job`], [`Progress`]; between two reports [`Portions`] |
//! | tell one piece of work from another | [`Fingerprint`] |
//! | keep its results in a checkpoint and continue from it | [`RecordFile`], read by [`RecordReader`] |
//! | share it among machines | [`Shard`], [`merge_shards`] |
//! | do it on all processors (feature `parallel`) | `parallel` |
//! | write and read named tensors with a header (feature `tensors`) | `write_tensors`, `TensorFile` |
//! | learn before long work whether its result can be written | [`check_writable`] |
//! | clear away what programs that were killed have left, or would leave | [`remove_abandoned`]; [`before_writing`], [`remove_unfinished`] |
//! | refuse a pipe where a file is named | [`expect_file`] |
//! | have large arrays on huge pages | [`HugePages`], [`choose_huge_pages`] |
//! | have options in one table for every front (feature `options`) | `options!`, `JobOptions`, `OptionField`, `OptionError`, `worded`; `WorkOptions`, `SharingOptions` |
//! | take them from a command line (feature `clap`) | `JobArgs` |
//! | keep results beside an output until it is written (feature `options`) | `JobFiles` |
//! | refuse work that takes too much memory, or room on the disk (feature `options`) | `MemoryLimit`, `expect_room` |
//! | print what a file says in one line that no character turns around | [`one_line`] |

mod endings;
mod error;
mod fingerprint;
mod huge_pages;
mod job;
#[cfg(feature = "options")]
mod job_files;
#[cfg(feature = "options")]
mod memory_limit;
mod one_line;
#[cfg(feature = "options")]
mod options;
#[cfg(feature = "parallel")]
pub mod parallel;
mod portions;
mod records;
#[cfg(feature = "options")]
mod room;
mod shard;
mod staged;
#[cfg(feature = "tensors")]
mod tensors;
#[cfg(feature = "options")]
mod work_options;

pub use endings::{either, named_endings};
pub use error::{IoError, expect_file, read_file};
pub use fingerprint::Fingerprint;
pub use huge_pages::{HugePages, choose_huge_pages};
pub use job::{Job, Listener, Progress, Watch};
#[cfg(feature = "options")]
pub use job_files::JobFiles;
#[cfg(feature = "options")]
pub use memory_limit::MemoryLimit;
pub use one_line::one_line;
#[cfg(feature = "options")]
pub use options::field::{OptionError, OptionField, worded};
#[cfg(feature = "clap")]
pub use options::job_args::{JobArgs, flag, option};
#[cfg(feature = "options")]
pub use options::job_options::{Given, GivenPaths, JobOptions};
#[cfg(feature = "options")]
pub use options::kind::{NumberRange, OptionKind, Refusal};
#[cfg(feature = "options")]
pub use options::path_text::{as_text, as_text_if_any, as_texts};
pub use portions::Portions;
pub use records::layout::{RecordFormat, RecordLayout};
pub use records::merge::merge_shards;
pub use records::record_file::RecordFile;
pub use records::record_reader::RecordReader;
#[cfg(feature = "options")]
pub use room::expect_room;
pub use shard::Shard;
pub use staged::{
    StagedFile, StagedWriter, before_writing, check_writable, remove_abandoned, remove_unfinished, write_atomically,
};
#[cfg(feature = "tensors")]
pub use tensors::{Dtype, Numbers, Tensor, TensorFile, TensorFormat, write_tensors};
#[cfg(feature = "options")]
pub use work_options::{SharingOptions, WorkOptions};
