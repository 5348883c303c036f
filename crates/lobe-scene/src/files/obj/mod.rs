//! Reading OBJ in parts: `lines` are what a file is made of, `materials` reads MTL files, `smoothing` makes normals.

pub(crate) mod lines;
pub(crate) mod materials;
pub(crate) mod smoothing;
