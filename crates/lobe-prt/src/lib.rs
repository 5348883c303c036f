//! Precomputed radiance transfer: what a scene does to distant light, baked once and applied to any light.
//!
//! Light from far away is an expansion L; what a point of a scene sends back of it is another, its transfer T, and the exit
//! radiance is their scalar product `B = Σᵢ Lᵢ Tᵢ`. Shadows and interreflections are in T: turning the light costs nothing.
//!
//! # Where to find what
//!
//! | purpose | item |
//! |---|---|
//! | what receivers do to light | [`Transfer`], [`Channels`] |

mod error;
mod transfer;

pub use error::PrtError;
pub use transfer::{Channels, Transfer};
