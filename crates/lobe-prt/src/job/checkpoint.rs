//! Results on disk while a bake runs, so that it can be stopped, killed and continued.

use std::fs::File;
use std::io::{self, BufReader, BufWriter, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use crate::PrtError;
use crate::job::chunks::{Chunk, Chunks, Job, Sink, Tally};
use crate::job::fingerprint::Fingerprint;
use crate::job::stored_rows::StoredRows;

/// The first bytes of a checkpoint.
const MAGIC: &[u8; 8] = b"LOBEPART";

/// The layout of the file.
const VERSION: u32 = 1;

/// Bytes of the header: magic, version, three numbers of 32 bits and one of 64, fingerprint, checksum.
const HEADER: usize = 8 + 4 * 4 + 8 + 16 + 8;

/// The file reaches the disk at least this often: with a wave of work between two looks at the clock, well within 10 s.
const SYNC_EVERY: Duration = Duration::from_secs(4);

/// The chunks of a job that are done, in a file of its final size.
///
/// ```text
///   header:  "LOBEPART", version, row, receivers per chunk, bounces (u32), receivers (u64), fingerprint (2 u64), checksum
///   record:  rays (u64), left, energy of each bounce (f64), rows (f32), checksum (u64)
/// ```
///
/// All numbers are little-endian. There is a record for each chunk in its order, zero until it is done. The checksum of
/// a record depends on the job and on its number, so that zeros and torn or old records are not taken for done. The
/// header is written last when the file is made, so that a file without one holds nothing yet.
#[derive(Debug)]
pub(crate) struct Checkpoint {
    path: PathBuf,
    file: File,
    layout: Layout,
    done: usize,
    /// Of the chunks that are done.
    tally: Tally,
    synced: Instant,
}

/// Where everything is.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Layout {
    fingerprint: Fingerprint,
    chunks: Chunks,
    row: usize,
    energies: usize,
}

impl Layout {
    fn of<J: Job>(job: &J, fingerprint: Fingerprint, bounces: usize) -> Self {
        Self { fingerprint, chunks: Chunks::of(job), row: job.row(), energies: bounces + 1 }
    }

    /// Bytes of the record of a chunk of so many receivers.
    fn record(&self, receivers: usize) -> usize {
        16 + 8 * self.energies + 4 * self.row * receivers + 8
    }

    fn record_of(&self, chunk: usize) -> usize {
        self.record(self.chunks.range(chunk).len())
    }

    fn offset(&self, chunk: usize) -> u64 {
        HEADER as u64 + chunk as u64 * self.record(self.chunks.size()) as u64
    }

    /// Where the row of a receiver begins.
    pub(crate) fn offset_of_row(&self, receiver: usize) -> u64 {
        let size = self.chunks.size();
        let before = 16 + 8 * self.energies + 4 * self.row * (receiver % size);
        self.offset(receiver / size) + before as u64
    }

    /// How many receivers from this one on have their rows one after the other.
    pub(crate) fn run_from(&self, receiver: usize) -> usize {
        self.chunks.range(receiver / self.chunks.size()).end - receiver
    }

    /// Numbers of a receiver.
    pub(crate) fn row(&self) -> usize {
        self.row
    }

    pub(crate) fn receivers(&self) -> usize {
        self.chunks.receivers()
    }

    fn bytes(&self) -> u64 {
        let last = self.chunks.count() - 1;
        self.offset(last) + self.record_of(last) as u64
    }

    fn header(&self) -> Vec<u8> {
        let mut bytes = MAGIC.to_vec();
        for number in [VERSION, self.row as u32, self.chunks.size() as u32, self.energies as u32 - 1] {
            bytes.extend(number.to_le_bytes());
        }
        bytes.extend((self.chunks.receivers() as u64).to_le_bytes());
        self.fingerprint.0.iter().for_each(|word| bytes.extend(word.to_le_bytes()));
        bytes.extend(self.checksum(u64::MAX, &bytes).to_le_bytes());
        bytes
    }

    fn checksum(&self, number: u64, bytes: &[u8]) -> u64 {
        let mut sum = self.fingerprint;
        sum.word(number);
        sum.bytes(bytes);
        sum.0[0]
    }

    fn encode(&self, number: usize, chunk: &Chunk) -> Vec<u8> {
        let Chunk { tally, rows } = chunk;
        let mut bytes = Vec::with_capacity(16 + 8 * self.energies + 4 * rows.len() + 8);
        bytes.extend(tally.rays.to_le_bytes());
        bytes.extend(tally.left.to_le_bytes());
        (0..self.energies).for_each(|b| bytes.extend(tally.energy.get(b).copied().unwrap_or(0.0).to_le_bytes()));
        rows.iter().for_each(|t| bytes.extend(t.to_le_bytes()));
        bytes.extend(self.checksum(number as u64, &bytes).to_le_bytes());
        bytes
    }

    /// The sums of a record; none if the record is not that of this job and number.
    fn tally(&self, number: usize, bytes: &[u8]) -> Option<Tally> {
        let (body, checksum) = bytes.split_last_chunk::<8>()?;
        if u64::from_le_bytes(*checksum) != self.checksum(number as u64, body) {
            return None;
        }
        let (numbers, _) = body.get(..16 + 8 * self.energies)?.as_chunks::<8>();
        let energy = numbers[2..].iter().map(|b| f64::from_le_bytes(*b)).collect();
        Some(Tally { rays: u64::from_le_bytes(numbers[0]), left: f64::from_le_bytes(numbers[1]), energy })
    }
}

impl Checkpoint {
    /// Opens the checkpoint of a job, or makes one of its final size.
    ///
    /// # Errors
    /// [`PrtError::Io`] if it cannot be written or the disk has no room for all of it; [`PrtError::Invalid`] if it is that
    /// of another job, or none, or in use.
    pub(crate) fn open<J: Job>(
        path: &Path,
        job: &J,
        fingerprint: Fingerprint,
        bounces: usize,
    ) -> Result<Self, PrtError> {
        let layout = Layout::of(job, fingerprint, bounces);
        let io = |source| PrtError::Io { file: path.display().to_string(), source };
        let mut file = File::options().read(true).write(true).create(true).truncate(false).open(path).map_err(io)?;
        if !file.metadata().map_err(io)?.is_file() {
            let message = "expected a file for the checkpoint, found a device or a pipe";
            return Err(PrtError::invalid(&path.display().to_string(), message));
        }
        if let Err(std::fs::TryLockError::WouldBlock) = file.try_lock() {
            let message = "another bake is writing this checkpoint; wait for it, or give another output";
            return Err(PrtError::invalid(&path.display().to_string(), message));
        }
        let is_new = Self::check_header(path, &mut file, &layout)?;
        let made = fill(&mut file, layout.bytes()).and_then(|()| {
            if is_new {
                file.seek(SeekFrom::Start(0))?;
                file.write_all(&layout.header())?;
            }
            file.sync_all()
        });
        if let Err(source) = made {
            if is_new {
                // What was written is of no use to anyone; that it could not be is the error to report.
                let _ = std::fs::remove_file(path);
            }
            let message = format!("cannot keep {} bytes of results: {source}", layout.bytes());
            return Err(io(io::Error::new(source.kind(), message)));
        }
        let tally = Tally { energy: vec![0.0; layout.energies], ..Tally::default() };
        let mut checkpoint = Self { path: path.to_path_buf(), file, layout, done: 0, tally, synced: Instant::now() };
        checkpoint.take_up()?;
        Ok(checkpoint)
    }

    /// Whether the file holds nothing yet. An error if it holds anything but results of this job.
    fn check_header(path: &Path, file: &mut File, layout: &Layout) -> Result<bool, PrtError> {
        let place = path.display().to_string();
        let refuse = |message: &str| Err(PrtError::invalid(&place, message));
        let mut found = Vec::new();
        let read = Read::take(&mut *file, HEADER as u64).read_to_end(&mut found);
        read.map_err(|source| PrtError::Io { file: place.clone(), source })?;
        let expected = layout.header();
        if found == expected {
            return Ok(false);
        }
        if found.iter().all(|&b| b == 0) {
            return Ok(true);
        }
        if !found.starts_with(MAGIC) {
            return refuse("this is no checkpoint of a bake; move it away");
        }
        if found.get(8..12).is_some_and(|version| version != VERSION.to_le_bytes()) {
            return refuse("this checkpoint was made by another version of Lobe; remove it to start anew");
        }
        refuse(
            "this checkpoint is of another bake: the scene, the receivers or the options differ; repeat that command \
             to continue it, or remove it to start anew",
        )
    }

    /// Finds how many records in a row are done, and adds them up.
    fn take_up(&mut self) -> Result<(), PrtError> {
        let layout = self.layout;
        let io = |source| PrtError::Io { file: self.path.display().to_string(), source };
        self.file.seek(SeekFrom::Start(layout.offset(0))).map_err(io)?;
        let mut reader = BufReader::with_capacity(1 << 20, &self.file);
        let mut bytes = Vec::new();
        while self.done < layout.chunks.count() {
            bytes.resize(layout.record_of(self.done), 0);
            reader.read_exact(&mut bytes).map_err(io)?;
            let Some(tally) = layout.tally(self.done, &bytes) else { break };
            self.tally += &tally;
            self.done += 1;
        }
        Ok(())
    }

    /// All that was found, when all is done. The rows stay where they are.
    pub(crate) fn finish(mut self) -> Result<(Tally, StoredRows), PrtError> {
        debug_assert_eq!(self.done, self.layout.chunks.count(), "chunks that are done");
        self.sync()?;
        Ok((self.tally, StoredRows::new(self.path, self.file, self.layout)))
    }

    /// Waits until everything is on the disk.
    pub(crate) fn sync(&mut self) -> Result<(), PrtError> {
        self.synced = Instant::now();
        let io = |source| PrtError::Io { file: self.path.display().to_string(), source };
        self.file.sync_data().map_err(io)
    }
}

impl Sink for Checkpoint {
    fn done(&self) -> usize {
        self.done
    }

    fn push(&mut self, chunk: Chunk) -> Result<(), PrtError> {
        if let Some(at) = chunk.rows.iter().position(|c| !c.is_finite()) {
            let receiver = self.layout.chunks.range(self.done).start + at / self.layout.row;
            let message = format!("expected finite coefficients, found {} at receiver {receiver}", chunk.rows[at]);
            return Err(PrtError::invalid("transfer", message));
        }
        let bytes = self.layout.encode(self.done, &chunk);
        let written =
            self.file.seek(SeekFrom::Start(self.layout.offset(self.done))).and_then(|_| self.file.write_all(&bytes));
        written.map_err(|source| PrtError::Io { file: self.path.display().to_string(), source })?;
        self.done += 1;
        self.tally += &chunk.tally;
        if self.synced.elapsed() > SYNC_EVERY { self.sync() } else { Ok(()) }
    }
}

/// Writes zeros from the end of a file on until it has `bytes`: room that the disk really gives, unlike a length that is
/// only set. Cuts it off there.
fn fill(file: &mut File, bytes: u64) -> io::Result<()> {
    let end = file.seek(SeekFrom::End(0))?;
    let mut writer = BufWriter::with_capacity(1 << 20, &mut *file);
    io::copy(&mut io::repeat(0).take(bytes.saturating_sub(end)), &mut writer)?;
    writer.flush()?;
    drop(writer);
    file.set_len(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn room_is_really_taken_and_what_is_too_long_is_cut_off() {
        let mut file = tempfile::tempfile().unwrap();
        file.write_all(&[7; 10]).unwrap();
        for (bytes, sum) in [(3_000_000, 70_u64), (5, 35), (8, 35)] {
            fill(&mut file, bytes).unwrap();
            let mut found = Vec::new();
            file.seek(SeekFrom::Start(0)).unwrap();
            file.read_to_end(&mut found).unwrap();
            let found = (found.len() as u64, found.into_iter().map(u64::from).sum::<u64>());
            assert_eq!(found, (bytes, sum), "length and sum of the bytes");
        }
        #[cfg(target_os = "linux")]
        {
            let mut full = File::options().read(true).write(true).open("/dev/full").unwrap();
            assert!(fill(&mut full, 100).is_err(), "a full disk");
        }
    }
}
