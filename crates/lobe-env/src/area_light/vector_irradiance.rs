//! Vector irradiance: the net flux of light through a point.

use std::f64::consts::PI;

use lobe_io::parallel;
use lobe_sh::basis::coefficient_index;
use lobe_sh::{Coefficient, Dir, Expansion, Rgb};

use crate::map::mapped_map::MappedMap;
use crate::mapping::lat_long::sin_cos_pi;
use crate::projection::irradiance::row_vectors;
use crate::projection::project_map::project_map;

/// Relative to all light, a net flux up to this is rounding error of uniform light.
const NOTHING: f64 = 1e-13;

/// The vector irradiance at a point (the "light vector" of Gershun): one vector for each channel.
///
/// ```text
///   e = ∫ L(s) s ds                                      over the whole sphere
///   n·e = ∫ L(s) n·s ds = E(n) - E(-n)                   the net irradiance through a surface of normal n
/// ```
///
/// It points towards the mean direction of the light. Where all light comes from one side of the surface, `E(-n) = 0`
/// and `n·e` is the irradiance itself. In W m⁻² for radiance in W m⁻² sr⁻¹.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct VectorIrradiance<T = Rgb<f64>> {
    components: [T; 3],
}

impl<T: Coefficient<Scalar = f64>> VectorIrradiance<T> {
    /// The vector of these three components.
    #[must_use]
    pub fn new(x: T, y: T, z: T) -> Self {
        Self { components: [x, y, z] }
    }

    /// The components along x, y and z.
    #[must_use]
    pub fn to_array(self) -> [T; 3] {
        self.components
    }

    /// From band 1 of an expansion of the radiance.
    ///
    /// ```text
    ///   e = √(4π/3) (-L_3, -L_1, L_2)
    /// ```
    ///
    /// because band 1 of the basis is `√(3/4π) (-y, z, -x)`. No other band contributes, so an expansion of order 2
    /// gives the exact vector. Zero for an expansion without band 1.
    ///
    /// ```
    /// use lobe_env::VectorIrradiance;
    /// use lobe_sh::{Dir, ShVec};
    ///
    /// // A far lamp that leaves irradiance 2 on a surface that faces it.
    /// let lamp = Dir::from_angles(0.4, 1.0);
    /// let e = VectorIrradiance::from_radiance_sh(&ShVec::impulse(3, lamp, 2.0_f64));
    /// assert!((e.magnitude(0) - 2.0).abs() < 1e-14);
    /// assert!(e.dir(0).unwrap().angle_to(lamp) < 1e-15);
    /// ```
    #[must_use]
    pub fn from_radiance_sh<C, E>(radiance: &E) -> Self
    where
        C: Coefficient<Wide = T>,
        E: Expansion<C>,
    {
        let scale = (4.0 * PI / 3.0).sqrt();
        let component = |m: isize, sign: f64| {
            radiance.coefficients().get(coefficient_index(1, m)).map_or(T::ZERO, |c| c.widen().scale(sign * scale))
        };
        Self::new(component(1, -1.0), component(-1, -1.0), component(0, 1.0))
    }

    /// The net irradiance `n·e = E(n) - E(-n)` through a surface of normal `n`; negative where more light comes from
    /// behind.
    #[must_use]
    pub fn net(self, n: Dir) -> T {
        let [x, y, z] = self.components;
        x.scale(n.x()) + y.scale(n.y()) + z.scale(n.z())
    }

    /// The length of the vector in channel `c`: the largest net irradiance of any surface.
    ///
    /// # Panics
    /// If there is no such channel.
    #[must_use]
    pub fn magnitude(self, c: usize) -> f64 {
        let [x, y, z] = self.components.map(|component| component.channel(c));
        (x * x + y * y + z * z).sqrt()
    }

    /// The direction of the vector in channel `c`; `None` where it is zero, as in a constant environment.
    ///
    /// # Panics
    /// If there is no such channel.
    #[must_use]
    pub fn dir(self, c: usize) -> Option<Dir> {
        Dir::new(self.components.map(|component| component.channel(c)))
    }
}

impl VectorIrradiance<Rgb<f64>> {
    /// One direction for all channels: that of the luminance.
    #[must_use]
    pub fn luminance_dir(self) -> Option<Dir> {
        Dir::new(self.components.map(Rgb::luminance))
    }
}

/// The vector irradiance of an environment.
///
/// ```text
///   e = Σ_texels L V        V = ∫_texel s ds
/// ```
///
/// The map is piecewise constant over texels and `V` is exact ([`irradiance_at`](crate::irradiance_at) has its closed
/// form), so the only error is rounding, in `f64`: `n·e` agrees with `E(n) - E(-n)` of the sum over all texels for
/// every normal to 5e-6 of the light, which is the rounding of that sum, and with band 1 of
/// [`project_env`](crate::project_env) to 1e-13 (tests
/// `the_net_irradiance_is_the_difference_of_both_sides`, `the_vector_is_band_one_of_the_map`). The same bits for any
/// number of threads.
///
/// This applies to a lat-long map; one of another mapping is projected to order 2 from its own texels, which is as
/// accurate (test `maps_of_every_mapping_have_the_vector_of_their_light`).
///
/// A channel whose vector is no longer than 1e-13 of `4π` times its mean, which is rounding, has the vector 0 and no
/// direction (test `even_light_flows_nowhere`); in a round picture, whose rim cuts texels, uniform light is uniform
/// only to the error of the quadrature over the parts of those texels.
#[must_use]
pub fn vector_irradiance(map: &MappedMap) -> VectorIrradiance {
    let e = if map.mapping().form().has_rows_of_latitude() {
        vector_of_rows(map)
    } else {
        VectorIrradiance::from_radiance_sh(&project_map(map, 2))
    };
    let mean = map.mean();
    let is_nothing = [0, 1, 2].map(|c| e.magnitude(c) <= NOTHING * 4.0 * PI * mean.channel(c).abs());
    let without_rounding =
        |component: Rgb<f64>| Rgb::from_channels(|c| if is_nothing[c] { 0.0 } else { component.channel(c) });
    VectorIrradiance { components: e.components.map(without_rounding) }
}

/// The sum over the texels of a lat-long map.
fn vector_of_rows(map: &MappedMap) -> VectorIrradiance {
    let (w, h) = (map.width(), map.height());
    let columns: Vec<(f64, f64)> = (0..w).map(|x| sin_cos_pi((w as f64 - 2.0 * x as f64 - 1.0) / w as f64)).collect();
    let vectors = row_vectors(w, h);
    let rows: Vec<[Rgb<f64>; 3]> = parallel::map(h, &|y| {
        let (a, b) = vectors[y];
        let mut sums: [Rgb<f64>; 3] = [Rgb::ZERO; 3];
        for (texel, &(sin, cos)) in map.row(y).iter().zip(&columns) {
            let texel = texel.widen();
            sums[0] += texel.scale(cos);
            sums[1] += texel.scale(sin);
            sums[2] += texel;
        }
        [sums[0].scale(a), sums[1].scale(a), sums[2].scale(b)]
    });
    let mut e = [Rgb::ZERO; 3];
    for row in rows {
        for (sum, part) in e.iter_mut().zip(row) {
            *sum += part;
        }
    }
    VectorIrradiance { components: e }
}

#[cfg(test)]
mod tests {
    use lobe_testkit::{Random, directions};

    use super::*;
    use crate::files::bundled;
    use crate::map::env_map::EnvMap;
    use crate::mapping::lat_long;
    use crate::mapping::mapping::Mapping;
    use crate::projection::irradiance::irradiance_at;
    use crate::projection::project::project_env;

    fn normals() -> Vec<Dir> {
        directions().into_iter().map(|v| Dir::new(v).unwrap()).collect()
    }

    fn noise(width: usize, height: usize) -> EnvMap {
        let mut random = Random::new(11);
        let texels = (0..width * height).map(|_| Rgb::from([(); 3].map(|()| random.unit().powi(4) as f32)));
        EnvMap::new(width, height, texels.collect()).unwrap()
    }

    fn maps() -> Vec<(&'static str, EnvMap)> {
        vec![
            ("sunset", bundled::sunset().map()),
            ("33 x 17", noise(33, 17)),
            ("2 x 1", noise(2, 1)),
            ("1 x 1", noise(1, 1)),
        ]
    }

    fn assert_equal(a: VectorIrradiance, b: VectorIrradiance, limit: f64, what: &str) {
        for (a, b) in a.to_array().into_iter().zip(b.to_array()) {
            for c in 0..3 {
                assert!((a.channel(c) - b.channel(c)).abs() < limit, "{what}, channel {c}: {a:?} against {b:?}");
            }
        }
    }

    #[test]
    fn the_vector_is_band_one_of_the_map() {
        for (name, map) in maps() {
            let e = vector_irradiance(&map);
            let from_sh = VectorIrradiance::from_radiance_sh(&project_env(&map, 2));
            assert_equal(e, from_sh, 1e-13 * map.mean().g * 4.0 * PI, name);
        }
    }

    #[test]
    fn even_light_flows_nowhere() {
        for mapping in [Mapping::LatLong, Mapping::Octahedral, Mapping::EqualArea, Mapping::Cube] {
            let width = if mapping == Mapping::Cube { 33 } else { 130 };
            let map = MappedMap::from_fn(mapping, width, mapping.height_for(width), |_| Rgb::new(0.7, 30.0, 0.0));
            let e = vector_irradiance(&map);
            for c in 0..3 {
                assert!(e.dir(c).is_none(), "{mapping}, channel {c}: {e:?}");
            }
            assert!(e.luminance_dir().is_none(), "{mapping}: {e:?}");
        }
        let mut map = MappedMap::from_fn(Mapping::LatLong, 64, 32, |_| Rgb::new(1.0, 1.0, 1.0));
        map.texels_mut()[300].g += 1e-6;
        let e = vector_irradiance(&map);
        assert!(e.dir(0).is_none() && e.dir(1).is_some(), "one texel is a little greener: {e:?}");
    }

    #[test]
    fn maps_of_every_mapping_have_the_vector_of_their_light() {
        // ∫ (c + a·s) s ds = 4π/3 a.
        let slopes = [[0.5, -0.25, 1.0], [-1.0, 0.0, 0.125], [0.0, 0.75, -0.5]];
        let light = |s: Dir| Rgb::from(slopes.map(|a| (2.0 + lobe_sh::sphere::vector::dot(a, s.to_array())) as f32));
        for mapping in Mapping::ALL {
            let width = if mapping == Mapping::Cube { 64 } else { 256 };
            let map = MappedMap::from_fn(mapping, width, mapping.height_for(width), light);
            let e = vector_irradiance(&map);
            assert_equal(e, VectorIrradiance::from_radiance_sh(&project_map(&map, 5)), 1e-8, mapping.name());
            for (c, a) in slopes.into_iter().enumerate() {
                for (k, component) in e.to_array().into_iter().enumerate() {
                    let error = component.channel(c) - 4.0 * PI / 3.0 * a[k];
                    // Texels hold the light of their centers.
                    assert!(error.abs() < 2e-3, "{mapping}, channel {c}, axis {k}: {component:?}, off by {error}");
                }
            }
        }
    }

    #[test]
    fn the_net_irradiance_is_the_difference_of_both_sides() {
        for (name, map) in maps() {
            let e = vector_irradiance(&map);
            let behind: Vec<Dir> = normals().into_iter().map(|n| -n).collect();
            let (front, back) = (irradiance_at(&map, &normals()), irradiance_at(&map, &behind));
            // Brute force sums its rows in f32.
            let light = map.mean().to_array().into_iter().fold(0.0, f64::max) * 4.0 * PI;
            let limit = 5e-6 * light;
            for ((n, front), back) in normals().into_iter().zip(front).zip(back) {
                let (net, difference) = (e.net(n), front - back);
                for c in 0..3 {
                    let (net, difference) = (net.channel(c), difference.channel(c));
                    assert!((net - difference).abs() < limit, "{name} facing {n:?}: {net} against {difference}");
                }
            }
        }
    }

    #[test]
    fn a_sun_of_one_texel_is_where_the_vector_points() {
        let (w, h) = (64, 32);
        for (x, y) in [(0, 0), (63, 15), (32, 31), (5, 7)] {
            let mut map = EnvMap::from_fn(w, h, |_| Rgb::ZERO);
            map.texels_mut()[y * w + x] = Rgb::new(0.0, 2.0, 0.0);
            let e = vector_irradiance(&map);
            assert_eq!(e.dir(0), None, "no red light");
            let off = e.dir(1).unwrap().angle_to(map.dir(x, y));
            assert!(off < 0.3 * PI / h as f64, "texel ({x}, {y}): {off}");
            let expected = 2.0 * lat_long::solid_angle(w, h, y);
            assert!((e.magnitude(1) / expected - 1.0).abs() < 2e-3, "({x}, {y}): {} {expected}", e.magnitude(1));
        }
    }

    #[test]
    fn a_constant_environment_has_no_direction() {
        let e = vector_irradiance(&EnvMap::from_fn(31, 16, |_| Rgb::new(1.0, 1.0, 1.0)));
        assert!(e.magnitude(2) < 1e-14, "{e:?}");
    }

    #[test]
    fn half_a_sky_of_radiance_one_leaves_pi() {
        let e = vector_irradiance(&EnvMap::from_fn(16, 8, |s| if s.z() > 0.0 { Rgb::splat(1.0) } else { Rgb::ZERO }));
        assert!((e.net(Dir::Z).r - PI).abs() < 1e-14, "{e:?}");
        assert!(e.luminance_dir().unwrap().angle_to(Dir::Z) < 1e-15, "{e:?}");
    }

    #[test]
    fn an_expansion_without_band_one_has_no_vector() {
        let flat = lobe_sh::ShVec::constant(1, 3.0_f64);
        assert_eq!(VectorIrradiance::from_radiance_sh(&flat), VectorIrradiance::<f64>::default(), "order 1");
    }
}
