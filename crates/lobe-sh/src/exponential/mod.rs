//! Exponentials and logarithms of functions on the sphere: a product of many functions as a sum of their logarithms.
//!
//! Read [`logarithm`] first, then [`exponential`], which lists the methods. [`matrix_function`] is what both rest on,
//! [`optimal_linear`] the table of one method. Uses `basis`, `expansion`, `product` and `sphere`.

pub(crate) mod exponential;
pub(crate) mod logarithm;
mod matrix_function;
mod optimal_linear;
