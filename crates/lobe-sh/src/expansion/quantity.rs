//! The physical quantity that an expansion describes.

use core::fmt;
use core::str::FromStr;

use crate::error::ShError;

/// The physical quantity that a function on the sphere describes; files carry it so that they are not confused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Quantity {
    /// Light arriving from a direction, L [W m⁻² sr⁻¹].
    Radiance,
    /// Light arriving on a surface whose normal is the direction, E [W m⁻²]; 1/π is not in it.
    Irradiance,
    /// Exit radiance for unit light from a direction: albedo, visibility and cosine together.
    Transfer,
    /// 1 where the direction is open, 0 where it is blocked.
    Visibility,
    /// The logarithm of visibility: sums stand for products.
    LogVisibility,
    /// A function without a physical quantity of this list, such as radiance times radiance.
    Function,
}

impl Quantity {
    /// Every quantity.
    pub const ALL: [Self; 6] =
        [Self::Radiance, Self::Irradiance, Self::Transfer, Self::Visibility, Self::LogVisibility, Self::Function];

    /// The name used in files and messages, such as `log-visibility`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Radiance => "radiance",
            Self::Irradiance => "irradiance",
            Self::Transfer => "transfer",
            Self::Visibility => "visibility",
            Self::LogVisibility => "log-visibility",
            Self::Function => "function",
        }
    }
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Quantity {
    type Err = ShError;

    fn from_str(name: &str) -> Result<Self, ShError> {
        let found = Self::ALL.into_iter().find(|q| q.name() == name);
        found.ok_or_else(|| ShError::Options(format!("expected one of {}", Self::ALL.map(Self::name).join(", "))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_quantity_is_found_by_its_name() {
        for quantity in Quantity::ALL {
            assert_eq!(quantity.name().parse().ok(), Some(quantity), "{quantity}");
        }
    }

    #[test]
    fn an_unknown_quantity_is_refused_with_the_known_ones() {
        let message = "Radiance".parse::<Quantity>().unwrap_err().to_string();
        assert!(message.ends_with("log-visibility, function"), "{message}");
    }
}
