//! Notes and progress bars on stderr; progress is drawn on a terminal only.

use std::io::{self, Write as _};

use indicatif::{ProgressBar, ProgressStyle};

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
            let _ = writeln!(io::stderr(), "note: {subject}: {text}");
        }
    }

    /// A bar of `steps` steps; it is drawn on a terminal only.
    pub(crate) fn bar(self, what: &'static str, steps: u64) -> ProgressBar {
        if self.quiet {
            return ProgressBar::hidden();
        }
        let bar = ProgressBar::new(steps).with_message(what);
        match ProgressStyle::with_template("{msg} {wide_bar} {percent:>3} %  {eta} left") {
            Ok(style) => bar.with_style(style),
            Err(_) => bar,
        }
    }

    /// A line of progress with its pace; it is drawn on a terminal only.
    pub(crate) fn progress(self, what: &'static str) -> ProgressLine {
        if self.quiet {
            return ProgressLine(ProgressBar::hidden());
        }
        let bar = ProgressBar::new(1).with_prefix(what);
        ProgressLine(match ProgressStyle::with_template("{prefix} {wide_bar} {percent:>3} %  {msg}") {
            Ok(style) => bar.with_style(style),
            Err(_) => bar,
        })
    }
}

/// A line of progress: the part that is done, the pace, the time left. It goes away when dropped.
pub(crate) struct ProgressLine(ProgressBar);

impl ProgressLine {
    /// Shows that `done` of `total` steps are done. `pace` is the work of a second with its unit, `seconds_left` an
    /// estimate; either may be unknown.
    pub(crate) fn show(&self, done: usize, total: usize, pace: Option<&str>, seconds_left: Option<f64>) {
        self.0.set_length(total as u64);
        self.0.set_position(done as u64);
        let left = seconds_left.map(|seconds| format!("{} left", duration(seconds)));
        let parts: Vec<&str> = pace.into_iter().chain(left.as_deref()).collect();
        self.0.set_message(parts.join(", "));
    }
}

impl Drop for ProgressLine {
    fn drop(&mut self) {
        self.0.finish_and_clear();
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
    fn a_line_says_pace_and_time_left_where_they_are_known() {
        let line = Talk { quiet: false }.progress("bake");
        for (pace, seconds, text) in [
            (Some("1.20 Mrays/s"), Some(75.0), "1.20 Mrays/s, 1 min 15 s left"),
            (None, Some(3.0), "3 s left"),
            (Some("1.20 Mrays/s"), None, "1.20 Mrays/s"),
            (None, None, ""),
        ] {
            line.show(3, 7, pace, seconds);
            assert_eq!((line.0.position(), line.0.length(), line.0.message().as_str()), (3, Some(7), text), "shown");
        }
    }
}
