//! Options of jobs as tables: a name, a kind, a default and words for each, of which every front makes its own.
//!
//! Read `kind` first, the values that an option may have; then `field`, an option in the table; then `job_options`, a
//! struct whose fields are such a table. `path_text` is for options that are paths, and `job_args` makes
//! arguments of a table. Uses no other room.

pub(crate) mod field;
#[cfg(feature = "clap")]
pub(crate) mod job_args;
pub(crate) mod job_options;
pub(crate) mod kind;
pub(crate) mod path_text;
