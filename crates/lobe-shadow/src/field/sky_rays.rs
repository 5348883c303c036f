//! Occlusion of the sky at a point: rays and their sum over the basis.

use lobe_scene::{Bvh, Ray, Scene};
use lobe_sh::basis::Basis;
use lobe_sh::rotation::tangent_frame;
use lobe_sh::{Dir, Rotation};

use crate::split_mix::{mix, unit};

/// Directions whose basis functions are evaluated together.
const BATCH: usize = 64;

/// Sectors of azimuth in which rays are ordered: a bundle of 256 of several thousand then has similar directions.
const SECTORS: usize = 16;

/// The rays that ask for the side of surfaces, see [`SkyRays::is_inside`]: their closest hits take longer than any hit.
const SIDE_RAYS: usize = 64;

/// `(√5 - 1)/2`.
const GOLDEN_SECTION: f64 = 0.618_033_988_749_894_9;

/// A point is inside a solid if this part of the rays from it hit a surface, and this part of those its back.
const INSIDE_PART: f64 = 0.95;

/// The estimator of occlusion: evenly distributed directions in a cap.
///
/// ```text
///   O_i = ∫ (1 - V) y_i ds ≈ Ω/N Σ_k y_i(s_k),    directions s_k of N in the cap that are occluded
/// ```
///
/// The cap of solid angle `Ω` holds the entity; outside it nothing is occluded, so that far points need no more rays than
/// near ones. Directions lie on a Fibonacci spiral in the cap, one in each of N parts of equal area: `O_00` counts parts and
/// is exact but for those that the outline crosses. The spiral is turned about the axis by an angle of the point's own, so
/// that the errors of different points are independent.
#[derive(Debug)]
pub(crate) struct SkyRays<'a> {
    scene: &'a Scene,
    bvh: &'a Bvh,
    has_holes: bool,
    /// Height in the cap, in `[0, 1]` from its rim to its axis, and azimuth.
    spiral: Vec<[f64; 2]>,
    basis: Basis<f32>,
}

/// The buffers of a thread.
#[derive(Debug, Default)]
pub(crate) struct RayScratch {
    directions: Vec<[f32; 3]>,
    occluded: Vec<bool>,
    hit: [Vec<f32>; 3],
    values: Vec<f32>,
    sums: Vec<f64>,
}

/// A cap of directions.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cap {
    pub(crate) axis: Dir,
    /// The cosine of its half angle; -1 for the whole sphere.
    pub(crate) cosine: f64,
}

impl Cap {
    pub(crate) const SPHERE: Self = Self { axis: Dir::Z, cosine: -1.0 };

    fn solid_angle(&self) -> f64 {
        std::f64::consts::TAU * (1.0 - self.cosine)
    }
}

impl<'a> SkyRays<'a> {
    pub(crate) fn new(scene: &'a Scene, bvh: &'a Bvh, order: usize, rays: u32) -> Self {
        let count = rays as usize;
        let golden_angle = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
        let mut spiral: Vec<[f64; 2]> = (0..count)
            .map(|k| [(k as f64 + 0.5) / count as f64, (golden_angle * k as f64).rem_euclid(std::f64::consts::TAU)])
            .collect();
        let sector = |azimuth: f64| (azimuth / std::f64::consts::TAU * SECTORS as f64) as usize;
        spiral.sort_by_key(|[_, azimuth]| sector(*azimuth));
        Self { scene, bvh, has_holes: scene.has_holes(), spiral, basis: Basis::new(order) }
    }

    /// Rays from a point.
    pub(crate) fn count(&self) -> usize {
        self.spiral.len()
    }

    /// The occlusion of the sky at a point of the scene by what is in the cap. `turn` in `[0, 1)` turns the spiral.
    pub(crate) fn occlusion_into(
        &self,
        origin: [f32; 3],
        cap: Cap,
        turn: f64,
        scratch: &mut RayScratch,
        out: &mut [f32],
    ) {
        self.trace(origin, cap, turn, scratch);
        let RayScratch { directions, occluded, hit, values, sums } = scratch;
        sums.clear();
        sums.resize(out.len(), 0.0);
        values.resize(out.len() * BATCH, 0.0);
        hit.iter_mut().for_each(Vec::clear);
        for (direction, _) in directions.iter().zip(&*occluded).filter(|(_, occluded)| **occluded) {
            (0..3).for_each(|k| hit[k].push(direction[k]));
        }
        for start in (0..hit[0].len()).step_by(BATCH) {
            let [x, y, z] = [0, 1, 2].map(|k| &hit[k][start..(start + BATCH).min(hit[k].len())]);
            let values = &mut values[..out.len() * x.len()];
            self.basis.eval_many_into([x, y, z], values);
            for (sum, values) in sums.iter_mut().zip(values.chunks_exact(x.len())) {
                *sum += values.iter().map(|y| f64::from(*y)).sum::<f64>();
            }
        }
        let weight = cap.solid_angle() / self.count() as f64;
        out.iter_mut().zip(sums).for_each(|(out, sum)| *out = (*sum * weight) as f32);
    }

    /// Traces all rays from a point.
    fn trace(&self, origin: [f32; 3], cap: Cap, turn: f64, scratch: &mut RayScratch) {
        let RayScratch { directions, occluded, .. } = scratch;
        let frame = if cap.cosine > -1.0 { tangent_frame(cap.axis) } else { Rotation::IDENTITY };
        let m = frame.matrix();
        directions.clear();
        directions.extend(self.spiral.iter().map(|[height, azimuth]| {
            let z = cap.cosine + (1.0 - cap.cosine) * height;
            let r = (1.0 - z * z).max(0.0).sqrt();
            let (sin, cos) = (azimuth + std::f64::consts::TAU * turn).sin_cos();
            m.map(|row| (row[0] * r * cos + row[1] * r * sin + row[2] * z) as f32)
        }));
        occluded.resize(directions.len(), false);
        if self.has_holes {
            for (direction, occluded) in directions.iter().zip(occluded) {
                let ray = Ray::new(origin, *direction);
                *occluded = self.bvh.is_occluded_where(&ray, |hit| self.scene.stops(&ray, hit));
            }
        } else {
            self.bvh.occluded_from_into(origin, directions, occluded);
        }
    }

    /// Whether a point is inside a solid, judged by rays in some of the directions that [`SkyRays::occlusion_into`] has
    /// just used: nearly all end, and nearly all of these at the back of a surface. Inside a room, whose walls face it, they
    /// end at fronts.
    pub(crate) fn is_inside(&self, origin: [f32; 3], scratch: &RayScratch) -> bool {
        let occluded = scratch.occluded.iter().filter(|o| **o).count();
        if (occluded as f64) < INSIDE_PART * self.count() as f64 {
            return false;
        }
        let (mut hits, mut backs) = (0, 0);
        for k in 0..SIDE_RAYS.min(self.count()) {
            // Directions are in the order of sectors, and of heights in each: multiples of the golden section are spread
            // evenly over both.
            let place = (k as f64 * GOLDEN_SECTION).fract() * self.count() as f64;
            let direction = &scratch.directions[place as usize];
            if let Some(hit) = self.bvh.closest(&Ray::new(origin, *direction)) {
                let normal = self.scene.surface(&hit).geometric_normal;
                hits += 1;
                backs += usize::from((0..3).map(|k| normal[k] * direction[k]).sum::<f32>() > 0.0);
            }
        }
        hits > 0 && f64::from(backs as u32) >= INSIDE_PART * f64::from(hits as u32)
    }
}

/// A number in `[0, 1)` that depends on all bits of a seed and of an index.
pub(crate) fn turn_of(seed: u64, index: u64) -> f64 {
    unit(mix(mix(seed) ^ index))
}

#[cfg(test)]
mod tests {
    use super::*;
    use lobe_scene::built_in;
    use lobe_sh::Zonal;

    /// The ball of this scene has the radius 1 and the center (0, 0, 1.5); its mesh with 128 sides covers 0.1 % less.
    fn ball() -> Scene {
        let (mut meshes, materials, textures) = built_in::ball_over_ground(128).into_parts();
        meshes.remove(0);
        Scene::new(meshes, materials, textures).unwrap()
    }

    #[test]
    fn a_ball_hides_its_cap() {
        let scene = ball();
        let bvh = Bvh::new(&scene);
        let rays = SkyRays::new(&scene, &bvh, 4, 4096);
        for distance in [1.2_f64, 2.0, 5.0] {
            let axis = Dir::new([0.3, -0.5, 0.8]).unwrap();
            let origin: [f32; 3] = std::array::from_fn(|k| ([0.0, 0.0, 1.5][k] - distance * axis.to_array()[k]) as f32);
            let half_angle = (1.0 / distance).asin();
            let expected = Zonal::cone(4, half_angle).towards(axis, 1.0_f64);
            let wide = Cap { axis, cosine: (1.1 / distance).min(1.0).asin().cos() };
            for cap in [wide, Cap::SPHERE] {
                let mut found = [0.0; 16];
                rays.occlusion_into(origin, cap, 0.3, &mut RayScratch::default(), &mut found);
                let size = Zonal::cone(4, half_angle).coefficients()[0];
                for i in 0..16 {
                    let error = (f64::from(found[i]) - expected[i]).abs() / size;
                    let allowed = if cap.cosine > -1.0 { 0.02 } else { 0.1 };
                    assert!(error < allowed, "{distance}, {i}: {} against {}", found[i], expected[i]);
                }
            }
        }
    }

    #[test]
    fn the_inside_of_a_solid_is_told_from_the_inside_of_a_room() {
        let inside = |scene: &Scene, origin| {
            let bvh = Bvh::new(scene);
            let rays = SkyRays::new(scene, &bvh, 2, 256);
            let mut scratch = RayScratch::default();
            rays.occlusion_into(origin, Cap::SPHERE, 0.0, &mut scratch, &mut [0.0; 4]);
            rays.is_inside(origin, &scratch)
        };
        assert!(inside(&ball(), [0.1, 0.2, 1.5]), "in the ball");
        assert!(!inside(&ball(), [0.1, 0.2, 0.4]), "below the ball");
        assert!(!inside(&built_in::closed_white_box(2), [0.1, 0.2, 0.3]), "in a room that faces its inside");
    }
}
