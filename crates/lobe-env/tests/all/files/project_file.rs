//! A map file that is projected while it is decoded.

use std::fs;
use std::path::Path;

use lobe_env::{
    CubeHandedness, CubeMap, CubeMipChain, CubeWriteOptions, EnvMap, FisheyeOptions, MapReadOptions, MappedMap,
    Mapping, Nonfinite, project_map, project_map_file, read_map, write_cube, write_env,
};
use lobe_image::PictureWriteOptions;
use lobe_sh::Rgb;
use lobe_testkit::Random;

/// Asserts that the projection and the report are those of the map, or the error is.
fn assert_alike(path: &Path, options: &MapReadOptions, what: &str) -> Result<(), String> {
    let mut last = Ok(());
    for order in [0, 1, 3, 16, 17] {
        let whole = read_map(path, options).map(|(map, report)| (project_map(map.base(), order), report));
        let by_rows = project_map_file(path, order, options);
        match (by_rows, whole) {
            (Ok(by_rows), Ok(whole)) => {
                assert!(by_rows == whole, "{what}, order {order}: {:?}, {:?}", by_rows.1, whole.1);
            }
            (Err(by_rows), Err(whole)) => {
                assert_eq!(by_rows.to_string(), whole.to_string(), "{what}, order {order}");
                last = Err(whole.to_string());
            }
            (by_rows, whole) => {
                panic!("{what}, order {order}: by rows {:?}, whole {:?}", by_rows.is_ok(), whole.is_ok())
            }
        }
    }
    last
}

fn random_map(width: usize, height: usize) -> EnvMap {
    let mut random = Random::new(5);
    let texels = (0..width * height).map(|_| Rgb::from([(); 3].map(|()| random.unit() as f32))).collect();
    EnvMap::new(width, height, texels).unwrap()
}

#[test]
fn a_file_by_rows_has_the_projection_and_the_report_of_its_map() {
    let folder = tempfile::tempdir().unwrap();
    let defaults = MapReadOptions::default();
    for (width, height) in [(64, 32), (301, 150), (400, 200)] {
        let map = random_map(width, height);
        for name in ["a.hdr", "a.exr", "a.pfm"] {
            let path = folder.path().join(name);
            write_env(&path, &map, &PictureWriteOptions::default()).unwrap();
            // A portable float map does not say what it is; its proportions do.
            let options =
                if width == 2 * height { defaults.clone() } else { defaults.clone().mapping(Mapping::LatLong) };
            assert_alike(&path, &options, name).unwrap_or_else(|e| panic!("{e}"));
            assert_alike(&path, &defaults, name).ok();
            let as_cube = defaults.clone().mapping(Mapping::Cube);
            assert!(assert_alike(&path, &as_cube, name).is_err(), "{name} is no cube");
            let left = defaults.clone().handedness(CubeHandedness::Left);
            assert!(assert_alike(&path, &left, name).is_err(), "{name} has no hands");
            let cropped = defaults.clone().elevations([-0.5, 0.5]).mapping(Mapping::LatLong);
            assert_alike(&path, &cropped, name).ok();
            if width == 64 {
                let fisheye = defaults.clone().fisheye(FisheyeOptions::default());
                assert_alike(&path, &fisheye, name).unwrap_or_else(|e| panic!("{e}"));
            }
            let bytes = fs::read(&path).unwrap();
            fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
            assert!(assert_alike(&path, &defaults, name).is_err(), "{name}, the half of it");
        }
    }
}

#[test]
fn other_maps_are_read_whole() {
    let folder = tempfile::tempdir().unwrap();
    let defaults = MapReadOptions::default();
    let probe = MappedMap::from_fn(Mapping::Angular, 40, 40, |s| Rgb::new(1.0, 2.0, 1.5 + s.z() as f32));
    for name in ["a.exr", "a.hdr"] {
        let path = folder.path().join(name);
        write_env(&path, &probe, &PictureWriteOptions::default()).unwrap();
        assert_alike(&path, &defaults, name).unwrap();
        // Taken for what it is not, which is noted.
        assert_alike(&path, &defaults.clone().mapping(Mapping::LatLong), name).unwrap();
    }
    let cube = CubeMipChain::averaged(CubeMap::from_fn(8, |s| Rgb::new(1.0, 2.0, 1.5 + s.z() as f32)));
    for name in ["a.ktx2", "a.dds"] {
        let path = folder.path().join(name);
        write_cube(&path, &cube, &CubeWriteOptions::default()).unwrap();
        assert_alike(&path, &defaults, name).unwrap();
    }
    assert_alike(Path::new("bundled:sunset"), &defaults, "bundled").unwrap();
    assert!(assert_alike(&folder.path().join("none.exr"), &defaults, "missing").is_err(), "missing");
    assert!(assert_alike(folder.path(), &defaults, "folder").is_err(), "folder");
}

#[test]
fn numbers_that_are_none_are_refused_or_black() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.pfm");
    write_env(&path, &random_map(32, 16), &PictureWriteOptions::default()).unwrap();
    let mut bytes = fs::read(&path).unwrap();
    let last = bytes.len() - 4;
    bytes[last..].copy_from_slice(&f32::NAN.to_le_bytes());
    fs::write(&path, bytes).unwrap();
    assert!(assert_alike(&path, &MapReadOptions::default(), "refused").is_err(), "refused");
    assert_alike(&path, &MapReadOptions::default().nonfinite(Nonfinite::Zero), "black").unwrap();
}
