//! Options of shading moving scenes.

use derive_setters::Setters;
use lobe_shadow::{ShadowFieldOptions, ShadowOptions};

/// How moving parts hide the sky from others.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum MovingMethod {
    /// By their occlusion fields where they have some, else by their spheres (precomputed shadow fields).
    #[default]
    Fields,
    /// By their spheres where they have some (SH exponentiation), else by their fields.
    Exponentials,
}

/// Options of shading a moving scene.
#[derive(Clone, Debug, PartialEq, Setters)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default))]
#[non_exhaustive]
pub struct MovingOptions {
    /// How moving parts hide the sky.
    pub method: MovingMethod,
    /// Number of bands, 1 to 8.
    pub order: usize,
    /// Of products of fields.
    pub fields: ShadowFieldOptions,
    /// Of exponentials of sums of spheres.
    pub spheres: ShadowOptions,
    /// Whether spheres send light of the sky on, one bounce, in the mean albedo of what they stand for. Of what still
    /// parts hide of the sky from a sphere, its light is dimmed.
    pub bounce: bool,
}

impl Default for MovingOptions {
    /// Fields of order 4, without the light that moving parts send on.
    fn default() -> Self {
        Self {
            method: MovingMethod::Fields,
            order: 4,
            fields: ShadowFieldOptions::default(),
            spheres: ShadowOptions::default(),
            bounce: false,
        }
    }
}
