//! TODO

pub(crate) mod expansion;
pub(crate) mod gradient;
pub(crate) mod quantity;
pub(crate) mod sh;
pub(crate) mod sh_vec;
pub(crate) mod zonal;
