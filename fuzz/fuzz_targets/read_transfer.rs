//! Transfer in every form that a file holds: vectors, compressed, lobes, matrices, matrices at points of a grid,
//! neighborhoods, light maps.
#![no_main]

use libfuzzer_sys::fuzz_target;
use lobe_fuzz::refused_in_one_line;
use lobe_prt::{read_any_transfer_bytes, read_lightmap_bytes, read_matrices_bytes, read_neighborhood_bytes};
use lobe_sh::Rgb;

fuzz_target!(|bytes: &[u8]| {
    if let Ok((transfer, _)) = read_any_transfer_bytes(bytes, "fuzz") {
        let light = vec![Rgb::new(1.0, 1.0, 1.0); transfer.order() * transfer.order()];
        assert_eq!(transfer.exit_radiance(&light).len(), transfer.receivers(), "every receiver can be lit");
    }
    refused_in_one_line(read_any_transfer_bytes(bytes, "fuzz"));
    refused_in_one_line(read_matrices_bytes(bytes, "fuzz"));
    refused_in_one_line(read_neighborhood_bytes(bytes, "fuzz"));
    refused_in_one_line(read_lightmap_bytes(bytes, "fuzz"));
});
