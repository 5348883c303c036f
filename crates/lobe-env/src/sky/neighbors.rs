//! Directions that lie near others, found by cells of space.

use std::collections::{BTreeMap, HashMap};

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

    /// The numbers of all directions near another one.
    fn near(&self, s: Dir) -> impl Iterator<Item = usize> {
        let cells = around::<3>(cell_of(s, self.side)).filter_map(|cell| self.cells.get(&cell));
        cells.flatten().copied().filter(move |k| self.directions[*k].angle_to(s) <= self.angle)
    }

    /// Whether any direction is near another one.
    pub(crate) fn has_near(&self, s: Dir) -> bool {
        self.near(s).next().is_some()
    }
}

/// The parts of some directions, and the part of each: two are of one part where neighbors within `angle` lead from one
/// to the other. The part of the direction `first` is 0. None if there are more than `most`.
///
/// Directions in one cell, whose diagonal is that angle, are of one part, so whole cells are joined. Two cells are
/// compared by one direction in each piece of a [`PIECES`]th of their sides: near the pole of a lat-long map a cell has
/// thousands of them (test `a_crowd_of_directions_is_parted_by_few_comparisons`).
pub(crate) fn parts(directions: &[Dir], angle: f64, first: usize, most: usize) -> Option<Vec<usize>> {
    let mut asked = 0;
    parts_counting(directions, angle, first, most, &mut asked)
}

/// As [`parts`]; counts comparisons.
fn parts_counting(
    directions: &[Dir],
    angle: f64,
    first: usize,
    most: usize,
    comparisons: &mut usize,
) -> Option<Vec<usize>> {
    let chord = 2.0 * (0.5 * angle).sin();
    let side = (chord / 3.0_f64.sqrt()).max(1e-6);
    let mut cells: HashMap<[i64; 3], Cell> = HashMap::new();
    for (k, s) in directions.iter().enumerate() {
        let cell = cells.entry(cell_of(*s, side)).or_default();
        cell.members.push(k);
        cell.pieces.entry(cell_of(*s, side / PIECES)).or_insert(*s);
    }
    let mut parts = vec![usize::MAX; directions.len()];
    let mut count = 0;
    for start in std::iter::once(first).chain(0..directions.len()) {
        if parts[start] != usize::MAX {
            continue;
        }
        if count == most {
            return None;
        }
        let at = cell_of(directions[start], side);
        let mut to_visit: Vec<_> = cells.remove(&at).map(|cell| (at, cell)).into_iter().collect();
        while let Some((at, cell)) = to_visit.pop() {
            cell.members.iter().for_each(|k| parts[*k] = count);
            for at in around::<5>(at) {
                if cells.get(&at).is_some_and(|other| cell.is_near(other, chord, comparisons))
                    && let Some(other) = cells.remove(&at)
                {
                    to_visit.push((at, other));
                }
            }
        }
        count += 1;
    }
    Some(parts)
}

/// Parts of the side of a cell, in which directions count as one. Texels of a map are farther apart, except near its
/// poles.
const PIECES: f64 = 16.0;

/// The directions in a cell.
#[derive(Default)]
struct Cell {
    members: Vec<usize>,
    /// One in each piece.
    pieces: BTreeMap<[i64; 3], Dir>,
}

impl Cell {
    /// Whether two directions in two cells lie within a chord.
    fn is_near(&self, other: &Self, chord: f64, comparisons: &mut usize) -> bool {
        let is_near = |a: &Dir, b: &Dir| {
            let (a, b) = (a.to_array(), b.to_array());
            [0, 1, 2].map(|k| (a[k] - b[k]).powi(2)).iter().sum::<f64>() <= chord * chord
        };
        self.pieces.values().any(|a| {
            other.pieces.values().any(|b| {
                *comparisons += 1;
                is_near(a, b)
            })
        })
    }
}

/// The cells around a cell, `N` in each direction, with itself.
fn around<const N: i64>([x, y, z]: [i64; 3]) -> impl Iterator<Item = [i64; 3]> {
    let offset = |k: i64| k % N - N / 2;
    (0..N * N * N).map(move |k| [x + offset(k), y + offset(k / N), z + offset(k / (N * N))])
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
                let mut found: Vec<usize> = neighbors.near(*s).collect();
                found.sort_unstable();
                let expected: Vec<usize> =
                    (0..directions.len()).filter(|k| directions[*k].angle_to(*s) <= angle).collect();
                assert_eq!(found, expected, "within {angle} of {s:?}");
            }
        }
    }

    /// The parts by all pairs.
    fn parts_of_all_pairs(directions: &[Dir], angle: f64) -> Vec<usize> {
        let mut parts = vec![usize::MAX; directions.len()];
        let mut count = 0;
        for start in 0..directions.len() {
            let mut to_visit = if parts[start] == usize::MAX { vec![start] } else { continue };
            while let Some(k) = to_visit.pop() {
                parts[k] = count;
                let is_new =
                    |other: &usize| parts[*other] == usize::MAX && directions[*other].angle_to(directions[k]) <= angle;
                to_visit.extend((0..directions.len()).filter(is_new));
            }
            count += 1;
        }
        parts
    }

    #[test]
    fn parts_are_those_of_all_pairs() {
        let mut random = lobe_testkit::Random::new(5);
        let directions: Vec<Dir> = (0..300).filter_map(|_| Dir::new(random.direction())).collect();
        for angle in [1e-3, 0.05, 0.1, 0.15, 0.7] {
            let expected = parts_of_all_pairs(&directions, angle);
            let count = 1 + expected.iter().max().unwrap();
            assert_eq!(parts(&directions, angle, 0, count).as_ref(), Some(&expected), "within {angle}");
            assert_eq!(parts(&directions, angle, 0, count - 1), None, "{count} parts within {angle}");
        }
    }

    #[test]
    fn a_crowd_of_directions_is_parted_by_few_comparisons() {
        const COLUMNS: usize = 16384;
        // The rows of a lat-long map of 16384 x 8192 next to its pole, and one apart from them.
        let pitch = std::f64::consts::TAU / COLUMNS as f64;
        let row = |k: usize| {
            let theta = (k as f64 + 0.5) * pitch;
            (0..COLUMNS).map(move |x| Dir::from_angles(theta, x as f64 * pitch))
        };
        let directions: Vec<Dir> = (0..12).chain([16]).flat_map(row).collect();
        let mut comparisons = 0;
        let parts = parts_counting(&directions, 1.6 * pitch, 0, 2, &mut comparisons).unwrap();
        let expected: Vec<usize> = (0..directions.len()).map(|k| k / (12 * COLUMNS)).collect();
        assert!(parts == expected, "two parts");
        // Pairs within that angle are more than a hundred million.
        assert!(comparisons < 50 * directions.len(), "{comparisons} comparisons of {} directions", directions.len());
    }
}
