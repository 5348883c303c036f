//! Pixels on disk while a picture is traced, so that it can be stopped, killed and continued.

use std::fs::{File, TryLockError};
use std::io::{self, BufReader, Read, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use lobe_prt::Fingerprint;

use crate::RenderError;
use crate::path_tracer::pixel::Pixel;

/// The first bytes of a checkpoint.
const MAGIC: &[u8; 8] = b"LOBEPICT";

/// The layout of the file, and what the pixels of the same arguments are.
const VERSION: u64 = 1;

/// Bytes of the header.
const HEADER: usize = 8 + 8 + 16;

/// Numbers and bytes of a pixel.
const NUMBERS: usize = 14;
const PIXEL: usize = 4 * NUMBERS;

/// Pixels reach the disk at least this often.
const SAVE_EVERY: Duration = Duration::from_secs(4);

/// The pixels of a picture that are done, in a file that grows.
///
/// ```text
///   header:  "LOBEPICT", version (u64), fingerprint (2 u64)
///   record:  number of pixels (u64), 14 numbers for each (f32), checksum (u64)
/// ```
///
/// All numbers are little-endian. A checksum depends on the picture and on where its record begins; what comes after a
/// record that is torn or damaged is forgotten.
pub(crate) struct TruthCheckpoint {
    path: PathBuf,
    file: File,
    fingerprint: Fingerprint,
    /// How many pixels are in the file.
    kept: usize,
    saved: Instant,
}

impl TruthCheckpoint {
    /// Opens the checkpoint of a picture of at most so many pixels, or makes one; also returns the pixels in it.
    pub(crate) fn open(path: &Path, fingerprint: Fingerprint, most: usize) -> Result<(Self, Vec<Pixel>), RenderError> {
        let io = |source| RenderError::Io { path: path.to_path_buf(), source };
        let refuse = |message: &str| Err(RenderError::Invalid(format!("{}: {message}", path.display())));
        let mut file = File::options().read(true).write(true).create(true).truncate(false).open(path).map_err(io)?;
        if let Err(TryLockError::WouldBlock) = file.try_lock() {
            return refuse("the same picture is being traced already; wait for it, or give another output");
        }
        let mut found = Vec::new();
        Read::take(&mut file, HEADER as u64).read_to_end(&mut found).map_err(io)?;
        let expected = header(fingerprint);
        if found != expected && !expected.starts_with(&found) {
            let is_ours = found.starts_with(MAGIC);
            return refuse(match is_ours && found.get(8..16) == Some(&VERSION.to_le_bytes()[..]) {
                true => {
                    "this checkpoint is of another picture: the scene, the light, the view or the options differ; repeat \
                     that command to continue it, or remove it to start anew"
                }
                false if is_ours => "this checkpoint was made by another version of Lobe; remove it to start anew",
                false => "this is no checkpoint of a picture; move it away",
            });
        }
        let (pixels, end) =
            if found == expected { records(&file, fingerprint, most).map_err(io)? } else { (vec![], 0) };
        let mut checkpoint =
            Self { path: path.to_path_buf(), file, fingerprint, kept: pixels.len(), saved: Instant::now() };
        checkpoint.cut_off_at(end).map_err(io)?;
        Ok((checkpoint, pixels))
    }

    /// Forgets what follows `end`; a file without a header gets one.
    fn cut_off_at(&mut self, end: u64) -> io::Result<()> {
        self.file.set_len(end)?;
        self.file.seek(SeekFrom::Start(end))?;
        if end == 0 { self.file.write_all(&header(self.fingerprint)) } else { Ok(()) }
    }

    /// Keeps the pixels if it is time to, or if there will be no other time.
    pub(crate) fn keep(&mut self, done: &[Pixel], is_last: bool) -> Result<(), RenderError> {
        if done.len() == self.kept || !is_last && self.saved.elapsed() < SAVE_EVERY {
            return Ok(());
        }
        let record = record(self.fingerprint, self.kept, &done[self.kept..]);
        let written = self.file.write_all(&record).and_then(|()| self.file.sync_data());
        written.map_err(|source| RenderError::Io { path: self.path.clone(), source })?;
        (self.kept, self.saved) = (done.len(), Instant::now());
        Ok(())
    }
}

fn header(fingerprint: Fingerprint) -> Vec<u8> {
    let [a, b] = fingerprint.bits();
    [*MAGIC, VERSION.to_le_bytes(), a.to_le_bytes(), b.to_le_bytes()].concat()
}

fn record(fingerprint: Fingerprint, first: usize, pixels: &[Pixel]) -> Vec<u8> {
    // At once: a vector that grows holds up to three times as much for a while.
    let mut bytes = Vec::with_capacity(8 + PIXEL * pixels.len() + 8);
    bytes.extend((pixels.len() as u64).to_le_bytes());
    bytes.extend(pixels.iter().copied().flat_map(Pixel::to_numbers).flat_map(f32::to_le_bytes));
    let sum = checksum(fingerprint, first, &bytes);
    bytes.extend(sum.to_le_bytes());
    bytes
}

fn checksum(mut fingerprint: Fingerprint, first: usize, bytes: &[u8]) -> u64 {
    fingerprint.word(first as u64);
    fingerprint.bytes(bytes);
    fingerprint.bits()[0]
}

/// The pixels of all whole records behind the header, and where the last of these ends.
fn records(file: &File, fingerprint: Fingerprint, most: usize) -> io::Result<(Vec<Pixel>, u64)> {
    let mut reader = BufReader::with_capacity(1 << 20, file);
    let (mut pixels, mut end) = (Vec::new(), HEADER as u64);
    loop {
        let mut bytes = Vec::new();
        reader.by_ref().take(8).read_to_end(&mut bytes)?;
        let Some(count) = bytes.first_chunk().map(|b| u64::from_le_bytes(*b)) else { return Ok((pixels, end)) };
        if count > (most - pixels.len()) as u64 {
            return Ok((pixels, end));
        }
        let length = 8 + PIXEL * count as usize;
        reader.by_ref().take((length - 8 + 8) as u64).read_to_end(&mut bytes)?;
        let Some((body, sum)) = bytes.split_at_checked(length) else { return Ok((pixels, end)) };
        if sum != checksum(fingerprint, pixels.len(), body).to_le_bytes() {
            return Ok((pixels, end));
        }
        let numbers: Vec<f32> = body[8..].as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
        pixels.extend(numbers.as_chunks::<NUMBERS>().0.iter().map(|numbers| Pixel::from_numbers(*numbers)));
        end += length as u64 + 8;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pixels(range: std::ops::Range<usize>) -> Vec<Pixel> {
        range.map(|i| Pixel::from_numbers(std::array::from_fn(|k| (NUMBERS * i + k) as f32))).collect()
    }

    fn numbers(pixels: &[Pixel]) -> Vec<[f32; NUMBERS]> {
        pixels.iter().copied().map(Pixel::to_numbers).collect()
    }

    #[test]
    fn wherever_a_file_was_cut_off_it_goes_on_from_a_whole_record() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("p");
        let key = Fingerprint::of_kind(99);
        let all = pixels(0..10);
        let (mut checkpoint, none) = TruthCheckpoint::open(&path, key, 10).unwrap();
        assert_eq!(none.len(), 0, "a new one");
        checkpoint.keep(&all[..3], true).unwrap();
        checkpoint.keep(&all[..4], false).unwrap();
        checkpoint.keep(&all[..7], true).unwrap();
        drop(checkpoint);
        let whole = std::fs::read(&path).unwrap();
        let first = HEADER + 16 + 3 * PIXEL;
        assert_eq!(whole.len(), first + 16 + 4 * PIXEL, "a record that was not due is not written");
        for length in 0..=whole.len() {
            std::fs::write(&path, &whole[..length]).unwrap();
            let (mut checkpoint, found) = TruthCheckpoint::open(&path, key, 10).unwrap();
            let expected = if length == whole.len() {
                7
            } else if length >= first {
                3
            } else {
                0
            };
            assert_eq!(numbers(&found), numbers(&all[..expected]), "cut off after {length}");
            checkpoint.keep(&all, true).unwrap();
            drop(checkpoint);
            let (_, found) = TruthCheckpoint::open(&path, key, 10).unwrap();
            assert_eq!(numbers(&found), numbers(&all), "completed after {length}");
        }
    }

    #[test]
    fn checkpoints_of_others_are_refused_and_damage_is_not_believed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("p");
        let key = Fingerprint::of_kind(99);
        let open = |key| TruthCheckpoint::open(&path, key, 10).map(|(_, found)| found.len());
        let refusal = |key| open(key).unwrap_err().to_string();
        TruthCheckpoint::open(&path, key, 10).unwrap().0.keep(&pixels(0..10), true).unwrap();
        assert!(refusal(Fingerprint::of_kind(98)).contains("is of another picture"), "another picture");
        let whole = std::fs::read(&path).unwrap();
        for at in HEADER..whole.len() {
            let mut bad = whole.clone();
            bad[at] ^= 0x40;
            std::fs::write(&path, bad).unwrap();
            assert_eq!(open(key).unwrap(), 0, "byte {at} is wrong");
        }
        std::fs::write(&path, [MAGIC, &[9; 8][..]].concat()).unwrap();
        assert!(refusal(key).contains("another version of Lobe"), "version");
        std::fs::write(&path, b"a letter").unwrap();
        assert!(refusal(key).contains("this is no checkpoint of a picture; move it away"), "a letter");
        std::fs::write(&path, b"").unwrap();
        let held = TruthCheckpoint::open(&path, key, 10).unwrap();
        assert!(refusal(key).contains("being traced already"), "in use");
        drop(held);
    }
}
