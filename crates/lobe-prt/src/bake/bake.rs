//! The bake: transfer vectors of receivers, in memory or on disk, by the loop that all bakes share.

use lobe_io::{Fingerprint, Job, Shard};
use lobe_scene::{Bvh, Scene};
use web_time::Instant;

use crate::bake::diffuse::Diffuse;
use crate::bake::options::{BakeMode, BakeOptions, BakeReport};
use crate::bake::pilot::{KnownPilot, Pilot, Piloted, pilot};
use crate::error::PrtError;
use crate::job::checkpoint::Checkpoint;
use crate::job::checkpoint::StoredRows;
use crate::job::chunks::{Chunks, Memory, Tally, run};
use crate::job::fingerprint::{fingerprint_arithmetic, fingerprint_scene};
use crate::receivers::receivers::Receivers;
use crate::transfer::transfer::Transfer;
use crate::transfer::transfer_rows::StoredTransfer;

/// Bakes the transfer vectors of receivers in a scene.
///
/// ```text
///   Tᵢ = ρ/π ∫ max(n·s, 0) L_in(s; yᵢ) ds
///   L_in(s; yᵢ) = yᵢ(s) where the ray escapes, else B of what it hits, 0 after the last bounce
/// ```
///
/// This is the transfer of [Sloan, Kautz and Snyder 2002], who interpolate the light that vertices around a hit send
/// on. Here nothing is interpolated: paths from each receiver are followed until they escape, so that the expectation
/// is exact for any number of them. Surfaces are Lambert with the base color, metals too; alpha masks have holes; back
/// sides reflect where the material is double-sided and are black elsewhere. Directions are scrambled Sobol' points,
/// independent from receiver to receiver. Coefficients depend on the arguments alone, not on the number of threads.
///
/// The job is told about once a second which receivers are done. If it is [kept in a file](Job::kept_in), results go
/// there about once a second, too, and reach the disk within 10 s, or when the receiver in work is done if that takes
/// longer. The file has its final size from the start, so that a full disk is found before the work.
///
/// ```
/// use lobe_io::Job;
/// use lobe_prt::{BakeMode, BakeOptions, Receivers, bake};
/// use lobe_scene::{Bvh, built_in};
///
/// let scene = built_in::ball_over_ground(8);
/// let receivers = Receivers::at_vertices(&scene)?;
/// let options = BakeOptions::default().mode(BakeMode::Shadowed).order(3).samples(64);
/// let (transfer, report) = bake(&scene, &Bvh::new(&scene), &receivers, &options, Job::default())?;
/// assert_eq!((transfer.receivers(), report.rays), (receivers.len(), 64 * receivers.len() as u64));
/// # Ok::<(), lobe_prt::PrtError>(())
/// ```
///
/// # Errors
/// [`PrtError::Options`] if an option is out of its range or the tree is of another scene; [`PrtError::Cancelled`] if
/// the job was told to stop. With a checkpoint, [`PrtError::Io`] if it cannot be written or the disk has no room for it
/// and [`PrtError::Invalid`] if it is that of another bake, no checkpoint, or in use.
pub fn bake(
    scene: &Scene,
    bvh: &Bvh,
    receivers: &Receivers,
    options: &BakeOptions,
    job: Job<'_>,
) -> Result<(Transfer, BakeReport), PrtError> {
    let bake = prepare(scene, bvh, receivers, options, &KnownPilot::new())?;
    let channels = bake.estimator.paths.channels;
    let (rows, report) = bake.run(|_| fingerprint(scene, receivers, options), job)?;
    Ok((Transfer::new(options.order, channels, rows)?, report))
}

/// [`fn@bake`] with results that stay in the checkpoint of the job, from where they are written to another file or
/// loaded.
///
/// Beside the scene, its tree and the receivers, memory holds 4 MiB of results for each thread, however many there are.
///
/// # Errors
/// Those of [`fn@bake`]; [`PrtError::Options`] if the job is not [kept in a file](Job::kept_in).
pub fn bake_on_disk(
    scene: &Scene,
    bvh: &Bvh,
    receivers: &Receivers,
    options: &BakeOptions,
    job: Job<'_>,
) -> Result<(StoredTransfer, BakeReport), PrtError> {
    bake_on_disk_knowing(scene, bvh, receivers, options, job, &KnownPilot::new())
}

/// [`bake_on_disk`] where the pilot may be known from a shard of the same bake.
pub(crate) fn bake_on_disk_knowing(
    scene: &Scene,
    bvh: &Bvh,
    receivers: &Receivers,
    options: &BakeOptions,
    job: Job<'_>,
    known: &KnownPilot,
) -> Result<(StoredTransfer, BakeReport), PrtError> {
    let bake = prepare(scene, bvh, receivers, options, known)?;
    let channels = bake.estimator.paths.channels;
    let (rows, report) = bake.run_on_disk(|_| fingerprint(scene, receivers, options), job)?;
    Ok((StoredTransfer { order: options.order, channels, rows }, report))
}

/// A shard of [`bake_on_disk`], whose results stay in the file of the job. [`lobe_io::merge_shards`] makes a checkpoint of the
/// files of all shards, from which [`bake_on_disk`] takes up everything. The report is about the receivers of the shard.
///
/// # Errors
/// Those of [`bake_on_disk`].
pub fn bake_shard(
    scene: &Scene,
    bvh: &Bvh,
    receivers: &Receivers,
    options: &BakeOptions,
    shard: Shard,
    job: Job<'_>,
) -> Result<BakeReport, PrtError> {
    bake_shard_knowing(scene, bvh, receivers, options, shard, job, &KnownPilot::new())
}

/// [`bake_shard`] where the pilot of another shard of the same bake may be known.
pub(crate) fn bake_shard_knowing(
    scene: &Scene,
    bvh: &Bvh,
    receivers: &Receivers,
    options: &BakeOptions,
    shard: Shard,
    job: Job<'_>,
    known: &KnownPilot,
) -> Result<BakeReport, PrtError> {
    let bake = prepare(scene, bvh, receivers, options, known)?;
    bake.run_shard(|_| fingerprint(scene, receivers, options), shard, job)
}

/// The fingerprint of everything that decides this bake.
fn fingerprint(scene: &Scene, receivers: &Receivers, options: &BakeOptions) -> Fingerprint {
    /// The kind of this work among fingerprints.
    const KIND: u64 = 1;
    let mut fingerprint = Fingerprint::of_kind(KIND);
    fingerprint_scene(&mut fingerprint, scene);
    receivers.write_into(&mut fingerprint);
    options.write_into(&mut fingerprint);
    fingerprint_arithmetic(&mut fingerprint);
    fingerprint
}

/// A bake whose numbers of bounces and paths are known, of any estimator.
pub(crate) struct PreparedBake<E> {
    pub(crate) estimator: E,
    pilot: Pilot,
    start: Instant,
}

impl<E: Piloted> PreparedBake<E> {
    /// Finds the numbers of bounces and paths by the pilot, unless they are known, and sets those of the estimator.
    pub(crate) fn new(mut estimator: E, options: &BakeOptions, known: &KnownPilot) -> Self {
        let start = Instant::now();
        let pilot = *known.get_or_init(|| pilot(&mut estimator, options));
        if pilot.samples != options.first_samples() {
            estimator.set_samples(pilot.samples);
        }
        estimator.limit_bounces(pilot.bounces);
        Self { estimator, pilot, start }
    }

    /// Estimates all rows, or takes them up from a checkpoint.
    pub(crate) fn run(
        self,
        fingerprint: impl FnOnce(&E) -> Fingerprint,
        mut job: Job<'_>,
    ) -> Result<(Vec<f32>, BakeReport), PrtError> {
        if job.checkpoint().is_some() {
            let (rows, report) = self.run_on_disk(fingerprint, job)?;
            return Ok((rows.load()?, report));
        }
        let mut memory = Memory::default();
        run(&self.estimator, &mut memory, &mut job)?;
        let report = self.report(&memory.tally, self.estimator.receivers());
        Ok((memory.rows, report))
    }

    /// Estimates the chunks that the checkpoint does not hold yet.
    pub(crate) fn run_on_disk(
        self,
        fingerprint: impl FnOnce(&E) -> Fingerprint,
        job: Job<'_>,
    ) -> Result<(StoredRows, BakeReport), PrtError> {
        let (tally, rows) = self.checkpoint(fingerprint, None, job)?.finish()?;
        Ok((rows, self.report(&tally, self.estimator.receivers())))
    }

    /// Estimates the chunks of a shard that its file does not hold yet.
    pub(crate) fn run_shard(
        self,
        fingerprint: impl FnOnce(&E) -> Fingerprint,
        shard: Shard,
        job: Job<'_>,
    ) -> Result<BakeReport, PrtError> {
        let tally = self.checkpoint(fingerprint, Some(shard), job)?.close()?;
        let (chunks, range) = (Chunks::of(&self.estimator), shard.range(Chunks::of(&self.estimator).count()));
        Ok(self.report(&tally, chunks.before(range.end) - chunks.before(range.start)))
    }

    /// The checkpoint of all or of a shard, with all of its chunks.
    fn checkpoint(
        &self,
        fingerprint: impl FnOnce(&E) -> Fingerprint,
        shard: Option<Shard>,
        mut job: Job<'_>,
    ) -> Result<Checkpoint, PrtError> {
        let path = job.checkpoint().ok_or_else(|| {
            PrtError::Options("expected a job that is kept in a file, in which the results stay".to_owned())
        })?;
        // Open the checkpoint, which holds the chunks of an earlier run of the same bake.
        let fingerprint = fingerprint(&self.estimator);
        let mut checkpoint = Checkpoint::open(path, &self.estimator, fingerprint, self.pilot.bounces, shard)?;
        // Estimate the other chunks; wait for the disk where that is interrupted.
        let outcome = run(&self.estimator, &mut checkpoint, &mut job);
        if outcome.is_err() {
            checkpoint.sync()?;
        }
        outcome?;
        Ok(checkpoint)
    }

    /// The report of a bake of `receivers` receivers, whose chunks add up to `tally`.
    fn report(&self, tally: &Tally, receivers: usize) -> BakeReport {
        let mean = |sum: f64| sum / receivers.max(1) as f64;
        BakeReport {
            receivers,
            rays: tally.rays,
            seconds: self.start.elapsed().as_secs_f64(),
            samples: self.pilot.samples,
            bounces: self.pilot.bounces,
            energy_per_bounce: tally.energy.iter().copied().map(mean).collect(),
            energy_left: mean(tally.left),
            stderr_dc: self.pilot.stderr_dc,
        }
    }
}

/// Checks the arguments of a bake of vectors.
pub(crate) fn check_of_vectors(scene: &Scene, bvh: &Bvh, options: &BakeOptions) -> Result<(), PrtError> {
    options.check()?;
    if options.mode == BakeMode::Glossy {
        let message = "expected light that receivers reflect, found glossy; bake_matrices bakes the matrices of that";
        return Err(PrtError::Options(message.to_owned()));
    }
    check_tree(scene, bvh)
}

fn prepare<'a>(
    scene: &'a Scene,
    bvh: &'a Bvh,
    receivers: &'a Receivers,
    options: &'a BakeOptions,
    known: &KnownPilot,
) -> Result<PreparedBake<Diffuse<'a>>, PrtError> {
    check_of_vectors(scene, bvh, options)?;
    let diffuse = Diffuse::new(scene, bvh, receivers, options);
    Ok(PreparedBake::new(diffuse, options, known))
}

/// Refuses the tree of another scene.
pub(crate) fn check_tree(scene: &Scene, bvh: &Bvh) -> Result<(), PrtError> {
    let (expected, found) = (scene.triangle_count(), bvh.triangle_count());
    if expected == found {
        return Ok(());
    }
    Err(PrtError::Options(format!("expected the tree of the scene's {expected} triangles, found one of {found}")))
}
