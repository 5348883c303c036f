//! Pictures of scenes of triangles whose light is known at the surface: by precomputed radiance transfer, or by
//! irradiance.
//!
//! Read `scene_picture`, which finds the surface that each pixel shows, and `silhouettes`, where it looks closer; then
//! `prt_shading`, which lights a surface by transfer, `placed_transfer`, which bakes what files of transfer leave out,
//! and `sun_rays`, which looks at suns. `baked_scene` holds a scene with its transfer, `lit_scene` lights it,
//! `surface_model` is how a surface reflects what reaches it, `openness` what hides its reflections; `light_scene`
//! makes the picture.
//! `transfer_source` is how a job asks for transfer, which is baked by `picture_bake` where no file has it. Uses
//! `camera`.

pub(crate) mod baked_scene;
pub(crate) mod light_scene;
pub(crate) mod lit_scene;
pub(crate) mod openness;
pub(crate) mod picture_bake;
pub(crate) mod placed_transfer;
pub(crate) mod prt_shading;
pub(crate) mod scene_picture;
pub(crate) mod silhouettes;
pub(crate) mod sun_rays;
pub(crate) mod surface_model;
pub(crate) mod transfer_source;
