//! Occluders that move: shadow fields, sphere sets, and what many of them leave of the sky.
//!
//! A baked transfer holds the shadows of a scene that stands still. Here every entity carries what it does to light around
//! it, and a receiver combines those of all entities when it is asked, wherever they have moved.
//!
//! # Index
//!
//! | to | use |
//! |---|---|
//! | place a rigid entity | [`Placement`] |
//! | shadow receivers by spheres that move ([Ren et al. 2006]) | [`SphereShadows`] of [`Occluder`]s, [`ShadowOptions`], [`Receivers`] |
//! | make or read the table that this needs | [`LogTable`], [`cached_log_table`], [`read_log_table`], [`write_log_table`] |
//! | keep spheres in a tree that follows them | [`SphereTree`] |
//! | turn visibility into irradiance | [`SkyLight`] |
//! | add the light that spheres reflect | [`SphereShadows::bounce`], [`Bounce`] |
//! | take exponentials of many functions at once | [`BatchExponential`] |
//!
//! [Ren et al. 2006]: https://doi.org/10.1145/1141911.1141982

mod accumulate;
mod error;
mod placement;

pub use accumulate::batch_exponential::BatchExponential;
pub use accumulate::bounce::Bounce;
pub use accumulate::log_table::{LogTable, LogTableOptions};
pub use accumulate::log_table_file::{cached_log_table, read_log_table, read_log_table_bytes, write_log_table};
pub use accumulate::receivers::Receivers;
pub use accumulate::sky_light::SkyLight;
pub use accumulate::sphere_shadows::{ShadowOptions, SphereShadows};
pub use accumulate::sphere_tree::{Occluder, SphereTree};
pub use error::ShadowError;
pub use placement::Placement;
