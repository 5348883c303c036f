//! A lat-long map or a cube map in any format, whichever the bytes say.
#![no_main]

use libfuzzer_sys::fuzz_target;
use lobe_env::{EnvFile, MapReadOptions, read_env_file_bytes};
use lobe_sh::Rgb;

/// Small enough that no input takes long, large enough that every path is reached.
const MAX_TEXELS: usize = 1 << 20;

fn assert_finite(texels: &[Rgb<f32>]) {
    assert!(texels.iter().all(|t| t.to_array().into_iter().all(f32::is_finite)), "a texel is not finite");
}

fuzz_target!(|bytes: &[u8]| {
    let options = MapReadOptions::default().max_texels(MAX_TEXELS);
    match read_env_file_bytes(bytes, "fuzz", &options) {
        Ok((EnvFile::LatLong(map), report)) => {
            assert_eq!((map.width(), map.height()), (report.width, report.height), "size in the report");
            assert_finite(map.texels());
        }
        Ok((EnvFile::Cube(chain), report)) => {
            assert_eq!((chain.base().size(), chain.levels().len()), (report.width, report.levels), "the report");
            chain.levels().iter().for_each(|level| assert_finite(level.texels()));
        }
        Err(error) => {
            let line = error.to_string();
            assert!(line.starts_with("fuzz: ") && !line.contains('\n'), "{line:?}");
        }
    }
});
