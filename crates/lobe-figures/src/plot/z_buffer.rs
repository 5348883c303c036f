//! A z-buffer: the triangle that is seen at each sample of a picture.

use lobe_sh::sphere::vector::Vec3;

/// The visible surface at a sample: a triangle and the weights of its corners.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hit {
    pub(crate) triangle: usize,
    pub(crate) weights: Vec3,
}

/// The numbers of the triangles that may cover samples of each band of `rows` rows of a picture, ascending.
///
/// `corners` are the vertices as `(x, y, towards the eye)`, `x` and `y` in samples from the top left; samples lie at
/// +½. Triangles without area, or with a corner that is not finite, are left out.
pub(crate) fn by_band(corners: &[Vec3], triangles: &[[usize; 3]], rows: usize, bands: usize) -> Vec<Vec<usize>> {
    let mut found = vec![Vec::new(); bands];
    for (triangle, &[a, b, c]) in triangles.iter().enumerate() {
        let [a, b, c] = [corners[a], corners[b], corners[c]];
        let double_area = Side::between(a, b).of_point(c[0], c[1]);
        let covered = samples(a[1], b[1], c[1], rows * bands);
        if double_area != 0.0 && double_area.is_finite() && !covered.is_empty() {
            for band in &mut found[covered.start / rows..=(covered.end - 1) / rows] {
                band.push(triangle);
            }
        }
    }
    found
}

/// Finds the front-most triangle at every sample of the rows `first_row .. first_row + rows`, among `of_band`, those
/// that may cover some of them. Of triangles at equal depth, the first is kept.
pub(crate) fn visible(
    corners: &[Vec3],
    triangles: &[[usize; 3]],
    of_band: &[usize],
    width: usize,
    first_row: usize,
    rows: usize,
) -> Vec<Option<Hit>> {
    let mut depths = vec![f64::NEG_INFINITY; width * rows];
    let mut hits = vec![None; width * rows];
    for &triangle in of_band {
        let [a, b, c] = triangles[triangle];
        let [a, b, c] = [corners[a], corners[b], corners[c]];
        let (side_a, side_b, side_c) = (Side::between(b, c), Side::between(c, a), Side::between(a, b));
        let double_area = side_c.of_point(c[0], c[1]);
        // Visit the samples of the bounding box.
        let (xs, ys) = (samples(a[0], b[0], c[0], width), samples(a[1], b[1], c[1], first_row + rows));
        for y in ys.start.max(first_row)..ys.end {
            let py = y as f64 + 0.5;
            let (row_a, row_b, row_c) = (side_a.in_row(py), side_b.in_row(py), side_c.in_row(py));
            let start = (y - first_row) * width;
            for x in xs.clone() {
                // Interpolate the depth by the barycentric weights, and keep the nearest hit.
                let px = x as f64 + 0.5;
                let weight_a = side_a.at(row_a, px) / double_area;
                let weight_b = side_b.at(row_b, px) / double_area;
                let weight_c = side_c.at(row_c, px) / double_area;
                let depth = weight_a * a[2] + weight_b * b[2] + weight_c * c[2];
                if weight_a >= 0.0 && weight_b >= 0.0 && weight_c >= 0.0 && depth > depths[start + x] {
                    depths[start + x] = depth;
                    hits[start + x] = Some(Hit { triangle, weights: [weight_a, weight_b, weight_c] });
                }
            }
        }
    }
    hits
}

/// A side of a triangle in the picture.
#[derive(Clone, Copy)]
struct Side {
    start: Vec3,
    x: f64,
    y: f64,
}

impl Side {
    fn between(a: Vec3, b: Vec3) -> Self {
        Self { start: a, x: b[0] - a[0], y: b[1] - a[1] }
    }

    /// Twice the signed area of the triangle of this side and the point.
    fn of_point(self, x: f64, y: f64) -> f64 {
        self.at(self.in_row(y), x)
    }

    /// The part of [`Side::of_point`] that the points of a row share.
    fn in_row(self, y: f64) -> f64 {
        self.x * (y - self.start[1])
    }

    /// [`Side::of_point`] in a row.
    fn at(self, in_row: f64, x: f64) -> f64 {
        in_row - self.y * (x - self.start[0])
    }
}

/// The samples between the smallest and the largest of three coordinates, of which there are `end`.
fn samples(a: f64, b: f64, c: f64, end: usize) -> std::ops::Range<usize> {
    let (low, high) = (a.min(b).min(c), a.max(b).max(c));
    // A negative number becomes 0.
    let (low, high) = ((low - 0.5).ceil() as usize, (high + 0.5).floor() as usize);
    low..high.min(end)
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
        let hits = visible(&corners(), &TRIANGLES, &by_band(&corners(), &TRIANGLES, 8, 1)[0], 8, 0, 8);
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
    fn each_band_has_the_triangles_that_reach_into_it() {
        let mut corners = corners();
        let above = corners.len();
        corners.extend([[0.0, -9.0, 0.0], [4.0, -9.0, 0.0], [0.0, -2.0, 0.0]]);
        corners.extend([[0.0, 19.0, 0.0], [4.0, 19.0, 0.0], [0.0, 15.0, 0.0], [0.0, f64::NAN, 0.0]]);
        let [below, nan] = [above + 3, above + 6];
        let hidden = [[above, above + 1, above + 2], [below, below + 1, below + 2], [0, 1, nan], [0, 3, 0]];
        let triangles = [&TRIANGLES[..], &hidden].concat();
        // The last band is longer than the picture, as that of a picture whose height is no multiple.
        assert_eq!(by_band(&corners, &triangles, 5, 2), [vec![0, 1, 2], vec![0, 1]], "bands of five rows");
    }

    #[test]
    fn bands_of_rows_give_the_same_as_all_at_once() {
        let seen = |bands: usize| -> Vec<_> {
            let rows = 9_usize.div_ceil(bands);
            let of_bands = by_band(&corners(), &TRIANGLES, rows, bands).into_iter().enumerate();
            let hits = of_bands.flat_map(|(band, of_band)| {
                let first = band * rows;
                visible(&corners(), &TRIANGLES, &of_band, 9, first, rows.min(9 - first))
            });
            hits.map(|hit| hit.map(|hit| hit.triangle)).collect()
        };
        let (whole, bands, uneven) = (seen(1), seen(3), seen(2));
        assert_eq!(whole, uneven, "bands of five and four rows");
        assert!(whole.iter().any(Option::is_some), "something is seen");
        assert_eq!(whole, bands, "three bands of three rows");
    }
}
