//! Running a bake: in chunks that are the same for any number of threads, watched, and kept on disk so that it can be
//! stopped, killed and continued.
//!
//! Read `chunks` first, which does the work; then `checkpoint`, which keeps what it finds in a
//! [`lobe_io::RecordFile`]; `fingerprint` identifies a bake; `meter` watches the searches of other rooms.
//! Uses no other room.

pub(crate) mod checkpoint;
pub(crate) mod chunks;
pub(crate) mod fingerprint;
pub(crate) mod meter;
