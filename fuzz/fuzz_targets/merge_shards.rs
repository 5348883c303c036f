//! The files of two shards, one of which was damaged, is cut off, or is another file: they become the checkpoint of all, or nothing is
//! written. An odd first byte says that what follows are pairs of a place and a change of the second, after a length to cut it off
//! at; with an even one follows what the header of the second promises, which may be more than there is.
#![no_main]

use std::fs;
use std::path::PathBuf;
use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use lobe_fuzz::path_of_process;
use lobe_io::{Fingerprint, Job, RecordFile, RecordFormat, RecordLayout, Shard, merge_shards};

const FORMAT: RecordFormat = RecordFormat { kind: *b"FUZZ", version: 1, work: "test", arguments: "the options" };

const LAYOUT: RecordLayout = RecordLayout { count: 5, bytes: 12, last: 4 };

/// Sizes that a header promises, at most: a file takes its room when it is made.
const MAX_SIZE: u64 = 1 << 10;

/// A folder of this process.
static FOLDER: LazyLock<PathBuf> = LazyLock::new(|| {
    let folder = path_of_process("shards");
    fs::create_dir_all(&folder).expect("the folder can be written");
    folder
});

/// The bytes of a file with these records of the work.
fn made(name: &str, layout: RecordLayout, shard: Option<Shard>) -> Vec<u8> {
    let path = FOLDER.join(name);
    let _ = fs::remove_file(&path);
    let mut file =
        RecordFile::open(&path, &FORMAT, layout, &Fingerprint::of_kind(7), shard, |_| ()).expect("a new file");
    let end = shard.map_or(layout.count, |shard| shard.range(layout.count).end);
    while layout == LAYOUT && file.done() < end {
        let bytes = if file.done() + 1 == LAYOUT.count { LAYOUT.last } else { LAYOUT.bytes };
        file.push(vec![10 + file.done() as u8; bytes]).expect("the work goes on");
    }
    drop(file);
    fs::read(&path).expect("the file is there")
}

/// The checkpoint of all, and the second shard. The first lies in its file.
static WHOLE: LazyLock<[Vec<u8>; 2]> = LazyLock::new(|| {
    made("first", LAYOUT, Shard::new(1, 2));
    [made("whole", LAYOUT, None), made("second", LAYOUT, Shard::new(2, 2))]
});

fn damaged(edits: &[u8]) -> Vec<u8> {
    let mut bytes = WHOLE[1].clone();
    let Some((length, edits)) = edits.split_first_chunk() else { return bytes };
    bytes.truncate(u16::from_le_bytes(*length).into());
    for [place, change] in edits.as_chunks::<2>().0 {
        if let Some(byte) = bytes.get_mut(usize::from(*place)) {
            *byte ^= change;
        }
    }
    bytes
}

/// The beginning of a shard of the sizes that the bytes say.
fn promising(bytes: &[u8]) -> Vec<u8> {
    let mut sizes = bytes.as_chunks::<2>().0.iter().map(|size| u64::from(u16::from_le_bytes(*size)) % MAX_SIZE);
    let mut next = || sizes.next().unwrap_or(1) as usize;
    let bytes = next();
    let layout = RecordLayout { count: next() + 1, bytes, last: next() % (bytes + 1) };
    let mut file = made("promise", layout, Shard::new(next() as u32, next() as u32));
    file.truncate(next());
    file
}

fuzz_target!(|bytes: &[u8]| {
    LazyLock::force(&WHOLE);
    let second = match bytes {
        [odd, edits @ ..] if odd % 2 == 1 => damaged(edits),
        [_, sizes @ ..] => promising(sizes),
        [] => Vec::new(),
    };
    let merged = FOLDER.join("merged");
    let parts = [FOLDER.join("first"), FOLDER.join("second")];
    fs::write(&parts[1], second).expect("the file can be written");
    match merge_shards(&parts, &merged, Job::default()) {
        Ok(()) => {
            assert_eq!(fs::read(&merged).expect("the file is there"), WHOLE[0], "the checkpoint of all");
            fs::remove_file(&merged).expect("the file can be removed");
        }
        Err(error) => {
            let line = error.to_string();
            assert!(!line.contains('\n'), "{line:?}");
            assert!(!merged.exists(), "nothing is half written: {line}");
        }
    }
});
