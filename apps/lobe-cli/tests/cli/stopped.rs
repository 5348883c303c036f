//! Ctrl-C in `lobe render`: the files that are left, and resumption by the same command.

use std::process::{Child, Command, Output, Stdio};

use crate::bake_killed::{ends_before, part_done};
use crate::harness::Dir;

pub(crate) fn started(dir: &Dir, args: &str) -> Child {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lobe"));
    let command = command.args(args.split(' ')).current_dir(dir.path("")).stderr(Stdio::piped());
    command.spawn().unwrap()
}

/// Presses Ctrl-C as soon as a file is there; the output of the command, or none if it was done before.
pub(crate) fn stopped(dir: &Dir, child: Child, file: &str) -> Option<Output> {
    signaled(dir, child, file, "-INT")
}

/// Sends a signal as soon as a file is there; the output of the command, or none if it was done before.
fn signaled(dir: &Dir, mut child: Child, file: &str, signal: &str) -> Option<Output> {
    ends_before(&mut child, || dir.path(file).exists());
    Command::new("kill").args([signal, &child.id().to_string()]).stderr(Stdio::null()).status().unwrap();
    let output = child.wait_with_output().unwrap();
    (!output.status.success()).then_some(output)
}

/// Starts a command and presses Ctrl-C as soon as it listens, which is when its long work begins; its output.
#[cfg(target_os = "linux")]
pub(crate) fn stopped_at_work(dir: &Dir, args: &str) -> Output {
    let mut child = started(dir, args);
    let status = format!("/proc/{}/status", child.id());
    // A mask of the signals that have a handler; SIGINT is number 2.
    let listens = || {
        let status = std::fs::read_to_string(&status).unwrap_or_default();
        let caught = status.lines().find_map(|line| line.strip_prefix("SigCgt:"));
        caught.is_some_and(|mask| u64::from_str_radix(mask.trim(), 16).unwrap() >> 1 & 1 == 1)
    };
    assert!(!ends_before(&mut child, listens), "lobe {args} was done before it listened");
    stopped(dir, child, "").unwrap_or_else(|| panic!("lobe {args} was done before it could be stopped"))
}

#[test]
fn a_command_without_an_order_to_keep_clears_away_what_it_was_writing() {
    // What is run in the background of a script inherits that it ignores interrupts.
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:")).unwrap().trim();
    let ignored = u64::from_str_radix(mask, 16).unwrap();
    for (number, signal) in [(1, "-HUP"), (2, "-INT"), (15, "-TERM")] {
        if ignored >> (number - 1) & 1 == 1 {
            lobe_testkit::skipped(&format!("{signal} of a command without an order to keep: it is ignored here"));
            continue;
        }
        // More to write each time it was done before it could be stopped.
        let was_stopped = [1024, 2048, 4096].into_iter().any(|size| {
            let dir = Dir::new();
            let mut child = started(&dir, &format!("env convert bundled:sunset --size {size} --quiet -o out.exr"));
            let begun = || dir.names().iter().any(|name| name.starts_with(".lobe-"));
            if ends_before(&mut child, begun) {
                return false;
            }
            Command::new("kill").args([signal, &child.id().to_string()]).stderr(Stdio::null()).status().unwrap();
            let output = child.wait_with_output().unwrap();
            if output.status.success() {
                return false;
            }
            assert_eq!(output.status.code(), None, "{signal}: ended by the signal");
            assert_eq!(dir.names(), [""; 0], "{signal}: files that are left");
            true
        });
        assert!(was_stopped, "{signal}: every conversion was done before it could be stopped");
    }
}

/// The one line with which a command that was stopped ends.
pub(crate) fn line(output: Output) -> String {
    let line = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "exit code; stderr: {line}");
    assert!(line.ends_with('\n') && line.lines().count() == 1, "{line:?}");
    line
}

#[test]
fn a_truth_that_was_stopped_goes_on_to_the_same_bytes() {
    let dir = Dir::new();
    // More work each time it was done before it could be stopped.
    for samples in [256, 1024, 4096, 16384, 65536] {
        let args = format!(
            "render trace built-in:ball --env bundled:studio --size 48x32 --samples {samples} --quiet -o out.exr"
        );
        let Some(output) = stopped(&dir, started(&dir, &args), "out.exr.checkpoint") else {
            std::fs::remove_file(dir.path("out.exr")).unwrap();
            continue;
        };
        let line = line(output);
        assert_eq!(
            line, "lobe: stopped before the end; the same command goes on from there, --fresh starts anew\n",
            "said"
        );
        assert_eq!(dir.names(), ["out.exr.checkpoint"], "files after Ctrl-C");
        let line = dir.lobe(&args.replace("studio", "sunset")).error();
        assert!(line.starts_with("out.exr.checkpoint: this checkpoint is of another picture"), "{line}");
        dir.lobe(&args).stdout();
        assert_eq!(dir.names(), ["out.exr"], "files at the end");
        dir.lobe(&args.replace("out.exr", "whole.exr")).stdout();
        assert!(dir.bytes("out.exr") == dir.bytes("whole.exr"), "the same bytes as without a stop");
        return;
    }
    panic!("the picture was done before it could be stopped");
}

#[test]
fn being_asked_to_end_stops_as_ctrl_c_does() {
    let dir = Dir::new();
    let args = "render trace built-in:ball --env bundled:studio --samples 65536 --quiet -o out.exr";
    for signal in ["-TERM", "-HUP"] {
        if signal == "-HUP" && hangups_are_ignored() {
            lobe_testkit::skipped("hangups: these tests were started with nohup, and so is what they start");
            continue;
        }
        let output = signaled(&dir, started(&dir, args), "out.exr.checkpoint", signal).unwrap();
        let said = line(output);
        assert!(said.starts_with("lobe: stopped before the end; the same command goes on"), "{signal}: {said}");
        assert_eq!(dir.names(), ["out.exr.checkpoint"], "files after {signal}");
        std::fs::remove_file(dir.path("out.exr.checkpoint")).unwrap();
    }
}

/// Whether SIGHUP, number 1, is ignored by this process and thus by all that it starts; false where nothing tells.
fn hangups_are_ignored() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    ignored.is_some_and(|mask| u64::from_str_radix(mask.trim(), 16).unwrap() & 1 == 1)
}

#[cfg(target_os = "linux")]
#[test]
fn what_was_started_with_nohup_does_not_hear_that_the_terminal_is_gone() {
    let dir = Dir::new();
    let lobe = env!("CARGO_BIN_EXE_lobe");
    let args = "render trace built-in:ball --env bundled:studio --samples 65536 --quiet -o out.exr";
    let mut command = Command::new("sh");
    command.args(["-c", &format!("trap '' HUP; exec {lobe} {args}")]).current_dir(dir.path("")).stderr(Stdio::piped());
    let mut child = command.spawn().unwrap();
    let checkpoint = dir.path("out.exr.checkpoint");
    assert!(!ends_before(&mut child, || part_done(&checkpoint) > 0.0), "done before the signal");
    let kill = |signal: &str, child: &Child| {
        Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap();
    };
    kill("-HUP", &child);
    let before = part_done(&checkpoint);
    assert!(!ends_before(&mut child, || part_done(&checkpoint) > before), "it goes on after SIGHUP");
    kill("-TERM", &child);
    assert!(line(child.wait_with_output().unwrap()).starts_with("lobe: stopped before the end"), "after SIGTERM");
}

#[test]
fn frames_that_were_complete_stay_and_nothing_is_half_written() {
    let dir = Dir::new();
    let args = "render irradiance built-in:ball --env bundled:studio --size 96x64 --frames 1000 --quiet -o turn.png";
    let output = stopped(&dir, started(&dir, args), "turn-001.png").unwrap();
    let line = line(output);
    let rest = line.strip_prefix("lobe: stopped after ").unwrap_or_else(|| panic!("{line}"));
    let (count, rest) = rest.split_once(' ').unwrap();
    assert_eq!(rest, "of 1000 pictures, which are kept; the same command starts anew\n", "said");
    let count: usize = count.parse().unwrap();
    assert_eq!(dir.names(), (0..count).map(|k| format!("turn-{k:03}.png")).collect::<Vec<_>>(), "files");
    for name in dir.names() {
        assert!(dir.bytes(&name).ends_with(b"IEND\xAEB`\x82"), "{name} is whole");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_bake_on_the_way_to_a_picture_stops_and_keeps_nothing() {
    let dir = Dir::new();
    let args =
        "render built-in:ball --env bundled:studio --mode shadowed --no-split --bake-samples 2048 --quiet -o out.png";
    let output = stopped_at_work(&dir, args);
    assert_eq!(dir.names(), Vec::<String>::new(), "files");
    let line = line(output);
    assert!(
        line.starts_with("lobe: stopped while transfer was baked, of which nothing is kept; lobe bake can"),
        "{line}"
    );
}
