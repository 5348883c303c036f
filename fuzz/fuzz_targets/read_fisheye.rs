//! Photographs by fisheyes. The first line says by which lens, in words: the projection, `edge` or another padding, the field of view,
//! the axis, and column, row and radius of the circle; what is missing has its default. The rest is a picture of any format.
#![no_main]

use std::f64::consts::PI;

use libfuzzer_sys::fuzz_target;
use lobe_env::{EnvError, FisheyeOptions, FisheyeProjection, MapReadOptions, Nonfinite, Padding, read_map_bytes};
use lobe_fuzz::let_decoders_panic;
use lobe_image::{ImageError, read_picture_bytes};
use lobe_sh::Dir;

/// Small enough that no input takes long, large enough that every path is reached.
const MAX_TEXELS: usize = 1 << 9;

/// How far from white the map of a white picture may be: the rounding of sums along rays, and of the weights that turn it.
const ROUNDING: f32 = 1e-5;

/// The lens of a line. Numbers may be any, and words that are none are NaN; an axis that is no direction is the default.
fn lens_of(line: &str) -> (FisheyeOptions, Padding) {
    let mut words = line.split(' ');
    let mut next = || words.next().unwrap_or_default();
    let projection = FisheyeProjection::from_name(next()).unwrap_or_default();
    let padding = if next() == "edge" { Padding::Edge } else { Padding::Black };
    let numbers: Vec<f64> = words.map(|word| word.parse().unwrap_or(f64::NAN)).collect();
    let three = |first: usize| numbers.get(first..first + 3).map(|n| [n[0], n[1], n[2]]);
    let lens = FisheyeOptions::default()
        .projection(projection)
        .field_of_view(numbers.first().copied().unwrap_or(PI))
        .axis(three(1).and_then(Dir::new).unwrap_or(Dir::Z))
        .circle(three(4));
    (lens, padding)
}

/// Whether a picture of this size can be by this lens, as the documentation of its options says.
fn can_be(lens: &FisheyeOptions, [width, height]: [usize; 2]) -> bool {
    let is_inside = |at: f64, size: usize| at > 0.0 && at < size as f64;
    let is_circle = lens
        .circle
        .is_none_or(|[x, y, radius]| is_inside(x, width) && is_inside(y, height) && radius > 0.0 && radius.is_finite());
    is_circle && lens.projection.check_field_of_view(lens.field_of_view).is_ok()
}

/// A white picture whose edge goes on all around is a white map, is refused as too large, or there is no such lens.
fn check_white([width, height]: [usize; 2], lens: &FisheyeOptions, options: &MapReadOptions) {
    let header = format!("Pf\n{width} {height}\n-1\n").into_bytes();
    let white = [header, 1_f32.to_le_bytes().repeat(width * height)].concat();
    let is_lens = can_be(lens, [width, height]);
    match read_map_bytes(&white, "fuzz", &options.clone().padding(Padding::Edge)) {
        Ok((map, _)) => {
            assert!(is_lens, "accepted: {lens:?}");
            for texel in map.base().texels() {
                assert!(texel.to_array().into_iter().all(|c| (c - 1.0).abs() < ROUNDING), "{texel:?} of {lens:?}");
            }
        }
        Err(EnvError::Image(ImageError::Refused { .. })) => assert!(is_lens, "refused as too large: {lens:?}"),
        Err(error) => assert!(!is_lens, "{error}: {lens:?}"),
    }
}

fuzz_target!(init: let_decoders_panic(), |bytes: &[u8]| {
    let mut parts = bytes.splitn(2, |byte| *byte == b'\n');
    let mut next = || parts.next().unwrap_or_default();
    let (line, picture) = (next(), next());
    let (lens, padding) = lens_of(&String::from_utf8_lossy(line));
    let options =
        MapReadOptions::default().max_texels(MAX_TEXELS).nonfinite(Nonfinite::Zero).fisheye(lens).padding(padding);
    let photograph = read_picture_bytes(picture, "fuzz", &options.picture);
    match read_map_bytes(picture, "fuzz", &options) {
        Ok((map, report)) => {
            let (photograph, _) = photograph.as_ref().expect("what becomes a map is a picture");
            let size = [photograph.width(), photograph.height()];
            assert!(can_be(&lens, size), "accepted: {lens:?}");
            assert_eq!([report.picture.width, report.picture.height], size, "the report");
            let map = map.into_base().into_env_map().expect("the map is lat-long");
            let (width, height) = (map.width(), map.height());
            assert!(width == 2 * height && height.is_multiple_of(2), "a horizon between rows: {width} x {height}");
            assert!(width * height <= MAX_TEXELS, "within the limit: {width} x {height}");
            let is_finite = map.texels().iter().all(|texel| texel.to_array().into_iter().all(f32::is_finite));
            assert!(is_finite, "a texel is not finite");
        }
        Err(error) => {
            let line = error.to_string();
            assert!(line.starts_with("fuzz") && !line.contains('\n'), "{line:?}");
        }
    }
    if let Ok((photograph, _)) = photograph {
        check_white([photograph.width(), photograph.height()], &lens, &options);
    }
});
