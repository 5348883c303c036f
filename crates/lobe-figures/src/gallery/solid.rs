//! The shapes of the gallery: a sphere and a torus, intersected exactly.

use lobe_sh::Dir;

use crate::gallery::torus::Torus;
use lobe_sh::sphere::vector::{Vec3, add, dot, scale};

/// A shape about the origin, met by rays exactly: no triangles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ExhibitSolid {
    /// A ball.
    Ball {
        /// Its radius.
        radius: f64,
    },
    /// A torus.
    Torus(Torus),
}

impl ExhibitSolid {
    /// The distance at which the ray first meets the surface, beyond the distance `after`.
    #[must_use]
    pub fn hit(&self, origin: [f64; 3], towards: Dir, after: f64) -> Option<f64> {
        match self {
            Self::Ball { radius } => {
                let nearest = -dot(origin, towards.to_array());
                let o: Vec3 = add(origin, scale(towards.to_array(), nearest));
                let half = radius * radius - dot(o, o);
                let half = if half >= 0.0 { half.sqrt() } else { return None };
                [nearest - half, nearest + half].into_iter().find(|t| *t > after)
            }
            Self::Torus(torus) => {
                let (distances, count) = torus.crossings(origin, towards);
                distances[..count].iter().copied().find(|t| *t > after)
            }
        }
    }

    /// The outward normal at a point of the surface.
    #[must_use]
    pub fn normal(&self, point: [f64; 3]) -> Dir {
        match self {
            Self::Ball { .. } => Dir::new(point).unwrap_or(Dir::Z),
            Self::Torus(torus) => torus.normal(point),
        }
    }
}

#[cfg(test)]
mod tests {
    use lobe_testkit::directions;

    use super::*;

    #[test]
    fn the_ball_is_met_where_its_normal_faces_the_ray() {
        let ball = ExhibitSolid::Ball { radius: 0.8 };
        for s in directions() {
            let s = Dir::new(s).unwrap();
            let origin = scale(s.to_array(), 5.0);
            let t = ball.hit(origin, -s, 0.0).unwrap();
            assert!((t - 4.2).abs() < 1e-12, "from {s:?}: {t}");
            let from_inside = ball.hit([0.0; 3], s, 0.0).unwrap();
            assert!((from_inside - 0.8).abs() < 1e-12, "from the middle: {from_inside}");
            assert_eq!(ball.hit(origin, s, 0.0), None, "away from it");
            assert!(ball.normal(scale(s.to_array(), 0.8)).angle_to(s) < 1e-12, "normal at {s:?}");
        }
    }

    #[test]
    fn a_ray_through_the_hole_of_the_torus_misses_it() {
        let torus = ExhibitSolid::Torus(Torus { axis: Dir::Z, major: 0.7, minor: 0.3 });
        assert_eq!(torus.hit([0.1, 0.0, 5.0], -Dir::Z, 0.0), None, "down the hole");
        let t = torus.hit([0.7, 0.0, 5.0], -Dir::Z, 0.0).unwrap();
        assert!((t - 4.7).abs() < 1e-12, "onto the top of the tube: {t}");
    }
}
