//! Records of work that is done.

use std::fs::File;
use std::io::{self, Read as _, Seek as _, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use crate::records::layout::RecordLayout;

/// The records of work that is done, in their file. It stays locked as long as this is there.
#[derive(Debug)]
pub struct RecordReader {
    path: PathBuf,
    /// A file has one place to read at.
    file: Mutex<File>,
    layout: RecordLayout,
}

impl RecordReader {
    pub(crate) fn new(path: PathBuf, file: File, layout: RecordLayout) -> Self {
        Self { path, file: Mutex::new(file), layout }
    }

    /// The file.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Where records are.
    #[must_use]
    pub fn layout(&self) -> &RecordLayout {
        &self.layout
    }

    /// Fills `bytes` from a place in the file, given in bytes from its start. See [`RecordLayout::offset`].
    ///
    /// # Errors
    /// If the system refuses or the file has become shorter.
    pub fn read_exact_at(&self, offset: u64, bytes: &mut [u8]) -> io::Result<()> {
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        file.seek(SeekFrom::Start(offset))?;
        file.read_exact(bytes)
    }
}
