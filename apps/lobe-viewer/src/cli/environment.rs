//! Environment variables: instructions and threads that do not exist are refused.

use lobe::io::{choose_huge_pages, parallel};
use lobe::sh::simd::Machine;

/// Refuses instructions and numbers of threads that do not exist, which would be ignored, or take minutes.
pub(crate) fn check() -> Result<(), String> {
    Machine::check_limit().map_err(|error| error.to_string())?;
    choose_huge_pages().map_err(|error| error.to_string())?;
    parallel::check_environment().map_err(|error| error.to_string())
}
