//! How every chore reports.

/// What a chore comes back with: nothing, or one text for each fault it found.
pub(crate) type Outcome = Result<(), Vec<String>>;
