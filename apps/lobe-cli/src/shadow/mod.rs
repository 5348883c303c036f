//! What moves: `lobe field` and `lobe spheres`, a file each. Uses `args` and `run`.

pub(crate) mod field;
pub(crate) mod spheres;
