//! A picture of any shape.
#![no_main]

use libfuzzer_sys::fuzz_target;
use lobe_image::{PictureReadOptions, read_picture_bytes};

/// Small enough that no input takes long, large enough that every path is reached.
const MAX_TEXELS: usize = 1 << 13;

fuzz_target!(|bytes: &[u8]| {
    let options = PictureReadOptions::default().max_texels(MAX_TEXELS);
    match read_picture_bytes(bytes, "fuzz", &options) {
        Ok((picture, _)) => {
            assert!(picture.pixels().as_flattened().iter().all(|c| c.is_finite()), "a pixel is not finite");
        }
        Err(error) => {
            let line = error.to_string();
            assert!(line.starts_with("fuzz: ") && !line.contains('\n'), "{line:?}");
        }
    }
});
