//! What a user changes in the room.

use serde::{Deserialize, Serialize};

use crate::rooms::light::Taming;

/// All that is kept from one start to the next.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
#[non_exhaustive]
pub struct SkyEdits {
    /// Number of bands.
    pub order: usize,
    /// What is done to the expansion.
    pub taming: Taming,
    /// The name of the mapping that is shown unfolded.
    pub mapping: String,
    /// Stops of exposure.
    pub exposure: f64,
    /// Lights that are looked for in the expansion.
    pub lights: usize,
}

impl Default for SkyEdits {
    fn default() -> Self {
        Self { order: 4, taming: Taming::None, mapping: "octahedral".into(), exposure: 0.0, lights: 2 }
    }
}
