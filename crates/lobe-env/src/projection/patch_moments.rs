//! Projection of maps on planes: cubes and octahedra, patch by patch through moments.
//!
//! On a face of a cube or of an octahedron a direction is `p/|p|` with `p` linear in the point `(a, b)` of the picture, and
//! `dΩ = da db/|p|³`. So the integrand `G_lm = y_lm(p/|p|)/|p|³` is analytic there, and within a cell of the face nearly
//! its polynomial through P x P Gauss-Legendre nodes. With the Lagrange polynomials `l_J` of the nodes
//!
//! ```text
//!   ∫_cell L G_lm da db  ≈  Σ_JK G_lm(a_J, b_K) m_JK        m_JK = Σ_y B_K(y) Σ_x A_J(x) L(x, y)
//!   A_J(x) = ∫_column l_J(a) da = (w_J/2) Σ_k P_k(a_J) [P_{k+1}(a) - P_{k-1}(a)]        B_K likewise
//! ```
//!
//! (`P_k` Legendre polynomials, `w_J` the weight of the node, in the coordinate `[-1, 1]` of the cell.) The moments
//! separate: `O(w h P)`, and the basis is evaluated at the nodes alone, however many texels there are.

use std::ops::Range;

use lobe_io::parallel;
use lobe_sh::simd::{Kernel, Machine};
use lobe_sh::vector::{Vec3, add_scaled, dot};
use lobe_sh::{Basis, Coefficient, Rgb, coefficient_count, gauss_legendre};
use pulp::Simd;

use crate::mapping::cube::{self, FACES};
use crate::projection::table_sums::{CHANNELS, PlainSums, TableSums, WideSums, widen};
use crate::{MappedMap, Mapping};

/// A part of the picture in which directions are one analytic function: `p = origin + a right + b down`, with `a` and `b`
/// in `[-1, 1]` over the whole rectangle of the face in the picture.
struct Patch {
    origin: Vec3,
    right: Vec3,
    down: Vec3,
    /// The columns and rows of the picture that `[-1, 1]²` spans.
    frame: [Range<usize>; 2],
    /// The columns and rows of whole texels of which the patch has some.
    texels: [Range<usize>; 2],
    /// The half of an octahedron that it belongs to; the other one has the texels across the diagonal.
    half: Option<Half>,
}

#[derive(Clone, Copy, PartialEq)]
enum Half {
    Upper,
    Lower,
}

/// The way in which a map is cut up.
pub(crate) struct Patches {
    patches: Vec<Patch>,
    /// Cells along the side of a patch.
    cells: usize,
    /// Nodes along the side of a cell.
    nodes: usize,
}

// A function of band l over an interval of the angle h behaves like cos(l t), |t| <= h/2, at worst. Interpolation at P
// Gauss nodes has an error of about (l h/4)^P/P!: 1e-13 for P = 16 where l h/4 <= 1, and for P = 32 where l h/4 <= 5. The
// poles of 1/|p| lie farther than four times half a cell's side off a cell with four cells a side: error 7^-16.

/// Nodes of a cell at low orders, and the largest `l h/4` that they serve.
const FEW: (usize, f64) = (16, 1.0);
/// The same at high orders.
const MANY: (usize, f64) = (32, 5.0);
/// The highest order with few nodes.
const LOW_ORDER: usize = 16;
const _: () = assert!(FEW.0.is_multiple_of(TOGETHER) && MANY.0.is_multiple_of(TOGETHER), "nodes are taken in fours");
/// The least number of cells along a patch.
const LEAST_CELLS: usize = 4;
/// The angle that a side of a patch spans at most, at the rate of its middle: 2 for a face of a cube, and √6 for half a
/// side of an octahedral picture.
const LONGEST_SIDE: f64 = 2.45;

impl Patches {
    /// For a map of planes; `None` for other mappings.
    pub(crate) fn new(map: &MappedMap, order: usize) -> Option<Self> {
        let (width, height) = (map.width(), map.height());
        let patches: Vec<Patch> = match map.mapping() {
            Mapping::Cube => (0..FACES).map(|face| face_patch(face, width)).collect(),
            Mapping::Octahedral => (0..8).filter_map(|k| octant_patch(k, width, height)).collect(),
            _ => return None,
        };
        let (nodes, phase) = if order <= LOW_ORDER { FEW } else { MANY };
        let cells = ((order as f64 * LONGEST_SIDE / 4.0 / phase).ceil() as usize).next_power_of_two().max(LEAST_CELLS);
        Some(Self { patches, cells, nodes })
    }

    /// The number of directions in which the basis is evaluated.
    pub(crate) fn evaluations(&self) -> usize {
        self.patches.len() * (self.cells * self.nodes).pow(2)
    }

    /// Whether texel `(x, y)` is in a patch; a fold cuts the others.
    pub(crate) fn hold(map: &MappedMap, x: usize, y: usize) -> bool {
        map.mapping() == Mapping::Cube || {
            let is_cut = |i: usize, n: usize| 2 * i + 1 == n;
            !is_cut(x, map.width()) && !is_cut(y, map.height()) && half_of(map.width(), map.height(), x, y).is_some()
        }
    }

    /// The parts of the expansion, in a fixed order.
    pub(crate) fn project(&self, map: &MappedMap, order: usize) -> Vec<Vec<Rgb<f64>>> {
        let rule = gauss_legendre(self.nodes);
        let basis = Basis::<f64>::new(order);
        // Few are different: those of both axes of all faces of a cube are one.
        let mut spans: Vec<Span> = self.patches.iter().flat_map(|patch| [patch.span(0), patch.span(1)]).collect();
        spans.sort_unstable();
        spans.dedup();
        let integrals = parallel::map(spans.len() * self.cells, &|task| {
            spans[task / self.cells].integrals(task % self.cells, self.cells, &rule)
        });
        let cell = |patch: &Patch, axis: usize, k: usize| {
            let span = spans.binary_search(&patch.span(axis)).unwrap_or_else(|_| unreachable!("every span is there"));
            patch.cell(axis, k, self.cells, &rule, &integrals[span * self.cells + k])
        };
        // A task for each row of cells of each patch.
        parallel::map(self.patches.len() * self.cells, &|task| {
            let (k, row) = (task / self.cells, task % self.cells);
            let patch = &self.patches[k];
            let row = cell(patch, 1, row);
            let columns: Vec<Cell<'_>> = (0..self.cells).map(|column| cell(patch, 0, column)).collect();
            let moments =
                Machine::detect().run(Moments { patch, map, columns: &columns, row: &row, nodes: self.nodes });
            let mut part = vec![Rgb::ZERO; coefficient_count(order)];
            let mut values = vec![0.0; coefficient_count(order)];
            for (column, moments) in columns.iter().zip(moments.chunks_exact(self.nodes * self.nodes)) {
                for (i, moment) in moments.iter().copied().map(Rgb::from).enumerate() {
                    let p = patch.point(column.nodes[i % self.nodes], row.nodes[i / self.nodes]);
                    let scale = dot(p, p).sqrt().recip();
                    basis.eval_into(p.map(|c| c * scale), &mut values);
                    let moment = moment.scale(scale.powi(3));
                    for (f, value) in part.iter_mut().zip(&values) {
                        *f += moment.scale(*value);
                    }
                }
            }
            part
        })
    }
}

/// The texels of a cell in one direction.
struct Cell<'a> {
    texels: Range<usize>,
    /// For each node, the integrals of its Lagrange polynomial over the texels.
    integrals: &'a [f64],
    /// The coordinates of the nodes on the patch.
    nodes: Vec<f64>,
}

impl Patch {
    fn point(&self, a: f64, b: f64) -> Vec3 {
        add_scaled(add_scaled(self.origin, self.right, a), self.down, b)
    }

    fn span(&self, axis: usize) -> Span {
        let (frame, texels) = (&self.frame[axis], &self.texels[axis]);
        Span { frame: frame.len(), start: texels.start - frame.start, len: texels.len() }
    }

    /// Cell `k` of `cells` along an axis, whose integrals are given.
    fn cell<'a>(&self, axis: usize, k: usize, cells: usize, rule: &[(f64, f64)], integrals: &'a [f64]) -> Cell<'a> {
        let (frame, texels) = (&self.frame[axis], &self.texels[axis]);
        let [middle, half] = middle_and_half(texels, k, cells);
        let first = (middle - half) as usize;
        // From edges of texels to [-1, 1] of the frame.
        let to_frame = 2.0 / frame.len() as f64;
        let nodes = rule.iter().map(|(x, _)| (middle + half * x - frame.start as f64) * to_frame - 1.0).collect();
        Cell { texels: first..first + integrals.len() / rule.len(), integrals, nodes }
    }

    /// The columns of the texels of a row that lie in the patch as a whole.
    fn columns_in(&self, map: &MappedMap, y: usize) -> Range<usize> {
        let Range { start, end } = self.texels[0].clone();
        if self.half.is_none() {
            return start..end;
        }
        let is_in = |x: &usize| half_of(map.width(), map.height(), *x, y) == self.half;
        // Each half has one run of them.
        let first = (start..end).find(is_in).unwrap_or(end);
        first..(first..end).find(|x| !is_in(x)).unwrap_or(end)
    }
}

/// The texels of a patch along an axis, from the start of its frame, and the length of that.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Span {
    frame: usize,
    start: usize,
    len: usize,
}

impl Span {
    /// For each node of cell `k` of `cells`, the integrals of its Lagrange polynomial over the texels.
    fn integrals(&self, k: usize, cells: usize, rule: &[(f64, f64)]) -> Vec<f64> {
        let [middle, half] = middle_and_half(&(self.start..self.start + self.len), k, cells);
        let (start, end) = (middle - half, middle + half);
        let first = start as usize;
        let count = if half > 0.0 { end.ceil() as usize - first } else { 0 };
        let scale = half * 2.0 / self.frame as f64;
        let at = |edge: usize| legendre_integrals(((edge as f64).clamp(start, end) - middle) / half, rule.len());
        let at_nodes: Vec<Vec<f64>> = rule.iter().map(|(x, _)| legendre(*x, rule.len())).collect();
        let mut integrals = vec![0.0; rule.len() * count];
        let mut from = at(first);
        for i in 0..count {
            let to = at(first + i + 1);
            let over: Vec<f64> = from.iter().zip(&to).map(|(from, to)| to - from).collect();
            for (j, (values, (_, weight))) in at_nodes.iter().zip(rule).enumerate() {
                let sum: f64 = values.iter().zip(&over).map(|(value, over)| value * over).sum();
                integrals[j * count + i] = 0.5 * weight * sum * scale;
            }
            from = to;
        }
        integrals
    }
}

/// The middle and half the length of cell `k` of `cells` of some texels, in texels.
fn middle_and_half(texels: &Range<usize>, k: usize, cells: usize) -> [f64; 2] {
    let edge = |k: usize| texels.start as f64 + (texels.len() * k) as f64 / cells as f64;
    [0.5 * (edge(k) + edge(k + 1)), 0.5 * (edge(k + 1) - edge(k))]
}

/// A face of a cube.
fn face_patch(face: usize, size: usize) -> Patch {
    let origin = cube::dir_from_face(face, 0.5, 0.5).to_array();
    let to_edge = |s: f64, t: f64| {
        let p = cube::dir_from_face(face, s, t).to_array();
        let scale = dot(p, origin).recip();
        add_scaled(p.map(|c| c * scale), origin, -1.0)
    };
    let rows = face * size..(face + 1) * size;
    let frame = [0..size, rows];
    Patch { origin, right: to_edge(1.0, 0.5), down: to_edge(0.5, 1.0), texels: frame.clone(), frame, half: None }
}

/// The part of a face of an octahedron, by the bits of `k`: right, lower in the picture, lower half of the sphere.
fn octant_patch(k: usize, width: usize, height: usize) -> Option<Patch> {
    let sign = |bit: usize| if k & bit == 0 { -1.0 } else { 1.0 };
    let (sa, sb) = (sign(1), sign(2));
    let side = |n: usize, sign: f64| if sign < 0.0 { 0..n / 2 } else { n.div_ceil(2)..n };
    let texels = [side(width, sa), side(height, sb)];
    let (origin, right, down, half) = if k & 4 == 0 {
        ([0.0, 0.0, 1.0], [1.0, 0.0, -sa], [0.0, 1.0, -sb], Half::Upper)
    } else {
        ([sa, sb, 1.0], [0.0, -sa * sb, -sa], [-sa * sb, 0.0, -sb], Half::Lower)
    };
    let is_empty = texels.iter().any(Range::is_empty);
    (!is_empty).then_some(Patch { origin, right, down, frame: [0..width, 0..height], texels, half: Some(half) })
}

/// The half of the octahedron in which a texel lies as a whole: `|a| + |b| <= 1` is the upper one.
fn half_of(width: usize, height: usize, x: usize, y: usize) -> Option<Half> {
    let edges = |i: usize, n: usize| {
        let (p, q) = ((2 * i).abs_diff(n) as u128, (2 * i + 2).abs_diff(n) as u128);
        (p.min(q), p.max(q))
    };
    let ((a0, a1), (b0, b1)) = (edges(x, width), edges(y, height));
    let (w, h) = (width as u128, height as u128);
    if a1 * h + b1 * w <= w * h {
        return Some(Half::Upper);
    }
    (a0 * h + b0 * w >= w * h).then_some(Half::Lower)
}

/// `P_0(t)` to `P_{n-1}(t)`.
fn legendre(t: f64, n: usize) -> Vec<f64> {
    let mut values = vec![1.0, t];
    for k in 1..n {
        values.push(((2 * k + 1) as f64 * t * values[k] - k as f64 * values[k - 1]) / (k + 1) as f64);
    }
    values.truncate(n);
    values
}

/// `(2k + 1) ∫ P_k dt = P_{k+1}(t) - P_{k-1}(t)` for `k < n`, with `P_{-1} = 0`.
fn legendre_integrals(t: f64, n: usize) -> Vec<f64> {
    let values = legendre(t, n + 1);
    (0..n).map(|k| values[k + 1] - if k > 0 { values[k - 1] } else { 0.0 }).collect()
}

/// The moments of the cells of one row, each `nodes x nodes`, columns first, of red, green and blue.
struct Moments<'a> {
    patch: &'a Patch,
    map: &'a MappedMap,
    columns: &'a [Cell<'a>],
    row: &'a Cell<'a>,
    nodes: usize,
}

/// Nodes whose sums share the loads of the texels.
const TOGETHER: usize = 4;

impl Moments<'_> {
    #[inline(always)]
    fn by<F: TableSums>(&self, arithmetic: F) -> Vec<[f64; CHANNELS]> {
        let nodes = self.nodes;
        let mut moments = vec![[0.0; CHANNELS]; self.columns.len() * nodes * nodes];
        let count = self.row.texels.len();
        let mut planes = [(); CHANNELS].map(|()| Vec::new());
        let mut sums = vec![[0.0; CHANNELS]; nodes];
        for (i, y) in self.row.texels.clone().enumerate() {
            let inside = self.patch.columns_in(self.map, y);
            for (cell, moments) in self.columns.iter().zip(moments.chunks_exact_mut(nodes * nodes)) {
                let part = cell.texels.start.max(inside.start)..cell.texels.end.min(inside.end);
                if part.is_empty() {
                    continue;
                }
                widen(&self.map.row(y)[part.clone()], &mut planes);
                let [r, g, b] = &planes;
                let table =
                    |j: usize| &cell.integrals[j * cell.texels.len() + part.start - cell.texels.start..][..part.len()];
                for (first, sums) in (0..nodes).step_by(TOGETHER).zip(sums.chunks_exact_mut(TOGETHER)) {
                    let tables = [table(first), table(first + 1), table(first + 2), table(first + 3)];
                    sums.copy_from_slice(&arithmetic.sums(tables, [r, g, b]));
                }
                for (k, moments) in moments.chunks_exact_mut(nodes).enumerate() {
                    let integral = self.row.integrals[k * count + i];
                    arithmetic.add_scaled(moments.as_flattened_mut(), [sums.as_flattened()], [integral]);
                }
            }
        }
        moments
    }
}

impl Kernel for Moments<'_> {
    type Output = Vec<[f64; CHANNELS]>;

    #[inline(always)]
    fn wide<S: Simd>(self, simd: S) -> Self::Output {
        self.by(WideSums(simd))
    }

    fn plain(self) -> Self::Output {
        self.by(PlainSums)
    }
}
