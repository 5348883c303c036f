//! Failures: their message in one line, and their exit code.

use std::io::{self, Write as _};
use std::panic;
use std::process::ExitCode;
use std::sync::Mutex;

use clap::error::ErrorKind;
use lobe::env::{EnvError, MapReadOption};
use lobe::image::{ImageError, ReadOption};
use lobe::io::IoError;
use lobe::prt::PrtError;
use lobe::render::RenderError;
use lobe::scene::{SceneError, SceneReadOption};
use lobe::sh::ShError;

/// The exit code for "compared and different".
const DIFFERENT: u8 = 1;

/// The exit code for every error, and for work that was stopped by Ctrl-C.
pub(crate) const ERROR: u8 = 2;

/// A reason for which a command fails.
pub(crate) enum Failure {
    /// The compared pictures differ by more than the bound; the result states the difference.
    Different,
    /// An error of ours, to be shown as one line.
    Error(anyhow::Error),
    /// A message of the parser of the command line: an error, or help that was asked for.
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
            Self::Different => ExitCode::from(DIFFERENT),
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
            Self::Error(error) => say(&plain(&error)),
        }
    }
}

/// The message of the last panic, and its place.
static LAST_PANIC: Mutex<String> = Mutex::new(String::new());

/// Panics print nothing by themselves: decoders of pictures panic on damaged files, which their callers catch and say
/// in one line. What nobody caught is said by [`report_panic`].
pub(crate) fn keep_panics_quiet() {
    panic::set_hook(Box::new(|info| {
        let said = info.payload_as_str().unwrap_or("no message");
        let place = info.location().map_or(String::new(), |at| format!(" at {}:{}", at.file(), at.line()));
        if let Ok(mut last) = LAST_PANIC.lock() {
            *last = format!("{said}{place}");
        }
    }));
}

/// Tells the user that the program is wrong, not what was given to it.
pub(crate) fn report_panic() -> ExitCode {
    let last = LAST_PANIC.lock().map(|last| last.clone()).unwrap_or_default();
    say(&format!("a fault of this program, please report it: {last}"))
}

/// The message of an error; what the system says about files that everybody meets is said in plain words, and what the
/// options of reading keep out by the names that they have here.
fn plain(error: &anyhow::Error) -> String {
    if let Some(ImageError::Refused { place, message, option }) = image_error(error) {
        return format!("{place}: {message}; {}", in_flags(*option));
    }
    if let Some(EnvError::UnknownMapping { place, message }) = error.downcast_ref() {
        return format!(
            "{place}: {message}; say what it is with --from, or what a cropped panorama shows with --vertical-fov"
        );
    }
    if let Some(EnvError::Contradiction { place, found, option }) = error.downcast_ref() {
        return match option {
            MapReadOption::Handedness => {
                format!("--from-left-handed: only of a cube, but {place} is {found}; leave it out")
            }
            MapReadOption::Elevations => {
                format!("--vertical-fov: only of a lat-long picture, but {place} is {found}; leave it out")
            }
            _ => format!("--from: {place} is {found}; leave the option out"),
        };
    }
    let scene = match prt_error(error) {
        Some(PrtError::Scene(scene)) => Some(scene),
        _ => error.downcast_ref(),
    };
    if let Some(SceneError::Refused { place, message, option }) = scene {
        return match option {
            SceneReadOption::MaxTriangles => format!("{place}: {message}: raise it with --max-triangles"),
            SceneReadOption::MaxTexels => {
                format!("{place}: {message}: make the textures smaller, or raise it with --max-texels")
            }
            _ => format!("{place}: {message}: make the scene smaller, or raise the limit with --max-memory"),
        };
    }
    match refusal_of_system(error).and_then(|(file, source)| Some(format!("{file}: {}", plain_refusal(source)?))) {
        Some(message) => message,
        None => error.to_string(),
    }
}

/// Advice on a picture that an option of reading keeps out, where the command has that option.
fn in_flags(option: ReadOption) -> String {
    match option {
        ReadOption::MaxTexels => "scale it down, or raise it with --max-texels".to_owned(),
        ReadOption::Nonfinite => "--nonfinite zero reads them as black".to_owned(),
        option => option.to_string(),
    }
}

/// An error of a picture, met alone or as that of a map.
pub(crate) fn image_error(error: &anyhow::Error) -> Option<&ImageError> {
    match error.downcast_ref() {
        Some(EnvError::Image(image)) => Some(image),
        _ => match error.downcast_ref() {
            Some(RenderError::Image(image)) => Some(image),
            _ => error.downcast_ref(),
        },
    }
}

/// An error of transfer, met alone or on the way to a picture.
fn prt_error(error: &anyhow::Error) -> Option<&PrtError> {
    match error.downcast_ref() {
        Some(RenderError::Prt(error)) => Some(error),
        _ => error.downcast_ref(),
    }
}

/// The file and the refusal, if an error is one of the system.
fn refusal_of_system(error: &anyhow::Error) -> Option<(&str, &io::Error)> {
    if let Some(ImageError::Io { place, source }) = image_error(error) {
        return Some((place, source));
    }
    if let Some(RenderError::Io { place, source }) = error.downcast_ref() {
        return Some((place, source));
    }
    if let Some(IoError::Io { place, source }) = error.downcast_ref() {
        return Some((place, source));
    }
    if let Some(ShError::Io { place, source }) = error.downcast_ref() {
        return Some((place, source));
    }
    match (prt_error(error), error.downcast_ref()) {
        (Some(PrtError::Io { place: file, source }), _)
        | (Some(PrtError::Scene(SceneError::Io { place: file, source })), _)
        | (_, Some(SceneError::Io { place: file, source })) => Some((file, source)),
        _ => None,
    }
}

/// Plain words for common errors of the operating system; none for those with a message of Lobe.
fn plain_refusal(refusal: &io::Error) -> Option<&'static str> {
    refusal.raw_os_error()?;
    Some(match refusal.kind() {
        io::ErrorKind::NotFound => "no such file; check the name and the folder",
        io::ErrorKind::PermissionDenied => "not permitted; check who may read and write it",
        io::ErrorKind::IsADirectory => "this is a folder; give the name of a file",
        io::ErrorKind::NotADirectory => "no such file: what stands for a folder in its name is a file",
        io::ErrorKind::StorageFull => "no space is left; make room, or write somewhere else",
        io::ErrorKind::ReadOnlyFilesystem => "nothing can be written here; write somewhere else",
        _ => return None,
    })
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
    fn refusals_of_the_system_are_said_in_plain_words() {
        let said = |source: io::Error| plain(&ImageError::Io { place: "a.exr".into(), source }.into());
        assert_eq!(
            said(io::Error::from_raw_os_error(2)),
            "a.exr: no such file; check the name and the folder",
            "missing"
        );
        let unknown = io::Error::from_raw_os_error(71);
        assert_eq!(said(io::Error::from_raw_os_error(71)), format!("a.exr: {unknown}"), "as the system gives it");
        let ours = io::Error::new(io::ErrorKind::NotFound, "the folder b does not exist; make it first");
        assert_eq!(said(ours), "a.exr: the folder b does not exist; make it first", "a message of ours");
        let other = plain(&anyhow::anyhow!("stdin: closed"));
        assert_eq!(other, "stdin: closed", "no file");
    }

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
