//! Projection of maps on planes: cubes and octahedra, plane by plane through moments.
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
use lobe_sh::basis::{Basis, coefficient_count};
use lobe_sh::simd::{Kernel, Machine};
use lobe_sh::sphere::gauss_legendre;
use lobe_sh::sphere::vector::{Vec3, add_scaled, dot};
use lobe_sh::{Coefficient, Rgb};
use pulp::Simd;

use crate::map::mapped_map::MappedMap;
use crate::mapping::form::{Pair, Plane};
use crate::projection::table_sums::{CHANNELS, PlainSums, TableSums, WideSums, widen};

/// The way in which a map is cut up.
pub(crate) struct Patches {
    planes: Vec<Plane>,
    /// Cells along the side of a plane.
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
/// The least number of cells along a plane.
const LEAST_CELLS: usize = 4;
/// The angle that a side of a plane spans at most, at the rate of its middle: 2 for a face of a cube, and √6 for half a
/// side of an octahedral picture.
const LONGEST_SIDE: f64 = 2.45;

impl Patches {
    /// For a map of planes; `None` for other mappings.
    pub(crate) fn new(map: &MappedMap, order: usize) -> Option<Self> {
        let planes = map.mapping().form().planes(size_of(map));
        if planes.is_empty() {
            return None;
        }
        let (nodes, phase) = if order <= LOW_ORDER { FEW } else { MANY };
        let cells = ((order as f64 * LONGEST_SIDE / 4.0 / phase).ceil() as usize).next_power_of_two().max(LEAST_CELLS);
        Some(Self { planes, cells, nodes })
    }

    /// The number of directions in which the basis is evaluated.
    pub(crate) fn evaluations(&self) -> usize {
        self.planes.len() * (self.cells * self.nodes).pow(2)
    }

    /// Whether texel `(x, y)` is in a plane; a fold cuts the others.
    pub(crate) fn hold(map: &MappedMap, x: usize, y: usize) -> bool {
        map.mapping().form().plane_of(size_of(map), [x, y]).is_some()
    }

    /// The parts of the expansion, in a fixed order.
    pub(crate) fn project(&self, map: &MappedMap, order: usize) -> Vec<Vec<Rgb<f64>>> {
        let rule = gauss_legendre(self.nodes);
        let basis = Basis::<f64>::new(order);
        // Few are different: those of both axes of all faces of a cube are one.
        let mut spans: Vec<Span> = self.planes.iter().flat_map(|plane| [span(plane, 0), span(plane, 1)]).collect();
        spans.sort_unstable();
        spans.dedup();
        let integrals = parallel::map(spans.len() * self.cells, &|task| {
            spans[task / self.cells].integrals(task % self.cells, self.cells, &rule)
        });
        let cell = |plane: &Plane, axis: usize, k: usize| {
            let span = spans.binary_search(&span(plane, axis)).unwrap_or_else(|_| unreachable!("every span is there"));
            cell_of(plane, axis, [k, self.cells], &rule, &integrals[span * self.cells + k])
        };
        // A task for each row of cells of each plane.
        parallel::map(self.planes.len() * self.cells, &|task| {
            let (k, row) = (task / self.cells, task % self.cells);
            let plane = &self.planes[k];
            let row = cell(plane, 1, row);
            let columns: Vec<Cell<'_>> = (0..self.cells).map(|column| cell(plane, 0, column)).collect();
            let moments =
                Machine::detect().run(Moments { plane, map, columns: &columns, row: &row, nodes: self.nodes });
            let mut part = vec![Rgb::ZERO; coefficient_count(order)];
            let mut values = vec![0.0; coefficient_count(order)];
            for (column, moments) in columns.iter().zip(moments.chunks_exact(self.nodes * self.nodes)) {
                for (i, moment) in moments.iter().copied().map(Rgb::from).enumerate() {
                    let p = point_of(plane, column.nodes[i % self.nodes], row.nodes[i / self.nodes]);
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
    /// The coordinates of the nodes on the plane.
    nodes: Vec<f64>,
}

fn size_of(map: &MappedMap) -> Pair {
    [map.width(), map.height()]
}

fn point_of(plane: &Plane, a: f64, b: f64) -> Vec3 {
    add_scaled(add_scaled(plane.origin, plane.right, a), plane.down, b)
}

fn span(plane: &Plane, axis: usize) -> Span {
    let (frame, texels) = (&plane.frame[axis], &plane.texels[axis]);
    Span { frame: frame.len(), start: texels.start - frame.start, len: texels.len() }
}

/// Cell `k` of `cells` along an axis of a plane, whose integrals are given.
fn cell_of<'a>(
    plane: &Plane,
    axis: usize,
    [k, cells]: [usize; 2],
    rule: &[(f64, f64)],
    integrals: &'a [f64],
) -> Cell<'a> {
    let (frame, texels) = (&plane.frame[axis], &plane.texels[axis]);
    let [middle, half] = middle_and_half(texels, k, cells);
    let first = (middle - half) as usize;
    // From edges of texels to [-1, 1] of the frame.
    let to_frame = 2.0 / frame.len() as f64;
    let nodes = rule.iter().map(|(x, _)| (middle + half * x - frame.start as f64) * to_frame - 1.0).collect();
    Cell { texels: first..first + integrals.len() / rule.len(), integrals, nodes }
}

/// The columns of the texels of a row that lie in a plane as a whole: one run.
fn columns_in(plane: &Plane, map: &MappedMap, y: usize) -> Range<usize> {
    let Range { start, end } = plane.texels[0].clone();
    let is_in = |x: &usize| map.mapping().form().plane_of(size_of(map), [*x, y]) == Some(plane.number);
    if is_in(&start) && is_in(&(end - 1)) {
        return start..end;
    }
    let first = (start..end).find(is_in).unwrap_or(end);
    first..(first..end).find(|x| !is_in(x)).unwrap_or(end)
}

/// The texels of a plane along an axis, from the start of its frame, and the length of that.
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
    plane: &'a Plane,
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
            let inside = columns_in(self.plane, self.map, y);
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
