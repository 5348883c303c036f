//! TODO room job.

pub(crate) mod checkpoint;
pub(crate) mod chunks;
pub(crate) mod fingerprint;
pub(crate) mod meter;
pub(crate) mod stored_rows;
