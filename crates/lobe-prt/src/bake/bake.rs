//! Baking transfer.

use std::ops::ControlFlow;
use std::path::Path;
use std::time::Instant;

use lobe_scene::{Bvh, Scene};

use crate::bake::diffuse::Diffuse;
use crate::bake::pilot::{Pilot, pilot};
use crate::job::checkpoint::Checkpoint;
use crate::job::chunks::{Job, Memory, OnProgress, Tally, run};
use crate::job::fingerprint::Fingerprint;
use crate::job::stored_rows::StoredRows;
use crate::{BakeOptions, BakeReport, Progress, PrtError, Receivers, StoredTransfer, Transfer};

/// Bakes what receivers in a scene do to light.
///
/// ```text
///   Tᵢ = ρ/π ∫ max(n·s, 0) L_in(s; yᵢ) ds
///   L_in(s; yᵢ) = yᵢ(s) where the ray escapes, else B of what it hits, 0 after the last bounce
/// ```
///
/// This is the transfer of [Sloan, Kautz and Snyder 2002], who take light that is sent on from the vertices around a hit.
/// Here nothing is interpolated: paths from each receiver are followed until they escape, so that the expectation
/// is exact for any number of them. Surfaces are Lambert with the base color, metals too; alpha masks have holes; back sides reflect where the material is
/// double-sided and are black elsewhere. Directions are scrambled Sobol' points, independent from receiver to
/// receiver. Coefficients depend on the arguments alone, not on the number of threads.
///
/// `progress` is called about once a second and at the end, and may stop the bake.
///
/// ```
/// use std::ops::ControlFlow;
/// use lobe_prt::{BakeOptions, Mode, Receivers, bake};
/// use lobe_scene::{Bvh, built_in};
///
/// let scene = built_in::ball_over_ground(8);
/// let receivers = Receivers::at_vertices(&scene)?;
/// let options = BakeOptions { mode: Mode::Shadowed, order: 3, samples: 64, ..BakeOptions::default() };
/// let (transfer, report) = bake(&scene, &Bvh::new(&scene), &receivers, &options, &mut |_| ControlFlow::Continue(()))?;
/// assert_eq!((transfer.receivers(), report.rays), (receivers.len(), 64 * receivers.len() as u64));
/// # Ok::<(), lobe_prt::PrtError>(())
/// ```
///
/// # Errors
/// [`PrtError::Options`] if an option is out of its range or the tree is of another scene; [`PrtError::Cancelled`] if
/// `progress` breaks.
pub fn bake(
    scene: &Scene,
    bvh: &Bvh,
    receivers: &Receivers,
    options: &BakeOptions,
    progress: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Result<(Transfer, BakeReport), PrtError> {
    let bake = prepare(scene, bvh, receivers, options)?;
    let channels = bake.job.channels;
    let (rows, report) = bake.in_memory(progress)?;
    Ok((Transfer::new(options.order, channels, rows)?, report))
}

/// [`fn@bake`], with results in the file `checkpoint`, from where they are written or loaded.
///
/// If the file is there, the bake continues from it: one that was stopped, or killed at any moment, ends with the same
/// bytes as one that ran through. Results go to the file about once a second, and reach the disk within 10 s; where
/// receivers have so many paths that one takes longer, when it is done. The file has its final size from the start, so
/// that a full disk is found before the work. The caller removes it when the results are safe.
///
/// Beside the scene, its tree and the receivers, memory holds 4 MiB of results for each thread, however many there are.
///
/// # Errors
/// Those of [`fn@bake`]; [`PrtError::Io`] if the file cannot be written or the disk has no room for it;
/// [`PrtError::Invalid`] if it is that of another bake, no checkpoint, or in use.
pub fn bake_resumable(
    scene: &Scene,
    bvh: &Bvh,
    receivers: &Receivers,
    options: &BakeOptions,
    checkpoint: &Path,
    progress: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Result<(StoredTransfer, BakeReport), PrtError> {
    let bake = prepare(scene, bvh, receivers, options)?;
    let channels = bake.job.channels;
    let mut fingerprint = Fingerprint::of_kind(KIND);
    fingerprint.scene(scene);
    fingerprint.receivers(receivers);
    fingerprint.options(options);
    let (rows, report) = bake.on_disk(checkpoint, fingerprint, progress)?;
    Ok((StoredTransfer { order: options.order, channels, rows }, report))
}

/// The number of this kind of job in fingerprints.
const KIND: u64 = 1;

/// A job whose number of bounces is known, as all kinds of bakes do it.
pub(crate) struct PreparedBake<J> {
    pub(crate) job: J,
    pilot: Pilot,
    start: Instant,
}

impl<J: Job> PreparedBake<J> {
    /// Finds how many bounces to bake, and has the job told.
    pub(crate) fn new(job: J, energy_stop: f64, limit_bounces: impl FnOnce(&mut J, usize)) -> Self {
        let (mut job, start) = (job, Instant::now());
        let pilot = pilot(&job, energy_stop);
        limit_bounces(&mut job, pilot.bounces);
        Self { job, pilot, start }
    }

    /// Does the job and keeps what it finds in memory.
    pub(crate) fn in_memory(self, progress: OnProgress<'_>) -> Result<(Vec<f32>, BakeReport), PrtError> {
        let mut memory = Memory::default();
        run(&self.job, &mut memory, progress)?;
        let report = self.report(&memory.tally);
        Ok((memory.rows, report))
    }

    /// Does what a checkpoint has not yet of the job.
    pub(crate) fn on_disk(
        self,
        checkpoint: &Path,
        fingerprint: Fingerprint,
        progress: OnProgress<'_>,
    ) -> Result<(StoredRows, BakeReport), PrtError> {
        let mut checkpoint = Checkpoint::open(checkpoint, &self.job, fingerprint, self.pilot.bounces)?;
        let outcome = run(&self.job, &mut checkpoint, progress);
        if outcome.is_err() {
            checkpoint.sync()?;
        }
        outcome?;
        let (tally, rows) = checkpoint.finish()?;
        Ok((rows, self.report(&tally)))
    }

    /// The report of a bake whose chunks add up to `tally`.
    fn report(&self, tally: &Tally) -> BakeReport {
        let receivers = self.job.receivers();
        let mean = |sum: f64| sum / receivers as f64;
        BakeReport {
            receivers,
            rays: tally.rays,
            seconds: self.start.elapsed().as_secs_f64(),
            bounces: self.pilot.bounces,
            energy_per_bounce: tally.energy.iter().copied().map(mean).collect(),
            energy_left: mean(tally.left),
            stderr_dc: self.pilot.stderr_dc,
        }
    }
}

/// Checks the arguments.
fn prepare<'a>(
    scene: &'a Scene,
    bvh: &'a Bvh,
    receivers: &'a Receivers,
    options: &'a BakeOptions,
) -> Result<PreparedBake<Diffuse<'a>>, PrtError> {
    options.check()?;
    check_tree(scene, bvh)?;
    let job = Diffuse::new(scene, bvh, receivers, options);
    Ok(PreparedBake::new(job, options.energy_stop, |job, bounces| job.bounces = bounces))
}

/// Refuses the tree of another scene.
pub(crate) fn check_tree(scene: &Scene, bvh: &Bvh) -> Result<(), PrtError> {
    let (expected, found) = (scene.triangle_count(), bvh.triangle_count());
    if expected == found {
        return Ok(());
    }
    Err(PrtError::Options(format!("expected the tree of the scene's {expected} triangles, found one of {found}")))
}
