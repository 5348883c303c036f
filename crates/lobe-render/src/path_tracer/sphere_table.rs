//! Importance sampling of directions by a table over the sphere.

use std::f64::consts::PI;

use lobe_env::lat_long;
use lobe_sh::Dir;

/// A density over the sphere that is constant over each cell of a lat-long grid.
///
/// A cell is drawn by the inverse of its cumulative distribution, the row first, then the column, and a direction
/// within it uniformly by solid angle. Both steps are monotone, so evenly spread numbers become evenly spread
/// directions.
pub(crate) struct SphereTable {
    width: usize,
    height: usize,
    /// The part of the whole in rows above each row, and 1.
    rows: Vec<f64>,
    /// For each row, the part of it left of each column, and 1.
    columns: Vec<f64>,
    /// The density in sr⁻¹ of each cell.
    densities: Vec<f64>,
}

impl SphereTable {
    /// The density in proportion to `weights`, one for each cell, row after row, none negative; none if all are zero, or their
    /// sum is not finite.
    pub(crate) fn new(width: usize, height: usize, weights: &[f64]) -> Option<Self> {
        let (mut rows, mut columns) = (vec![0.0], Vec::with_capacity((width + 1) * height));
        for (y, row) in weights.chunks_exact(width).enumerate() {
            let sum = cumulate(row, &mut columns);
            rows.push(rows[y] + sum * lat_long::solid_angle(width, height, y));
        }
        let whole = rows[height];
        if !(whole > 0.0 && whole.is_finite()) {
            return None;
        }
        rows.iter_mut().for_each(|part| *part /= whole);
        let densities = weights.iter().map(|weight| weight / whole).collect();
        Some(Self { width, height, rows, columns, densities })
    }

    /// A direction, its cell, and the density there.
    pub(crate) fn sample(&self, [u, v]: [f64; 2]) -> (Dir, usize, f64) {
        let (y, dy) = invert(&self.rows, v);
        let (x, dx) = invert(&self.columns[y * (self.width + 1)..][..=self.width], u);
        let cos = |row: usize| (PI * row as f64 / self.height as f64).cos();
        let z = cos(y) + dy * (cos(y + 1) - cos(y));
        let (sin_phi, cos_phi) = (PI * (1.0 - 2.0 * (x as f64 + dx) / self.width as f64)).sin_cos();
        let sin = ((1.0 - z) * (1.0 + z)).max(0.0).sqrt();
        let cell = y * self.width + x;
        (Dir::from_unit([sin * cos_phi, sin * sin_phi, z]), cell, self.densities[cell])
    }

    /// The density towards `s`.
    pub(crate) fn density(&self, s: Dir) -> f64 {
        self.densities[cell(self.width, self.height, s)]
    }
}

/// The cell of a lat-long grid that `s` goes through.
pub(crate) fn cell(width: usize, height: usize, s: Dir) -> usize {
    let (u, v) = lat_long::uv_from_dir(s);
    let place = |t: f64, count: usize| ((t * count as f64) as usize).min(count - 1);
    place(v, height) * width + place(u, width)
}

/// Appends the parts of a row left of each cell, and 1; its sum. In a row of zeros, which is never drawn, cells are
/// alike.
fn cumulate(row: &[f64], out: &mut Vec<f64>) -> f64 {
    let sum: f64 = row.iter().sum();
    let mut below = 0.0;
    out.push(0.0);
    for (x, weight) in row.iter().enumerate() {
        below += weight;
        out.push(if sum > 0.0 { below / sum } else { (x + 1) as f64 / row.len() as f64 });
    }
    sum
}

/// The interval of a cumulative distribution that holds `u`, never one without extent, and how far within it `u` lies.
fn invert(cumulative: &[f64], u: f64) -> (usize, f64) {
    let last = cumulative.len() - 2;
    let k = (cumulative.partition_point(|part| *part <= u).max(1) - 1).min(last);
    // Where rounding leaves the last parts below 1, the last interval of any extent is meant.
    let k = (0..=k).rev().find(|&k| cumulative[k + 1] > cumulative[k]).unwrap_or(0);
    let extent = cumulative[k + 1] - cumulative[k];
    (k, ((u - cumulative[k]) / extent).clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use lobe_testkit::Random;

    #[test]
    fn directions_are_drawn_with_the_density_stated() {
        // Pearson's statistic over the 60 cells of a grid of 12 x 6, of which some are empty.
        let (w, h) = (12, 6);
        let mut random = Random::new(4);
        let weights: Vec<f64> = (0..w * h).map(|i| if i % 5 == 0 { 0.0 } else { random.unit() }).collect();
        let table = SphereTable::new(w, h, &weights).unwrap();
        let count = 60_000;
        let mut seen = vec![0.0; w * h];
        for _ in 0..count {
            let (s, cell_drawn, density) = table.sample([random.unit(), random.unit()]);
            assert_eq!(cell(w, h, s), cell_drawn, "towards {s:?}");
            assert_eq!(table.density(s), density, "towards {s:?}");
            seen[cell_drawn] += 1.0;
        }
        let (mut statistic, mut cells) = (0.0, -1.0);
        for (i, &n) in seen.iter().enumerate() {
            let expected = table.densities[i] * lat_long::solid_angle(w, h, i / w) * f64::from(count);
            if expected == 0.0 {
                assert_eq!(n, 0.0, "cell {i} is empty");
                continue;
            }
            statistic += (n - expected).powi(2) / expected;
            cells += 1.0;
        }
        // Mean `cells`, standard deviation √(2 cells): five of them.
        assert!((statistic - cells).abs() < 5.0 * (2.0_f64 * cells).sqrt(), "{statistic} for {cells} degrees");
    }

    #[test]
    fn densities_integrate_to_one_and_black_has_none() {
        let weights: Vec<f64> = (0..32).map(f64::from).collect();
        let table = SphereTable::new(8, 4, &weights).unwrap();
        let whole: f64 = (0..32).map(|i| table.densities[i] * lat_long::solid_angle(8, 4, i / 8)).sum();
        assert!((whole - 1.0).abs() < 1e-14, "{whole}");
        assert!(SphereTable::new(8, 4, &[0.0; 32]).is_none(), "nothing to draw");
        let mut infinite = weights;
        infinite[5] = f64::INFINITY;
        assert!(SphereTable::new(8, 4, &infinite).is_none(), "no density is in proportion to this");
    }

    #[test]
    fn the_ends_of_the_interval_draw_cells_with_light() {
        let mut weights = [0.0; 32];
        weights[13] = 2.0;
        let table = SphereTable::new(8, 4, &weights).unwrap();
        for u in [0.0, 0.5, 1.0 - 1e-16, 1.0] {
            assert_eq!(table.sample([u, 1.0 - u]).1, 13, "the only cell, at {u}");
        }
    }
}
