//! The lobe by which glossy surfaces reflect what transfer matrices bring them.

use std::fmt;
use std::str::FromStr;

use lobe_sh::Zonal;

use crate::error::PrtError;

/// The lobe of reflection of glossy surfaces, about the mirrored view direction; in text `phong:E` or `ggx:ALPHA`.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum GlossyLobe {
    /// Phong's lobe with this exponent, 0 or more. It is scaled by the base color.
    Phong(f64),
    /// The lobe of GGX microfacets seen along the normal, with α from 0 to 1. It is scaled by the directional albedo of
    /// the microfacets at the angle of view, by the split-sum approximation, with the base color as reflectance along
    /// the normal.
    Ggx(f64),
}

impl GlossyLobe {
    /// The zonal function by which light is blurred: [`Zonal::phong`] or [`Zonal::ggx`].
    ///
    /// # Panics
    /// As those do.
    #[must_use]
    pub fn zonal(self, order: usize) -> Zonal {
        match self {
            Self::Phong(exponent) => Zonal::phong(order, exponent),
            Self::Ggx(alpha) => Zonal::ggx(order, alpha),
        }
    }
}

impl fmt::Display for GlossyLobe {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Phong(exponent) => write!(f, "phong:{exponent}"),
            Self::Ggx(alpha) => write!(f, "ggx:{alpha}"),
        }
    }
}

impl From<GlossyLobe> for String {
    fn from(lobe: GlossyLobe) -> Self {
        lobe.to_string()
    }
}

impl TryFrom<String> for GlossyLobe {
    type Error = PrtError;

    fn try_from(text: String) -> Result<Self, PrtError> {
        text.parse()
    }
}

impl FromStr for GlossyLobe {
    type Err = PrtError;

    fn from_str(text: &str) -> Result<Self, PrtError> {
        let number = |number: &str| number.parse::<f64>().ok().filter(|number| number.is_finite());
        let found = text.split_once(':').and_then(|(kind, parameter)| Some((kind, number(parameter)?)));
        match found {
            Some(("phong", exponent)) if exponent >= 0.0 => Ok(Self::Phong(exponent)),
            Some(("ggx", alpha)) if (0.0..=1.0).contains(&alpha) => Ok(Self::Ggx(alpha)),
            _ => Err(PrtError::Options(format!(
                "lobe: expected phong:E with an exponent of 0 or more, or ggx:ALPHA with 0 to 1, found '{text}'"
            ))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lobes_have_a_kind_and_a_number() {
        for (text, lobe) in [("phong:20", GlossyLobe::Phong(20.0)), ("ggx:0.25", GlossyLobe::Ggx(0.25))] {
            assert!(text.parse::<GlossyLobe>().is_ok_and(|found| found == lobe), "{text}");
            assert_eq!(lobe.to_string(), text);
        }
        for bad in ["phong", "phong:-1", "phong:inf", "ggx:2", "ggx:x", "box:1", ""] {
            assert!(bad.parse::<GlossyLobe>().is_err(), "{bad:?}");
        }
    }
}
