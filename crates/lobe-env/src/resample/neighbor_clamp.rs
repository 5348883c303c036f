//! Uniform part of a map's light: each texel clamped to the mean of its neighbors.
//!
//! ```text
//!   min(L_s, m_s)        m_s the mean of the up to eight neighbors of texel s in the picture that have a solid angle
//! ```
//!
//! Computed row by row on demand: to hold it would take as much memory as the map.

use lobe_io::parallel;
use lobe_sh::{Coefficient, Rgb};

use crate::map::mapped_map::MappedMap;
use crate::mapping::grid::Grid;
use crate::mapping::solid_angles::SolidAngles;

/// Rows of a band that one thread changes in place. The rows above and below each band are copied first.
const ROWS: usize = 32;

/// A row of a picture between its neighbors.
#[derive(Clone, Copy)]
struct Rows<'a> {
    above: Option<&'a [Rgb<f32>]>,
    own: &'a [Rgb<f32>],
    below: Option<&'a [Rgb<f32>]>,
}

/// Computes the uniform light of maps of one shape.
pub(crate) struct NeighborClamp<'a> {
    grid: Grid,
    solid_angles: &'a SolidAngles,
}

impl<'a> NeighborClamp<'a> {
    /// For pictures whose texels have these solid angles.
    pub(crate) fn new(grid: Grid, solid_angles: &'a SolidAngles) -> Self {
        Self { grid, solid_angles }
    }

    /// `of_row(y, uniform light of row y)` for every row, from the top.
    pub(crate) fn of_rows<T: Send>(&self, map: &MappedMap, of_row: impl Fn(usize, &[Rgb<f32>]) -> T + Sync) -> Vec<T> {
        let row = |y: usize| (y < self.grid.height).then(|| map.row(y));
        let of_row = |clamped: &mut Vec<Rgb<f32>>, y: usize| {
            let rows = Rows { above: y.checked_sub(1).and_then(row), own: map.row(y), below: row(y + 1) };
            self.row(y, rows, clamped);
            of_row(y, clamped)
        };
        parallel::map_with(self.grid.height, &|| vec![Rgb::<f32>::ZERO; self.grid.width], &of_row)
    }

    /// Adds to every texel the fraction `share(x, y)` of its excess over the uniform light.
    pub(crate) fn add_excess(&self, map: &mut MappedMap, share: impl Fn(usize, usize) -> f32 + Sync) {
        let width = self.grid.width;
        let texels = map.texels_mut();
        // Copy the rows that border each band.
        let row = |y: usize| texels.chunks_exact(width).nth(y).map(<[Rgb<f32>]>::to_vec);
        let starts = (0..self.grid.height).step_by(ROWS);
        let borders: Vec<_> = starts.map(|y| (y.checked_sub(1).and_then(row), row(y + ROWS))).collect();
        let mut bands: Vec<_> = texels.chunks_mut(ROWS * width).zip(borders).collect();
        // Change each band in place, row by row.
        parallel::rows(&mut bands, 1, &|part, band| {
            let [(rows, (above, below))] = band else { unreachable!("a band at a time") };
            let (mut clamped, mut kept) = (vec![Rgb::ZERO; width], Vec::new());
            let mut rest = &mut rows[..];
            for y in part * ROWS.. {
                let Some((own, next)) = rest.split_at_mut_checked(width) else { break };
                let rows = Rows { above: above.as_deref(), own, below: next.get(..width).or(below.as_deref()) };
                self.row(y, rows, &mut clamped);
                kept.clear();
                kept.extend_from_slice(own);
                for (x, (texel, clamped)) in own.iter_mut().zip(&clamped).enumerate() {
                    *texel += (*texel - *clamped).scale(share(x, y));
                }
                // Keep the unchanged row for the row below.
                std::mem::swap(above.get_or_insert_default(), &mut kept);
                rest = next;
            }
        });
    }

    /// Row `y` of the uniform light: each channel at most the mean of its neighbors; unchanged if there are none.
    fn row(&self, y: usize, rows: Rows<'_>, clamped: &mut [Rgb<f32>]) {
        // Without discs in the picture every texel has a solid angle.
        if self.grid.mapping.form().discs() == 0 {
            return clamped_row(rows, clamped);
        }
        for (x, clamped) in clamped.iter_mut().enumerate() {
            *clamped = least(rows.own[x], self.around(rows, x, y));
        }
    }

    /// The mean of the up to eight neighbors in the picture that have a solid angle; without any, the texel itself.
    fn around(&self, rows: Rows<'_>, x: usize, y: usize) -> Rgb<f32> {
        let columns = x.saturating_sub(1)..self.grid.width.min(x + 2);
        let (mut sum, mut count) = (Rgb::ZERO, 0.0);
        for (row, texels) in [(y.wrapping_sub(1), rows.above), (y, Some(rows.own)), (y + 1, rows.below)] {
            let Some(texels) = texels else { continue };
            for column in columns.clone() {
                if (column, row) != (x, y) && self.solid_angles.get(column, row) > 0.0 {
                    sum += texels[column];
                    count += 1.0;
                }
            }
        }
        if count > 0.0 { sum.scale(1.0 / count) } else { rows.own[x] }
    }
}

fn least(a: Rgb<f32>, b: Rgb<f32>) -> Rgb<f32> {
    Rgb::new(a.r.min(b.r), a.g.min(b.g), a.b.min(b.b))
}

/// A row of a picture without discs: column sums, each used three times.
fn clamped_row(rows: Rows<'_>, clamped: &mut [Rgb<f32>]) {
    let (own, width) = (rows.own, rows.own.len());
    let beside = usize::from(rows.above.is_some()) + usize::from(rows.below.is_some());
    // A neighbor beyond the border adds nothing and is not counted.
    let black = vec![Rgb::ZERO; if beside < 2 { width } else { 0 }];
    let [above, below] = [rows.above, rows.below].map(|row| row.unwrap_or(&black));
    let parts = |columns: usize| match columns * (beside + 1) + beside {
        0 => None,
        count => Some(1.0 / count as f32),
    };
    let [single, at_end, inside] = [0, 1, 2].map(parts);
    let column = |x: usize| [own[x], above[x] + below[x]];
    // Leave out the texel itself: nothing cancels next to a sun.
    let (mut left, mut here) = ([Rgb::ZERO; 2], column(0));
    for (x, clamped) in clamped.iter_mut().enumerate() {
        let right = if x + 1 < width { column(x + 1) } else { [Rgb::ZERO; 2] };
        let part = match (x > 0, x + 1 < width) {
            (true, true) => inside,
            (false, false) => single,
            _ => at_end,
        };
        let sum = (left[1] + here[1] + right[1]) + (left[0] + right[0]);
        *clamped = part.map_or(here[0], |part| least(here[0], sum.scale(part)));
        (left, here) = (here, right);
    }
}

#[cfg(test)]
mod tests {
    use lobe_testkit::Random;

    use super::*;
    use crate::mapping::mapping::Mapping;

    fn random_map(mapping: Mapping, width: usize, height: usize) -> MappedMap {
        let mut random = Random::new(8);
        let texels = (0..width * height).map(|_| Rgb::splat(random.unit() as f32)).collect();
        MappedMap::from_rows(mapping, width, height, texels)
    }

    /// Directly from the definition.
    fn clamped_at(map: &MappedMap, x: usize, y: usize) -> f32 {
        let near = |a: usize, b: usize| a.abs_diff(b) <= 1;
        let around = (0..map.texels().len()).map(|i| (i % map.width(), i / map.width()));
        let around =
            around.filter(|&(i, j)| (i, j) != (x, y) && near(i, x) && near(j, y) && map.solid_angle(i, j) > 0.0);
        let around: Vec<f32> = around.map(|(i, j)| map.texel(i, j).g).collect();
        let mean = around.iter().sum::<f32>() / around.len() as f32;
        if around.is_empty() { map.texel(x, y).g } else { map.texel(x, y).g.min(mean) }
    }

    #[test]
    fn the_clamp_is_the_mean_of_the_neighbors() {
        for mapping in [Mapping::LatLong, Mapping::Sphere] {
            for (width, height) in [(1, 1), (1, 4), (5, 1), (2, 3), (9, 7), (5, 70)] {
                let map = random_map(mapping, width, height);
                let solid_angles = SolidAngles::new(map.grid());
                let rows = NeighborClamp::new(map.grid(), &solid_angles).of_rows(&map, |_, row| row.to_vec());
                for (i, clamped) in rows.concat().into_iter().enumerate() {
                    let (x, y) = (i % width, i / width);
                    let expected = clamped_at(&map, x, y);
                    let place = format!("{mapping} {width} x {height}, ({x}, {y})");
                    assert!((clamped.g - expected).abs() < 1e-6, "{place}: {clamped:?}, not {expected}");
                }
            }
        }
    }

    #[test]
    fn every_texel_is_given_its_share_of_the_excess_over_what_the_others_were() {
        let (width, height) = (6, 3 * ROWS + 1);
        let map = random_map(Mapping::LatLong, width, height);
        let (mut changed, solid_angles) = (map.clone(), SolidAngles::new(map.grid()));
        let share = |x: usize, y: usize| (x + 2 * y) as f32 / 100.0;
        NeighborClamp::new(map.grid(), &solid_angles).add_excess(&mut changed, share);
        for (x, y) in (0..width * height).map(|i| (i % width, i / width)) {
            let own = map.texel(x, y).g;
            let (found, expected) = (changed.texel(x, y).g, own + share(x, y) * (own - clamped_at(&map, x, y)));
            assert!((found - expected).abs() < 1e-5, "({x}, {y}): {found}, not {expected}");
        }
    }
}
