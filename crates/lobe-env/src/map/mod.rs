//! TODO room map.

pub(crate) mod adjust;
pub(crate) mod cube_average;
pub(crate) mod cube_layout;
pub(crate) mod cube_map;
pub(crate) mod cube_mip_chain;
pub(crate) mod env_map;
pub(crate) mod mapped_map;
