//! A corpus of small malformed files of every format: each gives an error of one line, no panic, and no memory is taken for
//! what it promises.
//!
//! The files lie in `tests/corpus`; [`corpus`] makes them. A test program of its own, which counts what is asked of the
//! allocator.

#![allow(clippy::unwrap_used, reason = "helpers of tests may panic")]

mod bytes;
mod corpus;
mod dds;
mod exr;
mod hdr;
mod jpg;
mod ktx2;
mod pfm;
mod png;
mod sh_json;

use std::alloc::{GlobalAlloc, Layout, System};
use std::collections::BTreeMap;
use std::fs;
use std::io::Cursor;
use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};

use lobe_env::{MapReadOptions, read_map_bytes};
use lobe_image::{ImageError, PictureReadOptions, PictureReadReport, PictureRows, read_picture_bytes};
use lobe_sh::sh_json::read_sh_json_bytes;

use crate::corpus::{bad_files, good_files, readme};

/// The most bytes that a reader may ask for at once. A block of some hundred bytes of DWA may hold 26 MiB; the sizes that a
/// file here declares take hundreds and more.
const MOST_AT_ONCE: usize = 64 << 20;

/// The system's allocator, which remembers the largest request.
struct Remembering;

static LARGEST_REQUEST: AtomicUsize = AtomicUsize::new(0);

#[global_allocator]
static ALLOCATOR: Remembering = Remembering;

#[allow(unsafe_code, reason = "an allocator is unsafe; all is left to that of the system")]
// SAFETY: every call is passed on as it is.
unsafe impl GlobalAlloc for Remembering {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        LARGEST_REQUEST.fetch_max(layout.size(), Ordering::Relaxed);
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        LARGEST_REQUEST.fetch_max(layout.size(), Ordering::Relaxed);
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn realloc(&self, memory: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        LARGEST_REQUEST.fetch_max(size, Ordering::Relaxed);
        unsafe { System.realloc(memory, layout, size) }
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        unsafe { System.dealloc(memory, layout) }
    }
}

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/corpus")
}

/// Reads a file as its name says: an expansion, or whatever picture or texture it is.
fn read(name: &str, bytes: &[u8]) -> Result<(), String> {
    if name.ends_with(".sh.json") {
        return read_sh_json_bytes(bytes, name).map(|_| ()).map_err(|e| e.to_string());
    }
    let options = MapReadOptions::default();
    let read = read_map_bytes(bytes, name, &options).map(|_| ()).map_err(|e| e.to_string());
    // A picture of any shape is read by other checks; it may be good where a map is not, but never panics.
    let raster = read_picture_bytes(bytes, name, &PictureReadOptions::default()).map(|_| ()).map_err(|e| e.to_string());
    assert_rows_are_alike(name, bytes);
    for message in [&read, &raster].into_iter().filter_map(|result| result.as_ref().err()) {
        assert_one_line(name, message);
    }
    read
}

/// A picture by rows is the picture: the same report, or the same error.
fn assert_rows_are_alike(name: &str, bytes: &[u8]) {
    let options = PictureReadOptions::default();
    let by_rows = || -> Result<Option<PictureReadReport>, ImageError> {
        let Some(mut rows) = PictureRows::new(Cursor::new(bytes), name, &options)? else { return Ok(None) };
        while rows.next_strips()?.is_some() {}
        rows.finish().map(Some)
    };
    let by_rows = by_rows().map_err(|e| e.to_string()).transpose();
    let whole = read_picture_bytes(bytes, name, &options).map(|(_, report)| report).map_err(|e| e.to_string());
    if let Some(by_rows) = by_rows {
        assert_eq!(by_rows, whole, "{name} by rows, and whole");
    }
}

fn assert_one_line(name: &str, message: &str) {
    assert!(message.starts_with(&format!("{name}: ")), "{name}: the file is not named in {message:?}");
    assert!(!message.chars().any(char::is_control), "{name}: more than one line: {message:?}");
    assert!(message.len() < 400, "{name}: {} bytes of message: {message:?}", message.len());
}

fn assert_little_was_asked_for(what: &str) {
    let largest = LARGEST_REQUEST.load(Ordering::Relaxed);
    assert!(largest < MOST_AT_ONCE, "{what}: {largest} bytes were asked for at once, for what a file promises");
}

/// Every file of the corpus with its bytes, as its makers make them.
fn made() -> BTreeMap<String, Vec<u8>> {
    let good = good_files().into_iter().map(|file| (format!("good/{}", file.name), file.bytes));
    let bad = bad_files().into_iter().map(|file| (format!("bad/{}", file.name), file.bytes));
    let mut files: BTreeMap<String, Vec<u8>> = good.chain(bad).collect();
    let message = |name: &str, bytes: &[u8]| read(name, bytes).err().unwrap_or_else(|| panic!("{name} is read"));
    files.insert("README.md".into(), readme(message).into_bytes());
    files
}

#[test]
#[ignore = "writes tests/corpus anew: cargo test -p lobe-env --test malformed -- --ignored make_the_corpus"]
fn make_the_corpus() {
    for part in ["good", "bad"] {
        fs::remove_dir_all(folder().join(part)).ok();
        fs::create_dir_all(folder().join(part)).unwrap();
    }
    for (name, bytes) in made() {
        fs::write(folder().join(name), bytes).unwrap();
    }
}

#[test]
fn the_corpus_is_what_its_makers_make() {
    const REMAKE: &str = "cargo test -p lobe-env --test malformed -- --ignored make_the_corpus makes the corpus anew";
    let made = made();
    let mut stored = BTreeMap::new();
    for part in ["", "good", "bad"] {
        for entry in fs::read_dir(folder().join(part)).unwrap() {
            let path = entry.unwrap().path();
            let name = path.strip_prefix(folder()).unwrap().to_str().unwrap().replace('\\', "/");
            if path.is_file() {
                stored.insert(name, fs::read(path).unwrap());
            }
        }
    }
    let names = |files: &BTreeMap<String, Vec<u8>>| files.keys().cloned().collect::<Vec<_>>();
    assert_eq!(names(&stored), names(&made), "files in the folder and files that are made; {REMAKE}");
    for (name, bytes) in &made {
        assert!(stored[name] == *bytes, "{name} is not what its maker makes; {REMAKE}");
    }
}

#[test]
fn every_malformed_file_is_an_error_of_one_line() {
    for file in bad_files() {
        let bytes = fs::read(folder().join("bad").join(&file.name)).unwrap_or_else(|e| panic!("{}: {e}", file.name));
        assert!(read(&file.name, &bytes).is_err(), "{} ({}) is read as if it were good", file.name, file.what);
        assert_little_was_asked_for(&file.name);
    }
}

#[test]
fn good_files_are_read() {
    for file in good_files() {
        let bytes = fs::read(folder().join("good").join(&file.name)).unwrap();
        read(&file.name, &bytes).unwrap_or_else(|message| panic!("{message}"));
    }
}

#[test]
fn a_file_cut_anywhere_in_its_header_is_an_error() {
    for file in good_files() {
        assert!((8..=file.bytes.len()).contains(&file.header), "{}: header of {}", file.name, file.header);
        for length in 0..file.header {
            assert!(read(&file.name, &file.bytes[..length]).is_err(), "{} cut to {length} bytes is read", file.name);
        }
    }
}

#[test]
fn no_byte_of_a_header_makes_a_reader_panic_or_take_memory() {
    for file in good_files() {
        for at in 0..file.header {
            for value in [0, 1, 0x20, 0x7f, 0x80, 0xff] {
                let mut bytes = file.bytes.clone();
                bytes[at] = value;
                // It may be a good file still; `read` checks the message if it is not.
                let _ = read(&file.name, &bytes);
                assert_little_was_asked_for(&format!("{}, byte {at} = {value}", file.name));
            }
        }
    }
}

#[test]
fn no_number_of_a_header_makes_a_reader_panic_or_take_memory() {
    for file in good_files() {
        for at in 0..file.header.min(file.bytes.len() - 3) {
            for value in [0, 1 << 16, 1 << 30, i32::MAX as u32, 1 << 31, u32::MAX] {
                for word in [value.to_le_bytes(), value.to_be_bytes()] {
                    let mut bytes = file.bytes.clone();
                    bytes[at..at + 4].copy_from_slice(&word);
                    let _ = read(&file.name, &bytes);
                    assert_little_was_asked_for(&format!("{}, {word:?} at {at}", file.name));
                }
            }
        }
    }
}
