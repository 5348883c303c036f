//! The entities that matter to a receiver, nearest first.

use std::f64::consts::{PI, TAU};

use crate::field::placed::Placed;

/// What is met on the way outwards from a receiver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Met {
    pub(crate) distance: f64,
    pub(crate) kind: MetKind,
    /// The middle, from the receiver.
    pub(crate) towards: [f64; 3],
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum MetKind {
    /// The entity with this number.
    Occluder(usize),
    /// The lamp with this number.
    Lamp(usize),
}

/// The largest solid angle of an entity of this bounding radius at a distance: that of its bounding sphere, `2π (1 - √(1 -
/// (R/r)²))`, and all of the sphere from within.
pub(crate) fn largest_solid_angle(radius: f64, distance: f64) -> f64 {
    if distance <= radius {
        return 4.0 * PI;
    }
    let square = (radius / distance).powi(2);
    TAU * square / (1.0 + (1.0 - square).sqrt())
}

/// Adds the entities that matter at `point`, and returns the sum of the largest solid angles of those left out.
///
/// Left out are those whose bounding sphere lies below the horizon of `normal`, where the cosine is 0, so that they change
/// nothing; and, the smallest solid angles first, as many of the others as have no more than `negligible` in all.
pub(crate) fn add_occluders(
    entities: &[Placed<'_>],
    point: [f32; 3],
    normal: Option<[f32; 3]>,
    negligible: f64,
    sizes: &mut Vec<(f64, usize)>,
    met: &mut Vec<Met>,
) -> f64 {
    sizes.clear();
    let first = met.len();
    for (k, entity) in entities.iter().enumerate() {
        let towards = entity.towards(point);
        if let Some(n) = normal
            && (0..3).map(|c| f64::from(n[c]) * towards[c]).sum::<f64>() <= -entity.radius()
        {
            continue;
        }
        let distance = towards.iter().map(|c| c * c).sum::<f64>().sqrt();
        sizes.push((largest_solid_angle(entity.radius(), distance), met.len()));
        met.push(Met { distance, kind: MetKind::Occluder(k), towards });
    }
    let mut left_out = 0.0;
    if negligible > 0.0 {
        sizes.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        for (size, at) in &*sizes {
            if left_out + size > negligible {
                break;
            }
            left_out += size;
            met[*at].distance = f64::INFINITY;
        }
        if left_out > 0.0 {
            let mut at = 0;
            met.retain(|m| {
                at += 1;
                at <= first || m.distance.is_finite()
            });
        }
    }
    left_out
}

/// Sorts by distance; of equal ones occluders come first, in their order.
pub(crate) fn sort(met: &mut [Met]) {
    let key = |m: &Met| match m.kind {
        MetKind::Occluder(k) => (0, k),
        MetKind::Lamp(k) => (1, k),
    };
    met.sort_unstable_by(|a, b| a.distance.total_cmp(&b.distance).then(key(a).cmp(&key(b))));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{FieldGrid, OcclusionField, Placement};
    use lobe_sh::Rotation;

    #[test]
    fn what_is_left_out_is_below_the_horizon_or_small_in_all() {
        let grid = FieldGrid::new([0.0; 3], 1.0, [0.5, 4.0], 2, 2).unwrap();
        let field = OcclusionField::new(grid, 1, vec![0.0; 2 * grid.points()]).unwrap();
        let heights = [3.0, -2.0, 40.0, 50.0, 60.0, -0.5];
        let entities: Vec<Placed<'_>> = heights
            .iter()
            .map(|z| Placed::new(&field, &Placement::new([0.0, 0.0, *z], Rotation::IDENTITY, 1.0), 1, 0))
            .collect();
        let ask = |normal, negligible| {
            let mut met = Vec::new();
            let left_out = add_occluders(&entities, [0.0; 3], normal, negligible, &mut Vec::new(), &mut met);
            sort(&mut met);
            (met.iter().map(|m| m.towards[2]).collect::<Vec<f64>>(), left_out)
        };
        assert_eq!(ask(None, 0.0), (vec![-0.5, -2.0, 3.0, 40.0, 50.0, 60.0], 0.0), "all, nearest first");
        assert_eq!(ask(Some([0.0, 0.0, 1.0]), 0.0).0, [-0.5, 3.0, 40.0, 50.0, 60.0], "the horizon");
        let two = largest_solid_angle(1.0, 60.0) + largest_solid_angle(1.0, 50.0);
        let (found, left_out) = ask(None, two * 1.001);
        assert_eq!(found, [-0.5, -2.0, 3.0, 40.0], "the smallest two");
        assert!(left_out <= two * 1.001, "{left_out}");
        assert_eq!(ask(None, 1e9).0, [0.0; 0], "all are negligible to one who says so");
    }

    #[test]
    fn the_solid_angle_of_a_far_ball_is_that_of_its_disc() {
        let far = largest_solid_angle(1.0, 1e6) / (PI * 1e-12);
        assert!((far - 1.0).abs() < 1e-9, "{far}");
        assert_eq!(largest_solid_angle(1.0, 1.0), 4.0 * PI, "on the bounding sphere");
    }
}
