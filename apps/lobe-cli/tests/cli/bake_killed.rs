//! `lobe bake` killed at any moment: the same command resumes from its checkpoint and writes the same bytes.

use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::harness::Dir;

/// Starts a command that can be killed.
fn start(dir: &Dir, args: &str) -> Child {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lobe"));
    command.args(args.split(' ')).current_dir(dir.path("")).stderr(Stdio::piped()).spawn().unwrap()
}

/// Waits for `time` at most; whether the command came to its end by itself.
fn ends_within(child: &mut Child, time: Duration) -> bool {
    let start = Instant::now();
    while start.elapsed() < time {
        if let Some(status) = child.try_wait().unwrap() {
            assert!(status.success(), "{status}");
            return true;
        }
        sleep(Duration::from_millis(1));
    }
    false
}

/// The percentage from which a bake said that it resumes.
fn resumed_from(stderr: &[u8]) -> Option<u32> {
    let said = String::from_utf8_lossy(stderr);
    let (_, rest) = said.split_once("note: out.glb.checkpoint: found; going on from ")?;
    Some(rest.split_once(" %").unwrap().0.parse().unwrap())
}

/// Outputs that are being written, or were when something happened. Empty ones, by which a bake finds at its start that
/// it can write, do not count.
pub(crate) fn half_written(dir: &Dir) -> Vec<String> {
    let is_begun = |name: &String| dir.path(name).metadata().is_ok_and(|file| file.len() > 0);
    dir.names().into_iter().filter(|name| name.starts_with(".lobe-") && is_begun(name)).collect()
}

#[test]
fn a_bake_killed_again_and_again_goes_on_and_ends_with_the_same_bytes() {
    let dir = Dir::new();
    let bake = "bake built-in:ball --max-edge 0.15 --order 3 --samples 512 --bounces 1 -o";
    let begin = Instant::now();
    dir.lobe(&format!("{bake} whole.glb --quiet")).stdout();
    let whole = begin.elapsed();
    let mut percents = vec![0];
    let mut runs = 0;
    loop {
        // At once, before there is a checkpoint; then later every time, so that the end is reached on a busy machine
        // too.
        let time = whole * runs / 12;
        runs += 1;
        let mut child = start(&dir, &format!("{bake} out.glb"));
        let has_ended = ends_within(&mut child, time);
        child.kill().unwrap();
        let output = child.wait_with_output().unwrap();
        if let Some(percent) = resumed_from(&output.stderr) {
            assert!(percent >= percents[percents.len() - 1], "{percent} % after {percents:?}: what was saved is lost");
            percents.push(percent);
        }
        if has_ended {
            break;
        }
        assert!(!dir.path("out.glb").exists(), "a killed bake has no output");
    }
    println!("{runs} runs, {whole:?} in one; resumed from {percents:?} %");
    assert!(runs > 3 && percents[percents.len() - 1] > 0, "{runs} runs, resumed from {percents:?} %");
    assert_eq!(dir.names(), ["out.glb", "whole.glb"], "files at the end");
    assert!(dir.bytes("out.glb") == dir.bytes("whole.glb"), "the same bytes as without a kill");
}

#[test]
fn adaptive_splitting_killed_again_and_again_goes_on_and_ends_with_the_same_bytes() {
    let dir = Dir::new();
    let bake = "bake built-in:ball --max-edge 0.5 --adaptive 0.1 --order 2 --samples 64 --bounces 0 -o";
    let begin = Instant::now();
    dir.lobe(&format!("{bake} whole.glb --quiet")).stdout();
    let whole = begin.elapsed();
    let (mut runs, mut killed_while_splitting, mut resumed) = (0, 0, 0);
    loop {
        let time = whole * runs / 12;
        runs += 1;
        let mut child = start(&dir, &format!("{bake} out.glb"));
        let has_ended = ends_within(&mut child, time);
        child.kill().unwrap();
        let said = String::from_utf8(child.wait_with_output().unwrap().stderr).unwrap();
        resumed += usize::from(said.contains("out.glb.checkpoint: found; going on from "));
        if has_ended {
            break;
        }
        let names = dir.names();
        let is_splitting = names.iter().any(|name| name.starts_with("out.glb.checkpoint.split-"));
        killed_while_splitting += usize::from(is_splitting && !dir.path("out.glb.checkpoint").exists());
        assert!(!dir.path("out.glb").exists(), "a killed bake has no output");
    }
    println!("{runs} runs, {whole:?} in one; killed while splitting {killed_while_splitting} times, resumed {resumed}");
    assert!(
        killed_while_splitting > 1 && resumed > 0,
        "{killed_while_splitting} kills, {resumed} resumed, {runs} runs"
    );
    assert_eq!(dir.names(), ["out.glb", "whole.glb"], "files at the end");
    assert!(dir.bytes("out.glb") == dir.bytes("whole.glb"), "the same bytes as without a kill");
}

#[test]
fn a_bake_killed_while_it_writes_its_output_leaves_nothing_half_written() {
    let dir = Dir::new();
    // Little work, and an output of 20 MB.
    let bake = "bake built-in:ball --max-edge 0.06 --order 8 --mode unshadowed --quiet -o";
    dir.lobe(&format!("{bake} whole.glb")).stdout();
    let mut kills = 0;
    for _ in 0..100 {
        let earlier = half_written(&dir);
        let is_writing = || half_written(&dir).iter().any(|name| !earlier.contains(name));
        let mut child = start(&dir, &format!("{bake} out.glb"));
        while !is_writing() && child.try_wait().unwrap().is_none() {}
        child.kill().unwrap();
        child.wait().unwrap();
        if dir.path("out.glb").exists() {
            // Too late for this time.
            assert!(dir.bytes("out.glb") == dir.bytes("whole.glb"), "an output is there, so it is whole");
            std::fs::remove_file(dir.path("out.glb")).unwrap();
        } else if is_writing() {
            assert!(earlier.iter().all(|name| !dir.path(name).exists()), "{earlier:?} were taken away");
            kills += 1;
            if kills == 3 {
                break;
            }
        }
    }
    assert_eq!(kills, 3, "times it was killed while it wrote");
    let (_, said) = dir.lobe(&format!("{} out.glb", bake.replace(" --quiet", ""))).succeeds();
    assert!(said.contains("found; going on from 100 %"), "nothing is baked twice: {said}");
    assert_eq!(dir.names(), ["out.glb", "whole.glb"], "files at the end");
    assert!(dir.bytes("out.glb") == dir.bytes("whole.glb"), "the same bytes as without a kill");
}
