//! Scenes: meshes, materials and textures; positions and directions are arrays, z is up.
//!
//! Read `scene` first, then `mesh`, `material`, `texture` and `ray`. `shading_normal` applies normal maps. `vertex_normals`, `tangents`,
//! `flat` and `split_edges` compute what a file lacks, `coincident` counts duplicates, `near_origin` moves a scene to where `f32` is precise, `up` rotates y up to
//! z up, `transform` places meshes, `joined` takes scenes apart and puts them together, `finish`
//! makes all surfaces alike. Uses no other room.

pub(crate) mod coincident;
pub(crate) mod finish;
pub(crate) mod flat;
pub(crate) mod joined;
pub(crate) mod material;
pub(crate) mod mesh;
pub(crate) mod near_origin;
pub(crate) mod ray;
pub(crate) mod scene;
pub(crate) mod shading_normal;
pub(crate) mod split_edges;
pub(crate) mod tangents;
pub(crate) mod texture;
pub(crate) mod transform;
pub(crate) mod up;
pub(crate) mod vertex_normals;
