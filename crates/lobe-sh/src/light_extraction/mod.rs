//! Directional lights found in an expansion.
//!
//! Read `extract` first. It finds local maxima (`peaks`), solves for intensities (`light_fit`) and may improve
//! both together (`refine`, Levenberg-Marquardt). Uses `basis`, `expansion`, `light`, `solver` and `sphere`.

pub(crate) mod extract;
pub(crate) mod light_fit;
pub(crate) mod peaks;
pub(crate) mod refine;

pub use extract::{LightChoice, LightFitOptions, extract_light, extract_light_per_channel, extract_lights, fit_lights};
pub use light_fit::{DirectionalLight, LightFit, LightMetric};
pub use peaks::{Peak, PeakSearch, local_maxima};
