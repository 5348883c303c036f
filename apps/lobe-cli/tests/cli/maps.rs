//! `lobe env convert`, `rotate`, `adjust`, `sun`, `prefilter` and `show`: maps in, maps out.

use lobe::env::{
    CubeHandedness, CubeMap, CubeMipChain, CubeWriteOptions, EnvMap, MapReadOptions, MappedMap, Mapping, TexelFormat,
    project_map, read_map, write_cube,
};
use lobe::image::{PictureReadOptions, read_picture};
use lobe::sh::sh_json::FileCoefficients;
use lobe::sh::{Expansion as _, Rgb, ShVec};
use serde_json::Value;

use crate::harness::Dir;

/// A sky whose colors tell the six directions apart, brightest upwards.
fn write_sky(dir: &Dir, name: &str) {
    dir.map(name, 64, 32, |x, y| {
        let (phi, theta) =
            ((0.5 - (x as f32 + 0.5) / 64.0) * std::f32::consts::TAU, (y as f32 + 0.5) / 32.0 * std::f32::consts::PI);
        let s = [theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos()];
        [2.0 + s[0], 2.0 + s[1], 2.0 + s[2]]
    });
}

pub(crate) fn read_any(dir: &Dir, name: &str) -> MappedMap {
    MappedMap::load(dir.path(name)).unwrap()
}

/// The largest difference of a coefficient, relative to the mean.
fn difference(a: &ShVec<Rgb<f64>>, b: &ShVec<Rgb<f64>>) -> f64 {
    let d = a - b;
    let largest = d.coefficients().iter().flat_map(|c| c.to_array()).fold(0.0, |m: f64, c| m.max(c.abs()));
    largest / b[0].g
}

#[test]
fn every_mapping_can_be_written_and_read_again() {
    let dir = Dir::new();
    write_sky(&dir, "sky.exr");
    let before = project_map(&read_any(&dir, "sky.exr"), 4);
    for mapping in Mapping::ALL {
        dir.lobe(
            &format!("env convert sky.exr --to {mapping} -o there.exr --layout row")
                .replace(" --layout row", if mapping == Mapping::Cube { " --layout row" } else { "" }),
        )
        .stdout();
        dir.lobe(&format!("project there.exr --from {mapping} --order 4 -o there.sh.json")).stdout();
        let FileCoefficients::Rgb(after) = dir.read_sh("there.sh.json").coefficients else { panic!("{mapping}: gray") };
        let error = difference(&after, &before);
        assert!(error < 2e-3, "{mapping}: {error}");
        dir.lobe(&format!("env convert there.exr --from {mapping} --to lat-long --size 32 -o back.exr")).stdout();
        let error = difference(&project_map(&read_any(&dir, "back.exr"), 4), &before);
        assert!(error < 5e-3, "{mapping} and back: {error}");
    }
}

#[test]
fn cubes_are_textures_crosses_and_six_files() {
    let dir = Dir::new();
    write_sky(&dir, "sky.exr");
    dir.lobe("env convert sky.exr -o cube.ktx2 --size 16 --texels rgba32f").stdout();
    let cube = read_any(&dir, "cube.ktx2");
    assert_eq!((cube.mapping(), cube.width()), (Mapping::Cube, 16), "texture");
    dir.lobe("env convert cube.ktx2 -o faces/%.exr --size 16").succeeds();
    assert_eq!(dir.path("faces").read_dir().unwrap().count(), 6, "six files");
    dir.lobe("env convert faces/%.exr -o again.ktx2 --size 16 --texels rgba32f").stdout();
    assert_eq!(read_any(&dir, "again.ktx2"), cube, "through six files");
    for (layout, shape) in
        [("horizontal-cross", (64, 48)), ("vertical-cross", (48, 64)), ("row", (96, 16)), ("column", (16, 96))]
    {
        dir.lobe(&format!("env convert cube.ktx2 --to cube --layout {layout} --left-handed -o cross.exr")).succeeds();
        let (picture, _) = read_picture(dir.path("cross.exr"), &PictureReadOptions::default()).unwrap();
        assert_eq!((picture.width(), picture.height()), shape, "{layout}");
        let (_, note) = dir.lobe("env convert cross.exr --from-left-handed -o back.dds --texels rgba32f").succeeds();
        assert!(note.contains("read as the six faces of a cube"), "{layout}: {note}");
        assert_eq!(read_any(&dir, "back.dds"), cube, "through {layout}");
    }
    dir.lobe("env convert sky.exr -o mips.ktx2 --size 16 --mips --zstd").stdout();
    let info: Value = serde_json::from_str(&dir.lobe("env info mips.ktx2 --json").succeeds().0).unwrap();
    assert_eq!(info["mapping"], "cube", "{info}");
}

/// Writes a cube of left-handed faces, and says what it is in Lobe's own.
fn write_left_handed(dir: &Dir, name: &str) -> CubeMipChain {
    let cube = CubeMap::from_fn(8, |s| Rgb::new(2.0 + s.x() as f32, 2.0 + s.y() as f32, 2.0 + s.z() as f32));
    let chain = CubeMipChain::averaged(cube);
    let options = CubeWriteOptions::default().texels(TexelFormat::Rgba32F);
    write_cube(dir.path(name), &chain.clone().of_handedness(CubeHandedness::Left), &options).unwrap();
    chain
}

#[test]
fn pictures_of_a_left_handed_cube_say_so() {
    let dir = Dir::new();
    let cube = CubeMap::from_fn(8, |s| Rgb::new(2.0 + s.x() as f32, 2.0 + s.y() as f32, 2.0 + s.z() as f32));
    write_cube(
        dir.path("sky.ktx2"),
        &CubeMipChain::single(cube.clone()),
        &CubeWriteOptions::default().texels(TexelFormat::Rgba32F),
    )
    .unwrap();
    for (output, is_exact) in [("cross.exr", true), ("%.exr", true), ("cross.png", false), ("row.hdr", false)] {
        dir.lobe(&format!("env convert sky.ktx2 --to cube --left-handed -o {output}")).succeeds();
        let (_, notes) = dir.lobe(&format!("env convert {output} --texels rgba32f -o back.ktx2")).succeeds();
        assert!(notes.contains("left-handed, as the file says"), "{output}: {notes}");
        assert!(!is_exact || read_any(&dir, "back.ktx2") == cube.clone().into(), "{output} is turned around again");
    }
    let (_, notes) = dir.lobe("env convert cross.exr --from octahedral --to lat-long -o o.exr").succeeds();
    assert!(!notes.contains("left-handed"), "no cube: {notes}");
}

#[test]
fn textures_are_read_and_written_for_either_hand() {
    let dir = Dir::new();
    for name in ["left.ktx2", "left.dds"] {
        let cube = write_left_handed(&dir, name).into_base();
        dir.lobe(&format!("env convert {name} --from-left-handed --to cube --layout row -o row.exr")).succeeds();
        let (row, _) = read_picture(dir.path("row.exr"), &PictureReadOptions::default()).unwrap();
        assert_eq!(CubeMap::from_picture(&row, CubeHandedness::Right).unwrap(), cube, "{name} read");
        for back in ["back.ktx2", "back.dds"] {
            dir.lobe(&format!("env convert row.exr --left-handed --texels rgba32f -o {back}")).succeeds();
            // A .ktx2 says what its faces are.
            let expected = if back == "back.ktx2" { cube.clone().into() } else { read_any(&dir, name) };
            assert_eq!(read_any(&dir, back), expected, "{name} to {back}");
        }
    }
}

fn read_chain(dir: &Dir, name: &str) -> CubeMipChain {
    read_map(dir.path(name), &MapReadOptions::default()).unwrap().0.into_chain().unwrap()
}

#[test]
fn levels_go_along_or_are_said_to_be_left_out() {
    let dir = Dir::new();
    write_sky(&dir, "sky.exr");
    dir.lobe("env prefilter sky.exr -o chain.ktx2 --size 16 --last-size 4 --texels rgba32f").stdout();
    let chain = read_chain(&dir, "chain.ktx2");
    assert_eq!(chain.levels().len(), 3, "16, 8 and 4");
    for args in ["-o same.dds", "-o same.ktx2 --zstd", "-o same.ktx2 --size 16 --to cube"] {
        let (_, notes) = dir.lobe(&format!("env convert chain.ktx2 --texels rgba32f {args}")).succeeds();
        assert!(!notes.contains("left out"), "{args}: {notes}");
        let name = args.split(' ').nth(1).unwrap();
        assert_eq!(read_chain(&dir, name), chain, "{args}");
    }
    for args in [
        "convert chain.ktx2 -o other.ktx2 --size 8",
        "convert chain.ktx2 -o other.ktx2 --mips",
        "convert chain.ktx2 -o other.exr --to lat-long",
        "rotate chain.ktx2 --axis 0,0,1 --angle 90 -o other.ktx2",
        "adjust chain.ktx2 --exposure 1 -o other.ktx2",
    ] {
        let (_, notes) = dir.lobe(&format!("env {args}")).succeeds();
        assert!(notes.contains("chain.ktx2: the 2 smaller levels are left out"), "{args}: {notes}");
    }
    let (info, notes) = dir.lobe("env info chain.ktx2 --json").succeeds();
    let info: Value = serde_json::from_str(&info).unwrap();
    assert_eq!((&info["levels"], &info["format"]), (&Value::from(3), &Value::from("KTX2")), "{info}");
    assert!(!notes.contains("left out"), "nothing is left out of facts: {notes}");
}

#[test]
fn a_folder_is_made_when_there_is_something_to_put_into_it() {
    let dir = Dir::new();
    dir.lobe("env convert none.exr -o made/here/%.exr").error();
    assert_eq!(dir.names(), [""; 0], "no folder for a map that is not there");
    write_sky(&dir, "sky.exr");
    let line = dir.lobe("env convert sky.exr -o sky.exr/%.exr --size 4").error();
    assert!(line.contains("sky.exr"), "{line}");
    dir.lobe("env convert sky.exr -o made/here/%.exr --size 4").stdout();
    assert_eq!(dir.path("made/here").read_dir().unwrap().count(), 6, "six files");
    let (_, stderr) = dir.lobe("env convert sky.exr -o look_%.png --size 4").succeeds();
    assert!(stderr.contains("note: look_%.png: tone-mapped for looking at"), "{stderr}");
}

#[test]
fn light_beyond_all_numbers_is_refused() {
    let dir = Dir::new();
    dir.map("one.exr", 8, 4, |_, _| [1.0; 3]);
    for args in ["--exposure 200", "--scale 1e300,1,1", "--scale 1,1e39,1 --clamp 5"] {
        let line = dir.lobe(&format!("env adjust one.exr -o bright.exr {args}")).error();
        assert!(line.contains("32 texels would be brighter than 3.4028235e38"), "{args}: {line}");
    }
    assert_eq!(dir.names(), ["one.exr"], "nothing is written");
}

#[test]
fn the_sun_of_a_cube_is_that_of_its_picture() {
    let dir = Dir::new();
    let sun = |args: &str| -> Value {
        serde_json::from_str(&dir.lobe(&format!("env sun {args} --json")).succeeds().0).unwrap()
    };
    let picture = sun("bundled:sunset -o rest.exr");
    dir.lobe("env convert bundled:sunset -o cube.ktx2 --size 256 --texels rgba32f").succeeds();
    let cube = sun("cube.ktx2 -o rest.ktx2 --texels rgba32f");
    let red = picture["irradiance"][0].as_f64().unwrap();
    for c in 0..3 {
        let [a, b] = [&picture, &cube].map(|sun| sun["irradiance"][c].as_f64().unwrap());
        // On the way to the cube interpolation takes an eighth of its light, nearly all of it red, out of the disc.
        assert!((a - b).abs() < 0.15 * red, "channel {c}: {a} in the picture, {b} in the cube");
    }
    let (before, after) = (read_any(&dir, "cube.ktx2"), read_any(&dir, "rest.ktx2"));
    let changed = before.texels().iter().zip(after.texels()).filter(|(a, b)| a != b).count();
    assert_eq!(Value::from(changed), cube["texels"], "all but the sun's texels are as they were");
}

#[test]
fn bc6h_is_written_by_every_program() {
    let dir = Dir::new();
    write_sky(&dir, "sky.exr");
    dir.lobe("env convert sky.exr -o sky.ktx2 --size 32 --texels bc6h").stdout();
    let (texture, sky) = (read_any(&dir, "sky.ktx2"), read_any(&dir, "sky.exr"));
    assert!((texture.mean().g / sky.mean().g - 1.0).abs() < 0.02, "{:?}, was {:?}", texture.mean(), sky.mean());
}

#[test]
fn a_map_is_turned_like_its_expansion() {
    let dir = Dir::new();
    write_sky(&dir, "sky.exr");
    dir.lobe("env rotate sky.exr --axis 0,0,1 --angle 90 -o turned.exr").stdout();
    let (before, after) = (read_any(&dir, "sky.exr"), read_any(&dir, "turned.exr"));
    // From +x to +y: a quarter of the picture to the left.
    assert_eq!(after.texel(16, 5), before.texel(32, 5), "a quarter turn moves columns and changes nothing");
    dir.lobe("project sky.exr --order 3 -o p.sh.json").stdout();
    dir.lobe("sh rotate p.sh.json --axis 1,2,3 --angle 40 -o q.sh.json").stdout();
    dir.lobe("env rotate sky.exr --axis 1,2,3 --angle 40 -o oblique.exr").stdout();
    let FileCoefficients::Rgb(expected) = dir.read_sh("q.sh.json").coefficients else { panic!("gray") };
    let error = difference(&project_map(&read_any(&dir, "oblique.exr"), 3), &expected);
    assert!(error < 5e-3, "{error}");
}

#[test]
fn clamping_says_what_it_takes() {
    let dir = Dir::new();
    dir.map("sun.exr", 8, 4, |x, y| if (x, y) == (3, 1) { [100.0, 50.0, 0.0] } else { [1.0; 3] });
    let report = dir.lobe("env adjust sun.exr --exposure 1 --clamp 20 -o dim.exr --json").stdout();
    let report: Value = serde_json::from_str(&report).unwrap();
    let clamped = &report["clamped"];
    assert_eq!((clamped["texels"].as_u64(), clamped["largest"].as_f64()), (Some(1), Some(200.0)), "{report}");
    assert!(report["blackened"].is_null(), "nobody asked for that: {report}");
    let map = EnvMap::load(dir.path("dim.exr")).unwrap();
    assert_eq!(map.texel(3, 1), Rgb::new(20.0, 10.0, 0.0), "the hue stays");
    assert_eq!(map.texel(0, 0), Rgb::new(2.0, 2.0, 2.0), "one stop");
    let line = dir.lobe("env adjust sun.exr -o dim.exr").error();
    assert!(line.starts_with("nothing to adjust"), "{line}");
}

#[test]
fn negative_texels_can_be_made_black_and_the_note_about_them_says_how() {
    let dir = Dir::new();
    dir.map("rings.exr", 8, 4, |x, y| if (x, y) == (3, 1) { [-2.0, 5.0, -0.5] } else { [1.0; 3] });
    let (stdout, stderr) = dir.lobe("env adjust rings.exr --non-negative -o clean.exr").succeeds();
    assert!(stdout.starts_with("blackened  1 texels, the lowest channel was -2.0"), "{stdout}");
    assert!(stderr.contains("lobe env adjust --non-negative"), "{stderr}");
    let map = EnvMap::load(dir.path("clean.exr")).unwrap();
    assert_eq!(map.texel(3, 1), Rgb::new(0.0, 5.0, 0.0), "the channel that is not negative stays");
    let (_, stderr) = dir.lobe("env info clean.exr").succeeds();
    assert_eq!(stderr, "", "no note any more");
    let line = dir.lobe("env adjust rings.exr --exposure 1 --json -o clean.exr").error();
    assert!(line.starts_with("--json: only with --non-negative or --clamp"), "{line}");
}

#[test]
fn what_halves_cannot_hold_is_said_with_what_to_leave_out() {
    let dir = Dir::new();
    dir.map("bright.exr", 8, 4, |_, _| [1e5; 3]);
    let (_, stderr) = dir.lobe("env convert bright.exr -o half.exr --to lat-long --half").succeeds();
    assert!(stderr.contains("32 texels are outside") && stderr.contains("without --half it holds all"), "{stderr}");
}

#[test]
fn the_sun_leaves_its_light_and_the_sky() {
    let dir = Dir::new();
    let args = "env sun bundled:sunset -o rest.exr --json";
    let (stdout, _) = dir.lobe(args).succeeds();
    let sun: Value = serde_json::from_str(&stdout).unwrap();
    assert!(sun["diameter"].as_f64().unwrap() < 3.0 && sun["direction"][2].as_f64().unwrap() > 0.0, "{sun}");
    let rest = read_any(&dir, "rest.exr");
    let whole = MappedMap::from(lobe::env::bundled::sunset().map());
    let removed = 4.0 * std::f64::consts::PI * (whole.mean().r - rest.mean().r);
    let found = sun["irradiance"][0].as_f64().unwrap();
    assert!((removed / found - 1.0).abs() < 1e-4, "{removed} against {found}");
    dir.map("gray.exr", 16, 8, |_, _| [1.0; 3]);
    let output = dir.lobe("env sun gray.exr -o none.exr").output();
    assert_eq!(output.status.code(), Some(1), "no sun is an answer, not an error");
    let line = String::from_utf8(output.stderr).unwrap();
    assert!(line.contains("gray.exr: nothing in it is as small and bright as a sun: the brightest place"), "{line}");
    assert!(line.contains("1.000 times as bright as the mean"), "{line}");
    assert!(!dir.names().contains(&"none.exr".to_owned()), "nothing is written");
    // No file is another answer.
    dir.lobe("env sun missing.exr -o none.exr").error();
}

#[test]
fn levels_of_roughness_are_written_as_pictures_too() {
    let dir = Dir::new();
    dir.map("one.exr", 32, 16, |_, _| [1.0; 3]);
    let (_, notes) = dir.lobe("env prefilter one.exr -o level_%.exr --size 16 --last-size 4").succeeds();
    assert!(notes.contains("level_1.exr: roughness 0.5000, alpha 0.2500"), "{notes}");
    for (k, rows) in [32, 16, 8].into_iter().enumerate() {
        let (picture, _) = read_picture(dir.path(&format!("level_{k}.exr")), &PictureReadOptions::default()).unwrap();
        assert_eq!((picture.width(), picture.height()), (2 * rows, rows), "level {k}");
        let error = picture.pixels().as_flattened().iter().map(|c| (c - 1.0).abs()).fold(0.0, f32::max);
        assert!(error < 1e-6, "level {k}: the white furnace is {error} off");
    }
    let line = dir.lobe("env prefilter one.exr -o level_%.png").error();
    assert!(line.contains("% as .exr, .hdr or .pfm, one for each level"), "{line}");
}

#[test]
fn what_a_panorama_shows_is_said_kept_and_found_again() {
    let dir = Dir::new();
    // A .pfm cannot keep what its picture shows.
    dir.map("cropped.pfm", 40, 8, |_, _| [1.0; 3]);
    let line = dir.lobe("env info cropped.pfm").error();
    assert!(line.contains("--from") && line.contains("--vertical-fov"), "{line}");
    let (_, notes) = dir.lobe("env info cropped.pfm --from lat-long").succeeds();
    assert!(notes.contains("40 x 8 is not 2:1"), "{notes}");
    let (info, _) = dir.lobe("env info cropped.pfm --vertical-fov -15,45 --json").succeeds();
    let info: Value = serde_json::from_str(&info).unwrap();
    assert_eq!((&info["width"], &info["height"]), (&Value::from(40), &Value::from(24)), "{info}");
    dir.lobe("env convert cropped.pfm --vertical-fov 60 --padding edge --to octahedral --size 16 -o oct.exr")
        .succeeds();
    let (info, notes) = dir.lobe("env info oct.exr --json").succeeds();
    let info: Value = serde_json::from_str(&info).unwrap();
    assert_eq!(info["mapping"], "octahedral", "{info}");
    assert!(notes.contains("as the file says"), "{notes}");
    dir.lobe("env convert oct.exr -o oct.png").succeeds();
    let (info, _) = dir.lobe("env info oct.png --json").succeeds();
    assert!(info.contains("\"octahedral\""), "{info}");
    let line = dir.lobe("env info oct.exr --from octahedral --vertical-fov 60").error();
    assert!(line.starts_with("--vertical-fov: only of a lat-long picture"), "{line}");
}

#[test]
fn a_photograph_of_the_sky_by_a_fisheye_lens_is_a_map() {
    let dir = Dir::new();
    // East of the zenith, on the left of the picture, it is bright. A picture is no map by itself.
    dir.map("sky.pfm", 60, 40, |x, _| if (12..16).contains(&x) { [9.0; 3] } else { [1.0; 3] });
    let line = dir.lobe("env info sky.pfm").error();
    assert!(line.contains("--fisheye"), "{line}");
    let (_, notes) = dir
        .lobe("env convert sky.pfm --fisheye equisolid --fisheye-circle 30,20,18 --padding edge -o sky.exr")
        .succeeds();
    assert!(notes.contains("it shows 180° around 0.000,0.000,1.000 (equisolid fisheye)"), "{notes}");
    let map = read_any(&dir, "sky.exr");
    assert_eq!(map.mapping(), Mapping::LatLong, "the map");
    let towards = |s: [f64; 3]| map.radiance(lobe::sh::Dir::new(s).unwrap()).g;
    assert!(towards([0.0, -1.0, 0.1]) > 5.0 && towards([0.0, 1.0, 0.1]) < 2.0, "-y is on the left of the sky");
    dir.lobe("project sky.pfm --fisheye equisolid:170 --fisheye-axis down -o ground.sh.json --quantity visibility")
        .succeeds();
    let file = dir.read_sh("ground.sh.json");
    assert_eq!(file.quantity, lobe::sh::expansion::Quantity::Visibility, "as it was named");
    assert!(file.coefficients.to_rgb()[2].g < 0.0, "light comes from below");
    for (options, part) in [
        ("--fisheye round", "expected one of equidistant, equisolid, stereographic, orthographic"),
        ("--fisheye orthographic:190", "at most 180°"),
        ("--fisheye equisolid --vertical-fov 60", "cannot be used with"),
        ("--fisheye equisolid --from angular", "cannot be used with"),
        ("--fisheye-circle 30,20,18", "--fisheye"),
        ("--padding edge", "--fisheye"),
        ("--fisheye equisolid --fisheye-circle 70,20,18", "has its middle in it"),
    ] {
        let line = dir.lobe(&format!("env info sky.pfm {options}")).error();
        assert!(line.contains(part), "{options}: {line}");
    }
}

#[test]
fn an_even_sky_stays_even_however_rough_the_mirror() {
    let dir = Dir::new();
    dir.map("one.exr", 32, 16, |_, _| [1.0; 3]);
    dir.lobe("env prefilter one.exr -o rough.ktx2 --size 16 --last-size 4").stdout();
    let chain = read_chain(&dir, "rough.ktx2");
    assert_eq!(chain.levels().len(), 3, "16, 8, 4");
    let mut texels = chain.levels().iter().flat_map(|level| level.texels());
    assert!(texels.all(|t| *t == Rgb::new(1.0, 1.0, 1.0)), "the white furnace");
    dir.lobe("env prefilter one.exr -o highlights.exr --lobe phong:20 --size 8").stdout();
    let (picture, _) = read_picture(dir.path("highlights.exr"), &PictureReadOptions::default()).unwrap();
    assert_eq!((picture.width(), picture.height()), (32, 24), "a cross of faces");
}

#[test]
fn all_techniques_are_drawn_on_one_sheet() {
    let dir = Dir::new();
    write_sky(&dir, "sky.exr");
    dir.lobe("env show sky.exr -o sheet.png --size 32").stdout();
    assert!(dir.bytes("sheet.png").starts_with(b"\x89PNG\r\n\x1a\n"), "no PNG");
}

#[test]
fn a_picture_keeps_its_mapping_unless_another_is_asked_for() {
    let dir = Dir::new();
    write_sky(&dir, "sky.exr");
    for (args, mapping) in [("-o a.hdr", "lat-long"), ("-o b.exr --layout row", "cube"), ("-o c.exr --to cube", "cube")]
    {
        dir.lobe(&format!("env convert sky.exr {args}")).stdout();
        let found = dir.lobe(&format!("env info --quiet {}", &args[3..8])).stdout();
        assert!(found.contains(mapping), "{args}: {found}");
    }
}

#[test]
fn a_damaged_cross_is_damaged_and_not_of_wrong_proportions() {
    let dir = Dir::new();
    write_sky(&dir, "sky.exr");
    dir.lobe("env convert sky.exr --to cube --size 64 -o cross.exr").stdout();
    let bytes = dir.bytes("cross.exr");
    dir.file("cut.exr", &bytes[..bytes.len() / 2]);
    let line = dir.lobe("env info cut.exr").error();
    assert!(line.contains("cut.exr: the file ends early"), "{line}");
}

#[test]
fn options_that_would_be_ignored_are_refused() {
    let dir = Dir::new();
    dir.map("square.pfm", 8, 8, |_, _| [1.0; 3]);
    write_sky(&dir, "sky.exr");
    for (args, part) in [
        ("convert faces/%.exr --from lat-long -o a.ktx2", "--from: faces/%.exr is a cube; leave the option out"),
        ("rotate sky.exr -o a.exr --quat 0,0,0,1 --angle 5", "cannot be used with"),
        ("prefilter sky.exr -o a.ktx2 --size 16 --mips", "--mips: the levels of the chain of --lobe ggx are its own"),
        ("convert sky.exr -o a.ktx2 --to lat-long", "-o: this kind of file holds cubes only"),
        ("convert sky.exr -o a.exr --to lat-long --layout row", "--layout: only of a cube in one picture"),
        ("convert sky.exr -o a.exr --to cube --texels rgba16f", "--texels: only of .ktx2, .dds and .ktx"),
        ("convert sky.exr -o a.exr --to octahedral --left-handed", "--left-handed: only of a cube; leave it out"),
        ("convert sky.exr -o a.ktx2 --from-left-handed", "--from-left-handed: only of a cube, but sky.exr is lat-long"),
        (
            "info bundled:studio --quiet --from-left-handed",
            "--from-left-handed: only of a cube, but bundled:studio is lat-long",
        ),
        ("info square.pfm --from octahedral --from-left-handed", "--from-left-handed: only of a cube"),
        ("convert sky.exr -o a.hdr --to lat-long --half", "--half: only of .exr; leave it out"),
        ("convert sky.exr -o a.ktx2 --half", "--half: only of .exr; leave it out"),
        ("convert sky.exr -o a.dds --zstd", "--zstd: only of .ktx2; leave it out"),
        (
            "convert sky.exr -o a.gif --to cube",
            "ends in .exr, .hdr, .pfm or .png, or for a cube in .ktx2, .ktx or .dds",
        ),
        ("convert square.pfm -o a.ktx2", "is neither lat-long (2:1) nor a cube"),
        ("convert sky.exr --from cube -o a.ktx2", "a picture of a cube is 4:3"),
        ("convert bundled:studio --from angular -o a.ktx2", "--from: bundled:studio is lat-long"),
        ("prefilter sky.exr -o a.exr", "-o: the chain of --lobe ggx is written as .ktx2, .ktx or .dds"),
        ("prefilter sky.exr -o a.ktx --texels bc6h", "--texels: a .ktx holds r11g11b10f only; leave it out"),
        ("prefilter sky.exr -o a.ktx2 --tolerance 0.5", "tolerance"),
        ("prefilter sky.exr -o a.ktx2 --lobe phong:-1", "an exponent is 0 or more"),
        ("prefilter sky.exr -o a.ktx2 --size 8 --last-size 16", "not 8 to 16"),
        ("show sky.exr -o a.exr", "expected a name that ends in .png"),
    ] {
        let line = dir.lobe(&format!("env {args}")).error();
        assert!(line.contains(part), "{args}: {line}");
    }
    assert_eq!(dir.names(), ["sky.exr", "square.pfm"], "files");
}

#[test]
fn a_map_of_other_primaries_is_converted_where_asked_and_noted_where_not() {
    let dir = Dir::new();
    // Everything is the red of ITU-R BT.2020.
    let pixels = [128, 0, 0, 129].repeat(2);
    let head =
        "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\nPRIMARIES= 0.708 0.292 0.17 0.797 0.131 0.046 0.3127 0.329\n\n-Y 1 +X 2\n";
    dir.file("wide.hdr", [head.as_bytes(), &pixels].concat());
    let mean = |options: &str| {
        let (_, said) = dir.lobe(&format!("project wide.hdr --order 1 -o p.sh.json {options}")).succeeds();
        let FileCoefficients::Rgb(f) = dir.read_sh("p.sh.json").coefficients else { panic!("expected colors") };
        (f.mean().to_array(), said)
    };
    let (kept, said) = mean("");
    assert!(said.contains("PRIMARIES of the header are not those of Rec. 709"), "{said}");
    let (converted, said) = mean("--to-rec709");
    assert!(said.contains("converted"), "{said}");
    // A column of the matrix of ITU-R BT.2087, rounded to four digits.
    for (found, expected) in kept.into_iter().chain(converted).zip([1.0, 0.0, 0.0, 1.6605, -0.1246, -0.0182]) {
        assert!((found - expected).abs() < 2e-4, "{kept:?}, {converted:?}");
    }
}
