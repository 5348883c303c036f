//! Ray tracing: a bounding volume hierarchy with eight children per node (BVH8), its traversal, and watertight
//! intersection of triangles.
//!
//! Read `bvh` first, the public type; then `binned`, which builds a `binary_tree` by `bins`, `collapse`, which makes wide nodes of
//! it, and `wide_node`, their layout in memory, `layers`, triangles that need not be in it, and `refit`, which moves
//! the boxes of a tree; then `traverse`, one ray at a time: `ray_frame` prepares it, `watertight` intersects triangles.
//! `ray_stream` traces many rays from one point at once, `closest_stream` to their closest hits: `octant_slabs` for
//! boxes, `edge_planes` for triangles. `interleaved` traces independent rays in turns.
//! `surface_rays` asks surfaces whether they have holes. `lanes` has the vector instructions of all this. Uses `scene`.

pub(crate) mod binary_tree;
pub(crate) mod binned;
pub(crate) mod bins;
pub(crate) mod bvh;
pub(crate) mod closest_stream;
pub(crate) mod collapse;
pub(crate) mod edge_planes;
pub(crate) mod interleaved;
pub(crate) mod lanes;
#[cfg(target_arch = "x86_64")]
pub(crate) mod lanes_x86;
pub(crate) mod layers;
pub(crate) mod octant_slabs;
pub(crate) mod ray_frame;
pub(crate) mod ray_stream;
pub(crate) mod refit;
pub(crate) mod surface_rays;
pub(crate) mod traverse;
pub(crate) mod watertight;
pub(crate) mod wide_node;
