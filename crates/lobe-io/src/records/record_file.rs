//! Checkpoints: records on disk while long work goes on, so that it can be stopped, killed and continued.

use std::fs::{File, TryLockError};
use std::io::{self, BufReader, BufWriter, Read, Seek as _, SeekFrom, Write};
use std::path::{Path, PathBuf};

use web_time::{Duration, Instant};

use crate::error::IoError;
use crate::fingerprint::Fingerprint;
use crate::records::layout::{HEADER, Header, SUM, header_at};
use crate::records::layout::{RecordFormat, RecordLayout};
use crate::records::record_reader::RecordReader;
use crate::shard::Shard;

/// What was pushed reaches the disk at least this often. Work pushes about once a second, so that a machine that loses
/// its power costs less than 10 s of work.
const SYNC_EVERY: Duration = Duration::from_secs(4);

/// The records of a piece of work, or of a [shard](Shard) of it, that are done, in a file of its final size.
///
/// ```text
///   preface: of a shard only: a header of safetensors with the one tensor `records`, which is all that follows
///   header:  "LOBE", kind (4 letters), version 3 of this layout, version of the kind (u32),
///            records in all, bytes of a record, bytes of the last, fingerprint (128 bits, the higher 64 first),
///            number of the shard, number of shards (u64; 1 and 1 if it is all), checksum (u64)
///   record:  its bytes, checksum (u64)
/// ```
///
/// All numbers are little-endian. There is a place for each record in its order, zero until it is pushed. A checksum is
/// the XXH3-64 of the bytes before it from the header on, seeded with the exclusive or of the first half of the fingerprint and
/// the number of the record among all (of the header: 2⁶⁴ - 1), so that zeros and torn or old records are not taken for done. The
/// header is written when all the room is there, so that a file without one holds nothing yet.
#[derive(Debug)]
pub struct RecordFile {
    path: PathBuf,
    file: File,
    header: Header,
    /// Where the header begins.
    start: u64,
    done: usize,
    synced: Instant,
}

impl RecordFile {
    /// Opens the checkpoint of a piece of work, or makes one of its final size. `take_up` gets the records that are there
    /// already, from the first to the last before one that is missing or damaged. The file of a shard has its records alone, which
    /// are counted among all.
    ///
    /// # Errors
    /// [`IoError::Io`] if it cannot be written or the disk has no room for all of it; [`IoError::Invalid`] if it is that of
    /// other work, or none, or in use.
    pub fn open(
        path: &Path,
        format: &RecordFormat,
        layout: RecordLayout,
        fingerprint: &Fingerprint,
        shard: Option<Shard>,
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
        let header = Header::new(format, layout, fingerprint, shard.unwrap_or(Shard::WHOLE));
        let preface = if shard.is_some() { header.preface(format.work) } else { Vec::new() };
        let is_new = is_new(path, &mut file, format, &header, &preface)?;
        // Take all the room there will be need for.
        let start = preface.len() as u64;
        let room = start + layout.bytes_of(header.shard);
        let made = fill(&mut file, room).and_then(|()| {
            if is_new {
                file.seek(SeekFrom::Start(0))?;
                file.write_all(&[preface, header.to_bytes()].concat())?;
            }
            file.sync_all()
        });
        if let Err(source) = made {
            if is_new {
                // What was written is of no use to anyone; that it could not be is the error to report.
                let _ = std::fs::remove_file(path);
            }
            let message = format!("cannot keep {room} bytes of results: {source}");
            return Err(io(io::Error::new(source.kind(), message)));
        }
        // Take up the records that are done.
        let done = header.shard.range(layout.count).start;
        let mut records = Self { path: path.to_path_buf(), file, header, start, done, synced: Instant::now() };
        records.take_up(take_up).map_err(io)?;
        Ok(records)
    }

    /// Finds how many records from the first on are done, and leaves the file at their end.
    fn take_up(&mut self, mut take_up: impl FnMut(&[u8])) -> io::Result<()> {
        self.file.seek(SeekFrom::Start(self.start + HEADER as u64))?;
        let mut reader = BufReader::with_capacity(1 << 20, &self.file);
        let (mut bytes, mut whole) = (Vec::new(), 0);
        while self.done < self.end() {
            bytes.resize(self.header.layout.len(self.done) + SUM, 0);
            reader.read_exact(&mut bytes)?;
            let Some((body, sum)) = bytes.split_last_chunk() else { break };
            if u64::from_le_bytes(*sum) != self.header.checksum(self.done as u64, body) {
                break;
            }
            take_up(body);
            whole += bytes.len();
            self.done += 1;
        }
        self.file.seek(SeekFrom::Start(self.start + (HEADER + whole) as u64))?;
        Ok(())
    }

    /// The number of the first record that is not done: of all records, how many are done.
    #[must_use]
    pub fn done(&self) -> usize {
        self.done
    }

    /// The number behind that of the last record.
    fn end(&self) -> usize {
        self.header.shard.range(self.header.layout.count).end
    }

    /// Writes the next record, and brings it to the disk if none was for some seconds.
    ///
    /// # Errors
    /// [`IoError::Io`] if the system refuses.
    ///
    /// # Panics
    /// If all records are done, or this is not as long as it should be.
    pub fn push(&mut self, mut record: Vec<u8>) -> Result<(), IoError> {
        assert!(self.done < self.end(), "the records up to {} are done", self.end());
        assert_eq!(record.len(), self.header.layout.len(self.done), "bytes of record {}", self.done);
        record.extend(self.header.checksum(self.done as u64, &record).to_le_bytes());
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
    ///
    /// # Panics
    /// If it is a shard.
    pub fn into_reader(mut self) -> Result<RecordReader, IoError> {
        assert_eq!(self.start, 0, "expected all records, found shard {}", self.header.shard);
        debug_assert_eq!(self.done, self.header.layout.count, "records that are done");
        self.sync()?;
        let Self { path, file, header, .. } = self;
        Ok(RecordReader::new(path, file, header.layout))
    }
}

/// Whether the file holds nothing yet. An error if it holds anything but results of this work.
fn is_new(
    path: &Path,
    file: &mut File,
    format: &RecordFormat,
    header: &Header,
    preface: &[u8],
) -> Result<bool, IoError> {
    let expected = [preface, &header.to_bytes()].concat();
    let mut found = Vec::new();
    Read::take(&mut *file, expected.len() as u64)
        .read_to_end(&mut found)
        .map_err(|source| IoError::io(path, source))?;
    if found == expected {
        return Ok(false);
    }
    if found.iter().all(|&b| b == 0) {
        return Ok(true);
    }
    // Compare from the header on, wherever that is.
    let at = header_at(&found).unwrap_or(0);
    let mut found = Vec::new();
    let read = file.seek(SeekFrom::Start(at)).and_then(|_| Read::take(file, HEADER as u64).read_to_end(&mut found));
    read.map_err(|source| IoError::io(path, source))?;
    let expected = header.to_bytes();
    let RecordFormat { work, arguments, .. } = format;
    let other = Header::parse(&found).filter(|other| Header { shard: header.shard, ..*other } == *header);
    Err(IoError::invalid(
        path,
        if found.get(..8) != expected.get(..8) {
            format!("this is no checkpoint of a {work}; move it away")
        } else if found.get(8..16) != expected.get(8..16) {
            "this checkpoint was made by another version of Lobe; remove it to start anew".to_owned()
        } else if let Some(other) = other {
            format!("this is shard {} of the {work}, not {}; give another output", other.shard, header.shard)
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
        let file = RecordFile::open(path, &FORMAT, LAYOUT, &Fingerprint::of_kind(kind), None, take_up)?;
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
