//! Relative brightness of the cells of a map, in octaves.

use lobe_io::parallel;
use lobe_sh::Rgb;

use crate::map::cube_map::CubeMap;
use crate::mapping::cube::FACES;
use crate::prefilter::cell_tree::{children_of, place};

// The error left by a bright lamp spreads over dark parts of a filtered map too. For it not to show there, a cell a
// hundred times as bright as the dark ones needs about a hundredth of the tolerance.

/// Cells up to this many times as bright as the median are no lamps. With 4, a third more points are evaluated in the
/// bundled sunset, and nothing gets more accurate.
const LAMP: f64 = 16.0;

/// The number of octaves, at most: 16 · 2¹⁶ is a million, beyond which single precision ends.
const MOST_STEPS: usize = 17;

/// The divisor of the tolerance in a step: half of the greatest brightness in it, or 1 in step 0. With a quarter,
/// errors of 3 % of dark texels' values remain beside the lamps of the bundled studio.
pub(crate) fn of_step(step: usize) -> f64 {
    if step == 0 { 1.0 } else { 0.5 * LAMP * (step as f64).exp2() }
}

/// The step of every cell of a cube map, down to some depth; see
/// [`CellTree`](crate::prefilter::cell_tree::CellTree).
pub(crate) struct Brightness {
    /// For each depth.
    cells: Vec<Vec<u8>>,
    /// The number of steps.
    steps: usize,
}

impl Brightness {
    /// Measures a source with cells down to `depth`.
    ///
    /// Brightness is the mean of the largest channel's absolute value, relative to its median over the deepest cells.
    pub(crate) fn new(source: &CubeMap, depth: usize) -> Self {
        let deepest: Vec<f64> = parallel::map(FACES << (2 * depth), &|i| mean(source, i, depth));
        let mut levels = vec![deepest];
        for k in (0..depth).rev() {
            let children = &levels[levels.len() - 1];
            let parent = |i: usize| {
                let [a, b, c, d] = children_of(i, k).map(|child| children[child]);
                0.25 * ((a + b) + (c + d))
            };
            levels.push((0..FACES << (2 * k)).map(parent).collect());
        }
        levels.reverse();
        let mut deepest = levels[depth].clone();
        deepest.sort_by(f64::total_cmp);
        let usual = deepest[deepest.len() / 2];
        let step = |brightness: &f64| {
            let steps = (brightness / (LAMP * usual)).log2().ceil();
            // Where the median is black, all light is a lamp's; NaN is in step 0.
            if steps > 0.0 { steps.min((MOST_STEPS - 1) as f64) as u8 } else { 0 }
        };
        let cells: Vec<Vec<u8>> = levels.iter().map(|level| level.iter().map(step).collect()).collect();
        let most = cells.iter().flatten().copied().max().unwrap_or(0);
        Self { cells, steps: usize::from(most) + 1 }
    }

    /// The step of cell `i` of a depth.
    pub(crate) fn step(&self, i: usize, depth: usize) -> usize {
        usize::from(self.cells[depth][i])
    }

    /// The number of steps, at least 1.
    pub(crate) fn steps(&self) -> usize {
        self.steps
    }
}

/// The mean brightness of the texels that a cell touches.
fn mean(source: &CubeMap, i: usize, depth: usize) -> f64 {
    let (face, column, row) = place(i, depth);
    let (size, cells) = (source.size(), 1 << depth);
    let range = |k: usize| k * size / cells..((k + 1) * size).div_ceil(cells);
    let brightness = |texel: &Rgb<f32>| texel.to_array().into_iter().map(|c| f64::from(c.abs())).fold(0.0, f64::max);
    let rows = range(row).map(|y| &source.face(face)[y * size..][range(column)]);
    let sum: f64 = rows.flatten().map(brightness).sum();
    sum / (range(row).len() * range(column).len()) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lamp_is_as_many_steps_up_as_it_is_brighter() {
        let (size, depth) = (32, 2);
        for (factor, expected) in [(1.0, 0), (15.9, 0), (16.1, 1), (31.9, 1), (32.1, 2), (1e12, MOST_STEPS - 1)] {
            let mut source = CubeMap::from_fn(size, |_| Rgb::new(0.3, 0.5, 0.2));
            // A whole cell of the third face.
            for (x, y) in (8..16).flat_map(|x| (24..32).map(move |y| (x, y))) {
                source.texels_mut()[(2 * size + y) * size + x] = Rgb::new(0.0, 0.0, -0.5 * factor);
            }
            let found = Brightness::new(&source, depth);
            let cell = 2 * 16 + 3 * 4 + 1;
            assert_eq!(found.step(cell, depth), expected, "{factor} times as bright");
            assert_eq!(found.steps(), expected + 1, "{factor} times as bright: the number of steps");
            assert!((0..FACES * 16).all(|i| i == cell || found.step(i, depth) == 0), "{factor}: all others are dark");
            // Its parent has four times the area.
            let parent = found.step(2 * 4 + 2, 1);
            assert!(parent <= expected && parent + 2 >= expected, "{factor}: step {parent} of the parent");
        }
    }

    #[test]
    fn light_in_the_dark_is_bright() {
        let mut source = CubeMap::from_fn(16, |_| Rgb::new(0.0, 0.0, 0.0));
        assert_eq!(Brightness::new(&source, 1).steps(), 1, "all is black");
        source.texels_mut()[5] = Rgb::new(1.0, 0.0, 0.0);
        let found = Brightness::new(&source, 1);
        assert_eq!((found.step(0, 0), found.step(1, 0)), (MOST_STEPS - 1, 0), "one texel of the first face");
    }
}
