//! Baking: path tracing from each receiver, summed into coefficients.
//!
//! Read `options` first, then `bake`, which all kinds of bakes share; `tracer` follows a path; `point_transfer` says
//! what is summed at a point: `diffuse` sums vectors of matte receivers by `basis_sum`, `glossy` matrices by
//! `outer_sum`. `transfer_grid` bakes matrices in space, `pilot` finds beforehand how many bounces and paths it takes.
//! Uses `job`, `receivers`, `sampling` and `transfer`.

pub(crate) mod bake;
pub(crate) mod basis_sum;
pub(crate) mod diffuse;
pub(crate) mod glossy;
pub(crate) mod options;
pub(crate) mod outer_sum;
pub(crate) mod pilot;
pub(crate) mod point_transfer;
pub(crate) mod tracer;
pub(crate) mod transfer_grid;
