//! Results of long work on disk, record by record, so that it can be stopped, killed, continued, and shared among machines: `layout`
//! says where records are; `record_file` makes them, `record_reader` reads them when all are
//! there, and `merge` puts those of all shards together.
//!
//! Uses `error`.

pub(crate) mod layout;
pub(crate) mod merge;
pub(crate) mod record_file;
pub(crate) mod record_reader;
