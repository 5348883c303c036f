//! Steps of a chore, run one after the other, each with its time.

use std::ffi::OsStr;
use std::process::Command;
use std::time::Instant;

use crate::outcome::Outcome;
use crate::workspace;

/// The work of a step.
#[derive(Clone, Copy)]
pub(crate) enum Work {
    /// A cargo command, and what it adds to the environment.
    Cargo(&'static str, &'static [(&'static str, &'static str)]),
    /// A program and its arguments that need something of the machine: run where that is there, skipped with the reason
    /// where it is not.
    Where(fn() -> Result<(), String>, &'static str, &'static str),
    /// A program that is not part of Rust, its arguments, and how to get it. Continuous integration has all of them;
    /// elsewhere the step is skipped without it.
    Tool(&'static str, &'static str, &'static str),
    /// A chore of this program.
    Chore(fn() -> Outcome),
    /// A chore that needs something of the machine, as with [`Work::Where`].
    ChoreWhere(fn() -> Result<(), String>, fn() -> Outcome),
}

/// The end of a step that found no fault.
enum Passed {
    Whole,
    /// Not run, for this reason.
    Skipped(String),
}

/// A named piece of a longer chore.
#[derive(Clone, Copy)]
pub(crate) struct Step {
    pub(crate) name: &'static str,
    pub(crate) work: Work,
}

/// Runs every step, even after one that failed, and prints the time each took: one run shows all faults.
pub(crate) fn run_all(steps: &[Step]) -> Outcome {
    let start = Instant::now();
    let mut summary = String::new();
    let mut faults = Vec::new();
    let mut skipped = 0;
    for step in steps {
        println!("==> {}{}", step.name, step.command());
        let step_start = Instant::now();
        let outcome = step.run();
        let verdict = match &outcome {
            Ok(Passed::Whole) => "passed",
            Ok(Passed::Skipped(reason)) => {
                println!("SKIPPED {}: {reason}", step.name);
                skipped += 1;
                "skipped"
            }
            Err(_) => "FAILED",
        };
        let seconds = step_start.elapsed().as_secs_f64();
        println!("<== {} {verdict} after {seconds:.1} s", step.name);
        summary += &format!("{:<14} {verdict:<7} {seconds:7.1} s\n", step.name);
        faults.extend(outcome.err().into_iter().flatten().map(|fault| format!("{}: {fault}", step.name)));
    }
    let seconds = start.elapsed().as_secs_f64();
    println!("\n{summary}{:<14} {:7} {seconds:7.1} s, {skipped} skipped", "all", "");
    if faults.is_empty() { Ok(()) } else { Err(faults) }
}

impl Step {
    /// The command line that runs a cargo step alone.
    fn command(&self) -> String {
        match self.work {
            Work::Cargo(arguments, environment) => {
                let environment: String =
                    environment.iter().map(|(name, value)| format!("{name}='{value}' ")).collect();
                format!(": {environment}cargo {arguments}")
            }
            Work::Where(_, program, arguments) | Work::Tool(program, arguments, _) => {
                format!(": {program} {arguments}")
            }
            Work::Chore(_) | Work::ChoreWhere(..) => format!(": cargo xtask {}", self.name),
        }
    }

    fn run(&self) -> Result<Passed, Vec<String>> {
        match self.work {
            Work::Chore(chore) => chore().map(|()| Passed::Whole),
            Work::ChoreWhere(is_there, chore) => match is_there() {
                Ok(()) => chore().map(|()| Passed::Whole),
                Err(reason) => Ok(Passed::Skipped(reason)),
            },
            Work::Cargo(arguments, environment) => command(&workspace::cargo(), arguments, environment),
            Work::Where(is_there, program, arguments) => match is_there() {
                Ok(()) => command(program.as_ref(), arguments, &[]),
                Err(reason) => Ok(Passed::Skipped(reason)),
            },
            Work::Tool(program, arguments, how_to_get_it) => match Command::new(program).arg("--version").output() {
                Ok(_) => command(program.as_ref(), arguments, &[]),
                Err(_) if std::env::var_os("CI").is_none() => {
                    Ok(Passed::Skipped(format!("{program} is not installed; {how_to_get_it}")))
                }
                Err(error) => Err(vec![format!("{program} did not start: {error}; {how_to_get_it}")]),
            },
        }
    }
}

/// Runs a program at the root of the repository.
fn command(program: &OsStr, arguments: &str, environment: &[(&str, &str)]) -> Result<Passed, Vec<String>> {
    let name = program.to_string_lossy();
    let status = Command::new(program)
        .args(arguments.split_whitespace())
        .envs(environment.iter().copied())
        .current_dir(workspace::root())
        .status()
        .map_err(|error| vec![format!("{name} did not start: {error}")])?;
    if status.success() { Ok(Passed::Whole) } else { Err(vec![format!("`{name} {arguments}` failed ({status})")]) }
}
