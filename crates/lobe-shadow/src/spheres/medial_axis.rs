//! Sphere sets from the medial axis, to compare the variational ones with: a simplified form of the adaptive medial
//! axis of [Bradshaw and O'Sullivan 2004].
//!
//! Kept of it: candidates are balls of the medial axis, and *expand and select*: all of them are expanded by the same
//! length d, and then chosen greedily, always the one that contains most points that no chosen one does. The least d
//! for which n suffice is found by bisection. At last every ball shrinks to the points that are its own.
//!
//! Changed: medial balls are the largest ones inside that touch the surface at a sample, found by shrinking from
//! outside in [Ma, Bae and Choi 2012], instead of the Voronoi vertices of the samples; samples are not refined where
//! the fit is bad, as they are dense from the start; and no better variants are searched for by merging or bursting
//! single spheres.

use glam::DVec3;
use lobe_io::parallel;

use crate::spheres::ball::{Ball, reach};
use crate::spheres::cover_samples::CoverSamples;
use crate::spheres::solid::Solid;

/// Candidates at least, where the surface has that many points.
const LEAST_CANDIDATES: usize = 1000;

/// Candidates for each sphere.
const CANDIDATES: usize = 16;

/// Points of either kind that candidates are found and selected by at most; the sets of points in each of as many
/// candidates take 32 MiB.
const MOST_POINTS: usize = 1 << 14;

/// Halvings of the interval of d, which begins as wide as the solid.
const HALVINGS: usize = 14;

/// Shrinkings of a medial ball at most; most take less than ten.
const SHRINKINGS: usize = 64;

/// A ball is medial when no point is inside by more than this part of its radius.
const INSIDE: f64 = 1e-3;

/// At most `count` balls that contain all points; if they shrink, to those which are their own.
pub(crate) fn medial_balls(solid: &Solid, samples: &CoverSamples, count: usize, shrink: bool) -> Vec<Ball> {
    let candidates = candidates(solid, samples, count);
    let points = thinned_out(&samples.points);
    let [min, max] = solid.tree().bounds();
    let (mut least, mut most) = (0.0, (max - min).length());
    let mut best = selected(&candidates, &points, most, count).unwrap_or_default();
    for _ in 0..HALVINGS {
        let middle = 0.5 * (least + most);
        match selected(&candidates, &points, middle, count) {
            Some(found) => (best, most) = (found, middle),
            None => least = middle,
        }
    }
    fitted(solid, &best, &samples.points, shrink)
}

/// Points at equal steps through the list, so that there are not too many.
fn thinned_out<T: Copy>(all: &[T]) -> Vec<T> {
    all.iter().copied().step_by(all.len().div_ceil(MOST_POINTS).max(1)).collect()
}

/// Centers and radii of medial balls at points of the surface.
fn candidates(solid: &Solid, samples: &CoverSamples, count: usize) -> Vec<(DVec3, f64)> {
    let (surface, normals) = (thinned_out(&samples.points[samples.inner..]), thinned_out(&samples.normals));
    let wanted = (count * CANDIDATES).max(LEAST_CANDIDATES);
    let [min, max] = solid.tree().bounds();
    let places: Vec<usize> = (0..surface.len()).step_by((surface.len() / wanted).max(1)).collect();
    let width = (max - min).length();
    let ball = |k: usize| medial_ball(&surface, places[k], normals[places[k]], width);
    let all: Vec<(DVec3, f64)> = parallel::map(places.len(), &ball);
    // A ball that nothing limits is behind no surface: where the normals of faces cancel each other, or the mesh is open.
    let limited: Vec<(DVec3, f64)> = all.iter().copied().filter(|(_, radius)| *radius < width).collect();
    if limited.is_empty() { all } else { limited }
}

/// The largest ball about a center behind a point that touches the surface there and contains no other point.
fn medial_ball(surface: &[DVec3], at: usize, normal: DVec3, width: f64) -> (DVec3, f64) {
    let p = surface[at];
    let mut radius = width;
    for _ in 0..SHRINKINGS {
        let center = p - normal * radius;
        let square = |q: &&DVec3| q.distance_squared(center);
        let Some(&nearest) = surface.iter().min_by(|a, b| square(a).total_cmp(&square(b))) else { break };
        let behind = normal.dot(p - nearest);
        if nearest.distance(center) >= radius * (1.0 - INSIDE) || behind <= 0.0 {
            break;
        }
        // The ball through both points: |nearest - c| = r with c = p - r n.
        radius = p.distance_squared(nearest) / (2.0 * behind);
    }
    (p - normal * radius, radius)
}

/// The balls expanded by a length that greedy selection chooses, if at most `count` contain all points.
fn selected(candidates: &[(DVec3, f64)], points: &[DVec3], expansion: f64, count: usize) -> Option<Vec<(DVec3, f64)>> {
    let contained = |k: usize| {
        let (center, radius) = candidates[k];
        let square = (radius + expansion) * (radius + expansion);
        points.chunks(64).map(|points| bits(points, |p| p.distance_squared(center) <= square)).collect::<Vec<u64>>()
    };
    let contained: Vec<Vec<u64>> = parallel::map(candidates.len(), &contained);
    let mut left: Vec<u64> = points.chunks(64).map(|points| bits(points, |_| true)).collect();
    let new_points = |set: &[u64], left: &[u64]| set.iter().zip(left).map(|(a, b)| (a & b).count_ones()).sum::<u32>();
    // What a candidate adds only falls, so an old count is a bound, and most need not be counted again.
    let mut bounds: Vec<u32> = contained.iter().map(|set| new_points(set, &left)).collect();
    let mut chosen = Vec::new();
    while left.iter().any(|&word| word != 0) {
        if chosen.len() == count {
            return None;
        }
        let (mut best, mut most) = (0, 0);
        for (i, bound) in bounds.iter_mut().enumerate() {
            if *bound > most {
                *bound = new_points(&contained[i], &left);
                if *bound > most {
                    (best, most) = (i, *bound);
                }
            }
        }
        if most == 0 {
            return None;
        }
        left.iter_mut().zip(&contained[best]).for_each(|(left, set)| *left &= !set);
        chosen.push((candidates[best].0, candidates[best].1 + expansion));
    }
    Some(chosen)
}

fn bits(points: &[DVec3], is_set: impl Fn(DVec3) -> bool) -> u64 {
    points.iter().enumerate().map(|(i, &p)| u64::from(is_set(p)) << i).sum()
}

/// The balls, those that must larger, or all as small as can be, to contain the points that are deepest in them.
fn fitted(solid: &Solid, balls: &[(DVec3, f64)], points: &[DVec3], shrink: bool) -> Vec<Ball> {
    let mut groups = vec![Vec::new(); balls.len()];
    for &p in points {
        let gap = |k: &usize| p.distance(balls[*k].0) - balls[*k].1;
        if let Some(k) = (0..balls.len()).min_by(|a, b| gap(a).total_cmp(&gap(b))) {
            groups[k].push(p);
        }
    }
    parallel::map(balls.len(), &|k| {
        let (center, radius) = balls[k];
        let reach = reach(center, &groups[k]);
        Ball::new(solid, center, if shrink { reach } else { reach.max(radius) })
    })
}
