//! TODO room compare.

pub(crate) mod compare;
pub(crate) mod flip;
pub(crate) mod hdr_flip;
pub(crate) mod roots;
pub(crate) mod z_test;
