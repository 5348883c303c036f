//! Coefficients as the libraries of the sciences keep them: their basis, normalization, phase, layout and axes.
//!
//! Read `convention` first: a value says what a library's numbers are, and makes them of an expansion; `decode` is
//! the way back. `array` holds them. `normalization` has the lengths of the basis functions, `layout` the places of
//! the numbers in an array. `named` is the table of known libraries. Uses `basis`, `expansion` and `rotation`.

pub(crate) mod array;
pub(crate) mod convention;
mod decode;
pub(crate) mod layout;
pub(crate) mod named;
pub(crate) mod normalization;

pub use array::{ArrayNumbers, CoefficientArray};
pub use convention::{Convention, Harmonics, Meaning, PolarAxis};
pub use layout::CoefficientLayout;
pub use named::NamedConvention;
pub use normalization::BasisNormalization;
