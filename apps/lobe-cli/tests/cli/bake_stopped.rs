//! Ctrl-C in `lobe bake`, `compress` and `fit-lobes`: the files that are left, and resumption by the same command.

use std::fs;

use crate::bake_killed::{ends_before, part_done};
use crate::harness::Dir;
#[cfg(target_os = "linux")]
use crate::stopped::stopped_at_work;
use crate::stopped::{line, started, stopped};

/// The end of a line that says how to continue.
const GO_ON: &str = "; the same command goes on from there, --fresh starts anew\n";

/// A bake that takes no time, of enough vertices that the work after it takes long.
const MANY: &str = "bake built-in:ball --max-edge 0.1 --order 4 --mode unshadowed --quiet";

#[test]
fn a_bake_that_was_stopped_goes_on_to_the_same_bytes() {
    let dir = Dir::new();
    // More work each time it was done before it could be stopped.
    for samples in [2048, 8192, 32768, 131072] {
        let args = format!(
            "bake built-in:furnace --no-split --mode shadowed --order 2 --samples {samples} --quiet -o out.glb"
        );
        let Some(output) = stopped(&dir, started(&dir, &args), "out.glb.checkpoint") else {
            fs::remove_file(dir.path("out.glb")).unwrap();
            continue;
        };
        let line = line(output);
        assert!(line.starts_with("lobe: stopped after ") && line.ends_with(&format!(" points{GO_ON}")), "{line:?}");
        assert_eq!(dir.names(), ["out.glb.checkpoint"], "files after Ctrl-C");
        let line = dir.lobe(&args.replace("2 --samples", "3 --samples")).error();
        assert!(line.contains("out.glb.checkpoint"), "the checkpoint of another bake: {line}");
        dir.lobe(&args).stdout();
        assert_eq!(dir.names(), ["out.glb"], "files at the end");
        dir.lobe(&args.replace("out.glb", "whole.glb")).stdout();
        assert!(dir.bytes("out.glb") == dir.bytes("whole.glb"), "the same bytes as without a stop");
        return;
    }
    panic!("the bake was done before it could be stopped");
}

#[test]
fn compression_after_a_bake_stops_and_keeps_the_bake() {
    let dir = Dir::new();
    let args = format!("{MANY} -o out.glb --clusters 65536");
    let mut child = started(&dir, &args);
    let checkpoint = dir.path("out.glb.checkpoint");
    assert!(!ends_before(&mut child, || part_done(&checkpoint) == 1.0), "done before it could be stopped");
    let line = line(stopped(&dir, child, "").unwrap());
    assert_eq!(line, format!("lobe: stopped after the bake, before its output was written{GO_ON}"), "said");
    assert_eq!(dir.names(), ["out.glb.checkpoint"], "files after Ctrl-C");
    let (_, said) = dir.lobe(&format!("{} -o out.glb", MANY.replace(" --quiet", ""))).succeeds();
    assert!(said.contains("found; going on from 100 %"), "nothing is baked twice: {said}");
}

#[cfg(target_os = "linux")]
#[test]
fn compression_and_fits_stop_and_write_nothing() {
    let dir = Dir::new();
    dir.lobe(&format!("{MANY} -o in.safetensors")).stdout();
    for command in ["compress in.safetensors --clusters 65536", "fit-lobes in.safetensors --lobes 8"] {
        let line = line(stopped_at_work(&dir, &format!("{command} --quiet -o out.safetensors")));
        assert_eq!(line, "lobe: stopped; nothing is written, and the same command starts anew\n", "{command}");
        assert_eq!(dir.names(), ["in.safetensors"], "files after {command}");
    }
}
