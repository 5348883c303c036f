//! `lobe export`: light and shaders in the forms of other programs.
//!
//! `engines` writes the light of a map for engines, `shader` functions for shaders; `export` tells them apart. Uses
//! `args`, `env`, `render` and `run`.

mod engines;
pub(crate) mod export;
mod shader;
