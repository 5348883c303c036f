//! TODO room sphere.

pub(crate) mod dir;
pub(crate) mod fibonacci;
pub(crate) mod quadrature;
pub(crate) mod thomson;
pub(crate) mod triangulation;
pub(crate) mod vector;
