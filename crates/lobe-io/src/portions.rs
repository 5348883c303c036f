//! Portions of long work: how much of it to do between two reports.

use web_time::{Duration, Instant};

/// The steps between two reports of work whose results do not depend on how it is cut: few at first, then as many as the
/// time of the last ones suggests.
///
/// ```
/// use std::time::Duration;
///
/// let mut portions = lobe_io::Portions::new(Duration::from_millis(200), 4);
/// let mut squares = Vec::new();
/// while squares.len() < 1000 {
///     let next = squares.len()..1000.min(squares.len() + portions.size());
///     squares.extend(portions.time(|| next.map(|i| i * i).collect::<Vec<_>>()));
/// }
/// assert_eq!((squares.len(), squares[999]), (1000, 998_001));
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Portions {
    /// The time that each should take.
    time: Duration,
    /// A portion is a multiple of this: one step for each thread.
    unit: usize,
    /// How many of these the next one has, and at most.
    units: usize,
    most: usize,
}

impl Portions {
    /// Portions that take about `time`, each a multiple of `unit` steps, which threads do at once.
    #[must_use]
    pub fn new(time: Duration, unit: usize) -> Self {
        Self { time, unit: unit.max(1), units: 1, most: usize::MAX }
    }

    /// The same, each of `units` units at most.
    #[must_use]
    pub fn at_most(self, units: usize) -> Self {
        Self { most: units.max(1), ..self }
    }

    /// The steps of the next portion.
    #[must_use]
    pub fn size(&self) -> usize {
        self.unit.saturating_mul(self.units)
    }

    /// Does a portion, and learns from the time it takes.
    pub fn time<T>(&mut self, work: impl FnOnce() -> T) -> T {
        let begin = Instant::now();
        let result = work();
        self.adapt(begin.elapsed());
        result
    }

    /// At most twice as many as before: the next steps may take longer.
    fn adapt(&mut self, took: Duration) {
        let factor = (self.time.as_secs_f64() / took.as_secs_f64().max(1e-6)).min(2.0);
        self.units = ((self.units as f64 * factor) as usize).clamp(1, self.most);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn portions_come_to_take_the_time_they_should_whatever_a_step_takes() {
        let time = Duration::from_millis(700);
        for (milliseconds, most, expected) in [(10.0, 1000, 63..=70), (0.001, 1000, 1000..=1000), (9000.0, 7, 1..=1)] {
            let mut portions = Portions::new(time, 3).at_most(most);
            for _ in 0..20 {
                portions.adapt(Duration::from_secs_f64(portions.units as f64 * milliseconds / 1000.0));
            }
            let found = portions.units;
            assert!(expected.contains(&found), "{found} units of {milliseconds} ms, at most {most}");
            assert_eq!(portions.size(), 3 * found, "steps");
        }
        let mut portions = Portions { units: 100, ..Portions::new(time, 1) };
        portions.adapt(Duration::from_secs(70));
        assert_eq!(portions.size(), 1, "at once where steps begin to take long");
    }
}
