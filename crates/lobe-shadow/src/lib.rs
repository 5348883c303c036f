//! Occluders that move: shadow fields, sphere sets, and what many of them leave of the sky.
//!
//! A baked transfer holds the shadows of a scene that stands still. Here every entity carries what it does to light around
//! it, and a receiver combines those of all entities when it is asked, wherever they have moved.

//!
//! # Index
//!
//! | purpose | item |
//! |---|---|
//! | where an entity is | [`Placement`], [`relative_placement`] |
//! | occlusion fields | [`OcclusionField`], [`FieldGrid`], [`bake_field`], [`FieldOptions`] |
//! | files of fields | [`write_field`], [`read_field`], [`FieldStorage`] |
//! | visibility of an entity's own surface | [`bake_visibility`] |
//! | lamps near by | [`RadianceField`], [`PatchField`], [`Rectangle`] |
//! | entities together, and shading | [`ShadowFields`], [`Entity`], [`LocalLight`], [`ShadowReceivers`] |

mod error;
mod field;
mod placement;

pub use error::ShadowError;
pub use field::bake_field::{FieldOptions, FieldReport, VisibilityOptions, bake_field, bake_visibility};
pub use field::field_file::{read_field, read_field_bytes, write_field};
pub use field::field_grid::{FieldGrid, RadialInterpolation};
pub use field::field_storage::{FieldStorage, StorageReport};
pub use field::occlusion_field::OcclusionField;
pub use field::radiance_field::{PatchField, RadianceField, RadianceOptions, Rectangle};
pub use field::shadow_fields::{Entity, LocalLight, ShadowFieldOptions, ShadowFields, relative_placement};
pub use field::shadow_receivers::ShadowReceivers;
pub use placement::Placement;
