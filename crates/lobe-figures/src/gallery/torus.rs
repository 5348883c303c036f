//! The intersection of a ray with a torus.

use lobe_sh::Dir;

use crate::gallery::roots::{Roots, roots_between};
use lobe_sh::sphere::vector::{Vec3, add, dot, normalized, scale, sub};

/// A torus about the origin: a tube of radius `minor` around a circle of radius `major`, perpendicular to `axis`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Torus {
    /// The axis of symmetry.
    pub axis: Dir,
    /// The radius of the circle in the middle of the tube.
    pub major: f64,
    /// The radius of the tube, positive and below `major`.
    pub minor: f64,
}

// With the axis a, the radii R and r, the surface is (|p|² + R² - r²)² = 4 R² (|p|² - (p·a)²). Counted from the point o
// of the ray nearest to the center, p = o + t d has |p|² = e + t² with e = |o|², and no third power is left:
//
//     t⁴ + (2k - 4R²(1 - δ²)) t² + 8 R² η δ t + k² - 4R²(e - η²) = 0        k = e + R² - r²   η = o·a   δ = d·a
//
// So the coefficients are as small as the torus, however far away the ray starts.

impl Torus {
    /// The distances along the ray at which it crosses the surface, up to four in rising order, negative ones too.
    ///
    /// Every crossing lies on the surface to 1e-12 of the size, tangential ones included (test
    /// `crossings_lie_on_the_torus`); a ray that touches it may have none.
    pub(crate) fn crossings(&self, origin: Vec3, towards: Dir) -> ([f64; 4], usize) {
        // Count from the point of the ray nearest to the center.
        let (d, a) = (towards.to_array(), self.axis.to_array());
        let nearest = -dot(origin, d);
        let o = add(origin, scale(d, nearest));
        let (e, eta, delta) = (dot(o, o), dot(o, a), dot(d, a));
        // Leave out rays that miss the bounding sphere.
        let outer = self.major + self.minor;
        let reach = outer * outer - e;
        if reach <= 0.0 {
            return ([0.0; 4], 0);
        }
        // Set up the quartic, and find its roots within the bounding sphere.
        let (square, k) = (4.0 * self.major * self.major, e + (self.major + self.minor) * (self.major - self.minor));
        let quartic = [
            k * k - square * (e - eta * eta),
            2.0 * square * eta * delta,
            2.0 * k - square * (1.0 - delta * delta),
            0.0,
            1.0,
        ];
        let roots: Roots = roots_between(&quartic, -reach.sqrt(), reach.sqrt());
        // Count from the origin of the ray again.
        let mut distances = [0.0; 4];
        for (distance, root) in distances.iter_mut().zip(roots.as_slice()) {
            *distance = nearest + root;
        }
        (distances, roots.as_slice().len())
    }

    /// The outward normal at a point of the surface; the axis, if the point is on it.
    pub(crate) fn normal(&self, p: Vec3) -> Dir {
        Dir::new(sub(p, self.nearest_on_circle(p))).unwrap_or(self.axis)
    }

    /// The point of the circle in the middle of the tube that is nearest to `p`.
    fn nearest_on_circle(&self, p: Vec3) -> Vec3 {
        let a = self.axis.to_array();
        scale(normalized(sub(p, scale(a, dot(p, a)))), self.major)
    }
}

#[cfg(test)]
mod tests {
    use lobe_testkit::Random;

    use super::*;

    fn torus() -> Torus {
        Torus { axis: Dir::new([0.3, -0.4, 0.8]).unwrap(), major: 0.7, minor: 0.3 }
    }

    /// The distance of a point outside the tube.
    fn outside(torus: &Torus, p: Vec3) -> f64 {
        let from = sub(p, torus.nearest_on_circle(p));
        dot(from, from).sqrt() - torus.minor
    }

    #[test]
    fn crossings_lie_on_the_torus() {
        let (torus, mut random) = (torus(), Random::new(8));
        let (mut crossed, mut four) = (0, 0);
        for _ in 0..5000 {
            // From a point far away past a point near the torus.
            let origin = scale(random.direction(), 10.0 + 90.0 * random.unit());
            let aim = [0; 3].map(|_| random.signed());
            let towards = Dir::new(sub(aim, origin)).unwrap();
            let (distances, count) = torus.crossings(origin, towards);
            for t in &distances[..count] {
                let p = add(origin, scale(towards.to_array(), *t));
                // 100 radii away the point itself is rounded to 1e-14.
                assert!(outside(&torus, p).abs() < 1e-12, "{p:?} lies {} outside", outside(&torus, p));
            }
            assert_eq!(count % 2, 0, "a ray from outside goes in as often as out: {distances:?}");
            crossed += usize::from(count > 0);
            four += usize::from(count == 4);
        }
        assert!(crossed > 2000 && four > 100, "{crossed} rays crossed it, {four} of them twice");
    }

    #[test]
    fn no_crossing_is_missed_where_marching_finds_one() {
        let (torus, mut random) = (torus(), Random::new(9));
        for _ in 0..300 {
            let origin = scale(random.direction(), 3.0);
            let towards = Dir::new(sub([0; 3].map(|_| random.signed()), origin)).unwrap();
            let at = |t: f64| outside(&torus, add(origin, scale(towards.to_array(), t)));
            let steps: Vec<f64> = (0..4000).map(|k| at(1.5e-3 * f64::from(k))).collect();
            let marched = steps.windows(2).filter(|w| (w[0] < 0.0) != (w[1] < 0.0)).count();
            let (distances, count) = torus.crossings(origin, towards);
            assert!(count >= marched, "{count} crossings, but marching finds {marched}: {distances:?}");
        }
    }

    #[test]
    fn the_normal_is_the_gradient_of_the_distance() {
        let (torus, mut random) = (torus(), Random::new(10));
        for _ in 0..200 {
            let p = scale(random.direction(), 0.8);
            let n = torus.normal(p).to_array();
            let slope: Vec3 = std::array::from_fn(|k| {
                let shifted = |h: f64| outside(&torus, std::array::from_fn(|i| p[i] + if i == k { h } else { 0.0 }));
                (shifted(1e-6) - shifted(-1e-6)) / 2e-6
            });
            let off = sub(n, slope);
            assert!(dot(off, off).sqrt() < 1e-8, "at {p:?}: normal {n:?}, gradient {slope:?}");
        }
    }
}
