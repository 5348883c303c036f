//! Steps run one after the other, each with its time.

use std::process::Command;
use std::time::Instant;

use crate::outcome::Outcome;
use crate::workspace;

/// What a step does.
pub(crate) enum Work {
    /// A cargo command, and what it adds to the environment.
    Cargo(&'static str, &'static [(&'static str, &'static str)]),
    /// A chore of this program.
    Chore(fn() -> Outcome),
}

/// A named piece of a longer chore.
pub(crate) struct Step {
    pub(crate) name: &'static str,
    pub(crate) work: Work,
}

/// Runs every step, even after one that failed, and prints the time each took: one run shows all faults.
pub(crate) fn run_all(steps: &[Step]) -> Outcome {
    let start = Instant::now();
    let mut summary = String::new();
    let mut faults = Vec::new();
    for step in steps {
        println!("==> {}{}", step.name, step.command());
        let step_start = Instant::now();
        let outcome = step.run();
        let verdict = if outcome.is_ok() { "passed" } else { "FAILED" };
        let seconds = step_start.elapsed().as_secs_f64();
        println!("<== {} {verdict} after {seconds:.1} s", step.name);
        summary += &format!("{:<14} {verdict} {seconds:7.1} s\n", step.name);
        faults.extend(outcome.err().into_iter().flatten().map(|fault| format!("{}: {fault}", step.name)));
    }
    let seconds = start.elapsed().as_secs_f64();
    println!("\n{summary}{:<14} {:6} {seconds:7.1} s", "all", "");
    if faults.is_empty() { Ok(()) } else { Err(faults) }
}

impl Step {
    /// What to type to run a cargo step alone.
    fn command(&self) -> String {
        match self.work {
            Work::Cargo(arguments, environment) => {
                let environment: String =
                    environment.iter().map(|(name, value)| format!("{name}='{value}' ")).collect();
                format!(": {environment}cargo {arguments}")
            }
            Work::Chore(_) => format!(": cargo xtask {}", self.name),
        }
    }

    fn run(&self) -> Outcome {
        match self.work {
            Work::Chore(chore) => chore(),
            Work::Cargo(arguments, environment) => {
                let status = Command::new(workspace::cargo())
                    .args(arguments.split_whitespace())
                    .envs(environment.iter().copied())
                    .current_dir(workspace::root())
                    .status()
                    .map_err(|error| vec![format!("cargo did not start: {error}")])?;
                if status.success() { Ok(()) } else { Err(vec![format!("`cargo {arguments}` failed ({status})")]) }
            }
        }
    }
}
