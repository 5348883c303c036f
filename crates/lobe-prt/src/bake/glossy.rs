//! Glossy transfer: the transfer matrices of receivers or of points in space, by Monte Carlo sampling.

use std::f64::consts::{PI, TAU};

use lobe_io::{Fingerprint, Job, Shard};
use lobe_scene::{Bvh, Ray, Scene, SurfaceRays};

use crate::bake::bake::{PreparedBake, check_tree};
use crate::bake::outer_sum::OuterSum;
use crate::bake::pilot::KnownPilot;
use crate::bake::tracer::{PathEnd, Tracer};
use crate::job::chunks::{Estimator, Tally};
use crate::job::fingerprint::{fingerprint_arithmetic, fingerprint_scene};
use crate::receivers::planes::is_below;
use crate::sampling::sobol::{Sobol, coherent_order};
use crate::sampling::warp::{Frame, sphere};
use crate::{BakeMode, BakeOptions, BakeReport, Channels, PrtError, Receivers, StoredMatrices, TransferMatrices};

/// Bakes the transfer matrix of every receiver; its albedo is not in it.
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
    let channels = bake.estimator.channels;
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
    let channels = bake.estimator.channels;
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
    let matrices = Matrices {
        tracer: Tracer(SurfaceRays::new(scene, bvh)),
        points,
        options,
        bounces: options.most_bounces(),
        channels: options.channels_for(scene, true),
        order: coherent_order(options.samples),
    };
    Ok(PreparedBake::new(matrices, options.energy_stop, known, |matrices, bounces| matrices.bounces = bounces))
}

/// The estimator of matrices:
///
/// ```text
///   M_ij ≈ |Ω|/N Σ_k w_k yᵢ(a_k) yⱼ(b_k),    path k starts along a_k, uniform over Ω, and escapes along b_k
/// ```
#[derive(Debug)]
struct Matrices<'a> {
    tracer: Tracer<'a>,
    points: Points<'a>,
    options: &'a BakeOptions,
    bounces: usize,
    channels: Channels,
    order: Vec<u32>,
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
        self.options.write_into(&mut fingerprint);
        fingerprint_arithmetic(&mut fingerprint);
        fingerprint
    }

    /// The end of the path that starts along a ray.
    fn end(&self, ray: Ray, sobol: &Sobol, index: u32, rays: &mut u64) -> PathEnd {
        match self.options.mode {
            BakeMode::Unshadowed => PathEnd::Escaped { direction: ray.direction, throughput: [1.0; 3], bounce: 0 },
            _ => self.tracer.follow(ray, self.bounces, sobol, index, rays),
        }
    }
}

impl Estimator for Matrices<'_> {
    type Scratch = OuterSum;

    fn receivers(&self) -> usize {
        self.points.positions.len()
    }

    fn row(&self) -> usize {
        self.options.order.pow(4) * self.channels.count()
    }

    fn paths(&self) -> usize {
        self.order.len()
    }

    fn scratch(&self) -> OuterSum {
        OuterSum::new(self.options.order, self.channels.count())
    }

    fn seed(&self) -> u64 {
        self.options.seed
    }

    fn estimate(&self, seed: u64, receiver: usize, sum: &mut OuterSum, row: &mut [f32]) -> Tally {
        let position = self.points.positions[receiver];
        let normal = self.points.receivers.map(|receivers| receivers.normals()[receiver]);
        let planes = self.points.receivers.map_or(&[][..], |receivers| receivers.planes(receiver));
        let place = position.into_iter().chain(normal.into_iter().flatten());
        let sobol = Sobol::at_place(seed, place, self.bounces);
        let frame = normal.map(Frame::about);
        let lift = self.points.receivers.map(|receivers| receivers.lift(receiver));
        let origin = lift.map_or(position, |lift| self.tracer.origin_above(position, lift));
        let part = 1.0 / f64::from(self.options.samples);
        let energy = |throughput: [f32; 3]| part * throughput.iter().map(|&w| f64::from(w)).sum::<f64>() / 3.0;
        let mut tally = Tally { energy: vec![0.0; self.bounces + 1], ..Tally::default() };
        for &index in &self.order {
            // Start a path uniformly over the hemisphere, or over the sphere.
            let point = sobol.point(index, 0);
            let first = frame.map_or_else(|| sphere(point), |frame| frame.hemisphere(point));
            if self.options.mode != BakeMode::Unshadowed && is_below(planes, first) {
                continue;
            }
            // Follow it to its end.
            match self.end(Ray::new(origin, first), &sobol, index, &mut tally.rays) {
                // Add the basis at both ends of the path, times its throughput.
                PathEnd::Escaped { direction, throughput, bounce } => {
                    sum.push(first, direction, throughput);
                    tally.energy[bounce] += energy(throughput);
                }
                PathEnd::Left { throughput } => tally.left += energy(throughput),
                PathEnd::Absorbed => {}
            }
        }
        sum.take_into(part * if frame.is_some() { TAU } else { 4.0 * PI }, row);
        tally
    }
}
