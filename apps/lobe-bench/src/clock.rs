//! The time of work that is repeated.

use std::time::{Duration, Instant};

/// A sample takes this long at least, ten thousand times what the clock of any system resolves.
const SAMPLE: Duration = Duration::from_millis(1);

/// Samples at least, of work that takes longer than there is time for.
const LEAST_SAMPLES: usize = 3;

/// The nanoseconds that work takes: the least of the samples of `time`, since everything that disturbs makes it slower.
pub(crate) fn nanoseconds(time: Duration, mut work: impl FnMut()) -> f64 {
    // Once for the pages and the caches.
    work();
    let begun = Instant::now();
    work();
    let once = begun.elapsed().max(Duration::from_nanos(1));
    let repeats = (SAMPLE.as_nanos() / once.as_nanos()).max(1) as u32;
    let (begun, mut least, mut samples) = (Instant::now(), Duration::MAX, 0);
    while samples < LEAST_SAMPLES || begun.elapsed() < time {
        let sample = Instant::now();
        for _ in 0..repeats {
            work();
        }
        least = least.min(sample.elapsed());
        samples += 1;
    }
    least.as_nanos() as f64 / f64::from(repeats)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_is_done_at_least_five_times() {
        // One run warms up, one is timed for the number of repeats, and three samples follow.
        let mut runs = 0;
        let found = nanoseconds(Duration::ZERO, || {
            runs += 1;
            std::thread::sleep(SAMPLE);
        });
        assert!(runs == 5 && found >= SAMPLE.as_nanos() as f64, "{runs} runs, {found} ns");
    }
}
