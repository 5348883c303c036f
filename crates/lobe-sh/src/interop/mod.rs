//! Conversions from and to other libraries, each behind a feature of its name.
//!
//! `serde_values` writes and reads public values, `plain_bytes` (`bytemuck`) lets colors and expansions be copied to
//! buffers, `vectors` converts directions, colors and rotations from and to `glam` and `mint`. Uses `encoding`, `expansion`,
//! `filter`, `light`, `ringing`, `rotation` and `sphere`.

#[cfg(feature = "bytemuck")]
pub(crate) mod plain_bytes;
#[cfg(feature = "serde")]
pub(crate) mod serde_values;
#[cfg(any(feature = "glam", feature = "mint"))]
pub(crate) mod vectors;
