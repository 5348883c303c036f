//! TODO

pub(crate) mod branch_and_bound;
pub(crate) mod cap_bound;
pub(crate) mod extremum;
pub(crate) mod quadratic_form;
pub(crate) mod quartic_bound;
pub(crate) mod taylor;
