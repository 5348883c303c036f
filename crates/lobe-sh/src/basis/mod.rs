//! TODO room basis.

pub(crate) mod basis;
pub(crate) mod complex;
pub(crate) mod index;
pub(crate) mod legendre;
pub(crate) mod second_order;
