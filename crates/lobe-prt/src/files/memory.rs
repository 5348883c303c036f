//! Limits of memory for files of numbers: those that take more are refused before they are read.

use std::fs::{self, File};
use std::io::Read as _;
use std::path::Path;

use lobe_image::{ExrLayers, FileFormat, ImageError};
use lobe_io::{MemoryLimit, OptionError};

use crate::error::PrtError;

/// Bytes in memory while a file of numbers is read for each of the file: it, its numbers, and what is made of them; of
/// a scene its triangles. Measured 2.0 of a table, 3.0 of a scene, which a bake made finer.
pub const BYTES_FOR_EACH: u64 = 3;

/// Refuses a file of numbers that takes more than the limit while it is read, in any form. `instead` is what a user can
/// ask for then. One that cannot be read is left to its reader, which says so.
///
/// # Errors
/// [`PrtError::OfJob`] with the bytes; [`PrtError::Invalid`] for a picture that contradicts itself.
pub fn check_file_of_numbers(memory: MemoryLimit, path: &Path, instead: &str) -> Result<(), PrtError> {
    let name = path.display().to_string();
    let check =
        |bytes: u64| -> Result<(), OptionError> { memory.check(&name, BYTES_FOR_EACH.saturating_mul(bytes), instead) };
    check(fs::metadata(path).map_or(0, |file| file.len()))?;
    let mut begin = [0; 4];
    let is_exr = File::open(path).and_then(|mut file| file.read_exact(&mut begin)).is_ok()
        && matches!(FileFormat::of_bytes(&begin, &name), Ok(FileFormat::OpenExr));
    if is_exr && let Ok(bytes) = fs::read(path) {
        let of_picture = |error: ImageError| PrtError::invalid(&name, error.to_string());
        check(ExrLayers::bytes_in_memory(&bytes, &name).map_err(of_picture)?)?;
    }
    Ok(())
}
