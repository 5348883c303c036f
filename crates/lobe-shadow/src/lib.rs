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
//! | sphere sets | [`SphereSet`], [`fit_spheres`], [`SphereFitOptions`]; hierarchies of them [`SphereHierarchy`] |
//! | spheres that follow joints | [`SkinnedMesh`], [`Skin`], [`WorldSphere`] |
//! | files of sphere sets | [`write_spheres`], [`read_spheres`], [`SphereSetJson`] |

mod error;
mod field;
mod placement;
mod spheres;

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
pub use spheres::fit_spheres::{SphereFitMethod, SphereFitOptions, SphereFitReport, fit_spheres, refine_spheres};
pub use spheres::pose::{SkinnedMesh, WorldSphere};
pub use spheres::skin::Skin;
pub use spheres::solid::Solid;
pub use spheres::sphere_file::{
    read_sphere_hierarchy, read_sphere_hierarchy_bytes, read_spheres, read_spheres_bytes, write_sphere_hierarchy, write_spheres,
};
pub use spheres::sphere_hierarchy::{SphereHierarchy, SphereNode};
pub use spheres::sphere_json::{SphereJson, SphereSetJson};
pub use spheres::sphere_set::SphereSet;
