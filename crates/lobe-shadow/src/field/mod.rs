//! Precomputed shadow fields (Zhou, Hu, Lin, Guo and Shum 2005): what an entity hides of the sky, and what a lamp sends, at
//! every point around it; and what all of them together leave to a receiver.
//!
//! Read `octahedron` and `field_grid` first, the sample points, and `axial`, the form of what is stored there; then
//! `occlusion_field`, made by `bake_field` with the rays of `sky_rays`, by `fill_inside` within the solid, and `radiance_field`, which
//! `patch_field` makes of a `lamp_surface`. At run time `shadow_fields` is the
//! way in and `chain` the loop over what `nearest_first` lists, sixteen receivers at once: `placed` looks up in `block_stencil`.
//! `field_file`, `lamp_file` and `visibility_file` are its files, `field_storage` and `stored_tensors` the forms of their numbers. Uses no other room.

pub(crate) mod axial;
pub(crate) mod bake_field;
pub(crate) mod bake_rows;
pub(crate) mod block_stencil;
pub(crate) mod chain;
pub(crate) mod field_file;
pub(crate) mod field_grid;
pub(crate) mod field_storage;
pub(crate) mod fill_inside;
pub(crate) mod lamp;
pub(crate) mod lamp_file;
pub(crate) mod lamp_surface;
pub(crate) mod nearest_first;
pub(crate) mod occlusion_field;
pub(crate) mod octahedron;
pub(crate) mod patch_field;
pub(crate) mod placed;
pub(crate) mod radiance_field;
pub(crate) mod shadow_fields;
pub(crate) mod sky_rays;
mod stored_tensors;
pub(crate) mod visibility_file;
