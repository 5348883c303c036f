//! Ctrl-C: long work stops where it can go on later, or at least where nothing is half done.

use std::ops::ControlFlow;
use std::process;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::run::failure::ERROR;

/// Whether it was pressed.
static STOP: AtomicBool = AtomicBool::new(false);

/// From now on the first Ctrl-C asks the work to stop, the second ends the program at once.
pub(crate) fn watch() {
    // Where the system does not let it be handled, the program ends at once.
    let _ = ctrlc::set_handler(|| {
        if STOP.swap(true, Ordering::Relaxed) {
            process::exit(i32::from(ERROR));
        }
    });
}

/// The answer to work that asks whether to go on.
pub(crate) fn go_on() -> ControlFlow<()> {
    if STOP.load(Ordering::Relaxed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
}
