//! Finishing: what is done with the texels of a lightmap once they are baked.
//!
//! Read `finish` first. `denoise` averages texels that differ by their noise alone; `seams` finds the places where two
//! charts show one edge, and `stitch` makes them agree there. Uses `receivers` and `transfer`.

pub(crate) mod denoise;
pub(crate) mod finish;
pub(crate) mod seams;
pub(crate) mod stitch;
