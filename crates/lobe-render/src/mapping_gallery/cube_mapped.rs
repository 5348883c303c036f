//! Mirrors by cube mapping.

use lobe_env::CubeMap;
use lobe_sh::{Dir, Rgb};

use crate::{Shading, SurfacePoint};

/// A perfect mirror that looks its reflected direction up on the faces of a cube.
///
/// ```text
///   r = 2 (n·v) n - v        L = face of the largest |r_i|, at the other two components of r/|r_i|
/// ```
///
/// One division for each point, no direction is singular, and the texels differ in solid angle by no more than `3√3`:
/// why cube maps displaced the others. Across edges and corners the lookup goes on with the neighboring face
/// ([`CubeMap::radiance`]). The error falls with the square of the texel size (test
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
