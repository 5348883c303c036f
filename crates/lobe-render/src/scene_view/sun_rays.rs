//! Direct light of suns: how much of each disc a point of a surface sees, by rays.

use std::f64::consts::TAU;

use lobe_env::{SceneLight, Sun};
use lobe_scene::{Bvh, Ray, Scene, SurfaceRays};
use lobe_sh::sphere::vector::{Vec3, dot, tangents_along_z};
use lobe_sh::{Coefficient as _, Dir, Rgb};

use crate::scene_view::silhouettes::place_in_pixel;

/// Rays to the rim of a disc that tell, with [`INNER`], whether a point lies in the penumbra: all of them meet the
/// same if it does not. A straight edge that passes between two of them hides 1.2 % of the disc at most.
const RIM: usize = 8;

/// Rays to the inside for the same. A bar between them that no ray meets is narrower than half of the disc's radius,
/// and hides 30 % of it at most (test `a_bar_before_a_sun_hides_its_part_of_the_disc`).
const INNER: usize = 16;

/// Rays to a disc in its penumbra: steps of a sixty-fourth of the sun do not show.
const RAYS: usize = 64;

/// The suns of a light as surfaces of a scene see them.
///
/// ```text
///   E(x, n) = Σ_suns E_sun(n) Σₖ wₖ V(x, sₖ) / Σₖ wₖ        wₖ = max(n·sₖ, 0)
/// ```
///
/// `sₖ` are directions over the disc of the sun, the same for all points, `V` is 1 where a ray leaves the scene, the
/// tint of the glass that it passes, or 0. A point outside of all shadows has the irradiance of the whole disc,
/// [`Sun::irradiance_at`]. Rays are traced to 24 points of each disc, and to 64 others where these do not agree.
#[derive(Debug)]
pub struct SunRays<'a> {
    surfaces: SurfaceRays<'a>,
    discs: Vec<Disc>,
    /// Whether surfaces hide them from each other.
    are_hidden: bool,
}

/// A sun with the directions that are looked at.
#[derive(Debug)]
struct Disc {
    sun: Sun,
    /// Points of the rim and inside.
    probes: Vec<Dir>,
    /// Points all over it.
    points: Vec<Dir>,
}

impl Disc {
    fn new(sun: Sun) -> Self {
        let axis = sun.direction.to_array();
        let [u, v] = tangents_along_z(axis);
        // 1 - cos of the radius, without cancellation.
        let height = 2.0 * (0.25 * sun.angular_diameter).sin().powi(2);
        // A part of the solid angle around the center, and of a turn.
        let at = |[part, turn]: [f64; 2]| {
            let depth = part * height;
            let (sin, cos) = (TAU * turn).sin_cos();
            let r = (depth * (2.0 - depth)).max(0.0).sqrt();
            Dir::from_unit([0, 1, 2].map(|i| r * cos * u[i] + r * sin * v[i] + (1.0 - depth) * axis[i]))
        };
        let rim = (0..RIM).map(|k| at([1.0, k as f64 / RIM as f64]));
        let inner = (0..INNER).map(|k| at(place_in_pixel(k, INNER)));
        let points = (0..RAYS).map(|k| at(place_in_pixel(k, RAYS)));
        Self { sun, probes: rim.chain(inner).collect(), points: points.collect() }
    }
}

/// A point of a surface, on the side from which it is lit.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePoint {
    /// Where it is, in the frame of the scene.
    pub position: [f32; 3],
    /// The unit normal of the plane in which it lies.
    pub plane: Vec3,
    /// The unit normal to shade with.
    pub normal: Dir,
}

/// What directions show of a sun, and their weight.
struct Seen {
    sum: Rgb<f64>,
    weight: f64,
    is_mixed: bool,
}

impl<'a> SunRays<'a> {
    /// The suns of a light in the world of a scene, whose tree is `bvh`.
    #[must_use]
    pub fn new(scene: &'a Scene, bvh: &'a Bvh, light: &SceneLight) -> Self {
        let discs = light.suns().iter().map(|sun| Disc::new(*sun)).collect();
        Self { surfaces: SurfaceRays::new(scene, bvh), discs, are_hidden: true }
    }

    /// The same suns, seen through all surfaces if they are not hidden.
    #[must_use]
    pub fn hidden(self, are_hidden: bool) -> Self {
        Self { are_hidden, ..self }
    }

    /// The irradiance of a point by all suns, without those parts of their discs that surfaces hide.
    #[must_use]
    pub fn irradiance(&self, at: &SurfacePoint) -> Rgb<f64> {
        self.discs.iter().fold(Rgb::ZERO, |all, disc| all + self.of_disc(disc, at))
    }

    /// The suns that shine on a point, each with its irradiance there.
    pub fn shining_on(&self, at: &SurfacePoint) -> impl Iterator<Item = (Sun, Rgb<f64>)> {
        let lit = self.discs.iter().map(|disc| (disc.sun, self.of_disc(disc, at)));
        lit.filter(|(_, irradiance)| *irradiance != Rgb::ZERO)
    }

    fn of_disc(&self, disc: &Disc, at: &SurfacePoint) -> Rgb<f64> {
        let open = disc.sun.irradiance_at(at.normal);
        if open == Rgb::ZERO || !self.are_hidden {
            return open;
        }
        let mut seen = self.look(at, &disc.probes);
        if seen.is_mixed {
            seen = self.look(at, &disc.points);
        }
        if seen.weight > 0.0 { open * seen.sum.scale(seen.weight.recip()) } else { Rgb::ZERO }
    }

    /// The part of these directions that light comes from.
    fn look(&self, at: &SurfacePoint, towards: &[Dir]) -> Seen {
        let origin = self.surfaces.bvh().origin_above(at.position, at.plane.map(|c| c as f32));
        let rays: Vec<Ray> = towards.iter().map(|s| Ray::new(origin, s.to_array().map(|c| c as f32))).collect();
        let passed = self.surfaces.passes_through_each(&rays);
        let mut seen = Seen { sum: Rgb::ZERO, weight: 0.0, is_mixed: false };
        let mut first = None;
        for (s, tint) in towards.iter().zip(passed) {
            // A ray into the surface meets it.
            let tint = tint.filter(|_| dot(s.to_array(), at.plane) > 0.0).unwrap_or([0.0; 3]);
            let weight = at.normal.dot(*s).max(0.0);
            seen.is_mixed |= *first.get_or_insert(tint) != tint || weight == 0.0;
            seen.sum += Rgb::from(tint).widen().scale(weight);
            seen.weight += weight;
        }
        seen
    }
}
