//! Progressive rendering: pixels in parallel, in portions after which the work can be watched and stopped.

use lobe_io::{Portions, Progress};
use rayon::prelude::*;
use web_time::{Duration, Instant};

use crate::error::RenderError;

/// The time that a portion takes, about: short enough to stop without delay, long enough that threads seldom wait for
/// each other.
const PORTION: Duration = Duration::from_millis(250);

/// Computes `of(0)` to `of(count - 1)`, of which the first ones are in `done` already.
///
/// `ask` is shown the results so far, before the first portion and after each, and may stop the work by an error. The
/// size of portions depends on the clock, the results do not.
pub(crate) fn in_portions<T: Send>(
    mut done: Vec<T>,
    count: usize,
    of: &(dyn Fn(usize) -> T + Sync),
    ask: &mut dyn FnMut(&[T]) -> Result<(), RenderError>,
) -> Result<Vec<T>, RenderError> {
    let mut portions = Portions::new(PORTION, rayon::current_num_threads());
    ask(&done)?;
    // At once: growing takes up to three times as much for a while.
    done.reserve_exact(count.saturating_sub(done.len()));
    while done.len() < count {
        let next = done.len()..done.len().saturating_add(portions.size()).min(count);
        portions.time(|| done.par_extend(next.into_par_iter().map(of)));
        ask(&done)?;
    }
    Ok(done)
}

/// The progress of a run that began with `resumed` of `total` steps done.
pub(crate) fn progress_of(done: usize, total: usize, resumed: usize, begin: Instant) -> Progress {
    Progress { done, total, resumed, elapsed: begin.elapsed(), ..Progress::default() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn portions_follow_each_other_without_a_gap() {
        let mut asked = Vec::new();
        let found = in_portions(vec![0, 1, 4], 10_000, &|i| i * i, &mut |done| {
            asked.push(done.len());
            Ok(())
        });
        assert_eq!(found.unwrap(), (0..10_000).map(|i| i * i).collect::<Vec<_>>(), "squares");
        assert!(asked.is_sorted_by(|a, b| a < b), "{asked:?}");
        assert_eq!((asked[0], asked[asked.len() - 1]), (3, 10_000), "{asked:?}");
    }

    #[test]
    fn whoever_is_asked_can_stop_the_work() {
        let mut stop = |done: &[usize]| if done.len() > 1 { Err(RenderError::Cancelled) } else { Ok(()) };
        assert!(matches!(in_portions(vec![], 1_000_000, &|i| i, &mut stop), Err(RenderError::Cancelled)), "stopped");
    }
}
