//! Room on a disk: work whose results do not fit is refused before it begins.

use std::io;
use std::path::Path;

use crate::error::IoError;

/// Refuses an output that takes `bytes` with what is kept beside it, if its disk has fewer. Where the system does not
/// say how much is left, writing shows it.
///
/// # Errors
/// [`IoError::Io`], with what is needed and what is there.
pub fn expect_room(output: &Path, bytes: u64) -> Result<(), IoError> {
    let Some(free) = free_beside(output) else { return Ok(()) };
    if free >= bytes {
        return Ok(());
    }
    let [needed, free] = [bytes, free].map(|bytes| bytes.div_ceil(1 << 20));
    let message = format!(
        "expected {needed} MiB of free space for it and its checkpoint, found {free}: make room, or write somewhere else"
    );
    Err(IoError::io(output, io::Error::new(io::ErrorKind::StorageFull, message)))
}

/// The bytes that are free in the folder of a file, where the system says so.
#[cfg(any(unix, windows))]
fn free_beside(output: &Path) -> Option<u64> {
    let folder = match output.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    };
    fs4::available_space(folder).ok()
}

/// The same where no system keeps files.
#[cfg(not(any(unix, windows)))]
fn free_beside(_output: &Path) -> Option<u64> {
    None
}
