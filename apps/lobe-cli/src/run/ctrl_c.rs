//! Ctrl-C, SIGTERM and SIGHUP: long work stops where it can go on later, other work ends at once, and neither leaves anything half
//! done.

use std::ops::ControlFlow;
use std::sync::Once;
use std::sync::atomic::{AtomicBool, Ordering};

/// Whether work asks [`go_on`].
static IS_WATCHED: AtomicBool = AtomicBool::new(false);

/// Whether a signal has come to work that asks.
static STOP: AtomicBool = AtomicBool::new(false);

/// From now on the first signal asks the work to stop, the second ends the program at once.
pub(crate) fn watch() {
    IS_WATCHED.store(true, Ordering::Relaxed);
    listen();
    #[cfg(not(unix))]
    listen_for_work();
}

/// The answer to work that asks whether to go on.
pub(crate) fn go_on() -> ControlFlow<()> {
    if STOP.load(Ordering::Relaxed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
}

/// From now on signals are taken by a thread of their own, which clears away what is being written before the program ends. Before, there
/// is nothing to clear away. Where the system does not let it, they end the program as they do without.
#[cfg(unix)]
pub(crate) fn listen() {
    static ONCE: Once = Once::new();
    ONCE.call_once(take_signals);
}

#[cfg(unix)]
fn take_signals() {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    use signal_hook::iterator::Signals;

    let ignored = ignored_signals();
    // Whoever started the program has SIGHUP ignored, as nohup does.
    let hang_up = (!is_in(ignored, SIGHUP)).then_some(SIGHUP);
    if let Ok(mut signals) = Signals::new([SIGINT, SIGTERM].into_iter().chain(hang_up)) {
        let take_all = move || signals.forever().for_each(|signal| take(signal, is_in(ignored, signal)));
        // It calls little, and a thread has a stack of megabytes by itself.
        drop(std::thread::Builder::new().stack_size(STACK).spawn(take_all));
    }
}

/// Bytes of the stack of the thread that takes signals.
#[cfg(unix)]
const STACK: usize = 1 << 16;

#[cfg(unix)]
fn take(signal: i32, was_ignored: bool) {
    use signal_hook::low_level::{emulate_default_handler, exit};

    use crate::run::ERROR;

    let is_watched = IS_WATCHED.load(Ordering::Relaxed);
    let is_first = is_watched && !STOP.swap(true, Ordering::Relaxed);
    if is_first || (was_ignored && !is_watched) {
        return;
    }
    lobe::io::remove_unfinished();
    if !is_watched {
        // Ends the program by this signal, as whoever waits for it expects.
        let _ = emulate_default_handler(signal);
    }
    exit(i32::from(ERROR));
}

/// The signals that whoever started the program has ignored, a bit for each; none where the system has no such file.
#[cfg(unix)]
fn ignored_signals() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    line.and_then(|line| u64::from_str_radix(line.trim(), 16).ok()).unwrap_or(0)
}

#[cfg(unix)]
fn is_in(signals: u64, signal: i32) -> bool {
    signals >> (signal - 1) & 1 == 1
}

/// Here signals end the program by themselves until work asks.
#[cfg(not(unix))]
pub(crate) fn listen() {}

#[cfg(not(unix))]
fn listen_for_work() {
    static ONCE: Once = Once::new();
    ONCE.call_once(stop_in_order);
}

#[cfg(not(unix))]
fn stop_in_order() {
    use signal_hook::consts::{SIGINT, SIGTERM};
    use signal_hook::flag;

    use crate::run::ERROR;

    for signal in [SIGINT, SIGTERM] {
        // The actions of a signal are taken in the order of their registration: the flag ends the program only if it was set before.
        let _ = flag::register_conditional_shutdown(signal, i32::from(ERROR), &STOP);
        let _ = flag::register(signal, &STOP);
    }
}
