//! Suns that are taken out or kept, and cubes of photographs.

use serde_json::Value;

use crate::harness::Dir;
use crate::maps::read_any;

#[test]
fn several_lamps_are_taken_out_and_what_is_in_the_way_of_more_is_said() {
    let dir = Dir::new();
    // Two lamps of one texel, six degrees apart, in a map of texels of 1.4 degrees.
    dir.map("lamps.exr", 256, 128, |x, y| if y == 60 && (x == 100 || x == 104) { [9e3; 3] } else { [0.1; 3] });
    let args = "env sun lamps.exr -o rest.exr --count 3 --light lamps.sh.json --json";
    let (stdout, notes) = dir.lobe(args).succeeds();
    let found: Value = serde_json::from_str(&stdout).unwrap();
    assert_eq!(found["suns"].as_array().unwrap().len(), 2, "{found}");
    assert!(notes.contains("2 of 3 suns were found: the brightest place"), "{notes}");
    let brightest = read_any(&dir, "rest.exr").texels().iter().map(|texel| texel.r).fold(0.0, f32::max);
    assert!(brightest < 0.2, "the rest has {brightest}");
    dir.lobe("sh info lamps.sh.json").succeeds();
}

#[test]
fn a_sun_that_half_floats_cannot_hold_is_written_as_floats_by_default_and_its_loss_is_told_otherwise() {
    let dir = Dir::new();
    dir.map("sun.pfm", 64, 32, |x, y| if x == 20 && y == 10 { [1e7; 3] } else { [0.5; 3] });
    let mean = read_any(&dir, "sun.pfm").mean().r;
    for name in ["a.ktx2", "a.dds"] {
        let (_, notes) = dir.lobe(&format!("env convert sun.pfm -o {name} --size 32")).succeeds();
        assert!(notes.contains("written as RGBA32F: RGBA16F loses") && notes.contains("--texels rgba16f"), "{notes}");
        let kept = read_any(&dir, name).mean().r / mean;
        assert!((kept - 1.0).abs() < 0.01, "{name} keeps {kept}");
        for texels in ["rgba16f", "rgb9e5", "r11g11b10f", "bc6h"] {
            let (_, notes) = dir.lobe(&format!("env convert sun.pfm -o {name} --size 32 --texels {texels}")).succeeds();
            let told = notes.contains("% of the light; --texels rgba32f holds all, and lobe env sun takes a sun out");
            assert!(told && notes.contains("which loses 9"), "{texels}: {notes}");
        }
    }
    let (_, notes) = dir.lobe("env convert sun.pfm -o half.exr --half").succeeds();
    assert!(notes.contains("% of the light; without --half it holds all"), "{notes}");
    let (_, notes) = dir.lobe("env convert sun.pfm -o a.ktx --size 32").succeeds();
    assert!(notes.contains("% of the light; .ktx2 with --texels rgba32f holds all"), "{notes}");
}

#[test]
fn cubes_of_photographs_are_read_in_the_order_that_is_told_and_the_assumption_is_noted() {
    let dir = Dir::new();
    // A row of six faces, each of another gray, and the same in numbered files.
    let gray = |face: usize| [1.0 + face as f32; 3];
    dir.map("row.pfm", 24, 4, |x, _| gray(x / 4));
    for face in 0..6 {
        dir.map(&format!("face_{face:04}.pfm"), 4, 4, |_, _| gray(face));
    }
    for input in ["row.pfm", "face_%.pfm"] {
        let (_, notes) = dir.lobe(&format!("env convert {input} -o plain.pfm --to lat-long --size 16")).succeeds();
        assert!(notes.contains("right-handed") && notes.contains("--from-left-handed"), "{input}: {notes}");
        let args =
            format!("env convert {input} --faces front,right,back,left,up,down -o told.pfm --to lat-long --size 16");
        let (_, notes) = dir.lobe(&args).succeeds();
        assert!(!notes.contains("right-handed"), "{input}: {notes}");
        let map = read_any(&dir, "told.pfm");
        // The front is in the middle, and the right on its right.
        let at = |x: usize, y: usize| map.texel(x, y).g;
        let found = [at(16, 8), at(24, 8), at(0, 8), at(8, 8), at(16, 0), at(16, 15)];
        for (face, light) in found.into_iter().enumerate() {
            // Rows near the equator are balanced to keep the light of the whole.
            assert!((light - 1.0 - face as f32).abs() < 0.01, "{input}: face {face} has {light}");
        }
    }
    let line = dir.lobe("env convert row.pfm --faces front,right,back,left,up,up -o x.pfm").error();
    assert!(line.contains("up twice"), "{line}");
}

#[test]
fn a_sun_casts_its_shadow_by_rays_whether_it_is_found_or_given() {
    let dir = Dir::new();
    let (printed, _) = dir.lobe("env sun bundled:sunset -o rest.exr --json").succeeds();
    dir.file("suns.json", printed);
    dir.lobe("bake built-in:ball -o ball.glb --order 3 --samples 16 --no-split --parts direct,reflected").succeeds();
    let render = |env: &str, suns: &str, name: &str| {
        let args = format!("render baked ball.glb --env {env} --size 32x24 --background none -o {name}.exr {suns}");
        dir.lobe(&args).succeeds().1
    };
    let note = render("bundled:sunset", "", "found");
    assert!(note.contains("a sun of ") && note.contains("--suns none leaves it with the rest"), "{note}");
    render("rest.exr", "--suns suns.json", "given");
    render("bundled:sunset", "--suns none", "smeared");
    let apart = |a: &str, b: &str| -> f64 {
        let args = format!("compare {a}.exr {b}.exr --json");
        let found: Value = serde_json::from_str(&dir.lobe(&args).arg("--quiet").stdout()).unwrap();
        found["rmse"].as_f64().unwrap()
    };
    // The rest has been written in half precision.
    assert!(apart("found", "given") < 1e-3 * apart("found", "smeared"), "{}", apart("found", "given"));
    let note = render("bundled:sunset", "--suns suns.json", "twice");
    assert!(note.contains("has a sun of its own beside those of --suns"), "{note}");
    let note = render("bundled:sunset", "--suns 3", "three");
    assert!(note.contains("1 of 3 suns were found"), "{note}");
    let error = dir.lobe("render baked ball.glb --env bundled:sunset --suns no.json -o x.exr").error();
    assert!(error.contains("--suns") && error.contains("no.json"), "{error}");
}
