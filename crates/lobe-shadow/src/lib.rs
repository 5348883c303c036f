//! Occluders that move: shadow fields, sphere sets, and what many of them leave of the sky.
//!
//! A baked transfer holds the shadows of a scene that stands still. Here every entity carries what it does to light around
//! it, and a receiver combines those of all entities when it is asked, wherever they have moved.
//!
//! # Index
//!
//! | purpose | item |
//! |---|---|
//! | where an entity is | [`Placement`], [`relative_placement`]; over time [`Track`] |
//! | scenes of entities in files | [`SceneDescription`], its [`LampDescription`]s |
//! | occlusion fields | [`OcclusionField`], [`FieldGrid`], [`bake_field`], [`bake_field_shard`], [`FieldOptions`] |
//! | all that is asked of a field or of spheres as one value | [`FieldJob`], [`FieldDone`], [`SphereJob`]; [`FieldSampling`], [`StorageOptions`] |
//! | files of fields | [`write_field`], [`read_field`], [`FieldStorage`] |
//! | visibility of an entity's own surface | [`bake_visibility`], [`bake_vertex_visibility`]; files of it [`SurfaceVisibility`], [`write_visibility`], [`read_visibility`] |
//! | lamps near by | [`LampSurface`], its [`RadianceField`], [`PatchField`]; files of them [`Lamp`], [`write_lamp`], [`read_lamp`] |
//! | entities together, and shading | [`ShadowFields`], [`PlacedField`], [`LocalLight`], [`ShadowReceivers`] |
//! | sphere sets | [`SphereSet`], [`fit_spheres`], [`SphereFitOptions`] |
//! | spheres that follow joints | [`SphereSet::bind_to`] an entity, its [`Skeleton`]; [`SkinnedMesh`], [`Skin`], [`WorldSphere`] |
//! | files of sphere sets | [`write_spheres`], [`read_spheres`], [`SphereSetJson`] |
//! | spheres' shadows ([Ren et al. 2006]) | [`SphereShadows`] of [`Occluder`]s, [`ShadowOptions`], [`ShadowReceivers`]; many far ones as one [`SphereTree`] |
//! | the table that they need | [`LogTable`], [`cached_log_table`], [`read_log_table`], [`write_log_table`] |
//! | visibility to irradiance | [`SkyLight`]; light that spheres reflect [`Bounce`] |
//! | exponentials of many functions at once | [`BatchExponential`] |
//!
//! [Ren et al. 2006]: https://doi.org/10.1145/1141911.1141982

mod accumulate;
mod description;
mod error;
mod field;
mod jobs;
mod lamp_description;
mod lane_basis;
mod placement;
mod receivers;
mod spheres;
mod split_mix;
mod track;
mod track_json;

pub use accumulate::batch_exponential::BatchExponential;
pub use accumulate::bounce::Bounce;
pub use accumulate::log_table::{LogTable, LogTableOptions};
pub use accumulate::log_table_file::{cached_log_table, read_log_table, read_log_table_bytes, write_log_table};
pub use accumulate::occluder::Occluder;
pub use accumulate::sky_light::SkyLight;
pub use accumulate::sphere_shadows::{ShadowOptions, SphereShadows};
pub use accumulate::sphere_tree::SphereTree;
pub use description::{AnimationChoice, EntityDescription, SceneDescription, StillDescription};
pub use error::ShadowError;
pub use field::bake_field::{
    FieldOptions, FieldReport, VisibilityOptions, bake_field, bake_field_shard, bake_vertex_visibility, bake_visibility,
};
pub use field::field_file::{read_field, read_field_bytes, write_field};
pub use field::field_grid::{FieldGrid, RadialInterpolation};
pub use field::field_storage::{FieldStorage, StorageReport};
pub use field::lamp::{Lamp, LampSequence};
pub use field::lamp_file::{read_lamp, read_lamp_bytes, write_lamp};
pub use field::lamp_surface::{LampSurface, PatchedRectangle, Rectangle};
pub use field::occlusion_field::OcclusionField;
pub use field::patch_field::PatchField;
pub use field::radiance_field::{RadianceField, RadianceOptions};
pub use field::shadow_fields::{LocalLight, PlacedField, ShadowFieldOptions, ShadowFields, relative_placement};
pub use field::visibility_file::{SurfaceVisibility, read_visibility, read_visibility_bytes, write_visibility};
pub use jobs::field_job::{FieldDone, FieldJob};
pub use jobs::field_sampling::FieldSampling;
pub use jobs::sphere_job::SphereJob;
pub use jobs::storage_options::{StorageForm, StorageOptions};
pub use lamp_description::{LampDescription, LampSource};
pub use placement::Placement;
pub use receivers::ShadowReceivers;
pub use spheres::fit_spheres::{SphereFitMethod, SphereFitOptions, SphereFitReport, fit_spheres, refine_spheres};
pub use spheres::morphs::SphereMorphs;
pub use spheres::pose::{SkinnedMesh, WorldSphere};
pub use spheres::skeleton::Skeleton;
pub use spheres::skin::Skin;
pub use spheres::solid::Solid;
pub use spheres::sphere_file::{read_spheres, read_spheres_bytes, write_spheres};
pub use spheres::sphere_json::{SphereJson, SphereSetJson};
pub use spheres::sphere_set::SphereSet;
pub use track::{Key, Track};
