//! The lobe by which glossy surfaces reflect what transfer matrices bring them.

use lobe_sh::Zonal;

/// The lobe of reflection of glossy surfaces, about the mirrored view direction.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
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
