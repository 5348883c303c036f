//! Merging: the checkpoint of all of a piece of work from those of its shards.

use std::fs::{File, TryLockError};
use std::io::{self, BufReader, Read as _, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};

use web_time::Instant;

use crate::error::IoError;
use crate::job::{Job, Progress};
use crate::records::layout::{HEADER, Header, SUM, header_at};
use crate::shard::Shard;
use crate::staged::{StagedFile, StagedWriter};

/// Bytes between two reports: a fraction of a second of copying.
const REPORT_EVERY: usize = 32 << 20;

/// The most missing shards that a message names.
const MOST_NAMED: usize = 8;

/// Writes the checkpoint of a piece of work whose shards are all done: the same bytes that one machine alone would have left there.
/// The work that is then [kept in](Job::kept_in) it finds all of its records, if the shards are of the same arguments, and has only
/// to write its results. `parts` are the files of the shards in any order. The steps of `job` are records.
///
/// # Errors
/// [`IoError::Invalid`] that names the file if one is no shard or not whole, if shards are of different work or missing, or one is
/// there twice; [`IoError::Io`] if the system refuses; [`IoError::Cancelled`] if the watch of the job said to stop. What stood
/// under `checkpoint` is then untouched.
pub fn merge_shards(parts: &[PathBuf], checkpoint: &Path, job: Job<'_>) -> Result<(), IoError> {
    let mut parts: Vec<Part> = parts.iter().map(|path| Part::open(path)).collect::<Result<_, _>>()?;
    parts.sort_by_key(|part| part.header.shard);
    expect_all(&parts, checkpoint)?;
    // Held until the new file is in the place of the old one: no run takes the old one up meanwhile.
    let _old = lock_old(checkpoint)?;
    let out = StagedWriter::new(checkpoint).map_err(|source| IoError::io(checkpoint, source))?;
    let mut copy = Copy { out, checkpoint, job, begin: Instant::now(), bytes: 0 };
    let all = Header { shard: Shard::WHOLE, ..parts[0].header };
    copy.write(&all.to_bytes())?;
    copy.report(0, all.layout.count)?;
    for part in parts {
        copy.records_of(part)?;
    }
    let staged = copy.out.finish().and_then(StagedFile::publish);
    staged.map_err(|source| IoError::io(checkpoint, source))
}

/// The checkpoint that is there already, locked as long as it is open; an error if a run is writing it.
fn lock_old(checkpoint: &Path) -> Result<Option<File>, IoError> {
    let Ok(old) = File::open(checkpoint) else { return Ok(None) };
    if let Err(TryLockError::WouldBlock) = old.try_lock_shared() {
        let message = "another run is writing this checkpoint; wait for it, or give another output";
        return Err(IoError::invalid(checkpoint, message));
    }
    Ok(Some(old))
}

/// The file of a shard.
struct Part {
    path: PathBuf,
    file: File,
    header: Header,
}

impl Part {
    /// Opens it, and leaves it at its first record.
    fn open(path: &Path) -> Result<Self, IoError> {
        let io = |source| IoError::io(path, source);
        let mut file = File::open(path).map_err(io)?;
        if let Err(TryLockError::WouldBlock) = file.try_lock_shared() {
            return Err(IoError::invalid(path, "another run is writing this shard; wait for it"));
        }
        let mut bytes = Vec::new();
        (&file).take(HEADER as u64).read_to_end(&mut bytes).map_err(io)?;
        let at = header_at(&bytes).unwrap_or(0);
        // The preface is short.
        file.seek(SeekFrom::Start(0)).map_err(io)?;
        bytes.clear();
        (&file).take(at + HEADER as u64).read_to_end(&mut bytes).map_err(io)?;
        let preface = bytes.get(..at as usize).unwrap_or_default();
        let Some(header) = bytes.get(at as usize..).and_then(Header::parse) else {
            let message = "expected a shard, as this version of Lobe leaves it, found something else";
            return Err(IoError::invalid(path, message));
        };
        if !(preface.is_empty() || header.is_preface(preface)) {
            let message =
                "its header of safetensors is not that of its shard: the file was changed; make the shard anew";
            return Err(IoError::invalid(path, message));
        }
        // A header that lies may ask for more bytes than there are numbers.
        let expected = at.saturating_add(header.layout.bytes_of(header.shard));
        let found = file.metadata().map_err(io)?.len();
        if found > expected {
            let message =
                format!("expected {expected} bytes, found {found}: the file was changed; make the shard anew");
            return Err(IoError::invalid(path, message));
        }
        Ok(Self { path: path.to_path_buf(), file, header })
    }
}

/// A shard of the work that most of them are of, the first in their order; of works with as many shards that of the lowest number. The one
/// that does not belong there is more often one than most, and as often the first as any other.
fn of_most(parts: &[Part]) -> Option<&Part> {
    let work = |part: &Part| (Header { shard: Shard::WHOLE, ..part.header }, part.header.shard.count());
    let mut works: Vec<(&Part, usize)> = Vec::new();
    for part in parts {
        match works.iter_mut().find(|(first, _)| work(first) == work(part)) {
            Some((_, shards)) => *shards += 1,
            None => works.push((part, 1)),
        }
    }
    // The last of the greatest is what `max_by_key` finds.
    works.into_iter().rev().max_by_key(|&(_, shards)| shards).map(|(first, _)| first)
}

/// Refuses shards, in their order, that are not those of one piece of work.
fn expect_all(parts: &[Part], checkpoint: &Path) -> Result<(), IoError> {
    let Some(first) = of_most(parts) else {
        return Err(IoError::invalid(checkpoint, "expected the files of its shards, found none"));
    };
    let name = |part: &Part| part.path.display().to_string();
    for part in parts {
        let (shard, expected) = (part.header.shard, first.header.shard);
        if (Header { shard: expected, ..part.header }) != first.header {
            let message = "is a shard of other work: what it was made from, its options, the version of Lobe or the kind of machine (LOBE_SIMD) differ";
            return Err(IoError::invalid(&part.path, format!("{message} from those of {}", name(first))));
        }
        if shard.count() != expected.count() {
            let message =
                format!("is shard {shard}, found among shards of {}, such as {}", expected.count(), name(first));
            return Err(IoError::invalid(&part.path, message));
        }
    }
    for pair in parts.windows(2) {
        let shard = pair[1].header.shard;
        if pair[0].header.shard == shard {
            let message = format!("is shard {shard}, and so is {}; leave one of them out", name(&pair[0]));
            return Err(IoError::invalid(&pair[1].path, message));
        }
    }
    let count = first.header.shard.count();
    let missing = count as usize - parts.len();
    if missing == 0 {
        return Ok(());
    }
    // The count is a promise of a file: no list is as long.
    let is_there = |number: &u32| parts.binary_search_by_key(number, |part| part.header.shard.number()).is_ok();
    let named: Vec<String> =
        (1..=count).filter(|n| !is_there(n)).take(MOST_NAMED).map(|n| format!("{n}/{count}")).collect();
    let more = missing - named.len();
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    let named = named.join(", ");
    let message = format!("expected {count} shards, found {}; missing: {named}{more}", parts.len());
    Err(IoError::invalid(checkpoint, message))
}

/// The copying of records.
struct Copy<'a, 'b> {
    out: StagedWriter,
    checkpoint: &'a Path,
    job: Job<'b>,
    begin: Instant,
    /// Bytes since the last report.
    bytes: usize,
}

impl Copy<'_, '_> {
    fn write(&mut self, bytes: &[u8]) -> Result<(), IoError> {
        self.out.write_all(bytes).map_err(|source| IoError::io(self.checkpoint, source))
    }

    fn report(&mut self, done: usize, total: usize) -> Result<(), IoError> {
        self.bytes = 0;
        let progress = Progress { done, total, elapsed: self.begin.elapsed(), ..Progress::default() };
        // What is complete counts as done, not as stopped.
        if self.job.report(&progress).is_break() && done < total { Err(IoError::Cancelled) } else { Ok(()) }
    }

    /// Copies the records of a shard, each of which must be whole.
    fn records_of(&mut self, part: Part) -> Result<(), IoError> {
        let Part { path, file, header } = part;
        let (layout, range) = (header.layout, header.shard.range(header.layout.count));
        let file_bytes = file.metadata().map_err(|source| IoError::io(&path, source))?.len();
        let mut reader = BufReader::with_capacity(1 << 20, file);
        let mut bytes = Vec::new();
        for record in range.clone() {
            // What the header promises is taken for true only where the file is as long.
            let promised = layout.len(record).checked_add(SUM).filter(|&bytes| bytes as u64 <= file_bytes);
            let is_whole = match promised {
                None => false,
                Some(length) => {
                    bytes.resize(length, 0);
                    match reader.read_exact(&mut bytes) {
                        Ok(()) => bytes.split_last_chunk().is_some_and(|(body, sum)| {
                            u64::from_le_bytes(*sum) == header.checksum(record as u64, body)
                        }),
                        Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => false,
                        Err(source) => return Err(IoError::io(&path, source)),
                    }
                }
            };
            if !is_whole {
                let (done, all) = (record - range.start, range.len());
                let message = format!(
                    "shard {} is not complete: {done} of {all} records are whole; repeat its command, which goes on from there",
                    header.shard
                );
                return Err(IoError::invalid(&path, message));
            }
            self.write(&bytes)?;
            self.bytes += bytes.len();
            if self.bytes >= REPORT_EVERY || record + 1 == layout.count {
                self.report(record + 1, layout.count)?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::ops::ControlFlow;

    use super::*;
    use crate::fingerprint::Fingerprint;
    use crate::records::layout::{RecordFormat, RecordLayout};
    use crate::records::record_file::RecordFile;

    const FORMAT: RecordFormat = RecordFormat { kind: *b"TEST", version: 1, work: "test", arguments: "the options" };

    const LAYOUT: RecordLayout = RecordLayout { count: 10, bytes: 12, last: 4 };

    /// Makes the first `records` records of a shard.
    fn make(path: &Path, kind: u64, shard: Option<Shard>, records: usize) {
        let key = Fingerprint::of_kind(kind);
        let mut file = RecordFile::open(path, &FORMAT, LAYOUT, &key, shard, |_| ()).unwrap();
        let range = shard.unwrap_or(Shard::WHOLE).range(LAYOUT.count);
        while file.done() < range.end.min(range.start.saturating_add(records)) {
            file.push(vec![1 + file.done() as u8; LAYOUT.len(file.done())]).unwrap();
        }
    }

    /// All shards of a folder, and the checkpoint of a machine that made all.
    fn shards(folder: &Path, count: u32) -> (Vec<PathBuf>, PathBuf) {
        let parts = (1..=count).map(|number| {
            let path = folder.join(format!("part{number}-{count}"));
            make(&path, 1, Shard::new(number, count), usize::MAX);
            path
        });
        let whole = folder.join("whole");
        make(&whole, 1, None, LAYOUT.count);
        (parts.collect(), whole)
    }

    #[test]
    fn shards_in_any_order_become_what_one_machine_makes() {
        let folder = tempfile::tempdir().unwrap();
        for count in [1, 2, 3, 7, 10, 13] {
            let (mut parts, whole) = shards(folder.path(), count);
            let merged = folder.path().join("merged");
            for _ in 0..2 {
                parts.reverse();
                parts.swap(0, count as usize / 2);
                merge_shards(&parts, &merged, Job::default()).unwrap();
                assert!(fs::read(&merged).unwrap() == fs::read(&whole).unwrap(), "{count} shards");
            }
        }
    }

    #[test]
    fn a_shard_goes_on_from_wherever_it_was_cut_off() {
        let folder = tempfile::tempdir().unwrap();
        let shard: Shard = "2/3".parse().unwrap();
        let path = folder.path().join("part");
        make(&path, 1, Some(shard), usize::MAX);
        let whole = fs::read(&path).unwrap();
        let header = header_at(&whole).unwrap() as usize + HEADER;
        for end in (header..whole.len()).chain([0]) {
            fs::write(&path, &whole[..end]).unwrap();
            make(&path, 1, Some(shard), usize::MAX);
            assert!(fs::read(&path).unwrap() == whole, "cut off after {end}");
        }
        let other = RecordFile::open(&path, &FORMAT, LAYOUT, &Fingerprint::of_kind(1), "1/3".parse().ok(), |_| ());
        let refusal = other.unwrap_err().to_string();
        assert!(refusal.ends_with("this is shard 2/3 of the test, not 1/3; give another output"), "{refusal}");
        let other = RecordFile::open(&path, &FORMAT, LAYOUT, &Fingerprint::of_kind(2), Some(shard), |_| ());
        let refusal = other.unwrap_err().to_string();
        assert!(refusal.contains("is of another test: the options differ"), "{refusal}");
    }

    #[test]
    fn what_is_not_all_shards_of_one_piece_of_work_is_refused_by_name() {
        let folder = tempfile::tempdir().unwrap();
        let (parts, whole) = shards(folder.path(), 3);
        let other = folder.path().join("other");
        make(&other, 2, "2/3".parse().ok(), usize::MAX);
        let of_four = folder.path().join("four");
        make(&of_four, 1, "2/4".parse().ok(), usize::MAX);
        let half = folder.path().join("half");
        make(&half, 1, "2/3".parse().ok(), 1);
        let short = folder.path().join("short");
        let bytes = fs::read(&parts[1]).unwrap();
        fs::write(&short, &bytes[..bytes.len() - 1]).unwrap();
        let text = folder.path().join("text");
        fs::write(&text, "no shard").unwrap();
        let long = folder.path().join("long");
        fs::write(&long, [&bytes[..], b"more"].concat()).unwrap();
        let renamed = folder.path().join("renamed");
        let at = header_at(&bytes).unwrap() as usize;
        fs::write(&renamed, [&bytes[..8], &b"[]".repeat(at / 2 - 4), &bytes[at..]].concat()).unwrap();
        let [a, b, c] = &parts[..] else { panic!("three shards") };
        let merged = folder.path().join("merged");
        fs::write(&merged, "what stood there").unwrap();
        for (given, expected) in [
            (vec![a, c], "merged: expected 3 shards, found 2; missing: 2/3"),
            (vec![b], "merged: expected 3 shards, found 1; missing: 1/3, 3/3"),
            (vec![], "merged: expected the files of its shards, found none"),
            (vec![a, b, c, b], "part2-3: is shard 2/3, and so is "),
            (vec![a, &other, c], "other: is a shard of other work: "),
            (vec![a, &of_four, c], "four: is shard 2/4, found among shards of 3, such as "),
            (vec![a, &half, c], "half: shard 2/3 is not complete: 1 of 3 records are whole; repeat its command, "),
            (vec![a, &short, c], "short: shard 2/3 is not complete: 2 of 3 records are whole; "),
            (vec![a, &text, c], "text: expected a shard, as this version of Lobe leaves it, found something else"),
            (vec![a, &long, c], ": the file was changed; make the shard anew"),
            (vec![a, &renamed, c], "renamed: its header of safetensors is not that of its shard: "),
            (vec![a, &whole, c], "whole: is shard 1/1, found among shards of 3, such as "),
        ] {
            let given: Vec<PathBuf> = given.into_iter().cloned().collect();
            let error = merge_shards(&given, &merged, Job::default()).unwrap_err().to_string();
            assert!(error.contains(expected), "{given:?}: {error}");
            assert_eq!(fs::read(&merged).unwrap(), b"what stood there", "{expected}");
        }
    }

    #[test]
    fn the_shard_that_does_not_belong_is_accused_wherever_it_stands() {
        let folder = tempfile::tempdir().unwrap();
        let (parts, _) = shards(folder.path(), 5);
        let merged = folder.path().join("merged");
        for (number, of, message) in (1..=5).flat_map(|n| [(n, 5, "is a shard of other work: "), (n, 6, "is shard ")]) {
            let foreign = folder.path().join(format!("foreign{number}-{of}"));
            make(&foreign, if of == 5 { 2 } else { 1 }, Shard::new(number, of), usize::MAX);
            let mut given = parts.clone();
            given[number as usize - 1] = foreign;
            let error = merge_shards(&given, &merged, Job::default()).unwrap_err().to_string();
            assert!(error.contains(&format!("foreign{number}-{of}: {message}")), "{number} of {of}: {error}");
            let of_most = if number == 1 { "part2-5" } else { "part1-5" };
            assert!(error.ends_with(of_most), "{number} of {of}: {error}");
            assert!(!merged.exists(), "{number} of {of}");
        }
    }

    #[test]
    fn no_memory_is_taken_for_records_that_the_file_is_too_short_for() {
        let folder = tempfile::tempdir().unwrap();
        let (path, merged) = (folder.path().join("part"), folder.path().join("merged"));
        let layout = RecordLayout { count: 1, bytes: 1 << 60, last: 1 << 60 };
        fs::write(&path, Header::new(&FORMAT, layout, &Fingerprint::of_kind(1), Shard::WHOLE).to_bytes()).unwrap();
        let error = merge_shards(&[path], &merged, Job::default()).unwrap_err().to_string();
        assert!(error.contains("shard 1/1 is not complete: 0 of 1 records are whole"), "{error}");
        assert!(!merged.exists(), "no checkpoint");
    }

    #[test]
    fn a_shard_that_claims_more_bytes_than_there_are_numbers_is_refused_as_incomplete() {
        let folder = tempfile::tempdir().unwrap();
        let (path, merged) = (folder.path().join("part"), folder.path().join("merged"));
        let layout = RecordLayout { count: 1 << 60, bytes: 1 << 60, last: 1 };
        let header = Header::new(&FORMAT, layout, &Fingerprint::of_kind(1), Shard::WHOLE);
        fs::write(&path, [header.preface("test"), header.to_bytes()].concat()).unwrap();
        let error = merge_shards(&[path], &merged, Job::default()).unwrap_err().to_string();
        let expected = format!("shard 1/1 is not complete: 0 of {} records are whole", 1_u64 << 60);
        assert!(error.contains(&expected), "{error}");
        assert!(!merged.exists(), "no checkpoint");
    }

    #[test]
    fn merging_is_stopped_without_a_trace() {
        let folder = tempfile::tempdir().unwrap();
        let (parts, _) = shards(folder.path(), 3);
        let merged = folder.path().join("merged");
        let mut stop = |_: &Progress| ControlFlow::Break(());
        let stopped = merge_shards(&parts, &merged, Job::default().watched_by(&mut stop));
        assert!(matches!(stopped, Err(IoError::Cancelled)), "{stopped:?}");
        assert!(!merged.exists(), "no checkpoint");
    }
}
