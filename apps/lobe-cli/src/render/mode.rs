//! The methods of `lobe render`.

use lobe::render::Surfaces;

/// The method that makes a picture.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Mode {
    Trace,
    Irradiance,
    Maps,
    Baked,
    Moving,
}

impl Mode {
    /// The model of reflection without --surfaces, of methods that know more than one.
    pub(crate) fn surfaces(self) -> Option<Surfaces> {
        match self {
            Self::Trace | Self::Baked | Self::Moving => Some(Surfaces::Matte),
            Self::Maps => Some(Surfaces::MetallicRoughness),
            Self::Irradiance => None,
        }
    }
}
