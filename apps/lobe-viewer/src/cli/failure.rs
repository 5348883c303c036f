//! Failures: one line, and the exit code of errors; and notes of what went well.

use std::process::ExitCode;

use lobe::io::one_line;

/// The exit code of every error, as of the command `lobe`.
const ERROR: u8 = 2;

/// Says an error in one line.
pub(crate) fn say(message: &str) -> ExitCode {
    let line = message.lines().map(str::trim).filter(|line| !line.is_empty()).collect::<Vec<_>>().join(": ");
    eprintln!("lobe-viewer: {}", one_line(&line));
    ExitCode::from(ERROR)
}

/// Says what is no failure, where it is not mistaken for what was asked for.
pub(crate) fn note(message: &str) {
    eprintln!("note: {}", one_line(message));
}

/// What the parser of the command line has to say: help, or what is wrong in one line.
pub(crate) fn usage(error: &clap::Error) -> ExitCode {
    if !error.use_stderr() {
        // If help cannot be shown, nobody is there to be told.
        drop(error.print());
        return ExitCode::SUCCESS;
    }
    let text = error.render().to_string();
    let told = text.split("\n\n").next().unwrap_or_default();
    say(&format!("{}; see lobe-viewer --help", told.trim_start_matches("error: ").trim_end_matches('.')))
}
