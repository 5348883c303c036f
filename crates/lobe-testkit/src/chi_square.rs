//! Chi-square test of samplers on the sphere against their density.

use std::f64::consts::{PI, TAU};

/// Cells along cos θ and φ, of equal solid angle.
const ROWS: usize = 12;
const COLUMNS: usize = 24;

/// Points along each side of a cell that its share of the density is summed over: enough for lobes a cell wide.
const POINTS: usize = 48;

/// Cells that expect fewer are counted together: below, counts are not normally distributed (the usual rule).
const FEWEST: f64 = 5.0;

/// Pearson's test of a sampler on the sphere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChiSquare {
    /// `Σ (found - expected)²/expected`.
    pub statistic: f64,
    /// Cells compared, less one.
    pub freedom: f64,
    /// The part of all directions that the density leaves for those not drawn: one less its integral.
    pub missing: f64,
}

impl ChiSquare {
    /// Counts `count` drawn directions in 288 cells of equal solid angle, those not drawn (none) in one more, and
    /// compares with the integral of `density`, in sr⁻¹, over each cell.
    pub fn new(count: usize, mut draw: impl FnMut() -> Option<[f64; 3]>, density: impl Fn([f64; 3]) -> f64) -> Self {
        let mut found = [0.0; ROWS * COLUMNS + 1];
        for _ in 0..count {
            found[draw().map_or(ROWS * COLUMNS, cell)] += 1.0;
        }
        let mut expected = [0.0; ROWS * COLUMNS + 1];
        for (k, expected) in expected[..ROWS * COLUMNS].iter_mut().enumerate() {
            *expected = share(k, &density) * count as f64;
        }
        let missing = 1.0 - expected.iter().sum::<f64>() / count as f64;
        expected[ROWS * COLUMNS] = (missing * count as f64).max(0.0);
        let (mut statistic, mut cells, mut rest) = (0.0, 0, [0.0; 2]);
        for (found, expected) in found.into_iter().zip(expected) {
            if expected < FEWEST {
                rest = [rest[0] + found, rest[1] + expected];
            } else {
                statistic += (found - expected).powi(2) / expected;
                cells += 1;
            }
        }
        if rest[0].max(rest[1]) > 0.0 {
            statistic += (rest[0] - rest[1]).powi(2) / rest[1].max(FEWEST);
            cells += 1;
        }
        Self { statistic, freedom: (cells.max(2) - 1) as f64, missing }
    }

    /// The statistic in standard deviations above its mean under chance: the cube root of a χ² over its freedom is
    /// nearly normal [Wilson and Hilferty 1931].
    ///
    /// ```text
    ///   z = ((χ²/k)^⅓ - (1 - 2/9k)) / √(2/9k)
    /// ```
    #[must_use]
    pub fn z(&self) -> f64 {
        let part = 2.0 / (9.0 * self.freedom);
        ((self.statistic / self.freedom).cbrt() - (1.0 - part)) / part.sqrt()
    }
}

/// The cell of a unit vector.
fn cell([x, y, z]: [f64; 3]) -> usize {
    let row = ((1.0 - z) / 2.0 * ROWS as f64) as usize;
    let column = (y.atan2(x).rem_euclid(TAU) / TAU * COLUMNS as f64) as usize;
    row.min(ROWS - 1) * COLUMNS + column.min(COLUMNS - 1)
}

/// The integral of a density over a cell, by midpoints.
fn share(cell: usize, density: impl Fn([f64; 3]) -> f64) -> f64 {
    let (row, column) = ((cell / COLUMNS) as f64, (cell % COLUMNS) as f64);
    let mut sum = 0.0;
    for i in 0..POINTS * POINTS {
        let [u, v] = [i / POINTS, i % POINTS].map(|k| (k as f64 + 0.5) / POINTS as f64);
        let z = 1.0 - 2.0 * (row + u) / ROWS as f64;
        let (sin, cos) = (TAU * (column + v) / COLUMNS as f64).sin_cos();
        let r = (1.0 - z * z).sqrt();
        sum += density([r * cos, r * sin, z]);
    }
    sum / (POINTS * POINTS) as f64 * 4.0 * PI / (ROWS * COLUMNS) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Random;

    #[test]
    fn the_right_density_passes_and_wrong_ones_fail() {
        let mut random = Random::new(4);
        let mut uniform = || Some(random.direction());
        let right = ChiSquare::new(50_000, &mut uniform, |_| 0.25 / PI);
        assert!(right.z().abs() < 4.0 && right.missing.abs() < 1e-12, "{right:?}, z = {}", right.z());
        for (name, wrong) in [("tilted", [0.05, 0.0, 0.0]), ("upwards", [0.0, 0.0, 0.05])] {
            let density = |s: [f64; 3]| (1.0 + (0..3).map(|k| wrong[k] * s[k]).sum::<f64>()) * 0.25 / PI;
            let z = ChiSquare::new(500_000, &mut uniform, density).z();
            assert!(z > 5.0, "{name}: z = {z}");
        }
        let mut half = || uniform().filter(|s| s[2] > 0.0);
        let above = ChiSquare::new(50_000, &mut half, |s| if s[2] > 0.0 { 0.25 / PI } else { 0.0 });
        assert!(above.z().abs() < 4.0 && (above.missing - 0.5).abs() < 1e-12, "{above:?}, z = {}", above.z());
    }
}
