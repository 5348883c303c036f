//! Sections about a photograph of everything around a point, a file each.
//!
//! `environment` shows the photograph, `reconstruction` what an expansion keeps of it, `irradiance` the ball that it lights
//! and `overview` all of this in one picture. `encodings` and `extraction` are fewer numbers, `rotation` and `projection`
//! the expansion, `mappings`, `sun` and `environment_mapping` the picture. Uses `page`.

pub(crate) mod encodings;
pub(crate) mod environment;
pub(crate) mod environment_mapping;
pub(crate) mod extraction;
pub(crate) mod irradiance;
pub(crate) mod mappings;
pub(crate) mod overview;
pub(crate) mod projection;
pub(crate) mod reconstruction;
pub(crate) mod rotation;
pub(crate) mod sun;
