//! `bench`: the kernels beside their floors and beside other libraries, all measured here in one run.

use std::process::Command;

use crate::outcome::Outcome;
use crate::{toolchain, workspace};

/// The command, as `cargo build` leaves it: what it computes is checked before peers are measured.
const LOBE: &str = "target/release/lobe";

/// The program that measures, beside it.
const BENCH: &str = "target/release/lobe-bench";

/// The script that runs the program and the peers, and joins their tables.
const SCRIPT: &str = "peers/speed/speed.py";

/// The option that the script has and the program has not; it takes a number.
const ROUNDS: &str = "--rounds";

/// Builds the program and measures the kernels beside their peers; alone where there is no Python.
///
/// Arguments are those of the script: words of jobs, `--rounds`, `--seconds`, `--json`.
pub(crate) fn bench(arguments: &[String]) -> Outcome {
    let build = "build --release --package lobe-cli --package lobe-bench --bins --target-dir target";
    let build: Vec<String> = build.split(' ').map(Into::into).collect();
    run(&workspace::cargo().to_string_lossy(), &build)?;
    let python = toolchain::has_program("python3", "so no peer is measured");
    if let Err(why) = &python {
        eprintln!("{why}");
    }
    let (program, arguments) = measurement(python.is_ok(), arguments);
    run(program, &arguments)
}

/// What is run: the script, or without Python the program, which measures once.
fn measurement(has_python: bool, arguments: &[String]) -> (&'static str, Vec<String>) {
    if has_python {
        let script = [SCRIPT, LOBE].map(Into::into);
        return ("python3", script.into_iter().chain(arguments.iter().cloned()).collect());
    }
    let mut all = Vec::new();
    let mut rest = arguments.iter();
    while let Some(argument) = rest.next() {
        if argument == ROUNDS {
            rest.next();
        } else if !argument.starts_with(&format!("{ROUNDS}=")) {
            all.push(argument.clone());
        }
    }
    (BENCH, all)
}

fn run(program: &str, arguments: &[String]) -> Outcome {
    let status = Command::new(program)
        .args(arguments)
        .current_dir(workspace::root())
        .status()
        .map_err(|error| vec![format!("{program} cannot be started: {error}")])?;
    let failed = || vec![format!("{program} {}: {status}", arguments.join(" "))];
    status.success().then_some(()).ok_or_else(failed)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(has_python: bool, arguments: &str) -> String {
        let arguments: Vec<String> = arguments.split_whitespace().map(Into::into).collect();
        let (program, arguments) = measurement(has_python, &arguments);
        format!("{program} {}", arguments.join(" "))
    }

    #[test]
    fn the_script_is_given_the_command_and_all_arguments() {
        let with_python = line(true, "basis --rounds 2 --json");
        assert_eq!(with_python, "python3 peers/speed/speed.py target/release/lobe basis --rounds 2 --json");
        assert!(workspace::root().join(SCRIPT).is_file(), "{SCRIPT} is there");
    }

    #[test]
    fn without_python_the_program_measures_alone_and_once() {
        for rounds in ["--rounds 2", "--rounds=2", ""] {
            let alone = line(false, &format!("basis {rounds} --seconds 1 --json"));
            assert_eq!(alone, "target/release/lobe-bench basis --seconds 1 --json", "{rounds}");
        }
    }
}
