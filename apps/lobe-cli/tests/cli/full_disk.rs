//! A full disk: long work whose results have no room is refused before it begins, and nothing is left behind.

use std::process::Command;

use crate::harness::Dir;

/// Files of at most 4 KB, as `ulimit` counts: blocks of 512 bytes. A disk of a size of its own needs the rights of an administrator.
const BLOCKS: usize = 8;

/// Runs `lobe` where no file can be longer; the system would end it at the first one if it did not take the signal.
fn run_cramped(dir: &Dir, args: &str) -> (Option<i32>, String) {
    let line = format!("ulimit -f {BLOCKS}; exec {} {args}", env!("CARGO_BIN_EXE_lobe"));
    let output = Command::new("sh").args(["-c", &line]).current_dir(dir.path("")).output().unwrap();
    (output.status.code(), String::from_utf8(output.stderr).unwrap())
}

#[test]
fn work_whose_results_have_no_room_leaves_nothing_behind() {
    let dir = Dir::new();
    dir.map("sky.hdr", 4, 2, |_, _| [1.0; 3]);
    let room = "built-in:cornell";
    dir.lobe(&format!("bake {room} --no-split --samples 2 -o room.glb")).succeeds();
    let before = dir.names();
    for args in [
        &format!("render trace {room} --env sky.hdr --samples 4 --size 64x64 -o t.exr"),
        &format!(
            "render {room} --env sky.hdr --mode shadowed --no-split --bake-samples 4 --samples 4 --size 256x256 --frames 2 -o t.png"
        ),
        &format!("bake {room} --no-split --samples 16 -o b.glb"),
        &format!("bake {room} --samples 16 --mode glossy --order 3 -o g.safetensors"),
        &format!("bake {room} --samples 16 --grid 4,4,4 -o grid.safetensors"),
        &format!("bake {room} --samples 4 --texels 32 -o map.exr"),
        &format!("bake {room} --no-split --samples 16 --shard 1/2 -o part.safetensors"),
        "field room.glb --order 4 --rays 16 -o room.field.safetensors",
        "spheres room.glb --count 300 --points 600 --rounds 1 -o room.spheres.safetensors",
        "env convert sky.hdr --to cube --size 64 -o cube.ktx2",
        "compress room.glb --clusters 4 -o small.safetensors",
    ] {
        let (code, stderr) = run_cramped(&dir, args);
        let last = stderr.lines().last().unwrap_or_default();
        assert_eq!(code, Some(2), "lobe {args}: {stderr}");
        let names_the_reason = last.contains("File too large") || last.contains("larger than the system lets");
        assert!(last.starts_with("lobe: ") && names_the_reason, "lobe {args}: {stderr}");
        assert_eq!(dir.names(), before, "lobe {args}");
    }
}
