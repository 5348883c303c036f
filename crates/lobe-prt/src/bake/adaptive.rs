//! Adaptive subdivision: triangles split where transfer changes along their edges.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use derive_setters::Setters;
use lobe_io::{Job, Progress};
use lobe_scene::{Bounds, Bvh, Mesh, Scene};

use crate::{BakeMode, BakeOptions, PrtError, Receivers, Transfer, bake, bake_on_disk};

/// The shortest edge that is split if nothing else is said, as a part of the scene's diagonal.
const SHORTEST_EDGE: f32 = 1.0 / 512.0;

/// Options of [`split_adaptively`].
#[derive(Clone, Debug, PartialEq, Setters, serde::Serialize, serde::Deserialize)]
#[serde(default)]
#[non_exhaustive]
pub struct AdaptiveOptions {
    /// Edges are halved whose ends' transfer differs by more than this part of the root mean square of all transfer.
    pub threshold: f64,
    /// Edges that are shorter are left. Without a choice that is 1/512 of the diagonal of the scene's box.
    pub min_edge: Option<f32>,
    /// Options of the bake that estimates transfer at each vertex. Its noise should be well below the threshold.
    pub bake: BakeOptions,
}

impl Default for AdaptiveOptions {
    /// Splits where transfer changes by a tenth, found by 256 paths of shadowed transfer, which are enough to see that.
    fn default() -> Self {
        Self { threshold: 0.1, min_edge: None, bake: BakeOptions::default().mode(BakeMode::Shadowed).samples(256) }
    }
}

/// The report of an adaptive split.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
#[non_exhaustive]
pub struct AdaptiveReport {
    /// Rounds in which edges were halved.
    pub rounds: usize,
    /// Vertices at the beginning.
    pub vertices_before: usize,
    /// Vertices at the end.
    pub vertices: usize,
    /// Rays traced.
    pub rays: u64,
    /// Edges whose ends still differ by more, being too short to be halved.
    pub unresolved: usize,
    /// The largest change of transfer along an edge at the end, in the unit of [`AdaptiveOptions::threshold`]: no more than
    /// that, unless edges are unresolved.
    pub largest_change: f64,
}

/// Splits a scene until transfer changes little along every edge, or the edge is short.
///
/// ```text
///   an edge ab is halved if  ‖T_a - T_b‖ > t R  and  |ab| ≥ e,  R² = mean over the vertices of the given scene of ‖T‖²
/// ```
///
/// R makes the threshold t a part of what surfaces of this scene send back at all, so that noise in dark corners splits
/// nothing. The rest of the scene hardly changes where edges are halved, and transfer is baked for new vertices alone.
/// The first vertices of each mesh are those it had. The bake of the result is up to the caller.
///
/// The job is told of each [round](Progress::round) anew. If it is [kept in a file](Job::kept_in), each round keeps
/// what it finds in a file of its own, whose name has `.split-` and the number of the round appended. Splitting that
/// was stopped, or killed at any moment, continues from these files and ends with the same scene; edges are halved once
/// more, which takes no rays. All files stay locked until it ends. The caller removes them, the last one first, when
/// the results are safe.
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
    split(scene, options, &mut |round, scene, receivers, options| {
        let mut watch = |progress: &Progress| job.report(&Progress { round, ..*progress });
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

/// The checkpoint of a round of a split that is kept in a file.
fn path_of_round(checkpoint: &Path, round: usize) -> PathBuf {
    let mut name = checkpoint.to_path_buf().into_os_string();
    name.push(format!(".split-{round}"));
    name.into()
}

/// The transfer of some receivers, and the number of rays traced for it.
type Round = Result<(Transfer, u64), PrtError>;

/// Bakes the receivers of a round, whose number comes first.
type BakeRound<'a> = &'a mut dyn FnMut(usize, &Scene, &Receivers, &BakeOptions) -> Round;

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
    let vertices = scene.vertex_count();
    let mut report =
        AdaptiveReport { rounds: 0, vertices_before: vertices, vertices, rays: 0, unresolved: 0, largest_change: 0.0 };
    let mut scene = scene.clone();
    // Decide the channels by all vertices: new ones alone might need fewer.
    let channels = options.bake.channels_for(&scene, Receivers::at_vertices(&scene)?.is_gray());
    let bake = BakeOptions { channels: Some(channels), ..options.bake.clone() };
    let mut known = Known { rows: vec![Vec::new(); scene.meshes().len()], row: 0 };
    let mut limit = None;
    loop {
        // Bake the vertices that are new in this round.
        report.rays +=
            known.bake_new_vertices(&scene, &mut |receivers| bake_round(report.rounds, &scene, receivers, &bake))?;
        // Halve the edges along which transfer changes.
        let limit = *limit.get_or_insert_with(|| options.threshold * known.root_mean_square());
        let changes = |mesh, edge| known.distance(mesh, edge) > limit;
        let is_long = |mesh: usize, [a, b]: [u32; 2]| {
            let [a, b] = [a, b].map(|i| scene.meshes()[mesh].positions()[i as usize]);
            (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f32>() >= min_edge * min_edge
        };
        let finer = scene.halve_edges(|mesh, edge| is_long(mesh, edge) && changes(mesh, edge))?;
        // End where there are none.
        if finer.vertex_count() == scene.vertex_count() {
            report.vertices = scene.vertex_count();
            let changes = changes_along_edges(&scene, |mesh, edge| known.distance(mesh, edge));
            report.unresolved = changes.iter().filter(|change| **change > limit).count();
            let largest = changes.into_iter().fold(0.0, f64::max);
            // Where nothing sends light back, nothing changes.
            report.largest_change = if limit > 0.0 { options.threshold * largest / limit } else { 0.0 };
            return Ok((scene, report));
        }
        scene = finer;
        report.rounds += 1;
    }
}

/// Transfer of the vertices there are so far.
struct Known {
    /// For each mesh, vertex by vertex.
    rows: Vec<Vec<f32>>,
    /// Coefficients of a vertex.
    row: usize,
}

impl Known {
    /// Bakes the vertices that are not known yet; returns the number of rays traced.
    fn bake_new_vertices(&mut self, scene: &Scene, bake: &mut dyn FnMut(&Receivers) -> Round) -> Result<u64, PrtError> {
        let all = Receivers::at_vertices(scene)?;
        let (mut which, mut counts) = (Vec::new(), Vec::new());
        let mut first = 0;
        for (mesh, rows) in scene.meshes().iter().zip(&self.rows) {
            let end = first + mesh.positions().len();
            let new = first + rows.len().checked_div(self.row).unwrap_or(0)..end;
            counts.push(new.len());
            which.extend(new);
            first = end;
        }
        let (transfer, rays) = bake(&all.subset(&which)?)?;
        self.row = transfer.order() * transfer.order() * transfer.channels().count();
        let mut rest = transfer.coefficients();
        for (rows, count) in self.rows.iter_mut().zip(counts) {
            let (new, others) = rest.split_at(count * self.row);
            rows.extend_from_slice(new);
            rest = others;
        }
        Ok(rays)
    }

    fn root_mean_square(&self) -> f64 {
        let squares: f64 = self.rows.iter().flatten().map(|&c| f64::from(c).powi(2)).sum();
        let vertices: usize = self.rows.iter().map(|rows| rows.len() / self.row).sum();
        (squares / vertices as f64).sqrt()
    }

    fn distance(&self, mesh: usize, edge: [u32; 2]) -> f64 {
        let [a, b] = edge.map(|i| &self.rows[mesh][i as usize * self.row..][..self.row]);
        a.iter().zip(b).map(|(a, b)| f64::from(a - b).powi(2)).sum::<f64>().sqrt()
    }
}

/// The length of the diagonal of the scene's box.
fn diagonal(scene: &Scene) -> f32 {
    let Bounds { min, max } = scene.bounds();
    (0..3).map(|k| (max[k] - min[k]).powi(2)).sum::<f32>().sqrt()
}

/// The change along every edge, each once, by the indices of its ends.
fn changes_along_edges(scene: &Scene, change: impl Fn(usize, [u32; 2]) -> f64) -> Vec<f64> {
    let edges = |t: &[u32; 3]| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]].map(|[a, b]| [a.min(b), a.max(b)]);
    let of_mesh = |(m, mesh): (usize, &Mesh)| {
        let all: HashSet<[u32; 2]> = mesh.triangles().iter().flat_map(edges).collect();
        all.into_iter().map(|edge| change(m, edge)).collect::<Vec<_>>()
    };
    scene.meshes().iter().enumerate().flat_map(of_mesh).collect()
}
