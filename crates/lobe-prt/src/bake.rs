//! Baking transfer.

use std::ops::ControlFlow;
use std::path::Path;
use std::time::Instant;

use lobe_scene::{Bvh, Scene};

use crate::checkpoint::Checkpoint;
use crate::chunks::{Job, Memory, OnProgress, Tally, run};
use crate::diffuse::Diffuse;
use crate::fingerprint::Fingerprint;
use crate::pilot::{Pilot, pilot};
use crate::stored_rows::StoredRows;
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
/// is exact for any number of them. Surfaces are Lambert with the base colour, metals too; alpha masks have holes; back sides reflect where the material is
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
    let start = Instant::now();
    let (job, pilot) = prepare(scene, bvh, receivers, options)?;
    let (tally, rows) = in_memory(&job, progress)?;
    Ok((Transfer::new(options.order, job.channels, rows)?, report(&job, &pilot, &tally, start)))
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
    let start = Instant::now();
    let (job, pilot) = prepare(scene, bvh, receivers, options)?;
    let mut fingerprint = Fingerprint::of_kind(KIND);
    fingerprint.scene(scene);
    fingerprint.receivers(receivers);
    fingerprint.options(options);
    let (tally, rows) = on_disk(&job, checkpoint, fingerprint, pilot.bounces, progress)?;
    let transfer = StoredTransfer { order: options.order, channels: job.channels, rows };
    Ok((transfer, report(&job, &pilot, &tally, start)))
}

/// The number of this kind of job in fingerprints.
const KIND: u64 = 1;

/// Does a job and keeps what it finds in memory.
pub(crate) fn in_memory<J: Job>(job: &J, progress: OnProgress<'_>) -> Result<(Tally, Vec<f32>), PrtError> {
    let mut memory = Memory::default();
    run(job, &mut memory, progress)?;
    Ok((memory.tally, memory.rows))
}

/// Does what a checkpoint has not yet of a job.
pub(crate) fn on_disk<J: Job>(
    job: &J,
    checkpoint: &Path,
    fingerprint: Fingerprint,
    bounces: usize,
    progress: OnProgress<'_>,
) -> Result<(Tally, StoredRows), PrtError> {
    let mut checkpoint = Checkpoint::open(checkpoint, job, fingerprint, bounces)?;
    let outcome = run(job, &mut checkpoint, progress);
    if outcome.is_err() {
        checkpoint.sync()?;
    }
    outcome?;
    checkpoint.finish()
}

/// Checks the arguments and finds how many bounces to bake.
pub(crate) fn prepare<'a>(
    scene: &'a Scene,
    bvh: &'a Bvh,
    receivers: &'a Receivers,
    options: &'a BakeOptions,
) -> Result<(Diffuse<'a>, Pilot), PrtError> {
    options.check()?;
    check_tree(scene, bvh)?;
    let mut job = Diffuse::new(scene, bvh, receivers, options);
    let pilot = pilot(&job, options.energy_stop);
    job.bounces = pilot.bounces;
    Ok((job, pilot))
}

/// Refuses the tree of another scene.
pub(crate) fn check_tree(scene: &Scene, bvh: &Bvh) -> Result<(), PrtError> {
    let (expected, found) = (scene.triangle_count(), bvh.triangle_count());
    if expected == found {
        return Ok(());
    }
    Err(PrtError::Options(format!("expected the tree of the scene's {expected} triangles, found one of {found}")))
}

/// The report of a bake whose chunks add up to `tally`.
pub(crate) fn report<J: Job>(job: &J, pilot: &Pilot, tally: &Tally, start: Instant) -> BakeReport {
    let receivers = job.receivers();
    let mean = |sum: f64| sum / receivers as f64;
    BakeReport {
        receivers,
        rays: tally.rays,
        seconds: start.elapsed().as_secs_f64(),
        bounces: pilot.bounces,
        energy_per_bounce: tally.energy.iter().copied().map(mean).collect(),
        energy_left: mean(tally.left),
        stderr_dc: pilot.stderr_dc,
    }
}
