//! Baked parts: transfer that a file holds (`kept_transfer`), backs of double-sided surfaces (`part_backs`),
//! visibility past what stands still (`visibility_grid`) and the albedo of spheres (`sphere_albedo`). Uses no other
//! room.

pub(crate) mod kept_transfer;
pub(crate) mod part_backs;
pub(crate) mod sphere_albedo;
pub(crate) mod visibility_grid;
