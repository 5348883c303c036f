//! Occlusion fields, lamps and visibility of surfaces: what is read can be looked up.
#![no_main]

use libfuzzer_sys::fuzz_target;
use lobe_fuzz::refused_in_one_line;
use lobe_sh::Expansion as _;
use lobe_shadow::{RadialInterpolation, read_field_bytes, read_lamp_bytes, read_visibility_bytes};

fuzz_target!(|bytes: &[u8]| {
    if let Ok(field) = read_field_bytes(bytes, "fuzz") {
        let seen = field.visibility_at([0.3, -0.2, 0.1], RadialInterpolation::Cubic);
        assert!(seen.coefficients().iter().all(|c| !c.is_nan()), "{seen:?}");
    }
    refused_in_one_line(read_field_bytes(bytes, "fuzz"));
    refused_in_one_line(read_lamp_bytes(bytes, "fuzz"));
    refused_in_one_line(read_visibility_bytes(bytes, "fuzz"));
});
