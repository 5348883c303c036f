//! Sphere sets and hierarchies over them.
#![no_main]

use libfuzzer_sys::fuzz_target;
use lobe_shadow::{ShadowError, read_sphere_hierarchy_bytes, read_spheres_bytes};

fn check<T>(result: Result<T, ShadowError>) {
    if let Err(error) = result {
        let line = error.to_string();
        assert!(line.starts_with("fuzz: ") && !line.contains('\n'), "{line:?}");
    }
}

fuzz_target!(|bytes: &[u8]| {
    check(read_spheres_bytes(bytes, "fuzz"));
    check(read_sphere_hierarchy_bytes(bytes, "fuzz"));
});
