//! Conversions from and to other libraries, each behind a feature of its name.
//!
//! `serde_values` writes and reads public values, `plain_bytes` (`bytemuck`) lets colors and expansions be copied to
//! buffers, `glam_vectors` and `mint_vectors` convert directions, colors and rotations. Uses `encoding`, `expansion`,
//! `filter`, `light`, `ringing`, `rotation` and `sphere`.

#[cfg(feature = "glam")]
pub(crate) mod glam_vectors;
#[cfg(feature = "mint")]
pub(crate) mod mint_vectors;
#[cfg(feature = "bytemuck")]
pub(crate) mod plain_bytes;
#[cfg(feature = "serde")]
pub(crate) mod serde_values;
