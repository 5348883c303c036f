//! Removing ringing: windows that make a function non-negative.
//!
//! Read `dering` first. The least change comes from `cutting_planes` (Kelley's method) at any order and from
//! `quadratic_dering` at order 3, `batch_dering` by `lane_dering` and `lane_newton` for many at once; `sloan_table` is the published way. `content_window`
//! keeps the light as it is. `DeringOutcome` says how an attempt ended. Uses `basis`, `batch`, `expansion`, `extrema`, `filter`,
//! `rotation`, `simd`, `solver` and `sphere`.

#[cfg(feature = "batch")]
pub(crate) mod batch_dering;
pub(crate) mod content_window;
pub(crate) mod cutting_planes;
pub(crate) mod dering;
#[cfg(feature = "batch")]
pub(crate) mod lane_dering;
#[cfg(feature = "simd")]
pub(crate) mod lane_newton;
pub(crate) mod quadratic_dering;
pub(crate) mod sloan_table;

pub use content_window::ContentWindow;
pub use dering::{DeringMethod, DeringOptions, DeringReport, WindowFamily, dering_in_place};
pub use sloan_table::{conservative_minimum, dering_table_factors};

/// The depth below zero, relative to the mean, at which a function still counts as non-negative: rounding the
/// coefficients to `f32` lowers a function whose minimum is exactly 0 by as much.
pub const DERING_ALLOWED: f64 = 5e-7;

/// The outcome of dering: whether a function was changed and, if not, why.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum DeringOutcome {
    /// It was not negative (to within [`DERING_ALLOWED`]), and no bit of it was changed.
    Unchanged,
    /// It was negative somewhere and was windowed; now it is not.
    Windowed,
    /// A channel is not zero, but its mean is not positive: no window makes such a function non-negative. No bit of it
    /// was changed.
    MeanNotPositive {
        /// The first such channel.
        channel: usize,
    },
    /// A coefficient is not a finite number. No bit of the function was changed.
    NotFinite,
    /// [`DeringMethod::Table`] was asked for a function of more than three bands, or for
    /// one that needs a stronger window than the last of the table, which the irradiance of no light does. No bit of the function was
    /// changed.
    BeyondTable,
}
