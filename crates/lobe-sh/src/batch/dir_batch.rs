//! Many directions, sixteen side by side.

use alloc::vec::Vec;

use crate::simd::{LANES, Lanes};
use crate::sphere::Dir;

/// Directions in blocks of sixteen: of each block the x, then the y, then the z components. Places of the last block that
/// no direction takes hold +z.
///
/// ```
/// use lobe_sh::Dir;
/// use lobe_sh::batch::DirBatch;
///
/// let directions: DirBatch = [Dir::X, Dir::Y].into_iter().collect();
/// assert_eq!((directions.len(), directions.get(1)), (2, [0.0, 1.0, 0.0]));
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DirBatch {
    count: usize,
    blocks: Vec<[Lanes; 3]>,
}

/// +z in every lane.
const UP: [Lanes; 3] = [Lanes([0.0; LANES]), Lanes([0.0; LANES]), Lanes([1.0; LANES])];

impl DirBatch {
    /// Of unit vectors, given component by component.
    ///
    /// # Panics
    /// If the components differ in length.
    #[must_use]
    pub fn from_components([x, y, z]: [&[f32]; 3]) -> Self {
        let count = x.len();
        assert!(y.len() == count && z.len() == count, "components differ in length");
        let mut batch = Self { count, blocks: vec![UP; count.div_ceil(LANES)] };
        for (k, block) in batch.blocks.iter_mut().enumerate() {
            for (lanes, component) in block.iter_mut().zip([x, y, z]) {
                let values = &component[k * LANES..count.min((k + 1) * LANES)];
                lanes.0[..values.len()].copy_from_slice(values);
            }
        }
        batch
    }

    /// The number of directions.
    #[must_use]
    pub fn len(&self) -> usize {
        self.count
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Direction `k`.
    ///
    /// # Panics
    /// If `k >= len()`.
    #[must_use]
    pub fn get(&self, k: usize) -> [f32; 3] {
        assert!(k < self.count, "no direction {k} of {}", self.count);
        self.blocks[k / LANES].map(|component| component.0[k % LANES])
    }

    /// The blocks.
    #[must_use]
    pub fn blocks(&self) -> &[[Lanes; 3]] {
        &self.blocks
    }
}

impl FromIterator<Dir> for DirBatch {
    fn from_iter<I: IntoIterator<Item = Dir>>(directions: I) -> Self {
        let mut batch = Self::default();
        for s in directions {
            let lane = batch.count % LANES;
            if lane == 0 {
                batch.blocks.push(UP);
            }
            if let Some(block) = batch.blocks.last_mut() {
                for (component, value) in block.iter_mut().zip(s.to_array()) {
                    component.0[lane] = value as f32;
                }
            }
            batch.count += 1;
        }
        batch
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn components_and_directions_give_one_batch() {
        let all: Vec<Dir> = lobe_testkit::directions().into_iter().map(Dir::from_unit).collect();
        for count in [0, 1, 15, 16, 17] {
            let batch: DirBatch = all[..count].iter().copied().collect();
            let component = |k: usize| all[..count].iter().map(|s| s.to_array()[k] as f32).collect::<Vec<f32>>();
            let again = DirBatch::from_components([&component(0), &component(1), &component(2)]);
            assert_eq!(batch, again, "{count} directions");
            assert_eq!((batch.len(), batch.is_empty()), (count, count == 0), "{count} directions");
            for (k, s) in all[..count].iter().enumerate() {
                assert_eq!(batch.get(k), s.to_array().map(|c| c as f32), "direction {k} of {count}");
            }
        }
    }
}
