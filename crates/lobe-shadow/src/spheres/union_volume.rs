//! The volume of a union of spheres.

use crate::spheres::sphere_set::SphereSet;

/// Columns along each side of the box of the spheres: a ball that fills it is right to a part in 10⁵.
const COLUMNS: usize = 512;

impl SphereSet {
    /// The volume of the union of the spheres, which counts what several of them cover once.
    ///
    /// Each of 512² columns through the box of the spheres is covered between the ends of intervals, which are exact
    /// (`the_union_of_balls_has_their_closed_form`).
    #[must_use]
    pub fn union_volume(&self) -> f64 {
        let balls: Vec<([f64; 3], f64)> =
            (0..self.len()).map(|k| (self.center(k), f64::from(self.radii()[k]))).collect();
        let bound = |axis: usize, sign: f64| {
            let ends = balls.iter().map(|(center, radius)| sign * center[axis] + radius);
            sign * ends.fold(f64::NEG_INFINITY, f64::max)
        };
        let [low, high] = [-1.0, 1.0].map(|sign| [bound(0, sign), bound(1, sign)]);
        let step = [0, 1].map(|axis| (high[axis] - low[axis]) / COLUMNS as f64);
        let mut column = Vec::new();
        let mut covered = 0.0;
        for i in 0..COLUMNS {
            let x = low[0] + (i as f64 + 0.5) * step[0];
            // What is left of the squares of the radii in this row of columns.
            let rest = |(center, radius): &([f64; 3], f64)| (*center, radius * radius - (x - center[0]).powi(2));
            let row: Vec<([f64; 3], f64)> = balls.iter().map(rest).filter(|(_, rest)| *rest > 0.0).collect();
            for j in 0..COLUMNS {
                let y = low[1] + (j as f64 + 0.5) * step[1];
                column.clear();
                for (center, rest) in &row {
                    let square = rest - (y - center[1]).powi(2);
                    if square > 0.0 {
                        column.push([center[2] - square.sqrt(), center[2] + square.sqrt()]);
                    }
                }
                covered += length_of_union(&mut column);
            }
        }
        covered * step[0] * step[1]
    }
}

/// The length that intervals cover together.
fn length_of_union(intervals: &mut [[f64; 2]]) -> f64 {
    intervals.sort_unstable_by(|a, b| a[0].total_cmp(&b[0]));
    let (mut sum, mut end) = (0.0, f64::NEG_INFINITY);
    for [from, to] in intervals {
        sum += (*to - from.max(end)).max(0.0);
        end = end.max(*to);
    }
    sum
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    fn volume(balls: &[([f32; 3], f32)]) -> f64 {
        let (centers, radii) = balls.iter().copied().unzip();
        SphereSet::new(centers, radii).unwrap().union_volume()
    }

    #[test]
    fn the_union_of_balls_has_their_closed_form() {
        let ball = |r: f64| 4.0 / 3.0 * PI * r.powi(3);
        // Two balls of radius 1 whose middles are 1 apart share two caps of height ½.
        let caps = 2.0 * PI * 0.25 * (1.0 - 0.5 / 3.0);
        for (name, balls, expected) in [
            ("one", vec![([1.0, 2.0, 3.0], 0.5)], ball(0.5)),
            ("apart", vec![([0.0; 3], 1.0), ([3.0, 0.0, 1.0], 0.75)], ball(1.0) + ball(0.75)),
            ("the same twice", vec![([0.0; 3], 2.0), ([0.0; 3], 2.0)], ball(2.0)),
            ("one in another", vec![([0.0; 3], 2.0), ([0.5, 0.0, -0.5], 0.5)], ball(2.0)),
            ("along x", vec![([0.0; 3], 1.0), ([1.0, 0.0, 0.0], 1.0)], 2.0 * ball(1.0) - caps),
            ("along z", vec![([0.0; 3], 1.0), ([0.0, 0.0, 1.0], 1.0)], 2.0 * ball(1.0) - caps),
        ] {
            let found = volume(&balls);
            assert!((found / expected - 1.0).abs() < 1e-4, "{name}: {found}, expected {expected}");
        }
    }
}
