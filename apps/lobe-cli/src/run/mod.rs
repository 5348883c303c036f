//! TODO room run.

pub(crate) mod bake_watch;
pub(crate) mod bake_write;
pub(crate) mod ctrl_c;
pub(crate) mod failure;
pub(crate) mod talk;
