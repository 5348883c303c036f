//! Failures: their message in one line, and their exit code.

use std::fmt;
use std::io::{self, Write as _};
use std::panic;
use std::process::ExitCode;
use std::sync::Mutex;

use clap::error::ErrorKind;
use lobe::env::{EnvError, MapReadOption};
use lobe::image::{ImageError, ReadOption};
use lobe::io::{IoError, OptionError, one_line};
use lobe::prt::PrtError;
use lobe::render::RenderError;
use lobe::scene::{SceneError, SceneReadOption};
use lobe::sh::ShError;
use lobe::shadow::ShadowError;
use lobe_gallery::GalleryError;

use crate::run::ERROR;
use crate::run::option_names::refusal;
use crate::run::system::stdout;

/// The exit code for "compared and different", and for "looked and found nothing": answers, not errors.
const DIFFERENT: u8 = 1;

/// What was looked for is not there, though all went well; the message says what. The exit code is that of a comparison
/// that finds a difference.
#[derive(Debug)]
pub(crate) struct NotFound(pub(crate) String);

impl fmt::Display for NotFound {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for NotFound {}

/// A reason for which a command fails.
pub(crate) enum Failure {
    /// The compared pictures differ by more than the bound; the result states the difference.
    Different,
    /// An error whose line is printed already.
    Told,
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
            Self::Told => ExitCode::from(ERROR),
            Self::Usage { error, .. } if !error.use_stderr() => {
                // A reader that has gone away has read enough.
                match printed(&error) {
                    Err(refused) if refused.kind() != io::ErrorKind::BrokenPipe => {
                        let words = plain_refusal(&refused).map_or_else(|| refused.to_string(), str::to_owned);
                        say(&format!("stdout: {words}"))
                    }
                    _ => ExitCode::SUCCESS,
                }
            }
            Self::Usage { error, .. } if error.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => {
                let _ = error.print();
                ExitCode::from(ERROR)
            }
            Self::Usage { error, command } => say(&usage_line(&error.render().to_string(), &command)),
            Self::Error(error) if is_broken_pipe(&error) => ExitCode::SUCCESS,
            Self::Error(error) if error.is::<NotFound>() => {
                say(&error.to_string());
                ExitCode::from(DIFFERENT)
            }
            Self::Error(error) => say(&plain(&error)),
        }
    }
}

/// Prints help that was asked for. On a terminal it is styled, which clap does by itself.
fn printed(error: &clap::Error) -> io::Result<()> {
    drop(stdout()?);
    error.print()
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
    if let Some(error) = refused_option(error) {
        return refusal(error);
    }
    let said = match cause(error) {
        Some(Cause::Image(ImageError::Refused { place, message, option })) => {
            Some(format!("{place}: {message}; {}", in_flags(*option)))
        }
        Some(Cause::Map(error)) => of_map(error),
        Some(Cause::Scene(SceneError::Refused { place, message, option })) => Some(match option {
            SceneReadOption::MaxTriangles => format!("{place}: {message}: raise it with --max-triangles"),
            SceneReadOption::MaxTexels => {
                format!("{place}: {message}: make the textures smaller, or raise it with --max-texels")
            }
            _ => format!("{place}: {message}: make the scene smaller, or raise the limit with --max-memory"),
        }),
        Some(Cause::System(place, source)) => plain_refusal(source).map(|words| format!("{place}: {words}")),
        _ => None,
    };
    match (said, error.downcast_ref()) {
        (Some(said), Some(RenderError::Part { name, .. })) => format!("part `{name}`: {said}"),
        (Some(said), _) => said,
        (None, _) => error.to_string(),
    }
}

/// The option of a job that is refused, if that is the fault.
fn refused_option(error: &anyhow::Error) -> Option<&OptionError> {
    macro_rules! refused_by {
        ($($type:ident),*) => {$(
            if let Some($type::OfJob(error)) = error.downcast_ref() {
                return Some(error);
            }
        )*};
    }
    refused_by!(IoError, SceneError, PrtError, ShadowError, RenderError);
    error.downcast_ref()
}

/// The message of a map whose mapping is in doubt.
fn of_map(error: &EnvError) -> Option<String> {
    match error {
        EnvError::UnknownMapping { place, message } => Some(format!(
            "{place}: {message}; say what it is with --from or --fisheye, or what a cropped panorama shows with --vertical-fov"
        )),
        EnvError::Contradiction { place, found, option } => Some(match option {
            MapReadOption::Handedness => {
                format!("--from-left-handed: only of a cube, but {place} is {found}; leave it out")
            }
            MapReadOption::Elevations => {
                format!("--vertical-fov: only of a lat-long picture, but {place} is {found}; leave it out")
            }
            MapReadOption::Faces => format!("--faces: only of a cube, but {place} is {found}; leave it out"),
            MapReadOption::Fisheye => {
                format!("--fisheye: only of a picture that is no map yet, but {place} is {found}; leave it out")
            }
            _ => format!("--from: {place} is {found}; leave the option out"),
        }),
        _ => None,
    }
}

/// Advice on a picture that an option of reading keeps out, where the command has that option.
fn in_flags(option: ReadOption) -> String {
    match option {
        ReadOption::MaxTexels => "scale it down, or raise it with --max-texels".to_owned(),
        ReadOption::MaxBytes => "make it smaller, or raise the limit with --max-memory".to_owned(),
        ReadOption::Nonfinite => "--nonfinite zero reads them as black".to_owned(),
        ReadOption::ToRec709 => "without --to-rec709 the values are taken as they are".to_owned(),
        option => option.to_string(),
    }
}

/// What an error is about, however many crates it has come through.
enum Cause<'a> {
    Map(&'a EnvError),
    Image(&'a ImageError),
    Scene(&'a SceneError),
    /// A file, and what the system says.
    System(&'a str, &'a io::Error),
}

/// The innermost error that the library wraps; none if it is none of those.
fn cause(error: &anyhow::Error) -> Option<Cause<'_>> {
    let found = error.downcast_ref().and_then(of_gallery);
    let found = found.or_else(|| error.downcast_ref().and_then(of_render));
    let found = found.or_else(|| error.downcast_ref().and_then(of_shadow));
    let found = found.or_else(|| error.downcast_ref().and_then(of_prt));
    let found = found.or_else(|| error.downcast_ref().map(of_env));
    let found = found.or_else(|| error.downcast_ref().map(of_scene));
    let found = found.or_else(|| error.downcast_ref().map(of_image));
    let found = found.or_else(|| error.downcast_ref().and_then(of_io));
    found.or_else(|| match error.downcast_ref()? {
        ShError::Io { place, source } => Some(Cause::System(place, source)),
        _ => None,
    })
}

/// Its data are built in, so that only its files can be at fault.
fn of_gallery(error: &GalleryError) -> Option<Cause<'_>> {
    match error {
        GalleryError::Image(error) => Some(of_image(error)),
        GalleryError::Io(error) => of_io(error),
        _ => None,
    }
}

fn of_render(error: &RenderError) -> Option<Cause<'_>> {
    match error {
        RenderError::Image(error) => Some(of_image(error)),
        RenderError::Env(error) => Some(of_env(error)),
        RenderError::Scene(error) => Some(of_scene(error)),
        RenderError::Shadow(error) => of_shadow(error),
        RenderError::Prt(error) => of_prt(error),
        RenderError::Part { source, .. } => of_render(source),
        RenderError::Io(error) => of_io(error),
        _ => None,
    }
}

fn of_shadow(error: &ShadowError) -> Option<Cause<'_>> {
    match error {
        ShadowError::Scene(error) => Some(of_scene(error)),
        ShadowError::Io(error) => of_io(error),
        _ => None,
    }
}

fn of_prt(error: &PrtError) -> Option<Cause<'_>> {
    match error {
        PrtError::Scene(error) => Some(of_scene(error)),
        PrtError::Io(error) => of_io(error),
        _ => None,
    }
}

fn of_env(error: &EnvError) -> Cause<'_> {
    match error {
        EnvError::Image(error) => of_image(error),
        other => Cause::Map(other),
    }
}

fn of_scene(error: &SceneError) -> Cause<'_> {
    match error {
        SceneError::Io { place, source } => Cause::System(place, source),
        other => Cause::Scene(other),
    }
}

fn of_image(error: &ImageError) -> Cause<'_> {
    match error {
        ImageError::Io { place, source } => Cause::System(place, source),
        other => Cause::Image(other),
    }
}

fn of_io(error: &IoError) -> Option<Cause<'_>> {
    match error {
        IoError::Io { place, source } => Some(Cause::System(place, source)),
        _ => None,
    }
}

/// An error of a picture, met alone or on the way to something else.
pub(crate) fn image_error(error: &anyhow::Error) -> Option<&ImageError> {
    match cause(error) {
        Some(Cause::Image(error)) => Some(error),
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
        io::ErrorKind::QuotaExceeded => "the quota of space is used up; make room, or write somewhere else",
        io::ErrorKind::FileTooLarge => {
            "larger than the system lets this program write; raise its limit, or write somewhere else"
        }
        io::ErrorKind::ReadOnlyFilesystem => "nothing can be written here; write somewhere else",
        _ => return None,
    })
}

/// Prints one line on stderr.
fn say(message: &str) -> ExitCode {
    let line = one_line(message);
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
        let missing = || io::Error::from_raw_os_error(2);
        let place = || "a.exr".to_owned();
        let part = RenderError::from(ShadowError::from(IoError::Io { place: place(), source: missing() }));
        let part = RenderError::Part { name: "cat".into(), source: Box::new(part) };
        let nested: [(anyhow::Error, &str); 3] = [
            (part.into(), "part `cat`: "),
            (RenderError::from(SceneError::Io { place: place(), source: missing() }).into(), ""),
            (RenderError::from(PrtError::from(IoError::Io { place: place(), source: missing() })).into(), ""),
        ];
        for (error, before) in nested {
            assert_eq!(
                plain(&error),
                format!("{before}a.exr: no such file; check the name and the folder"),
                "{error:?}"
            );
        }
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
