use std::io::Write as _;

/// Says that a test leaves something out, and why. Printed past the capture of passing tests, so that it is seen.
pub fn skipped(reason: &str) {
    // A closed stderr is no fault of the test.
    let _ = writeln!(std::io::stderr(), "skipped: {reason}");
}
