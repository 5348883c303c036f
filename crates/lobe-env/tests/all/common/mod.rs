//! Helpers of several test files.

use std::path::PathBuf;

use lobe_env::{EnvMap, bundled};

/// The bundled maps and, where the folder of larger inputs lies beside the repository, those too, with their names.
pub(crate) fn real_maps() -> Vec<(String, EnvMap)> {
    let mut maps: Vec<_> = bundled::all().iter().map(|b| (b.name.to_owned(), b.map())).collect();
    for path in shared_maps() {
        let map = EnvMap::load(&path).unwrap_or_else(|e| panic!("{e}"));
        maps.push((path.display().to_string(), map));
    }
    maps.sort_by_key(|(_, map)| map.width());
    maps
}

/// The .hdr and .exr files of `../shared/assets`, if there is such a folder.
pub(crate) fn shared_maps() -> Vec<PathBuf> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared/assets");
    let Ok(entries) = std::fs::read_dir(&folder) else {
        lobe_testkit::skipped(&format!("{} is absent, only the bundled maps are tested", folder.display()));
        return Vec::new();
    };
    let is_map = |path: &PathBuf| path.extension().is_some_and(|e| e == "hdr" || e == "exr");
    let mut paths: Vec<_> = entries.map(|entry| entry.unwrap().path()).filter(is_map).collect();
    paths.sort();
    assert!(!paths.is_empty(), "{} has no maps", folder.display());
    paths
}
