//! Bakes of occluders as jobs: all that is asked for as one value, and all that is done for it.
//!
//! Read `field_job` first, an occlusion field or the visibility of an entity's own surface; then `sphere_job`, spheres
//! that stand for a mesh. `field_sampling` and `storage_options` are options that
//! lamps have, too. Uses `field` and `spheres`.

pub(crate) mod field_job;
pub(crate) mod field_sampling;
pub(crate) mod sphere_job;
pub(crate) mod storage_options;
