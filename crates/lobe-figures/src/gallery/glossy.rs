//! Glossy reflection by a prefiltered environment map and the split sum.

use lobe_env::{CubeMipChain, DfgTable};
use lobe_sh::{Coefficient, Dir, Rgb};

use crate::gallery::exhibit::{Shading, SurfacePoint};

/// A glossy surface that looks its reflected direction up in a map that was prefiltered for its roughness.
///
/// ```text
///   L = (F₀ A + B) P(r, level)        r = 2 (n·v) n - v        A, B of DfgTable at (n·v, roughness)
/// ```
///
/// `P` is the chain, linear between its two nearest levels. The split sum ([Karis 2013]): the mean of the light under
/// the lobe times the directional albedo. Exact for uniform light and for a mirror; elsewhere the lobe has one shape at
/// every angle, where the true lobe of a surface seen at a slant is long and narrow.
#[derive(Clone, Copy, Debug)]
pub struct Glossy<'a> {
    /// The prefiltered maps.
    pub chain: &'a CubeMipChain,
    /// The level that was prefiltered for the roughness; whole numbers are levels, 0 the sharpest.
    pub level: f64,
    /// The roughness `√α` of GGX in `[0, 1]`.
    pub roughness: f64,
    /// The reflectance along the normal.
    pub f0: Rgb<f64>,
    /// The table of `A` and `B`, which give the directional albedo.
    pub table: &'a DfgTable,
}

impl Shading for Glossy<'_> {
    fn radiance(&self, at: &SurfacePoint) -> Rgb<f32> {
        let reflectance = self.table.lookup(at.cos_view(), self.roughness).reflectance(self.f0);
        Rgb::narrow(between_levels(self.chain, at.reflected(), self.level).widen() * reflectance)
    }
}

/// The radiance from `s`, linear between the two levels nearest to `level`, which is clamped to those there are.
#[must_use]
pub fn between_levels(chain: &CubeMipChain, s: Dir, level: f64) -> Rgb<f32> {
    let levels = chain.levels();
    let last = levels.len() - 1;
    let level = level.clamp(0.0, last as f64);
    let low = (level as usize).min(last);
    let t = (level - low as f64) as f32;
    let sharper = levels[low].radiance(s);
    if t == 0.0 { sharper } else { sharper.scale(1.0 - t) + levels[low + 1].radiance(s).scale(t) }
}

#[cfg(test)]
mod tests {
    use lobe_env::CubeMap;

    use super::*;

    #[test]
    fn even_light_is_reflected_by_the_ambient_reflectance() {
        let chain = CubeMipChain::averaged(CubeMap::from_fn(8, |_| Rgb::new(1.0, 2.0, 0.5)));
        let (table, f0) = (DfgTable::new(32), Rgb::new(0.9, 0.5, 0.04));
        let view = Dir::X;
        for (level, roughness) in [(0.0, 0.2), (1.4, 0.6), (9.0, 1.0)] {
            let glossy = Glossy { chain: &chain, level, roughness, f0, table: &table };
            for angle in [0.0, 0.5, 1.2] {
                let normal = Dir::new([f64::cos(angle), f64::sin(angle), 0.0]).unwrap();
                let found = glossy.radiance(&SurfacePoint { position: [0.0; 3], normal, view });
                let expected = table.lookup(angle.cos(), roughness).reflectance(f0);
                let off = (f64::from(found.g) - 2.0 * expected.g).abs();
                assert!(off < 1e-6, "roughness {roughness}, {angle} rad: {found:?}, reflectance {expected:?}");
            }
        }
    }

    #[test]
    fn between_two_levels_the_light_is_mixed() {
        let level = |size: usize, value: f32| CubeMap::from_fn(size, |_| Rgb::splat(value));
        let chain = CubeMipChain::new(vec![level(4, 1.0), level(2, 3.0), level(1, 7.0)]).unwrap();
        for (at, expected) in [(-1.0, 1.0), (0.0, 1.0), (0.25, 1.5), (1.0, 3.0), (1.5, 5.0), (2.0, 7.0), (8.0, 7.0)] {
            assert_eq!(between_levels(&chain, Dir::Y, at), Rgb::splat(expected), "level {at}");
        }
    }
}
