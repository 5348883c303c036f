//! Errors of results on disk.

use std::fs::File;
use std::io::{self, Read as _};
use std::path::Path;

/// Why results could not be kept on disk or taken up from there, by whose fault it is.
///
/// Every message is one line: where, what was expected, what was found, what to do.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum IoError {
    /// The file holds something else than it should.
    #[error("{place}: {message}")]
    Invalid {
        /// The file.
        place: String,
        /// What is wrong with it.
        message: String,
    },
    /// The file is of a version that is not read.
    #[error("{place}: {message}")]
    Unsupported {
        /// The file.
        place: String,
        /// Which version it is of, and what to do.
        message: String,
    },
    /// An option of a job is refused.
    #[cfg(feature = "options")]
    #[error(transparent)]
    OfJob(#[from] crate::OptionError),
    /// The watch of the job said to stop.
    #[error("stopped before the end")]
    Cancelled,
    /// The operating system refused.
    #[error("{place}: {source}")]
    Io {
        /// The file.
        place: String,
        /// The refusal.
        source: io::Error,
    },
}

impl IoError {
    pub(crate) fn invalid(path: &Path, message: impl Into<String>) -> Self {
        Self::Invalid { place: path.display().to_string(), message: message.into() }
    }

    /// The refusal of the system, at this file.
    #[must_use]
    pub fn io(path: &Path, source: io::Error) -> Self {
        Self::Io { place: path.display().to_string(), source }
    }
}

/// The most bytes of what has no length, a pipe or a device.
const MOST_STREAMED: u64 = 1 << 30;

/// The bytes of a file.
///
/// # Errors
/// [`IoError::Io`] if it cannot be read, [`IoError::Invalid`] if it is no regular file and does not end within a gigabyte.
pub fn read_file(path: &Path) -> Result<Vec<u8>, IoError> {
    let io = |source| IoError::io(path, source);
    if std::fs::metadata(path).map_err(io)?.is_file() {
        return std::fs::read(path).map_err(io);
    }
    read_stream(path, MOST_STREAMED)
}

/// Refuses what is there and is no regular file: to open a pipe that nobody writes to would take for ever. What is not there is left
/// to its reader, which says so.
///
/// # Errors
/// [`IoError::Invalid`] for a pipe, a device or a socket.
pub fn expect_file(path: &Path) -> Result<(), IoError> {
    match std::fs::metadata(path) {
        Ok(found) if !(found.is_file() || found.is_dir()) => {
            Err(IoError::invalid(path, "expected a file, found a device or a pipe"))
        }
        _ => Ok(()),
    }
}

fn read_stream(path: &Path, most: u64) -> Result<Vec<u8>, IoError> {
    let io = |source| IoError::io(path, source);
    let mut bytes = Vec::new();
    File::open(path).map_err(io)?.take(most + 1).read_to_end(&mut bytes).map_err(io)?;
    if bytes.len() as u64 > most {
        let message = format!("is no regular file, and does not end within {most} bytes; make it a file");
        return Err(IoError::invalid(path, message));
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_regular_file_is_read_up_to_a_limit() {
        let null = Path::new("/dev/null");
        if cfg!(unix) {
            assert!(read_file(null).unwrap().is_empty(), "nothing is a file");
            let message = read_stream(Path::new("/dev/zero"), 1000).unwrap_err().to_string();
            assert_eq!(message, "/dev/zero: is no regular file, and does not end within 1000 bytes; make it a file");
        }
        let folder = tempfile::tempdir().unwrap();
        assert!(matches!(read_file(folder.path()), Err(IoError::Io { .. })), "a folder");
        assert!(matches!(read_file(&folder.path().join("none")), Err(IoError::Io { .. })), "no file");
    }

    #[test]
    fn only_what_is_there_and_no_file_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        std::fs::write(&file, "").unwrap();
        for path in [&file, folder.path(), &folder.path().join("none")] {
            assert!(expect_file(path).is_ok(), "{}", path.display());
        }
        if cfg!(unix) {
            let message = expect_file(Path::new("/dev/null")).unwrap_err().to_string();
            assert_eq!(message, "/dev/null: expected a file, found a device or a pipe");
        }
    }
}
