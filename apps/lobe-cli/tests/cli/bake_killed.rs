//! `lobe bake` killed at any moment: the same command resumes from its checkpoint and writes the same bytes.

use std::fs;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::Duration;

use crate::harness::Dir;

/// Starts a command that can be killed.
fn start(dir: &Dir, args: &str) -> Child {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lobe"));
    command.args(args.split(' ')).current_dir(dir.path("")).stderr(Stdio::piped()).spawn().unwrap()
}

/// Waits until `is_time`, or the command has come to its end by itself, which is what is returned: it is not to fail.
pub(crate) fn ends_before(child: &mut Child, mut is_time: impl FnMut() -> bool) -> bool {
    while !is_time() {
        if let Some(status) = child.try_wait().unwrap() {
            assert!(status.success(), "{status}");
            return true;
        }
        sleep(Duration::from_millis(1));
    }
    false
}

/// The part of the records in a checkpoint that is done: their checksums, at their ends, are no longer zero. None without
/// a file.
pub(crate) fn part_done(path: &Path) -> f64 {
    /// Bytes of the header, see the guide's page of formats.
    const HEADER: usize = 80;
    let bytes = fs::read(path).unwrap_or_default();
    let Some(header) = bytes.get(..HEADER).filter(|header| header.starts_with(b"LOBE")) else { return 0.0 };
    let [records, len] = [16, 24].map(|at| u64::from_le_bytes(header[at..at + 8].try_into().unwrap()) as usize);
    // The last record may be shorter.
    let end = |k: usize| if k + 1 == records { bytes.len() } else { HEADER + (k + 1) * (len + 8) };
    let done = (0..records).take_while(|k| bytes.get(end(*k) - 8..end(*k)).is_some_and(|sum| sum != [0; 8])).count();
    done as f64 / records as f64
}

/// The percentage from which a bake said that it resumes.
fn resumed_from(stderr: &[u8]) -> Option<u32> {
    let said = String::from_utf8_lossy(stderr);
    let (_, rest) = said.split_once("note: out.glb.checkpoint: found; going on from ")?;
    Some(rest.split_once(" %").unwrap().0.parse().unwrap())
}

/// Outputs that are being written, or were when something happened. Empty ones, by which a bake finds at its start that
/// it can write, do not count.
fn half_written(dir: &Dir) -> Vec<String> {
    let is_begun = |name: &String| dir.path(name).metadata().is_ok_and(|file| file.len() > 0);
    dir.names().into_iter().filter(|name| name.starts_with(".lobe-") && is_begun(name)).collect()
}

#[test]
#[ignore = "long: of the nightly group"]
fn a_bake_killed_again_and_again_goes_on_and_ends_with_the_same_bytes() {
    let dir = Dir::new();
    let bake = "bake built-in:ball --max-edge 0.15 --order 3 --samples 1024 --bounces 1 -o";
    dir.lobe(&format!("{bake} whole.glb --quiet")).stdout();
    let checkpoint = dir.path("out.glb.checkpoint");
    let mut percents = vec![0];
    for run in 0.. {
        // Once before there is a checkpoint, then four times as soon as there is a tenth more in it.
        let before = part_done(&checkpoint);
        let mut child = start(&dir, &format!("{bake} out.glb"));
        let has_ended = ends_before(&mut child, || run == 0 || run < 5 && part_done(&checkpoint) > before + 0.1);
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
    assert!(percents.len() > 2 && percents[percents.len() - 1] > 0, "resumed from {percents:?} %");
    assert_eq!(dir.names(), ["out.glb", "whole.glb"], "files at the end");
    assert!(dir.bytes("out.glb") == dir.bytes("whole.glb"), "the same bytes as without a kill");
}

#[test]
#[ignore = "long: of the nightly group"]
fn adaptive_splitting_killed_again_and_again_goes_on_and_ends_with_the_same_bytes() {
    let dir = Dir::new();
    let bake =
        "bake built-in:ball --max-edge 0.5 --max-vertices 40000 --adaptive 0.002 --order 2 --samples 64 --bounces 0 -o";
    dir.lobe(&format!("{bake} whole.glb --quiet")).stdout();
    let (mut killed_while_splitting, mut resumed) = (0, 0);
    let [first, second] = [0, 1].map(|round| dir.path(&format!("out.glb.checkpoint.split-{round}")));
    for run in 0.. {
        // Three times as soon as there is a fifth more of the first round, then once in the second.
        let before = part_done(&first);
        let mut child = start(&dir, &format!("{bake} out.glb"));
        let has_ended = ends_before(&mut child, || match run {
            0..3 => part_done(&first) > before + 0.2,
            3 => second.exists(),
            _ => false,
        });
        child.kill().unwrap();
        let said = String::from_utf8(child.wait_with_output().unwrap().stderr).unwrap();
        resumed += usize::from(said.contains("out.glb.checkpoint: found; going on from "));
        if has_ended {
            break;
        }
        killed_while_splitting += usize::from(!dir.path("out.glb.checkpoint").exists());
        assert!(!dir.path("out.glb").exists(), "a killed bake has no output");
    }
    assert!(killed_while_splitting > 1 && resumed > 1, "{killed_while_splitting} kills, {resumed} resumed");
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
            fs::remove_file(dir.path("out.glb")).unwrap();
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
