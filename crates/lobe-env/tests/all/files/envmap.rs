//! OpenEXR's attribute `envmap`.

use std::f64::consts::PI;
use std::io::Cursor;

use exr::meta::attribute::EnvironmentMap;
use exr::prelude::{Image, SpecificChannels, Vec2, WritableImage};
use lobe_env::{CubeHandedness, FileFormat, FisheyeOptions, LoadedMap, MapReadOptions, lat_long, read_map_bytes};
use lobe_image::{PictureReadOptions, read_picture_bytes};
use lobe_sh::{Dir, Rgb};
use lobe_testkit::directions;

/// A file of `width` x `height` with the attribute.
fn exr_with_envmap(
    (width, height): (usize, usize),
    kind: EnvironmentMap,
    texel: impl Fn(usize, usize) -> [f32; 3] + Sync,
) -> Vec<u8> {
    let channels = SpecificChannels::rgb(|Vec2(x, y): Vec2<usize>| {
        let [r, g, b] = texel(x, y);
        (r, g, b)
    });
    let mut image = Image::from_channels((width, height), channels);
    image.layer_data.attributes.environment_map = Some(kind);
    let mut bytes = Cursor::new(Vec::new());
    image.write().to_buffered(&mut bytes).unwrap();
    bytes.into_inner()
}

/// The y-up direction of texel `(x, y)` of face `f`, from OpenEXR's own function (`CubeMap::direction`): first where
/// the texel is in the coordinates that `pixelPosition` maps to the picture, then the direction of those.
fn openexr_direction(f: usize, x: usize, y: usize, size: usize) -> [f64; 3] {
    let last = (size - 1) as f64;
    let (x, y) = (x as f64, y as f64);
    let (a, b) = match f {
        0 => (last - y, x),
        1 => (last - y, last - x),
        3 => (x, y),
        4 => (last - x, last - y),
        _ => (x, last - y),
    };
    let (a, b) = (2.0 * a / last - 1.0, 2.0 * b / last - 1.0);
    match f {
        0 => [1.0, a, b],
        1 => [-1.0, a, b],
        2 => [a, 1.0, b],
        3 => [a, -1.0, b],
        4 => [a, b, 1.0],
        _ => [a, b, -1.0],
    }
}

/// The y-up direction of texel `(x, y)` of a lat-long picture, from OpenEXR's own function (`LatLongMap::direction`).
fn openexr_lat_long_direction(x: usize, y: usize, (width, height): (usize, usize)) -> [f64; 3] {
    let latitude = -PI * (y as f64 / (height - 1) as f64 - 0.5);
    let longitude = -2.0 * PI * (x as f64 / (width - 1) as f64 - 0.5);
    [longitude.sin() * latitude.cos(), latitude.sin(), longitude.cos() * latitude.cos()]
}

fn cube_exr(size: usize) -> Vec<u8> {
    exr_with_envmap((size, 6 * size), EnvironmentMap::Cube, |x, y| {
        openexr_direction(y / size, x, y % size, size).map(|c| c as f32 + 2.0)
    })
}

#[test]
fn cube_faces_look_where_openexr_says() {
    for size in [2, 7, 16] {
        let bytes = cube_exr(size);
        let (loaded, report) = read_map_bytes(&bytes, "test", &MapReadOptions::default()).unwrap();
        assert!(matches!(loaded, LoadedMap::Chain(_)), "the file says that it is a cube");
        let report = report.picture;
        assert_eq!((report.format, report.width, report.height), (FileFormat::OpenExr, size, size), "report");
        assert!(report.notes.iter().any(|n| n.contains("envmap")), "{:?}", report.notes);
        let map = loaded.into_base().into_cube_map().unwrap();
        for face in 0..6 {
            for (x, y) in [(0, 0), (size - 1, 0), (0, size - 1), (size / 2, size / 3)] {
                // Each texel holds the point of the cube that it looks at, in OpenEXR's y-up axes.
                let [px, py, pz] = map.texel(face, x, y).to_array().map(|c| f64::from(c) - 2.0);
                let found = Dir::new([pz, px, py]).unwrap();
                let error =
                    found.to_array().into_iter().zip(map.dir(face, x, y).to_array()).map(|(a, b)| (a - b).abs());
                let error = error.fold(0.0, f64::max);
                assert!(
                    error < 2e-6,
                    "face {face} of {size} at ({x}, {y}): {found:?} against {:?}",
                    map.dir(face, x, y)
                );
            }
        }
        let (picture, _) = read_picture_bytes(&bytes, "test", &PictureReadOptions::default()).unwrap();
        assert_eq!((picture.width(), picture.height()), (size, 6 * size), "as it is");
    }
}

#[test]
fn a_lat_long_map_with_the_attribute_has_its_outer_texels_on_the_edges() {
    let (w, h) = (64, 32);
    let bytes = exr_with_envmap((w, h), EnvironmentMap::LatitudeLongitude, |x, y| {
        let s = lat_long::dir_from_uv(x as f64 / (w - 1) as f64, y as f64 / (h - 1) as f64);
        s.to_array().map(|c| c as f32 + 2.0)
    });
    let (map, report) = read_map_bytes(&bytes, "test", &MapReadOptions::default()).unwrap();
    let (map, notes) = (map.into_base().into_env_map().unwrap(), report.picture.notes);
    assert!(notes.iter().any(|n| n.contains("on the edges")), "{notes:?}");
    for y in 0..h {
        for x in 0..w {
            let texel = map.texel(x, y) - Rgb::new(2.0, 2.0, 2.0);
            let dir = map.dir(x, y).to_array();
            let error = (0..3).map(|i| (f64::from(texel.to_array()[i]) - dir[i]).abs()).fold(0.0, f64::max);
            // A chord of two texels of 0.1 rad lies up to 0.1²/8 below the arc, in each direction.
            assert!(error < 3e-3, "({x}, {y}): {texel:?} against {dir:?}");
        }
    }
    // Half a texel would be an error of 0.05.
}

#[test]
fn both_encodings_show_one_sky_alike() {
    // A sky that tells its directions, by OpenEXR's names.
    let sky = |d: [f64; 3]| Dir::new(d).unwrap().to_array().map(|c| c as f32 + 2.0);
    let (picture, size) = ((256, 128), 64);
    let flat = exr_with_envmap(picture, EnvironmentMap::LatitudeLongitude, |x, y| {
        sky(openexr_lat_long_direction(x, y, picture))
    });
    let cube = |sign: f64| {
        exr_with_envmap((size, 6 * size), EnvironmentMap::Cube, |x, y| {
            let [x, y, z] = openexr_direction(y / size, x, y % size, size);
            sky([sign * x, y, z])
        })
    };
    let right = MapReadOptions::default();
    let left = MapReadOptions::default().handedness(CubeHandedness::Left);
    let files = [("lat-long", flat, &right), ("cube", cube(1.0), &right), ("left-handed cube", cube(-1.0), &left)];
    for (name, bytes, options) in files {
        let map = read_map_bytes(&bytes, "test", options).unwrap().0.into_base();
        for v in directions() {
            // The middle of the lat-long picture, OpenEXR's +z, is Lobe's +x; OpenEXR's +x, left of it, is +y.
            let s = Dir::new(v).unwrap();
            let expected = [s.y(), s.z(), s.x()];
            let found = map.radiance(s).to_array();
            let error = (0..3).map(|i| (f64::from(found[i]) - 2.0 - expected[i]).abs()).fold(0.0, f64::max);
            // Half a texel of the lat-long picture is 0.012; a quarter turn is an error of 1.
            assert!(error < 0.02, "{name} towards {s:?}: {found:?} against {expected:?}");
        }
    }
}

#[test]
fn an_environment_is_no_fisheye_picture() {
    let bytes = exr_with_envmap((16, 8), EnvironmentMap::LatitudeLongitude, |_, _| [1.0; 3]);
    let options = MapReadOptions::default().fisheye(FisheyeOptions::default());
    let error = read_map_bytes(&bytes, "test", &options).map(|_| ()).unwrap_err().to_string();
    let expected = "test is a map by its attribute envmap; leave MapReadOptions::fisheye at its default";
    assert_eq!(error, expected, "the attribute says what it is");
}

#[test]
fn a_map_of_another_shape_than_the_attribute_says_is_an_error() {
    let shapes = [(EnvironmentMap::Cube, [(4, 23), (6, 42), (24, 4), (16, 8)], "six times as high")];
    let lat_long = (EnvironmentMap::LatitudeLongitude, [(4, 24), (6, 6), (24, 4), (16, 12)], "twice as wide");
    for (kind, sizes, part) in shapes.into_iter().chain([lat_long]) {
        for size in sizes {
            let bytes = exr_with_envmap(size, kind, |_, _| [1.0; 3]);
            let error = read_map_bytes(&bytes, "test", &MapReadOptions::default()).unwrap_err().to_string();
            assert!(error.contains(part) && error.contains("envmap"), "{size:?}: {error}");
        }
    }
}
