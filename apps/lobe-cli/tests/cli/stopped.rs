//! Ctrl-C in `lobe render`: the files that are left, and resumption by the same command.

use std::process::{Child, Command, Output, Stdio};
use std::thread::sleep;
use std::time::Duration;

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
    while !dir.path(file).exists() && child.try_wait().unwrap().is_none() {
        sleep(Duration::from_millis(5));
    }
    sleep(Duration::from_millis(50));
    Command::new("kill").args([signal, &child.id().to_string()]).stderr(Stdio::null()).status().unwrap();
    let output = child.wait_with_output().unwrap();
    (!output.status.success()).then_some(output)
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
            "render built-in:ball --env bundled:studio --mode truth --size 48x32 --samples {samples} --quiet -o out.exr"
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
    let args = "render built-in:ball --env bundled:studio --mode truth --samples 65536 --quiet -o out.exr";
    for signal in ["-TERM", "-HUP"] {
        let output = signaled(&dir, started(&dir, args), "out.exr.checkpoint", signal).unwrap();
        let said = line(output);
        assert!(said.starts_with("lobe: stopped before the end; the same command goes on"), "{signal}: {said}");
        assert_eq!(dir.names(), ["out.exr.checkpoint"], "files after {signal}");
        std::fs::remove_file(dir.path("out.exr.checkpoint")).unwrap();
    }
}

#[cfg(target_os = "linux")]
#[test]
fn what_was_started_with_nohup_does_not_hear_that_the_terminal_is_gone() {
    let dir = Dir::new();
    let lobe = env!("CARGO_BIN_EXE_lobe");
    let args = "render built-in:ball --env bundled:studio --mode truth --samples 65536 --quiet -o out.exr";
    let mut command = Command::new("sh");
    command.args(["-c", &format!("trap '' HUP; exec {lobe} {args}")]).current_dir(dir.path("")).stderr(Stdio::piped());
    let mut child = command.spawn().unwrap();
    while !dir.path("out.exr.checkpoint").exists() {
        sleep(Duration::from_millis(5));
    }
    let kill = |signal: &str, child: &Child| {
        Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap();
    };
    kill("-HUP", &child);
    sleep(Duration::from_millis(500));
    assert!(child.try_wait().unwrap().is_none(), "it goes on after SIGHUP");
    kill("-TERM", &child);
    assert!(line(child.wait_with_output().unwrap()).starts_with("lobe: stopped before the end"), "after SIGTERM");
}

#[test]
fn frames_that_were_complete_stay_and_nothing_is_half_written() {
    let dir = Dir::new();
    let args =
        "render built-in:ball --env bundled:studio --mode irradiance --size 96x64 --frames 1000 --quiet -o turn.png";
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

#[test]
fn a_bake_on_the_way_to_a_picture_stops_and_keeps_nothing() {
    let dir = Dir::new();
    let args = "render built-in:ball --env bundled:studio --mode shadowed --bake-samples 2048 --quiet -o out.png";
    for seconds in [1, 2, 4, 8, 16] {
        let child = started(&dir, args);
        sleep(Duration::from_secs(seconds));
        let output = stopped(&dir, child, "").unwrap();
        assert_eq!(dir.names(), Vec::<String>::new(), "files");
        if output.status.code().is_some() {
            let line = line(output);
            let said = "lobe: stopped while transfer was baked, of which nothing is kept; lobe bake can";
            return assert!(line.starts_with(said), "{line}");
        }
        // It had not begun to bake, and ended as any program does.
    }
    panic!("the bake never began");
}
