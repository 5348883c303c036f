//! Occlusion fields and lamps: what is read can be looked up.
#![no_main]

use libfuzzer_sys::fuzz_target;
use lobe_sh::Expansion as _;
use lobe_shadow::{RadialInterpolation, ShadowError, read_field_bytes, read_lamp_bytes};

fn check<T>(result: Result<T, ShadowError>) {
    if let Err(error) = result {
        let line = error.to_string();
        assert!(line.starts_with("fuzz: ") && !line.contains('\n'), "{line:?}");
    }
}

fuzz_target!(|bytes: &[u8]| {
    if let Ok(field) = read_field_bytes(bytes, "fuzz") {
        let seen = field.visibility_at([0.3, -0.2, 0.1], RadialInterpolation::Cubic);
        assert!(seen.coefficients().iter().all(|c| !c.is_nan()), "{seen:?}");
    }
    check(read_field_bytes(bytes, "fuzz"));
    check(read_lamp_bytes(bytes, "fuzz"));
});
