//! `lobe lamp`: lamps of every shape as files, and what cannot be one.

use lobe::shadow::{Lamp, RadialInterpolation, read_lamp};
use serde_json::Value;

use crate::harness::{Dir, flat_hdr};
use crate::stopped::{line, started, stopped};

/// Few samples, so that it is quick.
const COARSE: &str = "--order 3 --spheres 4 --cells 4";

/// The mean radiance that a lamp sends to a point, red and blue.
fn at(lamp: &Lamp, time: f64, point: [f64; 3]) -> [f32; 2] {
    let light = lamp.at(time).unwrap().radiance_at(point, RadialInterpolation::Linear);
    [light[0].r, light[0].b]
}

#[test]
fn lamps_of_every_shape_are_written_and_read() {
    let dir = Dir::new();
    dir.lobe("lamp sphere --radius 0.5 --radiance 1,2,3 -o s.safetensors").succeeds();
    let sphere = read_lamp(dir.path("s.safetensors")).unwrap();
    let [red, blue] = at(&sphere, 0.0, [0.0, 0.0, 2.0]);
    assert!(red > 0.0 && (blue / red - 3.0).abs() < 1e-5, "{red} and {blue}");

    dir.lobe(&format!("lamp rectangle --size 2,1 {COARSE} -o r.safetensors")).succeeds();
    let rectangle = read_lamp(dir.path("r.safetensors")).unwrap();
    let [[front, _], [back, _]] = [2.0, -2.0].map(|z| at(&rectangle, 0.0, [0.0, 0.0, z]));
    assert!(front > 0.1 && back.abs() < 0.1 * front, "it shines towards +z: {front} before and {back} behind");
}

#[test]
fn pictures_are_seen_from_the_front_and_follow_each_other() {
    let dir = Dir::new();
    // Red on the left and blue on the right, then the other way round.
    let (red, blue) = ([128, 0, 0, 129], [0, 0, 128, 129]);
    dir.file("a.hdr", flat_hdr(2, 1, &[red, blue]));
    dir.file("b.hdr", flat_hdr(2, 1, &[blue, red]));
    let size = format!("lamp rectangle --size 2,1 --patches 2,1 {COARSE}");
    let printed = dir.lobe(&format!("{size} --pictures a.hdr b.hdr --fps 2 -o l.safetensors --json")).succeeds().0;
    let printed: Value = serde_json::from_str(&printed).unwrap();
    assert_eq!((&printed["pictures"], &printed["patches"]), (&2.into(), &serde_json::json!([2, 1])), "{printed}");
    let lamp = read_lamp(dir.path("l.safetensors")).unwrap();
    // Near the left end, as one sees it from the front with y up.
    let left = [-0.8, 0.0, 0.4];
    let ([r, b], [later_r, later_b]) = (at(&lamp, 0.0, left), at(&lamp, 0.5, left));
    assert!(r > 1.5 * b && later_b > 1.5 * later_r, "{r}, {b} at first, {later_r}, {later_b} half a second later");
    let printed = dir.lobe(&format!("{size} --pictures a.hdr -o one.safetensors --json")).succeeds().0;
    let printed: Value = serde_json::from_str(&printed).unwrap();
    assert_eq!((&printed["pictures"], &printed["patches"]), (&1.into(), &serde_json::json!([2, 1])), "{printed}");
    let one = read_lamp(dir.path("one.safetensors")).unwrap();
    assert!(matches!(one, Lamp::Still(_)), "one picture stands");
    let off = (at(&one, 0.0, left)[0] - r).abs();
    assert!(off < 1e-6, "off by {off}");
}

#[test]
fn pictures_that_an_option_keeps_out_come_in_by_the_option_that_is_named() {
    let dir = Dir::new();
    dir.map("nan.exr", 4, 2, |x, _| if x == 0 { [f32::NAN; 3] } else { [1.0; 3] });
    let lamp = format!("lamp rectangle --size 2,1 --patches 2,1 {COARSE} --pictures nan.exr -o l.safetensors");
    for (options, named, then) in
        [("", "--nonfinite zero", ""), ("--nonfinite zero --max-texels 7", "--max-texels", "--nonfinite zero")]
    {
        let message = dir.lobe(&format!("{lamp} {options}")).error();
        assert!(message.starts_with("nan.exr: ") && message.contains(named), "{options}: {message}");
        if !then.is_empty() {
            dir.lobe(&format!("{lamp} {then}")).succeeds();
        }
    }
    let lit = read_lamp(dir.path("l.safetensors")).unwrap();
    assert!(at(&lit, 0.0, [0.0, 0.0, 1.0])[0] > 0.0, "the texels that are numbers shine");
}

#[test]
fn what_cannot_be_a_lamp_is_refused() {
    let dir = Dir::new();
    for (given, expected) in [
        ("sphere", "a sphere has a --radius"),
        ("rectangle", "a rectangle has a --size: give it as --size W,H"),
        ("sphere --radius 1 --size 1,1", "--size: only of a rectangle"),
        ("rectangle --size 1,1 --radius 1", "--radius: only of a sphere"),
        ("rectangle --size 1,1 --patches 2,2", "--patches: only with --pictures"),
        ("rectangle --size 1,1 --fps 2", "--fps: only with several --pictures"),
        ("rectangle --size 1,1 --pictures none.png", "none.png"),
        ("rectangle --size 0,1", "a width and a height above 0"),
    ] {
        let message = dir.lobe(&format!("lamp {given} -o l.safetensors")).error();
        assert!(message.contains(expected), "{given}: {message}");
    }
}

#[test]
fn a_lamp_that_was_stopped_goes_on_to_the_same_bytes() {
    let dir = Dir::new();
    dir.file("a.hdr", flat_hdr(2, 1, &[[128, 0, 0, 129], [0, 0, 128, 129]]));
    // More work each time it was done before it could be stopped.
    for patches in [8, 16, 32, 64] {
        let args = format!(
            "lamp rectangle --size 2,1 --pictures a.hdr --patches {patches},{patches} --quiet -o l.safetensors"
        );
        let Some(output) = stopped(&dir, started(&dir, &args), "l.safetensors.checkpoint") else {
            std::fs::remove_file(dir.path("l.safetensors")).unwrap();
            continue;
        };
        let line = line(output);
        let go_on = " points; the same command goes on from there, --fresh starts anew\n";
        assert!(line.starts_with("lobe: stopped after ") && line.ends_with(go_on), "{line:?}");
        assert_eq!(dir.names(), ["a.hdr", "l.safetensors.checkpoint"], "files after Ctrl-C");
        let other = dir.lobe(&args.replace("--size 2,1", "--size 2,2")).error();
        assert!(other.contains("l.safetensors.checkpoint"), "the checkpoint of another lamp: {other}");
        dir.lobe(&args).stdout();
        assert_eq!(dir.names(), ["a.hdr", "l.safetensors"], "files at the end");
        dir.lobe(&args.replace("l.safetensors", "whole.safetensors")).stdout();
        assert!(dir.bytes("l.safetensors") == dir.bytes("whole.safetensors"), "the same bytes as without a stop");
        return;
    }
    panic!("the bake was done before it could be stopped");
}

#[test]
fn a_lamp_in_half_precision_takes_half_the_bytes() {
    let dir = Dir::new();
    let bytes = |options: &str| {
        let command = format!("lamp rectangle --size 2,1 {COARSE} {options} -o r.safetensors --json");
        let printed: Value = serde_json::from_str(&dir.lobe(&command).succeeds().0).unwrap();
        let error = printed["relative_error"].as_f64().unwrap();
        assert!(error < 0.02, "{printed}");
        read_lamp(dir.path("r.safetensors")).unwrap();
        printed["bytes"].as_u64().unwrap()
    };
    let [single, half, eighth] = ["", "--storage f16", "--storage u8"].map(bytes);
    assert_eq!(half * 2, single, "bytes in half precision");
    assert!(eighth < half, "{eighth} of eight bits, {half} of half precision");
    let message = dir.lobe("lamp sphere --radius 1 --storage f16 -o s.safetensors").error();
    assert!(message.contains("--storage: only of a rectangle"), "{message}");
}

#[test]
fn a_lamp_beyond_the_limit_of_memory_is_refused_before_it_is_baked() {
    let dir = Dir::new();
    dir.file("a.hdr", flat_hdr(2, 1, &[[128, 0, 0, 129], [0, 0, 128, 129]]));
    let lamp = "lamp rectangle --size 1,1 --pictures a.hdr --patches 64,64 -o l.safetensors --quiet";
    let line = dir.lobe(&format!("{lamp} --spheres 256 --cells 256 --order 8")).error();
    let expected = "a lamp of 64 x 64 patches at order 8 takes up to ";
    assert!(line.contains(expected) && line.contains("ask for fewer --patches, --spheres or --cells"), "{line}");
    let line = dir.lobe(&format!("{lamp} --spheres 2 --cells 2 --order 1 --max-memory 0.0001")).error();
    assert!(line.contains("more than the limit of 0.0001 GiB"), "{line}");
    dir.lobe(&format!("{lamp} --spheres 2 --cells 2 --order 1 --max-memory 0.01")).stdout();
    assert_eq!(dir.names(), ["a.hdr", "l.safetensors"]);
}
