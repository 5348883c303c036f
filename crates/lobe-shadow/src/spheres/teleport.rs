//! Teleportation: spheres move from where they gain little to where one more gains much.
//!
//! *Gain.* The points of a sphere are cut in two and each half gets a sphere of its own; what falls away of the
//! outside volume is the gain. *Cost.* A sphere is taken away by giving each of its points to the nearest other
//! sphere, which grows, or by one sphere around its points and those of a neighbor; what the outside volume grows by
//! is the cost. A sphere is taken away for another to be cut where the gain is larger than the cost and no sphere has
//! a part in both, so the energy falls by exactly their difference. [Cohen-Steiner, Alliez and Desbrun 2004]
//! introduced the step for clusters of triangles.

use std::collections::HashSet;

use glam::DVec3;
use lobe_io::parallel;

use crate::spheres::ball::{Ball, Search, enclosing_center, fitted};
use crate::spheres::solid::Solid;

/// The part of the spheres that is tried to be cut each round, one of this number: those with the most volume outside, and at
/// least [`LEAST`].
const CUT_ONE_OF: usize = 4;

/// The least number of spheres that are tried.
const LEAST: usize = 8;

/// Neighbors that a sphere is tried to be joined to.
const NEIGHBORS: usize = 3;

/// Steps of the clustering that cuts points in two.
const CUT_STEPS: usize = 4;

/// A gain must be larger than a cost by this part, so that rounding teleports nothing.
const MARGIN: f64 = 1.001;

/// A sphere cut in two.
struct Cut {
    sphere: usize,
    gain: f64,
    halves: [(Ball, Vec<DVec3>); 2],
}

/// A sphere taken away: what the spheres that take over its points become.
struct Removal {
    sphere: usize,
    cost: f64,
    grown: Vec<(usize, Ball)>,
}

/// Moves spheres. Every ball contains its group.
pub(crate) fn teleported(solid: &Solid, balls: Vec<Ball>, groups: Vec<Vec<DVec3>>) -> Vec<Ball> {
    let (mut balls, groups) = (balls, groups);
    if balls.len() < 3 {
        return balls;
    }
    let cuts = cuts(solid, &balls, &groups);
    let Some(most) = cuts.first().map(|cut| cut.gain) else { return balls };
    let removals = removals(solid, &balls, &groups, most);
    let mut touched = HashSet::new();
    let mut removals = removals.into_iter();
    for cut in cuts {
        if touched.contains(&cut.sphere) {
            continue;
        }
        let is_free = |r: &Removal| {
            r.sphere != cut.sphere
                && !touched.contains(&r.sphere)
                && r.grown.iter().all(|(k, _)| *k != cut.sphere && !touched.contains(k))
        };
        let Some(removal) = removals.find(is_free) else { break };
        if cut.gain <= removal.cost * MARGIN {
            break;
        }
        touched.extend([cut.sphere, removal.sphere]);
        let [(first, _), (second, _)] = cut.halves;
        (balls[cut.sphere], balls[removal.sphere]) = (first, second);
        for (k, ball) in removal.grown {
            touched.insert(k);
            balls[k] = ball;
        }
    }
    balls
}

/// Takes away the spheres that cost least, up to `count` of them; fewer where their neighbors are touched already.
pub(crate) fn thinned(solid: &Solid, balls: Vec<Ball>, groups: &[Vec<DVec3>], count: usize) -> Vec<Ball> {
    let (mut balls, mut touched, mut gone) = (balls, HashSet::new(), HashSet::new());
    for removal in removals(solid, &balls, groups, f64::INFINITY) {
        let is_free = !touched.contains(&removal.sphere) && removal.grown.iter().all(|(k, _)| !touched.contains(k));
        if gone.len() < count && is_free {
            gone.insert(removal.sphere);
            touched.insert(removal.sphere);
            for (k, ball) in removal.grown {
                touched.insert(k);
                balls[k] = ball;
            }
        }
    }
    (0..balls.len()).filter(|k| !gone.contains(k)).map(|k| balls[k]).collect()
}

/// The cuts that gain something, those that gain most first.
fn cuts(solid: &Solid, balls: &[Ball], groups: &[Vec<DVec3>]) -> Vec<Cut> {
    let mut order: Vec<usize> = (0..balls.len()).filter(|&k| groups[k].len() > 1 && balls[k].outside > 0.0).collect();
    order.sort_by(|&a, &b| balls[b].outside.total_cmp(&balls[a].outside));
    order.truncate((balls.len() / CUT_ONE_OF).max(LEAST));
    let cut = |k: usize| {
        let sphere = order[k];
        let halves = halves(&groups[sphere]).map(|half| (fitted(solid, &half, Search::ROUGH), half));
        let gain = balls[sphere].outside - halves[0].0.outside - halves[1].0.outside;
        Cut { sphere, gain, halves }
    };
    let mut cuts: Vec<Cut> = parallel::map(order.len(), &cut);
    cuts.retain(|cut| cut.gain > 0.0);
    cuts.sort_by(|a, b| b.gain.total_cmp(&a.gain).then(a.sphere.cmp(&b.sphere)));
    cuts
}

/// Points in two clusters, which start from two points far from each other.
fn halves(points: &[DVec3]) -> [Vec<DVec3>; 2] {
    let mean = |points: &[DVec3]| points.iter().sum::<DVec3>() / points.len().max(1) as f64;
    let farthest = |from: DVec3| {
        let farther = |a: &&DVec3, b: &&DVec3| a.distance_squared(from).total_cmp(&b.distance_squared(from));
        points.iter().max_by(farther).copied().unwrap_or(from)
    };
    let first = farthest(mean(points));
    let mut centers = [first, farthest(first)];
    let mut halves = [Vec::new(), Vec::new()];
    for _ in 0..CUT_STEPS {
        let [a, b] = centers;
        let (near_a, near_b) = points.iter().copied().partition(|p| p.distance_squared(a) <= p.distance_squared(b));
        halves = [near_a, near_b];
        if !halves.iter().any(Vec::is_empty) {
            centers = [mean(&halves[0]), mean(&halves[1])];
        }
    }
    halves
}

/// The removals that cost less than `most`, those that cost least first. Balls around the points of two spheres are
/// fitted only where they are cheapest before.
fn removals(solid: &Solid, balls: &[Ball], groups: &[Vec<DVec3>], most: f64) -> Vec<Removal> {
    let cheapest = |sphere: usize| {
        let joined =
            neighbors(balls, sphere).into_iter().map(|other| joined(solid, balls, groups, sphere, other, None));
        joined.fold(spread(solid, balls, groups, sphere), |best, next| if next.cost < best.cost { next } else { best })
    };
    let mut removals: Vec<Removal> = parallel::map(balls.len(), &cheapest);
    removals.sort_by(|a, b| a.cost.total_cmp(&b.cost).then(a.sphere.cmp(&b.sphere)));
    let count = (balls.len() / CUT_ONE_OF).max(LEAST).min(balls.len());
    parallel::rows(&mut removals[..count], 1, &|_, one| {
        let removal = &mut one[0];
        if let [(other, _)] = removal.grown[..] {
            let fitted = joined(solid, balls, groups, removal.sphere, other, Some(Search::ROUGH));
            if fitted.cost < removal.cost {
                *removal = fitted;
            }
        }
    });
    removals.retain(|removal| removal.cost < most);
    removals.sort_by(|a, b| a.cost.total_cmp(&b.cost).then(a.sphere.cmp(&b.sphere)));
    removals
}

/// Gives every point of a sphere to the nearest other.
fn spread(solid: &Solid, balls: &[Ball], groups: &[Vec<DVec3>], sphere: usize) -> Removal {
    let mut radii: Vec<f64> = balls.iter().map(|ball| ball.radius).collect();
    for &p in &groups[sphere] {
        let others = (0..balls.len()).filter(|&k| k != sphere);
        let gap = |k: usize| balls[k].center.distance(p) - radii[k];
        if let Some((nearest, gap)) = others.map(|k| (k, gap(k))).min_by(|a, b| a.1.total_cmp(&b.1)) {
            radii[nearest] += gap.max(0.0);
        }
    }
    let grown: Vec<(usize, Ball)> = (0..balls.len())
        .filter(|&k| radii[k] > balls[k].radius)
        .map(|k| (k, Ball::new(solid, balls[k].center, radii[k])))
        .collect();
    let cost = grown.iter().map(|(k, ball)| ball.outside - balls[*k].outside).sum::<f64>() - balls[sphere].outside;
    Removal { sphere, cost, grown }
}

/// The spheres with the smallest balls around them and a sphere.
fn neighbors(balls: &[Ball], sphere: usize) -> Vec<usize> {
    let width = |k: usize| balls[k].center.distance(balls[sphere].center) + balls[k].radius;
    let mut others: Vec<usize> = (0..balls.len()).filter(|&k| k != sphere).collect();
    others.sort_by(|&a, &b| width(a).total_cmp(&width(b)));
    others.truncate(NEIGHBORS);
    others
}

/// Gives all points of a sphere to another, around whose and its points a ball is put.
fn joined(
    solid: &Solid,
    balls: &[Ball],
    groups: &[Vec<DVec3>],
    sphere: usize,
    other: usize,
    search: Option<Search>,
) -> Removal {
    let points = [groups[sphere].as_slice(), &groups[other]].concat();
    let ball = match search {
        Some(search) => fitted(solid, &points, search),
        None => Ball::around(solid, enclosing_center(&points), &points),
    };
    let cost = ball.outside - balls[sphere].outside - balls[other].outside;
    Removal { sphere, cost, grown: vec![(other, ball)] }
}
