//! Descriptions of scenes that move. They name files beside themselves, so the bytes are read from a file.
#![no_main]

use std::sync::OnceLock;

use libfuzzer_sys::fuzz_target;
use lobe_shadow::SceneDescription;

fuzz_target!(|bytes: &[u8]| {
    static PATH: OnceLock<std::path::PathBuf> = OnceLock::new();
    let path =
        PATH.get_or_init(|| std::env::temp_dir().join(format!("lobe-fuzz-description-{}.json", std::process::id())));
    std::fs::write(path, bytes).expect("the folder of temporary files can be written");
    if let Err(error) = SceneDescription::read(path, false) {
        let line = error.to_string();
        assert!(!line.contains('\n'), "{line:?}");
    }
});
