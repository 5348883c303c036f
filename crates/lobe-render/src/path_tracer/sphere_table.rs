//! Importance sampling of directions by a table over the sphere.

use std::f64::consts::{FRAC_1_PI, FRAC_PI_2, PI};

use lobe_env::lat_long;
use lobe_sh::Dir;

/// A density over the sphere that is constant over each cell of a lat-long grid.
///
/// A cell is drawn by the inverse of its cumulative distribution, the row first, then the column, and a direction
/// within it uniformly by solid angle. Both steps are monotone, so evenly spread numbers become evenly spread
/// directions.
///
/// The density in a cell is its weight over the [whole](Self::whole): who holds the weights needs no table of it.
pub(crate) struct SphereTable {
    width: usize,
    height: usize,
    /// The part of the whole in rows above each row, and 1.
    rows: Vec<f64>,
    row_guide: Vec<u16>,
    /// For each row, the part of it left of each column, and 1.
    columns: Vec<f64>,
    /// As many for each row as it has columns.
    column_guides: Vec<u16>,
    /// The cosine of the upper border of each row, and that of the lower border of the last.
    borders: Vec<f64>,
    whole: f64,
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
        let (mut row_guide, mut column_guides) = (Vec::new(), Vec::with_capacity(width * height));
        guide(&rows, &mut row_guide);
        columns.chunks_exact(width + 1).for_each(|row| guide(row, &mut column_guides));
        let borders = (0..=height).map(|row| (PI * row as f64 / height as f64).cos()).collect();
        Some(Self { width, height, rows, row_guide, columns, column_guides, borders, whole })
    }

    /// A direction and its cell, for each two numbers.
    ///
    /// Each step is done for all of them before the next, so that they wait for memory together.
    pub(crate) fn samples(&self, numbers: &[[f64; 2]]) -> Vec<(Dir, usize)> {
        // Draw the rows, and read where the search for the columns begins.
        let starts = numbers.iter().map(|&[u, v]| {
            let (y, dy) = invert(&self.rows, start_of(&self.row_guide, v), v);
            (y, dy, start_of(&self.column_guides[y * self.width..][..self.width], u))
        });
        let starts: Vec<_> = starts.collect();
        // Draw the columns.
        let cells = starts.iter().zip(numbers).map(|(&(y, dy, start), &[u, _])| {
            let row = &self.columns[y * (self.width + 1)..][..=self.width];
            let (x, dx) = invert(row, start, u);
            ((x, dx), (y, dy))
        });
        let cells: Vec<_> = cells.collect();
        cells.into_iter().map(|(x, y)| self.within(x, y)).collect()
    }

    /// The direction at a place within the cell of a column and a row.
    fn within(&self, (x, dx): (usize, f64), (y, dy): (usize, f64)) -> (Dir, usize) {
        let z = self.borders[y] + dy * (self.borders[y + 1] - self.borders[y]);
        let (sin_phi, cos_phi) = (PI * (1.0 - 2.0 * (x as f64 + dx) / self.width as f64)).sin_cos();
        let sin = ((1.0 - z) * (1.0 + z)).max(0.0).sqrt();
        (Dir::from_unit([sin * cos_phi, sin * sin_phi, z]), y * self.width + x)
    }

    /// The integral of the weights over the sphere.
    pub(crate) fn whole(&self) -> f64 {
        self.whole
    }

    /// The columns and rows of the grid.
    pub(crate) fn size(&self) -> [usize; 2] {
        [self.width, self.height]
    }
}

/// The cell of a lat-long grid that `s` goes through.
///
/// Angles are found to [`ATAN_ERROR`] first, which is all that most directions need. The others are those that pass a
/// border of cells as near as that, so that all have the cell of the angles in full.
pub(crate) fn cell(width: usize, height: usize, s: Dir) -> usize {
    let [x, y, z] = s.to_array();
    let across = 0.5 - 0.5 * FRAC_1_PI * nearly_atan2(y, x);
    let down = FRAC_1_PI * nearly_atan2((x * x + y * y).sqrt(), z);
    match (certain_place(across, width), certain_place(down, height)) {
        (Some(column), Some(row)) => row * width + column,
        _ => cell_by_angles(width, height, s),
    }
}

/// The same by angles to all digits.
fn cell_by_angles(width: usize, height: usize, s: Dir) -> usize {
    let (u, v) = lat_long::uv_from_dir(s);
    let place = |t: f64, count: usize| ((t * count as f64) as usize).min(count - 1);
    place(v, height) * width + place(u, width)
}

/// The one of `count` equal parts of `(0, 1)` in which lies what is `t` to an angle of [`ATAN_ERROR`]; none if it may
/// be another.
fn certain_place(t: f64, count: usize) -> Option<usize> {
    // A turn is 2π and half a turn π: the larger part of these is meant.
    let (at, error) = (t * count as f64, FRAC_1_PI * ATAN_ERROR * count as f64);
    let place = at.max(0.0) as usize;
    let within = at - place as f64;
    (within > error && within < 1.0 - error && place < count).then_some(place)
}

/// The largest error of [`nearly_atan2`] in radian (test `nearly_all_of_an_angle_is_within_its_error`).
const ATAN_ERROR: f64 = 1e-7;

/// `atan2`, to [`ATAN_ERROR`]; 0 for two zeros.
///
/// ```text
///   atan a = a P(a²), 0 ≤ a ≤ 1        P: interpolates atan(√q)/√q at the nodes of Chebyshev in q
///   atan a = π/2 - atan 1/a for the other half of a quadrant
/// ```
fn nearly_atan2(y: f64, x: f64) -> f64 {
    /// From the lowest power on, computed by `numpy.polynomial.chebyshev.chebinterpolate`.
    const P: [f64; 8] = [
        0.9999998819964928,
        -0.3333181265562583,
        0.19966961829568286,
        -0.14003290184552686,
        0.09868865457940856,
        -0.0588297531413815,
        0.02378051859662378,
        -0.004559791986139317,
    ];
    let (ax, ay) = (x.abs(), y.abs());
    let (small, large) = if ax < ay { (ax, ay) } else { (ay, ax) };
    let a = if large > 0.0 { small / large } else { 0.0 };
    let q = a * a;
    // In two halves, which do not wait for each other.
    let q2 = q * q;
    let even = P[0] + q2 * (P[2] + q2 * (P[4] + q2 * P[6]));
    let odd = P[1] + q2 * (P[3] + q2 * (P[5] + q2 * P[7]));
    let atan = a * (even + q * odd);
    let in_quadrant = if ax < ay { FRAC_PI_2 - atan } else { atan };
    let in_half = if x < 0.0 { PI - in_quadrant } else { in_quadrant };
    if y < 0.0 { -in_half } else { in_half }
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

/// Appends, for each of as many equal parts of `(0, 1)` as the distribution has intervals, the interval that holds
/// its start: a guide table ([Chen and Asau 1974]). Intervals beyond the last number of 16 bits have that, from which
/// [`invert`] goes on.
///
/// [Chen and Asau 1974]: https://doi.org/10.1080/05695557408974949
fn guide(cumulative: &[f64], out: &mut Vec<u16>) {
    let count = cumulative.len() - 1;
    let mut k = 0;
    for part in 0..count {
        let start = part as f64 / count as f64;
        while k + 1 < count && cumulative[k + 1] <= start {
            k += 1;
        }
        out.push(k.min(usize::from(u16::MAX)) as u16);
    }
}

/// Where the search for `u` begins, by the guide of a distribution.
fn start_of(guide: &[u16], u: f64) -> usize {
    usize::from(guide[((u * guide.len() as f64) as usize).min(guide.len() - 1)])
}

/// The interval of a cumulative distribution that holds `u`, never one without extent, and how far within it `u` lies.
///
/// The search begins where the guide [says](start_of). Over all `u` it passes less than one interval in the mean, as
/// there are as many parts of the guide as intervals.
fn invert(cumulative: &[f64], start: usize, u: f64) -> (usize, f64) {
    let (mut k, last) = (start, cumulative.len() - 2);
    // Where the product was rounded up, the part begins above `u`.
    while k > 0 && cumulative[k] > u {
        k -= 1;
    }
    while k < last && cumulative[k + 1] <= u {
        k += 1;
    }
    // Where rounding leaves the last parts below 1, the last interval of any extent is meant.
    if cumulative[k + 1] <= u {
        k = (0..=k).rev().find(|&k| cumulative[k + 1] > cumulative[k]).unwrap_or(0);
    }
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
            let (s, cell_drawn) = table.samples(&[[random.unit(), random.unit()]])[0];
            assert_eq!(cell(w, h, s), cell_drawn, "towards {s:?}");
            seen[cell_drawn] += 1.0;
        }
        let (mut statistic, mut cells) = (0.0, -1.0);
        for (i, &n) in seen.iter().enumerate() {
            let expected = weights[i] / table.whole() * lat_long::solid_angle(w, h, i / w) * f64::from(count);
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
        let whole: f64 = (0..32).map(|i| weights[i] / table.whole() * lat_long::solid_angle(8, 4, i / 8)).sum();
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
            assert_eq!(table.samples(&[[u, 1.0 - u]])[0].1, 13, "the only cell, at {u}");
        }
    }

    #[test]
    fn a_guide_leads_to_the_interval_of_a_binary_search() {
        let mut random = Random::new(8);
        // Even parts, parts of many sizes with some of none, and one that holds nearly all.
        let weights: [Vec<f64>; 4] = [
            vec![1.0; 97],
            (0..200).map(|i| if i % 3 == 0 { 0.0 } else { random.unit().powi(8) }).collect(),
            (0..500).map(|i| if i == 123 { 1e7 } else { 1e-3 }).collect(),
            vec![2.0],
        ];
        for weights in weights {
            let (mut cumulative, mut parts) = (Vec::new(), Vec::new());
            cumulate(&weights, &mut cumulative);
            guide(&cumulative, &mut parts);
            let borders = cumulative.iter().copied().filter(|u| *u < 1.0);
            for u in borders.chain((0..2000).map(|_| random.unit())).collect::<Vec<_>>() {
                let expected = cumulative.partition_point(|part| *part <= u) - 1;
                let (found, within) = invert(&cumulative, start_of(&parts, u), u);
                assert_eq!(found, expected, "{u} of {} parts", weights.len());
                assert!((0.0..=1.0).contains(&within), "{u}: {within}");
            }
        }
    }

    #[test]
    fn a_guide_of_more_intervals_than_16_bits_count_leads_to_all_of_them() {
        let (mut cumulative, mut parts) = (Vec::new(), Vec::new());
        cumulate(&vec![1.0; 70_000], &mut cumulative);
        guide(&cumulative, &mut parts);
        for k in [0, 65_000, 65_535, 65_536, 69_999] {
            let u = 0.5 * (cumulative[k] + cumulative[k + 1]);
            assert_eq!(invert(&cumulative, start_of(&parts, u), u).0, k, "{u}");
        }
    }

    #[test]
    fn nearly_all_of_an_angle_is_within_its_error() {
        let mut largest: f64 = 0.0;
        for k in -100_000..=100_000 {
            let angle = PI * f64::from(k) / 100_000.0;
            let (y, x) = angle.sin_cos();
            largest = largest.max((nearly_atan2(y, x) - y.atan2(x)).abs());
        }
        assert!(largest < ATAN_ERROR, "{largest}");
        assert_eq!(nearly_atan2(0.0, 0.0), 0.0, "no angle");
    }

    #[test]
    fn the_cell_of_a_direction_is_that_of_its_angles() {
        let mut random = Random::new(11);
        for (w, h) in [(1, 1), (2, 1), (12, 6), (1024, 512), (8192, 4096), (1 << 20, 1 << 19)] {
            let chance = (0..5000).map(|_| random.direction()).collect::<Vec<_>>();
            // On borders of cells, too.
            let borders = (0..2000).map(|k| lat_long::dir_from_uv(f64::from(k) / 1024.0, f64::from(k % 513) / 512.0));
            let all = lobe_testkit::directions().into_iter().chain(chance).filter_map(Dir::new);
            for s in all.chain(borders) {
                assert_eq!(cell(w, h, s), cell_by_angles(w, h, s), "{w} x {h} towards {s:?}");
            }
        }
    }
}
