//! Rows of numbers found in parallel, watched, and kept on disk while they are found.

use lobe_io::{Fingerprint, Job, Progress, RecordFile, RecordFormat, RecordLayout, Shard, parallel};
use web_time::{Duration, Instant};

use crate::error::ShadowError;

/// Rows of a record. The pieces are the same for any number of threads.
const CHUNK: usize = 32;

/// The time between two reports, about.
const WAVE: Duration = Duration::from_millis(500);

/// A table to make.
pub(crate) struct RowWork {
    pub(crate) rows: usize,
    pub(crate) width: usize,
    /// Rays for each row.
    pub(crate) rays: u64,
    pub(crate) format: RecordFormat,
    pub(crate) fingerprint: Fingerprint,
}

/// All rows or those of a shard, each found by `estimate` from its number alone, and so the same for any number of threads.
///
/// # Errors
/// [`ShadowError::Cancelled`] if the job says so, and those of its checkpoint.
pub(crate) fn bake_rows<S>(
    work: &RowWork,
    shard: Option<Shard>,
    mut job: Job<'_>,
    scratch: &(dyn Fn() -> S + Sync),
    estimate: &(dyn Fn(usize, &mut S, &mut [f32]) + Sync),
) -> Result<Vec<f32>, ShadowError> {
    let chunks = work.rows.div_ceil(CHUNK);
    let range = shard.unwrap_or(Shard::WHOLE).range(chunks);
    let (first, end) = (range.start * CHUNK, (range.end * CHUNK).min(work.rows));
    let total = end.saturating_sub(first);
    let mut rows: Vec<f32> = Vec::with_capacity(total * work.width);
    let mut records = match job.checkpoint() {
        Some(path) if chunks > 0 => {
            Some(RecordFile::open(path, &work.format, layout(work), &work.fingerprint, shard, |bytes| {
                rows.extend(bytes.as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)));
            })?)
        }
        _ => None,
    };
    let (begin, resumed) = (Instant::now(), rows.len() / work.width);
    let mut wave = rayon::current_num_threads();
    loop {
        // Tell how far it is; end where the job says so, or all is done.
        let done = rows.len() / work.width;
        let rays = (done - resumed) as u64 * work.rays;
        let progress = Progress { done, total, resumed, rays, elapsed: begin.elapsed(), ..Progress::default() };
        if job.report(&progress).is_break() {
            return Err(ShadowError::Cancelled);
        }
        if done >= total {
            break;
        }
        // Find some chunks in parallel, and keep them in their order.
        let start = Instant::now();
        let next = (first + done) / CHUNK;
        let found: Vec<Vec<f32>> = parallel::map_with(wave.min(range.end - next), scratch, &|scratch: &mut S, k| {
            let range = (next + k) * CHUNK..((next + k + 1) * CHUNK).min(work.rows);
            let mut out = vec![0.0; range.len() * work.width];
            range.zip(out.chunks_exact_mut(work.width)).for_each(|(row, out)| estimate(row, scratch, out));
            out
        });
        for chunk in found {
            if let Some(records) = &mut records {
                records.push(chunk.iter().flat_map(|x| x.to_le_bytes()).collect())?;
            }
            rows.extend(chunk);
        }
        let factor = (WAVE.as_secs_f64() / start.elapsed().as_secs_f64().max(1e-6)).min(2.0);
        wave = ((wave as f64 * factor) as usize).max(rayon::current_num_threads());
    }
    if let Some(records) = &mut records {
        records.sync()?;
    }
    Ok(rows)
}

fn layout(work: &RowWork) -> RecordLayout {
    let (count, row) = (work.rows.div_ceil(CHUNK), work.width * size_of::<f32>());
    RecordLayout { count, bytes: CHUNK * row, last: (work.rows - (count - 1) * CHUNK) * row }
}
