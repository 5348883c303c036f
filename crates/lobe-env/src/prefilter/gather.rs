//! Zonal filtering of a cube map by hierarchical quadrature, to a given tolerance.

use std::f64::consts::PI;

use lobe_io::parallel;
#[cfg(target_arch = "x86_64")]
use lobe_sh::simd::Machine;
use lobe_sh::sphere::gauss_legendre;
use lobe_sh::{Coefficient, Dir, Rgb};

use crate::map::cube_map::CubeMap;
use crate::mapping::cube::{self, FACES};
use crate::prefilter::brightness::Brightness;
use crate::prefilter::cell_tolerance::{CellTolerance, class_of};
use crate::prefilter::cell_tree::{CellTree, NODES, PLANES, Piece, children_of, extent, place};
use crate::reflection::specular_lobe::{Kernel, integral};

/// Points summed side by side: a register of AVX.
const LANES: usize = 8;

/// Points processed together: those of a cell. All weights first, then one sum at a time: with several at once the
/// compiler runs out of registers.
const TOGETHER: usize = NODES;

/// A lobe whose solid angle is at most this fraction of a texel's is treated as a mirror: it resolves only the steps
/// between texels.
const MIRROR: f64 = 1.0 / 16.0;

/// A source and a kernel, ready to be convolved.
///
/// ```text
///   g(r) = Σ w K(|p - r|²/2) L / Σ w K(|p - r|²/2)
/// ```
///
/// The sum runs over the nodes of a cut through the tree of cells: large cells where the kernel is flat, small cells
/// where it is steep, texels where no cell is accurate enough. The source is piecewise constant over texels. Both sums
/// go through the same operations, so a map of 1 stays exactly 1.
pub(crate) struct ZonalFilter<'a, K> {
    tree: &'a CellTree<'a>,
    kernel: K,
    cells: CellTolerance,
    brightness: &'a Brightness,
    /// Gauss-Legendre rules by their number of points.
    rules: Vec<Vec<(f64, f64)>>,
    depth: usize,
    shapes: &'a [Vec<Shape>],
}

/// Center and extent of a cell.
pub(crate) struct Shape {
    middle: Dir,
    radius: f64,
    class: usize,
}

/// The shapes of all cells down to a depth.
pub(crate) fn shapes(depth: usize) -> Vec<Vec<Shape>> {
    let shape = |i: usize, k: usize| {
        let (middle, side) = extent(i, k);
        let (face, column, row) = place(i, k);
        let cells = (1_usize << k) as f64;
        let corner = |dx: usize, dy: usize| {
            cube::dir_from_face(face, (column + dx) as f64 / cells, (row + dy) as f64 / cells).angle_to(middle)
        };
        let radius = corner(0, 0).max(corner(0, 1)).max(corner(1, 0)).max(corner(1, 1));
        Shape { middle, radius, class: class_of(side) }
    };
    (0..=depth).map(|k| (0..FACES << (2 * k)).map(|i| shape(i, k)).collect()).collect()
}

/// Points and their light, plane after plane.
#[derive(Default)]
struct Points {
    planes: [Vec<f32>; PLANES],
}

impl<'a, K: Kernel> ZonalFilter<'a, K> {
    pub(crate) fn new(
        tree: &'a CellTree<'a>,
        shapes: &'a [Vec<Shape>],
        brightness: &'a Brightness,
        kernel: K,
        cells: CellTolerance,
    ) -> Self {
        let depth = cells.depth_needed(brightness.steps(), tree.depth());
        let rules =
            (0..=CellTolerance::MOST_POINTS).map(|n| if n == 0 { Vec::new() } else { gauss_legendre(n) }).collect();
        Self { tree, kernel, cells, brightness, rules, depth, shapes }
    }

    /// The averages about directions that are near each other, by the widest instructions of the machine.
    pub(crate) fn towards(&self, targets: &[Dir]) -> Vec<Rgb<f32>> {
        #[cfg(target_arch = "x86_64")]
        if let Some(v3) = Machine::detect().avx2() {
            return v3.vectorize(Wide { filter: self, targets });
        }
        self.towards_by::<false>(targets)
    }

    /// [`towards`](Self::towards), with fused multiply-adds or, `FUSED` being false, without.
    #[inline(always)]
    fn towards_by<const FUSED: bool>(&self, targets: &[Dir]) -> Vec<Rgb<f32>> {
        // Bound the targets by a cone.
        let sum = targets.iter().fold([0.0; 3], |sum, r| [0, 1, 2].map(|k| sum[k] + r.to_array()[k]));
        let axis = Dir::new(sum).unwrap_or(targets[0]);
        let radius = targets.iter().map(|r| r.angle_to(axis)).fold(0.0, f64::max);
        let singles: Vec<[f32; 3]> = targets.iter().map(|r| r.to_array().map(|c| c as f32)).collect();
        let mut sums = vec![[0.0; 4]; targets.len()];
        let mut open: Vec<(usize, usize)> = (0..FACES).rev().map(|face| (0, face)).collect();
        let mut points = Points::default();
        while let Some((depth, i)) = open.pop() {
            // Bound the angles between the cell and the targets.
            let shape = &self.shapes[depth][i];
            let angle = axis.dot(shape.middle).clamp(-1.0, 1.0).acos();
            let around = |more: f64| [(angle - radius - more).max(0.0), (angle + radius + more).min(PI)];
            let step = self.brightness.step(i, depth);
            // Skip a cell whose light is negligible.
            if self.cells.is_negligible(step, around(shape.radius)) {
                continue;
            }
            // Descend while the cell is too coarse for the kernel.
            let is_good = self.cells.cell_is_good(shape.class, step, around(0.0));
            if !is_good && depth < self.depth {
                open.extend(children_of(i, depth).into_iter().rev().map(|child| (depth + 1, child)));
                continue;
            }
            // Add the nodes of the cell, or Gauss points of its texels where no cell is accurate enough.
            let count = if is_good { 1 } else { self.cells.texel_points(step, around(shape.radius)) };
            if count == 1 {
                // The nodes of the cell are no worse than one point in each of its texels, even at a kink.
                let cell = &self.tree.levels[depth][i];
                accumulate::<FUSED, K>(
                    &self.kernel,
                    &cell.each_ref().map(<[f32; NODES]>::as_slice),
                    &singles,
                    &mut sums,
                );
            } else {
                points.fill(self.tree, i, depth, &self.rules[count]);
                accumulate::<FUSED, K>(&self.kernel, &points.planes.each_ref().map(Vec::as_slice), &singles, &mut sums);
            }
        }
        // Normalize by the sum of the weights.
        sums.iter().map(|[weight, r, g, b]| Rgb::narrow(Rgb::new(r / weight, g / weight, b / weight))).collect()
    }
}

/// Compiled for AVX2 and FMA.
#[cfg(target_arch = "x86_64")]
struct Wide<'a, 'b, K> {
    filter: &'a ZonalFilter<'a, K>,
    targets: &'b [Dir],
}

#[cfg(target_arch = "x86_64")]
impl<K: Kernel> pulp::NullaryFnOnce for Wide<'_, '_, K> {
    type Output = Vec<Rgb<f32>>;

    #[inline(always)]
    fn call(self) -> Self::Output {
        self.filter.towards_by::<true>(self.targets)
    }
}

impl Points {
    /// Fills in the points of Gauss-Legendre rules over the texels of a deepest cell.
    fn fill(&mut self, tree: &CellTree<'_>, i: usize, depth: usize, rule: &[(f64, f64)]) {
        let (face, column, row) = place(i, depth);
        self.planes.iter_mut().for_each(Vec::clear);
        let size = tree.source.size();
        let at = |piece: &Piece, x: f64| {
            let [start, end] = piece.range;
            (0.5 * (start + end) + 0.5 * x * (end - start), 0.5 * (end - start))
        };
        for down in &tree.pieces[row] {
            for along in &tree.pieces[column] {
                let light = tree.source.face(face)[down.texel * size + along.texel];
                for (y, p) in rule {
                    for (x, q) in rule {
                        let ((s, width), (t, height)) = (at(along, *x), at(down, *y));
                        // du dv of the picture of six faces is a sixth of ds dt.
                        let area = p * q * width * height * cube::density(s, t / 6.0) / 6.0;
                        self.push(cube::dir_from_face(face, s, t), area, light);
                    }
                }
            }
        }
        while !self.planes[0].len().is_multiple_of(TOGETHER) {
            self.push(Dir::Z, 0.0, Rgb::ZERO);
        }
    }

    fn push(&mut self, s: Dir, area: f64, light: Rgb<f32>) {
        let [x, y, z] = s.to_array().map(|c| c as f32);
        let [r, g, b] = light.to_array().map(|c| (area * f64::from(c)) as f32);
        for (plane, value) in self.planes.iter_mut().zip([x, y, z, area as f32, r, g, b]) {
            plane.push(value);
        }
    }
}

/// Adds the points, weighted with the kernel, to the four sums of every target.
///
/// `1 - cos θ` is half the square of the chord: no digits are lost near the axis.
#[inline(always)]
fn accumulate<const FUSED: bool, K: Kernel>(
    kernel: &K,
    planes: &[&[f32]; PLANES],
    targets: &[[f32; 3]],
    sums: &mut [[f64; 4]],
) {
    // Without the instruction a fused multiply-add is a slow call: use two operations.
    let add_product = |sum: f32, a: f32, b: f32| if FUSED { a.mul_add(b, sum) } else { sum + a * b };
    let [x, y, z, rest @ ..] = planes.map(|plane| plane.as_chunks::<TOGETHER>().0);
    for (target, sums) in targets.iter().zip(sums) {
        for (i, ((x, y), z)) in x.iter().zip(y).zip(z).enumerate() {
            let mut weights = [0.0_f32; TOGETHER];
            for (k, weight) in weights.iter_mut().enumerate() {
                let (dx, dy, dz) = (x[k] - target[0], y[k] - target[1], z[k] - target[2]);
                *weight = kernel.fast(0.5 * add_product(add_product(dx * dx, dy, dy), dz, dz));
            }
            for (sum, values) in sums.iter_mut().zip(rest) {
                *sum += f64::from(dot::<FUSED>(&weights, &values[i]));
            }
        }
    }
}

/// The dot product, in lanes.
#[inline(always)]
fn dot<const FUSED: bool>(weights: &[f32; TOGETHER], values: &[f32; TOGETHER]) -> f32 {
    let mut lanes = [0.0_f32; LANES];
    for (weights, values) in weights.as_chunks::<LANES>().0.iter().zip(values.as_chunks::<LANES>().0) {
        for k in 0..LANES {
            lanes[k] = if FUSED { weights[k].mul_add(values[k], lanes[k]) } else { lanes[k] + weights[k] * values[k] };
        }
    }
    let [a, b, c, d, e, f, g, h] = lanes;
    ((a + e) + (c + g)) + ((b + f) + (d + h))
}

/// Whether a lobe is too narrow for a source of this size to tell it from a mirror.
pub(crate) fn is_mirror(kernel: &impl Kernel, size: usize) -> bool {
    let texel = 4.0 * PI / (FACES * size * size) as f64;
    // A kernel without a peak on its axis is no mirror.
    integral(kernel).abs() < MIRROR * texel * kernel.exact(0.0).abs()
}

/// The angular size of the side of the largest texel.
pub(crate) fn texel_side(source: &CubeMap) -> f64 {
    2.0 / source.size() as f64
}

/// The side of the tiles of a cube, and each tile as its face, first column and first row.
pub(crate) fn tiles(size: usize) -> (usize, Vec<[usize; 3]>) {
    // Directions that share a cut should be near each other compared with a lobe as wide as the map is small.
    let side = (size / 16).clamp(1, 8);
    let count = size.div_ceil(side);
    let tile = |i: usize| [i / (count * count), i % count * side, i / count % count * side];
    (side, (0..FACES * count * count).map(tile).collect())
}

/// The values of `towards` about the texel centers of some tiles.
pub(crate) fn filter_tiles(
    size: usize,
    side: usize,
    tiles: &[[usize; 3]],
    out: &mut [Rgb<f32>],
    towards: &(dyn Fn(&[Dir]) -> Vec<Rgb<f32>> + Sync),
) {
    let done: Vec<Vec<(usize, Rgb<f32>)>> = parallel::map(tiles.len(), &|k| {
        let [face, left, top] = tiles[k];
        let places: Vec<_> =
            (top..size.min(top + side)).flat_map(|y| (left..size.min(left + side)).map(move |x| (x, y))).collect();
        let at = |i: usize| (i as f64 + 0.5) / size as f64;
        let dirs: Vec<Dir> = places.iter().map(|&(x, y)| cube::dir_from_face(face, at(x), at(y))).collect();
        let index = places.iter().map(|&(x, y)| (face * size + y) * size + x);
        index.zip(towards(&dirs)).collect()
    });
    for (index, value) in done.into_iter().flatten() {
        out[index] = value;
    }
}
