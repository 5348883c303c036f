//! Notes and progress on stderr: a bar on a terminal, lines in a log.

use std::borrow::Cow;
use std::io::{self, IsTerminal as _, Write as _};
use std::ops::ControlFlow;
use std::sync::Mutex;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use lobe::io::{Job, Progress, one_line};

/// The time after which work has a line in a log, and the time between two lines.
const LOG_AFTER: Duration = Duration::from_secs(2);
const LOG_EVERY: Duration = Duration::from_secs(10);

/// The time between two looks at work that says nothing.
const TICK: Duration = Duration::from_millis(200);

/// Prints notes and progress, unless `--quiet` forbids it.
#[derive(Clone, Copy)]
pub(crate) struct Talk {
    pub(crate) quiet: bool,
}

impl Talk {
    /// One line that a careful user should know about `subject`.
    pub(crate) fn note(self, subject: &str, text: &str) {
        if !self.quiet {
            // A note that nobody can read does not stop the work.
            let _ = writeln!(io::stderr(), "note: {}", one_line(&format!("{subject}: {text}")));
        }
    }

    /// The progress of work that knows its pace.
    pub(crate) fn progress(self, what: impl Into<Cow<'static, str>>) -> ProgressLine {
        self.line(what.into(), "{prefix} {wide_bar} {percent:>3} %  {msg}")
    }

    /// Work of an unknown number of steps, each of which is named.
    pub(crate) fn waiting(self, what: &'static str) -> ProgressLine {
        self.line(what.into(), "{prefix} {msg}")
    }

    /// Does work that takes a job, while a line shows how far it is.
    pub(crate) fn watch<T, E>(self, what: &'static str, work: impl FnOnce(Job<'_>) -> Result<T, E>) -> Result<T, E> {
        let line = self.progress(what);
        let mut watch = |progress: &Progress| {
            line.show(progress.done, progress.total, None, progress.seconds_left());
            ControlFlow::Continue(())
        };
        work(Job::default().watched_by(&mut watch))
    }

    /// Does work that says nothing of how far it is, while a line shows how long it has taken.
    pub(crate) fn while_waiting<T: Send>(self, what: &'static str, work: impl FnOnce() -> T + Send) -> T {
        let line = self.waiting(what);
        std::thread::scope(|scope| {
            let (done, is_done) = mpsc::channel::<()>();
            let work = scope.spawn(move || {
                // Dropped at the end, by a panic too, which ends the wait below.
                let _done = done;
                work()
            });
            let begun = Instant::now();
            while let Err(RecvTimeoutError::Timeout) = is_done.recv_timeout(TICK) {
                line.wait(begun.elapsed());
            }
            work.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
        })
    }

    fn line(self, what: Cow<'static, str>, template: &str) -> ProgressLine {
        let bar = if self.quiet { ProgressBar::hidden() } else { ProgressBar::new(1) };
        let bar = bar.with_prefix(what.clone());
        let bar = match ProgressStyle::with_template(template) {
            Ok(style) => bar.with_style(style),
            Err(_) => bar,
        };
        let is_logged = !self.quiet && !io::stderr().is_terminal();
        ProgressLine { bar, what, log: is_logged.then(|| Mutex::new(Log { next: Instant::now() + LOG_AFTER })) }
    }
}

/// The progress of work: the part that is done, the pace, the time left. On a terminal it is one line, which goes away when
/// dropped; elsewhere, as in a log, a line every [`LOG_EVERY`] of what takes longer than [`LOG_AFTER`].
pub(crate) struct ProgressLine {
    bar: ProgressBar,
    what: Cow<'static, str>,
    log: Option<Mutex<Log>>,
}

/// Lines of progress in a log.
struct Log {
    /// When there will be another.
    next: Instant,
}

impl Log {
    fn is_due(&mut self, now: Instant) -> bool {
        let is_due = now >= self.next;
        if is_due {
            self.next = now + LOG_EVERY;
        }
        is_due
    }
}

impl ProgressLine {
    /// Shows that `done` of `total` steps are done. `pace` is the work of a second with its unit, `seconds_left` an
    /// estimate; either may be unknown.
    pub(crate) fn show(&self, done: usize, total: usize, pace: Option<&str>, seconds_left: Option<f64>) {
        self.bar.set_length(total as u64);
        let left = seconds_left.map(|seconds| format!("{} left", duration(seconds)));
        let parts: Vec<&str> = pace.into_iter().chain(left.as_deref()).collect();
        self.bar.set_message(parts.join(", "));
        self.set_position(done as u64);
    }

    /// Shows how long the work has taken.
    fn wait(&self, elapsed: Duration) {
        let elapsed = duration(elapsed.as_secs_f64());
        if let Some(Ok(mut log)) = self.log.as_ref().map(Mutex::lock)
            && log.is_due(Instant::now())
        {
            // A line that nobody can read does not stop the work.
            let _ = writeln!(io::stderr(), "progress: {}: {elapsed} so far", self.what);
        }
        self.bar.set_message(format!("{elapsed} so far"));
        self.bar.tick();
    }

    /// Shows that `done` steps are done.
    fn set_position(&self, done: u64) {
        self.bar.set_position(done);
        let Some(Ok(mut log)) = self.log.as_ref().map(Mutex::lock) else { return };
        let total = self.bar.length().unwrap_or(0).max(1);
        if done < total && log.is_due(Instant::now()) {
            let (percent, message) = (100 * done / total, self.bar.message());
            let comma = if message.is_empty() { "" } else { ", " };
            // A line that nobody can read does not stop the work.
            let _ = writeln!(io::stderr(), "progress: {}: {percent} %{comma}{message}", self.what);
        }
    }

    /// Takes the line away.
    pub(crate) fn finish_and_clear(&self) {
        self.bar.finish_and_clear();
    }
}

impl Drop for ProgressLine {
    fn drop(&mut self) {
        self.finish_and_clear();
    }
}

/// As exact as a guess deserves: 7 s, 3 min 20 s, 2 h 05 min.
fn duration(seconds: f64) -> String {
    let whole = seconds.max(0.0).ceil() as u64;
    match whole {
        0..60 => format!("{whole} s"),
        60..3600 => format!("{} min {:02} s", whole / 60, whole % 60),
        _ => format!("{} h {:02} min", whole / 3600, whole % 3600 / 60),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations_are_as_exact_as_a_guess_deserves() {
        for (seconds, text) in [
            (0.0, "0 s"),
            (6.2, "7 s"),
            (59.5, "1 min 00 s"),
            (200.0, "3 min 20 s"),
            (7500.0, "2 h 05 min"),
            (f64::NAN, "0 s"),
        ] {
            assert_eq!(duration(seconds), text, "{seconds} seconds");
        }
    }

    #[test]
    fn work_that_says_nothing_is_waited_for() {
        let talk = Talk { quiet: true };
        let begun = Instant::now();
        let answer = talk.while_waiting("think", || {
            std::thread::sleep(2 * TICK);
            42
        });
        assert!(answer == 42 && begun.elapsed() >= 2 * TICK, "{answer}");
        let panicked = std::panic::catch_unwind(|| talk.while_waiting("think", || panic!("planted")));
        assert_eq!(panicked.unwrap_err().downcast_ref(), Some(&"planted"), "a panic is that of the work");
    }

    #[test]
    fn a_log_has_a_line_after_two_seconds_and_then_every_ten() {
        let start = Instant::now();
        let mut log = Log { next: start + LOG_AFTER };
        let due = [0, 1, 2, 3, 11, 12, 13, 30].map(|second| log.is_due(start + Duration::from_secs(second)));
        assert_eq!(due, [false, false, true, false, false, true, false, true], "lines");
    }

    #[test]
    fn a_line_says_pace_and_time_left_where_they_are_known() {
        let line = Talk { quiet: false }.progress("bake");
        for (pace, seconds, text) in [
            (Some("1.20 Mrays/s"), Some(75.0), "1.20 Mrays/s, 1 min 15 s left"),
            (None, Some(3.0), "3 s left"),
            (Some("1.20 Mrays/s"), None, "1.20 Mrays/s"),
            (None, None, ""),
        ] {
            line.show(3, 7, pace, seconds);
            assert_eq!(
                (line.bar.position(), line.bar.length(), line.bar.message().as_str()),
                (3, Some(7), text),
                "shown"
            );
        }
    }
}
