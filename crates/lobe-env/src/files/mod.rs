//! Map files: the reader of any map ([`read_map`]), pictures, textures and the six faces of a cube ([`cube_faces`], by
//! their [`face_names`]), and the writers.
//!
//! Read [`read_options`] first, then [`read_map`]. Decoding and encoding belong to `lobe-image`; this room finds the mapping,
//! interprets the attribute `envmap` of OpenEXR ([`exr_envmap`]), completes cropped panoramas ([`cropped`], by what
//! [`panorama`] finds in XMP) and makes maps of fisheye pictures ([`fisheye`], by the rays of [`fisheye_rays`]). A map
//! that is only projected need not be read whole ([`project_map_file()`]). [`babylon_env`] is a file of Babylon.js.
//! Uses `map`, `mapping`, `prefilter`, `projection` and `resample`.

pub(crate) mod babylon_env;
pub mod bundled;
pub(crate) mod cropped;
pub(crate) mod cube_faces;
pub(crate) mod exr_envmap;
pub(crate) mod face_names;
pub(crate) mod fisheye;
pub(crate) mod fisheye_rays;
pub(crate) mod panorama;
pub(crate) mod project_map_file;
pub(crate) mod read_map;
pub(crate) mod read_options;
pub(crate) mod write;
