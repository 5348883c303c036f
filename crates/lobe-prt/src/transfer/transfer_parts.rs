//! The parts of transfer that a file holds.

use serde::{Deserialize, Serialize};

/// The parts of transfer that a file holds.
///
/// ```text
///   T = T_direct + T_reflected
/// ```
///
/// Light reaches the receiver directly, or from a surface that reflects it. Both parts see the light of a sky. A sun
/// lights directly by rays, which cast sharp shadows, and by `T_reflected` alone.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum TransferParts {
    /// Their sum.
    #[default]
    #[serde(rename = "whole")]
    Whole,
    /// Their sum, and the direct part.
    #[serde(rename = "direct,reflected")]
    DirectAndReflected,
}
