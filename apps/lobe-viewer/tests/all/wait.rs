//! Waiting for the threads behind a window.

use std::thread::sleep;
use std::time::Duration;

use egui_kittest::Harness;

/// Steps until `is_so`, however long the threads take, for no machine is too slow. Of a test that never ends cargo prints the name
/// after a minute.
pub(crate) fn step_until<S>(harness: &mut Harness<'_, S>, mut is_so: impl FnMut(&S) -> bool) {
    while !is_so(harness.state()) {
        sleep(Duration::from_millis(5));
        harness.run_steps(2);
    }
}
