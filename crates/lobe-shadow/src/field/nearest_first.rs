//! The entities that matter to each of sixteen receivers, nearest first.

use std::f32::consts::{PI, TAU};

use lobe_sh::simd::{Lanes, Wide, constant};
use pulp::{Arch, Simd, WithSimd};

use crate::field::placed::{Placed, Positions};

/// What is met on the way outwards from a receiver, in the order of its distance; of equally distant ones occluders come
/// first, in their order. The upper half has the bits of the square of its middle's distance, which as integers have the
/// order of the numbers; the lower half the number of an entity, or that of a lamp with [`LAMP`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Met(u64);

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
    fn new(square: f32, number: u32) -> Self {
        Self(u64::from(square.to_bits()) << 32 | u64::from(number))
    }

    pub(crate) fn lamp(number: usize, square: f32) -> Self {
        Self::new(square, number as u32 | LAMP)
    }

    #[inline]
    pub(crate) fn kind(self) -> MetKind {
        let number = self.0 as u32;
        if number < LAMP { MetKind::Occluder(number as usize) } else { MetKind::Lamp((number & !LAMP) as usize) }
    }
}

/// The size of what lies below the horizon.
const BELOW: f32 = -1.0;

/// How far entities are and how large they look, to sixteen receivers.
#[derive(Debug, Default)]
pub(crate) struct Sights {
    /// Squares of distances of the middles.
    squares: Vec<Lanes>,
    /// Largest solid angles: of the bounding sphere `2π (1 - √(1 - (R/r)²))`, and all of the sphere from within. [`BELOW`] for
    /// what lies below the horizon.
    sizes: Vec<Lanes>,
    /// Sizes, as bits that have their order, and entities that may be left out.
    small: Vec<Met>,
}

impl Sights {
    /// Looks at all entities. With normals, those whose bounding sphere lies below the horizon are marked.
    pub(crate) fn look(
        &mut self,
        arch: Arch,
        entities: &[Placed<'_>],
        positions: &Positions,
        normals: Option<&[Lanes; 3]>,
    ) {
        self.squares.resize(entities.len(), Lanes::ZERO);
        self.sizes.resize(entities.len(), Lanes::ZERO);
        arch.dispatch(Look { entities, positions, normals, squares: &mut self.squares, sizes: &mut self.sizes });
    }

    /// Adds the entities that matter to one receiver, in no order, and returns the sum of the largest solid angles of those
    /// left out: of those above the horizon, the smallest first, as many as have no more than `negligible` in all.
    pub(crate) fn add_occluders(&mut self, lane: usize, negligible: f32, met: &mut Vec<Met>) -> f32 {
        let Self { squares, sizes, small } = self;
        small.clear();
        let mut total = 0.0;
        for (k, (square, size)) in squares.iter().zip(&*sizes).enumerate() {
            let (square, size) = (square[lane], size[lane]);
            if size > negligible {
                met.push(Met::new(square, k as u32));
            } else if size >= 0.0 {
                total += size;
                small.push(Met::new(size, k as u32));
            }
        }
        if total <= negligible {
            return total;
        }
        small.sort_unstable();
        let mut left_out = 0.0;
        for this in &*small {
            let k = this.0 as u32;
            let with_this = left_out + sizes[k as usize][lane];
            if with_this > negligible {
                // The others are no smaller.
                met.push(Met::new(squares[k as usize][lane], k));
            } else {
                left_out = with_this;
            }
        }
        left_out
    }
}

/// To be compiled for the machine's registers.
struct Look<'a, 'f> {
    entities: &'a [Placed<'f>],
    positions: &'a Positions,
    normals: Option<&'a [Lanes; 3]>,
    squares: &'a mut [Lanes],
    sizes: &'a mut [Lanes],
}

impl WithSimd for Look<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let splat = |value| constant(simd, value);
        for (entity, (squares, sizes)) in self.entities.iter().zip(self.squares.iter_mut().zip(self.sizes)) {
            let [x, y, z] = &entity.towards(self.positions);
            let radius = splat(entity.radius() as f32);
            let within = radius * radius;
            for part in 0..Wide::<S>::PARTS {
                let [x, y, z] = [Wide::load(simd, x, part), Wide::load(simd, y, part), Wide::load(simd, z, part)];
                let square = x.times_plus(x, y.times_plus(y, z * z));
                square.store(squares, part);
                let ratio = (within * square.recip()).min(splat(1.0));
                let cap = splat(TAU) * ratio * (splat(1.0) + (splat(1.0) - ratio).sqrt()).recip();
                let size = within.if_less(square, cap, splat(4.0 * PI));
                let size = match self.normals {
                    None => size,
                    Some([nx, ny, nz]) => {
                        let (nx, ny) = (Wide::load(simd, nx, part), Wide::load(simd, ny, part));
                        let height = nx.times_plus(x, ny.times_plus(y, Wide::load(simd, nz, part) * z));
                        (splat(0.0) - radius).if_less(height, size, splat(BELOW))
                    }
                };
                size.store(sizes, part);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::field_grid::{FieldGrid, RadialInterpolation};
    use crate::field::occlusion_field::OcclusionField;
    use crate::placement::Placement;
    use lobe_sh::Rotation;
    use lobe_sh::simd::LANES;

    /// The largest solid angle of a ball at a distance, in closed form.
    fn solid_angle(radius: f64, distance: f64) -> f64 {
        2.0 * std::f64::consts::PI * (1.0 - (1.0 - (radius / distance).powi(2)).sqrt())
    }

    #[test]
    fn what_is_left_out_is_below_the_horizon_or_small_in_all() {
        let grid = FieldGrid::new([0.0; 3], 1.0, [0.5, 4.0], 2, 2).unwrap();
        let field = OcclusionField::new(grid, 1, vec![0.0; 2 * grid.points()]).unwrap();
        let heights = [3.0, -2.0, 40.0, 50.0, 60.0, -0.5];
        let entities: Vec<Placed<'_>> = heights
            .iter()
            .map(|z| {
                let placement = Placement::new([0.0, 0.0, *z], Rotation::IDENTITY, 1.0);
                Placed::new(&field, &placement, 1, RadialInterpolation::Linear)
            })
            .collect();
        let up = [Lanes::ZERO, Lanes::ZERO, Lanes::splat(1.0)];
        for arch in [Arch::new(), Arch::Scalar] {
            let ask = |normals, negligible| {
                let (mut sights, mut met) = (Sights::default(), Vec::new());
                sights.look(arch, &entities, &[[0.0; LANES]; 3], normals);
                let left_out = sights.add_occluders(5, negligible, &mut met);
                met.sort_unstable();
                let height = |m: &Met| match m.kind() {
                    MetKind::Occluder(k) => heights[k],
                    MetKind::Lamp(_) => f64::NAN,
                };
                (met.iter().map(height).collect::<Vec<f64>>(), left_out)
            };
            assert_eq!(ask(None, 0.0), (vec![-0.5, -2.0, 3.0, 40.0, 50.0, 60.0], 0.0), "all, nearest first");
            assert_eq!(ask(Some(&up), 0.0).0, [-0.5, 3.0, 40.0, 50.0, 60.0], "the horizon");
            let two = (solid_angle(1.0, 60.0) + solid_angle(1.0, 50.0)) as f32;
            let (found, left_out) = ask(None, two * 1.001);
            assert_eq!(found, [-0.5, -2.0, 3.0, 40.0], "the smallest two");
            assert!(left_out <= two * 1.001 && left_out > two * 0.999, "{left_out} of {two}");
            assert_eq!(ask(None, 1e9).0, [0.0; 0], "all are negligible to one who says so");
        }
    }
}
