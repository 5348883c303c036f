//! Light along paths: what leaves a point of a scene towards an eye, by nothing but sampling.

use std::f64::consts::PI;

use lobe_scene::{Bvh, Hit, Ray, Scene};
use lobe_sh::{Coefficient as _, Dir, Rgb};

use crate::DistantLight;
use crate::path_tracer::bsdf::Bsdf;
use crate::path_tracer::estimate::{Estimate, SampleCount, estimate};
use crate::path_tracer::sampler::{PathNumbers, SampleSet};
use crate::vector::{Vec3, dot, normalized, scale, tangents};

/// What a path is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathOptions {
    /// How often light is reflected before the surface that is looked at reflects it: 0 for light that comes straight
    /// from afar.
    pub bounces: usize,
    /// How directions towards the light are found.
    pub strategy: LightStrategy,
    /// How surfaces reflect.
    pub surfaces: Surfaces,
    /// Another seed gives other paths.
    pub seed: u64,
}

impl Default for PathOptions {
    /// Three bounces among matte surfaces, both strategies.
    fn default() -> Self {
        Self { bounces: 3, strategy: LightStrategy::Both, surfaces: Surfaces::Matte, seed: 0 }
    }
}

/// How directions towards the light are found. All have the same mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LightStrategy {
    /// Drawn from the light as well as from the surface, weighted by the power heuristic ([Veach and Guibas 1995]).
    ///
    /// ```text
    ///   w = p² / (p² + q²)      p: density of the strategy that drew the direction; q: of the other one
    /// ```
    ///
    /// [Veach and Guibas 1995]: https://doi.org/10.1145/218380.218498
    Both,
    /// Drawn from the surface alone: for light that is smooth.
    FromSurface,
    /// Drawn from the light alone: for matte surfaces under small lights.
    FromLight,
}

/// How surfaces reflect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Surfaces {
    /// All are matte and their albedo is the base color; metallic and roughness are ignored. This is what a diffuse bake
    /// computes.
    Matte,
    /// The metallic-roughness model of glTF 2.0.
    MetallicRoughness,
}

/// A point that sends light back like a matte surface, such as a vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathReceiver {
    /// Where it is.
    pub position: [f32; 3],
    /// The unit normal to shade with; rays go to its side.
    pub normal: [f32; 3],
    /// The reflected part of the light.
    pub albedo: Rgb<f32>,
}

/// Sends paths through a scene under a distant light.
///
/// ```text
///   B(x) = ∫ L_in(s) f(s) max(n·s, 0) ds        L_in = the light where the ray escapes, else B of what it hits
/// ```
///
/// A surface that is not double-sided is black from behind and stops light all the same. Otherwise both normals are turned to
/// the side that is hit; it is shaded with the interpolated one, and directions behind the triangle's plane bring nothing.
/// Rays start at [`Bvh::origin_above`]. Holes of alpha masks let rays through. Nothing is clamped, paths end by the number of
/// bounces alone: the mean is unbiased.
pub struct PathTracer<'a> {
    scene: &'a Scene,
    bvh: &'a Bvh,
    light: &'a DistantLight,
    options: PathOptions,
    has_masks: bool,
}

/// A point where a path goes on.
pub(crate) struct Node {
    /// Where rays start.
    origin: [f32; 3],
    /// The normal of the plane that rays go above of.
    plane: Vec3,
    bsdf: Bsdf,
}

/// What a ray from the eye finds first.
pub(crate) struct Seen {
    pub(crate) albedo: Rgb<f32>,
    pub(crate) normal: [f32; 3],
    /// Along the ray.
    pub(crate) distance: f64,
    /// None if the surface is black from this side.
    pub(crate) node: Option<Node>,
}

/// Purposes of random numbers at each point of a path; see [`Purpose::at`].
#[derive(Clone, Copy)]
enum Purpose {
    Light = 1,
    Surface = 2,
    Lobe = 3,
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
        Self { scene, bvh, light, options, has_masks: scene.has_masks() }
    }

    /// The exit radiance of receiver number `place`, with its variance.
    ///
    /// Receivers of different numbers use independent paths.
    #[must_use]
    pub fn radiance_at(&self, receiver: &PathReceiver, place: usize, count: &SampleCount) -> Estimate {
        let node = self.receiver_node(receiver);
        estimate(count, |set, path| {
            let numbers = SampleSet::new(self.options.seed, place as u64, set as u64).path(path);
            self.radiance_of(&node, numbers, self.options.bounces)
        })
    }

    /// Follows paths from receiver number `place` that are drawn from surfaces alone, and calls `escaped` for each that
    /// leaves the scene: with its set, the number of bounces before the receiver's own, its direction, and its weight.
    ///
    /// ```text
    ///   B = Σ_paths weight L(direction) / number of paths       of the paths with at most so many bounces
    /// ```
    ///
    /// The same paths serve any number of lights.
    pub fn for_each_escape(
        &self,
        receiver: &PathReceiver,
        place: usize,
        count: &SampleCount,
        mut escaped: impl FnMut(usize, usize, Dir, Rgb<f64>),
    ) {
        for set in 0..count.sets {
            let samples = SampleSet::new(self.options.seed, place as u64, set as u64);
            for path in 0..count.per_set {
                let node = self.receiver_node(receiver);
                self.follow(node, samples.path(path), |bounce, s, weight| escaped(set, bounce, s, weight));
            }
        }
    }

    /// Follows paths of the light that arrives at receiver number `place`, and calls `arrived` for each: with its set, the
    /// direction it comes from, uniform over the hemisphere Ω above the receiver, and an estimate of the radiance from there.
    ///
    /// ```text
    ///   ∫_Ω f(s) L_in(s) ds = 2π Σ_paths f(direction) radiance / number of paths
    /// ```
    ///
    /// Bounces are counted before the receiver's own reflection, whatever that is: its albedo plays no part.
    pub fn for_each_arrival(
        &self,
        receiver: &PathReceiver,
        place: usize,
        count: &SampleCount,
        mut arrived: impl FnMut(usize, Dir, Rgb<f64>),
    ) {
        let Node { origin, plane, .. } = self.receiver_node(receiver);
        let [u, v] = tangents(plane);
        for set in 0..count.sets {
            let samples = SampleSet::new(self.options.seed, place as u64, set as u64);
            for path in 0..count.per_set {
                let numbers = samples.path(path);
                let [x, y, z] = uniform_over_hemisphere(numbers.pair(FIRST_PURPOSE));
                let s = std::array::from_fn(|k| x * u[k] + y * v[k] + z * plane[k]);
                let radiance = match (self.see(&Ray::new(origin, s.map(|c| c as f32))), self.options.bounces) {
                    (None, _) => self.light.radiance(Dir::from_unit(s)),
                    (Some(Seen { node: Some(node), .. }), 1..) => {
                        self.radiance_of(&node, numbers, self.options.bounces - 1)
                    }
                    _ => Rgb::ZERO,
                };
                arrived(set, Dir::from_unit(s), radiance);
            }
        }
    }

    /// What a ray finds, or none if it escapes.
    pub(crate) fn see(&self, ray: &Ray) -> Option<Seen> {
        let hit = self.closest(ray)?;
        let surface = self.scene.surface(&hit);
        let towards = ray.direction.map(f64::from);
        let length = dot(towards, towards).sqrt();
        let geometric = surface.geometric_normal.map(f64::from);
        let is_front = dot(towards, geometric) < 0.0;
        let material = self.scene.material(surface.mesh);
        let side = if is_front { 1.0 } else { -1.0 };
        // Normals of f32 are not of unit length to the last digit of f64.
        let shading = normalized(surface.shading_normal.map(|c| side * f64::from(c)));
        let plane = scale(geometric, side);
        let [r, g, b, _] = surface.base_color;
        let base = Rgb::new(r, g, b);
        let node = (is_front || material.double_sided).then(|| {
            let bsdf = match self.options.surfaces {
                Surfaces::Matte => Bsdf::matte(shading, base.widen()),
                Surfaces::MetallicRoughness => {
                    let (metallic, roughness) = (f64::from(material.metallic), f64::from(material.roughness));
                    Bsdf::metallic_roughness(shading, base.widen(), metallic, roughness, scale(towards, -1.0 / length))
                }
            };
            Node { origin: self.bvh.origin_above(surface.position, plane.map(|c| c as f32)), plane, bsdf }
        });
        let distance = f64::from(hit.t) * length;
        Some(Seen { albedo: base, normal: shading.map(|c| c as f32), distance, node })
    }

    /// One path's estimate of what leaves a node that light reaches by so many bounces.
    pub(crate) fn radiance_of(&self, node: &Node, numbers: PathNumbers, bounces: usize) -> Rgb<f64> {
        let draws_light = self.options.strategy != LightStrategy::FromSurface;
        let draws_surface = self.options.strategy != LightStrategy::FromLight;
        let (mut sum, mut throughput) = (Rgb::ZERO, Rgb::splat(1.0));
        let mut next: Option<Node> = None;
        for bounce in 0..=bounces {
            let node = next.as_ref().unwrap_or(node);
            if draws_light {
                sum += throughput * self.light_drawn(node, numbers.pair(Purpose::Light.at(bounce)));
            }
            let is_last = bounce == bounces;
            if is_last && !draws_surface {
                break;
            }
            let choice = numbers.one(Purpose::Lobe.at(bounce));
            let Some(sample) = node.bsdf.sample(numbers.pair(Purpose::Surface.at(bounce)), choice) else { break };
            if dot(sample.towards, node.plane) <= 0.0 {
                break;
            }
            throughput = throughput * sample.weight;
            let ray = Ray::new(node.origin, sample.towards.map(|c| c as f32));
            let seen = if is_last { self.is_blocked(&ray).then_some(None) } else { self.see(&ray).map(|s| s.node) };
            match seen {
                None if draws_surface => {
                    let s = Dir::from_unit(sample.towards);
                    let weight = if draws_light { power(sample.density, self.light.density(s)) } else { 1.0 };
                    sum += (throughput * self.light.radiance(s)).scale(weight);
                    break;
                }
                Some(Some(found)) => next = Some(found),
                _ => break,
            }
        }
        sum
    }

    /// What a direction drawn from the light brings to a node.
    fn light_drawn(&self, node: &Node, numbers: [f64; 2]) -> Rgb<f64> {
        let Some(sample) = self.light.sample(numbers) else { return Rgb::ZERO };
        let s = sample.towards.to_array();
        let (value, density) = node.bsdf.eval(s);
        if density <= 0.0 || dot(s, node.plane) <= 0.0 {
            return Rgb::ZERO;
        }
        if self.is_blocked(&Ray::new(node.origin, s.map(|c| c as f32))) {
            return Rgb::ZERO;
        }
        let is_alone = self.options.strategy == LightStrategy::FromLight;
        let weight = if is_alone { 1.0 } else { power(sample.density, density) };
        (value * sample.radiance).scale(weight / sample.density)
    }

    fn follow(&self, start: Node, numbers: PathNumbers, mut escaped: impl FnMut(usize, Dir, Rgb<f64>)) {
        let (mut node, mut throughput) = (start, Rgb::splat(1.0));
        for bounce in 0..=self.options.bounces {
            let choice = numbers.one(Purpose::Lobe.at(bounce));
            let Some(sample) = node.bsdf.sample(numbers.pair(Purpose::Surface.at(bounce)), choice) else { return };
            if dot(sample.towards, node.plane) <= 0.0 {
                return;
            }
            throughput = throughput * sample.weight;
            match self.see(&Ray::new(node.origin, sample.towards.map(|c| c as f32))) {
                None => return escaped(bounce, Dir::from_unit(sample.towards), throughput),
                Some(Seen { node: Some(found), .. }) => node = found,
                Some(_) => return,
            }
        }
    }

    fn receiver_node(&self, receiver: &PathReceiver) -> Node {
        let normal = normalized(receiver.normal.map(f64::from));
        let origin = self.bvh.origin_above(receiver.position, receiver.normal);
        Node { origin, plane: normal, bsdf: Bsdf::matte(normal, receiver.albedo.widen()) }
    }

    fn closest(&self, ray: &Ray) -> Option<Hit> {
        if self.has_masks { self.bvh.closest_where(ray, |hit| self.scene.is_solid(hit)) } else { self.bvh.closest(ray) }
    }

    fn is_blocked(&self, ray: &Ray) -> bool {
        if self.has_masks {
            self.bvh.is_occluded_where(ray, |hit| self.scene.is_solid(&hit))
        } else {
            self.bvh.is_occluded(ray)
        }
    }
}

/// A direction over +z, all alike.
fn uniform_over_hemisphere([u0, u1]: [f64; 2]) -> Vec3 {
    let radius = ((1.0 - u1) * (1.0 + u1)).sqrt();
    let (sin, cos) = (2.0 * PI * u0).sin_cos();
    [radius * cos, radius * sin, u1]
}

/// The power heuristic's weight of a direction drawn with density `p` that the other strategy draws with `q`.
fn power(p: f64, q: f64) -> f64 {
    // As ratios, so that squares of large densities do not overflow.
    let ratio = q / p;
    1.0 / (1.0 + ratio * ratio)
}
