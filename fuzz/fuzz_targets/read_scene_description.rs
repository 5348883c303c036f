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
    match SceneDescription::read(path, false) {
        Ok(description) => evaluate(&description),
        Err(error) => {
            let line = error.to_string();
            assert!(!line.contains('\n'), "{line:?}");
        }
    }
});

/// Asks every track where it is: before, at and between its keys, and after.
fn evaluate(description: &SceneDescription) {
    let tracks = description.entities.iter().map(|entity| &entity.track);
    for track in tracks.chain(description.lamps.iter().map(|lamp| &lamp.track)) {
        for pair in track.keys().windows(2) {
            let [low, high] = [pair[0].time, pair[1].time];
            for time in [low, 0.5 * low + 0.5 * high, high] {
                assert!(track.at(time).scale() > 0.0, "{pair:?} at {time}");
            }
        }
        let [first, last] = track.span();
        for time in [first - 1.0, last + 1.0] {
            assert!(track.at(time).scale() > 0.0, "outside, at {time}");
        }
    }
}
