//! A z-buffer: the triangle that is seen at each sample of a picture.

use lobe_sh::vector::Vec3;

/// The visible surface at a sample: a triangle and the weights of its corners.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hit {
    pub(crate) triangle: usize,
    pub(crate) weights: Vec3,
}

/// Finds the front-most triangle at every sample of the rows `first_row .. first_row + rows`.
///
/// `corners` are the vertices as `(x, y, towards the eye)`, `x` and `y` in samples from the top left; samples lie at
/// +½. Of triangles at equal depth, the first is kept. Triangles with a corner that is not finite are left out.
pub(crate) fn visible(
    corners: &[Vec3],
    triangles: &[[usize; 3]],
    width: usize,
    first_row: usize,
    rows: usize,
) -> Vec<Option<Hit>> {
    let mut depths = vec![f64::NEG_INFINITY; width * rows];
    let mut hits = vec![None; width * rows];
    for (triangle, &abc) in triangles.iter().enumerate() {
        let [a, b, c] = abc.map(|i| corners[i]);
        // Leave out triangles without area, with corners that are not finite, or outside of the rows.
        let double_area = edge(a, b, c);
        let y_range = samples([a[1], b[1], c[1]], first_row, first_row + rows);
        if double_area == 0.0 || !double_area.is_finite() || y_range.is_empty() {
            continue;
        }
        // Visit the samples of the bounding box.
        let x_range = samples([a[0], b[0], c[0]], 0, width);
        for y in y_range {
            for x in x_range.clone() {
                let p = [x as f64 + 0.5, y as f64 + 0.5, 0.0];
                // Interpolate the depth by the barycentric weights, and keep the nearest hit.
                let weights = [edge(b, c, p), edge(c, a, p), edge(a, b, p)].map(|e| e / double_area);
                let depth = weights[0] * a[2] + weights[1] * b[2] + weights[2] * c[2];
                let i = (y - first_row) * width + x;
                if weights.iter().all(|w| *w >= 0.0) && depth > depths[i] {
                    depths[i] = depth;
                    hits[i] = Some(Hit { triangle, weights });
                }
            }
        }
    }
    hits
}

/// Twice the signed area of the triangle `a b c` in the picture.
fn edge(a: Vec3, b: Vec3, c: Vec3) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// The samples between the smallest and the largest of three coordinates, within `first..end`.
fn samples(corners: [f64; 3], first: usize, end: usize) -> std::ops::Range<usize> {
    let low = corners.into_iter().fold(f64::INFINITY, f64::min);
    let high = corners.into_iter().fold(f64::NEG_INFINITY, f64::max);
    // A negative number becomes 0.
    let (low, high) = ((low - 0.5).ceil() as usize, ((high + 0.5).floor().max(0.0)) as usize);
    low.max(first)..high.min(end)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRIANGLES: [[usize; 3]; 3] = [[0, 1, 2], [1, 3, 2], [4, 5, 6]];

    fn corners() -> Vec<Vec3> {
        let square = [[0.0, 0.0, 0.0], [8.0, 0.0, 0.0], [0.0, 8.0, 0.0], [8.0, 8.0, 0.0]];
        let small = [[-3.0, 0.0, 1.0], [5.0, 0.0, 1.0], [1.0, 4.0, 1.0]];
        [&square[..], &small].concat()
    }

    #[test]
    fn a_square_of_two_triangles_has_no_gap_and_the_nearer_triangle_hides_it() {
        let hits = visible(&corners(), &TRIANGLES, 8, 0, 8);
        for y in 0..8 {
            for x in 0..8 {
                let (px, py) = (x as f64 + 0.5, y as f64 + 0.5);
                let inside_small = py < 4.0 && px >= py - 3.0 && px <= 5.0 - py;
                let expected = if inside_small {
                    2
                } else if px + py <= 8.0 {
                    0
                } else {
                    1
                };
                let found = hits[y * 8 + x].map(|hit| hit.triangle);
                assert_eq!(found, Some(expected), "sample ({x}, {y})");
            }
        }
    }

    #[test]
    fn bands_of_rows_give_the_same_as_all_at_once() {
        let whole: Vec<_> = visible(&corners(), &TRIANGLES, 9, 0, 9).iter().map(|h| h.map(|h| h.triangle)).collect();
        let bands: Vec<_> = (0..3)
            .flat_map(|band| visible(&corners(), &TRIANGLES, 9, 3 * band, 3))
            .map(|h| h.map(|h| h.triangle))
            .collect();
        assert_eq!(whole, bands, "three bands of three rows");
    }
}
