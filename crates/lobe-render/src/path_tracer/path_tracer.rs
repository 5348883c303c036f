//! The path tracer: exit radiance by paths from the surface to the light, with next-event estimation and multiple
//! importance sampling.

use std::f64::consts::PI;

use derive_setters::Setters;
use lobe_prt::Receivers;
use lobe_scene::{Bvh, Hit, Ray, Scene, Surface, SurfaceRays};
use lobe_sh::{Coefficient as _, Dir, Rgb};

use crate::path_tracer::bsdf::Bsdf;
use crate::path_tracer::distant_light::DistantLight;
use crate::path_tracer::emitter::Emitter;
use crate::path_tracer::estimate::{PathEstimate, SampleCount, SetMeans};
use crate::path_tracer::ggx::Facets;
use crate::path_tracer::sampler::{PathNumbers, SampleSet};
use crate::path_tracer::surfaces::Surfaces;
use lobe_sh::sphere::vector::{Vec3, dot, normalized, scale, tangents_along_z};

/// Options of [`PathTracer`].
#[derive(Clone, Copy, Debug, PartialEq, Setters)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default))]
#[non_exhaustive]
pub struct PathOptions {
    /// Reflections before the visible surface's own: 0 for direct light.
    pub bounces: usize,
    /// The strategy that samples directions towards the light.
    pub strategy: LightStrategy,
    /// The reflection model.
    pub surfaces: Surfaces,
    /// The seed of the random numbers.
    pub seed: u64,
}

impl Default for PathOptions {
    /// Three bounces among matte surfaces, by multiple importance sampling.
    fn default() -> Self {
        Self { bounces: 3, strategy: LightStrategy::MultipleImportance, surfaces: Surfaces::Matte, seed: 0 }
    }
}

/// Strategies that sample directions towards the light. All have the same mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum LightStrategy {
    /// Multiple importance sampling: directions are drawn from the light and from the BSDF, both weighted by the power
    /// heuristic ([Veach and Guibas 1995]).
    ///
    /// ```text
    ///   w = p² / (p² + q²)      p: density of the strategy that drew the direction; q: of the other one
    /// ```
    ///
    /// [Veach and Guibas 1995]: https://doi.org/10.1145/218380.218498
    MultipleImportance,
    /// Directions are drawn from the BSDF alone: for smooth light.
    Bsdf,
    /// Next-event estimation: directions are drawn from the light alone, for matte surfaces under small lights.
    NextEvent,
}

/// A diffuse receiver, such as a vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathReceiver<'a> {
    /// Its position.
    pub position: [f32; 3],
    /// The unit normal to shade with; rays go to its side.
    pub normal: [f32; 3],
    /// The unit vector along which rays are lifted above the surface: the normal, or as [`Receivers::lift`] has it.
    pub lift: [f32; 3],
    /// Its albedo.
    pub albedo: Rgb<f32>,
    /// The normals of the planes of the triangles around it, as [`Receivers::planes`] has them, of any length: only
    /// their sides count. Directions below all of them bring nothing. There may be none.
    pub planes: &'a [[f32; 3]],
}

impl<'a> PathReceiver<'a> {
    /// One of the receivers that transfer is baked for.
    ///
    /// # Panics
    /// If there is no such receiver.
    #[must_use]
    pub fn of(receivers: &'a Receivers, receiver: usize) -> Self {
        let [r, g, b] = receivers.albedos()[receiver];
        let (position, normal) = (receivers.positions()[receiver], receivers.normals()[receiver]);
        let (lift, planes) = (receivers.lift(receiver), receivers.planes(receiver));
        Self { position, normal, lift, albedo: Rgb::new(r, g, b), planes }
    }
}

/// The path tracer of a scene under a distant light.
///
/// ```text
///   B(x) = ∫ L_in(s) f(s) max(n·s, 0) ds        L_in = the light where the ray escapes, else B of what it hits
/// ```
///
/// A surface that is not double-sided is black from behind and stops light all the same. Otherwise both normals are
/// turned to the side that is hit; it is shaded with the interpolated one, tilted by the normal map if there is one, and
/// directions below the triangle's plane bring nothing. Rays start at [`Bvh::origin_above`]. Holes of alpha masks let rays
/// through; [`Scene::stops`] decides about glass, and [`Scene::tint`] is the color of the light that goes through it.
/// Nothing is clamped, and paths end at the last bounce, without Russian roulette: the mean is unbiased. Paths meet
/// surfaces that emit light by chance, as no direction is drawn towards them: small and bright ones make noise.
///
/// Where the normal to shade with is tilted by δ off that of the triangle:
///
/// * A point that is seen from below that normal is lit as from above it: the radiance of a matte surface does not
///   depend on the viewer.
/// * Under a white sky a matte surface reflects `(1 + cos δ)/2` of its albedo, a cosine lobe that the plane of the
///   triangle cuts. No exit radiance exceeds that of the sky (test
///   `light_from_a_ceiling_of_bent_normals_is_what_its_tilt_leaves_whoever_sees_it`).
/// * Under light from one direction `s` the flux that leaves may exceed the flux that arrives, by `(n·s)/(g·s)`, where
///   `g` is the normal of the triangle ([Veach 1997], section 5.3).
///
/// Mitsuba turns the normal to the viewer instead (`twosided`), and lets rays below the triangle go on into the solid.
/// It loses more light at each reflection, `2c(1 - c)` of it against `1 - c` with `c = (1 + cos δ)/2`, and light passes
/// through closed surfaces.
///
/// [Veach 1997]: https://graphics.stanford.edu/papers/veach_thesis/
pub struct PathTracer<'a> {
    surfaces: SurfaceRays<'a>,
    light: &'a DistantLight,
    /// From the origin of the scene.
    emitters: Vec<Emitter>,
    options: PathOptions,
}

/// A point of a surface that a path visits.
pub(crate) struct Interaction {
    /// The origin of rays.
    pub(crate) origin: [f32; 3],
    /// The geometric normals: no ray goes below all of their planes. There is one but at a receiver.
    pub(crate) planes: SurfacePlanes,
    pub(crate) bsdf: Bsdf,
    /// The radiance that the surface emits; none of a receiver.
    pub(crate) emission: Rgb<f64>,
}

/// Where a path starts, and its numbers.
pub(crate) struct PathStart<'s> {
    pub(crate) at: &'s Interaction,
    pub(crate) numbers: PathNumbers,
}

/// The most paths that are followed at once: their state fits the first-level cache.
pub(crate) const ABREAST: usize = 64;

/// The planes of an interaction.
pub(crate) enum SurfacePlanes {
    One(Vec3),
    Around(Vec<Vec3>),
}

/// Whether a direction is below all planes, and leads into the surface.
#[inline]
pub(crate) fn is_below(planes: &SurfacePlanes, s: Vec3) -> bool {
    match planes {
        SurfacePlanes::One(normal) => dot(s, *normal) <= 0.0,
        SurfacePlanes::Around(normals) => normals.iter().all(|normal| dot(s, *normal) <= 0.0),
    }
}

/// The first surface along a ray.
pub(crate) struct FirstHit {
    pub(crate) albedo: Rgb<f32>,
    pub(crate) normal: [f32; 3],
    /// Along the ray.
    pub(crate) distance: f64,
    /// None if the surface is black from this side.
    pub(crate) interaction: Option<Interaction>,
}

/// How a ray meets a surface: both normals are turned to the side that is hit.
struct Facing {
    is_front: bool,
    /// The direction of the ray, and its length.
    towards: Vec3,
    length: f64,
    plane: Vec3,
    shading: Vec3,
}

impl Facing {
    #[inline]
    fn of(surface: &Surface, ray: &Ray) -> Self {
        let towards = ray.direction.map(f64::from);
        let geometric = surface.geometric_normal.map(f64::from);
        let is_front = dot(towards, geometric) < 0.0;
        let side = if is_front { 1.0 } else { -1.0 };
        // Normals of f32 are not of unit length to the last digit of f64.
        let shading = normalized(surface.shading_normal.map(|c| side * f64::from(c)));
        Self { is_front, towards, length: dot(towards, towards).sqrt(), plane: scale(geometric, side), shading }
    }
}

/// Purposes of random numbers at each point of a path; see [`Purpose::at`].
#[derive(Clone, Copy)]
pub(crate) enum Purpose {
    Light = 1,
    Surface = 2,
    Lobe = 3,
    Emitter = 4,
}

impl Purpose {
    pub(crate) fn at(self, bounce: usize) -> u32 {
        4 * bounce as u32 + self as u32
    }
}

/// The purpose of the pair that says where a path begins: the place of a ray within its pixel, the direction that light
/// arrives from.
pub(crate) const FIRST_PURPOSE: u32 = 0;

impl<'a> PathTracer<'a> {
    /// Paths through `scene`, whose tree is `bvh`.
    #[must_use]
    pub fn new(scene: &'a Scene, bvh: &'a Bvh, light: &'a DistantLight, options: PathOptions) -> Self {
        Self { surfaces: SurfaceRays::new(scene, bvh), light, emitters: Vec::new(), options }
    }

    /// The same with lamps in the world, from each of which one direction is drawn at every reflection, whatever the strategy.
    /// [`Self::for_each_escape`] and [`Self::for_each_arrival`] leave them out.
    #[must_use]
    pub fn with_emitters(self, emitters: &[Emitter]) -> Self {
        let origin = self.surfaces.scene().origin();
        Self { emitters: emitters.iter().map(|emitter| emitter.relative_to(origin)).collect(), ..self }
    }

    /// The exit radiance of receiver number `place`, with its variance.
    ///
    /// Receivers of different numbers use independent paths.
    #[must_use]
    pub fn radiance_at(&self, receiver: &PathReceiver<'_>, place: usize, count: &SampleCount) -> PathEstimate {
        let at = &self.receiver_interaction(receiver);
        let mut means = SetMeans::new(count);
        self.for_each_group(place, count, |_, numbers| {
            let starts: Vec<_> = numbers.iter().map(|&numbers| PathStart { at, numbers }).collect();
            self.radiances(&starts).into_iter().for_each(|value| means.add(value));
        });
        means.estimate()
    }

    /// Follows paths from receiver number `place` that are drawn from the BSDF alone, and calls `escaped` for each that
    /// leaves the scene: with its set, the number of bounces before the receiver's own, its direction, and its
    /// throughput.
    ///
    /// ```text
    ///   B = Σ_paths throughput L(direction) / number of paths       over the paths with at most b bounces, for any b
    /// ```
    ///
    /// The same paths serve any number of lights.
    pub fn for_each_escape(
        &self,
        receiver: &PathReceiver<'_>,
        place: usize,
        count: &SampleCount,
        mut escaped: impl FnMut(usize, usize, Dir, Rgb<f64>),
    ) {
        for set in 0..count.sets {
            let samples = SampleSet::new(self.options.seed, place as u64, set as u64);
            for path in 0..count.per_set {
                let start = self.receiver_interaction(receiver);
                self.follow(start, samples.path(path), |bounce, s, throughput| escaped(set, bounce, s, throughput));
            }
        }
    }

    /// Follows paths of the light that arrives at receiver number `place`, and calls `arrived` for each: with its set,
    /// the direction it comes from, uniform over the hemisphere Ω above the receiver, and an estimate of the radiance
    /// from there.
    ///
    /// ```text
    ///   ∫_Ω f(s) L_in(s) ds = 2π Σ_paths f(direction) radiance / number of paths
    /// ```
    ///
    /// Bounces are counted before the receiver's own reflection, whatever that is: its albedo plays no part.
    pub fn for_each_arrival(
        &self,
        receiver: &PathReceiver<'_>,
        place: usize,
        count: &SampleCount,
        mut arrived: impl FnMut(usize, Dir, Rgb<f64>),
    ) {
        let Interaction { origin, planes, .. } = self.receiver_interaction(receiver);
        let normal = normalized(receiver.normal.map(f64::from));
        let [u, v] = tangents_along_z(normal);
        self.for_each_group(place, count, |first, numbers| {
            // Draw directions uniformly over the hemisphere.
            let directions: Vec<Vec3> = numbers
                .iter()
                .map(|numbers| {
                    let [x, y, z] = uniform_over_hemisphere(numbers.pair(FIRST_PURPOSE));
                    std::array::from_fn(|k| x * u[k] + y * v[k] + z * normal[k])
                })
                .collect();
            // Estimate the radiance from there: that of the light, or of the surface that was hit.
            let rays: Vec<_> = directions.iter().map(|s| Ray::new(origin, s.map(|c| c as f32))).collect();
            let hits = self.first_hits(&rays);
            let mut starts = Vec::with_capacity(rays.len());
            for ((hit, _), &numbers) in hits.iter().zip(numbers) {
                if let Some(FirstHit { interaction: Some(at), .. }) = hit {
                    starts.push(PathStart { at, numbers });
                }
            }
            let mut reflected = match self.options.bounces.checked_sub(1) {
                None => vec![Rgb::ZERO; starts.len()],
                Some(bounces) => self.exit_radiances(&[], &starts, bounces),
            }
            .into_iter();
            for (k, (s, (hit, tint))) in directions.iter().zip(&hits).enumerate() {
                let radiance = match hit {
                    None => self.light.radiance(Dir::from_unit(*s)),
                    Some(FirstHit { interaction: Some(at), .. }) => at.emission + reflected.next().unwrap_or(Rgb::ZERO),
                    Some(_) => Rgb::ZERO,
                };
                let radiance = if is_below(&planes, *s) { Rgb::ZERO } else { radiance * *tint };
                arrived((first + k) / count.per_set, Dir::from_unit(*s), radiance);
            }
        });
    }

    /// The numbers of all paths from a place in their order, some at a time, with the place among all of the first.
    pub(crate) fn for_each_group(
        &self,
        place: usize,
        count: &SampleCount,
        mut found: impl FnMut(usize, &[PathNumbers]),
    ) {
        let mut group = Vec::with_capacity(ABREAST.min(count.total()));
        for first in (0..count.total()).step_by(ABREAST) {
            group.clear();
            group.extend((first..count.total().min(first + ABREAST)).map(|k| {
                let set = SampleSet::new(self.options.seed, place as u64, (k / count.per_set) as u64);
                set.path(k % count.per_set)
            }));
            found(first, &group);
        }
    }

    /// Whether surfaces emit light.
    pub(crate) fn has_emission(&self) -> bool {
        self.options.surfaces != Surfaces::Matte && self.surfaces.scene().is_emissive()
    }

    pub(crate) fn options(&self) -> &PathOptions {
        &self.options
    }

    pub(crate) fn light(&self) -> &DistantLight {
        self.light
    }

    /// One estimate for each path of the light that leaves its start under all lights.
    pub(crate) fn radiances(&self, starts: &[PathStart<'_>]) -> Vec<Rgb<f64>> {
        self.exit_radiances(&self.emitters, starts, self.options.bounces)
    }

    /// Intersects rays with the scene: see [`Self::intersect`].
    pub(crate) fn first_hits(&self, rays: &[Ray]) -> Vec<(Option<FirstHit>, Rgb<f64>)> {
        let found = self.intersections(rays).into_iter().zip(rays);
        found.map(|((hit, tint), ray)| (hit.map(|hit| self.first_hit(ray, &hit)), tint)).collect()
    }

    /// The first hits of rays, and the factors of light on the way there.
    pub(crate) fn intersections(&self, rays: &[Ray]) -> Vec<(Option<Hit>, Rgb<f64>)> {
        let widened = |(hit, tint): (Option<Hit>, [f32; 3])| (hit, Rgb::from(tint).widen());
        self.surfaces.closest_through_each(rays).into_iter().map(widened).collect()
    }

    /// The factor of light along each ray that no surface stops.
    pub(crate) fn pass(&self, rays: &[Ray]) -> impl Iterator<Item = Option<Rgb<f64>>> {
        self.surfaces.passes_through_each(rays).into_iter().map(|tint| tint.map(|tint| Rgb::from(tint).widen()))
    }

    /// Intersects a ray with the scene: the first surface, or none if the ray escapes, and the factor of light on the
    /// way there.
    fn intersect(&self, ray: &Ray) -> (Option<FirstHit>, Rgb<f64>) {
        let (hit, tint) = self.surfaces.closest_through(ray);
        (hit.map(|hit| self.first_hit(ray, &hit)), Rgb::from(tint).widen())
    }

    fn first_hit(&self, ray: &Ray, hit: &Hit) -> FirstHit {
        let surface = self.surfaces.scene().surface(hit);
        let facing = Facing::of(&surface, ray);
        let [r, g, b, _] = surface.base_color;
        FirstHit {
            albedo: Rgb::new(r, g, b),
            normal: facing.shading.map(|c| c as f32),
            distance: f64::from(hit.t) * facing.length,
            interaction: self.interaction_at(hit, &surface, &facing),
        }
    }

    /// What a path goes on from at a hit; none if the surface is black from this side.
    #[inline]
    pub(crate) fn interaction(&self, ray: &Ray, hit: &Hit) -> Option<Interaction> {
        let surface = self.surfaces.scene().surface(hit);
        self.interaction_at(hit, &surface, &Facing::of(&surface, ray))
    }

    #[inline]
    fn interaction_at(&self, hit: &Hit, surface: &Surface, facing: &Facing) -> Option<Interaction> {
        let scene = self.surfaces.scene();
        if !(facing.is_front || scene.material(surface.mesh).double_sided) {
            return None;
        }
        let [r, g, b, _] = surface.base_color;
        let base = Rgb::new(r, g, b).widen();
        let (bsdf, emission) = match self.options.surfaces {
            Surfaces::Matte => (Bsdf::matte(facing.shading, base), Rgb::ZERO),
            gltf => {
                let finish = scene.finish(hit);
                let is_separable = gltf == Surfaces::MetallicRoughnessSeparable;
                let facets = Facets::of_roughness(finish.roughness.into(), is_separable);
                let view = scale(facing.towards, -1.0 / facing.length);
                let bsdf = Bsdf::metallic_roughness(facing.shading, base, finish.metallic.into(), facets, view);
                (bsdf, Rgb::from(finish.emission).widen())
            }
        };
        let origin = self.surfaces.bvh().origin_above(surface.position, facing.plane.map(|c| c as f32));
        Some(Interaction { origin, planes: SurfacePlanes::One(facing.plane), bsdf, emission })
    }

    /// Follows one path drawn from the BSDF alone, and calls `escaped` where it leaves the scene.
    fn follow(&self, start: Interaction, numbers: PathNumbers, mut escaped: impl FnMut(usize, Dir, Rgb<f64>)) {
        let (mut at, mut throughput) = (start, Rgb::splat(1.0));
        for bounce in 0..=self.options.bounces {
            // Draw a direction from the BSDF.
            let choice = || numbers.one(Purpose::Lobe.at(bounce));
            let Some(sample) = at.bsdf.sample(numbers.pair(Purpose::Surface.at(bounce)), choice) else { return };
            if is_below(&at.planes, sample.towards) {
                return;
            }
            // Update the path throughput.
            throughput = throughput * sample.weight;
            // Trace the ray: hand over the path where it escapes, or go on from the surface that was hit.
            let (hit, tint) = self.intersect(&Ray::new(at.origin, sample.towards.map(|c| c as f32)));
            throughput = throughput * tint;
            match hit {
                None => return escaped(bounce, Dir::from_unit(sample.towards), throughput),
                Some(FirstHit { interaction: Some(interaction), .. }) => at = interaction,
                Some(_) => return,
            }
        }
    }

    pub(crate) fn receiver_interaction(&self, receiver: &PathReceiver<'_>) -> Interaction {
        let normal = normalized(receiver.normal.map(f64::from));
        let origin = self.surfaces.bvh().origin_above(receiver.position, receiver.lift);
        let planes = match receiver.planes {
            [] => SurfacePlanes::One(normal),
            planes => SurfacePlanes::Around(planes.iter().map(|n| n.map(f64::from)).collect()),
        };
        Interaction { origin, planes, bsdf: Bsdf::matte(normal, receiver.albedo.widen()), emission: Rgb::ZERO }
    }
}

/// A direction over +z, uniform by solid angle.
fn uniform_over_hemisphere([u0, u1]: [f64; 2]) -> Vec3 {
    let radius = ((1.0 - u1) * (1.0 + u1)).sqrt();
    let (sin, cos) = (2.0 * PI * u0).sin_cos();
    [radius * cos, radius * sin, u1]
}
