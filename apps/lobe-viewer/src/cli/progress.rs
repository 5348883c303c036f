//! Progress of work, on a terminal.

use std::io::{IsTerminal as _, Write as _, stderr};
use std::ops::ControlFlow;

use lobe::io::Progress;

/// A line on the terminal that says how far a bake is.
pub(crate) fn progress(what: impl Into<String>) -> impl FnMut(&Progress) -> ControlFlow<()> {
    let (is_shown, what) = (stderr().is_terminal(), what.into());
    move |progress| {
        if is_shown {
            let percent = 100 * progress.done / progress.total.max(1);
            let end = if progress.done == progress.total { "\r\x1b[K" } else { "" };
            // A terminal that has gone away is told nothing.
            drop(write!(stderr(), "\r{what}: {percent} %{end}"));
        }
        ControlFlow::Continue(())
    }
}
