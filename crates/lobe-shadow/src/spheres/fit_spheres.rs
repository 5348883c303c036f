//! Fitting sphere sets to meshes: options, report, the job.

use std::{iter, mem};

use derive_setters::Setters;
use glam::DVec3;
use lobe_io::{Fingerprint, Job, Progress, RecordFile, RecordFormat, RecordLayout};
use lobe_scene::Scene;
use web_time::Instant;

use crate::error::ShadowError;
use crate::spheres::ball::{Ball, reach};
use crate::spheres::cover_samples::CoverSamples;
use crate::spheres::medial_axis::medial_balls;
use crate::spheres::solid::Solid;
use crate::spheres::sphere_set::SphereSet;
use crate::spheres::variational::{Cover, energy};

/// A fit is at its end when two rounds together lower the energy by less than twice the tolerance.
const WINDOW: usize = 2;

/// The fingerprint and the records of a fit.
const KIND: u64 = 22;
const FORMAT: RecordFormat =
    RecordFormat { kind: *b"SPHR", version: 2, work: "fit of spheres", arguments: "the mesh or the options" };

/// Steps of the start that are kept; an eighth of the spheres goes at each, unless neighbors are in the way, so most starts take six.
const START_STEPS: usize = 32;

/// Ways to fit spheres.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SphereFitMethod {
    /// The least summed outside volume that Lloyd's algorithm with teleportation finds [Wang et al. 2006].
    Variational,
    /// Balls of the medial axis, expanded and selected greedily: faster, and worse. A simplified form of
    /// [Bradshaw and O'Sullivan 2004], for comparison.
    MedialAxis,
}

/// Options of a fit.
#[derive(Clone, Debug, PartialEq, Setters, serde::Serialize, serde::Deserialize)]
#[serde(default)]
#[non_exhaustive]
pub struct SphereFitOptions {
    /// Number of spheres, 1 to 4096 and no more than samples. The medial axis may need fewer.
    pub count: usize,
    /// The way.
    pub method: SphereFitMethod,
    /// About how many points are to be covered, at most 2²²: a third of them inside, the others on the surface,
    /// vertices first.
    pub samples: usize,
    /// Whether spheres of the medial axis shrink at last to the points that are theirs; as published they do not.
    pub shrink: bool,
    /// Rounds at most, of the variational method.
    pub rounds: usize,
    /// The fit ends when a round lowers the energy by less than this part.
    pub tolerance: f64,
    /// Fits with different seeds start from different points.
    pub seed: u64,
}

impl Default for SphereFitOptions {
    /// 64 spheres by at most 100 rounds over 12288 points.
    fn default() -> Self {
        Self {
            count: 64,
            method: SphereFitMethod::Variational,
            samples: 12288,
            shrink: true,
            rounds: 100,
            tolerance: 1e-3,
            seed: 0,
        }
    }
}

impl SphereFitOptions {
    /// Spheres of a set at most: rounds take time proportional to spheres times points.
    pub const MAX_COUNT: usize = 4096;

    /// Points to cover at most: each takes about 100 bytes while the fit runs.
    pub const MAX_SAMPLES: usize = 1 << 22;

    /// Rounds at most; a fit is at its end after some tens.
    pub const MAX_ROUNDS: usize = 10_000;

    fn check(&self) -> Result<(), ShadowError> {
        let refuse = |message: String| Err(ShadowError::Options(message));
        let (most, samples, rounds) = (Self::MAX_COUNT, Self::MAX_SAMPLES, Self::MAX_ROUNDS);
        if !(1..=most).contains(&self.count) {
            return refuse(format!("expected 1 to {most} spheres, found {}", self.count));
        }
        if !(1..=samples).contains(&self.samples) {
            return refuse(format!("expected 1 to {samples} samples, found {}", self.samples));
        }
        if self.rounds > rounds {
            return refuse(format!("expected at most {rounds} rounds, found {}", self.rounds));
        }
        if !(self.tolerance >= 0.0 && self.tolerance < 1.0) {
            return refuse(format!("expected a tolerance in [0, 1), found {}", self.tolerance));
        }
        Ok(())
    }
}

/// The report of a fit.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
#[non_exhaustive]
pub struct SphereFitReport {
    /// The energy of the spheres as returned: their volumes outside the solid, summed; where two overlap, it counts
    /// twice.
    pub outside_volume: f64,
    /// The volume of the solid: by its surface if that is closed, less what overlaps count too much; else that of the
    /// samples with a winding number of at least ½, which is right to about their number to the power -2/3.
    pub solid_volume: f64,
    /// The energy at the start and after each round, before rounding to single precision; it never rises.
    pub history: Vec<f64>,
    /// The part of the points of a lattice over the box whose winding number is not between ¼ and ¾: 1 for a closed
    /// mesh. Below about 0.9 the mesh says little about what is inside.
    pub certainty: f64,
    /// The points that were to be covered, all of which are.
    pub samples: usize,
}

/// Fits spheres to the solid inside a scene: every sample of the solid is in a sphere, and little else.
///
/// ```text
///   minimize  E = Σ_k SOTV(c_k, R_k)   such that every sample p has a k with |p - c_k| ≤ R_k
/// ```
///
/// The mesh need not be watertight, see [`Solid`]; [`SphereFitReport::certainty`] says how much of a solid it is.
/// Centers count from the [origin](Scene::origin) of the scene, which is kept with the set. Between samples the surface may stick out of the spheres by a
/// part of their distance from each other. The same bytes come out for any number of threads.
///
/// The variational method starts with twice as many balls of the medial axis, takes spheres away until as many are
/// left as were asked for, and then runs rounds of two kinds in turn: Lloyd's with teleportation, and tightening.
/// Progress counts rounds. It can be resumed after any of them and after any step of the start, in which nothing else is counted: of 100 352
/// triangles that took 9 s of processor time for 64 spheres and 33 s for 512. For the other method a checkpoint is refused.
///
/// E over the volume of the solid, as the example `sphere_sets` prints it; "shrunk" are balls of the medial axis that
/// shrink to their own points at last, which in the published method they do not:
///
/// | | n | variational | medial, n | medial, 2n | shrunk, n | shrunk, 2n |
/// |---|---|---|---|---|---|---|
/// | bunny | 8 | 0.706 | 1.815 | 1.121 | 1.588 | 0.863 |
/// | | 16 | 0.443 | 1.121 | 0.753 | 0.863 | 0.646 |
/// | | 32 | 0.239 | 0.753 | 0.407 | 0.646 | 0.318 |
/// | | 64 | 0.136 | 0.407 | 0.201 | 0.318 | 0.157 |
/// | suzi (open) | 8 | 0.710 | 2.504 | 1.509 | 1.713 | 1.256 |
/// | | 16 | 0.390 | 1.509 | 0.854 | 1.256 | 0.695 |
/// | | 32 | 0.260 | 0.854 | 0.462 | 0.695 | 0.362 |
/// | | 64 | 0.155 | 0.462 | 0.267 | 0.362 | 0.221 |
/// | torus | 8 | 1.507 | 3.413 | **0.820** | 2.810 | **0.621** |
/// | | 16 | 0.365 | 0.820 | **0.273** | 0.621 | **0.203** |
/// | | 32 | 0.091 | 0.273 | 0.141 | 0.203 | 0.102 |
/// | | 64 | 0.023 | 0.141 | 0.061 | 0.102 | 0.042 |
/// | star | 8 | 3.294 | 5.840 | **2.786** | 4.642 | **2.328** |
/// | | 16 | 1.257 | 2.786 | 1.690 | 2.328 | 1.299 |
/// | | 32 | 0.766 | 1.690 | 1.300 | 1.299 | 1.022 |
/// | | 64 | 0.492 | 1.300 | 0.862 | 1.022 | 0.629 |
///
/// So half the spheres do no worse, but for the bold cases. On a tube, E falls with the square of n for the best
/// spheres already: 16 of them, evenly spaced on the center line of this torus, have 0.43, and 8 have 1.67.
///
/// ```
/// use lobe_io::Job;
/// use lobe_scene::{Material, Mesh, MeshParts, Scene};
/// use lobe_shadow::{SphereFitOptions, fit_spheres};
///
/// let positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
/// let triangles = vec![[0, 2, 1], [0, 3, 2], [0, 1, 3], [1, 2, 3]];
/// let mesh = Mesh::new(MeshParts { positions, triangles, ..MeshParts::default() })?;
/// let scene = Scene::new(vec![mesh], Vec::<Material>::new(), Vec::new())?;
/// let (set, report) = fit_spheres(&scene, &SphereFitOptions::default().count(4).samples(600), Job::default())?;
/// assert_eq!(set.len(), 4);
/// assert!((report.solid_volume - 1.0 / 6.0).abs() < 1e-9);
/// # Ok::<(), lobe_shadow::ShadowError>(())
/// ```
///
/// # Errors
/// [`ShadowError::Options`] if an option is out of range, there are more spheres than samples, or the scene has no
/// volume; [`ShadowError::Cancelled`]; of the checkpoint.
pub fn fit_spheres(
    scene: &Scene,
    options: &SphereFitOptions,
    job: Job<'_>,
) -> Result<(SphereSet, SphereFitReport), ShadowError> {
    fit(scene, None, options, job)
}

/// [`fit_spheres`] by the variational method from the spheres of a set, whose number counts instead of that of the
/// options: one read from a file, or fitted to a similar mesh.
///
/// # Errors
/// As [`fit_spheres`].
pub fn refine_spheres(
    scene: &Scene,
    start: &SphereSet,
    options: &SphereFitOptions,
    job: Job<'_>,
) -> Result<(SphereSet, SphereFitReport), ShadowError> {
    let options = options.clone().count(start.len()).method(SphereFitMethod::Variational);
    fit(scene, Some(start), &options, job)
}

fn fit(
    scene: &Scene,
    start: Option<&SphereSet>,
    options: &SphereFitOptions,
    job: Job<'_>,
) -> Result<(SphereSet, SphereFitReport), ShadowError> {
    options.check()?;
    if options.method == SphereFitMethod::MedialAxis {
        job.expect_no_checkpoint().map_err(ShadowError::Options)?;
    }
    let start = start.map(|set| moved_to(set, scene.origin())).transpose()?;
    let solid = Solid::of_scene(scene)?;
    let mut samples = CoverSamples::new(&solid, options.samples, options.seed)?;
    let solid = solid.without(mem::take(&mut samples.overlaps));
    let points = samples.points.as_slice();
    if options.count > points.len() {
        let message =
            format!("expected at most a sphere for each of {} samples, found {}", points.len(), options.count);
        return Err(ShadowError::Options(message));
    }
    let cover = Cover { solid: &solid, points };
    let (balls, history) = match options.method {
        SphereFitMethod::MedialAxis => {
            let balls = medial_balls(&solid, &samples, options.count, options.shrink);
            let energy = energy(&balls);
            (balls, vec![energy])
        }
        SphereFitMethod::Variational => {
            let fingerprint = fingerprint(scene, start.as_ref(), options);
            let first = |begun: Option<Vec<Ball>>, step: Step<'_>| match &start {
                Some(set) => Ok(cover.covering(&balls_of(set))),
                None => first_balls(&cover, &samples, options, begun, step),
            };
            run_rounds(&cover, first, options, &fingerprint, job)?
        }
    };
    let shrinks = options.method == SphereFitMethod::Variational || options.shrink;
    let (set, outside_volume) = rounded(&cover, &balls, shrinks)?;
    let set = set.with_origin(scene.origin())?;
    let CoverSamples { volume, certainty, .. } = samples;
    let report = SphereFitReport { outside_volume, solid_volume: volume, history, certainty, samples: points.len() };
    Ok((set, report))
}

/// What is done with the balls of a step of the start, which may end it.
type Step<'a> = &'a mut dyn FnMut(&[Ball]) -> Result<(), ShadowError>;

/// The balls that the first round begins with: twice as many of the medial axis, thinned out, or points where there
/// are fewer. A start that was `begun` goes on from its balls.
fn first_balls(
    cover: &Cover<'_>,
    samples: &CoverSamples,
    options: &SphereFitOptions,
    begun: Option<Vec<Ball>>,
    step: Step<'_>,
) -> Result<Vec<Ball>, ShadowError> {
    let begin = begun.unwrap_or_else(|| medial_balls(cover.solid, samples, 2 * options.count, true));
    let mut balls = cover.thinned(begin, options.count, step)?;
    while balls.len() < options.count {
        balls.push(Ball { center: cover.points[balls.len() % cover.points.len()], ..Ball::NONE });
    }
    Ok(balls)
}

/// The same spheres, whose centers count from another origin.
fn moved_to(set: &SphereSet, origin: [f64; 3]) -> Result<SphereSet, ShadowError> {
    let center = |k: usize| std::array::from_fn(|axis| (set.center(k)[axis] - origin[axis]) as f32);
    SphereSet::new((0..set.len()).map(center).collect(), set.radii().to_vec())
}

fn balls_of(set: &SphereSet) -> Vec<Ball> {
    let ball = |(center, radius): (&[f32; 3], &f32)| Ball {
        center: DVec3::from_array(center.map(f64::from)),
        radius: f64::from(*radius),
        outside: 0.0,
    };
    set.centers().iter().zip(set.radii()).map(ball).collect()
}

/// What decides the result.
fn fingerprint(scene: &Scene, start: Option<&SphereSet>, options: &SphereFitOptions) -> Fingerprint {
    let SphereFitOptions { count, samples, rounds, tolerance, seed, .. } = options;
    let mut fingerprint = Fingerprint::of_kind(KIND);
    let words = [*count, *samples, *rounds, scene.triangle_count()].map(|n| n as u64);
    fingerprint.words(words.into_iter().chain([tolerance.to_bits(), *seed]).collect::<Vec<_>>().into_iter());
    scene.corners().for_each(|corners| fingerprint.floats(corners.as_flattened()));
    if let Some(set) = start {
        fingerprint.floats(set.centers().as_flattened());
        fingerprint.floats(set.radii());
    }
    fingerprint
}

/// The state after a round, or before it begins: then there are more balls than are asked for.
struct Round {
    energy: f64,
    balls: Vec<Ball>,
}

/// The most balls of a state.
fn most_balls(count: usize) -> usize {
    2 * count
}

impl Round {
    fn of(balls: Vec<Ball>) -> Self {
        Self { energy: energy(&balls), balls }
    }

    /// The record of a state: its energy, the number of its balls, these, and zeros for as many as it might have.
    fn bytes(&self, count: usize) -> Vec<u8> {
        let balls = self.balls.iter().flat_map(|b| [b.center.x, b.center.y, b.center.z, b.radius, b.outside]);
        let numbers = [self.energy, self.balls.len() as f64].into_iter().chain(balls).chain(iter::repeat(0.0));
        numbers.take(Self::numbers(count)).flat_map(f64::to_le_bytes).collect()
    }

    /// Numbers of a record.
    fn numbers(count: usize) -> usize {
        2 + 5 * most_balls(count)
    }

    fn from_bytes(bytes: &[u8]) -> Self {
        let numbers: Vec<f64> = bytes.as_chunks().0.iter().map(|b| f64::from_le_bytes(*b)).collect();
        let balls = numbers[2..].as_chunks().0.iter();
        let ball = |&[x, y, z, radius, outside]: &[f64; 5]| Ball { center: DVec3::new(x, y, z), radius, outside };
        Self { energy: numbers[0], balls: balls.map(ball).take(numbers[1] as usize).collect() }
    }
}

/// Rounds until little is gained, and the energy after each.
fn run_rounds(
    cover: &Cover<'_>,
    first: impl FnOnce(Option<Vec<Ball>>, Step<'_>) -> Result<Vec<Ball>, ShadowError>,
    options: &SphereFitOptions,
    fingerprint: &Fingerprint,
    mut job: Job<'_>,
) -> Result<(Vec<Ball>, Vec<f64>), ShadowError> {
    let start = Instant::now();
    let (mut begun, mut rounds): (Vec<Round>, Vec<Round>) = (Vec::new(), Vec::new());
    let (total, bytes) = (options.rounds + 1, size_of::<f64>() * Round::numbers(options.count));
    let layout = RecordLayout { count: START_STEPS + total, bytes, last: bytes };
    let mut file = match job.checkpoint() {
        Some(path) => Some(RecordFile::open(path, &FORMAT, layout, fingerprint, None, |bytes| {
            let round = Round::from_bytes(bytes);
            if round.balls.len() > options.count { begun.push(round) } else { rounds.push(round) }
        })?),
        None => None,
    };
    let resumed = rounds.len();
    let progress = |done: usize, total: usize| Progress {
        done,
        total,
        resumed,
        elapsed: start.elapsed(),
        is_bound: done < total,
        ..Progress::default()
    };
    if rounds.is_empty() {
        let (mut kept, mut is_kept) = (begun.len(), !begun.is_empty());
        let mut step = |balls: &[Ball]| {
            if let Some(file) = file.as_mut().filter(|_| !is_kept && kept < START_STEPS) {
                file.push(Round::of(balls.to_vec()).bytes(options.count))?;
                kept += 1;
            }
            is_kept = false;
            go_on(&mut job, &progress(0, total), &mut file)
        };
        let balls = first(begun.pop().map(|state| state.balls), &mut step)?;
        keep(&mut rounds, &mut file, balls)?;
    }
    while !is_done(&rounds, options) {
        go_on(&mut job, &progress(rounds.len(), total), &mut file)?;
        let last = rounds.last().map_or(&[][..], |round| &round.balls);
        let balls = if rounds.len().is_multiple_of(2) { cover.tightened(last) } else { cover.round(last) };
        keep(&mut rounds, &mut file, balls)?;
    }
    let done = rounds.len();
    // All is done, so nothing is left to stop.
    let _ = job.report(&progress(done, done));
    let history = rounds.iter().map(|round| round.energy).collect();
    Ok((rounds.pop().map_or_else(Vec::new, |round| round.balls), history))
}

/// Ends the work if its watch says so, with all that is kept on the disk.
fn go_on(job: &mut Job<'_>, progress: &Progress, file: &mut Option<RecordFile>) -> Result<(), ShadowError> {
    if job.report(progress).is_continue() {
        return Ok(());
    }
    if let Some(file) = file {
        file.sync()?;
    }
    Err(ShadowError::Cancelled)
}

/// Appends a round, also to the file. The spheres of earlier ones are no longer needed.
fn keep(rounds: &mut Vec<Round>, file: &mut Option<RecordFile>, balls: Vec<Ball>) -> Result<(), ShadowError> {
    let round = Round::of(balls);
    if let Some(file) = file {
        file.push(round.bytes(round.balls.len()))?;
    }
    if let Some(last) = rounds.last_mut() {
        last.balls = Vec::new();
    }
    rounds.push(round);
    Ok(())
}

/// Whether there were enough rounds, or the last two gained little.
fn is_done(rounds: &[Round], options: &SphereFitOptions) -> bool {
    let Some(last) = rounds.last() else { return false };
    let gains_little = rounds.len().checked_sub(1 + WINDOW).is_some_and(|before| {
        rounds[before].energy - last.energy <= WINDOW as f64 * options.tolerance * last.energy.abs()
    });
    rounds.len() > options.rounds || gains_little
}

/// The set in single precision, and its energy. Each radius is the next larger number that reaches all points of its
/// sphere, or that of its ball if balls do not shrink.
fn rounded(cover: &Cover<'_>, balls: &[Ball], shrinks: bool) -> Result<(SphereSet, f64), ShadowError> {
    let groups = cover.assigned(balls);
    let (mut centers, mut radii, mut outside) = (Vec::new(), Vec::new(), 0.0);
    for (ball, group) in balls.iter().zip(&groups) {
        let center = ball.center.as_vec3();
        let reach = reach(center.as_dvec3(), group);
        let radius = if shrinks { reach } else { reach.max(ball.radius) };
        let radius = if radius > 0.0 { (radius as f32).next_up() } else { 0.0 };
        outside += cover.solid.outside(center.as_dvec3(), f64::from(radius));
        centers.push(center.to_array());
        radii.push(radius);
    }
    Ok((SphereSet::new(centers, radii)?, outside))
}
