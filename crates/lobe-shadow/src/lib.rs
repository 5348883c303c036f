//! Occluders that move: shadow fields, sphere sets, and what many of them leave of the sky.
//!
//! A baked transfer holds the shadows of a scene that stands still. Here every entity carries what it does to light around
//! it, and a receiver combines those of all entities when it is asked, wherever they have moved.

mod error;
mod placement;

pub use error::ShadowError;
pub use placement::Placement;
