//! Glossy transfer: the transfer matrices of receivers or of points in space, by Monte Carlo sampling.

use std::f64::consts::{PI, TAU};

use lobe_io::{Fingerprint, Job, Shard};
use lobe_scene::{Bvh, Scene, SurfaceRays};

use crate::bake::bake::{PreparedBake, check_tree};
use crate::bake::options::{BakeMode, BakeOptions, BakeReport};
use crate::bake::outer_sum::OuterSum;
use crate::bake::pilot::{KnownPilot, Piloted};
use crate::bake::point_transfer::{PathStart, PointTransfer};
use crate::bake::tracer::{PathEnd, Starts, Tracer};
use crate::error::PrtError;
use crate::job::chunks::{Estimator, Tally};
use crate::job::fingerprint::{fingerprint_arithmetic, fingerprint_scene};
use crate::receivers::planes::is_below;
use crate::receivers::receivers::Receivers;
use crate::sampling::sobol::{Sobol, coherent_order};
use crate::sampling::warp::{Frame, sphere};
use crate::transfer::transfer::Channels;
use crate::transfer::transfer_matrices::TransferMatrices;
use crate::transfer::transfer_rows::StoredMatrices;

/// Bakes the transfer matrix of every receiver; its albedo is not in it. Those of the vertices of a scene are better
/// [fitted](crate::FittedVertices::bake_matrices).
///
/// [`BakeOptions`] mean what they mean to [`fn@crate::bake`]; directions are uniform over the hemisphere. With
/// [`BakeMode::Unshadowed`] nothing is in the way. Memory: `4 n⁴` bytes for each receiver and channel, 1 KiB at order 4.
///
/// # Errors
/// Those of [`fn@crate::bake`].
pub fn bake_matrices(
    scene: &Scene,
    bvh: &Bvh,
    receivers: &Receivers,
    options: &BakeOptions,
    job: Job<'_>,
) -> Result<(TransferMatrices, BakeReport), PrtError> {
    bake_points(scene, bvh, Points::of(receivers), options, job)
}

/// The points that matrices are baked for: receivers on surfaces, or points in space.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Points<'a> {
    pub(crate) positions: &'a [[f32; 3]],
    /// The receivers at these positions, if they are on surfaces.
    pub(crate) receivers: Option<&'a Receivers>,
}

impl<'a> Points<'a> {
    pub(crate) fn of(receivers: &'a Receivers) -> Self {
        Self { positions: receivers.positions(), receivers: Some(receivers) }
    }
}

pub(crate) fn bake_points(
    scene: &Scene,
    bvh: &Bvh,
    points: Points<'_>,
    options: &BakeOptions,
    job: Job<'_>,
) -> Result<(TransferMatrices, BakeReport), PrtError> {
    let bake = prepare(scene, bvh, points, options, &KnownPilot::new())?;
    let channels = bake.estimator.paths.channels;
    let (rows, report) = bake.run(|matrices| matrices.fingerprint(scene), job)?;
    Ok((TransferMatrices::new(options.order, channels, rows)?, report))
}

/// [`bake_matrices`] of any points with results that stay in the checkpoint, as [`crate::bake_on_disk`] leaves them. The pilot may be
/// known from a shard of the same bake.
pub(crate) fn bake_points_on_disk(
    scene: &Scene,
    bvh: &Bvh,
    points: Points<'_>,
    options: &BakeOptions,
    job: Job<'_>,
    known: &KnownPilot,
) -> Result<(StoredMatrices, BakeReport), PrtError> {
    let bake = prepare(scene, bvh, points, options, known)?;
    let channels = bake.estimator.paths.channels;
    let (rows, report) = bake.run_on_disk(|matrices| matrices.fingerprint(scene), job)?;
    Ok((StoredMatrices { order: options.order, channels, rows }, report))
}

/// A shard of it.
pub(crate) fn bake_points_shard(
    scene: &Scene,
    bvh: &Bvh,
    points: Points<'_>,
    options: &BakeOptions,
    shard: Shard,
    job: Job<'_>,
    known: &KnownPilot,
) -> Result<BakeReport, PrtError> {
    prepare(scene, bvh, points, options, known)?.run_shard(|matrices| matrices.fingerprint(scene), shard, job)
}

/// Checks the arguments.
fn prepare<'a>(
    scene: &'a Scene,
    bvh: &'a Bvh,
    points: Points<'a>,
    options: &'a BakeOptions,
    known: &KnownPilot,
) -> Result<PreparedBake<Matrices<'a>>, PrtError> {
    options.check()?;
    check_tree(scene, bvh)?;
    let paths = MatrixPaths::new(SurfaceRays::new(scene, bvh), options, coherent_order(options.first_samples()));
    let matrices = Matrices { paths, points };
    Ok(PreparedBake::new(matrices, options, known))
}

/// The paths from a point, summed into its matrix:
///
/// ```text
///   M_ij ≈ |Ω|/N Σ_k w_k yᵢ(a_k) yⱼ(b_k),    path k starts along a_k, uniform over Ω, and escapes along b_k
/// ```
#[derive(Debug)]
pub(crate) struct MatrixPaths<'a> {
    tracer: Tracer<'a>,
    options: &'a BakeOptions,
    bounces: usize,
    pub(crate) channels: Channels,
    /// The numbers of the paths from a point, so that neighbors follow each other.
    order: Vec<u32>,
}

/// The buffers of a thread.
pub(crate) struct MatrixScratch {
    sum: OuterSum,
    starts: Starts,
}

impl<'a> MatrixPaths<'a> {
    /// Paths of these numbers from each point.
    pub(crate) fn new(surfaces: SurfaceRays<'a>, options: &'a BakeOptions, order: Vec<u32>) -> Self {
        let channels = options.channels_for(surfaces.scene(), true);
        Self { tracer: Tracer(surfaces), options, bounces: options.most_bounces(), channels, order }
    }

    /// The sum over paths from an origin, whose first directions are `direction` of points of a sequence, number
    /// `first` and those after it. Those below all planes bring nothing.
    fn sum(
        &self,
        (origin, planes): ([f32; 3], &[[f32; 3]]),
        direction: impl Fn([f32; 2]) -> [f32; 3],
        (sobol, first): (&Sobol, u32),
        scratch: &mut MatrixScratch,
    ) -> Tally {
        let MatrixScratch { sum, starts } = scratch;
        let part = 1.0 / self.order.len() as f64;
        let energy = |throughput: [f32; 3]| part * throughput.iter().map(|&w| f64::from(w)).sum::<f64>() / 3.0;
        let mut tally = Tally { energy: vec![0.0; self.bounces + 1], ..Tally::default() };
        let Tally { rays, energy: escaped, left } = &mut tally;
        let is_open = self.options.mode == BakeMode::Unshadowed;
        // Start paths.
        starts.clear();
        for &index in &self.order {
            let number = first + index;
            let start = direction(sobol.point(number, 0));
            if is_open || !is_below(planes, start) {
                starts.push(start, number);
            }
        }
        // Follow them to their ends.
        let end = |start: [f32; 3], end: PathEnd| match end {
            // Add the basis at both ends of the path, times its throughput.
            PathEnd::Escaped { direction, throughput, bounce } => {
                sum.push(start, direction, throughput);
                escaped[bounce] += energy(throughput);
            }
            PathEnd::Left { throughput } => *left += energy(throughput),
            PathEnd::Absorbed => {}
        };
        if is_open {
            starts.escape(end);
        } else {
            self.tracer.follow_all(origin, starts, self.bounces, sobol, rays, end);
        }
        tally
    }

    /// The factor of the sums over escaping paths of directions in this solid angle.
    fn factor(&self, solid_angle: f64) -> f64 {
        1.0 / self.order.len() as f64 * solid_angle
    }
}

impl PointTransfer for MatrixPaths<'_> {
    type Scratch = MatrixScratch;

    fn row(&self) -> usize {
        self.options.order.pow(4) * self.channels.count()
    }

    fn count(&self) -> usize {
        self.order.len()
    }

    fn bounces(&self) -> usize {
        self.bounces
    }

    fn limit_bounces(&mut self, bounces: usize) {
        self.bounces = bounces;
    }

    fn set_count(&mut self, count: u32) {
        self.order = coherent_order(count);
    }

    fn scratch(&self) -> MatrixScratch {
        let sum = OuterSum::new(self.options.order, self.channels.count());
        MatrixScratch { sum, starts: Starts::default() }
    }

    fn tracer(&self) -> Option<&Tracer<'_>> {
        (self.options.mode != BakeMode::Unshadowed).then_some(&self.tracer)
    }

    fn transfer(&self, start: &PathStart<'_>, scratch: &mut MatrixScratch, row: &mut [f32]) -> Tally {
        let frame = Frame::about(start.normal);
        let origin = self.tracer.origin_above(start.position, start.lift);
        let sequence = (start.sobol, start.first);
        let tally = self.sum((origin, start.planes), |point| frame.hemisphere(point), sequence, scratch);
        scratch.sum.take_into(self.factor(TAU), row);
        tally
    }
}

/// The estimator of matrices of receivers, or of points in space.
#[derive(Debug)]
struct Matrices<'a> {
    paths: MatrixPaths<'a>,
    points: Points<'a>,
}

impl Matrices<'_> {
    /// The kinds of this work among fingerprints: on surfaces, and in space.
    const KINDS: [u64; 2] = [2, 3];

    fn fingerprint(&self, scene: &Scene) -> Fingerprint {
        let mut fingerprint = Fingerprint::of_kind(Self::KINDS[usize::from(self.points.receivers.is_none())]);
        fingerprint_scene(&mut fingerprint, scene);
        match self.points.receivers {
            Some(receivers) => receivers.write_into(&mut fingerprint),
            None => fingerprint.floats(self.points.positions.as_flattened()),
        }
        self.paths.options.write_into(&mut fingerprint);
        fingerprint_arithmetic(&mut fingerprint);
        fingerprint
    }
}

impl Piloted for Matrices<'_> {
    fn limit_bounces(&mut self, bounces: usize) {
        self.paths.limit_bounces(bounces);
    }

    fn set_samples(&mut self, samples: u32) {
        self.paths.set_count(samples);
    }
}

impl Estimator for Matrices<'_> {
    type Scratch = MatrixScratch;

    fn receivers(&self) -> usize {
        self.points.positions.len()
    }

    fn row(&self) -> usize {
        self.paths.row()
    }

    fn paths(&self) -> usize {
        self.paths.count()
    }

    fn scratch(&self) -> MatrixScratch {
        self.paths.scratch()
    }

    fn seed(&self) -> u64 {
        self.paths.options.seed
    }

    fn estimate(&self, seed: u64, point: usize, scratch: &mut MatrixScratch, row: &mut [f32]) -> Tally {
        let position = self.points.positions[point];
        let Some(receivers) = self.points.receivers else {
            let sobol = Sobol::at_place(seed, position.into_iter(), self.paths.bounces);
            let tally = self.paths.sum((position, &[]), sphere, (&sobol, 0), scratch);
            scratch.sum.take_into(self.paths.factor(4.0 * PI), row);
            return tally;
        };
        let normal = receivers.normals()[point];
        let start = PathStart {
            position,
            normal,
            lift: receivers.lift(point),
            planes: receivers.planes(point),
            albedo: [1.0; 3],
            sobol: &Sobol::at_place(seed, position.into_iter().chain(normal), self.paths.bounces),
            first: 0,
        };
        self.paths.transfer(&start, scratch, row)
    }
}
