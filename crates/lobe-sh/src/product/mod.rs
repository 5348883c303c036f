//! TODO

#[cfg(test)]
pub(crate) mod cost;
pub(crate) mod gaunt;
pub(crate) mod generated;
pub(crate) mod grid;
pub(crate) mod matrix;
pub(crate) mod product;
