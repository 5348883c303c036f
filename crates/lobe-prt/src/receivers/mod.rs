//! Receivers, the points that transfer is baked for: vertices, and the texels of a lightmap.
//!
//! Read `receivers` first; `inset` moves those at borders into their meshes, which `edges` finds, `planes` are those of
//! their triangles.
//! `texel_receivers` are those of a lightmap, whose `charts` belong together and from which `beyond_walls` fetches
//! those that light the foot of one, `texel_rows` their transfer as a picture, `lightmap` looks it up between
//! texels; `vertex_key` finds vertices that are the same. Uses `transfer`.

pub(crate) mod beyond_walls;
pub(crate) mod charts;
pub(crate) mod edges;
pub(crate) mod inset;
pub(crate) mod lightmap;
pub(crate) mod planes;
pub(crate) mod receivers;
pub(crate) mod texel_receivers;
pub(crate) mod texel_rows;
pub(crate) mod vertex_key;
