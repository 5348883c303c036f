//! Skies by formula ([`preetham`], [`cie_sky`]), and the sun in a map ([`sun_extraction`]).
//!
//! Read first: [`sky`], the trait and the ground below. [`sky_fit`] is a sky whose coefficients are polynomials of the sun's
//! height and the turbidity. Uses map, mapping and projection.

pub(crate) mod cie_sky;
pub(crate) mod preetham;
pub(crate) mod sky;
pub(crate) mod sky_fit;
pub(crate) mod sun_extraction;
