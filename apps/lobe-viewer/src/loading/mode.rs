//! Light paths of a picture: irradiance, shadowed, interreflected, or a difference.

use lobe::prt::{BakeMode, PrtError, Transfer};
use serde::{Deserialize, Serialize};

/// Which light paths are shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Mode {
    /// Irradiance of the normal alone, which needs no bake.
    Irradiance,
    /// Direct light with shadows.
    Shadowed,
    /// Shadows, and the light that surfaces send each other.
    #[default]
    Interreflected,
    /// Only the light that surfaces send each other: interreflected minus shadowed.
    Difference,
}

impl Mode {
    /// All of them, in the order of the window.
    pub const ALL: [Self; 4] = [Self::Irradiance, Self::Shadowed, Self::Interreflected, Self::Difference];

    /// The name in the window.
    #[must_use]
    pub fn title(self) -> &'static str {
        match self {
            Self::Irradiance => "Irradiance",
            Self::Shadowed => "Shadowed",
            Self::Interreflected => "Interreflected",
            Self::Difference => "Difference",
        }
    }

    /// What it shows, in one sentence.
    pub(crate) fn explain(self) -> &'static str {
        match self {
            Self::Irradiance => "Light by the normal alone: nothing stands in its way",
            Self::Shadowed => "Direct light with shadows",
            Self::Interreflected => "Shadows, and the light that surfaces send each other",
            Self::Difference => "Only the light that surfaces send each other: interreflected minus shadowed",
        }
    }

    /// The bakes that it is made of.
    #[must_use]
    pub fn bakes(self) -> &'static [BakeMode] {
        match self {
            Self::Irradiance => &[],
            Self::Shadowed => &[BakeMode::Shadowed],
            Self::Interreflected => &[BakeMode::Interreflected],
            Self::Difference => &[BakeMode::Shadowed, BakeMode::Interreflected],
        }
    }

    /// The transfer of this mode, of that of its bakes; none if one of them is missing, or none is needed.
    ///
    /// # Errors
    /// As [`Transfer::minus`].
    pub fn transfer<'a>(self, baked: impl Fn(BakeMode) -> Option<&'a Transfer>) -> Result<Option<Transfer>, PrtError> {
        match self {
            Self::Irradiance => Ok(None),
            Self::Shadowed => Ok(baked(BakeMode::Shadowed).cloned()),
            Self::Interreflected => Ok(baked(BakeMode::Interreflected).cloned()),
            Self::Difference => match (baked(BakeMode::Interreflected), baked(BakeMode::Shadowed)) {
                (Some(all), Some(direct)) => all.minus(direct).map(Some),
                _ => Ok(None),
            },
        }
    }
}
