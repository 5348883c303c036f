//! A checkpoint: a complete one that was damaged, or whatever else lies there under its name. An odd first byte says that
//! what follows are pairs of a place and a change of a complete one, after a length to cut it off at.
#![no_main]

use std::fs;
use std::path::PathBuf;
use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use lobe_fuzz::path_of_process;
use lobe_io::{Fingerprint, IoError, RecordFile, RecordFormat, RecordLayout};

const FORMAT: RecordFormat = RecordFormat { kind: *b"FUZZ", version: 1, work: "test", arguments: "the options" };

const LAYOUT: RecordLayout = RecordLayout { count: 5, bytes: 12, last: 4 };

/// A file of this process.
static PATH: LazyLock<PathBuf> = LazyLock::new(|| path_of_process("checkpoint"));

/// The bytes of a complete checkpoint.
static WHOLE: LazyLock<Vec<u8>> = LazyLock::new(|| {
    fs::write(&*PATH, []).expect("the file can be written");
    complete(open(&mut Vec::new()).expect("an empty file is a new checkpoint"));
    fs::read(&*PATH).expect("the file is there")
});

fn record(number: usize) -> Vec<u8> {
    let bytes = if number + 1 == LAYOUT.count { LAYOUT.last } else { LAYOUT.bytes };
    vec![10 + number as u8; bytes]
}

fn open(found: &mut Vec<Vec<u8>>) -> Result<RecordFile, IoError> {
    RecordFile::open(&PATH, &FORMAT, LAYOUT, &Fingerprint::of_kind(7), None, |body| found.push(body.to_vec()))
}

fn complete(mut file: RecordFile) {
    while file.done() < LAYOUT.count {
        file.push(record(file.done())).expect("the work goes on");
    }
}

fn damaged(edits: &[u8]) -> Vec<u8> {
    let Some((length, edits)) = edits.split_first() else { return WHOLE.clone() };
    let mut bytes = WHOLE.clone();
    bytes.truncate(usize::from(*length));
    for [place, change] in edits.as_chunks::<2>().0 {
        if let Some(byte) = bytes.get_mut(usize::from(*place)) {
            *byte ^= change;
        }
    }
    bytes
}

fuzz_target!(|bytes: &[u8]| {
    let bytes = match bytes {
        [odd, edits @ ..] if odd % 2 == 1 => damaged(edits),
        _ => bytes.to_vec(),
    };
    fs::write(&*PATH, &bytes).expect("the file can be written");
    let mut found = Vec::new();
    match open(&mut found) {
        Ok(file) => {
            assert_eq!(found.len(), file.done(), "records taken up");
            assert!(found.iter().enumerate().all(|(k, body)| *body == record(k)), "only whole records: {found:?}");
            complete(file);
            let left = fs::read(&*PATH).expect("the file is there");
            assert_eq!(left, *WHOLE, "completed");
        }
        Err(error) => {
            let line = error.to_string();
            assert!(line.contains("checkpoint") && !line.contains('\n'), "{line:?}");
            assert_eq!(fs::read(&*PATH).expect("the file is there"), bytes, "what is refused stays as it is");
        }
    }
    fs::remove_file(&*PATH).expect("the file can be removed");
});
