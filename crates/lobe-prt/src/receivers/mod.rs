//! TODO room receivers.

pub(crate) mod inset;
pub(crate) mod lightmap;
pub(crate) mod receivers;
pub(crate) mod texel_receivers;
pub(crate) mod texel_rows;
