//! The entities that matter to a receiver, nearest first.

use std::f64::consts::{PI, TAU};

use crate::field::placed::Placed;

/// What is met on the way outwards from a receiver, in the order of its distance; of equally distant ones occluders come
/// first, in their order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Met {
    /// The bits of the square of its middle's distance, which as integers have the order of the numbers.
    square: u64,
    /// The number of an entity, or that of a lamp with [`LAMP`].
    number: u32,
}

/// The bit that tells lamps.
const LAMP: u32 = 1 << 31;

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum MetKind {
    /// The entity with this number.
    Occluder(usize),
    /// The lamp with this number.
    Lamp(usize),
}

impl Met {
    fn occluder(number: usize, towards: [f64; 3]) -> Self {
        Self { square: square(towards).to_bits(), number: number as u32 }
    }

    pub(crate) fn lamp(number: usize, towards: [f64; 3]) -> Self {
        Self { square: square(towards).to_bits(), number: number as u32 | LAMP }
    }

    pub(crate) fn kind(self) -> MetKind {
        if self.number < LAMP {
            MetKind::Occluder(self.number as usize)
        } else {
            MetKind::Lamp((self.number & !LAMP) as usize)
        }
    }
}

fn square(v: [f64; 3]) -> f64 {
    v[0] * v[0] + v[1] * v[1] + v[2] * v[2]
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
    sizes: &mut Vec<(u64, Met)>,
    met: &mut Vec<Met>,
) -> f64 {
    sizes.clear();
    for (k, entity) in entities.iter().enumerate() {
        let towards = entity.towards(point);
        if let Some(n) = normal
            && (0..3).map(|c| f64::from(n[c]) * towards[c]).sum::<f64>() <= -entity.radius()
        {
            continue;
        }
        let this = Met::occluder(k, towards);
        if negligible > 0.0 {
            let size = largest_solid_angle(entity.radius(), square(towards).sqrt());
            sizes.push((size.to_bits(), this));
        } else {
            met.push(this);
        }
    }
    // Bits of numbers that are not negative have their order.
    sizes.sort_unstable();
    let mut left_out = 0.0;
    let mut small = 0;
    for (size, _) in &*sizes {
        if left_out + f64::from_bits(*size) > negligible {
            break;
        }
        left_out += f64::from_bits(*size);
        small += 1;
    }
    met.extend(sizes[small..].iter().map(|(_, this)| this));
    left_out
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
            met.sort_unstable();
            let height = |m: &Met| match m.kind() {
                MetKind::Occluder(k) => heights[k],
                MetKind::Lamp(_) => f64::NAN,
            };
            (met.iter().map(height).collect::<Vec<f64>>(), left_out)
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
