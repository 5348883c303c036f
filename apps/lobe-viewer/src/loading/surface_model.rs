//! Models of reflection, by their names.

use serde::{Deserialize, Serialize};

/// How surfaces reflect, by the names of `lobe render --surfaces`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum SurfaceModel {
    /// Lambert with the base color as albedo
    #[default]
    Matte,
    /// The metallic-roughness model of glTF, Smith's masking height-correlated
    Gltf,
}
