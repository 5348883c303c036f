//! Techniques of environment mapping from 1976 to split-sum reflection, each beside its reference, on a ball and a
//! torus.
//!
//! Read `exhibit` first: a shape before a camera, and the trait by which a technique shades it. The shapes are in
//! `solid` and `torus`. Then the techniques: mirrors by `mirror_maps` and `paraboloids` beside `traced_mirror`; glossy
//! reflection by `glossy`, `highlight_map` and `reflection_space` (interpolated on an `icosphere`); diffuse reflection
//! by `matte`; `bump` perturbs the normals of any of them. `square_texture` is a picture over a square.
//! `environment_sheet` puts all on one sheet. Uses no other room.

pub(crate) mod bump;
pub(crate) mod environment_sheet;
pub(crate) mod exhibit;
pub(crate) mod glossy;
pub(crate) mod highlight_map;
pub(crate) mod icosphere;
pub(crate) mod matte;
pub(crate) mod mirror_maps;
pub(crate) mod paraboloids;
pub(crate) mod reflection_space;
pub(crate) mod roots;
pub(crate) mod solid;
pub(crate) mod square_texture;
pub(crate) mod torus;
pub(crate) mod traced_mirror;
