//! Products of functions.
//!
//! Read `product` first: it picks one of three routes, straight-line code (`straight_line` of `generated`, which `cargo xtask
//! tables` writes; `fused_pair` and `fused` in `f32`), the sparse tensor of Gaunt coefficients (`gaunt`) or a
//! `grid`, the rows of which `grid_fft` transforms at high orders by `row_columns` and FFT. `matrix` multiplies
//! many functions by one. `lane_product` multiplies sixteen pairs at once (`lanes`, generated too), `lane_rows`
//! one pair of order 7 to 10 by wide instructions. Uses `basis`, `expansion`, `simd` and
//! `sphere`.

#[cfg(test)]
pub(crate) mod cost;
#[cfg(feature = "simd")]
pub(crate) mod fused;
#[cfg(feature = "simd")]
pub(crate) mod fused_pair;
pub(crate) mod gaunt;
pub(crate) mod generated;
pub(crate) mod grid;
#[cfg(feature = "fft")]
pub(crate) mod grid_fft;
#[cfg(feature = "batch")]
pub(crate) mod lane_product;
#[cfg(feature = "simd")]
pub(crate) mod lane_rows;
#[cfg(feature = "simd")]
pub(crate) mod lanes;
pub(crate) mod matrix;
pub(crate) mod product;
#[cfg(feature = "fft")]
pub(crate) mod row_columns;
pub(crate) mod straight_line;

pub use gaunt::{GauntCoefficient, GauntTensor, MAX_GAUNT_ORDER, gaunt_coefficient};
pub use grid::product_on_grid;
#[cfg(feature = "batch")]
pub use lane_product::product_of_blocks;
pub use matrix::ProductMatrix;
pub use product::{product_into, square_into, zonal_product_into};
