//! Spheres as large as the shape that they stand for, as seen from all sides.

use std::f64::consts::TAU;

use glam::DVec3;
use lobe_io::parallel;
use lobe_scene::{Bvh, Ray, Scene};

use crate::spheres::sphere_set::SphereSet;

/// Lines through the ball around a shape and its spheres.
const LINES: usize = 1 << 14;

/// Additive steps of the plastic number and of its square (Roberts 2018).
const STEPS: [f64; 2] = [0.754_877_666_246_692_8, 0.569_840_290_998_053_2];

/// The additive step of the golden ratio.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

impl SphereSet {
    /// The same spheres, all smaller by one factor, so that together they hide as much of the sky as a shape does, in
    /// the mean over all sides. Spheres that [cover](crate::fit_spheres) a shape reach out of it, and hide more: 16 of
    /// the bunny make the ground within three pixels of it 4 % darker than it is.
    ///
    /// Of lines spread evenly over places and directions, as many hit a sphere as hit the shape. That is exact for the
    /// mean area of silhouettes (Cauchy), to the part that 16384 lines resolve. Spheres are never made larger.
    #[must_use]
    pub fn with_silhouette_of(self, scene: &Scene) -> Self {
        let Some(factor) = self.silhouette_factor(scene) else { return self };
        self.scaled(factor)
    }

    /// The factor; none where nothing is hit.
    fn silhouette_factor(&self, scene: &Scene) -> Option<f64> {
        let spheres: Vec<(DVec3, f64)> = (0..self.len())
            .map(|k| (DVec3::from_array(self.center(k)), f64::from(self.radii()[k])))
            .filter(|(_, radius)| *radius > 0.0)
            .collect();
        let origin = DVec3::from_array(scene.origin());
        let [min, max] = scene.world_bounds().map(DVec3::from_array);
        let middle = 0.5 * (min + max);
        let far = spheres.iter().map(|(center, radius)| center.distance(middle) + radius);
        let reach = far.fold(0.5 * min.distance(max), f64::max);
        let bvh = Bvh::new(scene);
        // How many times as large spheres must be for each line to touch one, and whether it hits the shape.
        let lines: Vec<(f64, bool)> = parallel::map(LINES, &|k| {
            let (through, along) = line(k, middle, reach);
            let least = spheres.iter().map(|(center, radius)| (center - through).cross(along).length() / radius);
            let begin = (through - reach * along - origin).as_vec3().to_array();
            (least.fold(f64::INFINITY, f64::min), bvh.is_occluded(&Ray::new(begin, along.as_vec3().to_array())))
        });
        let hits = lines.iter().filter(|(_, is_hit)| *is_hit).count();
        let mut least: Vec<f64> = lines.into_iter().map(|(least, _)| least).collect();
        least.sort_unstable_by(f64::total_cmp);
        let factor = hits.checked_sub(1).map(|last| least[last])?;
        (factor > 0.0 && factor < 1.0).then_some(factor)
    }
}

/// A line through a ball: a point of it in the plane through the middle, and its direction.
fn line(number: usize, middle: DVec3, reach: f64) -> (DVec3, DVec3) {
    let part = (number as f64 + 0.5) / LINES as f64;
    let [u, v] = STEPS.map(|step| (0.5 + step * number as f64).fract());
    let (z, turn) = (1.0 - 2.0 * part, TAU * (GOLDEN * number as f64).fract());
    let along = DVec3::new((1.0 - z * z).sqrt() * turn.cos(), (1.0 - z * z).sqrt() * turn.sin(), z);
    let (x, y) = along.any_orthonormal_pair();
    let (distance, angle) = (reach * u.sqrt(), TAU * v);
    (middle + distance * (angle.cos() * x + angle.sin() * y), along)
}
