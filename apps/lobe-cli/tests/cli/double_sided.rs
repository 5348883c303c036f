//! `lobe render`: surfaces seen from behind.

use lobe::image::{PictureReadOptions, read_picture};

use crate::harness::Dir;

/// From above and from below, so near that a square of side 2 fills the picture.
const ABOVE: &str = "--eye 0.1,0.2,3 --target 0,0,0 --fov 20 --size 16x12";
const BELOW: &str = "--eye 0.1,0.2,-3 --target 0,0,0 --fov 20 --size 16x12";

/// The largest difference between the means of a picture by transfer and of one by paths. 192 pixels of 256 paths,
/// whose light deviates by about itself, are known to 0.5 %, and transfer of 1024 paths to about as much: twice their
/// sum.
const TOLERANCE: f64 = 0.02;

/// A white square that faces up, and light of other colors from above and from below.
fn write_square(dir: &Dir) {
    dir.file(
        "s.obj",
        "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvn 0 0 1\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1/1 2/2/1 3/3/1 4/4/1\n",
    );
    dir.map("sky.exr", 32, 16, |_, y| if y < 8 { [1.0, 0.5, 0.2] } else { [0.1, 0.4, 0.8] });
}

/// The mean of a picture.
fn mean(dir: &Dir, name: &str) -> [f64; 3] {
    let (picture, _) = read_picture(dir.path(name), &PictureReadOptions::default()).unwrap();
    let count = picture.pixels().len() as f64;
    let mut sum = [0.0; 3];
    for texel in picture.pixels() {
        texel.iter().zip(&mut sum).for_each(|(c, sum)| *sum += f64::from(*c) / count);
    }
    sum
}

/// Renders `args` and compares its mean.
fn check(dir: &Dir, args: &str, expected: [f64; 3]) {
    dir.lobe(&format!("render {args} -o a.exr")).arg("--quiet").stdout();
    let found = mean(dir, "a.exr");
    for c in 0..3 {
        assert!((found[c] / expected[c] - 1.0).abs() < TOLERANCE, "{args}: {found:?}, not {expected:?}");
    }
}

fn truth(dir: &Dir, args: &str) -> [f64; 3] {
    dir.lobe(&format!("render trace {args} --order 4 --background light --samples 256 -o truth.exr"))
        .arg("--quiet")
        .stdout();
    mean(dir, "truth.exr")
}

#[test]
fn both_sides_of_an_open_square_show_their_own_light() {
    let dir = Dir::new();
    write_square(&dir);
    let common = "--up z --env sky.exr";
    for (view, is_redder) in [(ABOVE, true), (BELOW, false)] {
        let expected = truth(&dir, &format!("s.obj {common} {view}"));
        assert!((expected[0] > expected[2]) == is_redder, "{view}: {expected:?}");
        for mode in
            ["irradiance --order 4", "baked --mode unshadowed", "baked --mode shadowed", "baked --mode interreflected"]
        {
            check(&dir, &format!("{mode} s.obj {common} {view}"), expected);
        }
    }
}

#[test]
fn files_hold_fronts_and_the_backs_that_are_seen_are_baked_as_they_were() {
    let dir = Dir::new();
    write_square(&dir);
    let bake = |args: &str| dir.lobe(&format!("bake s.obj --up z --mode shadowed {args}")).arg("--quiet").stdout();
    bake("-o s.glb --samples 512");
    bake("-o s.safetensors --samples 512");
    bake("-o texels.exr --samples 512 --texels 8");
    let [above, below] = [ABOVE, BELOW].map(|view| truth(&dir, &format!("s.obj --up z --env sky.exr {view}")));
    for (scene, file, places) in [
        ("s.glb", "s.glb", "4 vertices"),
        ("s.obj --up z --transfer s.safetensors", "s.safetensors", "4 vertices"),
        ("s.obj --up z --transfer texels.exr", "texels.exr", "49 texels"),
    ] {
        let args = |view: &str| format!("{scene} --env sky.exr --mode shadowed {view}");
        check(&dir, &args(ABOVE), above);
        check(&dir, &args(BELOW), below);
        let (_, notes) = dir.lobe(&format!("render {} -o b.exr", args(BELOW))).succeeds();
        let expected = format!(
            "note: {file}: holds fronts of surfaces; the backs of {places}, which are seen, are baked now from 512 paths each\n"
        );
        assert_eq!(notes, expected, "{scene}");
        let (_, notes) = dir.lobe(&format!("render {} -o c.exr", args(ABOVE))).succeeds();
        assert_eq!(notes, "", "{scene}: no back is seen");
    }
}

#[test]
fn backs_in_a_file_are_those_that_a_picture_bakes_on_its_way() {
    let dir = Dir::new();
    write_square(&dir);
    let bake = |args: &str| dir.lobe(&format!("bake s.obj --up z --mode shadowed --samples 512 {args}"));
    bake("-o fronts.glb").arg("--quiet").stdout();
    bake("--backs -o both.glb").arg("--quiet").stdout();
    let render = |scene: &str, view: &str, out: &str| {
        let args = format!("render {scene} --env sky.exr --mode shadowed {view} -o {out}");
        dir.lobe(&args).succeeds().1
    };
    for view in [ABOVE, BELOW] {
        render("fronts.glb", view, "baked.exr");
        let notes = render("both.glb", view, "kept.exr");
        assert_eq!(notes, "", "{view}: nothing is baked");
        assert!(dir.bytes("baked.exr") == dir.bytes("kept.exr"), "{view}: the same picture");
    }
    let text = String::from_utf8_lossy(&dir.bytes("both.glb")).into_owned();
    assert!(text.contains("\"_TRANSFER_BACK_0\"") && text.contains("\"backs\":true"), "attributes of backs");
    assert!(!dir.names().iter().any(|name| name.contains("checkpoint")), "{:?}", dir.names());
    // Baked again, a file has the backs of that bake alone.
    dir.lobe("bake both.glb --mode shadowed --samples 512 -o again.glb").arg("--quiet").stdout();
    let text = String::from_utf8_lossy(&dir.bytes("again.glb")).into_owned();
    assert!(!text.contains("_TRANSFER_BACK_"), "backs of an earlier bake are taken out");
    for (args, part) in [
        ("-o a.safetensors", "--backs: only of a .glb"),
        ("--clusters 2 -o a.glb", "--clusters"),
        ("--shard 1/2 -o a.safetensors", "--shard"),
    ] {
        let line = bake(&format!("--backs {args}")).arg("--quiet").error();
        assert!(line.contains(part), "{args}: {line}");
    }
}

#[test]
fn light_goes_to_and_fro_between_the_backs_of_a_folded_sheet() {
    let dir = Dir::new();
    // Two squares of 16 x 16 cells that meet in the x axis like a roof, their fronts outside.
    let (mut vertices, mut faces) = (String::new(), String::new());
    for (side, y) in [(0, 1.0), (1, -1.0)] {
        for k in 0..17 * 17 {
            let (u, v) = (f64::from(k % 17) / 8.0 - 1.0, f64::from(k / 17) / 16.0);
            vertices += &format!("v {} {} {}\n", u * y, y * v, 1.0 - v);
            if k % 17 < 16 && k / 17 < 16 {
                let first = side * 289 + k + 1;
                faces += &format!("f {} {} {} {}\n", first, first + 1, first + 18, first + 17);
            }
        }
    }
    dir.file("roof.obj", format!("{vertices}{faces}"));
    dir.map("sky.exr", 32, 16, |_, y| if y < 8 { [1.0, 0.5, 0.2] } else { [0.1, 0.4, 0.8] });
    for view in ["--eye 0.2,0.1,-4 --target 0,0,0.5", "--eye 0.2,0.3,5 --target 0,0,0.5"] {
        let common = format!("roof.obj --up z --env sky.exr {view} --fov 18 --size 16x12");
        let once = truth(&dir, &format!("{common} --bounces 0"));
        let often = truth(&dir, &common);
        check(&dir, &format!("{common} --mode shadowed --background light"), once);
        check(&dir, &format!("{common} --mode interreflected --background light"), often);
        let (is_inside, gain) = (view.contains("-4"), often[0] / once[0]);
        assert!((gain > 1.0 + 2.0 * TOLERANCE) == is_inside, "{view}: {once:?}, {often:?}");
    }
}

#[test]
fn a_shining_sheet_looks_alike_from_both_sides_under_light_that_is() {
    let dir = Dir::new();
    write_square(&dir);
    dir.map("alike.exr", 32, 16, |_, y| [1.0, 0.1 * y.min(15 - y) as f32, 0.5]);
    let [above, below] = [ABOVE, BELOW].map(|view| {
        let args = format!("render s.obj --up z --env alike.exr --mode glossy {view} -o a.exr");
        dir.lobe(&args).arg("--quiet").stdout();
        mean(&dir, "a.exr")
    });
    assert!(above.iter().all(|c| *c > 0.1), "{above:?}");
    for c in 0..3 {
        assert!((above[c] / below[c] - 1.0).abs() < TOLERANCE, "above {above:?}, below {below:?}");
    }
}

#[test]
fn single_sided_surfaces_are_black_from_behind_in_every_mode() {
    let dir = Dir::new();
    dir.map("even.exr", 16, 8, |_, _| [1.0; 3]);
    let baked = ["unshadowed", "shadowed", "interreflected", "glossy"];
    let baked = baked.map(|mode| format!("baked --mode {mode} --no-split --bake-samples 16"));
    for method in ["trace", "irradiance"].map(str::to_owned).into_iter().chain(baked) {
        // From outside, the box fills the picture.
        let args = format!("{method} built-in:furnace --env even.exr --eye 3,0.3,0.2 --target 0,0,0 --fov 20");
        dir.lobe(&format!("render {args} --size 8x6 -o a.exr")).arg("--quiet").stdout();
        assert_eq!(mean(&dir, "a.exr"), [0.0; 3], "{method}");
    }
}
