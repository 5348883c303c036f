//! What goes to stderr beside results: notes, and a progress bar where a person is watching.

use std::io::{self, Write as _};

use indicatif::{ProgressBar, ProgressStyle};

/// Says things about the work, unless `--quiet` forbids it.
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
}
