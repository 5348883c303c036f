//! Adaptive subdivision: triangles split where linear functions fit their transfer worst.

use std::collections::{HashMap, HashSet};

use derive_setters::Setters;
use lobe_io::{Fingerprint, Job, JobFiles, Progress};
use lobe_scene::{Bounds, Bvh, Scene};

use crate::bake::bake::check_tree;
use crate::bake::options::BakeOptions;
use crate::bake::pilot::DARKEST;
use crate::error::PrtError;
use crate::fit::residual::{Residual, Residuals, RoundOfResiduals};
use crate::fit::surface_points::{area, gap};
use crate::job::checkpoint::{Checkpoint, StoredRows};
use crate::job::chunks::{Memory, run};
use crate::job::fingerprint::{fingerprint_arithmetic, fingerprint_scene};

/// The shortest edge that is split if nothing else is said, as a part of the scene's diagonal.
const SHORTEST_EDGE: f32 = 1.0 / 1024.0;

/// Triangles of this part of all error are split in a round [Dörfler 1996]: those that it brings to light are not left
/// behind.
const PART_OF_A_ROUND: f64 = 0.5;

/// Edges of a triangle that are no shorter than this part of its longest one are halved with it, so that triangles of
/// any shape become four like it, and thin ones less thin.
const NEARLY_LONGEST: f32 = 0.7;

/// A continuous fit, over the surfaces that a picture shows, is off by about this times as much as linear functions
/// that end at each triangle are over all surfaces. With it the estimate is .8 to 1.4 times the error of pictures of a
/// box, a room, a robot and a hall.
const CONTINUITY: f64 = 2.0;

/// Options of [`split_adaptively`].
#[derive(Clone, Debug, PartialEq, Setters, serde::Serialize, serde::Deserialize)]
#[serde(default)]
#[non_exhaustive]
pub struct AdaptiveOptions {
    /// Splitting ends where interpolated transfer is off by less than this part of itself, as a root mean square over
    /// all surfaces.
    pub error: f64,
    /// Edges that are shorter are left. Without a choice that is 1/1024 of the diagonal of the scene's box.
    pub min_edge: Option<f32>,
    /// The most vertices of the result. Without a choice that is four times as many as the scene has, and at least
    /// [`AdaptiveOptions::LEAST_BUDGET`].
    pub max_vertices: Option<usize>,
    /// Options of the bake that follows.
    pub bake: BakeOptions,
}

impl Default for AdaptiveOptions {
    /// An error of 1 %.
    fn default() -> Self {
        Self { error: 0.01, min_edge: None, max_vertices: None, bake: BakeOptions::default() }
    }
}

impl AdaptiveOptions {
    /// The vertices that any scene may have if nothing else is said.
    pub const LEAST_BUDGET: usize = 20_000;

    /// The most vertices of a scene that begins with so many.
    #[must_use]
    pub fn budget(&self, vertices: usize) -> usize {
        self.max_vertices.unwrap_or_else(|| (4 * vertices).max(Self::LEAST_BUDGET))
    }
}

/// The report of an adaptive split.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
#[non_exhaustive]
pub struct AdaptiveReport {
    /// Rounds in which triangles were split.
    pub rounds: usize,
    /// Vertices at the beginning.
    pub vertices_before: usize,
    /// Vertices at the end.
    pub vertices: usize,
    /// Rays traced.
    pub rays: u64,
    /// The estimate of the error at the end, in the unit of [`AdaptiveOptions::error`].
    pub error: f64,
    /// One standard deviation more: splitting ends where this is below [`AdaptiveOptions::error`].
    pub error_bound: f64,
    /// The part of the error that is in triangles whose edges are too short to be halved.
    pub too_short: f64,
    /// The mesh with the largest error, and its part of all.
    pub worst: Option<(usize, f64)>,
}

/// Splits a scene where transfer at vertices, [fitted](crate::bake_vertices), is farthest off, until the error is small
/// or there are as many vertices as allowed.
///
/// ```text
///   error² = 4 Σ_t e_t / (E_t + Ē/100) / area of all      E_t = mean over triangle t of ‖T‖²
///   e_t = ∫ over triangle t of  ‖T - (the nearest linear function)‖² dA
/// ```
///
/// e is estimated without bias from points in the triangle; each has two estimates of its transfer, whose product has
/// no noise on average. Band l counts by 1/(l + 1)². The factor 4 is for what a fit
/// loses that is continuous. In each round the triangles are split that have half of all error above its standard
/// deviation, worst first. What nobody sees, inside of a solid or in a narrow gap, counts nothing.
///
/// What comes and goes between the points of a triangle is not found. Points are as dense as triangles would be if all
/// vertices were spread evenly, and no more than 256 in a triangle at first.
///
/// The job is told of each [round](Progress::round) anew, and of the [error](Progress::error) that is left. If it is
/// [kept in a file](Job::kept_in), each round keeps what it finds in a file of its own, see [`JobFiles::rounds`].
/// Splitting that was stopped, or killed at any moment, continues from these files and ends with the same scene. The
/// caller removes them, the last one first, when the results are safe.
///
/// # Errors
/// [`PrtError::Options`] if an option is out of its range, [`PrtError::Scene`] if the scene would have more than 2²⁶
/// triangles; for the job those of [`bake()`](crate::bake()).
pub fn split_adaptively(
    scene: &Scene,
    bvh: &Bvh,
    options: &AdaptiveOptions,
    mut job: Job<'_>,
) -> Result<(Scene, AdaptiveReport), PrtError> {
    check(options)?;
    check_tree(scene, bvh)?;
    let budget = options.budget(scene.vertex_count());
    let min_edge = options.min_edge.unwrap_or_else(|| diagonal(scene) * SHORTEST_EDGE);
    let mut report = AdaptiveReport { vertices_before: scene.vertex_count(), ..AdaptiveReport::default() };
    let mut split = scene.clone();
    // Two triangles for each vertex.
    let all: f64 = scene.corners().map(area).sum();
    let density = if all > 0.0 { 2.0 * budget as f64 / all } else { 0.0 };
    let residuals = Residuals::new(scene, bvh, &options.bake, density, gap(scene));
    let mut known = Known::default();
    let mut locked = Vec::new();
    loop {
        // Estimate the residuals of the triangles that are new.
        let new = known.unknown(&split);
        let round = RoundOfResiduals { residuals: &residuals, split: &split, triangles: &new };
        let (rows, rays) = estimate(&round, scene, options, (&known, report.rounds), &mut job, &mut locked)?;
        report.rays += rays;
        known.add(&split, &new, &rows);
        // End where the error is small.
        [report.error, report.error_bound] = known.relative_error();
        if report.error_bound <= options.error {
            break;
        }
        // Split the worst triangles, as far as vertices are allowed.
        let chosen = known.worst(&split, min_edge);
        let Some(finer) = within(&split, chosen, budget)? else { break };
        split = finer;
        report.rounds += 1;
    }
    report.vertices = split.vertex_count();
    report.too_short = known.too_short(&split, min_edge);
    report.worst = known.worst_mesh();
    Ok((split, report))
}

fn check(options: &AdaptiveOptions) -> Result<(), PrtError> {
    options.bake.check()?;
    if !(options.error > 0.0 && options.error.is_finite()) {
        return Err(PrtError::Options(format!("expected an error above zero, found {}", options.error)));
    }
    match options.min_edge {
        Some(edge) if !(edge > 0.0 && edge.is_finite()) => {
            Err(PrtError::Options(format!("expected a shortest edge above zero, found {edge}")))
        }
        _ => Ok(()),
    }
}

/// Estimates the residuals of a round, in memory or in a file of its own, and counts the rays.
fn estimate(
    round: &RoundOfResiduals<'_>,
    scene: &Scene,
    options: &AdaptiveOptions,
    (known, number): (&Known, usize),
    job: &mut Job<'_>,
    locked: &mut Vec<StoredRows>,
) -> Result<(Vec<f32>, u64), PrtError> {
    let path = job.checkpoint().map(|path| JobFiles::round(path, number));
    let error = if number == 0 { 0.0 } else { known.relative_error()[1] };
    let mut watch = |progress: &Progress| job.report(&Progress { round: number, error, ..*progress });
    let mut watched = Job::default().watched_by(&mut watch);
    let Some(path) = path else {
        let mut memory = Memory::default();
        run(round, &mut memory, &mut watched)?;
        return Ok((memory.rows, memory.tally.rays));
    };
    let fingerprint = fingerprint(scene, round.split, options);
    let mut checkpoint = Checkpoint::open(&path, round, fingerprint, 0, None)?;
    let outcome = run(round, &mut checkpoint, &mut watched);
    if outcome.is_err() {
        checkpoint.sync()?;
    }
    outcome?;
    let (tally, rows) = checkpoint.finish()?;
    let found = rows.load()?;
    locked.push(rows);
    Ok((found, tally.rays))
}

/// The fingerprint of everything that decides a round.
fn fingerprint(scene: &Scene, split: &Scene, options: &AdaptiveOptions) -> Fingerprint {
    /// The kind of this work among fingerprints.
    const KIND: u64 = 9;
    let mut fingerprint = Fingerprint::of_kind(KIND);
    fingerprint_scene(&mut fingerprint, scene);
    fingerprint_scene(&mut fingerprint, split);
    options.bake.write_into(&mut fingerprint);
    fingerprint.word(options.budget(scene.vertex_count()) as u64);
    fingerprint_arithmetic(&mut fingerprint);
    fingerprint
}

/// A mesh, and the ends of one of its edges, the smaller index first.
type Edge = (usize, [u32; 2]);

/// The scene with the edges of the first triangles halved, as far as its vertices are allowed; none if there is no room
/// even for one.
fn within(scene: &Scene, mut chosen: Vec<Vec<Edge>>, budget: usize) -> Result<Option<Scene>, PrtError> {
    while !chosen.is_empty() {
        let edges: HashSet<Edge> = chosen.iter().flatten().copied().collect();
        // Each edge makes one vertex at least.
        let is_hopeless = scene.vertex_count() + edges.len() > budget;
        if !is_hopeless {
            let (finer, _) = scene.halve_edges(|mesh, edge| edges.contains(&(mesh, sorted(edge))))?;
            if finer.vertex_count() <= budget {
                return Ok((finer.vertex_count() > scene.vertex_count()).then_some(finer));
            }
        }
        chosen.truncate(chosen.len() / 2);
    }
    Ok(None)
}

/// The residuals of the triangles there are, by mesh and vertices.
#[derive(Default)]
struct Known {
    residuals: HashMap<(usize, [u32; 3]), Residual>,
    /// Those of the triangles of the scene, in its order, with relative errors.
    current: Vec<Residual>,
    meshes: Vec<usize>,
}

impl Known {
    /// The triangles whose residuals are not known.
    fn unknown(&self, scene: &Scene) -> Vec<usize> {
        let keys = keys(scene).enumerate();
        keys.filter(|(_, key)| !self.residuals.contains_key(key)).map(|(triangle, _)| triangle).collect()
    }

    /// Adds the residuals of triangles that were not known.
    fn add(&mut self, scene: &Scene, new: &[usize], rows: &[f32]) {
        let mut rows = rows.as_chunks::<{ Residual::NUMBERS }>().0.iter();
        let mut new = new.iter().peekable();
        let mut residuals = HashMap::with_capacity(scene.triangle_count());
        self.current.clear();
        self.meshes.clear();
        for (triangle, key) in keys(scene).enumerate() {
            let residual = match new.next_if(|&&number| number == triangle).and_then(|_| rows.next()) {
                Some(row) => Residual::of_numbers(*row),
                None => self.residuals.get(&key).copied().unwrap_or_default(),
            };
            residuals.insert(key, residual);
            self.current.push(residual);
            self.meshes.push(key.0);
        }
        self.residuals = residuals;
        // Errors count by what is there: a dim room is looked at by an eye that is used to it.
        let sum = |of: fn(&Residual) -> f64| self.current.iter().map(of).sum::<f64>();
        let (energy, area) = (sum(|residual| residual.energy), sum(|residual| residual.area));
        let floor = if area > 0.0 { DARKEST * energy.max(0.0) / area } else { 0.0 };
        self.current.iter_mut().for_each(|residual| *residual = residual.relative_to(floor));
    }

    /// The error as a part of all, and the bound that it is below with a probability of 84 %: one standard deviation
    /// more.
    fn relative_error(&self) -> [f64; 2] {
        let sum = |of: fn(&Residual) -> f64| self.current.iter().map(of).sum::<f64>();
        let area = sum(|residual| residual.area);
        let (error, deviation) = (sum(|residual| residual.error), sum(|residual| residual.variance).sqrt());
        let part = |error: f64| if area > 0.0 { CONTINUITY * (error.max(0.0) / area).sqrt() } else { 0.0 };
        [part(error), part(error.max(0.0) + deviation)]
    }

    /// The edges to halve of the triangles that have half of all error, worst first.
    fn worst(&self, scene: &Scene, min_edge: f32) -> Vec<Vec<Edge>> {
        let mut off = self.off_by(scene, min_edge, Residual::least_error);
        if off.is_empty() {
            // Nothing stands out of the noise; what is left is spread evenly.
            off = self.off_by(scene, min_edge, |residual| residual.error);
        }
        let mut rest = PART_OF_A_ROUND * off.iter().map(|(error, _)| error).sum::<f64>();
        let is_worst = |(error, _): &(f64, Vec<Edge>)| {
            let is_worst = rest > 0.0;
            rest -= error;
            is_worst
        };
        off.into_iter().take_while(is_worst).map(|(_, edges)| edges).collect()
    }

    /// The triangles with an error above zero that can be split, worst first: the error, and the edges to halve.
    fn off_by(&self, scene: &Scene, min_edge: f32, error: fn(&Residual) -> f64) -> Vec<(f64, Vec<Edge>)> {
        let errors = self.current.iter().map(error).zip(0..);
        let mut off: Vec<(f64, usize)> = errors.filter(|(error, _)| *error > 0.0).collect();
        off.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let edges = |&(error, triangle): &(f64, usize)| {
            let edges = edges_to_halve(scene, triangle, min_edge);
            (!edges.is_empty()).then_some((error, edges))
        };
        off.iter().filter_map(edges).collect()
    }

    /// The part of the error that is in triangles whose edges are too short.
    fn too_short(&self, scene: &Scene, min_edge: f32) -> f64 {
        let (mut short, mut all) = (0.0, 0.0);
        for (triangle, residual) in self.current.iter().enumerate() {
            all += residual.error.max(0.0);
            if residual.error > 0.0 && edges_to_halve(scene, triangle, min_edge).is_empty() {
                short += residual.error;
            }
        }
        if all > 0.0 { short / all } else { 0.0 }
    }

    /// The mesh with the largest error, and its part of all.
    fn worst_mesh(&self) -> Option<(usize, f64)> {
        let mut errors = vec![0.0; self.meshes.last()? + 1];
        self.current.iter().zip(&self.meshes).for_each(|(residual, &mesh)| errors[mesh] += residual.error);
        let all: f64 = errors.iter().sum();
        let (mesh, worst) = errors.into_iter().enumerate().max_by(|a, b| a.1.total_cmp(&b.1))?;
        (all > 0.0).then(|| (mesh, worst / all))
    }
}

/// For each triangle its mesh and its vertices.
fn keys(scene: &Scene) -> impl Iterator<Item = (usize, [u32; 3])> {
    scene.meshes().iter().enumerate().flat_map(|(m, mesh)| mesh.triangles().iter().map(move |&t| (m, t)))
}

/// The longest edges of a triangle, if they may be halved and have a middle in f32.
fn edges_to_halve(scene: &Scene, triangle: usize, min_edge: f32) -> Vec<Edge> {
    let (m, number) = scene.locate(triangle);
    let mesh = &scene.meshes()[m];
    let [a, b, c] = mesh.triangles()[number];
    let edges = [[a, b], [b, c], [c, a]].map(|edge| {
        let [from, to] = edge.map(|i| mesh.positions()[i as usize]);
        let middle = [0, 1, 2].map(|k| 0.5 * (from[k] + to[k]));
        let length = (0..3).map(|k| (from[k] - to[k]).powi(2)).sum::<f32>().sqrt();
        (edge, length, middle != from && middle != to)
    });
    let longest = edges.iter().map(|(_, length, _)| *length).fold(0.0, f32::max);
    let is_chosen = |length: f32| length >= min_edge && length >= NEARLY_LONGEST * longest;
    let chosen = edges.into_iter().filter(|&(_, length, has_middle)| has_middle && is_chosen(length));
    chosen.map(|(edge, ..)| (m, sorted(edge))).collect()
}

fn sorted([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// The length of the diagonal of the scene's box.
fn diagonal(scene: &Scene) -> f32 {
    let Bounds { min, max } = scene.bounds();
    (0..3).map(|k| (max[k] - min[k]).powi(2)).sum::<f32>().sqrt()
}
