//! SH exponentiation: the visibility of the sky past many spheres, as the sum of their logarithms, and its exponential ([Ren et al. 2006]).
//!
//! Read [`log_table`] first (and [`log_table_file`] for its file), then [`aim`], how a receiver sees a sphere,
//! [`sum_logarithms`], the kernel by the polynomials in [`monic_columns`], and [`batch_exponential`]. [`shares`] lets spheres that overlap
//! share what they hide, [`sphere_tree`] many spheres count as one,
//! [`sky_light`] turns visibility into irradiance, [`bounce`] adds what spheres reflect, and [`sphere_shadows`] is all of it for
//! a set of receivers. Uses no other room.
//!
//! [Ren et al. 2006]: https://doi.org/10.1145/1141911.1141982

mod aim;
pub(crate) mod batch_exponential;
pub(crate) mod bounce;
pub(crate) mod log_table;
pub(crate) mod log_table_file;
mod monic_columns;
pub(crate) mod occluder;
mod receiver_groups;
mod shares;
pub(crate) mod sky_light;
pub(crate) mod sphere_shadows;
pub(crate) mod sphere_tree;
mod sum_logarithms;
