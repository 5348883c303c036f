//! Environment mapping of scenes of triangles: surfaces look light up in maps, by direction alone and without shadows.
//!
//! Read `environment_maps` first: the maps of a light, and what a surface sends to the eye by them. `gltf_surfaces` is
//! glTF's model of reflection, for these and for baked scenes; `reflection_maps` are the maps that it needs;
//! `options` says how they are stored, and `light_by_maps` makes the picture. Uses `scene_view`, `path_tracer` and
//! `camera`.

pub(crate) mod environment_maps;
pub(crate) mod gltf_surfaces;
pub(crate) mod light_by_maps;
pub(crate) mod options;
pub(crate) mod reflection_maps;
