//! Phong highlights by highlight mapping.

use lobe_env::{EnvMap, MappedMap, Mapping, irradiance_sh, project_env, reconstruct};
use lobe_sh::filter::convolve_in_place;
use lobe_sh::{Coefficient, Dir, Expansion, Rgb, Zonal};

use crate::gallery::exhibit::{Shading, SurfacePoint};

/// Bands with which surroundings are blurred. Phong's lobe keeps about `e^(-l²/2s)` of band `l`: a part in a thousand
/// of the last one for `s = 35`.
const ORDER: usize = 23;

/// Rows of the blurred maps: six texels to the half wave of the last band, for what interpolation costs.
const ROWS: usize = 144;

/// A surface whose highlights are looked up by the reflected direction and whose matte part by the normal.
///
/// ```text
///   L = k_d E(n)/π + k_s S(r)        r = 2 (n·v) n - v
///   E(n) = Σ E_i max(n·l_i, 0)       S(r) = Σ E_i (s+1)/(2π) max(r·l_i, 0)^s         for lights E_i from l_i
/// ```
///
/// Both maps are drawn once for any number of lights, and then the cost of a point is two lookups; lights of any shape
/// can be painted into `S`. A surface of this kind shows its highlight unweakened at every angle; a reflectance
/// function would multiply by `n·l`, which depends on more than `r`. Over all `r`, `S` holds the light's irradiance
/// once.
///
/// For surroundings in place of lights `E` is the irradiance map and `S` the map blurred with the same lobe. Miller and
/// Hoffman 1984. The error of the maps is measured in test `highlight_maps_agree_with_the_sum_over_the_lights`.
#[derive(Clone, Debug, PartialEq)]
pub struct HighlightMap {
    /// `E` by the normal, without `1/π`.
    pub irradiance: MappedMap,
    /// `S` by the reflected direction.
    pub highlights: MappedMap,
    /// The albedo of the matte part.
    pub k_d: Rgb<f32>,
    /// The color of the highlights.
    pub k_s: Rgb<f32>,
}

impl HighlightMap {
    /// The maps, octahedral and `size` x `size`, of lights: the direction towards each, and the irradiance of a surface
    /// that faces it.
    ///
    /// # Panics
    /// If `size` is 0.
    #[must_use]
    pub fn of_lights(size: usize, lights: &[(Dir, Rgb<f32>)], exponent: f64, k_d: Rgb<f32>, k_s: Rgb<f32>) -> Self {
        let map = |f: &(dyn Fn(Dir) -> Rgb<f32> + Sync)| MappedMap::from_fn(Mapping::Octahedral, size, size, f);
        let irradiance = map(&|n| irradiance_of_lights(lights, n));
        let highlights = map(&|r| highlights_of_lights(lights, exponent, r));
        Self { irradiance, highlights, k_d, k_s }
    }

    /// The maps of surroundings: their irradiance, and their light blurred with the lobe `(s+1)/(2π) max(r·l, 0)^s`.
    ///
    /// By spherical harmonics of order 23: for an exponent of 30 within 0.8 % of the highest value (test
    /// `the_highlights_of_surroundings_are_their_light_under_the_lobe`); above, the lobe is widened.
    #[must_use]
    pub fn of_surroundings(map: &EnvMap, exponent: f64, k_d: Rgb<f32>, k_s: Rgb<f32>) -> Self {
        let mut blurred = project_env(map, ORDER);
        convolve_in_place(blurred.coefficients_mut(), &Zonal::phong(ORDER, exponent));
        let drawn = |f: &_| MappedMap::from(reconstruct(f, 2 * ROWS, ROWS));
        Self { irradiance: drawn(&irradiance_sh(map, ORDER)), highlights: drawn(&blurred), k_d, k_s }
    }
}

impl Shading for HighlightMap {
    fn radiance(&self, at: &SurfacePoint) -> Rgb<f32> {
        let matte = self.irradiance.radiance(at.normal).scale(std::f32::consts::FRAC_1_PI);
        self.k_d * matte + self.k_s * self.highlights.radiance(at.reflected())
    }
}

/// `E(n)` of [`HighlightMap`] for lights given by direction and irradiance.
#[must_use]
pub fn irradiance_of_lights(lights: &[(Dir, Rgb<f32>)], n: Dir) -> Rgb<f32> {
    sum(lights, |l| n.dot(l).max(0.0))
}

/// `S(r)` of [`HighlightMap`] for lights given by direction and irradiance.
#[must_use]
pub fn highlights_of_lights(lights: &[(Dir, Rgb<f32>)], exponent: f64, r: Dir) -> Rgb<f32> {
    let norm = (exponent + 1.0) / (2.0 * std::f64::consts::PI);
    sum(lights, |l| norm * r.dot(l).max(0.0).powf(exponent))
}

fn sum(lights: &[(Dir, Rgb<f32>)], weight: impl Fn(Dir) -> f64) -> Rgb<f32> {
    let total = lights.iter().fold(Rgb::<f64>::ZERO, |sum, (l, e)| sum + e.widen().scale(weight(*l)));
    Rgb::narrow(total)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::gallery::exhibit::{Exhibit, compare_shadings};
    use crate::gallery::solid::ExhibitSolid;
    use lobe_render::{Camera, View};

    fn lights() -> Vec<(Dir, Rgb<f32>)> {
        vec![
            (Dir::new([-1.0, -0.8, 0.9]).unwrap(), Rgb::new(3.0, 2.6, 2.0)),
            (Dir::new([-0.4, 1.0, 0.1]).unwrap(), Rgb::new(0.3, 0.6, 1.4)),
        ]
    }

    #[test]
    fn highlight_maps_agree_with_the_sum_over_the_lights() {
        let (lights, exponent) = (lights(), 30.0);
        let (k_d, k_s) = (Rgb::new(0.6, 0.5, 0.4), Rgb::splat(0.2));
        let truth = |p: &SurfacePoint| {
            k_d * irradiance_of_lights(&lights, p.normal).scale(1.0 / PI as f32)
                + k_s * highlights_of_lights(&lights, exponent, p.reflected())
        };
        let camera = Camera::orthographic(View::ALONG_X, 1.1);
        let points = Exhibit { solid: ExhibitSolid::Ball { radius: 1.0 }, camera, samples: 1 }.points(60, 60);
        let error = |size| {
            let map = HighlightMap::of_lights(size, &lights, exponent, k_d, k_s);
            compare_shadings(&points, &map, &truth).relative_rmse
        };
        let (coarse, fine) = (error(64), error(128));
        println!("relative RMSE {coarse:.2e} with 64 x 64 texels, {fine:.2e} with 128 x 128");
        assert!(coarse < 0.02 && fine < 0.3 * coarse, "{coarse} and {fine}: second order");
    }

    #[test]
    fn the_highlights_of_surroundings_are_their_light_under_the_lobe() {
        // Two lamps of some 10°, as a map and as the texels of that map.
        let lamps = lights();
        let map = EnvMap::from_fn(128, 64, |s| sum(&lamps, |l| (80.0 * (s.dot(l) - 1.0)).exp()));
        let texels: Vec<(Dir, Rgb<f32>)> = (0..128 * 64)
            .map(|i| {
                let solid_angle = lobe_env::lat_long::solid_angle(128, 64, i / 128) as f32;
                (map.dir(i % 128, i / 128), map.texel(i % 128, i / 128).scale(solid_angle))
            })
            .collect();
        let surface = HighlightMap::of_surroundings(&map, 30.0, Rgb::splat(1.0), Rgb::splat(1.0));
        // The sum takes each texel as a point, which a texel of 2.8° is not: 3e-3 of the peak.
        let peak = highlights_of_lights(&texels, 30.0, lamps[0].0).r;
        for s in lobe_testkit::directions() {
            let s = Dir::new(s).unwrap();
            let (found, expected) = (surface.highlights.radiance(s).r, highlights_of_lights(&texels, 30.0, s).r);
            assert!((found - expected).abs() < 8e-3 * peak, "highlight towards {s:?}: {found}, {expected}");
            let (found, expected) = (surface.irradiance.radiance(s).r, irradiance_of_lights(&texels, s).r);
            assert!((found - expected).abs() < 8e-3 * peak, "irradiance of {s:?}: {found}, {expected}; {peak}");
        }
    }

    #[test]
    fn a_highlight_holds_the_irradiance_of_its_light() {
        for exponent in [1.0, 20.0, 60.0] {
            let map = HighlightMap::of_lights(128, &lights()[..1], exponent, Rgb::ZERO, Rgb::splat(1.0));
            let total = 4.0 * PI * map.highlights.mean().r;
            assert!((total / 3.0 - 1.0).abs() < 2e-3, "exponent {exponent}: {total} of 3");
        }
    }
}
