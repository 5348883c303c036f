//! The cost of a job: its arithmetic and its bytes, and the floor that follows from them.

use lobe::sh::product::GauntTensor;

use crate::floors::Floors;

/// Where the bytes of a job lie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Level {
    /// Written to the cache that holds all items.
    WrittenToCache,
    /// Read from and written to the cache that holds all items.
    Cache,
    /// Written to memory.
    Written,
    /// Read from memory.
    Read,
}

const FIRST_LEVEL: &str = "first-level cache";
const SECOND_LEVEL: &str = "second-level cache";

/// What one item needs.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cost {
    /// Operations; a multiplication and the addition that follows it are two.
    pub(crate) operations: f64,
    /// Bytes at a level.
    pub(crate) bytes: f64,
    pub(crate) level: Level,
}

impl Cost {
    /// The nanoseconds of one of some items, the larger of the time for its arithmetic and that for its bytes, and
    /// which of them it is. The cache is of the first level where that holds the bytes of all items, else of the
    /// second.
    pub(crate) fn floor(&self, items: usize, floors: &Floors) -> (f64, &'static str) {
        let is_first = self.bytes * items as f64 <= floors.first_level as f64;
        let (rate, name) = match (self.level, is_first) {
            (Level::WrittenToCache, true) => (floors.store_first_level, FIRST_LEVEL),
            (Level::WrittenToCache, false) => (floors.store_second_level, SECOND_LEVEL),
            (Level::Cache, true) => (floors.copy_first_level, FIRST_LEVEL),
            (Level::Cache, false) => (floors.copy_second_level, SECOND_LEVEL),
            (Level::Written, _) => (floors.store.max(floors.store_past_caches), "memory, written"),
            (Level::Read, _) => (floors.read, "memory, read"),
        };
        let (arithmetic, bytes) = (self.operations / floors.gflops, self.bytes / rate);
        if arithmetic > bytes { (arithmetic, "arithmetic") } else { (bytes, name) }
    }
}

/// Operations of the basis of order n in one direction: two for each step of the recurrences in the band, one for each factor
/// in x and y.
pub(crate) fn basis_operations(order: usize) -> f64 {
    let n = order as f64;
    n * (n + 1.0) + n * n + 4.0 * (n - 1.0)
}

/// Operations of the product of two functions over the entries of the tensor of Gaunt coefficients, without common factors taken out.
pub(crate) fn product_operations(order: usize) -> f64 {
    let (entries, pairs, squares) = entries(order);
    // a_i b_j + a_j b_i for each pair, a multiply-add for each entry.
    (2 * entries + 3 * (pairs - squares) + squares) as f64
}

/// The same for a square.
pub(crate) fn square_operations(order: usize) -> f64 {
    let (entries, pairs, _) = entries(order);
    (2 * entries + pairs) as f64
}

/// Operations of the product of a zonal function about +z with another: `M^μ_ll' = Σ_k z_k Γ(k0, lμ, l'μ)` for `l ≥ l'`, `μ ≥ 0`, and that
/// matrix times the coefficients of both signs of m.
pub(crate) fn zonal_product_operations(order: usize) -> f64 {
    let tensor = GauntTensor::new(order, order, order);
    let is_zonal = |i: usize| (0..order).any(|l| i == l * (l + 1));
    let is_above = |j: usize| (0..order).any(|l| (l * (l + 1)..(l + 1) * (l + 1)).contains(&j));
    let entries = tensor.coefficients().iter().filter(|t| is_zonal(t.i) && t.j <= t.k && is_above(t.j)).count();
    let matrix: usize = (0..order).map(|m| if m == 0 { order * order } else { 2 * (order - m).pow(2) }).sum();
    2.0 * (entries + matrix) as f64
}

/// Entries `(i ≤ j, k)`, pairs `(i ≤ j)` that have some, and those with `i = j`.
fn entries(order: usize) -> (usize, usize, usize) {
    let tensor = GauntTensor::new(order, order, order);
    let upper: Vec<[usize; 2]> = tensor.coefficients().iter().filter(|t| t.i <= t.j).map(|t| [t.i, t.j]).collect();
    let mut pairs = upper.clone();
    pairs.dedup();
    (upper.len(), pairs.len(), pairs.iter().filter(|[i, j]| i == j).count())
}

/// Operations of one rotation by the matrices of its bands, that of the constant left out.
pub(crate) fn rotation_operations(order: usize) -> f64 {
    let n = order as f64;
    2.0 * (n * (4.0 * n * n - 1.0) / 3.0 - 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn operations_are_those_that_were_counted_elsewhere() {
        // Nonzero entries (i ≤ j, k) and pairs of orders 2 to 6, counted independently for these floors.
        for (order, expected) in [(2, (7, 7)), (3, (52, 40)), (4, (194, 125)), (5, (623, 310)), (6, (1517, 646))] {
            let (entries, pairs, squares) = entries(order);
            assert_eq!((entries, pairs), expected, "order {order}");
            assert_eq!(squares, order * order, "order {order}: every function times itself has a mean");
        }
        // M of order 2: z_0 in three places, z_1 between the bands; times one function and two.
        assert_eq!(zonal_product_operations(2), 2.0 * (4.0 + 4.0 + 2.0), "entries, and 2² + 2 · 1²");
        assert_eq!(basis_operations(3), 12.0 + 9.0 + 8.0, "n (n + 1) + n² + 4 (n - 1)");
        // Bands of 3 and 5: 9 and 25 multiply-adds.
        assert_eq!(rotation_operations(3), 2.0 * (9.0 + 25.0), "bands 1 and 2");
    }

    #[test]
    fn the_floor_is_the_slower_of_arithmetic_and_bytes() {
        let floor = |operations, bytes, level| Cost { operations, bytes, level }.floor(10, &Floors::EXAMPLE);
        assert_eq!(floor(100.0, 100.0, Level::WrittenToCache), (10.0, "arithmetic"), "10 ns against 1 ns");
        assert_eq!(floor(100.0, 100.0, Level::Written), (20.0, "memory, written"), "10 ns against 20 ns");
        assert_eq!(floor(0.0, 100.0, Level::WrittenToCache), (1.0, "first-level cache"), "1000 bytes fit");
        assert_eq!(floor(0.0, 200.0, Level::WrittenToCache), (8.0, "second-level cache"), "2000 bytes do not");
        assert_eq!(floor(0.0, 80.0, Level::Cache), (1.0, "first-level cache"), "800 bytes fit");
        assert_eq!(floor(0.0, 200.0, Level::Cache), (4.0, "second-level cache"), "2000 bytes do not");
        assert_eq!(floor(0.0, 80.0, Level::Read), (10.0, "memory, read"), "bytes alone");
    }
}
