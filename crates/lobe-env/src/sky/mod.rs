//! Skies by formula ([`preetham`], [`cie_sky`]), and the suns in a map ([`sun_extraction`], one
//! after another [`suns`], and why there is none [`no_sun`]).
//!
//! Read [`sky`] first: the trait, and the ground below. [`sky_fit`] is a sky whose coefficients are polynomials of the
//! sun's height and the turbidity. Uses `area_light`, `map` and `mapping`.

pub(crate) mod cie_sky;
pub(crate) mod neighbors;
pub(crate) mod no_sun;
pub(crate) mod preetham;
pub(crate) mod sky;
pub(crate) mod sky_fit;
pub(crate) mod sun_extraction;
pub(crate) mod suns;
