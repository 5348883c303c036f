//! The size of a picture, its samples, and what is kept of it.

use derive_setters::Setters;

use crate::error::GpuError;

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
    /// Whether silhouettes are smoothed by four samples of each pixel (multisampling, MSAA), where one ray a pixel is
    /// drawn for [`ViewOutput::Display`] alone. Surfaces are shaded once a pixel; four times the bytes of the display
    /// and of depth. Linear light is not drawn so, as few devices can: more [rays](SceneViewOptions::rays) smooth that.
    /// Default: true.
    pub multisample: bool,
    /// Texels along each side of the map of what a sun sees, of a view that shows suns
    /// [apart](crate::SunsApart): at least 16, eight bytes for each texel. Default: 1024.
    pub shadow_side: u32,
}

/// Samples of a pixel, which every device can draw.
const SAMPLES: u32 = 4;

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
        Self { width: 512, height: 384, rays: 2, output: ViewOutput::default(), multisample: true, shadow_side: 1024 }
    }
}

impl SceneViewOptions {
    /// The samples of depth in each place that is shaded: one unless silhouettes are smoothed by several.
    pub(crate) fn samples_of_shade(&self) -> u32 {
        if self.multisample && self.rays == 1 && self.output == ViewOutput::Display { SAMPLES } else { 1 }
    }

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
