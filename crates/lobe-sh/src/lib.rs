//! Functions on the sphere as a few numbers each: the real spherical-harmonic basis, expansions in it, and what
//! lighting does with them.
//!
//! A function `f(s)` of the direction `s` is kept as the coefficients of `f(s) = Σ_i f_i y_i(s)`. Then an integral of a
//! product is a dot product, light from a whole sky onto a surface is one multiplication per band, and a rotation is
//! exact.
//!
//! The basis `y_i` is real and orthonormal with the Condon-Shortley phase kept, as in Sloan's papers, D3DX and
//! DirectXMath: `y_1 .. y_3 = √(3/4π) (-y, z, -x)`. The flat index is `i = l(l+1) + m` for band `l`; **order** `n`
//! counts bands, so that there are `n²` coefficients; +z is up. `CONVENTIONS.md` at the root of the repository has the
//! figures.
//!
//! # Example: one function
//!
//! ```
//! use lobe_sh::{Dir, Expansion as _, project};
//!
//! // Brighter above than below; of degree 1 in x, y, z, so that two bands hold all of it.
//! let sky = project(2, 1, |s| 1.0 + 0.5 * s.z());
//! assert!((sky.eval(Dir::Z) - 1.5).abs() < 1e-14);
//! assert!((sky.mean() - 1.0).abs() < 1e-14);
//! ```
//!
//! # Example: what a surface receives, in color
//!
//! ```
//! use lobe_sh::{Dir, Expansion as _, Rgb, Rotation, ShL2, Zonal};
//!
//! // A bluish sky and a red light of irradiance 1 from +x. ShL2 has bands 0 to 2.
//! let light = ShL2::constant(Rgb::new(0.2, 0.3, 0.5)) + ShL2::impulse(Dir::X, Rgb::new(1.0, 0.1, 0.1));
//! // The whole sky turns by 90° about +z.
//! let light = light.rotated(&Rotation::from_axis_angle(Dir::Z, 90.0_f64.to_radians()));
//! // Irradiance E for every normal at once; a white diffuse surface sends E/π back.
//! let irradiance = light.convolved(&Zonal::clamped_cosine(3));
//! let (lit, shaded) = (irradiance.eval(Dir::Y), irradiance.eval(-Dir::Y));
//! assert!(lit.r > 2.0 * shaded.r, "{lit:?} {shaded:?}");
//! ```
//!
//! # Example: measurements, and how far to trust them
//!
//! ```
//! use lobe_sh::projection::{Conditioning, MonteCarloOptions, least_squares, project_monte_carlo};
//! use lobe_sh::{Dir, Expansion as _, Zonal};
//!
//! // A lamp that can only be sampled: 120° wide, with a hard edge.
//! let lamp = |s: Dir| -> f64 { if s.dot(Dir::X) > 0.5 { 1.0 } else { 0.0 } };
//! let estimate = project_monte_carlo(4, &MonteCarloOptions::default().samples(4096), lamp);
//! let exact = Zonal::project(4, &[0.5], 4, |t| if t > 0.5 { 1.0 } else { 0.0 }).towards(Dir::X, 1.0);
//! let error = (estimate.sh[0] - exact[0]).abs();
//! assert!(error < 4.0 * estimate.standard_error[0], "{error} against {}", estimate.standard_error[0]);
//!
//! // A light meter turned to 30 directions; the fit says whether they suffice for nine unknowns.
//! let irradiance = exact.convolved(&Zonal::clamped_cosine(4));
//! let readings = (0..30).map(|k| Dir::from_angles(0.1 * f64::from(k), 2.4 * f64::from(k)));
//! let fit = least_squares(3, readings.map(|s| (s, irradiance.eval(s), 1.0)));
//! assert_eq!(fit.conditioning, Conditioning::Well);
//! assert!((fit.sh[0] - irradiance[0]).abs() < 1e-12 && fit.residual < 1e-12);
//! ```
//!
//! # Index
//!
//! What almost every program needs stands at the root, all else in the module of its field.
//!
//! | to | use |
//! |---|---|
//! | hold a function | [`Sh`] (order fixed, [`ShL0`] to [`ShL9`]), [`ShVec`] (order at run time), [`Zonal`] (symmetric about an axis) |
//! | get a type of fixed order from a function | [`project_as`], [`ShVec::product_as`], [`Zonal::towards_as`], [`Light::project_as`]: any [`FixedOrder`] |
//! | exchange data with an engine | `From` and `Into` of arrays, `[[f32; 3]; 9]`; features `glam`, `mint`, `bytemuck`, `serde` |
//! | read, compare, evaluate any of the first two | [`Expansion`]; coefficients are [`Coefficient`]s: `f32`, `f64`, [`Rgb`] |
//! | hold and compute many functions at once | `batch::ShBatch`, `batch::DirBatch` (feature `batch`): basis, rotation, products by the widest instructions of the machine (feature `simd`) |
//! | evaluate many functions towards many vectors | `batch::Functions` of numbers or colors one after the other, towards `basis::Vectors` (feature `simd`) |
//! | evaluate the basis | [`eval_basis`], [`Basis`](basis::Basis) (many directions), [`eval_basis_gradients`](expansion::eval_basis_gradients), [`eval_complex`](basis::eval_complex), [`legendre`](fn@basis::legendre) |
//! | number bands and coefficients | [`coefficient_index`](basis::coefficient_index), [`band_range`](basis::band_range), [`band_and_m`](basis::band_and_m), [`coefficient_count`](basis::coefficient_count), [`order_of`](basis::order_of) |
//! | turn a function into an expansion | [`fn@project`] (exact), [`project_to_accuracy`](projection::project_to_accuracy), [`project_monte_carlo`](projection::project_monte_carlo), [`Zonal::project`] |
//! | turn samples into one | [`least_squares`](fn@projection::least_squares) |
//! | integrate | [`SphereQuadrature`](sphere::SphereQuadrature), [`gauss_legendre`](sphere::gauss_legendre) |
//! | keep irradiance in a few numbers | [`IrradianceEncoding`](encoding::IrradianceEncoding): [`AmbientCube`](encoding::AmbientCube), [`NonLinearL1`](encoding::NonLinearL1), [`Zh3`](encoding::Zh3), [`Ahd`](encoding::Ahd), [`HBasis`](encoding::HBasis), [`Hl2`](encoding::Hl2); [`encoding_error`](encoding::encoding_error) |
//! | give irradiance to a shader | [`PackedIrradiance`](encoding::PackedIrradiance), [`IrradianceMatrix`](encoding::IrradianceMatrix), [`IrradiancePolynomial`](encoding::IrradiancePolynomial); of order 5 [`PackedIrradiance5`](encoding::PackedIrradiance5) |
//! | blur: irradiance, Phong, GGX | [`ShVec::convolved`] with [`Zonal::clamped_cosine`], [`Zonal::phong`], [`Zonal::ggx`] |
//! | rotate | [`ShVec::rotated`] by a [`Rotation`] (Euler angles, quaternions), [`RotationMatrices`](rotation::RotationMatrices) (Ivanic and Ruedenberg, for many expansions), [`Zonal::towards`] |
//! | mirror, exchange axes | [`ShVec::permuted`] by an [`AxisPermutation`](rotation::AxisPermutation), [`ShVec::mirrored`], [`mirror_in_place`](rotation::mirror_in_place), [`quarter_turn_in_place`](rotation::quarter_turn_in_place) |
//! | multiply functions | [`ShVec::product`], [`product_into`](product::product_into), of many `product::product_of_blocks`, [`product_on_grid`](product::product_on_grid), [`ProductMatrix`](product::ProductMatrix); Gaunt coefficients: [`gaunt_coefficient`](product::gaunt_coefficient), [`GauntTensor`](product::GauntTensor) |
//! | combine shadows | [`logarithm`](exponential::logarithm), of many at once `exponential::logarithm_batch_in_place`, [`Zonal::sphere_logarithm`], [`ZonalLogarithm`](exponential::ZonalLogarithm), [`Exponential`](exponential::Exponential) ([`ExpMethod`](exponential::ExpMethod), [`OptimalLinear`](exponential::OptimalLinear)) |
//! | make light | [`Light`] with its [`Normalization`](light::Normalization); [`Zonal::cone`], [`Zonal::soft_cone`], [`SphericalPolygon`](light::SphericalPolygon) |
//! | find lights in an expansion | [`extract_light`](light_extraction::extract_light), [`extract_lights`](light_extraction::extract_lights), [`fit_lights`](light_extraction::fit_lights); [`local_maxima`](light_extraction::local_maxima) |
//! | exchange ringing for blur | [`Window`], [`ShVec::windowed`], [`ContentWindow`](ringing::ContentWindow) (none towards the light), [`Window::squared_laplacian_of`], [`width_of_peak`](filter::width_of_peak), [`dering_table_factors`](ringing::dering_table_factors) |
//! | find extreme values | [`certified_minimum`](extrema::certified_minimum), [`certified_maximum`](extrema::certified_maximum), [`conservative_minimum`](ringing::conservative_minimum) |
//! | remove ringing below zero | [`ShVec::deringed`], [`dering_in_place`](ringing::dering_in_place) with its [`DeringReport`](ringing::DeringReport); of many functions `ShBatch::dering_in_place` |
//! | exchange coefficients with pyshtools, healpy, e3nn, Ambisonics | [`NamedConvention`](convention::NamedConvention), [`Convention`](convention::Convention): basis, normalization, phase, layout, axes |
//! | read and write `.sh.json` | `sh_json::read_sh_json`, `sh_json::write_sh_json` (feature `json`) |
//!
//! # Types on top, slices below
//!
//! What is done with a function is a method of both types, `light.rotated(&turn).convolved(&kernel).deringed()`.
//!
//! A shader's order is known at compile time, that of a file at run time. One type for both would need a heap
//! allocation for each value or a fixed maximum. So there are two types, and every operation is written once, for a
//! slice of `n²` coefficients (`_into`, `_in_place`), which serves both types and the caller's own arrays and vertex
//! buffers without a copy. The price: stable Rust cannot compute `n²` in a type, so that [`Sh`] counts coefficients;
//! and a slice of the wrong length is found at run time, by a panic that names it.
//!
//! Coefficients have the caller's type, usually `f32`. Sums over many terms and all tables are `f64`; only the kernels
//! for many directions or expansions at once stay in `f32`, for speed.
//!
//! The mathematics has no errors: degenerate cases (order 0, no samples, poles) have a documented value. Errors are for
//! data from outside, such as files and matrices that are no rotations.
//!
//! # Without the standard library
//!
//! With `default-features = false` and the feature `libm` the crate needs `core` and `alloc` only. Elementary functions then come
//! from `libm`, so that results may differ in the last place, and files are left out.

#![cfg_attr(not(any(feature = "std", test)), no_std)]

#[cfg(not(any(feature = "std", feature = "libm")))]
compile_error!("lobe-sh needs the feature `std`, or `libm` where there is no standard library");

#[macro_use]
extern crate alloc;

pub mod basis;
#[cfg(feature = "batch")]
pub mod batch;
mod by_type;
pub mod convention;
pub mod encoding;
mod error;
pub mod expansion;
pub mod exponential;
pub mod extrema;
pub mod filter;
mod interop;
pub mod light;
pub mod light_extraction;
mod once;
mod prelude;
#[cfg(feature = "simd")]
#[doc(hidden)]
pub mod probes;
pub mod product;
pub mod projection;
pub mod ringing;
pub mod rotation;
mod scalar;
mod setters;
#[cfg(feature = "json")]
pub mod sh_json;
pub mod simd;
mod solver;
pub mod sphere;
mod verbs;

/// The example of README.md, compiled and run as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

pub use basis::eval_basis;
pub use error::ShError;
pub use expansion::{
    Expansion, FixedOrder, Sh, ShL0, ShL1, ShL2, ShL3, ShL4, ShL5, ShL6, ShL7, ShL8, ShL9, ShVec, Zonal,
};
pub use filter::Window;
pub use light::Light;
pub use projection::{project, project_as};
pub use rotation::Rotation;
pub use scalar::{Coefficient, Real, Rgb};
pub use sphere::Dir;
