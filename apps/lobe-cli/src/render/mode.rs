//! The methods of `lobe render`.

use clap::ValueEnum;
use lobe::render::Surfaces;

/// The method that makes a picture.
#[derive(Clone, Copy, PartialEq, ValueEnum)]
pub(crate) enum Mode {
    /// Path tracing: shadows and reflections between surfaces
    Truth,
    /// The irradiance of the expansion by shading normal, times albedo/π
    Irradiance,
    /// Environment mapping: reflections looked up in the map by the mirrored view, prefiltered for rough surfaces, and irradiance by
    /// the normal; without shadows and reflections between surfaces
    Environment,
    /// Transfer without shadows
    Unshadowed,
    /// Transfer with shadows
    Shadowed,
    /// Transfer with shadows and reflections between surfaces
    Interreflected,
    /// Transfer matrices with shadows and reflections between surfaces, and rough mirrors
    Glossy,
    /// A scene that moves: transfer of its parts, which hide the sky from each other by precomputed shadow fields, or by spheres where
    /// they change their shape: nearer to the truth
    Fields,
    /// The same by spheres alone, as exponentials of sums (SHEXP): less to bake, and files of a few kilobytes
    Shexp,
}

impl Mode {
    /// The model of reflection without --surfaces, of methods that know more than one.
    pub(crate) fn surfaces(self) -> Option<Surfaces> {
        match self {
            Self::Truth => Some(Surfaces::Matte),
            Self::Environment => Some(Surfaces::MetallicRoughness),
            _ => None,
        }
    }
}
