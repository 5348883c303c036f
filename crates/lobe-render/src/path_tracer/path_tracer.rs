//! The path tracer: exit radiance by paths from the surface to the light, with next-event estimation and multiple
//! importance sampling.

use std::f64::consts::PI;

use derive_setters::Setters;
use lobe_prt::Receivers;
use lobe_scene::{Bvh, Hit, Ray, Scene, SurfaceRays};
use lobe_sh::{Coefficient as _, Dir, Rgb};

use crate::DistantLight;
use crate::path_tracer::bsdf::Bsdf;
use crate::path_tracer::emitter::Emitter;
use crate::path_tracer::estimate::{PathEstimate, SampleCount, estimate};
use crate::path_tracer::ggx::Facets;
use crate::path_tracer::sampler::{PathNumbers, SampleSet};
use lobe_sh::vector::{Vec3, dot, normalized, scale, tangents_along_z};

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

/// Reflection models.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Surfaces {
    /// All are matte and their albedo is the base color; metallic and roughness are ignored. This is what a diffuse
    /// bake computes.
    Matte,
    /// The metallic-roughness model of glTF 2.0 with height-correlated masking, as renderers have it.
    MetallicRoughness,
    /// The same with separable masking, as appendix B.3 of the specification prints it: rough metals are darker.
    MetallicRoughnessSeparable,
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
/// Nothing is clamped, and paths end at the last bounce, without Russian roulette: the mean is unbiased.
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
    origin: [f32; 3],
    /// The geometric normals: no ray goes below all of their planes. There is one but at a receiver.
    planes: SurfacePlanes,
    bsdf: Bsdf,
}

/// The planes of an interaction.
pub(crate) enum SurfacePlanes {
    One(Vec3),
    Around(Vec<Vec3>),
}

/// Whether a direction is below all planes, and leads into the surface.
fn is_below(planes: &SurfacePlanes, s: Vec3) -> bool {
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

/// Purposes of random numbers at each point of a path; see [`Purpose::at`].
#[derive(Clone, Copy)]
enum Purpose {
    Light = 1,
    Surface = 2,
    Lobe = 3,
    Emitter = 4,
}

impl Purpose {
    fn at(self, bounce: usize) -> u32 {
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
        let start = self.receiver_interaction(receiver);
        estimate(count, |set, path| {
            let numbers = SampleSet::new(self.options.seed, place as u64, set as u64).path(path);
            self.exit_radiance(&start, numbers, self.options.bounces)
        })
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
        for set in 0..count.sets {
            let samples = SampleSet::new(self.options.seed, place as u64, set as u64);
            for path in 0..count.per_set {
                // Draw a direction uniformly over the hemisphere.
                let numbers = samples.path(path);
                let [x, y, z] = uniform_over_hemisphere(numbers.pair(FIRST_PURPOSE));
                let s = std::array::from_fn(|k| x * u[k] + y * v[k] + z * normal[k]);
                // Estimate the radiance from there: that of the light, or of the surface that was hit.
                if is_below(&planes, s) {
                    arrived(set, Dir::from_unit(s), Rgb::ZERO);
                    continue;
                }
                let (hit, tint) = self.intersect(&Ray::new(origin, s.map(|c| c as f32)));
                let radiance = match (hit, self.options.bounces) {
                    (None, _) => self.light.radiance(Dir::from_unit(s)),
                    (Some(FirstHit { interaction: Some(at), .. }), 1..) => {
                        self.exit_radiance_under(&[], &at, numbers, self.options.bounces - 1)
                    }
                    _ => Rgb::ZERO,
                };
                arrived(set, Dir::from_unit(s), radiance * tint);
            }
        }
    }

    /// Intersects a ray with the scene: the first surface, or none if the ray escapes, and the factor of light on the
    /// way there.
    pub(crate) fn intersect(&self, ray: &Ray) -> (Option<FirstHit>, Rgb<f64>) {
        let (hit, tint) = self.surfaces.closest_through(ray);
        (hit.map(|hit| self.first_hit(ray, &hit)), Rgb::from(tint).widen())
    }

    fn first_hit(&self, ray: &Ray, hit: &Hit) -> FirstHit {
        let surface = self.surfaces.scene().surface(hit);
        let towards = ray.direction.map(f64::from);
        let length = dot(towards, towards).sqrt();
        // Turn both normals to the side that is hit.
        let geometric = surface.geometric_normal.map(f64::from);
        let is_front = dot(towards, geometric) < 0.0;
        let material = self.surfaces.scene().material(surface.mesh);
        let side = if is_front { 1.0 } else { -1.0 };
        // Normals of f32 are not of unit length to the last digit of f64.
        let shading = normalized(surface.shading_normal.map(|c| side * f64::from(c)));
        let plane = scale(geometric, side);
        let [r, g, b, _] = surface.base_color;
        let base = Rgb::new(r, g, b);
        // Prepare the BSDF, unless the surface is black from this side.
        let interaction = (is_front || material.double_sided).then(|| {
            let bsdf = match self.options.surfaces {
                Surfaces::Matte => Bsdf::matte(shading, base.widen()),
                gltf => {
                    let is_separable = gltf == Surfaces::MetallicRoughnessSeparable;
                    let facets = Facets::of_roughness(material.roughness.into(), is_separable);
                    let (metallic, view) = (material.metallic.into(), scale(towards, -1.0 / length));
                    Bsdf::metallic_roughness(shading, base.widen(), metallic, facets, view)
                }
            };
            let origin = self.surfaces.bvh().origin_above(surface.position, plane.map(|c| c as f32));
            Interaction { origin, planes: SurfacePlanes::One(plane), bsdf }
        });
        let distance = f64::from(hit.t) * length;
        FirstHit { albedo: base, normal: shading.map(|c| c as f32), distance, interaction }
    }

    /// One path's estimate of the light that leaves `start`, reflected by at most `bounces` surfaces before.
    pub(crate) fn exit_radiance(&self, start: &Interaction, numbers: PathNumbers, bounces: usize) -> Rgb<f64> {
        self.exit_radiance_under(&self.emitters, start, numbers, bounces)
    }

    /// The same under these lamps.
    fn exit_radiance_under(
        &self,
        emitters: &[Emitter],
        start: &Interaction,
        numbers: PathNumbers,
        bounces: usize,
    ) -> Rgb<f64> {
        let samples_light = self.options.strategy != LightStrategy::Bsdf;
        let samples_bsdf = self.options.strategy != LightStrategy::NextEvent;
        let (mut sum, mut throughput) = (Rgb::ZERO, Rgb::splat(1.0));
        let mut next: Option<Interaction> = None;
        for bounce in 0..=bounces {
            let at = next.as_ref().unwrap_or(start);
            // Add the light of a direction drawn from the light.
            if samples_light {
                sum += throughput * self.next_event(at, numbers.pair(Purpose::Light.at(bounce)));
            }
            if !emitters.is_empty() {
                sum += throughput * self.emitted_light(emitters, at, numbers.pair(Purpose::Emitter.at(bounce)));
            }
            // Draw a direction from the BSDF.
            let is_last = bounce == bounces;
            if is_last && !samples_bsdf {
                break;
            }
            let choice = numbers.one(Purpose::Lobe.at(bounce));
            let Some(sample) = at.bsdf.sample(numbers.pair(Purpose::Surface.at(bounce)), choice) else { break };
            if is_below(&at.planes, sample.towards) {
                break;
            }
            // Update the path throughput.
            throughput = throughput * sample.weight;
            // Trace the ray; at the last bounce it only matters whether it escapes.
            let ray = Ray::new(at.origin, sample.towards.map(|c| c as f32));
            let (hit, tint) = if is_last {
                self.passes(&ray).map_or((Some(None), Rgb::ZERO), |tint| (None, tint))
            } else {
                let (hit, tint) = self.intersect(&ray);
                (hit.map(|hit| hit.interaction), tint)
            };
            throughput = throughput * tint;
            match hit {
                // Add the light of the direction drawn from the BSDF.
                None if samples_bsdf => {
                    let s = Dir::from_unit(sample.towards);
                    let (radiance, density) = self.light.radiance_and_density(s);
                    let weight = if samples_light { power_heuristic(sample.density, density) } else { 1.0 };
                    sum += (throughput * radiance).scale(weight);
                    break;
                }
                // Go on from the surface that was hit.
                Some(Some(interaction)) => next = Some(interaction),
                _ => break,
            }
        }
        sum
    }

    /// Next-event estimation: the light that one direction drawn from the light brings to an interaction.
    fn next_event(&self, at: &Interaction, numbers: [f64; 2]) -> Rgb<f64> {
        // Draw a direction from the light.
        let Some(sample) = self.light.sample(numbers) else { return Rgb::ZERO };
        // Evaluate the BSDF towards it.
        let s = sample.towards.to_array();
        let (value, density) = at.bsdf.eval(s);
        if density <= 0.0 || is_below(&at.planes, s) {
            return Rgb::ZERO;
        }
        // Trace the shadow ray.
        let Some(tint) = self.passes(&Ray::new(at.origin, s.map(|c| c as f32))) else { return Rgb::ZERO };
        // Weight the sample against the same direction drawn from the BSDF.
        let is_alone = self.options.strategy == LightStrategy::NextEvent;
        let weight = if is_alone { 1.0 } else { power_heuristic(sample.density, density) };
        (value * sample.radiance * tint).scale(weight / sample.density)
    }

    /// The factor of light along a ray that no surface stops; none if one does.
    fn passes(&self, ray: &Ray) -> Option<Rgb<f64>> {
        self.surfaces.passes_through(ray).map(|tint| Rgb::from(tint).widen())
    }

    /// The light that one direction drawn from each emitter brings to an interaction.
    fn emitted_light(&self, emitters: &[Emitter], at: &Interaction, numbers: [f64; 2]) -> Rgb<f64> {
        let mut sum = Rgb::ZERO;
        for emitter in emitters {
            let Some(sample) = emitter.sample(at.origin.map(f64::from), numbers) else { continue };
            let (value, density) = at.bsdf.eval(sample.towards);
            if density <= 0.0 || is_below(&at.planes, sample.towards) {
                continue;
            }
            let t_max = (sample.distance * (1.0 - BEFORE_EMITTER)) as f32;
            let ray = Ray { t_max, ..Ray::new(at.origin, sample.towards.map(|c| c as f32)) };
            if let Some(tint) = self.passes(&ray) {
                sum += (value * sample.radiance * tint).scale(sample.density.recip());
            }
        }
        sum
    }

    /// Follows one path drawn from the BSDF alone, and calls `escaped` where it leaves the scene.
    fn follow(&self, start: Interaction, numbers: PathNumbers, mut escaped: impl FnMut(usize, Dir, Rgb<f64>)) {
        let (mut at, mut throughput) = (start, Rgb::splat(1.0));
        for bounce in 0..=self.options.bounces {
            // Draw a direction from the BSDF.
            let choice = numbers.one(Purpose::Lobe.at(bounce));
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

    fn receiver_interaction(&self, receiver: &PathReceiver<'_>) -> Interaction {
        let normal = normalized(receiver.normal.map(f64::from));
        let origin = self.surfaces.bvh().origin_above(receiver.position, receiver.lift);
        let planes = match receiver.planes {
            [] => SurfacePlanes::One(normal),
            planes => SurfacePlanes::Around(planes.iter().map(|n| n.map(f64::from)).collect()),
        };
        Interaction { origin, planes, bsdf: Bsdf::matte(normal, receiver.albedo.widen()) }
    }
}

/// The part of the way to an emitter at its end in which nothing hides it, such as the wall that it lies on.
const BEFORE_EMITTER: f64 = 1e-4;

/// A direction over +z, uniform by solid angle.
fn uniform_over_hemisphere([u0, u1]: [f64; 2]) -> Vec3 {
    let radius = ((1.0 - u1) * (1.0 + u1)).sqrt();
    let (sin, cos) = (2.0 * PI * u0).sin_cos();
    [radius * cos, radius * sin, u1]
}

/// The power heuristic with exponent 2: the weight of a direction drawn with density `p` by a strategy, where the other
/// one would draw it with density `q`.
fn power_heuristic(p: f64, q: f64) -> f64 {
    // As ratios, so that squares of large densities do not overflow.
    let ratio = q / p;
    1.0 / (1.0 + ratio * ratio)
}
