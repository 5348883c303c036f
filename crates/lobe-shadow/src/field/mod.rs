//! Precomputed shadow fields (Zhou, Hu, Lin, Guo and Shum 2005): what an entity hides of the sky, and what a lamp sends, at
//! every point around it; and what all of them together leave to a receiver.
//!
//! Read `octahedron` and `field_grid` first, the sample points, and `axial`, the form of what is stored there; then `occlusion_field`, made by `bake_field` with the rays of
//! `sky_rays`, and `radiance_field`. At run time `shadow_fields` is the way in, `chain` the loop of products. `field_file`
//! and `field_storage` are its files. Uses no other room.

pub(crate) mod axial;
pub(crate) mod bake_field;
pub(crate) mod bake_rows;
pub(crate) mod chain;
pub(crate) mod field_file;
pub(crate) mod field_grid;
pub(crate) mod field_storage;
pub(crate) mod fill_inside;
pub(crate) mod lane_basis;
pub(crate) mod lanes;
pub(crate) mod nearest_first;
pub(crate) mod occlusion_field;
pub(crate) mod octahedron;
pub(crate) mod placed;
pub(crate) mod radiance_field;
pub(crate) mod shadow_fields;
pub(crate) mod shadow_receivers;
pub(crate) mod sky_rays;
