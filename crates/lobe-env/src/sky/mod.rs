//! Skies by formula ([`preetham`], [`cie_sky`]), and the sun in a map ([`sun_extraction`]).
//!
//! Read [`sky`] first: the trait, and the ground below. [`sky_fit`] is a sky whose coefficients are polynomials of the
//! sun's height and the turbidity. Uses `area_light`, `map` and `mapping`.

pub(crate) mod cie_sky;
pub(crate) mod preetham;
pub(crate) mod sky;
pub(crate) mod sky_fit;
pub(crate) mod sun_extraction;
