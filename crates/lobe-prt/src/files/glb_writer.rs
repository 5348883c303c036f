//! The container of .glb files: a header, the JSON, and one buffer.

use std::io::{self, Write};
use std::path::Path;

use lobe_io::{IoError, Job, write_atomically};
use serde_json::Value;

use crate::error::PrtError;
use crate::job::meter::Meter;

/// Writes a .glb; until all is written, nothing has its name. Its buffer, of `length` bytes, is that of a document,
/// padded to a multiple of four, and what `rest` writes, `steps` steps of the job.
///
/// # Errors
/// [`PrtError::Options`] if it would have 4 GiB or more, [`PrtError::Io`] if the system refuses,
/// [`PrtError::Cancelled`] if the job was told to stop.
pub(crate) fn write_glb(
    path: &Path,
    (json, document, length): (&Value, &[u8], usize),
    (steps, job): (usize, Job<'_>),
    rest: impl FnOnce(&mut dyn Write, &mut Meter<'_>) -> io::Result<()>,
) -> Result<(), PrtError> {
    let json = padded(json);
    let total = 12 + 8 + json.len() as u64 + 8 + length as u64;
    check_length(total)?;
    let mut meter = Meter::new(steps, job)?;
    let written = write_atomically(path, |out| {
        out.write_all(b"glTF")?;
        write_words(out, &[2, total as u32, json.len() as u32, u32::from_le_bytes(*b"JSON")])?;
        out.write_all(&json)?;
        write_words(out, &[length as u32, u32::from_le_bytes(*b"BIN\0")])?;
        out.write_all(document)?;
        out.write_all(&[0; 3][..padding(document.len())])?;
        rest(out, &mut meter)
    });
    let place = path.display().to_string();
    meter.written(written.map_err(|source| IoError::Io { place, source }))
}

/// The header of a .glb has 32 bits for its length.
pub(crate) fn check_length(bytes: u64) -> Result<(), PrtError> {
    if u32::try_from(bytes).is_ok() {
        return Ok(());
    }
    Err(PrtError::Options(format!(
        "expected less than 4 GiB, the most a .glb holds, found {bytes} bytes: write .safetensors, or a lower order"
    )))
}

/// The padding to the next multiple of four.
pub(crate) fn padding(length: usize) -> usize {
    length.next_multiple_of(4) - length
}

fn padded(json: &Value) -> Vec<u8> {
    let mut text = json.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    text
}

fn write_words(out: &mut dyn Write, words: &[u32]) -> io::Result<()> {
    words.iter().try_for_each(|word| out.write_all(&word.to_le_bytes()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_that_are_too_long_for_their_header_are_refused() {
        assert!(check_length(u64::from(u32::MAX)).is_ok(), "the longest");
        let message = check_length(1 << 32).unwrap_err().to_string();
        assert!(
            message.starts_with("expected less than 4 GiB, the most a .glb holds, found 4294967296 bytes"),
            "{message}"
        );
    }
}
