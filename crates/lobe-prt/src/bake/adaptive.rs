//! Adaptive subdivision: triangles split where interpolated transfer is off in the middle of their edges.

use std::collections::{BTreeMap, HashSet};
use std::path::{Path, PathBuf};

use derive_setters::Setters;
use lobe_io::{Job, Progress};
use lobe_scene::{Bounds, Bvh, HalvedEdges, Mesh, Scene};

use crate::{BakeMode, BakeOptions, PrtError, Receivers, Transfer, bake, bake_on_disk};

/// The shortest edge that is split if nothing else is said, as a part of the scene's diagonal.
const SHORTEST_EDGE: f32 = 1.0 / 512.0;

/// With a limit of vertices, edges whose error is at least this part of the largest one are halved in a round: worse ones
/// that it brings to light go before the others.
const WORST: f64 = 0.5;

/// Options of [`split_adaptively`].
#[derive(Clone, Debug, PartialEq, Setters, serde::Serialize, serde::Deserialize)]
#[serde(default)]
#[non_exhaustive]
pub struct AdaptiveOptions {
    /// Edges are halved in whose middle interpolated transfer is off by more than this part of the root mean square of all
    /// transfer.
    pub threshold: f64,
    /// Edges that are shorter are left. Without a choice that is 1/512 of the diagonal of the scene's box.
    pub min_edge: Option<f32>,
    /// The most vertices of the result; the edges with the largest errors are halved first. Without a choice there is no limit.
    pub max_vertices: Option<usize>,
    /// Options of the bake that estimates transfer at each vertex. Its noise should be well below the threshold.
    pub bake: BakeOptions,
}

impl Default for AdaptiveOptions {
    /// Splits where interpolation is off by a twentieth, found by 256 paths of shadowed transfer, which are enough to see
    /// that.
    fn default() -> Self {
        let bake = BakeOptions::default().mode(BakeMode::Shadowed).samples(256);
        Self { threshold: 0.05, min_edge: None, max_vertices: None, bake }
    }
}

impl AdaptiveOptions {
    /// For a bake that follows: its options, but for reflections, which do not show where edges are off, and for the paths, as few as by default.
    #[must_use]
    pub fn before(bake: &BakeOptions) -> Self {
        let mode = if bake.mode == BakeMode::Unshadowed { BakeMode::Unshadowed } else { BakeMode::Shadowed };
        let defaults = Self::default();
        let samples = defaults.bake.samples;
        defaults.bake(bake.clone().mode(mode).samples(samples))
    }
}

/// The report of an adaptive split.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
#[non_exhaustive]
pub struct AdaptiveReport {
    /// Rounds in which middles of edges were baked.
    pub rounds: usize,
    /// Vertices at the beginning.
    pub vertices_before: usize,
    /// Vertices at the end.
    pub vertices: usize,
    /// Rays traced.
    pub rays: u64,
    /// Edges that may be off by more, being too short to be halved.
    pub too_short: usize,
    /// Edges that are off by more, which were not halved because of [`AdaptiveOptions::max_vertices`].
    pub left_out: usize,
    /// The largest error along an edge at the end, in the unit of [`AdaptiveOptions::threshold`]: no more than that, unless
    /// edges are too short or left out.
    pub largest_error: f64,
}

/// Splits a scene until transfer that is interpolated along edges is nearly right, or the edges are short.
///
/// ```text
///   an edge ab of middle m is halved if  e(ab) > t R  and  |ab| ≥ l,   R² = mean over the vertices of the given scene of ‖T‖²
///   e(ab) = ‖T_m - (T_a + T_b)/2‖
/// ```
///
/// R makes the threshold t a part of what surfaces of this scene send back at all, so that noise in dark corners splits
/// nothing. Where transfer changes evenly along an edge, however much, nothing is gained by a vertex and none is added. `T_m`
/// is baked only where `½‖T_a - T_b‖ > t R`, which e does not exceed while transfer changes one way along the edge: what comes
/// and goes between two vertices is not found, so that edges should be no longer than the shadows that matter (see
/// [`Scene::split_edges`]). Nor are the middles of triangles looked at: where normals to shade with tilt off convex
/// surfaces, a vertex loses less light below the planes around it than points within its triangles do, and a bake between
/// vertices stays brighter by a part in a hundred than the truth, which is below any useful threshold.
///
/// The rest of the scene hardly changes where edges are halved, and transfer is baked for new vertices alone. The first
/// vertices of each mesh are those it had. The bake of the result is up to the caller.
///
/// The job is told of each [round](Progress::round) anew, and of the [largest error](Progress::error) that is left. If it is [kept in a file](Job::kept_in), each round keeps
/// what it finds in a file of its own, see [`split_checkpoints`]. Splitting that was stopped, or killed at any moment,
/// continues from these files and ends with the same scene; edges are halved once more, which takes no rays. All files stay
/// locked until it ends. The caller removes them, the last one first, when the results are safe.
///
/// # Errors
/// [`PrtError::Options`] if an option is out of its range, [`PrtError::Scene`] if the scene would have more than 2²⁶
/// triangles; for the job those of [`bake()`].
pub fn split_adaptively(
    scene: &Scene,
    options: &AdaptiveOptions,
    mut job: Job<'_>,
) -> Result<(Scene, AdaptiveReport), PrtError> {
    let checkpoint = job.checkpoint().map(Path::to_path_buf);
    let mut locked = Vec::new();
    split(scene, options, &mut |(round, error), scene, receivers, options| {
        let mut watch = |progress: &Progress| job.report(&Progress { round, error, ..*progress });
        let job = Job::default().watched_by(&mut watch);
        let bvh = Bvh::new(scene);
        let Some(path) = &checkpoint else {
            let (transfer, report) = bake(scene, &bvh, receivers, options, job)?;
            return Ok((transfer, report.rays));
        };
        let job = job.kept_in(path_of_round(path, round));
        let (stored, report) = bake_on_disk(scene, &bvh, receivers, options, job)?;
        let transfer = stored.load()?;
        locked.push(stored);
        Ok((transfer, report.rays))
    })
}

/// The files in which the rounds of a split that is kept in `checkpoint` keep what they find, as far as they are there: its
/// name with `.split-0` appended, and so on. They are made in this order; where they are removed in the reverse one, there are
/// no gaps.
#[must_use]
pub fn split_checkpoints(checkpoint: impl AsRef<Path>) -> Vec<PathBuf> {
    let path = |round| path_of_round(checkpoint.as_ref(), round);
    (0..).map(path).take_while(|path| path.exists()).collect()
}

/// The checkpoint of a round of a split that is kept in a file.
fn path_of_round(checkpoint: &Path, round: usize) -> PathBuf {
    let mut name = checkpoint.to_path_buf().into_os_string();
    name.push(format!(".split-{round}"));
    name.into()
}

/// The transfer of some receivers, and the number of rays traced for it.
type Round = Result<(Transfer, u64), PrtError>;

/// Bakes the receivers of a round, whose number comes first, with how far transfer may be off before it.
type BakeRound<'a> = &'a mut dyn FnMut((usize, f64), &Scene, &Receivers, &BakeOptions) -> Round;

fn split(
    scene: &Scene,
    options: &AdaptiveOptions,
    bake_round: BakeRound<'_>,
) -> Result<(Scene, AdaptiveReport), PrtError> {
    if !(options.threshold > 0.0 && options.threshold.is_finite()) {
        return Err(PrtError::Options(format!("expected a threshold above zero, found {}", options.threshold)));
    }
    let min_edge = options.min_edge.unwrap_or_else(|| diagonal(scene) * SHORTEST_EDGE);
    if !(min_edge > 0.0 && min_edge.is_finite()) {
        return Err(PrtError::Options(format!("expected a shortest edge above zero, found {min_edge}")));
    }
    let mut report = AdaptiveReport { vertices_before: scene.vertex_count(), ..AdaptiveReport::default() };
    let mut scene = scene.clone();
    // Decide the channels by all vertices: new ones alone might need fewer.
    let channels = options.bake.channels_for(&scene, Receivers::at_vertices(&scene)?.is_gray());
    let bake = BakeOptions { channels: Some(channels), ..options.bake.clone() };
    // Bake the vertices there are.
    let (transfer, rays) = bake_round((0, 0.0), &scene, &Receivers::at_vertices(&scene)?, &bake)?;
    report.rays = rays;
    let mut known = Known::new(&scene, &transfer);
    let limit = options.threshold * known.root_mean_square();
    loop {
        // Find the edges that are off by too much, as far as is known.
        let is_off = |mesh, edge| is_long(&scene, mesh, edge, min_edge) && known.error(mesh, edge) > limit;
        let (finer, halved) = scene.halve_edges(is_off)?;
        // Bake their middles, and those of the edges that would be halved with them.
        let middles = known.unknown_middles(&scene, &halved);
        let is_over = middles.is_empty();
        if !is_over {
            report.rounds += 1;
            let receivers = Receivers::at_vertices(&finer)?.subset(&middles.values().copied().collect::<Vec<_>>())?;
            let may_be_off = edges(&scene).into_iter().filter(|&(mesh, edge)| is_long(&scene, mesh, edge, min_edge));
            let largest = may_be_off.map(|(mesh, edge)| known.error(mesh, edge)).fold(0.0, f64::max);
            let begin = (report.rounds, options.threshold * largest / limit);
            let (transfer, rays) = bake_round(begin, &finer, &receivers, &bake)?;
            report.rays += rays;
            known.add_middles(middles.into_keys(), &transfer);
        }
        // Halve those that are off indeed, the worst ones first; end where there are none, or no more vertices are allowed.
        let mut off = known.edges_off(&scene, limit, min_edge);
        let Some(&(worst, _)) = off.first() else { if is_over { break } else { continue } };
        if options.max_vertices.is_some() {
            off.retain(|(error, _)| *error >= WORST * worst);
        }
        let Some((finer, halved)) = within(&scene, off, options.max_vertices)? else { break };
        known.add_vertices(&halved);
        scene = finer;
    }
    report.vertices = scene.vertex_count();
    let mut largest = 0.0_f64;
    for (mesh, edge) in edges(&scene) {
        let error = known.error(mesh, edge);
        largest = largest.max(error);
        if error > limit {
            let is_long = is_long(&scene, mesh, edge, min_edge);
            *if is_long { &mut report.left_out } else { &mut report.too_short } += 1;
        }
    }
    // Where nothing sends light back, nothing is off.
    report.largest_error = if limit > 0.0 { options.threshold * largest / limit } else { 0.0 };
    Ok((scene, report))
}

/// A mesh, and the ends of one of its edges, the smaller index first.
type Edge = (usize, [u32; 2]);

/// The scene with these edges halved, the first ones at least, as far as its vertices are allowed, and the edges that were;
/// none if there is no room even for the first.
fn within(
    scene: &Scene,
    mut chosen: Vec<(f64, Edge)>,
    max_vertices: Option<usize>,
) -> Result<Option<(Scene, HalvedEdges)>, PrtError> {
    while !chosen.is_empty() {
        let edges: HashSet<Edge> = chosen.iter().map(|(_, edge)| *edge).collect();
        let (finer, halved) = scene.halve_edges(|mesh, edge| edges.contains(&(mesh, sorted(edge))))?;
        if max_vertices.is_none_or(|most| finer.vertex_count() <= most) {
            return Ok(Some((finer, halved)));
        }
        chosen.truncate(chosen.len() / 2);
    }
    Ok(None)
}

/// Transfer of the vertices there are so far, and in the middle of edges.
struct Known {
    /// Coefficients of a vertex.
    row: usize,
    /// For each mesh, vertex by vertex.
    rows: Vec<Vec<f32>>,
    /// In the middle of edges that are not halved, with the error of interpolation there.
    middles: BTreeMap<Edge, (Vec<f32>, f64)>,
}

impl Known {
    /// The transfer of all vertices of a scene.
    fn new(scene: &Scene, transfer: &Transfer) -> Self {
        let row = transfer.order() * transfer.order() * transfer.channels().count();
        let mut rest = transfer.coefficients();
        let mut of_mesh = |mesh: &Mesh| {
            let (rows, others) = rest.split_at(mesh.positions().len() * row);
            rest = others;
            rows.to_vec()
        };
        Self { row, rows: scene.meshes().iter().map(&mut of_mesh).collect(), middles: BTreeMap::new() }
    }

    fn root_mean_square(&self) -> f64 {
        let squares: f64 = self.rows.iter().flatten().map(|&c| f64::from(c).powi(2)).sum();
        let vertices: usize = self.rows.iter().map(|rows| rows.len() / self.row).sum();
        (squares / vertices as f64).sqrt()
    }

    fn ends(&self, mesh: usize, edge: [u32; 2]) -> [&[f32]; 2] {
        edge.map(|i| &self.rows[mesh][i as usize * self.row..][..self.row])
    }

    /// The error of interpolation in the middle of an edge; where that is not baked, the largest it can be while transfer
    /// changes one way.
    fn error(&self, mesh: usize, edge: [u32; 2]) -> f64 {
        if let Some((_, error)) = self.middles.get(&(mesh, sorted(edge))) {
            return *error;
        }
        let [a, b] = self.ends(mesh, edge);
        0.5 * a.iter().zip(b).map(|(a, b)| f64::from(a - b).powi(2)).sum::<f64>().sqrt()
    }

    /// The edges among those that were halved whose middles are not baked, with the numbers of these among all vertices of
    /// the finer scene.
    fn unknown_middles(&self, scene: &Scene, halved: &[Vec<[u32; 2]>]) -> BTreeMap<Edge, usize> {
        let (mut unknown, mut first) = (BTreeMap::new(), 0);
        for (m, (mesh, edges)) in scene.meshes().iter().zip(halved).enumerate() {
            first += mesh.positions().len();
            let middles = edges.iter().enumerate().map(|(k, edge)| ((m, *edge), first + k));
            unknown.extend(middles.filter(|(edge, _)| !self.middles.contains_key(edge)));
            first += edges.len();
        }
        unknown
    }

    fn add_middles(&mut self, edges: impl Iterator<Item = Edge>, transfer: &Transfer) {
        for ((mesh, ends), middle) in edges.zip(transfer.coefficients().chunks_exact(self.row)) {
            let [a, b] = self.ends(mesh, ends);
            let square =
                |((a, b), m): ((&f32, &f32), &f32)| (f64::from(*m) - 0.5 * (f64::from(*a) + f64::from(*b))).powi(2);
            let error = a.iter().zip(b).zip(middle).map(square).sum::<f64>().sqrt();
            self.middles.insert((mesh, ends), (middle.to_vec(), error));
        }
    }

    /// The edges whose baked middles are off by more than `limit`, worst first.
    fn edges_off(&self, scene: &Scene, limit: f64, min_edge: f32) -> Vec<(f64, Edge)> {
        let is_off = |&(error, (mesh, edge)): &(f64, Edge)| error > limit && is_long(scene, mesh, edge, min_edge);
        let errors = self.middles.iter().map(|(edge, (_, error))| (*error, *edge));
        let mut off: Vec<(f64, Edge)> = errors.filter(is_off).collect();
        off.sort_by(|(a, edge_a), (b, edge_b)| b.total_cmp(a).then(edge_a.cmp(edge_b)));
        off
    }

    /// Makes the middles of edges that are halved vertices.
    fn add_vertices(&mut self, halved: &[Vec<[u32; 2]>]) {
        for (mesh, edges) in halved.iter().enumerate() {
            for edge in edges {
                let row = match self.middles.remove(&(mesh, *edge)) {
                    Some((row, _)) => row,
                    // Only where an edge is too short for a middle in f32 was it not baked.
                    None => self.ends(mesh, *edge)[0].to_vec(),
                };
                self.rows[mesh].extend(row);
            }
        }
    }
}

fn sorted([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// Whether an edge may be halved, and has a middle in f32.
fn is_long(scene: &Scene, mesh: usize, edge: [u32; 2], min_edge: f32) -> bool {
    let [a, b] = edge.map(|i| scene.meshes()[mesh].positions()[i as usize]);
    let middle = [0, 1, 2].map(|k| 0.5 * (a[k] + b[k]));
    middle != a && middle != b && (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f32>() >= min_edge * min_edge
}

/// The length of the diagonal of the scene's box.
fn diagonal(scene: &Scene) -> f32 {
    let Bounds { min, max } = scene.bounds();
    (0..3).map(|k| (max[k] - min[k]).powi(2)).sum::<f32>().sqrt()
}

/// Every edge once.
fn edges(scene: &Scene) -> HashSet<Edge> {
    let of = |t: &[u32; 3]| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]].map(sorted);
    let meshes = scene.meshes().iter().enumerate();
    meshes.flat_map(|(m, mesh)| mesh.triangles().iter().flat_map(of).map(move |edge| (m, edge))).collect()
}
