//! `lobe sh`: commands on expansions in .sh.json files, a file each. Uses `args` and `run`.

pub(crate) mod add;
pub(crate) mod convert;
pub(crate) mod convolve;
pub(crate) mod dering;
pub(crate) mod encode;
pub(crate) mod encodings;
pub(crate) mod eval;
pub(crate) mod exp;
pub(crate) mod incident;
pub(crate) mod info;
pub(crate) mod lights;
pub(crate) mod log;
pub(crate) mod min;
pub(crate) mod mirror;
pub(crate) mod peaks;
pub(crate) mod plot;
pub(crate) mod product;
pub(crate) mod rotate;
pub(crate) mod scale;
pub(crate) mod window;
