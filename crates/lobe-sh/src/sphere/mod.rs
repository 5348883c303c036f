//! TODO

pub(crate) mod dir;
pub(crate) mod point_sets;
pub(crate) mod quadrature;
pub(crate) mod triangulation;
pub(crate) mod vector;
