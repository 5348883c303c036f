//! Results of long work on disk, record by record, so that it can be stopped, killed, continued, and shared among machines: `layout`
//! says where records are, `shard` which of them a machine makes; `record_file` makes them, `record_reader` reads them when all are
//! there, and `merge` puts those of all shards together.
//!
//! Uses no other room.

pub(crate) mod layout;
pub(crate) mod merge;
pub(crate) mod record_file;
pub(crate) mod record_reader;
pub(crate) mod shard;
