//! TODO room mapping_gallery.

pub(crate) mod blinn_newell;
pub(crate) mod bump;
pub(crate) mod cube_mapped;
pub(crate) mod environment_sheet;
pub(crate) mod exhibit;
pub(crate) mod glossy;
pub(crate) mod highlight_map;
pub(crate) mod icosphere;
pub(crate) mod irradiance_polynomial;
pub(crate) mod matte;
pub(crate) mod paraboloids;
pub(crate) mod reflection_space;
pub(crate) mod roots;
pub(crate) mod solid;
pub(crate) mod sphere_mapped;
pub(crate) mod square_texture;
pub(crate) mod torus;
pub(crate) mod traced_mirror;
