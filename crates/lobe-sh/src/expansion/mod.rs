//! Functions on the sphere by their coefficients.
//!
//! Read [`expansion`] first: the trait that both kinds share. [`sh`] has the order in its type, [`sh_vec`] at run time,
//! [`zonal`] one coefficient for each band. [`gradient`] has slopes, [`quantity`] the physical meaning. Uses `basis` and `sphere`.

pub(crate) mod expansion;
pub(crate) mod gradient;
pub(crate) mod quantity;
pub(crate) mod sh;
pub(crate) mod sh_vec;
pub(crate) mod zonal;
