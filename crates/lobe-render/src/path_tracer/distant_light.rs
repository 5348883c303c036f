//! Light from infinitely far away: an environment map or an expansion, evaluated and sampled.

use std::sync::Arc;

use lobe_env::{EnvMap, Sun};
use lobe_io::Fingerprint;
use lobe_sh::{Coefficient as _, Dir, Expansion as _, Rgb, Rotation, ShVec};

use crate::path_tracer::sphere_table::{SphereTable, cell};

/// Light that depends on direction alone: an environment map or an expansion, turned.
///
/// A map is constant over each texel, as it is wherever Lobe integrates it, so light and its expansion by
/// [`project_env`](lobe_env::project_env) are of one function. An eye that looks past all surfaces
/// [sees](DistantLight::seen) a map interpolated between its texels. An expansion is evaluated exactly, its negative
/// values are kept.
///
/// Directions are drawn with a density that is constant over each cell of a lat-long grid:
///
/// ```text
///   map         p ∝ 0.2126 |r| + 0.7152 |g| + 0.0722 |b|         over its own texels: zero only where the map is black
///   expansion   p ∝ max |channel| at the cell's center + 0.1 mean over 64 x 32 cells: zero nowhere
/// ```
///
/// Behind a scene the eye sees the light itself, or another [`Backdrop`]. That lights nothing.
pub struct DistantLight {
    source: Source,
    backdrop: Backdrop,
    /// Shown before the light itself.
    suns: Vec<Sun>,
    /// The table for importance sampling; none if the light is black, or not finite.
    table: Option<SphereTable>,
    /// The weights of the table under an expansion; those of a map follow from its texels.
    weights: Vec<f64>,
    world_from_light: Rotation,
    light_from_world: Rotation,
}

enum Source {
    Map(Arc<EnvMap>),
    Expansion(ShVec<Rgb<f64>>),
}

/// What an eye sees where no surface is. Pictures turn with the light.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum Backdrop {
    /// The light itself: an expansion as it is, a map as [`Backdrop::Map`].
    #[default]
    Light,
    /// A map by [`MappedMap::radiance`](lobe_env::MappedMap::radiance): bilinear between the centers of its texels, and
    /// across its seam. The interpolation leaves every texel its solid angle, so that a sky is as bright as the light
    /// of its map.
    Map(Arc<EnvMap>),
    /// An expansion of radiance.
    Expansion(ShVec<Rgb<f64>>),
    /// One color of radiance, linear.
    Color(Rgb<f64>),
    /// Nothing: what lies behind is transparent.
    None,
}

/// A direction drawn from a light.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LightSample {
    pub(crate) towards: Dir,
    pub(crate) met: Met,
}

/// Where a direction meets a light: in the frame of the light, and in which cell of its table.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Met {
    s: Dir,
    cell: usize,
}

/// Rows of the grid that directions are drawn from under an expansion: a band-limited function of order 8 changes
/// little within 6°.
const ROWS: usize = 32;

/// The part of its mean that is added to the density of an expansion, so that it is zero nowhere.
const EVERYWHERE: f64 = 0.1;

impl DistantLight {
    /// The light of an environment map. Its texels should be [finite](EnvMap): of a map that is not, no direction is drawn, and
    /// its light is met only in directions drawn from the BSDF.
    #[must_use]
    pub fn from_map(map: impl Into<Arc<EnvMap>>) -> Self {
        let map = map.into();
        let weights: Vec<f64> = map.texels().iter().map(|texel| weight(texel.widen())).collect();
        let table = SphereTable::new(map.width(), map.height(), &weights);
        Self::new(Source::Map(map), table, Vec::new())
    }

    /// The light of an expansion of radiance, of any order.
    #[must_use]
    pub fn from_expansion(radiance: ShVec<Rgb<f64>>) -> Self {
        let grid = EnvMap::from_fn(2 * ROWS, ROWS, |s| Rgb::narrow(radiance.eval(s)));
        let largest = |c: &Rgb<f32>| f64::from(c.r.abs().max(c.g.abs()).max(c.b.abs()));
        let mut weights: Vec<f64> = grid.texels().iter().map(largest).collect();
        let mean = weights.iter().sum::<f64>() / weights.len() as f64;
        weights.iter_mut().for_each(|weight| *weight += EVERYWHERE * mean);
        let table = SphereTable::new(2 * ROWS, ROWS, &weights);
        Self::new(Source::Expansion(radiance), table, weights)
    }

    fn new(source: Source, table: Option<SphereTable>, weights: Vec<f64>) -> Self {
        let none = Rotation::from_axis_angle(Dir::Z, 0.0);
        let (backdrop, suns) = (Backdrop::Light, Vec::new());
        Self { source, backdrop, suns, table, weights, world_from_light: none, light_from_world: none }
    }

    /// This light in front of a backdrop. One that is the light itself is the same as [`Backdrop::Light`], in
    /// fingerprints too.
    #[must_use]
    pub fn before(self, backdrop: Backdrop) -> Self {
        let is_light = match (&backdrop, &self.source) {
            (Backdrop::Map(map), Source::Map(own)) => map == own,
            (Backdrop::Expansion(f), Source::Expansion(own)) => f == own,
            _ => false,
        };
        Self { backdrop: if is_light { Backdrop::Light } else { backdrop }, ..self }
    }

    /// This light with the discs of suns, which an eye sees where the backdrop is the light itself. They turn with it,
    /// and light nothing: [`Emitter::of_sun`](crate::Emitter::of_sun) does.
    #[must_use]
    pub fn showing(self, suns: &[Sun]) -> Self {
        Self { suns: suns.to_vec(), ..self }
    }

    /// This light turned, after all turns before: what was towards `s` is towards `R s`.
    #[must_use]
    pub fn turned(self, rotation: &Rotation) -> Self {
        let world_from_light = self.world_from_light.then(*rotation);
        Self { world_from_light, light_from_world: world_from_light.inverse(), ..self }
    }

    /// The radiance that arrives from direction `s`: what lights surfaces, and what they mirror.
    #[must_use]
    pub fn radiance(&self, s: Dir) -> Rgb<f64> {
        let s = self.light_from_world.rotate_dir(s);
        match &self.source {
            Source::Map(map) => map.texels()[cell(map.width(), map.height(), s)].widen(),
            Source::Expansion(f) => f.eval(s),
        }
    }

    /// What an eye sees towards `s`, where no surface is: the [`Backdrop`]; black where there is none.
    #[must_use]
    pub fn seen(&self, s: Dir) -> Rgb<f64> {
        let turned = || self.light_from_world.rotate_dir(s);
        match (&self.backdrop, &self.source) {
            (Backdrop::Map(map), _) => map.radiance(turned()).widen(),
            (Backdrop::Expansion(f), _) => f.eval(turned()),
            (Backdrop::Light, Source::Map(map)) => map.radiance(turned()).widen() + self.of_suns(turned()),
            (Backdrop::Light, Source::Expansion(f)) => f.eval(turned()) + self.of_suns(turned()),
            (Backdrop::Color(color), _) => *color,
            (Backdrop::None, _) => Rgb::ZERO,
        }
    }

    /// The radiance of the suns in a direction of the light's frame.
    fn of_suns(&self, s: Dir) -> Rgb<f64> {
        let shines = |sun: &&Sun| sun.direction.angle_to(s) <= 0.5 * sun.angular_diameter;
        self.suns.iter().filter(shines).fold(Rgb::ZERO, |all, sun| all + sun.radiance())
    }

    /// Whether nothing is behind the scene, so that pictures have an alpha.
    #[must_use]
    pub fn is_transparent(&self) -> bool {
        self.backdrop == Backdrop::None
    }

    /// Writes everything that identifies this light into a fingerprint.
    pub(crate) fn write_into(&self, all: &mut Fingerprint) {
        match &self.source {
            Source::Map(map) => write_map(all, map),
            Source::Expansion(f) => write_expansion(all, f),
        }
        match &self.backdrop {
            Backdrop::Light => all.word(0),
            Backdrop::Map(map) => {
                all.word(1);
                write_map(all, map);
            }
            Backdrop::Expansion(f) => {
                all.word(2);
                write_expansion(all, f);
            }
            Backdrop::Color(color) => {
                all.word(3);
                color.to_array().iter().for_each(|c| all.word(c.to_bits()));
            }
            Backdrop::None => all.word(4),
        }
        for sun in &self.suns {
            let numbers = [sun.direction.to_array(), sun.irradiance.to_array(), [sun.angular_diameter, 0.0, 0.0]];
            numbers.as_flattened().iter().for_each(|c| all.word(c.to_bits()));
        }
        for axis in [Dir::X, Dir::Z] {
            self.light_from_world.rotate_dir(axis).to_array().iter().for_each(|c| all.word(c.to_bits()));
        }
    }

    /// A direction drawn with each two numbers in `(0, 1)`; none under a light that is black, or not finite.
    pub(crate) fn samples(&self, numbers: &[[f64; 2]]) -> Vec<LightSample> {
        let Some(table) = &self.table else { return Vec::new() };
        let of = |(s, cell)| LightSample { towards: self.world_from_light.rotate_dir(s), met: Met { s, cell } };
        table.samples(numbers).into_iter().map(of).collect()
    }

    /// Where directions of the world meet the light.
    pub(crate) fn meet(&self, directions: impl Iterator<Item = Dir>) -> Vec<Met> {
        let [width, height] = self.table.as_ref().map_or([1, 1], SphereTable::size);
        let of = |s| {
            let s = self.light_from_world.rotate_dir(s);
            Met { s, cell: cell(width, height, s) }
        };
        directions.map(of).collect()
    }

    /// The radiance that arrives from there, and the density in sr⁻¹ with which [`DistantLight::samples`] draws it.
    pub(crate) fn radiance_and_density(&self, met: &Met) -> (Rgb<f64>, f64) {
        let Some(table) = &self.table else { return (self.radiance(self.world_from_light.rotate_dir(met.s)), 0.0) };
        let (radiance, weight) = self.in_cell(met.cell, met.s);
        (radiance, weight / table.whole())
    }

    /// The radiance from a direction in the frame of the light, and the weight in the table of its cell.
    fn in_cell(&self, cell: usize, s: Dir) -> (Rgb<f64>, f64) {
        match &self.source {
            Source::Map(map) => {
                let texel = map.texels()[cell].widen();
                (texel, weight(texel))
            }
            Source::Expansion(f) => (f.eval(s), self.weights[cell]),
        }
    }
}

/// The weight of a texel in the table: the luminance of its absolute values.
fn weight(texel: Rgb<f64>) -> f64 {
    Rgb::from(texel.to_array().map(f64::abs)).luminance()
}

fn write_map(all: &mut Fingerprint, map: &EnvMap) {
    all.word(map.width() as u64);
    for row in map.texels().chunks(map.width()) {
        let numbers: Vec<f32> = row.iter().flat_map(|texel| texel.to_array()).collect();
        all.floats(&numbers);
    }
}

fn write_expansion(all: &mut Fingerprint, f: &ShVec<Rgb<f64>>) {
    all.word(f.order() as u64);
    f.coefficients().iter().flat_map(|c| c.to_array()).for_each(|c| all.word(c.to_bits()));
}

#[cfg(test)]
mod tests {
    use lobe_env::{bundled, project_env};
    use lobe_testkit::Random;

    use super::*;

    fn turn() -> Rotation {
        Rotation::from_euler_zyz(0.4, 1.1, -2.0)
    }

    #[test]
    fn samples_estimate_the_integral_of_the_light() {
        let map = bundled::sunset().map();
        let expected = map.mean().scale(4.0 * std::f64::consts::PI);
        let lights = [
            ("map", DistantLight::from_map(map.clone()), 2e-3),
            ("expansion", DistantLight::from_expansion(project_env(&map, 5)), 1e-2),
        ];
        for (name, light, allowed) in lights {
            let light = light.turned(&turn());
            let mut random = Random::new(1);
            let (mut sum, count) = (Rgb::<f64>::ZERO, 20_000);
            for _ in 0..count {
                let sample = light.samples(&[[random.unit(), random.unit()]])[0];
                let (radiance, density) = light.radiance_and_density(&sample.met);
                sum += radiance.scale(1.0 / (density * f64::from(count)));
                let (_, found) = light.radiance_and_density(&light.meet(std::iter::once(sample.towards))[0]);
                assert!((found / density - 1.0).abs() < 1e-12, "{name}: density {found}, {density}");
            }
            let error = (sum.luminance() / expected.luminance() - 1.0).abs();
            assert!(error < allowed, "{name}: {sum:?} against {expected:?}");
        }
    }

    #[test]
    fn a_turned_light_shows_what_it_showed_elsewhere() {
        let map = bundled::sunset().map();
        let (light, turned) = (DistantLight::from_map(map.clone()), DistantLight::from_map(map).turned(&turn()));
        for v in lobe_testkit::directions() {
            let s = Dir::new(v).unwrap();
            let (a, b) = (light.radiance(turn().inverse().rotate_dir(s)), turned.radiance(s));
            assert_eq!(a, b, "towards {s:?}");
            let (a, b) = (light.seen(turn().inverse().rotate_dir(s)), turned.seen(s));
            assert_eq!(a, b, "seen towards {s:?}");
        }
    }

    #[test]
    fn an_eye_sees_a_map_linear_between_its_texels_and_its_light_constant_over_them() {
        // Rows alike: between two centers of columns the value is their mean, on the seam too.
        let map = EnvMap::from_fn(16, 8, |s| Rgb::splat(s.x().atan2(s.y()).sin().mul_add(2.0, 3.0) as f32));
        let light = DistantLight::from_map(map.clone());
        for x in 0..16 {
            let [a, b] = [x, (x + 1) % 16].map(|x| f64::from(map.texel(x, 4).r));
            let s = lobe_env::lat_long::dir_from_uv((x as f64 + 0.75) / 16.0, 4.5 / 8.0);
            let (seen, lights) = (light.seen(s).r, light.radiance(s).r);
            assert!((seen - 0.75f64.mul_add(a, 0.25 * b)).abs() < 1e-6, "column {x}: {seen} between {a} and {b}");
            assert_eq!(lights, a, "column {x}: what lights is the texel");
        }
    }

    #[test]
    fn what_is_behind_a_scene_lights_nothing_and_turns_with_the_light() {
        let map = Arc::new(bundled::sunset().map());
        let even = || DistantLight::from_expansion(ShVec::constant(1, Rgb::splat(1.0))).turned(&turn());
        let behind = even().before(Backdrop::Map(map.clone()));
        let itself = DistantLight::from_map(map).turned(&turn());
        for v in lobe_testkit::directions() {
            let s = Dir::new(v).unwrap();
            assert_eq!(behind.seen(s), itself.seen(s), "the map towards {s:?}");
            assert_eq!(behind.radiance(s), even().radiance(s), "the light towards {s:?}");
        }
        let red = Rgb::new(2.0, 0.0, 0.0);
        assert_eq!(even().before(Backdrop::Color(red)).seen(Dir::X), red, "a color");
        let nothing = even().before(Backdrop::None);
        assert!(nothing.is_transparent() && nothing.seen(Dir::X) == Rgb::ZERO, "nothing");
    }

    #[test]
    fn black_light_has_nothing_to_draw() {
        let light = DistantLight::from_map(EnvMap::from_fn(4, 2, |_| Rgb::ZERO));
        let met = light.meet(std::iter::once(Dir::X))[0];
        assert!(light.samples(&[[0.5; 2]]).is_empty() && light.radiance_and_density(&met) == (Rgb::ZERO, 0.0), "black");
    }
}
