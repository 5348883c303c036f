//! Directions that lie near others, found by cells of space.

use std::collections::HashMap;

use lobe_sh::Dir;

/// Some directions, sorted into cells as wide as what counts as near.
pub(crate) struct Neighbors {
    directions: Vec<Dir>,
    /// The largest angle of neighbors.
    angle: f64,
    /// The side of a cell: the chord of that angle.
    side: f64,
    cells: HashMap<[i64; 3], Vec<usize>>,
}

impl Neighbors {
    /// Directions of which those are neighbors that lie within `angle`, at least a millionth.
    pub(crate) fn new(directions: impl Iterator<Item = Dir>, angle: f64) -> Self {
        let directions: Vec<Dir> = directions.collect();
        let side = (2.0 * (0.5 * angle).sin()).max(1e-6);
        let mut cells: HashMap<[i64; 3], Vec<usize>> = HashMap::new();
        for (k, direction) in directions.iter().enumerate() {
            cells.entry(cell_of(*direction, side)).or_default().push(k);
        }
        Self { directions, angle, side, cells }
    }

    /// Calls `visit` with the number of every direction near another one.
    pub(crate) fn each_near(&self, s: Dir, mut visit: impl FnMut(usize)) {
        let [x, y, z] = cell_of(s, self.side);
        for cell in (0..27).map(|k| [x + k % 3 - 1, y + k / 3 % 3 - 1, z + k / 9 - 1]) {
            for k in self.cells.get(&cell).into_iter().flatten() {
                if self.directions[*k].angle_to(s) <= self.angle {
                    visit(*k);
                }
            }
        }
    }

    /// Whether any direction is near another one.
    pub(crate) fn has_near(&self, s: Dir) -> bool {
        let mut has = false;
        self.each_near(s, |_| has = true);
        has
    }
}

fn cell_of(s: Dir, side: f64) -> [i64; 3] {
    s.to_array().map(|c| (c / side).floor() as i64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbors_are_those_of_all_pairs() {
        let mut random = lobe_testkit::Random::new(3);
        let directions: Vec<Dir> = (0..300).filter_map(|_| Dir::new(random.direction())).collect();
        for angle in [1e-3, 0.1, 0.7, 2.0] {
            let neighbors = Neighbors::new(directions.iter().copied(), angle);
            for s in &directions {
                let mut found = Vec::new();
                neighbors.each_near(*s, |k| found.push(k));
                found.sort_unstable();
                let expected: Vec<usize> =
                    (0..directions.len()).filter(|k| directions[*k].angle_to(*s) <= angle).collect();
                assert_eq!(found, expected, "within {angle} of {s:?}");
            }
        }
    }
}
