//! Functions on the sphere by their coefficients.
//!
//! Read `expansion` first: the trait that both kinds share. `sh` has the order in its type, `sh_vec` at run time,
//! `zonal` one coefficient for each band. `gradient` has slopes, `quantity` the physical meaning. Uses `basis` and `sphere`.

pub(crate) mod expansion;
pub(crate) mod gradient;
pub(crate) mod quantity;
pub(crate) mod sh;
pub(crate) mod sh_vec;
pub(crate) mod zonal;

pub use expansion::{Expansion, FixedOrder, optimal_linear_direction};
pub use gradient::{eval_basis_gradients, eval_with_gradient};
pub use quantity::Quantity;
pub use sh::{Sh, ShL0, ShL1, ShL2, ShL3, ShL4, ShL5, ShL6, ShL7, ShL8, ShL9};
pub use sh_vec::ShVec;
pub use zonal::Zonal;
