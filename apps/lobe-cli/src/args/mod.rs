//! TODO room args.

pub(crate) mod compression;
pub(crate) mod input;
pub(crate) mod map_input;
pub(crate) mod map_output;
pub(crate) mod memory;
pub(crate) mod output;
pub(crate) mod picture;
pub(crate) mod scene_input;
pub(crate) mod transfer_input;
pub(crate) mod turn;
pub(crate) mod values;
