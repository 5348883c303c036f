//! Tables of the logarithms of spheres.
#![no_main]

use libfuzzer_sys::fuzz_target;
use lobe_fuzz::refused_in_one_line;
use lobe_shadow::read_log_table_bytes;

fuzz_target!(|bytes: &[u8]| {
    refused_in_one_line(read_log_table_bytes(bytes, "fuzz"));
});
