//! How every chore reports.

/// What a chore comes back with: nothing, or one text for each fault it found.
pub(crate) type Outcome = Result<(), Vec<String>>;

/// The outcome of a list of faults.
pub(crate) fn of(faults: Vec<String>) -> Outcome {
    if faults.is_empty() { Ok(()) } else { Err(faults) }
}
