//! What of a map's light is even: as much as the neighbours of each texel have.

use lobe_sh::{Coefficient, Rgb};
use rayon::prelude::*;

use crate::solid_angles::SolidAngles;
use crate::{MappedMap, Mapping};

/// Every texel, in each channel no brighter than the mean of its up to eight neighbours in the picture that show
/// something; without any, as it is.
pub(crate) fn even_light(map: &MappedMap, solid_angles: &SolidAngles) -> Vec<Rgb<f32>> {
    let width = map.width();
    let mut even = vec![Rgb::ZERO; map.texels().len()];
    // Of a picture without rims every texel shows something.
    let rimless = matches!(map.mapping(), Mapping::LatLong | Mapping::Octahedral | Mapping::EqualArea | Mapping::Cube);
    even.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
        if rimless {
            even_row(map, y, row);
        } else {
            for (x, even) in row.iter_mut().enumerate() {
                *even = least(map.texel(x, y), around(map, solid_angles, x, y));
            }
        }
    });
    even
}

fn least(a: Rgb<f32>, b: Rgb<f32>) -> Rgb<f32> {
    Rgb::new(a.r.min(b.r), a.g.min(b.g), a.b.min(b.b))
}

/// A row of a picture in which every texel shows something: sums of columns, each used three times.
fn even_row(map: &MappedMap, y: usize, even: &mut [Rgb<f32>]) {
    let (own, width) = (map.row(y), map.width());
    let black = vec![Rgb::ZERO; width];
    let above = if y > 0 { map.row(y - 1) } else { &black };
    let below = if y + 1 < map.height() { map.row(y + 1) } else { &black };
    let beside = usize::from(y > 0) + usize::from(y + 1 < map.height());
    let parts = |columns: usize| match columns * (beside + 1) + beside {
        0 => None,
        count => Some(1.0 / count as f32),
    };
    let [single, at_end, inside] = [0, 1, 2].map(parts);
    // Without the texel itself: nothing cancels next to a sun.
    let (mut left, mut here) = ([Rgb::ZERO; 2], [own[0], above[0] + below[0]]);
    for (x, even) in even.iter_mut().enumerate() {
        let right = if x + 1 < width { [own[x + 1], above[x + 1] + below[x + 1]] } else { [Rgb::ZERO; 2] };
        let part = match (x > 0, x + 1 < width) {
            (true, true) => inside,
            (false, false) => single,
            _ => at_end,
        };
        let sum = (left[1] + here[1] + right[1]) + (left[0] + right[0]);
        *even = part.map_or(here[0], |part| least(here[0], sum.scale(part)));
        (left, here) = (here, right);
    }
}

/// The mean of the up to eight neighbours of a texel in the picture that show something; without any, that texel.
fn around(map: &MappedMap, solid_angles: &SolidAngles, x: usize, y: usize) -> Rgb<f32> {
    let columns = x.saturating_sub(1)..map.width().min(x + 2);
    let (mut sum, mut count) = (Rgb::ZERO, 0.0);
    for row in y.saturating_sub(1)..map.height().min(y + 2) {
        for (column, other) in columns.clone().zip(&map.row(row)[columns.clone()]) {
            if (column, row) != (x, y) && solid_angles.get(column, row) > 0.0 {
                sum += *other;
                count += 1.0;
            }
        }
    }
    if count > 0.0 { sum.scale(1.0 / count) } else { map.texel(x, y) }
}

#[cfg(test)]
mod tests {
    use lobe_testkit::Random;

    use super::*;
    use crate::taps::Grid;

    #[test]
    fn sums_of_columns_are_the_sums_over_the_neighbours() {
        let mut random = Random::new(8);
        for (width, height) in [(1, 1), (1, 4), (5, 1), (2, 3), (9, 7)] {
            let texels = (0..width * height).map(|_| Rgb::splat(random.unit() as f32)).collect();
            let map = MappedMap::from_rows(Mapping::LatLong, width, height, texels);
            let solid_angles = SolidAngles::new(Grid::new(Mapping::LatLong, width, height));
            for (i, even) in even_light(&map, &solid_angles).into_iter().enumerate() {
                let (x, y) = (i % width, i / width);
                let expected = least(map.texel(x, y), around(&map, &solid_angles, x, y));
                assert!((even.g - expected.g).abs() < 1e-6, "{width} x {height}, ({x}, {y}): {even:?}, {expected:?}");
            }
        }
    }
}
