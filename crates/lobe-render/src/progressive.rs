//! Pixels in parallel, with somebody asked now and then whether to go on.

use std::time::{Duration, Instant};

use rayon::prelude::*;

use crate::RenderError;

/// About how long work goes on unasked: whoever says to stop is not kept waiting, and threads seldom wait for each other.
const PORTION: Duration = Duration::from_millis(250);

/// What `of` says of numbers 0 to `count`, of which those in `done` are known.
///
/// `ask` is shown what is known, before the first portion and after each, and may stop the work by an error. How large
/// portions are depends on the clock, what comes out does not.
pub(crate) fn in_portions<T: Send>(
    mut done: Vec<T>,
    count: usize,
    of: impl Fn(usize) -> T + Sync,
    mut ask: impl FnMut(&[T]) -> Result<(), RenderError>,
) -> Result<Vec<T>, RenderError> {
    let least = rayon::current_num_threads();
    let mut portion = least;
    ask(&done)?;
    // At once: growing takes up to three times as much for a while.
    done.reserve_exact(count.saturating_sub(done.len()));
    while done.len() < count {
        let start = Instant::now();
        let next = done.len()..(done.len() + portion).min(count);
        done.par_extend(next.into_par_iter().map(&of));
        let elapsed = start.elapsed();
        if elapsed < PORTION / 2 {
            portion *= 2;
        } else if elapsed > PORTION {
            portion = (portion / 2).max(least);
        }
        ask(&done)?;
    }
    Ok(done)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn portions_follow_each_other_without_a_gap() {
        let mut asked = Vec::new();
        let found = in_portions(
            vec![0, 1, 4],
            10_000,
            |i| i * i,
            |done| {
                asked.push(done.len());
                Ok(())
            },
        );
        assert_eq!(found.unwrap(), (0..10_000).map(|i| i * i).collect::<Vec<_>>(), "squares");
        assert!(asked.is_sorted_by(|a, b| a < b), "{asked:?}");
        assert_eq!((asked[0], asked[asked.len() - 1]), (3, 10_000), "{asked:?}");
    }

    #[test]
    fn whoever_is_asked_can_stop_the_work() {
        let stop = |done: &[usize]| if done.len() > 1 { Err(RenderError::Cancelled) } else { Ok(()) };
        assert!(matches!(in_portions(vec![], 1_000_000, |i| i, stop), Err(RenderError::Cancelled)), "stopped");
    }
}
