//! Traced pictures, whose variance is a layer of the file.
#![no_main]

use libfuzzer_sys::fuzz_target;
use lobe_fuzz::{let_decoders_panic, refused_in_one_line};
use lobe_render::read_traced_picture_bytes;

fuzz_target!(init: let_decoders_panic(), |bytes: &[u8]| {
    if let Ok(traced) = read_traced_picture_bytes(bytes, "fuzz") {
        let planes = [&traced.mean, &traced.variance];
        assert!(planes.iter().all(|plane| plane.pixels().as_flattened().iter().all(|c| c.is_finite())), "finite");
        assert_eq!(traced.mean.pixels().len(), traced.variance.pixels().len(), "one variance a pixel");
    }
    refused_in_one_line(read_traced_picture_bytes(bytes, "fuzz"));
});
