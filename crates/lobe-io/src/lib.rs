//! Files that are never half-written: what several crates of Lobe need for keeping results on disk.
//!
//! | to | use |
//! |---|---|
//! | write a file all or nothing | [`write_atomically`]; piece by piece [`StagedWriter`]; several at once [`StagedFile`] |
//! | learn before long work whether its result can be written | [`check_writable`] |

mod staged;

pub use staged::{StagedFile, StagedWriter, check_writable, write_atomically};
