//! One sphere of a set: the ball around given points that has the least volume outside a solid.
//!
//! A larger ball around the same center has no less volume outside, so the best ball of a center c reaches to the
//! farthest of its points, and what is left is to minimize over three numbers
//!
//! ```text
//!   f(c) = SOTV(c, R(c)),   R(c) = max_i |p_i - c|
//! ```
//!
//! The derivatives of SOTV are known wherever it is (see [`Solid`]), but R has ridges where two points are equally
//! far, and the best center is mostly on one. So the search is a trust-region method for such compositions: from a
//! center c it minimizes the model
//!
//! ```text
//!   m(δ) = ∂SOTV/∂c · δ + ∂SOTV/∂R R(c + δ)      for |δ| ≤ Δ
//! ```
//!
//! which is convex, keeps the ridges and needs distances alone; goes there if f falls, and doubles or shrinks Δ by how
//! well the model foretold it. The minimum of the model is found by the simplex method of [Nelder and Mead 1965].
//! [Wang et al. 2006] minimize f by Powell's method, without derivatives.

use glam::DVec3;

use crate::spheres::solid::Solid;

/// A ball and its volume outside the solid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ball {
    pub(crate) center: DVec3,
    pub(crate) radius: f64,
    pub(crate) outside: f64,
}

impl Ball {
    pub(crate) const NONE: Self = Self { center: DVec3::ZERO, radius: 0.0, outside: 0.0 };

    /// The ball about a center that reaches to the farthest of some points.
    pub(crate) fn around(solid: &Solid, center: DVec3, points: &[DVec3]) -> Self {
        Self::new(solid, center, reach(center, points))
    }

    pub(crate) fn new(solid: &Solid, center: DVec3, radius: f64) -> Self {
        Self { center, radius, outside: solid.outside(center, radius) }
    }
}

/// The distance to the farthest of some points.
pub(crate) fn reach(center: DVec3, points: &[DVec3]) -> f64 {
    points.iter().map(|p| p.distance_squared(center)).fold(0.0, f64::max).sqrt()
}

/// How carefully a center is searched for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Search {
    /// The first Δ over the radius.
    pub(crate) step: f64,
    /// Evaluations of f at most.
    pub(crate) evaluations: usize,
    /// The search ends when Δ is smaller than this part of the radius.
    pub(crate) size: f64,
}

impl Search {
    /// For balls whose points will change again.
    pub(crate) const ROUGH: Self = Self { step: 0.15, evaluations: 12, size: 0.01 };
    /// For the last changes of a set.
    pub(crate) const FINE: Self = Self { step: 0.1, evaluations: 30, size: 0.001 };
}

/// The model is trusted farther where f falls by more than this part of what it foretold, and less where by less than
/// the second; the customary values.
const TRUSTED: [f64; 2] = [0.7, 0.1];

/// A foretold fall of less than this part of the volume outside is not worth an evaluation.
const WORTH: f64 = 1e-4;

/// A ball around the points with less volume outside than `start`, or `start`, which contains them.
pub(crate) fn improved(solid: &Solid, points: &[DVec3], start: Ball, search: Search) -> Ball {
    match points {
        [] => Ball { center: start.center, ..Ball::NONE },
        [point] => Ball { center: *point, ..Ball::NONE },
        _ => {
            let found = descended(solid, points, start, search);
            if found.outside < start.outside { found } else { start }
        }
    }
}

/// The trust-region search from the center of a ball.
fn descended(solid: &Solid, points: &[DVec3], start: Ball, search: Search) -> Ball {
    let evaluated = |center: DVec3| {
        let radius = reach(center, points);
        let (outside, by_center, by_radius) = solid.outside_and_slope(center, radius);
        (Ball { center, radius, outside }, by_center, by_radius)
    };
    let (mut best, mut by_center, mut by_radius) = evaluated(start.center);
    let mut trust = search.step * best.radius;
    for _ in 1..search.evaluations {
        // Nearer points are not the farthest from any center within the trust region.
        let far = (best.radius - 2.0 * trust).max(0.0).powi(2);
        let farthest: Vec<DVec3> = points.iter().copied().filter(|p| p.distance_squared(best.center) >= far).collect();
        let model =
            |step: DVec3| by_center.dot(step) + by_radius * (reach(best.center + step, &farthest) - best.radius);
        let (step, fall) =
            nelder_mead(|step| if step.length() <= trust { model(step) } else { f64::INFINITY }, 0.5 * trust);
        if -fall > WORTH * best.outside {
            let next = evaluated(best.center + step);
            let ratio = (best.outside - next.0.outside) / -fall;
            if ratio > 0.0 {
                (best, by_center, by_radius) = next;
            }
            trust *= if ratio > TRUSTED[0] {
                2.0
            } else if ratio < TRUSTED[1] {
                0.3
            } else {
                1.0
            };
        } else {
            trust *= 0.3;
        }
        if trust < search.size * best.radius {
            break;
        }
    }
    best
}

/// The ball of any center around the points, from about the middle of them.
pub(crate) fn fitted(solid: &Solid, points: &[DVec3], search: Search) -> Ball {
    let start = enclosing_center(points);
    improved(solid, points, Ball::around(solid, start, points), search)
}

/// About the center of the smallest ball around points: steps towards the farthest, ever shorter (Bădoiu and Clarkson
/// 2003).
pub(crate) fn enclosing_center(points: &[DVec3]) -> DVec3 {
    /// The radius is within 1/√32 of the smallest, which is enough to start from.
    const STEPS: usize = 32;
    let Some(&first) = points.first() else { return DVec3::ZERO };
    (1..=STEPS).fold(first, |center, step| {
        let farther = |a: &&DVec3, b: &&DVec3| a.distance_squared(center).total_cmp(&b.distance_squared(center));
        let farthest = points.iter().max_by(farther).copied().unwrap_or(center);
        center + (farthest - center) / (step + 1) as f64
    })
}

/// Evaluations of the model at most.
const MODEL_EVALUATIONS: usize = 90;

/// The place of the least value found from 0 on, where the function is 0, by steps that begin with `step`; and that
/// value.
fn nelder_mead(at: impl Fn(DVec3) -> f64, step: f64) -> (DVec3, f64) {
    let vertex = |place: DVec3| (place, at(place));
    let mut simplex = [(DVec3::ZERO, 0.0), vertex(DVec3::X * step), vertex(DVec3::Y * step), vertex(DVec3::Z * step)];
    let mut evaluations = 3;
    while evaluations < MODEL_EVALUATIONS {
        simplex.sort_by(|a, b| a.1.total_cmp(&b.1));
        let [best, second, third, worst] = simplex;
        let middle = (best.0 + second.0 + third.0) / 3.0;
        let along = |factor: f64| vertex(middle + (middle - worst.0) * factor);
        let reflected = along(1.0);
        evaluations += 2;
        let next = if reflected.1 < best.1 {
            let expanded = along(2.0);
            Some(if expanded.1 < reflected.1 { expanded } else { reflected })
        } else if reflected.1 < third.1 {
            Some(reflected)
        } else {
            let contracted = along(if reflected.1 < worst.1 { 0.5 } else { -0.5 });
            (contracted.1 < reflected.1.min(worst.1)).then_some(contracted)
        };
        match next {
            Some(next) => simplex[3] = next,
            None => {
                for other in &mut simplex[1..] {
                    *other = vertex(best.0.midpoint(other.0));
                }
                evaluations += 3;
            }
        }
    }
    simplex.into_iter().fold((DVec3::ZERO, 0.0), |best, next| if next.1 < best.1 { next } else { best })
}
