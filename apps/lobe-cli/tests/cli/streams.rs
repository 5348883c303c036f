//! stdout, stderr, pipes, help.

use std::io::Write as _;
use std::process::{Command, Stdio};

use lobe::sh::ShVec;
use lobe::sh::expansion::Quantity;

use crate::harness::Dir;

#[test]
fn help_is_printed_on_stdout_with_examples() {
    let dir = Dir::new();
    let help = dir.lobe("--help").stdout();
    for part in [
        "Usage: lobe [OPTIONS] <COMMAND>",
        "Examples:\n  lobe demo",
        "\n  lobe project sky.exr -o sky.sh.json",
        "Exit code",
    ] {
        assert!(help.contains(part), "{part:?} is missing in\n{help}");
    }
    assert!(dir.lobe("--version").stdout().starts_with("lobe "), "version");
}

/// The commands that a help lists, each with its one line.
fn commands_of(help: &str) -> Vec<(String, String)> {
    let list = help.lines().skip_while(|line| *line != "Commands:").skip(1).take_while(|line| !line.is_empty());
    // Lines that go on further are indented further.
    let first = list.filter_map(|line| line.strip_prefix("  ")).filter(|line| !line.starts_with(' '));
    let parts = first.map(|line| line.split_once(' ').unwrap_or((line, "")));
    parts.map(|(name, about)| (name.to_owned(), about.trim().to_owned())).collect()
}

#[test]
fn every_command_that_a_help_lists_has_a_help_of_its_own() {
    let dir = Dir::new();
    let mut seen = Vec::new();
    let mut left = vec![String::new()];
    while let Some(command) = left.pop() {
        let help = dir.lobe(&format!("{command} --help")).stdout();
        let usage = format!("Usage: lobe {command}").trim_end().to_owned();
        assert!(help.contains(&format!("{usage} ")), "lobe {command} --help:\n{help}");
        for (name, about) in commands_of(&help).into_iter().filter(|(name, _)| name != "help") {
            assert!(!about.is_empty(), "lobe {command} --help says nothing of {name}:\n{help}");
            left.push(format!("{command} {name}").trim_start().to_owned());
        }
        seen.push(command);
    }
    assert!(seen.len() > 30, "{} commands found, which are not all: {seen:?}", seen.len());
    for command in ["bake", "sh peaks", "env dfg"] {
        assert!(seen.iter().any(|name| name == command), "{command} is not among {seen:?}");
    }
}

#[test]
fn without_a_command_help_goes_to_stderr_and_the_exit_code_is_2() {
    let dir = Dir::new();
    for args in ["", "sh", "env"] {
        let output = dir.lobe(args).output();
        assert_eq!((output.status.code(), output.stdout.len()), (Some(2), 0), "exit code and stdout of lobe {args}");
        assert!(String::from_utf8(output.stderr).unwrap().contains("Usage: lobe"), "stderr of lobe {args}");
    }
}

#[test]
fn an_expansion_goes_through_stdin_and_stdout_unchanged() {
    let dir = Dir::new();
    dir.sh("p.sh.json", Quantity::Visibility, ShVec::from_vec(vec![1.0, 0.25, -3e-9, 1.0 / 3.0]).unwrap());
    let text = String::from_utf8(dir.bytes("p.sh.json")).unwrap();
    let stdout = dir.lobe("sh rotate - --matrix 1,0,0,0,1,0,0,0,1 -o -").stdin(text.clone()).stdout();
    assert_eq!(stdout, text, "turned by nothing");
    assert_eq!(dir.names(), ["p.sh.json"], "files");
}

#[test]
fn quiet_silences_notes_but_not_errors() {
    let dir = Dir::new();
    dir.map("minus.exr", 2, 1, |_, _| [-1.0; 3]);
    for quiet in ["--quiet project", "project -q"] {
        dir.lobe(&format!("{quiet} minus.exr -o p.sh.json")).stdout();
    }
    dir.lobe("project -q none.exr -o p.sh.json").error();
}

#[test]
fn characters_that_turn_text_around_are_escaped_in_messages() {
    let dir = Dir::new();
    let name = "sky\u{202e}rxe.\u{2066}exr";
    let error = dir.lobe("project -o p.sh.json").arg(name).error();
    assert!(error.starts_with("sky\\u{202e}rxe.\\u{2066}exr: "), "{error}");
    dir.map("minus.exr", 2, 1, |_, _| [-1.0; 3]);
    if cfg!(unix) {
        std::fs::rename(dir.path("minus.exr"), dir.path(name)).unwrap();
        let (_, note) = dir.lobe("project -o p.sh.json").arg(name).succeeds();
        assert!(note.starts_with("note: sky\\u{202e}rxe.\\u{2066}exr: "), "{note}");
    }
}

#[test]
fn a_reader_that_goes_away_is_no_error() {
    let dir = Dir::new();
    dir.sh("p.sh.json", Quantity::Radiance, ShVec::constant(2, 1.0));
    for args in ["sh eval - --dir 0,0,1", "sh eval - --json --dir 0,0,1", "sh rotate - --quat 0,0,0,1 -o -"] {
        let mut command = Command::new(env!("CARGO_BIN_EXE_lobe"));
        command.args(args.split(' ')).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().unwrap();
        // The command waits for its input, so the reader is gone before anything is written.
        drop(child.stdout.take());
        child.stdin.take().unwrap().write_all(&dir.bytes("p.sh.json")).unwrap();
        let output = child.wait_with_output().unwrap();
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert_eq!((output.status.code(), stderr.as_str()), (Some(0), ""), "exit code and stderr of lobe {args}");
    }
}

/// Runs `lobe` with a stdout that is closed.
#[cfg(any(target_os = "linux", target_os = "macos"))]
fn closed(dir: &Dir, args: &str) -> std::process::Output {
    let line = format!("exec {} {args} >&-", env!("CARGO_BIN_EXE_lobe"));
    Command::new("sh").args(["-c", &line]).current_dir(dir.path("")).output().unwrap()
}

#[cfg(any(target_os = "linux", target_os = "macos"))]
#[test]
fn a_result_that_a_closed_stdout_would_lose_is_an_error_and_all_else_is_none() {
    let dir = Dir::new();
    dir.sh("p.sh.json", Quantity::Radiance, ShVec::constant(2, 1.0));
    for args in [
        "sh eval p.sh.json --dir 0,0,1",
        "sh eval p.sh.json --json --dir 0,0,1",
        "sh rotate p.sh.json --quat 0,0,0,1 -o -",
        "--help",
        "--version",
        "sh eval --help",
    ] {
        let output = closed(&dir, args);
        let stderr = String::from_utf8(output.stderr).unwrap();
        let said = "lobe: stdout: it is closed, so the result would be lost; open it, or send it to /dev/null\n";
        assert_eq!((output.status.code(), stderr.as_str()), (Some(2), said), "lobe {args}");
    }
    let output = closed(&dir, "sh rotate p.sh.json --quat 0,0,0,1 -o q.sh.json");
    assert_eq!((output.status.code(), output.stderr.as_slice()), (Some(0), &b""[..]), "nothing is printed");
    let output = closed(&dir, "bake built-in:ball --quiet --mode unshadowed --order 1 -o b.glb");
    assert_eq!((output.status.code(), output.stderr.as_slice()), (Some(0), &b""[..]), "a report is a note");
    assert_eq!(dir.read_sh("q.sh.json").coefficients, dir.read_sh("p.sh.json").coefficients, "the file");
}

#[cfg(target_os = "linux")]
#[test]
fn a_stdout_without_room_for_the_result_is_found_before_the_work() {
    let dir = Dir::new();
    let said = "lobe: stdout: no space is left; make room, or write somewhere else\n";
    for args in [
        "bake built-in:ball --json -o b.glb",
        "field built-in:ball --json -o f.safetensors",
        "field built-in:ball -o f.safetensors",
        "spheres built-in:ball --count 4 -o s.safetensors",
        "spheres table -o t.safetensors",
        "demo -o demo",
        "light ambient --order 2 -o -",
    ] {
        let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
        let lobe = env!("CARGO_BIN_EXE_lobe");
        let mut command = Command::new(lobe);
        let command = command.args(args.split(' ')).current_dir(dir.path("")).stdout(full).stderr(Stdio::piped());
        let output = command.output().unwrap();
        assert_eq!(String::from_utf8(output.stderr).unwrap(), said, "lobe {args}");
        let output = closed(&dir, args);
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert!(stderr.starts_with("lobe: stdout: it is closed"), "lobe {args}: {stderr}");
        assert_eq!(dir.names(), [""; 0], "lobe {args}: nothing is done");
    }
    // Room behind the end of a file is asked for, and its length stays.
    let file = std::fs::File::create(dir.path("out.json")).unwrap();
    let args = "light ambient --order 2 -o p.sh.json";
    dir.lobe(args).succeeds();
    let mut command = Command::new(env!("CARGO_BIN_EXE_lobe"));
    let status = command.args(["sh", "info", "p.sh.json", "--json"]).current_dir(dir.path("")).stdout(file).status();
    assert!(status.unwrap().success(), "a file as stdout");
    let text = String::from_utf8(dir.bytes("out.json")).unwrap();
    assert!(text.starts_with('{') && text.ends_with("}\n") && !text.contains('\0'), "{text:?}");
}

#[cfg(target_os = "linux")]
#[test]
fn help_that_has_no_room_is_an_error() {
    for args in ["--help", "--version", "sh eval --help"] {
        let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
        let lobe = env!("CARGO_BIN_EXE_lobe");
        let output = Command::new(lobe).args(args.split(' ')).stdout(full).stderr(Stdio::piped()).output().unwrap();
        let stderr = String::from_utf8(output.stderr).unwrap();
        let said = "lobe: stdout: no space is left; make room, or write somewhere else\n";
        assert_eq!((output.status.code(), stderr.as_str()), (Some(2), said), "lobe {args}");
    }
}
