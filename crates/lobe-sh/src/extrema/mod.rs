//! The extreme values of a function on the sphere, with proof.
//!
//! Read [`extremum`], then [`branch_and_bound`]. Three bands are a [`quadratic_form`] and solved exactly; more bands
//! are searched, with lower bounds on caps ([`cap_bound`]) of second order and, from the expansion in [`taylor`], of
//! fourth order ([`quartic_bound`]). Uses `basis`, `rotation` and `sphere`.

pub(crate) mod branch_and_bound;
pub(crate) mod cap_bound;
pub(crate) mod extremum;
pub(crate) mod quadratic_form;
pub(crate) mod quartic_bound;
pub(crate) mod taylor;
