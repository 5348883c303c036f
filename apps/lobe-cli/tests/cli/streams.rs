//! stdout, stderr, pipes, help.

use std::io::Write as _;
use std::process::{Command, Stdio};

use lobe::sh::{Quantity, ShVec};

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
    for command in [
        "demo",
        "project",
        "sh",
        "sh info",
        "sh eval",
        "sh rotate",
        "sh product",
        "sh convolve",
        "env",
        "env info",
        "env irradiance",
        "env reconstruct",
    ] {
        let help = dir.lobe(&format!("{command} --help")).stdout();
        assert!(help.contains(&format!("Usage: lobe {command} ")), "{command}:\n{help}");
    }
    assert!(dir.lobe("--version").stdout().starts_with("lobe "), "version");
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
