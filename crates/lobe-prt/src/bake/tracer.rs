//! Path tracing from a receiver towards the distant light.

use glam::Vec3;
use lobe_scene::{Ray, SurfaceRays};

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

impl Tracer<'_> {
    /// The origin of rays from a receiver.
    pub(crate) fn origin_above(&self, position: [f32; 3], normal: [f32; 3]) -> [f32; 3] {
        self.0.bvh().origin_above(position, normal)
    }

    /// Follows a path for at most `bounces` reflections, whose directions come from point `index` of the sequences.
    /// Counts its rays.
    pub(crate) fn follow(&self, ray: Ray, bounces: usize, sobol: &Sobol, index: u32, rays: &mut u64) -> PathEnd {
        let Self(surfaces) = self;
        let scene = surfaces.scene();
        let mut ray = ray;
        let mut throughput = [1.0; 3];
        for bounce in 0..bounces {
            // Find the first surface along the ray; without one the path escapes to the light.
            *rays += 1;
            let (hit, tint) = surfaces.closest_through(&ray);
            (0..3).for_each(|c| throughput[c] *= tint[c]);
            let Some(hit) = hit else {
                return PathEnd::Escaped { direction: ray.direction, throughput, bounce };
            };
            // End at back sides that reflect nothing.
            let surface = scene.surface(&hit);
            let towards = Vec3::from(surface.geometric_normal).dot(Vec3::from(ray.direction));
            if towards >= 0.0 && !scene.material(surface.mesh).double_sided {
                return PathEnd::Absorbed;
            }
            // Multiply the throughput by the albedo.
            (0..3).for_each(|c| throughput[c] *= surface.base_color[c]);
            // Sample the next direction about the shading normal, on the side that was met.
            let side = if towards < 0.0 { 1.0 } else { -1.0 };
            let geometric = surface.geometric_normal.map(|c| c * side);
            let shading = surface.shading_normal.map(|c| c * side);
            let direction = Frame::about(shading).cosine(sobol.point(index, bounce + 1));
            if throughput == [0.0; 3] || Vec3::from(direction).dot(Vec3::from(geometric)) <= 0.0 {
                return PathEnd::Absorbed;
            }
            // Go on from above the surface.
            ray = Ray::new(self.origin_above(surface.position, geometric), direction);
        }
        // After the last reflection only ask whether the path escapes.
        *rays += 1;
        match surfaces.passes_through(&ray) {
            None => PathEnd::Left { throughput },
            Some(tint) => {
                let throughput = [0, 1, 2].map(|c| throughput[c] * tint[c]);
                PathEnd::Escaped { direction: ray.direction, throughput, bounce: bounces }
            }
        }
    }
}
