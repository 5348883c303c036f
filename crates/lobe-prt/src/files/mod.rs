//! TODO room files.

pub(crate) mod any_transfer;
pub(crate) mod baked_compressed;
pub(crate) mod baked_glb;
pub(crate) mod baked_layout;
pub(crate) mod compressed_file;
pub(crate) mod lightmap_file;
pub(crate) mod matrix_file;
pub(crate) mod read_baked;
pub(crate) mod tensor_file;
pub(crate) mod transfer_file;
