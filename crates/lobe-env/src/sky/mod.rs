//! Skies by formula ([`preetham`], [`cie_sky`]), and the suns in a map ([`sun_extraction`], one
//! after another [`suns`], and why there is none [`no_sun`]).
//!
//! Read [`sky`] first: the trait, and the ground below. [`sky_fit`] is a sky whose coefficients are polynomials of the
//! sun's height and the turbidity. [`scene_light`] is the light of a scene as suns, by a [`sun_choice`] or from a
//! [`sun_file`], and an expansion of the rest. Uses `area_light`, `projection`, `map` and `mapping`.

pub(crate) mod cie_sky;
pub(crate) mod neighbors;
pub(crate) mod no_sun;
pub(crate) mod preetham;
pub(crate) mod scene_light;
pub(crate) mod sky;
pub(crate) mod sky_fit;
pub(crate) mod sun_choice;
pub(crate) mod sun_extraction;
pub(crate) mod sun_file;
pub(crate) mod suns;
