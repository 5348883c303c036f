//! The program without a window.

use std::path::Path;
use std::process::{Command, Output};

use lobe::io::Job;
use lobe::prt::{
    BakeOptions, Channels, CompressOptions, CompressedTransfer, Receivers, Recipe, WeightBits, ZonalTransfer, bake,
    bake_matrices, write_compressed_transfer, write_matrices, write_transfer, write_zonal_transfer,
};
use lobe::scene::{Bvh, built_in};

pub(crate) fn viewer(folder: &Path, arguments: &str) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lobe-viewer"));
    command.current_dir(folder).args(arguments.split_whitespace()).env("LOBE_VIEWER_FOLDER", folder);
    command.output().unwrap()
}

/// What a failure says: one line, and exit code 2.
fn error(folder: &Path, arguments: &str) -> String {
    let output = viewer(folder, arguments);
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{arguments}: {said}");
    assert_eq!(said.lines().count(), 1, "{arguments}: {said}");
    said
}

/// Whether this machine has no graphics adapter, told once.
pub(crate) fn is_without_adapter(output: &Output) -> bool {
    let is_without = String::from_utf8_lossy(&output.stderr).contains("no graphics adapter");
    if is_without {
        lobe_testkit::skipped("pictures of lobe-viewer: no graphics adapter");
    }
    is_without
}

#[test]
fn variables_that_name_no_instructions_and_no_number_of_threads_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    for (name, value) in [("LOBE_SIMD", "plains"), ("LOBE_HUGE_PAGES", "none"), ("RAYON_NUM_THREADS", "100000")] {
        let mut command = Command::new(env!("CARGO_BIN_EXE_lobe-viewer"));
        let output = command.current_dir(folder.path()).arg("--bench").env(name, value).output().unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{name}={value}: {said}");
        assert!(said.starts_with(&format!("lobe-viewer: {name}: expected ")), "{name}={value}: {said}");
        assert_eq!(said.lines().count(), 1, "{name}={value}: {said}");
    }
}

#[test]
fn bad_input_is_one_line_and_exit_code_2() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    std::fs::write(at.join("bad.glb"), b"nonsense").unwrap();
    std::fs::write(at.join("bad.safetensors"), b"nonsense").unwrap();
    std::fs::write(at.join("three.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 3 2\n").unwrap();
    std::fs::write(at.join("wide.pfm"), [b"PF\n2 1\n-1.0\n".as_slice(), &[0; 24]].concat()).unwrap();
    for (arguments, word) in [
        ("--headless none.glb -o a.png", "none.glb"),
        ("--headless bad.glb -o a.png", "bad.glb"),
        ("--headless built-in:teapot -o a.png", "built-in:ball"),
        ("--headless built-in:ball --env made:midnight -o a.png", "made:evening"),
        ("--headless built-in:ball", "--output"),
        ("--headless built-in:ball --order 9 -o a.png", "--order"),
        ("--headless built-in:ball --size 0x4 -o a.png", "0x4"),
        ("--headless built-in:ball --mode shiny -o a.png", "shiny"),
        ("--headless built-in:ball --background sky -o a.png", "expected env, light, none"),
        ("--headless built-in:ball --mode glossy --order 8 --max-memory 0.01 -o a.png", "transfer matrices"),
        ("--headless built-in:ball --mode glossy --lobe cone:1 -o a.png", "cone:1"),
        ("--headless built-in:ball --mode specular --roughness 1.5 -o a.png", "1.5"),
        ("--headless built-in:ball --mode specular --transfer bad.safetensors -o a.png", "--transfer bad.safetensors"),
        (
            "--headless built-in:ball --mode irradiance --transfer bad.safetensors -o a.png",
            "--transfer bad.safetensors",
        ),
        ("--headless built-in:three-objects --mode fields --transfer bad.safetensors -o a.png", "--transfer"),
        ("--headless built-in:ball --lobe ggx:0.2 -o a.png", "--lobe: only with --mode glossy"),
        ("--headless built-in:ball --roughness 0.2 -o a.png", "--roughness: only with --mode specular"),
        (
            "--headless built-in:ball --surfaces gltf --mode irradiance -o a.png",
            "--surfaces gltf: only with --mode shadowed",
        ),
        ("--headless built-in:ball --surfaces shiny -o a.png", "shiny"),
        ("--transfer bad.safetensors", "--headless"),
        ("--headless built-in:ball --transfer three.obj -o a.png", "three.obj: expected transfer"),
        ("--headless built-in:ball --transfer wide.pfm -o a.png", "wide.pfm: expected transfer"),
        ("--headless built-in:ball --transfer none.safetensors -o a.png", "none.safetensors"),
        ("--headless built-in:ball --transfer bad.safetensors -o a.png", "bad.safetensors"),
        ("--headless three.obj --max-triangles 1 -o a.png", "start with a higher --max-triangles"),
        ("--headless three.obj --max-memory 1e-9 -o a.png", "start with a higher --max-memory"),
        ("--headless built-in:ball --env wide.pfm --max-texels 1 -o a.png", "start with a higher --max-texels"),
        ("--headless three.obj --max-memory 0 -o a.png", "--max-memory"),
        ("--headless built-in:ball --mode fields --order 9 -o a.png", "--order"),
        ("--headless built-in:ball --mode fields -o a.png", "built-in:three-objects"),
        ("--bench --mode fields", "--mode fields"),
        ("--json", "--bench"),
        ("--nonsense", "--nonsense"),
    ] {
        let said = error(at, arguments);
        assert!(said.contains(word), "{arguments}: {said}");
    }
}

#[test]
fn a_picture_is_not_written_over_what_it_is_made_of() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let sky = lobe::image::Picture::filled(8, 4, [0.5; 3]);
    sky.write_png(at.join("sky.png"), &lobe::image::Tone::PLAIN).unwrap();
    std::fs::create_dir(at.join("other")).unwrap();
    let before = std::fs::read(at.join("sky.png")).unwrap();
    for name in ["sky.png", "./sky.png", "other/../sky.png"] {
        let said = error(at, &format!("--headless built-in:ball --env sky.png --mode irradiance -o {name}"));
        assert!(said.contains(&format!("-o: {name} is an input, which would be lost")), "{said}");
        let said = error(at, &format!("--headless built-in:ball --transfer sky.png --mode shadowed -o {name}"));
        assert!(said.contains("is an input"), "{said}");
    }
    assert_eq!(std::fs::read(at.join("sky.png")).unwrap(), before, "the sky is as it was");
    // Of several pictures the names are numbered.
    std::fs::write(at.join("sky.0002.pfm"), &before).unwrap();
    let options = "--headless built-in:ball --env sky.0002.pfm --mode irradiance --frames 3 --size 8x6";
    let said = error(at, &format!("{options} -o sky.pfm"));
    assert!(said.contains("-o: sky.0002.pfm is an input, which would be lost"), "{said}");
}

#[test]
fn a_scene_is_rendered_to_a_file_in_every_mode() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    for mode in ["irradiance", "shadowed", "interreflected", "difference", "glossy", "specular"] {
        let small = "--order 2 --samples 4 --size 32x20 --rays 1 --software";
        let output =
            viewer(at, &format!("--headless built-in:ball --env made:even --mode {mode} {small} -o {mode}.exr"));
        if is_without_adapter(&output) {
            return;
        }
        assert!(output.status.success(), "{mode}: {}", String::from_utf8_lossy(&output.stderr));
        let (picture, _) = lobe::image::read_picture(at.join(format!("{mode}.exr")), &Default::default()).unwrap();
        assert_eq!((picture.width(), picture.height()), (32, 20), "{mode}");
        let mean = picture.mean().iter().sum::<f64>();
        assert!(mean.is_finite() && mean > 0.0, "{mode}: {mean}");
    }
}

#[test]
fn a_picture_has_the_background_that_is_asked_for_and_before_nothing_an_alpha() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let small = "--headless built-in:ball --env made:even --mode irradiance --size 32x20 --software";
    let mut pictures = Vec::new();
    for background in ["env", "light", "none", "0.5,2,0.25"] {
        let output = viewer(at, &format!("{small} --background {background} -o a.exr"));
        if is_without_adapter(&output) {
            return;
        }
        assert!(output.status.success(), "{background}: {}", String::from_utf8_lossy(&output.stderr));
        let bytes = std::fs::read(at.join("a.exr")).unwrap();
        pictures.push(lobe::image::ExrLayers::from_bytes(&bytes, "a.exr").unwrap());
    }
    let channel = |picture: usize, name: &str| pictures[picture].get(name).map(<[f32]>::to_vec);
    let alpha = channel(2, "A").expect("an alpha before nothing");
    assert!(alpha[0] == 0.0 && alpha.contains(&1.0), "{alpha:?}: nothing in the corner, and the ball");
    assert_eq!([0, 1, 3].map(|picture| channel(picture, "A")), [None, None, None], "no other alpha");
    for (name, color) in [("R", 0.5), ("G", 2.0), ("B", 0.25)] {
        let [env, light, none, colored] = [0, 1, 2, 3].map(|picture| channel(picture, name).unwrap());
        for (i, alpha) in alpha.iter().enumerate() {
            let behind = 1.0 - alpha;
            let off = [env[i] - none[i] - behind, light[i] - none[i] - behind, colored[i] - none[i] - behind * color];
            assert!(off.iter().all(|off| off.abs() < 2e-3), "{name} of pixel {i} behind {alpha}: off by {off:?}");
        }
    }
}

/// Pictures of a ball by what the program bakes on its way, and by files of the same bakes.
#[test]
#[ignore = "long: of the nightly group"]
fn transfer_of_a_file_shows_what_its_bake_would() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let scene = built_in::named("ball").unwrap();
    let bvh = Bvh::new(&scene);
    let receivers = Receivers::at_vertices(&scene).unwrap();
    let options = BakeOptions::default().order(3).samples(16).bounces(3);
    let (transfer, report) = bake(&scene, &bvh, &receivers, &options, Job::default()).unwrap();
    let recipe = Recipe::of_bake(&scene, &options, &report);
    write_transfer(at.join("vectors.safetensors"), &transfer, &recipe, Job::default()).unwrap();
    // As many clusters and components as there may be: nothing is lost but digits.
    let most = CompressOptions::default().clusters(2).components(27).weights(WeightBits::F32);
    let (compressed, _) = CompressedTransfer::new(&transfer, &most, Job::default()).unwrap();
    write_compressed_transfer(at.join("clusters.safetensors"), &compressed, &recipe).unwrap();
    // In memory 132 bytes a vertex while they are read, and 768 as vectors of colors.
    let vertices = scene.vertex_count();
    let lobes = ZonalTransfer::new(8, Channels::Gray, 1, vec![[0.0, 0.0, 1.0]; vertices], vec![0.1; 8 * vertices]);
    let lobes = lobes.unwrap();
    let limit = format!("{:.9}", 400.0 * vertices as f64 / f64::from(1 << 30));
    write_zonal_transfer(at.join("lobes.safetensors"), &lobes, &recipe).unwrap();
    let (matrices, _) = bake_matrices(&scene, &bvh, &receivers, &options, Job::default()).unwrap();
    write_matrices(at.join("matrices.safetensors"), &matrices, &recipe, Job::default()).unwrap();
    let small = "--headless built-in:ball --env made:evening --size 48x32 --rays 1 --software";
    let picture = |arguments: &str| {
        let output = viewer(at, &format!("{small} {arguments} -o a.exr"));
        if is_without_adapter(&output) {
            return None;
        }
        assert!(output.status.success(), "{arguments}: {}", String::from_utf8_lossy(&output.stderr));
        Some(lobe::image::read_picture(at.join("a.exr"), &Default::default()).unwrap().0)
    };
    let Some(baked) = picture("--order 3 --samples 16") else { return };
    let vectors = picture("--transfer vectors.safetensors").unwrap();
    assert_eq!(vectors.pixels(), baked.pixels(), "vectors of a file, of the order of the file");
    let clusters = picture("--transfer clusters.safetensors").unwrap();
    let apart = apart(&clusters, &baked);
    // Sums of 27 terms in another basis, by single precision.
    assert!(apart > 0.0 && apart < 1e-4, "clusters: {apart} of the brightest");
    let glossy = picture("--mode glossy --order 3 --samples 16").unwrap();
    let of_file = picture("--mode glossy --transfer matrices.safetensors").unwrap();
    assert_eq!(of_file.pixels(), glossy.pixels(), "matrices of a file");
    let sharp = picture("--mode glossy --transfer matrices.safetensors --lobe phong:40").unwrap();
    assert_ne!(sharp.pixels(), glossy.pixels(), "another lobe");
    for (arguments, word) in [
        ("--transfer matrices.safetensors -o a.exr", "--mode glossy"),
        ("--transfer vectors.safetensors --mode glossy -o a.exr", "diffuses light"),
        ("--transfer vectors.safetensors --mode shadowed -o a.exr", "ask for --mode interreflected"),
        ("--transfer vectors.safetensors --order 4 -o a.exr", "baked to order 3"),
        (&format!("--transfer lobes.safetensors --max-memory {limit} -o a.exr"), "lobes.safetensors: takes up to"),
    ] {
        let said = error(at, &format!("{small} {arguments}"));
        assert!(said.contains(word), "{arguments}: {said}");
    }
    let said = error(at, "--headless built-in:columns --transfer vectors.safetensors -o a.exr");
    assert!(said.contains("vertices"), "of another scene: {said}");
}

#[test]
#[ignore = "long: of the nightly group"]
fn microfacets_turn_with_their_sky_and_blur_it_by_their_roughness() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let small = "--headless built-in:ball --mode specular --size 48x32 --rays 1 --software";
    let output = viewer(at, &format!("{small} --frames 2 -o turned.exr"));
    if is_without_adapter(&output) {
        return;
    }
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let read = |name: &str| lobe::image::read_picture(at.join(name), &Default::default()).unwrap().0;
    let [first, turned] = ["turned.0000.exr", "turned.0001.exr"].map(read);
    // Of the ball, which is in the middle of the picture and 7 pixels high: what differs from its mean.
    let contrast = |picture: &lobe::image::Picture| {
        let ball: Vec<f32> = (13..18).flat_map(|y| (22..27).map(move |x| picture.pixels()[48 * y + x][1])).collect();
        let mean = ball.iter().sum::<f32>() / ball.len() as f32;
        (ball.iter().map(|g| (g / mean - 1.0).powi(2)).sum::<f32>() / ball.len() as f32).sqrt()
    };
    let [smooth, rough, under_even] = ["--roughness 0.1", "--roughness 0.8", "--env made:even"].map(|of| {
        assert!(viewer(at, &format!("{small} {of} -o of.exr")).status.success(), "{of}");
        contrast(&read("of.exr"))
    });
    assert!(smooth > 1.5 * rough && rough > 10.0 * under_even, "{smooth}, {rough}, {under_even}");
    let apart = apart(&turned, &first);
    assert!(apart > 0.05, "the sky turned half around: {apart} of the brightest");
}

/// The largest difference of two pictures, over the brightest of the second.
fn apart(a: &lobe::image::Picture, b: &lobe::image::Picture) -> f32 {
    let most = b.pixels().iter().flatten().fold(0.0_f32, |most, c| most.max(*c));
    let pairs = a.pixels().iter().flatten().zip(b.pixels().iter().flatten());
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max) / most
}

#[test]
fn a_measurement_is_a_table_or_json() {
    let folder = tempfile::tempdir().unwrap();
    let small = "--bench --scene built-in:furnace --order 2 --samples 4 --size 32x20 --receivers 500 --software";
    let table = viewer(folder.path(), small);
    if is_without_adapter(&table) {
        return;
    }
    let text = String::from_utf8(table.stdout).unwrap();
    assert!(text.contains("surfaces") && text.contains("frames a second"), "{text}");
    assert!(text.contains("exponentials of 128 spheres at 500 receivers, order 2"), "{text}");
    assert!(text.contains("floor of all passes"), "{text}");
    let json = viewer(folder.path(), &format!("{small} --json")).stdout;
    let value: serde_json::Value = serde_json::from_slice(&json).unwrap();
    assert!(value["frames_per_second"].as_f64().is_some_and(|rate| rate > 0.0), "{value}");
    assert_eq!(value["size"], serde_json::json!([32, 20]), "{value}");
    let copied = value["copied_bytes_per_second"].as_f64().unwrap();
    let all = value["passes"].as_array().unwrap().iter().chain([&value["exponentials"]]);
    for pass in all {
        let (bytes, floor) = (pass["bytes"].as_f64().unwrap(), pass["floor_ms"].as_f64().unwrap());
        assert!((floor - 1e3 * bytes / copied).abs() <= 1e-9 * floor, "{pass}: bytes over the speed of a copy");
    }
    assert!(value["exponentials"]["ms"].as_f64().is_some_and(|ms| ms > 0.0), "{value}");
}

#[test]
fn what_moves_is_rendered_moment_by_moment_in_both_ways_and_numbers_may_be_halved() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let wedge = "v 0.5 0 -0.3\nv -0.3 0.4 -0.3\nv -0.3 -0.4 -0.3\nv 0 0 0.5\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
    std::fs::write(at.join("wedge.obj"), wedge).unwrap();
    std::fs::write(at.join("ground.obj"), "v -2 0 2\nv 2 0 2\nv 2 0 -2\nv -2 0 -2\nf 1 2 3\nf 1 3 4\n").unwrap();
    let falls = r#"{"format": "lobe-scene", "version": 1, "still": ["ground.obj"], "entities": [{"name": "falling",
        "mesh": "wedge.obj", "keys": [{"time": 0, "translation": [0, 0, 2]}, {"time": 2, "translation": [0, 0, 1]}]}]}"#;
    std::fs::write(at.join("falls.json"), falls).unwrap();
    let small = "--order 2 --size 40x24 --rays 1 --env made:even --software";
    let read = |name: &str| lobe::image::read_picture(at.join(name), &Default::default()).unwrap().0;
    for mode in ["fields", "exponentials"] {
        let arguments = format!("--headless falls.json --mode {mode} --spheres 4 --frames 2 {small} -o {mode}.exr");
        let output = viewer(at, &arguments);
        if is_without_adapter(&output) {
            return;
        }
        assert!(output.status.success(), "{mode}: {}", String::from_utf8_lossy(&output.stderr));
        let [first, second] = ["0000", "0001"].map(|number| read(&format!("{mode}.{number}.exr")));
        assert_ne!(first.pixels(), second.pixels(), "{mode}: it moves");
    }
    assert_ne!(read("fields.0000.exr").pixels(), read("exponentials.0000.exr").pixels(), "two ways");
    for storage in ["f32", "f16"] {
        let arguments = format!("--headless built-in:ball --samples 4 --storage {storage} {small} -o {storage}.exr");
        assert!(viewer(at, &arguments).status.success(), "{storage}");
    }
    let [whole, half] = ["f32.exr", "f16.exr"].map(read);
    let apart = apart(&half, &whole);
    // Half of eleven bits for each number; the sums of a few are as far apart.
    assert!(apart > 0.0 && apart < 2e-3, "{apart} of the brightest");
    let said = error(at, "--headless built-in:ball --part wedge.safetensors -o a.png");
    assert!(said.contains("--part wedge.safetensors"), "{said}");
}
