//! Running a bake: in chunks that are the same for any number of threads, watched, and kept on disk so that it can be
//! stopped, killed and continued.
//!
//! Read `chunks` first, which does the work; then `row_layout`, `checkpoint` and `stored_rows`, which keep what it
//! finds in a [`lobe_io::RecordFile`]; `fingerprint` identifies a bake; `meter` watches the searches of other rooms.
//! Uses no other room.

pub(crate) mod checkpoint;
pub(crate) mod chunks;
pub(crate) mod fingerprint;
pub(crate) mod meter;
pub(crate) mod row_layout;
pub(crate) mod stored_rows;
