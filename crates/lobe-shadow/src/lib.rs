//! Occluders that move: shadow fields, sphere sets, and what many of them leave of the sky.
//!
//! A baked transfer holds the shadows of a scene that stands still. Here every entity carries what it does to light around
//! it, and a receiver combines those of all entities when it is asked, wherever they have moved.

mod description;
mod error;
mod placement;
mod track;

pub use description::{EntityDescription, SceneDescription};
pub use error::ShadowError;
pub use placement::Placement;
pub use track::{Key, Track};
