//! Options of unwrapping.

use derive_setters::Setters;
use serde::{Deserialize, Serialize};

use crate::error::SceneError;

/// Options of [`Scene::unwrapped`](crate::Scene::unwrapped).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Setters)]
#[serde(default)]
#[non_exhaustive]
pub struct UnwrapOptions {
    /// Width and height of the lightmap in texels, 1 to 2¹⁴.
    pub texels: usize,
    /// Empty texels around each chart, 0 to 256: charts are twice as far apart. From 1 on, the four texels around any
    /// place of a chart are its own.
    pub padding: u32,
    /// The side of a texel on a surface, in the unit of the scene. `None` is the smallest with which all charts fit.
    pub texel_size: Option<f64>,
    /// The largest angle between a triangle and the mean of its chart, in degrees, above 0 and below 90: smaller ones
    /// distort less, and cut more.
    pub chart_angle: f64,
}

impl UnwrapOptions {
    /// The widest lightmap.
    pub const MOST_TEXELS: usize = 1 << 14;
    /// The most empty texels around a chart.
    pub const MOST_PADDING: u32 = 256;

    /// Refuses options out of range.
    pub(crate) fn check(&self) -> Result<(), SceneError> {
        let Self { texels, padding, texel_size, chart_angle } = self;
        let refused = |message: String| Err(SceneError::Options(message));
        if !(1..=Self::MOST_TEXELS).contains(texels) {
            return refused(format!("expected a width of 1 to {} texels, found {texels}", Self::MOST_TEXELS));
        }
        if *padding > Self::MOST_PADDING {
            return refused(format!("expected a padding of 0 to {} texels, found {padding}", Self::MOST_PADDING));
        }
        if !(*chart_angle > 0.0 && *chart_angle < 90.0) {
            return refused(format!("expected a chart angle above 0 and below 90 degrees, found {chart_angle}"));
        }
        match texel_size {
            Some(size) if !(*size > 0.0 && size.is_finite()) => {
                refused(format!("expected a texel size above 0, found {size}"))
            }
            _ => Ok(()),
        }
    }
}

impl Default for UnwrapOptions {
    /// 1024 texels, two of them around each chart, as small as they can be, and charts of up to 60°.
    fn default() -> Self {
        Self { texels: 1024, padding: 2, texel_size: None, chart_angle: 60.0 }
    }
}
