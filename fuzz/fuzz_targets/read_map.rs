//! A map of any mapping in any format, whichever the bytes say.
#![no_main]

use libfuzzer_sys::fuzz_target;
use lobe_env::{LoadedMap, MapReadOptions, read_map_bytes};
use lobe_image::PictureReadOptions;
use lobe_sh::Rgb;

/// Small enough that no input takes long, large enough that every path is reached.
const MAX_TEXELS: usize = 1 << 13;

fn assert_finite(texels: &[Rgb<f32>]) {
    assert!(texels.iter().all(|t| t.to_array().into_iter().all(f32::is_finite)), "a texel is not finite");
}

fuzz_target!(|bytes: &[u8]| {
    let options = MapReadOptions::default().picture(PictureReadOptions::default().max_texels(MAX_TEXELS));
    match read_map_bytes(bytes, "fuzz", &options) {
        Ok((LoadedMap::Single(map), report)) => {
            assert!(report.picture.width * report.picture.height >= map.texels().len(), "size in the report");
            assert_finite(map.texels());
        }
        Ok((LoadedMap::Chain(chain), report)) => {
            let report = report.picture;
            assert_eq!((chain.base().size(), chain.levels().len()), (report.width, report.levels), "the report");
            chain.levels().iter().for_each(|level| assert_finite(level.texels()));
        }
        Err(error) => {
            let line = error.to_string();
            assert!(line.starts_with("fuzz: ") && !line.contains('\n'), "{line:?}");
        }
    }
});
