//! Checkpoints: records on disk while long work goes on, so that it can be stopped, killed and continued.

use std::fs::{File, TryLockError};
use std::io::{self, BufReader, BufWriter, Read, Seek as _, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use twox_hash::XxHash3_64;

use crate::{Fingerprint, IoError};

/// The first bytes of every checkpoint.
const MAGIC: [u8; 4] = *b"LOBE";

/// The layout of the header and of the frame of a record.
const VERSION: u32 = 2;

/// Bytes of the header.
const HEADER: usize = 64;

/// Bytes of a checksum.
const SUM: usize = 8;

/// What was pushed reaches the disk at least this often. Work pushes about once a second, so that a machine that loses
/// its power costs less than 10 s of work.
const SYNC_EVERY: Duration = Duration::from_secs(4);

/// The kind of work that a checkpoint is of.
#[derive(Clone, Copy, Debug)]
pub struct RecordFormat {
    /// Four letters that tell its files from others.
    pub kind: [u8; 4],
    /// Changes with what a record holds.
    pub version: u32,
    /// What results are called in messages, without an article: `bake`.
    pub work: &'static str,
    /// The arguments that the fingerprint depends on, in messages: `the scene or the options`.
    pub arguments: &'static str,
}

/// How many records there are and how long they are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RecordLayout {
    /// Records in all, at least 1.
    pub count: usize,
    /// Bytes of a record.
    pub bytes: usize,
    /// Bytes of the last record, at most [`RecordLayout::bytes`].
    pub last: usize,
}

impl RecordLayout {
    /// Where the bytes of a record begin in the file.
    #[must_use]
    pub fn offset(&self, record: usize) -> u64 {
        HEADER as u64 + record as u64 * (self.bytes + SUM) as u64
    }

    fn len(&self, record: usize) -> usize {
        if record + 1 == self.count { self.last } else { self.bytes }
    }

    /// Bytes of the whole file.
    fn file_len(&self) -> u64 {
        self.offset(self.count - 1) + (self.last + SUM) as u64
    }
}

/// The records of a piece of work that are done, in a file of its final size.
///
/// ```text
///   header:  "LOBE", kind (4 letters), version 2 of this layout, version of the kind (u32),
///            records, bytes of a record, bytes of the last (u64), fingerprint (128 bits, the higher 64 first), checksum (u64)
///   record:  its bytes, checksum (u64)
/// ```
///
/// All numbers are little-endian. There is a place for each record in its order, zero until it is pushed. A checksum is
/// the XXH3-64 of the bytes before it, seeded with the exclusive or of the first half of the fingerprint and the number of
/// the record (of the header: 2⁶⁴ - 1), so that zeros and torn or old records are not taken for done. The header is written
/// when all the room is there, so that a file without one holds nothing yet.
#[derive(Debug)]
pub struct RecordFile {
    path: PathBuf,
    file: File,
    seed: u64,
    layout: RecordLayout,
    done: usize,
    synced: Instant,
}

impl RecordFile {
    /// Opens the checkpoint of a piece of work, or makes one of its final size. `take_up` gets the records that are there
    /// already, from the first to the last before one that is missing or damaged.
    ///
    /// # Errors
    /// [`IoError::Io`] if it cannot be written or the disk has no room for all of it; [`IoError::Invalid`] if it is that of
    /// other work, or none, or in use.
    pub fn open(
        path: &Path,
        format: &RecordFormat,
        layout: RecordLayout,
        fingerprint: &Fingerprint,
        take_up: impl FnMut(&[u8]),
    ) -> Result<Self, IoError> {
        let io = |source| IoError::io(path, source);
        // Open and lock the file.
        let mut file = File::options().read(true).write(true).create(true).truncate(false).open(path).map_err(io)?;
        if !file.metadata().map_err(io)?.is_file() {
            return Err(IoError::invalid(path, "expected a file for the checkpoint, found a device or a pipe"));
        }
        if let Err(TryLockError::WouldBlock) = file.try_lock() {
            let message = "another run is writing this checkpoint; wait for it, or give another output";
            return Err(IoError::invalid(path, message));
        }
        // Refuse what is not of this work.
        let header = header(format, &layout, fingerprint);
        let is_new = is_new(path, &mut file, format, &header)?;
        // Take all the room there will be need for.
        let made = fill(&mut file, layout.file_len()).and_then(|()| {
            if is_new {
                file.seek(SeekFrom::Start(0))?;
                file.write_all(&header)?;
            }
            file.sync_all()
        });
        if let Err(source) = made {
            if is_new {
                // What was written is of no use to anyone; that it could not be is the error to report.
                let _ = std::fs::remove_file(path);
            }
            let message = format!("cannot keep {} bytes of results: {source}", layout.file_len());
            return Err(io(io::Error::new(source.kind(), message)));
        }
        // Take up the records that are done.
        let seed = fingerprint.bits()[0];
        let mut records = Self { path: path.to_path_buf(), file, seed, layout, done: 0, synced: Instant::now() };
        records.take_up(take_up).map_err(io)?;
        Ok(records)
    }

    /// Finds how many records from the first on are done, and leaves the file at their end.
    fn take_up(&mut self, mut take_up: impl FnMut(&[u8])) -> io::Result<()> {
        self.file.seek(SeekFrom::Start(self.layout.offset(0)))?;
        let mut reader = BufReader::with_capacity(1 << 20, &self.file);
        let mut bytes = Vec::new();
        while self.done < self.layout.count {
            bytes.resize(self.layout.len(self.done) + SUM, 0);
            reader.read_exact(&mut bytes)?;
            let Some((body, sum)) = bytes.split_last_chunk() else { break };
            if u64::from_le_bytes(*sum) != checksum(self.seed, self.done as u64, body) {
                break;
            }
            take_up(body);
            self.done += 1;
        }
        self.file.seek(SeekFrom::Start(self.layout.offset(self.done)))?;
        Ok(())
    }

    /// How many records are done.
    #[must_use]
    pub fn done(&self) -> usize {
        self.done
    }

    /// Writes the next record, and brings it to the disk if none was for some seconds.
    ///
    /// # Errors
    /// [`IoError::Io`] if the system refuses.
    ///
    /// # Panics
    /// If all records are done, or this is not as long as it should be.
    pub fn push(&mut self, mut record: Vec<u8>) -> Result<(), IoError> {
        assert!(self.done < self.layout.count, "all {} records are done", self.layout.count);
        assert_eq!(record.len(), self.layout.len(self.done), "bytes of record {}", self.done);
        record.extend(checksum(self.seed, self.done as u64, &record).to_le_bytes());
        self.file.write_all(&record).map_err(|source| IoError::io(&self.path, source))?;
        self.done += 1;
        if self.synced.elapsed() > SYNC_EVERY { self.sync() } else { Ok(()) }
    }

    /// Waits until everything is on the disk.
    ///
    /// # Errors
    /// [`IoError::Io`] if the system refuses.
    pub fn sync(&mut self) -> Result<(), IoError> {
        self.synced = Instant::now();
        self.file.sync_data().map_err(|source| IoError::io(&self.path, source))
    }

    /// The file of work that is done, to read from, when everything is on the disk. It stays locked.
    ///
    /// # Errors
    /// [`IoError::Io`] if the system refuses.
    pub fn into_reader(mut self) -> Result<RecordReader, IoError> {
        debug_assert_eq!(self.done, self.layout.count, "records that are done");
        self.sync()?;
        let Self { path, file, layout, .. } = self;
        Ok(RecordReader { path, file: Mutex::new(file), layout })
    }
}

/// The records of work that is done, in their file. It stays locked as long as this is there.
#[derive(Debug)]
pub struct RecordReader {
    path: PathBuf,
    /// A file has one place to read at.
    file: Mutex<File>,
    layout: RecordLayout,
}

impl RecordReader {
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

fn header(format: &RecordFormat, layout: &RecordLayout, fingerprint: &Fingerprint) -> Vec<u8> {
    let [high, low] = fingerprint.bits();
    let mut bytes = [MAGIC, format.kind].concat();
    [VERSION, format.version].iter().for_each(|number| bytes.extend(number.to_le_bytes()));
    let numbers = [layout.count as u64, layout.bytes as u64, layout.last as u64, high, low];
    numbers.iter().for_each(|number| bytes.extend(number.to_le_bytes()));
    bytes.extend(checksum(high, u64::MAX, &bytes).to_le_bytes());
    debug_assert_eq!(bytes.len(), HEADER, "bytes of the header");
    bytes
}

fn checksum(seed: u64, number: u64, bytes: &[u8]) -> u64 {
    XxHash3_64::oneshot_with_seed(seed ^ number, bytes)
}

/// Whether the file holds nothing yet. An error if it holds anything but results of this work.
fn is_new(path: &Path, file: &mut File, format: &RecordFormat, expected: &[u8]) -> Result<bool, IoError> {
    let mut found = Vec::new();
    Read::take(file, HEADER as u64).read_to_end(&mut found).map_err(|source| IoError::io(path, source))?;
    if found == expected {
        return Ok(false);
    }
    if found.iter().all(|&b| b == 0) {
        return Ok(true);
    }
    let RecordFormat { work, arguments, .. } = format;
    Err(IoError::invalid(
        path,
        if found.get(..8) != expected.get(..8) {
            format!("this is no checkpoint of a {work}; move it away")
        } else if found.get(8..16) != expected.get(8..16) {
            "this checkpoint was made by another version of Lobe; remove it to start anew".to_owned()
        } else {
            format!(
                "this checkpoint is of another {work}: {arguments} differ; repeat that command to continue it, or remove \
                 it to start anew"
            )
        },
    ))
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
    use std::fs;

    use super::*;

    const FORMAT: RecordFormat = RecordFormat { kind: *b"TEST", version: 1, work: "test", arguments: "the options" };

    const LAYOUT: RecordLayout = RecordLayout { count: 5, bytes: 12, last: 4 };

    fn record(number: usize) -> Vec<u8> {
        vec![10 + number as u8; LAYOUT.len(number)]
    }

    fn open(path: &Path, kind: u64) -> Result<(RecordFile, Vec<u8>), IoError> {
        let mut found = Vec::new();
        let take_up = |body: &[u8]| found.push(body[0] - 10);
        let file = RecordFile::open(path, &FORMAT, LAYOUT, &Fingerprint::of_kind(kind), take_up)?;
        Ok((file, found))
    }

    fn complete(path: &Path) {
        let mut file = open(path, 99).unwrap().0;
        while file.done() < LAYOUT.count {
            file.push(record(file.done())).unwrap();
        }
    }

    #[test]
    fn wherever_a_file_was_cut_off_or_zeroed_it_goes_on_from_a_whole_record() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("p");
        complete(&path);
        let whole = fs::read(&path).unwrap();
        assert_eq!(whole.len(), HEADER + 4 * (12 + SUM) + 4 + SUM, "bytes of the file");
        for end in 0..=whole.len() {
            if (1..HEADER).contains(&end) {
                // The header is written at once.
                continue;
            }
            let mut zeroed = whole.clone();
            zeroed[end..].fill(0);
            for (what, bytes) in [("cut off", &whole[..end]), ("zeroed", &zeroed[..])] {
                fs::write(&path, bytes).unwrap();
                let (file, found) = open(&path, 99).unwrap();
                let expected = (0..5).take_while(|&k| end >= LAYOUT.offset(k) as usize + LAYOUT.len(k) + SUM).count();
                assert!(found.iter().copied().eq(0..expected as u8), "{what} after {end}: {found:?}");
                assert_eq!(fs::metadata(&path).unwrap().len(), whole.len() as u64, "room, {what} after {end}");
                drop(file);
                complete(&path);
                assert!(fs::read(&path).unwrap() == whole, "completed, {what} after {end}");
            }
        }
    }

    #[test]
    fn checkpoints_of_others_are_refused_and_damage_is_not_believed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("p");
        complete(&path);
        let refusal = |kind| open(&path, kind).unwrap_err().to_string();
        assert!(refusal(98).contains("is of another test: the options differ; "), "{}", refusal(98));
        let whole = fs::read(&path).unwrap();
        for at in HEADER..whole.len() {
            let mut bad = whole.clone();
            bad[at] ^= 0x40;
            fs::write(&path, bad).unwrap();
            let expected = (at - HEADER) / (12 + SUM);
            assert_eq!(open(&path, 99).unwrap().0.done(), expected, "records before byte {at}, which is wrong");
        }
        for (at, expected) in [
            (0, "this is no checkpoint of a test; move it away"),
            (5, "this is no checkpoint of a test; move it away"),
            (8, "made by another version of Lobe"),
            (12, "made by another version of Lobe"),
            (16, "is of another test"),
            (50, "is of another test"),
        ] {
            let mut other = whole.clone();
            other[at] ^= 0x40;
            fs::write(&path, &other).unwrap();
            assert!(refusal(99).contains(expected), "byte {at}: {}", refusal(99));
            assert!(fs::read(&path).unwrap() == other, "what is refused is not touched, byte {at}");
        }
        fs::write(&path, b"").unwrap();
        let held = open(&path, 99).unwrap();
        assert!(refusal(99).contains("another run is writing this checkpoint"), "in use");
        drop(held);
    }

    #[test]
    fn records_are_read_back_from_a_file_that_stays_locked() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("p");
        complete(&path);
        let reader = open(&path, 99).unwrap().0.into_reader().unwrap();
        for number in 0..5 {
            let mut bytes = vec![0; LAYOUT.len(number)];
            reader.read_exact_at(reader.layout().offset(number), &mut bytes).unwrap();
            assert_eq!(bytes, record(number), "record {number}");
        }
        assert!(open(&path, 99).is_err(), "in use");
    }

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
