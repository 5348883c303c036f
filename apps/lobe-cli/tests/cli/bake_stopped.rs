//! Ctrl-C in `lobe bake`, `compress` and `fit-lobes`: the files that are left, and resumption by the same command.

use std::fs;
use std::thread::sleep;
use std::time::Duration;

use crate::bake_killed::half_written;
use crate::harness::Dir;
use crate::stopped::{line, started, stopped};

/// The end of a line that says how to continue.
const GO_ON: &str = "; the same command goes on from there, --fresh starts anew\n";

/// A bake that takes no time, of enough vertices that the work after it takes long.
const MANY: &str = "bake built-in:ball --max-edge 0.1 --order 4 --mode unshadowed --quiet";

/// Starts a command that takes minutes and presses Ctrl-C, later each time until `is_meant` says of its line that it
/// was at the right moment; that line. What it leaves otherwise is removed.
fn pressed_until(dir: &Dir, args: &str, leaves: &[&str], is_meant: impl Fn(&str) -> bool) -> String {
    let before = dir.names();
    for tenths in [5, 10, 20, 40, 80, 160, 320] {
        let child = started(dir, args);
        sleep(Duration::from_millis(100 * tenths));
        let output = stopped(dir, child, "").unwrap_or_else(|| panic!("lobe {args} was done after {tenths} tenths"));
        // Where it had not begun its work, it ended as any program does.
        if output.status.code().is_some() {
            let line = line(output);
            if is_meant(&line) {
                return line;
            }
        }
        for name in leaves.iter().filter(|name| !before.iter().any(|old| old == *name)) {
            let _ = fs::remove_file(dir.path(name));
        }
    }
    panic!("lobe {args} was never at the right moment");
}

#[test]
fn a_bake_that_was_stopped_goes_on_to_the_same_bytes() {
    let dir = Dir::new();
    // More work each time it was done before it could be stopped.
    for samples in [2048, 8192, 32768, 131072] {
        let args = format!("bake built-in:furnace --mode shadowed --order 2 --samples {samples} --quiet -o out.glb");
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
fn adaptive_splitting_that_was_stopped_goes_on_to_the_same_bytes() {
    let dir = Dir::new();
    for edge in [0.5, 0.25, 0.125, 0.06] {
        let args = format!(
            "bake built-in:ball --max-edge {edge} --adaptive 0.05 --order 2 --samples 64 --bounces 0 --quiet -o out.glb"
        );
        let Some(output) = stopped(&dir, started(&dir, &args), "out.glb.checkpoint.split-1") else {
            fs::remove_file(dir.path("out.glb")).unwrap();
            continue;
        };
        let line = line(output);
        assert!(line.starts_with("lobe: stopped ") && line.ends_with(GO_ON), "{line:?}");
        assert!(
            dir.names().contains(&"out.glb.checkpoint.split-0".to_owned()),
            "files after Ctrl-C: {:?}",
            dir.names()
        );
        assert!(!dir.path("out.glb").exists(), "no output");
        for other in [args.replace(" --adaptive 0.05", ""), args.replace("--order 2", "--order 3")] {
            let line = dir.lobe(&other).error();
            assert!(line.starts_with("out.glb.checkpoint.split-0: this checkpoint is of "), "{line}");
        }
        let (_, said) = dir.lobe(&args.replace("--quiet ", "")).succeeds();
        assert!(said.contains("note: out.glb.checkpoint: found; going on from "), "{said}");
        assert_eq!(dir.names(), ["out.glb"], "files at the end");
        dir.lobe(&args.replace("out.glb", "whole.glb")).stdout();
        assert!(dir.bytes("out.glb") == dir.bytes("whole.glb"), "the same bytes as without a stop");
        return;
    }
    panic!("the splitting was done before it could be stopped");
}

#[test]
fn compression_after_a_bake_stops_and_keeps_the_bake() {
    let dir = Dir::new();
    let args = format!("{MANY} -o out.glb --clusters 65536");
    let line = pressed_until(&dir, &args, &["out.glb.checkpoint"], |line| !line.contains(" points"));
    assert_eq!(line, format!("lobe: stopped after the bake, before its output was written{GO_ON}"), "said");
    assert_eq!(dir.names(), ["out.glb.checkpoint"], "files after Ctrl-C");
    let (_, said) = dir.lobe(&format!("{} -o out.glb", MANY.replace(" --quiet", ""))).succeeds();
    assert!(said.contains("found; going on from 100 %"), "nothing is baked twice: {said}");
}

#[test]
fn compression_and_fits_stop_and_write_nothing() {
    let dir = Dir::new();
    dir.lobe(&format!("{MANY} -o in.safetensors")).stdout();
    for command in ["compress in.safetensors --clusters 65536", "fit-lobes in.safetensors --lobes 8"] {
        let line = pressed_until(&dir, &format!("{command} -o out.safetensors"), &[], |_| true);
        assert_eq!(line, "lobe: stopped; nothing is written, and the same command starts anew\n", "{command}");
        assert_eq!(dir.names(), ["in.safetensors"], "files after {command}");
    }
}

#[test]
fn ctrl_c_while_the_output_is_written_leaves_a_checkpoint_or_all_of_it_and_says_which() {
    let dir = Dir::new();
    for _ in 0..3 {
        let _ = fs::remove_file(dir.path("out.glb"));
        let mut child = started(&dir, "bake built-in:ball --max-edge 0.1 --order 8 --mode unshadowed -o out.glb");
        while half_written(&dir).is_empty() && child.try_wait().unwrap().is_none() {}
        match stopped(&dir, child, "") {
            Some(output) => {
                let said = String::from_utf8(output.stderr).unwrap();
                let last = said.lines().last().unwrap();
                assert_eq!(
                    format!("{last}\n"),
                    format!("lobe: stopped after the bake, before its output was written{GO_ON}")
                );
                assert_eq!(
                    (output.status.code(), dir.names()),
                    (Some(2), vec!["out.glb.checkpoint".to_owned()]),
                    "left"
                );
            }
            None => assert_eq!(dir.names(), ["out.glb"], "all of it"),
        }
    }
}
