//! TODO room scene.

pub(crate) mod material;
pub(crate) mod mesh;
pub(crate) mod near_origin;
pub(crate) mod ray;
pub(crate) mod scene;
pub(crate) mod split_edges;
pub(crate) mod texture;
pub(crate) mod up;
pub(crate) mod vertex_normals;
