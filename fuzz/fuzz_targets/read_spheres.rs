//! Sphere sets.
#![no_main]

use libfuzzer_sys::fuzz_target;
use lobe_fuzz::refused_in_one_line;
use lobe_shadow::read_spheres_bytes;

fuzz_target!(|bytes: &[u8]| {
    refused_in_one_line(read_spheres_bytes(bytes, "fuzz"));
});
