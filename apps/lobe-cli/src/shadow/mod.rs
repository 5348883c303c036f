//! Occluders that move: `lobe field`, `lobe lamp` and `lobe spheres`, a file each. Uses `args` and `run`.

pub(crate) mod field;
pub(crate) mod lamp;
pub(crate) mod spheres;
