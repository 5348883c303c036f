//! Values for the sample points inside a solid.

use crate::FieldGrid;

/// Gives the rows of points inside a solid the mean of their neighbors outside, layer by layer from the surface inwards: those
/// of representatives alone, [`FieldGrid::neighbors`]. If all points are inside there is nothing to take, and all stay as they are.
///
/// All of the sky is hidden inside a solid. Interpolated with that, receivers just outside its surface would be too dark,
/// although half of the sky may be open to them. So the field holds there what is seen from near by outside; receivers
/// inside see it too, which nobody else sees. The test `receivers_near_a_surface_are_not_darkened_by_its_inside` measures
/// the difference.
///
/// The mean is that of the scaled rows, `w(r) O` of [`FieldGrid`]: inwards what is hidden rises by `1/w`, as it does towards the surface. With the
/// mean of `O` itself receivers near the rabbit were 14.2 % off instead of 13.6 %, near the torus 5.5 % both.
pub(crate) fn fill_inside(grid: &FieldGrid, inside: &[bool], width: usize, rows: &mut [f32]) {
    let mut known: Vec<bool> = inside.iter().map(|inside| !inside).collect();
    let neighbors = grid.neighbors();
    loop {
        let mut layer: Vec<(usize, Vec<f32>)> = Vec::new();
        for point in (0..known.len()).filter(|point| !known[*point]) {
            let neighbors: Vec<usize> = neighbors[point].iter().copied().filter(|p| known[*p]).collect();
            if neighbors.is_empty() {
                continue;
            }
            let mean = |i: usize| {
                neighbors.iter().map(|p| f64::from(rows[p * width + i])).sum::<f64>() / neighbors.len() as f64
            };
            layer.push((point, (0..width).map(|i| mean(i) as f32).collect()));
        }
        if layer.is_empty() {
            return;
        }
        for (point, row) in layer {
            rows[point * width..][..width].copy_from_slice(&row);
            known[point] = true;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_outside_stays_and_what_is_inside_is_near_it() {
        let grid = FieldGrid::new([0.0; 3], 1.0, [0.25, 4.0], 5, 4).unwrap();
        let mut rows: Vec<f32> = (0..grid.points()).map(|p| 1.0 + (p / 25) as f32).collect();
        let inside: Vec<bool> = (0..grid.points()).map(|p| p / 25 < 2 || p + 1 == grid.points()).collect();
        let before = rows.clone();
        fill_inside(&grid, &inside, 1, &mut rows);
        for p in grid.representatives() {
            let expected = if inside[p] { 3.0 } else { before[p] };
            assert_eq!(rows[p], expected, "point {p}, the nearest outside are on sphere 2");
        }
        let mut all = before.clone();
        fill_inside(&grid, &vec![true; grid.points()], 1, &mut all);
        assert_eq!(all, before, "nothing to take");
    }
}
