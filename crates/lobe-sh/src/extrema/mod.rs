//! The extreme values of a function on the sphere, with proof.
//!
//! Read `Extremum`, then `branch_and_bound`. Three bands are a `quadratic_form` and solved exactly by `quadratic_minimum`, several at once
//! as `lane_form`; more bands are searched, with lower bounds on caps (`cap_bound`) of second order and, from the expansion in `taylor`, of
//! fourth order (`quartic_bound`). Uses `basis`, `rotation`, `simd` and `sphere`.

pub(crate) mod branch_and_bound;
pub(crate) mod cap_bound;
#[cfg(feature = "simd")]
pub(crate) mod lane_form;
pub(crate) mod quadratic_form;
pub(crate) mod quadratic_minimum;
pub(crate) mod quartic_bound;
pub(crate) mod taylor;

pub use branch_and_bound::{certified_maximum, certified_minimum};

use crate::sphere::Dir;

/// An interval that contains the least value of a function ([`certified_minimum`]) or its
/// greatest ([`certified_maximum`]), and a direction towards which the function has a value
/// in it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Extremum {
    /// The extreme value is not below this.
    pub lo: f64,
    /// The extreme value is not above this.
    pub hi: f64,
    /// The direction in which it was found; one of them, if several are equal.
    pub dir: Dir,
}

impl Extremum {
    /// The interval for a function with a coefficient that is not a finite number: nothing is known.
    pub(crate) const UNKNOWN: Self = Self { lo: f64::NEG_INFINITY, hi: f64::INFINITY, dir: Dir::Z };
}
