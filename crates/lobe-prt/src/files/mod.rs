//! Files of transfer: baked glTF, safetensors, lightmaps.
//!
//! Read `transfer_file` first, the simplest, on `tensor_file`, which all safetensors share; then `matrix_file`,
//! `compressed_file` and `lightmap_file`. `any_transfer` reads whichever it is, and `open_scene` a scene with or without;
//! `memory` refuses what is too large.
//!
//! `baked_glb` writes scenes whose vertices carry transfer, laid out as `baked_layout` and `baked_compressed` say.
//! `baked_extras` and `baked_shape` describe it. `read_baked` reads them, their backs by `baked_backs`. `lightmap_glb`
//! writes those with a lightmap, with `new_vertices` where a file was unwrapped. `glb_writer` is the container. Uses
//! `bake`, `compression`, `job`, `receivers`, `recipe`, `transfer` and `zonal`.

pub(crate) mod any_transfer;
pub(crate) mod baked_backs;
pub(crate) mod baked_compressed;
pub(crate) mod baked_extras;
pub(crate) mod baked_glb;
pub(crate) mod baked_layout;
pub(crate) mod baked_shape;
pub(crate) mod compressed_file;
pub(crate) mod glb_writer;
pub(crate) mod lightmap_file;
pub(crate) mod lightmap_glb;
pub(crate) mod matrix_file;
pub(crate) mod memory;
pub(crate) mod new_vertices;
pub(crate) mod open_scene;
pub(crate) mod read_baked;
pub(crate) mod tensor_file;
pub(crate) mod transfer_file;
