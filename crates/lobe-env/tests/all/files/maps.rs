//! The same map through every format, and what a file says of itself.

use std::fs;
use std::path::Path;

use lobe_env::{
    CubeMap, CubeMipChain, CubeWriteOptions, EnvError, EnvMap, LoadedMap, MapReadOptions, MappedMap, Mapping, Padding,
    PictureWriteOptions, TexelFormat, cube, project_env, read_map, read_map_bytes, write_cube, write_env,
};
use lobe_image::{ImageError, encode_picture};
use lobe_sh::{Coefficient as _, Expansion, Rgb, ShVec};

fn read(bytes: &[u8]) -> EnvMap {
    let (map, _) = read_map_bytes(bytes, "test", &MapReadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    map.into_base().into_env_map().unwrap()
}

#[test]
fn a_file_says_itself_whether_it_is_a_cube() {
    let chain = CubeMipChain::averaged(CubeMap::from_fn(4, |s| Rgb::new(s.x() as f32 + 2.0, 1.0, 0.5)));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.dds");
    write_cube(&path, &chain, &CubeWriteOptions::default().texels(TexelFormat::Rgba32F)).unwrap();
    let options = MapReadOptions::default();
    let (loaded, report) = read_map(&path, &options).unwrap();
    assert_eq!((&loaded, report.picture.levels), (&LoadedMap::Chain(chain.clone()), 3), "cube");
    assert_eq!(loaded.into_chain().unwrap(), chain, "with its levels");
    let bundled = lobe_env::bundled::sunset();
    let (loaded, _) = read_map_bytes(bundled.bytes, "test", &options).unwrap();
    assert_eq!(loaded, LoadedMap::Single(bundled.map().into()), "lat-long");
    let error = loaded.into_chain().unwrap_err().to_string();
    assert!(error.contains("a cube map expected"), "{error}");
    let error = read_map_bytes(&fs::read(&path).unwrap(), "test", &options.mapping(Mapping::LatLong)).unwrap_err();
    assert!(matches!(error, EnvError::Contradiction { .. }), "{error:?}");
}

#[test]
fn pictures_of_a_wrong_shape_say_the_size_found() {
    for (w, h) in [(16, 16), (8, 16), (17, 8), (1, 1)] {
        for name in ["a.exr", "a.hdr"] {
            let texels = vec![[1.0; 3]; w * h];
            let (bytes, _) = encode_picture(name.as_ref(), w, &texels, &PictureWriteOptions::default()).unwrap();
            let error = read_map_bytes(&bytes, "test", &MapReadOptions::default()).unwrap_err();
            let message = error.to_string();
            assert!(matches!(error, EnvError::UnknownMapping { .. }), "{message}");
            assert!(
                message.starts_with(&format!("test: a picture of {w} x {h}")) && message.contains("2:1"),
                "{message}"
            );
        }
    }
}

/// The largest difference of two expansions of order 6, relative to the mean of the first.
fn difference(a: &ShVec<Rgb<f64>>, b: &ShVec<Rgb<f64>>) -> f64 {
    let mean = a.coefficients()[0].to_array();
    let error = a.coefficients().iter().zip(b.coefficients()).flat_map(|(a, b)| (*a - *b).to_array());
    error.enumerate().map(|(i, e)| e.abs() / mean[i % 3]).fold(0.0, f64::max)
}

#[test]
fn a_real_map_has_the_same_harmonics_through_every_format() {
    const ORDER: usize = 6;
    // Both round to the nearest: half 2^-12 of a channel, RGBE 2^-9 of the largest in the texel, of either sign;
    // a few texels of a lamp may hold most of the light.
    const HALF: f64 = 2.5e-4;
    const RGBE: f64 = 5e-4;
    let folder = tempfile::tempdir().unwrap();
    for (name, map) in crate::common::real_maps() {
        let any = (f32::NEG_INFINITY, f32::INFINITY);
        let cases = [
            ("a.exr", false, any, 0.0),
            ("a.exr", true, (-65504.0, 65504.0), HALF),
            ("a.pfm", false, any, 0.0),
            ("a.hdr", false, (0.0, f32::INFINITY), RGBE),
        ];
        for (file, half, (low, high), tolerance) in cases {
            // Clamping is not an error of precision.
            let mut map = map.clone();
            for texel in map.texels_mut() {
                *texel = Rgb::from(texel.to_array().map(|c| c.clamp(low, high)));
            }
            let path = folder.path().join(file);
            write_env(&path, &map, &PictureWriteOptions::default().half(half)).unwrap();
            let back = EnvMap::load(&path).unwrap();
            let error = difference(&project_env(&map, ORDER), &project_env(&back, ORDER));
            println!("{name} through {file} (half {half}): {error:.2e}");
            assert!(error <= tolerance, "{name} through {file} (half {half}): {error} against {tolerance}");
        }
    }
}

#[test]
fn a_real_cube_map_has_the_same_harmonics_through_every_format() {
    const ORDER: usize = 6;
    const SIZE: usize = 32;
    // As above: a texel of RGB9E5 is off by half of 2^-9 of its largest channel at the most, of either sign.
    let formats = [(TexelFormat::Rgba32F, 0.0), (TexelFormat::Rgba16F, 2.5e-4), (TexelFormat::Rgb9e5, 5e-4)];
    let folder = tempfile::tempdir().unwrap();
    let project = |cube: &CubeMap| {
        let mut f = ShVec::zero(ORDER);
        for face in 0..6 {
            for (y, x) in (0..SIZE * SIZE).map(|i| (i / SIZE, i % SIZE)) {
                let light = cube.texel(face, x, y).widen().scale(cube::solid_angle(SIZE, x, y));
                f += &ShVec::impulse(ORDER, cube.dir(face, x, y), light);
            }
        }
        f
    };
    for (name, map) in crate::common::real_maps() {
        let faces = CubeMap::from_fn(SIZE, |s| Rgb::from(map.radiance(s).to_array().map(|c| c.clamp(0.0, 65504.0))));
        let expected = project(&faces);
        for (texels, tolerance) in formats {
            for (file, zstd) in [("a.ktx2", false), ("a.ktx2", true), ("a.dds", false)] {
                let path = folder.path().join(file);
                write_cube(
                    &path,
                    &CubeMipChain::single(faces.clone()),
                    &CubeWriteOptions::default().texels(texels).zstd(zstd),
                )
                .unwrap();
                let back = MappedMap::load(&path).unwrap().into_cube_map().unwrap();
                let error = difference(&expected, &project(&back));
                println!("{name} through {file} {texels} zstd {zstd}: {error:.2e}");
                assert!(error <= tolerance, "{name} through {file} {texels}: {error} against {tolerance}");
            }
        }
    }
}

#[test]
fn the_same_map_has_the_same_harmonics_in_zip_and_in_dwab() {
    // The ZIP files hold what a DWAB decoder made of the others, rounded to half again.
    const HALF: f64 = 2.5e-4;
    let mut pairs = Vec::new();
    for path in crate::common::shared_maps() {
        let dwab = path.to_str().unwrap().replace(".exr", "-dwab.exr");
        if dwab != path.to_str().unwrap() && Path::new(&dwab).exists() {
            pairs.push((path.display().to_string(), fs::read(&path).unwrap(), fs::read(dwab).unwrap()));
        }
    }
    let named = ["lobby", "studio", "sunset", "venice"];
    let missing: Vec<_> =
        named.iter().filter(|n| !pairs.iter().any(|(p, ..)| p.ends_with(&format!("{n}.exr")))).collect();
    assert!(pairs.is_empty() || missing.is_empty(), "the folder of larger inputs lacks {missing:?} or its DWAB");
    // In the repository: a small DWAB file and what another decoder made of it.
    let decoded = include_bytes!("../../../../lobe-image/tests/data/dwa-decoded.exr").to_vec();
    pairs.push(("dwab.exr".into(), decoded, include_bytes!("../../../../lobe-image/tests/data/dwab.exr").to_vec()));
    for (name, zip, dwab) in pairs {
        let error = difference(&project_env(&read(&zip), 6), &project_env(&read(&dwab), 6));
        println!("{name}: {error:.2e}");
        assert!(error <= HALF, "{name}: {error} against {HALF}");
    }
}

#[test]
fn real_files_are_read_with_sensible_values() {
    for (name, map) in crate::common::real_maps() {
        let mean = map.mean().luminance();
        assert!(map.width() == 2 * map.height() && (0.01..100.0).contains(&mean), "{name}: mean {mean}");
    }
}

#[test]
fn the_facts_about_the_bundled_maps_are_true() {
    let facts = [("sunset", 412856, -99.6875, 801.0), ("studio", 458128, -149.25, 3730.0)];
    for (bundled, (name, bytes, low, high)) in lobe_env::bundled::all().iter().zip(facts) {
        let channels = bundled.map().texels().iter().flat_map(|t| t.to_array()).collect::<Vec<_>>();
        let found =
            (channels.iter().copied().fold(f32::INFINITY, f32::min), channels.iter().copied().fold(0.0, f32::max));
        assert_eq!((bundled.name, bundled.bytes.len(), found), (name, bytes, (low, high)), "{name}");
    }
    let sunset = lobe_env::bundled::sunset().map();
    let brightest = (0..sunset.texels().len()).max_by(|a, b| sunset.texels()[*a].r.total_cmp(&sunset.texels()[*b].r));
    let brightest = brightest.unwrap();
    let sun = sunset.dir(brightest % sunset.width(), brightest / sunset.width());
    let (elevation, azimuth) = (90.0 - sun.theta().to_degrees(), sun.phi().to_degrees());
    assert!((elevation - 3.0).abs() < 1.0 && (azimuth + 36.0).abs() < 1.0, "the sun is at {azimuth}°, {elevation}°");
}

#[test]
fn an_unknown_extension_or_folder_is_an_error_and_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let map = EnvMap::from_fn(4, 2, |s| Rgb::new(2.0 + s.x() as f32, 1.0, 1.0));
    for name in ["a.png", "a", "hdr"] {
        let error = write_env(folder.path().join(name), &map, &PictureWriteOptions::default());
        assert!(matches!(error, Err(ImageError::Options(_))), "{name}: {error:?}");
    }
    let error = write_env(Path::new("/no/such/folder/a.exr"), &map, &PictureWriteOptions::default());
    assert!(matches!(error, Err(ImageError::Io { .. })), "{error:?}");
    fs::create_dir(folder.path().join("b.exr")).unwrap();
    let error = write_env(folder.path().join("b.exr"), &map, &PictureWriteOptions::default());
    assert!(matches!(error, Err(ImageError::Io { .. })), "{error:?}");
    let left: Vec<_> = fs::read_dir(folder.path()).unwrap().map(|f| f.unwrap().file_name()).collect();
    assert_eq!(left, ["b.exr"], "nothing but the folder made here");
}

#[test]
fn a_failed_write_keeps_the_old_file_and_a_good_one_replaces_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.hdr");
    fs::write(&path, "old").unwrap();
    let wide = EnvMap::from_fn(32768, 1, |_| Rgb::new(1.0, 1.0, 1.0));
    let error = write_env(&path, &wide, &PictureWriteOptions::default());
    assert!(matches!(&error, Err(ImageError::Options(m)) if m.contains("32767")), "{error:?}");
    assert_eq!(fs::read(&path).unwrap(), b"old", "kept");
    write_env(
        &path,
        &EnvMap::from_fn(4, 2, |s| Rgb::new(2.0 + s.x() as f32, 1.0, 1.0)),
        &PictureWriteOptions::default(),
    )
    .unwrap();
    assert!(fs::read(&path).unwrap().starts_with(b"#?RADIANCE"), "replaced");
}

/// The root of the mean squared difference of the logarithms, with a hundredth of the mean added to both.
fn difference_of_logarithms(a: &CubeMap, b: &CubeMap) -> f64 {
    let floor = 0.01 * a.mean().luminance();
    let logarithms = |map: &CubeMap| {
        let channels = map.texels().iter().flat_map(|t| t.to_array());
        channels.map(|c| (f64::from(c) + floor).ln()).collect::<Vec<_>>()
    };
    let squares = logarithms(a).into_iter().zip(logarithms(b)).map(|(a, b)| (a - b) * (a - b));
    (squares.sum::<f64>() / (3 * a.texels().len()) as f64).sqrt()
}

#[test]
fn blocks_of_a_real_sky_are_close() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.ktx2");
    // 0.0504 was found for the sunset. All channels count alike here; the encoder weighs those less that are darker than others.
    for (bundled, limit) in lobe_env::bundled::all().into_iter().zip([0.052, 0.1]) {
        let map = bundled.map();
        let cube = CubeMap::from_fn(128, |s| Rgb::from(map.radiance(s).to_array().map(|c| c.clamp(0.0, 65504.0))));
        let options = CubeWriteOptions::default().texels(TexelFormat::Bc6h);
        write_cube(&path, &CubeMipChain::single(cube.clone()), &options).unwrap();
        let back = MappedMap::load(&path).unwrap().into_cube_map().unwrap();
        let error = difference_of_logarithms(&cube, &back);
        assert!(error < limit, "{}: {error} against {limit}", bundled.name);
    }
}

#[test]
fn every_mapping_is_found_again_in_files_with_room_for_its_name() {
    let folder = tempfile::tempdir().unwrap();
    let options = MapReadOptions::default();
    for mapping in Mapping::ALL {
        let map = MappedMap::from_fn(mapping, 16, mapping.height_for(16), |s| Rgb::new(s.x() as f32 + 2.0, 1.0, 0.5));
        for name in ["a.exr", "a.hdr"] {
            let path = folder.path().join(name);
            write_env(&path, &map, &PictureWriteOptions::default()).unwrap();
            let (found, report) = read_map(&path, &options).unwrap();
            assert_eq!(found.base().mapping(), mapping, "{name}");
            let is_noted = report.told.iter().any(|remark| remark.contains("as the file says"));
            assert_eq!(is_noted, map.untold_mapping().is_some(), "{mapping}: {:?}", report.told);
            let asked = read_map(&path, &options.clone().mapping(Mapping::Octahedral)).map(|(map, _)| map.into_base());
            assert!(
                asked.is_ok_and(|map| map.mapping() == Mapping::Octahedral) || mapping == Mapping::Cube,
                "{mapping}"
            );
        }
    }
    let wide = MappedMap::from_fn(Mapping::LatLong, 16, 4, |_| Rgb::splat(1.0));
    let path = folder.path().join("wide.exr");
    write_env(&path, &wide, &PictureWriteOptions::default()).unwrap();
    assert_eq!(MappedMap::load(&path).unwrap(), wide, "a lat-long map of any proportions");
}

#[test]
fn cropped_panoramas_become_whole_maps() {
    let texels: Vec<[f32; 3]> = (0..12 * 4).map(|i| [1.0 + i as f32, 2.0, 3.0]).collect();
    let (bytes, _) = encode_picture("a.exr".as_ref(), 12, &texels, &PictureWriteOptions::default()).unwrap();
    let read = |options: &MapReadOptions| {
        read_map_bytes(&bytes, "test", options).map(|(map, report)| (map.into_base(), report.picture.notes))
    };
    let cropped = MapReadOptions::default().elevations([-30.0, 30.0].map(f64::to_radians));
    let (map, notes) = read(&cropped).unwrap();
    assert_eq!((map.mapping(), map.width(), map.height()), (Mapping::LatLong, 12, 12), "rows of 15 degrees");
    assert!(notes[0].contains("-30° to 30°"), "{notes:?}");
    let row = |map: &MappedMap, y: usize| map.row(y).iter().map(|t| t.to_array()).collect::<Vec<_>>();
    for y in 0..12 {
        let expected = if (4..8).contains(&y) { texels[12 * (y - 4)..][..12].to_vec() } else { vec![[0.0; 3]; 12] };
        assert_eq!(row(&map, y), expected, "row {y}");
    }
    let (map, _) = read(&cropped.padding(Padding::Edge)).unwrap();
    assert_eq!([row(&map, 0), row(&map, 11)], [texels[..12].to_vec(), texels[36..].to_vec()], "the rows of the edges");
    let (map, notes) = read(&MapReadOptions::default().mapping(Mapping::LatLong)).unwrap();
    assert!(map.height() == 4 && notes[0].contains("not 2:1; taken to show all elevations"), "{notes:?}");
    let error = read(&MapReadOptions::default().mapping(Mapping::Angular).elevations([-0.5, 0.5])).unwrap_err();
    assert!(error.to_string().contains("leave MapReadOptions::elevations at its default"), "{error}");
}
