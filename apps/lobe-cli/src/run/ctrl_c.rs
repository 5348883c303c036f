//! Ctrl-C, SIGTERM and SIGHUP: long work stops where it can go on later, or at least where nothing is half done.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

use crate::run::ERROR;

/// Whether a signal has come; there once signals are watched.
static STOP: OnceLock<Arc<AtomicBool>> = OnceLock::new();

/// From now on the first signal asks the work to stop, the second ends the program at once.
pub(crate) fn watch() {
    STOP.get_or_init(|| {
        let stop = Arc::new(AtomicBool::new(false));
        for signal in [SIGINT, SIGTERM].into_iter().chain(hang_up()) {
            // Where the system does not let it be handled, the program ends at once. The actions of a signal are taken in
            // the order of their registration: the flag ends the program only if it was set before.
            let _ = flag::register_conditional_shutdown(signal, i32::from(ERROR), Arc::clone(&stop));
            let _ = flag::register(signal, Arc::clone(&stop));
        }
        stop
    });
}

/// SIGHUP, unless whoever started the program has it ignored, as nohup does.
#[cfg(unix)]
fn hang_up() -> Option<i32> {
    use signal_hook::consts::SIGHUP;

    // Where the system has no such file it cannot be asked.
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| u64::from_str_radix(line.strip_prefix("SigIgn:")?.trim(), 16).ok());
    let is_ignored = ignored.is_some_and(|signals| signals >> (SIGHUP - 1) & 1 == 1);
    (!is_ignored).then_some(SIGHUP)
}

#[cfg(not(unix))]
fn hang_up() -> Option<i32> {
    None
}

/// The answer to work that asks whether to go on.
pub(crate) fn go_on() -> ControlFlow<()> {
    let is_stopped = STOP.get().is_some_and(|stop| stop.load(Ordering::Relaxed));
    if is_stopped { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
}
