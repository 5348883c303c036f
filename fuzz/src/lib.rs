//! Properties that the fuzz targets ask of readers, and their files.

use std::path::{Path, PathBuf};

/// A path for a file or a folder of this process, in memory where the system has such a folder.
pub fn path_of_process(name: &str) -> PathBuf {
    let memory = Path::new("/dev/shm");
    let folder = if memory.is_dir() { memory.into() } else { std::env::temp_dir() };
    folder.join(format!("lobe-fuzz-{}.{name}", std::process::id()))
}

/// Lets decoders of pictures panic without a word, as readers catch that: what nobody catches still ends the program, and what a target
/// asserts is printed.
pub fn let_decoders_panic() {
    std::panic::set_hook(Box::new(|panic| {
        if panic.location().is_some_and(|place| place.file().contains("fuzz_targets")) {
            eprintln!("{panic}");
        }
    }));
}

/// The message of a reader that refuses a file begins with the file's name, `fuzz`, and is one line.
///
/// # Panics
/// If it is not.
pub fn refused_in_one_line<T>(result: Result<T, impl std::fmt::Display>) {
    if let Err(error) = result {
        let line = error.to_string();
        assert!(line.starts_with("fuzz: ") && !line.contains('\n'), "{line:?}");
    }
}
