//! How a command ends when it does not succeed.

use std::io::{self, Write as _};
use std::process::ExitCode;

use clap::error::ErrorKind;

/// The exit code for every error; 1 is kept for "compared and different".
const ERROR: u8 = 2;

/// Why a command stops.
pub(crate) enum Failure {
    /// An error of ours, to be shown as one line.
    Error(anyhow::Error),
    /// What the parser of the command line has to say: an error, or help that was asked for.
    Usage {
        error: Box<clap::Error>,
        /// The command whose help explains it, such as `lobe sh eval`.
        command: String,
    },
}

impl From<anyhow::Error> for Failure {
    fn from(error: anyhow::Error) -> Self {
        Self::Error(error)
    }
}

impl Failure {
    /// Tells the user, and says how to exit. A reader that has gone away is no error.
    pub(crate) fn report(self) -> ExitCode {
        match self {
            Self::Usage { error, .. } if !error.use_stderr() => {
                // If help cannot be shown, nobody is there to be told.
                let _ = error.print();
                ExitCode::SUCCESS
            }
            Self::Usage { error, .. } if error.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => {
                let _ = error.print();
                ExitCode::from(ERROR)
            }
            Self::Usage { error, command } => say(&usage_line(&error.render().to_string(), &command)),
            Self::Error(error) if is_broken_pipe(&error) => ExitCode::SUCCESS,
            Self::Error(error) => say(&error.to_string()),
        }
    }
}

/// Prints one line on stderr.
fn say(message: &str) -> ExitCode {
    let line: String = message.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    // If stderr is closed, the exit code still says it.
    let _ = writeln!(io::stderr(), "lobe: {line}");
    ExitCode::from(ERROR)
}

fn is_broken_pipe(error: &anyhow::Error) -> bool {
    let broken = |e: &io::Error| e.kind() == io::ErrorKind::BrokenPipe;
    error.chain().any(|cause| cause.downcast_ref::<io::Error>().is_some_and(broken))
}

/// The parser's message of several paragraphs as one line that ends in where to look.
fn usage_line(text: &str, command: &str) -> String {
    let mut said = Vec::new();
    for line in text.lines().map(str::trim).filter(|line| !line.is_empty()) {
        if line.starts_with("Usage: ") || line.starts_with("For more information") {
            break;
        }
        let line = line.strip_prefix("error: ").unwrap_or(line);
        match line.strip_prefix("tip: ") {
            // That a word may be a file's name is true and never what was meant.
            Some(tip) if tip.starts_with("to pass") => {}
            Some(tip) => said.push(format!("({tip})")),
            None => said.push(line.to_owned()),
        }
    }
    format!("{}; see {command} --help", said.join(" "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn usage_errors_become_one_line() {
        let text = "error: unexpected argument '--dirr' found\n\n  tip: a similar argument exists: '--dir'\n\n\
                    Usage: lobe sh eval --dir <X,Y,Z> <P>\n\nFor more information, try '--help'.\n";
        let line = "unexpected argument '--dirr' found (a similar argument exists: '--dir'); see lobe sh eval --help";
        assert_eq!(usage_line(text, "lobe sh eval"), line, "with usage");
        let text = "error: invalid value 'x' for '--order <N>': not a number\n\nFor more information, try '--help'.\n";
        let line = "invalid value 'x' for '--order <N>': not a number; see lobe project --help";
        assert_eq!(usage_line(text, "lobe project"), line, "without usage");
    }
}
