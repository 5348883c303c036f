//! Path tracing from a receiver towards the distant light.

use glam::Vec3;
use lobe_scene::{Hit, Ray, SurfaceRays};

use crate::sampling::sobol::Sobol;
use crate::sampling::warp::Frame;

/// The tracer of paths through a scene.
///
/// Where a path meets a surface, the side is that of the geometric normal. A back side that is not double-sided
/// reflects nothing. Otherwise both normals are turned to the side met, and the path goes on, cosine-weighted about the
/// normal to shade with, tilted by a normal map if there is one, from above the surface; a direction below the surface brings
/// nothing. Its throughput is multiplied by the tints of the glass that it passes, and by the albedo: density and
/// cosine cancel,
///
/// ```text
///   L(x, -d) = ρ/π ∫ L_in(s) max(n·s, 0) ds = ρ E[L_in(s)],    s of density max(n·s, 0)/π
/// ```
/// `PathTracer` of `lobe-render` has the same rule and says what it does to energy.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tracer<'a>(pub(crate) SurfaceRays<'a>);

/// The end of a path, with its throughput.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum PathEnd {
    /// It left the scene along `direction` after `bounce` reflections, by which its throughput was multiplied.
    Escaped { direction: [f32; 3], throughput: [f32; 3], bounce: usize },
    /// It met a surface after its last reflection.
    Left { throughput: [f32; 3] },
    /// It met a surface that reflects nothing.
    Absorbed,
}

/// Paths from a point, at least, whose first rays are traced together: rays of an octant share the work, and of 16
/// paths there are two or three to each (`lobe bake --samples 256`, a fit, takes 0.9 to 1.2 times as long by bundles).
const TOGETHER: usize = 24;

/// The first directions of paths from one point, with their numbers in the sequences, and room for what they meet.
#[derive(Debug, Default)]
pub(crate) struct Starts {
    directions: Vec<[f32; 3]>,
    numbers: Vec<u32>,
    hits: Vec<Option<Hit>>,
    occluded: Vec<bool>,
}

impl Starts {
    pub(crate) fn clear(&mut self) {
        self.directions.clear();
        self.numbers.clear();
    }

    pub(crate) fn push(&mut self, direction: [f32; 3], number: u32) {
        self.directions.push(direction);
        self.numbers.push(number);
    }

    /// The ends of the paths where nothing is in the way, each with its first direction.
    pub(crate) fn escape(&self, mut end: impl FnMut([f32; 3], PathEnd)) {
        for &direction in &self.directions {
            end(direction, PathEnd::Escaped { direction, throughput: [1.0; 3], bounce: 0 });
        }
    }
}

impl Tracer<'_> {
    /// The origin of rays from a receiver.
    pub(crate) fn origin_above(&self, position: [f32; 3], normal: [f32; 3]) -> [f32; 3] {
        self.0.bvh().origin_above(position, normal)
    }

    /// Follows paths from one point, which start together, and calls `end` with the first direction of each and its
    /// end, in their order. Counts their rays.
    ///
    /// The first rays are traced in bundles, which few of them are not worth. Where glass tints light, each is alone.
    pub(crate) fn follow_all(
        &self,
        origin: [f32; 3],
        starts: &mut Starts,
        bounces: usize,
        sobol: &Sobol,
        rays: &mut u64,
        mut end: impl FnMut([f32; 3], PathEnd),
    ) {
        let Self(surfaces) = self;
        let Starts { directions, numbers, hits, occluded } = starts;
        if surfaces.is_tinted() || (bounces > 0 && directions.len() < TOGETHER) {
            for (direction, number) in directions.iter().zip(numbers) {
                end(*direction, self.follow(Ray::new(origin, *direction), bounces, sobol, *number, rays));
            }
            return;
        }
        *rays += directions.len() as u64;
        let throughput = [1.0; 3];
        let escaped = |direction| PathEnd::Escaped { direction, throughput, bounce: 0 };
        if bounces == 0 {
            occluded.resize(directions.len(), false);
            surfaces.occluded_from_into(origin, directions, occluded);
            for (direction, occluded) in directions.iter().zip(occluded) {
                end(*direction, if *occluded { PathEnd::Left { throughput } } else { escaped(*direction) });
            }
            return;
        }
        hits.resize(directions.len(), None);
        surfaces.closest_from_into(origin, directions, hits);
        for ((direction, number), hit) in directions.iter().zip(numbers).zip(hits) {
            let ray = Ray::new(origin, *direction);
            end(
                *direction,
                match hit {
                    Some(hit) => self.follow_from(ray, (*hit, throughput), bounces, sobol, *number, rays),
                    None => escaped(*direction),
                },
            );
        }
    }

    /// Follows a path for at most `bounces` reflections, whose directions come from point `index` of the sequences.
    /// Counts its rays.
    pub(crate) fn follow(&self, ray: Ray, bounces: usize, sobol: &Sobol, index: u32, rays: &mut u64) -> PathEnd {
        if bounces == 0 {
            return self.last(&ray, [1.0; 3], 0, rays);
        }
        // Find the first surface along the ray; without one the path escapes to the light.
        *rays += 1;
        match self.0.closest_through(&ray) {
            (None, throughput) => PathEnd::Escaped { direction: ray.direction, throughput, bounce: 0 },
            (Some(hit), throughput) => self.follow_from(ray, (hit, throughput), bounces, sobol, index, rays),
        }
    }

    /// Follows a path on from the hit of its first ray, to which it came with this throughput; one bounce at least.
    fn follow_from(
        &self,
        ray: Ray,
        (hit, throughput): (Hit, [f32; 3]),
        bounces: usize,
        sobol: &Sobol,
        index: u32,
        rays: &mut u64,
    ) -> PathEnd {
        let (mut ray, mut hit, mut throughput) = (ray, hit, throughput);
        for bounce in 1..=bounces {
            match self.reflected(&ray, &hit, &mut throughput, sobol.point(index, bounce)) {
                Some(reflected) => ray = reflected,
                None => return PathEnd::Absorbed,
            }
            if bounce < bounces {
                *rays += 1;
                let (next, tint) = self.0.closest_through(&ray);
                (0..3).for_each(|c| throughput[c] *= tint[c]);
                match next {
                    Some(next) => hit = next,
                    None => return PathEnd::Escaped { direction: ray.direction, throughput, bounce },
                }
            }
        }
        self.last(&ray, throughput, bounces, rays)
    }

    /// The ray that goes on from a hit, by a point of the unit square; none if the surface reflects nothing there.
    #[inline]
    fn reflected(&self, ray: &Ray, hit: &Hit, throughput: &mut [f32; 3], point: [f32; 2]) -> Option<Ray> {
        // End at back sides that reflect nothing.
        let scene = self.0.scene();
        let surface = scene.surface(hit);
        let towards = Vec3::from(surface.geometric_normal).dot(Vec3::from(ray.direction));
        if towards >= 0.0 && !scene.material(surface.mesh).double_sided {
            return None;
        }
        // Multiply the throughput by the albedo.
        (0..3).for_each(|c| throughput[c] *= surface.base_color[c]);
        // Sample the next direction about the shading normal, on the side that was met.
        let side = if towards < 0.0 { 1.0 } else { -1.0 };
        let geometric = surface.geometric_normal.map(|c| c * side);
        let shading = surface.shading_normal.map(|c| c * side);
        let direction = Frame::about(shading).cosine(point);
        let goes_on = *throughput != [0.0; 3] && Vec3::from(direction).dot(Vec3::from(geometric)) > 0.0;
        // Go on from above the surface.
        goes_on.then(|| Ray::new(self.origin_above(surface.position, geometric), direction))
    }

    /// The end of a path after its last reflection: only whether it escapes is asked.
    #[inline]
    fn last(&self, ray: &Ray, throughput: [f32; 3], bounce: usize, rays: &mut u64) -> PathEnd {
        *rays += 1;
        match self.0.passes_through(ray) {
            None => PathEnd::Left { throughput },
            Some(tint) => {
                let throughput = [0, 1, 2].map(|c| throughput[c] * tint[c]);
                PathEnd::Escaped { direction: ray.direction, throughput, bounce }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use lobe_scene::{Bvh, Scene, built_in};

    use super::*;

    /// Compares paths that start together at a vertex with each alone; returns how many met something.
    fn compared(tracer: &Tracer<'_>, [position, normal]: [[f32; 3]; 2], bounces: usize, count: u32) -> usize {
        let origin = tracer.origin_above(position, normal);
        let sobol = Sobol::at_place(5, position.into_iter(), bounces);
        let mut starts = Starts::default();
        let (mut rays, mut expected_rays) = (0, 0);
        let mut expected = Vec::new();
        for number in 0..count {
            let direction = Frame::about(normal).cosine(sobol.point(number, 0));
            starts.push(direction, number);
            let ray = Ray::new(origin, direction);
            expected.push((direction, tracer.follow(ray, bounces, &sobol, number, &mut expected_rays)));
        }
        let mut found = Vec::new();
        let end = |start, end| found.push((start, end));
        tracer.follow_all(origin, &mut starts, bounces, &sobol, &mut rays, end);
        assert_eq!(found, expected, "{bounces} bounces from {position:?}");
        assert_eq!(rays, expected_rays, "rays of {bounces} bounces from {position:?}");
        let escapes = |(start, end): &&([f32; 3], PathEnd)| match end {
            PathEnd::Escaped { direction, .. } => direction == start,
            PathEnd::Left { .. } | PathEnd::Absorbed => false,
        };
        found.len() - found.iter().filter(escapes).count()
    }

    fn vertices(scene: &Scene) -> impl Iterator<Item = [[f32; 3]; 2]> {
        scene.meshes().iter().flat_map(|mesh| mesh.positions().iter().zip(mesh.normals())).map(|(p, n)| [*p, *n])
    }

    #[test]
    fn paths_that_start_together_end_as_each_does_alone() {
        for (name, scene) in [("ball", built_in::ball_over_ground(32)), ("columns", built_in::columns_hall(1))] {
            let bvh = Bvh::new(&scene);
            let tracer = Tracer(SurfaceRays::new(&scene, &bvh));
            // Few are traced one by one.
            for (bounces, count) in [(0, 50), (1, 50), (3, 50), (3, TOGETHER as u32 - 1)] {
                let vertices = vertices(&scene).step_by(97);
                let met: usize = vertices.map(|vertex| compared(&tracer, vertex, bounces, count)).sum();
                assert!(met > 50, "{name}, {bounces} bounces: {met} paths met something, enough to tell");
            }
        }
    }
}
