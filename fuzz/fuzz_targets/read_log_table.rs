//! Tables of the logarithms of spheres.
#![no_main]

use libfuzzer_sys::fuzz_target;
use lobe_shadow::{ShadowError, read_log_table_bytes};

fn check<T>(result: Result<T, ShadowError>) {
    if let Err(error) = result {
        let line = error.to_string();
        assert!(line.starts_with("fuzz: ") && !line.contains('\n'), "{line:?}");
    }
}

fuzz_target!(|bytes: &[u8]| {
    check(read_log_table_bytes(bytes, "fuzz"));
});
