//! Mirrors that look the reflected direction up in one map: lat-long (Blinn and Newell), sphere map, cube map.

use lobe_env::{CubeMap, EnvMap, MappedMap, Mapping};
use lobe_sh::{Dir, Rgb};

use crate::gallery::exhibit::{Shading, SurfacePoint};

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

/// A perfect mirror that looks its reflected direction up on the faces of a cube.
///
/// ```text
///   r = 2 (n·v) n - v        L = face of the largest |r_i|, at the other two components of r/|r_i|
/// ```
///
/// One division for each point, no direction is singular, and the texels differ in solid angle by no more than `3√3`:
/// why cube maps displaced the others. Across edges and corners the lookup goes on with the neighboring face
/// ([`MappedMap::radiance`](lobe_env::MappedMap::radiance)). The error falls with the square of the texel size (test
/// `mirrors_agree_with_the_traced_reflection_to_second_order`). [Greene 1986].
#[derive(Clone, Debug, PartialEq)]
pub struct CubeMapped {
    /// The faces.
    pub map: CubeMap,
}

impl CubeMapped {
    /// The mirror whose faces have `size` x `size` samples of `source`.
    ///
    /// # Panics
    /// If `size` is 0.
    #[must_use]
    pub fn sampled(size: usize, source: impl Fn(Dir) -> Rgb<f32> + Sync) -> Self {
        Self { map: CubeMap::from_fn(size, source) }
    }
}

impl Shading for CubeMapped {
    fn radiance(&self, at: &SurfacePoint) -> Rgb<f32> {
        self.map.radiance(at.reflected())
    }
}
