//! A picture of any shape.
#![no_main]

use libfuzzer_sys::fuzz_target;
use lobe_image::read_picture_bytes;
use lobe_env::MapReadOptions;

/// Small enough that no input takes long, large enough that every path is reached.
const MAX_TEXELS: usize = 1 << 20;

fuzz_target!(|bytes: &[u8]| {
    let options = PictureReadOptions::default().max_texels(MAX_TEXELS);
    match read_picture_bytes(bytes, "fuzz", &options) {
        Ok((raster, _)) => {
            assert_eq!(raster.texels.len(), raster.width * raster.height, "texels of the picture");
            assert!(
                raster.texels.iter().all(|t| t.to_array().into_iter().all(f32::is_finite)),
                "a texel is not finite"
            );
        }
        Err(error) => {
            let line = error.to_string();
            assert!(line.starts_with("fuzz: ") && !line.contains('\n'), "{line:?}");
        }
    }
});
