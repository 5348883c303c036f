//! Reading OBJ in parts: `lines` are what a file is made of, `materials` reads MTL files.

pub(crate) mod lines;
pub(crate) mod materials;
