//! The size of a picture, its samples, and what is kept of it.

use derive_setters::Setters;

use crate::GpuError;

/// The size and the sampling of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Setters)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default))]
#[non_exhaustive]
pub struct SceneViewOptions {
    /// Columns, at least 1.
    pub width: u32,
    /// Rows, at least 1.
    pub height: u32,
    /// Samples per pixel and axis, at least 1, on the regular grid on which `lobe-render` has its rays. Default: 2.
    pub rays: u32,
    /// What is kept. Default: [`ViewOutput::LightAndDisplay`].
    pub output: ViewOutput,
}

/// What a view keeps of a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
#[non_exhaustive]
pub enum ViewOutput {
    /// The picture in linear light, and what a display shows of it.
    #[default]
    LightAndDisplay,
    /// Only what a display shows, a quarter of the bytes: for a window in which things move. Tones are mapped where surfaces are
    /// drawn, or where samples become pixels.
    Display,
}

impl Default for SceneViewOptions {
    fn default() -> Self {
        Self { width: 512, height: 384, rays: 2, output: ViewOutput::default() }
    }
}

impl SceneViewOptions {
    /// The samples along the sides of the picture, none of which is empty.
    pub(crate) fn samples(&self) -> Result<[u32; 2], GpuError> {
        let Self { width, height, rays, .. } = *self;
        if width > 0 && height > 0 && rays > 0 {
            return Ok([width.saturating_mul(rays), height.saturating_mul(rays)]);
        }
        let found = format!("{width} x {height} with {rays} rays along an axis");
        Err(GpuError::Options(format!("expected a picture with pixels and rays, found {found}")))
    }
}
