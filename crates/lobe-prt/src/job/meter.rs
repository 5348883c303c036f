//! How far a search is that may end before its last step.

use std::time::Instant;

use crate::Progress;
use crate::job::chunks::OnProgress;

/// Tells how far a search is and remembers whether it is to stop. A search that was stopped comes to its end without further work;
/// what it has found is of no use.
pub(crate) struct Meter<'a> {
    on_progress: OnProgress<'a>,
    done: usize,
    total: usize,
    begin: Instant,
    is_stopped: bool,
}

impl<'a> Meter<'a> {
    /// Of a search of so many steps at most.
    pub(crate) fn new(total: usize, on_progress: OnProgress<'a>) -> Self {
        let mut meter = Self { on_progress, done: 0, total, begin: Instant::now(), is_stopped: false };
        meter.reach(0);
        meter
    }

    /// How many steps are done or were left out.
    pub(crate) fn done(&self) -> usize {
        self.done
    }

    /// So many steps more are done.
    pub(crate) fn step(&mut self, steps: usize) {
        self.reach(self.done + steps);
    }

    /// So many steps are done in all, or need not be done any more.
    pub(crate) fn reach(&mut self, done: usize) {
        self.done = done.clamp(self.done, self.total);
        let Self { done, total, begin, .. } = *self;
        let progress = Progress { done, total, resumed: 0, rays: 0, elapsed: begin.elapsed() };
        self.is_stopped |= (self.on_progress)(&progress).is_break();
    }

    pub(crate) fn is_stopped(&self) -> bool {
        self.is_stopped
    }
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use super::*;

    #[test]
    fn steps_never_go_back_nor_past_the_end_and_a_stop_is_remembered() {
        let mut seen = Vec::new();
        let mut watch = |progress: &Progress| {
            seen.push(progress.done);
            if progress.done == 7 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let mut meter = Meter::new(10, &mut watch);
        meter.step(7);
        meter.reach(3);
        meter.step(2);
        assert_eq!((meter.done(), meter.is_stopped()), (9, true), "stopped at 7");
        meter.step(5);
        assert_eq!(seen, [0, 7, 7, 9, 10], "steps told");
    }
}
