//! Inputs: expansions and pictures from files, stdin and the program itself.

use std::ffi::OsString;
use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

use anyhow::bail;
use clap::Args;
use lobe::env::{EnvError, Nonfinite};
use lobe::image::{FileFormat, ImageError, PictureReadReport, ReadOption};
use lobe::sh::sh_json::{ShFile, read_sh_json, read_sh_json_from};

use crate::args::names::names;
use crate::run::failure::image_error;
use crate::run::talk::Talk;

/// The heading of options of reading, which short help leaves out.
pub(crate) const READING: &str = "Options of reading";

/// The files that are read as environment maps.
pub(crate) fn pictures() -> String {
    FileFormat::names(|_| true)
}

/// The number of bytes at the beginning of a file that are searched for the mark of an expansion.
const HEAD: u64 = 256;

/// A `.sh.json` file, or `-` for stdin.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum ShInput {
    Stdin,
    File(PathBuf),
}

impl From<OsString> for ShInput {
    fn from(text: OsString) -> Self {
        if text == "-" { Self::Stdin } else { Self::File(text.into()) }
    }
}

impl fmt::Display for ShInput {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Stdin => f.write_str("stdin"),
            Self::File(path) => path.display().fmt(f),
        }
    }
}

/// The highest order of functions that are looked at all over the sphere, direction by direction: the number of directions grows
/// with the square of the order, and so does the work in each.
const MOST_SEARCHED: usize = 64;

impl ShInput {
    /// Reads the expansion.
    pub(crate) fn read(&self) -> anyhow::Result<ShFile> {
        Ok(match self {
            Self::Stdin => read_sh_json_from(io::stdin().lock(), "stdin")?,
            Self::File(path) => read_sh_json(path)?,
        })
    }

    /// Reads the expansion, of an order at which the whole sphere can be searched or drawn.
    pub(crate) fn read_to_search(&self) -> anyhow::Result<ShFile> {
        let file = self.read()?;
        let order = file.coefficients.order();
        if order > MOST_SEARCHED {
            bail!(
                "{self}: expected order {MOST_SEARCHED} at most, found {order}: looking at the whole sphere would take \
                 too long; project to fewer bands, or cut them off: lobe sh scale --order N"
            );
        }
        Ok(file)
    }

    /// Reads two expansions, of which one at most can be stdin.
    pub(crate) fn read_two(a: &Self, b: &Self) -> anyhow::Result<(ShFile, ShFile)> {
        Self::check_stdin_once([a, b])?;
        Ok((a.read()?, b.read()?))
    }

    /// Refuses two inputs from stdin.
    pub(crate) fn check_stdin_once<'a>(inputs: impl IntoIterator<Item = &'a Self>) -> anyhow::Result<()> {
        if inputs.into_iter().filter(|input| **input == Self::Stdin).count() > 1 {
            bail!("stdin: two inputs are -, but stdin can be read only once; name a file for one of them");
        }
        Ok(())
    }
}

/// What to do with pixels that are no numbers; shared by all commands that compute with a picture.
#[derive(Args)]
pub(crate) struct NonfiniteOption {
    /// What to do with pixels that are NaN or infinite
    #[arg(long = "nonfinite", value_name = "WHAT", value_enum, default_value = "error")]
    #[arg(help_heading = READING, hide_short_help = true)]
    choice: NonfiniteChoice,
}

impl NonfiniteOption {
    /// The default: refusal.
    pub(crate) fn refuse() -> Self {
        Self { choice: NonfiniteChoice::Error }
    }
}

names! {
    /// What to do with pixels that are no numbers.
    enum NonfiniteChoice for Nonfinite {
        /// Read them as black, and say how many there are
        Zero,
        /// Refuse the file
        Error,
    }
}

impl From<&NonfiniteOption> for Nonfinite {
    fn from(option: &NonfiniteOption) -> Self {
        option.choice.into()
    }
}

/// The error of a file that is no picture, in the words of the command.
pub(crate) fn explain(path: &Path, error: EnvError) -> anyhow::Error {
    if holds_expansion(path) {
        return anyhow::anyhow!(
            "{}: expected a picture ({}), found an expansion; make a picture of it with lobe env reconstruct",
            path.display(),
            pictures()
        );
    }
    error.into()
}

/// What to do with a picture that is no map yet, where no option says how it shows the surroundings.
const MAKE_A_MAP: &str =
    "make a map of it first: lobe env convert PHOTO --fisheye ... -o sky.exr, or with --from or --vertical-fov";

/// A refusal of a picture that is too large, has texels which are no numbers, or is no map yet, in a command without options for that,
/// and what to do instead of the first two.
pub(crate) fn without_options(error: anyhow::Error, [too_large, nonfinite]: [&str; 2]) -> anyhow::Error {
    if let Some(EnvError::UnknownMapping { place, message }) = error.downcast_ref() {
        return anyhow::anyhow!("{place}: {message}; {MAKE_A_MAP}");
    }
    match image_error(&error) {
        Some(ImageError::Refused { place, message, option: ReadOption::MaxTexels }) => {
            anyhow::anyhow!("{place}: {message}; {too_large}")
        }
        Some(ImageError::Refused { place, message, option: ReadOption::MaxBytes }) => {
            anyhow::anyhow!("{place}: {message}; {too_large}, or raise the limit with --max-memory")
        }
        Some(ImageError::Refused { place, message, option: ReadOption::Nonfinite }) => {
            anyhow::anyhow!("{place}: {message}; {nonfinite}")
        }
        _ => error,
    }
}

/// Whether a file begins like a `.sh.json` file.
fn holds_expansion(path: &Path) -> bool {
    use std::io::Read as _;
    let mut head = Vec::new();
    let read = std::fs::File::open(path).and_then(|file| file.take(HEAD).read_to_end(&mut head));
    read.is_ok() && head.windows(9).any(|window| window == b"\"lobe-sh\"")
}

/// Notes the findings of reading a file.
pub(crate) fn tell(report: &PictureReadReport, name: &str, talk: Talk) {
    let findings = report.findings();
    for (k, finding) in findings.iter().enumerate() {
        // The last one is of negative texels, if there are any.
        let is_negative = report.negative > 0 && k + 1 == findings.len();
        let advice = if is_negative { " (lobe env adjust --non-negative makes them black)" } else { "" };
        talk.note(name, &format!("{finding}{advice}"));
    }
}

/// "1 texel is", "2 texels are".
pub(crate) fn texels_are(count: usize) -> String {
    if count == 1 { "1 texel is".to_owned() } else { format!("{count} texels are") }
}
