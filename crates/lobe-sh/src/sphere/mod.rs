//! The sphere itself: directions, points spread over it, triangles and quadrature rules.
//!
//! Read `dir` first, then `quadrature`; `triangulation` and `point_sets` are for searches, `vector` has the
//! vector algebra that all rooms share. Uses no other room.

pub(crate) mod dir;
pub(crate) mod point_sets;
pub(crate) mod quadrature;
pub(crate) mod triangulation;
pub mod vector;

pub use dir::Dir;
pub use point_sets::even_directions;
pub use quadrature::{SphereQuadrature, gauss_legendre};
