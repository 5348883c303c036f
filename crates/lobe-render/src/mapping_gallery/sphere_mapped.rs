//! Mirrors by sphere mapping.

use lobe_env::{MappedMap, Mapping};
use lobe_sh::{Dir, Rgb};

use crate::{Shading, SurfacePoint};

/// A perfect mirror that looks its reflected direction up in the picture of a mirror ball.
///
/// ```text
///   r = 2 (n·v) n - v        m = (r + e)/|r + e|        L = picture at (m·right, m·up) of the disc
/// ```
///
/// `m` is the normal at which the ball of the picture, seen from `e`, mirrors `r`. For an orthographic eye at `e`
/// itself `m = n`: then the normal alone finds the texel, as fixed-function hardware did it. Here `r` is looked up, so
/// the eye may stand elsewhere; what suffers is the direction behind the ball, `r = -e`, which the whole rim of the
/// picture shows. Around it neighboring directions are far apart in the picture, one texel spans the square root of its
/// size, and the error falls with the texel size alone; elsewhere with its square (test
/// `mirrors_agree_with_the_traced_reflection_to_second_order`).
///
/// The pictures are [`Mapping::Sphere`] (`e = -y`, OpenGL's) and [`Mapping::MirrorBall`] (`e = -x`).
#[derive(Clone, Debug, PartialEq)]
pub struct SphereMapped {
    /// The picture of the ball.
    pub map: MappedMap,
}

impl SphereMapped {
    /// The mirror whose picture, the ball seen from -x, has `size` x `size` samples of `source`.
    ///
    /// # Panics
    /// If `size` is 0.
    #[must_use]
    pub fn sampled(size: usize, source: impl Fn(Dir) -> Rgb<f32> + Sync) -> Self {
        Self { map: MappedMap::from_fn(Mapping::MirrorBall, size, size, source) }
    }
}

impl Shading for SphereMapped {
    fn radiance(&self, at: &SurfacePoint) -> Rgb<f32> {
        self.map.radiance(at.reflected())
    }
}
