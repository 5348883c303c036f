//! The bake loop: receivers in chunks, estimated in parallel with results that do not depend on the number of threads.

use std::ops::{AddAssign, Range};

use lobe_io::{Job, Portions, Progress, Shard, parallel};
use web_time::{Duration, Instant};

use crate::error::PrtError;

/// Paths in a chunk, about: some milliseconds of work for one thread.
const CHUNK_PATHS: usize = 1 << 14;

/// Receivers in a chunk, at most.
const CHUNK_RECEIVERS: usize = 64;

/// Work between two reports, about. A bake that is stopped waits no longer than that, or than one chunk takes. One that is
/// killed loses no more either, besides writes that the operating system has not yet made. At the end of a wave threads
/// wait for each other for half the time of a chunk, on average.
const WAVE: Duration = Duration::from_millis(700);

/// Bytes of results of one thread between two reports, at most, where a chunk has not more.
const WAVE_BYTES: usize = 4 << 20;

/// An estimator of a row of numbers for each receiver.
pub(crate) trait Estimator: Sync {
    /// The buffers of a thread.
    type Scratch;

    fn receivers(&self) -> usize;

    /// Numbers found for each receiver.
    fn row(&self) -> usize;

    /// Paths from each receiver.
    fn paths(&self) -> usize;

    fn scratch(&self) -> Self::Scratch;

    /// The seed of the bake.
    fn seed(&self) -> u64;

    /// Finds the numbers of one receiver by the paths of a seed. They depend on nothing else.
    fn estimate(&self, seed: u64, receiver: usize, scratch: &mut Self::Scratch, row: &mut [f32]) -> Tally;
}

/// Sums that a report is made from.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Tally {
    pub(crate) rays: u64,
    /// Exit radiance under a constant sky, by the number of reflections, summed over receivers.
    pub(crate) energy: Vec<f64>,
    /// The same for paths that met a surface at their end.
    pub(crate) left: f64,
}

impl AddAssign<&Self> for Tally {
    fn add_assign(&mut self, other: &Self) {
        self.rays += other.rays;
        self.left += other.left;
        self.energy.resize(self.energy.len().max(other.energy.len()), 0.0);
        self.energy.iter_mut().zip(&other.energy).for_each(|(a, b)| *a += b);
    }
}

/// The results of a run of receivers.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Chunk {
    pub(crate) tally: Tally,
    pub(crate) rows: Vec<f32>,
}

/// All receivers in chunks of equal size, but for the last.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Chunks {
    receivers: usize,
    size: usize,
}

impl Chunks {
    pub(crate) fn of<E: Estimator>(estimator: &E) -> Self {
        let size = (CHUNK_PATHS / estimator.paths().max(1)).clamp(1, CHUNK_RECEIVERS);
        Self { receivers: estimator.receivers(), size }
    }

    pub(crate) fn count(&self) -> usize {
        self.receivers.div_ceil(self.size)
    }

    pub(crate) fn size(&self) -> usize {
        self.size
    }

    pub(crate) fn receivers(&self) -> usize {
        self.receivers
    }

    /// The receivers of one chunk.
    pub(crate) fn range(&self, chunk: usize) -> Range<usize> {
        chunk * self.size..((chunk + 1) * self.size).min(self.receivers)
    }

    /// The number of receivers in the first `chunk` chunks.
    pub(crate) fn before(&self, chunk: usize) -> usize {
        (chunk * self.size).min(self.receivers)
    }
}

/// The destination of chunks, in their order.
pub(crate) trait Sink {
    /// The number of the first chunk that it has not.
    fn done(&self) -> usize;

    /// The chunks that it is for.
    fn shard(&self) -> Shard {
        Shard::WHOLE
    }

    fn push(&mut self, chunk: Chunk) -> Result<(), PrtError>;
}

/// Chunks in memory.
#[derive(Debug, Default)]
pub(crate) struct Memory {
    chunks: usize,
    pub(crate) tally: Tally,
    pub(crate) rows: Vec<f32>,
}

impl Sink for Memory {
    fn done(&self) -> usize {
        self.chunks
    }

    fn push(&mut self, chunk: Chunk) -> Result<(), PrtError> {
        self.chunks += 1;
        self.tally += &chunk.tally;
        self.rows.extend_from_slice(&chunk.rows);
        Ok(())
    }
}

/// Estimates the chunks of a sink that it does not hold yet. Results depend on the estimator alone: chunks are the same for
/// any number of threads, and the sink gets them in their order.
pub(crate) fn run<E: Estimator>(estimator: &E, sink: &mut impl Sink, job: &mut Job<'_>) -> Result<(), PrtError> {
    let chunks = Chunks::of(estimator);
    let start = Instant::now();
    let shard = sink.shard().range(chunks.count());
    let first = chunks.before(shard.start);
    let resumed = chunks.before(sink.done()) - first;
    let mut rays = 0;
    let bytes = size_of::<f32>() * estimator.row() * chunks.size();
    let mut wave = Portions::new(WAVE, rayon::current_num_threads()).at_most(WAVE_BYTES / bytes);
    loop {
        // Report the progress; end where the job says so, or all is done.
        let next = sink.done();
        let (done, total) = (chunks.before(next) - first, chunks.before(shard.end) - first);
        let progress = Progress { done, total, resumed, rays, elapsed: start.elapsed(), ..Progress::default() };
        let is_stopped = job.report(&progress).is_break();
        // A bake that is complete counts as done, not as stopped.
        if next >= shard.end {
            return Ok(());
        }
        if is_stopped {
            return Err(PrtError::Cancelled);
        }
        // Estimate a wave of chunks in parallel.
        let count = wave.size().min(shard.end - next);
        let scratch = || estimator.scratch();
        let of = |scratch: &mut E::Scratch, k: usize| estimate(estimator, chunks.range(next + k), scratch);
        let done: Vec<Chunk> = wave.time(|| parallel::map_with(count, &scratch, &of));
        // Hand them over in their order.
        for chunk in done {
            rays += chunk.tally.rays;
            sink.push(chunk)?;
        }
    }
}

fn estimate<E: Estimator>(estimator: &E, range: Range<usize>, scratch: &mut E::Scratch) -> Chunk {
    let mut chunk = Chunk { tally: Tally::default(), rows: vec![0.0; range.len() * estimator.row()] };
    for (receiver, row) in range.zip(chunk.rows.chunks_exact_mut(estimator.row())) {
        chunk.tally += &estimator.estimate(estimator.seed(), receiver, scratch, row);
    }
    chunk
}
