//! Mirrors by the method of Blinn and Newell.

use lobe_env::EnvMap;
use lobe_sh::{Dir, Rgb};

use crate::{Shading, SurfacePoint};

/// A perfect mirror that looks its reflected direction up in a lat-long picture.
///
/// ```text
///   r = 2 (n·v) n - v        u = ½ - atan2(r_y, r_x)/(2π)        v = acos(r_z)/π        L = picture(u, v)
/// ```
///
/// Two arc functions for each point; texels crowd at the poles, and a bilinear lookup there mixes directions that are
/// half a turn apart in azimuth. [Blinn and Newell 1976] have no sign conventions of their own to follow: these are
/// those of [`lobe_env::lat_long`]. Against the light itself the error falls with the square of the texel size (test
/// `mirrors_agree_with_the_traced_reflection_to_second_order`).
#[derive(Clone, Debug, PartialEq)]
pub struct BlinnNewell {
    /// The picture of the surroundings.
    pub map: EnvMap,
}

impl BlinnNewell {
    /// The mirror whose picture has `2 height` x `height` samples of `source`.
    ///
    /// # Panics
    /// If `height` is 0.
    #[must_use]
    pub fn sampled(height: usize, source: impl Fn(Dir) -> Rgb<f32> + Sync) -> Self {
        Self { map: EnvMap::from_fn(2 * height, height, source) }
    }
}

impl Shading for BlinnNewell {
    fn radiance(&self, at: &SurfacePoint) -> Rgb<f32> {
        self.map.radiance(at.reflected())
    }
}
