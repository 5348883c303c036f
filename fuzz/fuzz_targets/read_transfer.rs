//! Transfer in every form that a file holds: vectors, compressed, lobes, matrices, matrices at points of a grid,
//! neighborhoods, light maps.
#![no_main]

use libfuzzer_sys::fuzz_target;
use lobe_prt::{PrtError, read_any_transfer_bytes, read_lightmap_bytes, read_matrices_bytes, read_neighborhood_bytes};
use lobe_sh::Rgb;

fn check<T>(result: Result<T, PrtError>) {
    if let Err(error) = result {
        let line = error.to_string();
        assert!(line.starts_with("fuzz: ") && !line.contains('\n'), "{line:?}");
    }
}

fuzz_target!(|bytes: &[u8]| {
    if let Ok((transfer, _)) = read_any_transfer_bytes(bytes, "fuzz") {
        let light = vec![Rgb::new(1.0, 1.0, 1.0); transfer.order() * transfer.order()];
        assert_eq!(transfer.exit_radiance(&light).len(), transfer.receivers(), "every receiver can be lit");
    }
    check(read_any_transfer_bytes(bytes, "fuzz"));
    check(read_matrices_bytes(bytes, "fuzz"));
    check(read_neighborhood_bytes(bytes, "fuzz"));
    check(read_lightmap_bytes(bytes, "fuzz"));
});
