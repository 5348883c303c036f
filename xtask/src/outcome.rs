//! The outcome of a chore: nothing, or its faults.

/// Nothing, or one text for each fault that was found.
pub(crate) type Outcome = Result<(), Vec<String>>;

/// The outcome of a list of faults.
pub(crate) fn of(faults: Vec<String>) -> Outcome {
    if faults.is_empty() { Ok(()) } else { Err(faults) }
}
