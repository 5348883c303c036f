//! TODO room bake.

pub(crate) mod adaptive;
pub(crate) mod bake;
pub(crate) mod basis_sum;
pub(crate) mod diffuse;
pub(crate) mod glossy;
pub(crate) mod options;
pub(crate) mod outer_sum;
pub(crate) mod pilot;
pub(crate) mod tracer;
pub(crate) mod transfer_grid;
