//! Outputs: files and stdout, their checks, and the quantity of a result.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use anyhow::bail;
use clap::Args;
use lobe::io::{IoError, check_writable, remove_abandoned};
use lobe::sh::expansion::Quantity;
use lobe::sh::sh_json::{ShFile, write_sh_json, write_sh_json_to};
use serde::Serialize;

use crate::run::system::{check_stdout, stdout};

/// A `.sh.json` file to write, or `-` for stdout.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum ShOutput {
    Stdout,
    File(PathBuf),
}

impl From<OsString> for ShOutput {
    fn from(text: OsString) -> Self {
        if text == "-" { Self::Stdout } else { Self::File(text.into()) }
    }
}

impl ShOutput {
    /// Refuses an output that could not be written, before any work is done for it.
    pub(crate) fn check(&self) -> anyhow::Result<()> {
        self.check_as("-o")
    }

    /// [`ShOutput::check`] of the output of another option.
    pub(crate) fn check_as(&self, option: &str) -> anyhow::Result<()> {
        match self {
            Self::Stdout => check_stdout().map_err(stdout_error),
            Self::File(path) => {
                prepare_file(path, NO_INPUTS)?;
                // A device or a pipe has no extension.
                if !has_extension(path, "json") && (path.is_file() || !path.exists()) {
                    bail!("{option}: {}: an expansion is written as .sh.json, or to stdout with -", path.display());
                }
                Ok(())
            }
        }
    }

    /// Writes the expansion.
    pub(crate) fn write(&self, file: &ShFile) -> anyhow::Result<()> {
        match self {
            Self::Stdout => write_sh_json_to(stdout().map_err(stdout_error)?, file, "stdout")?,
            Self::File(path) => write_sh_json(path, file)?,
        }
        Ok(())
    }
}

/// `--quantity`: the name of a result that has none by itself.
#[derive(Args)]
pub(crate) struct QuantityOption {
    /// The quantity that the result is written as: radiance, irradiance, transfer, visibility, log-visibility or function,
    /// which is none of them [default: what the inputs make, if that is one of these]
    #[arg(long, value_name = "QUANTITY", value_parser = str::parse::<Quantity>)]
    quantity: Option<Quantity>,
}

impl QuantityOption {
    /// The quantity asked for, else the one that the inputs make; where they make none, the refusal says what to do.
    pub(crate) fn or(&self, made: Result<Quantity, String>) -> Result<Quantity, String> {
        match self.quantity {
            Some(quantity) => Ok(quantity),
            None => made.map_err(|why| format!("{why}; --quantity names the result whatever it is")),
        }
    }
}

/// For [`prepare_file`], where nothing is read that a file may lie under.
pub(crate) const NO_INPUTS: &[&Path] = &[];

/// Refuses a file that could not be written, or that is one of the inputs, which would be lost. Clears away what killed
/// commands have left in its folder.
pub(crate) fn prepare_file<P: AsRef<Path>>(path: &Path, inputs: &[P]) -> anyhow::Result<()> {
    let output = path.canonicalize();
    if inputs
        .iter()
        .any(|input| matches!((&output, input.as_ref().canonicalize()), (Ok(out), Ok(input)) if *out == input))
    {
        bail!("-o: {} is an input, which would be lost; give another name", path.display());
    }
    check_writable(path).map_err(|source| IoError::Io { place: path.display().to_string(), source })?;
    remove_abandoned(path);
    Ok(())
}

/// [`prepare_file`] of files in a folder, which may be missing: it is made when there is something to put into it.
pub(crate) fn prepare_files<P: AsRef<Path>>(
    folder: &Path,
    names: impl IntoIterator<Item = &'static str>,
    inputs: &[P],
) -> anyhow::Result<()> {
    let is_missing = |folder: &&Path| !folder.as_os_str().is_empty() && !folder.exists();
    match folder.ancestors().take_while(is_missing).last() {
        Some(outermost) => prepare_file(outermost, inputs),
        None => names.into_iter().try_for_each(|name| prepare_file(&folder.join(name), inputs)),
    }
}

/// Whether a file has this extension, in letters of any case.
pub(crate) fn has_extension(path: &Path, extension: &str) -> bool {
    path.extension().is_some_and(|found| found.eq_ignore_ascii_case(extension))
}

/// Refuses another extension than that of safetensors.
pub(crate) fn check_safetensors(path: &Path) -> anyhow::Result<()> {
    if !has_extension(path, "safetensors") {
        bail!("-o: expected a name that ends in .safetensors, found {}", path.display());
    }
    Ok(())
}

/// Refuses another extension than that of PNG.
pub(crate) fn check_png(path: &Path) -> anyhow::Result<()> {
    if !has_extension(path, "png") {
        bail!("-o: expected a name that ends in .png, found {}", path.display());
    }
    Ok(())
}

/// Prints a result on stdout.
pub(crate) fn print(text: &str) -> anyhow::Result<()> {
    let mut stdout = stdout().map_err(stdout_error)?;
    stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()).map_err(stdout_error)
}

/// Prints a result on stdout as one line of JSON.
pub(crate) fn print_json(value: &impl Serialize) -> anyhow::Result<()> {
    print(&(serde_json::to_string(value)? + "\n"))
}

/// Prints results on stdout as one line of JSON, an object with one member.
pub(crate) fn print_json_list(member: &str, results: Vec<impl Serialize>) -> anyhow::Result<()> {
    print_json(&BTreeMap::from([(member, results)]))
}

/// Prints numbers on stdout, those of a place as one line, or all as JSON.
pub(crate) fn print_values(values: Vec<Vec<f64>>, as_json: bool) -> anyhow::Result<()> {
    if as_json {
        return print_json_list("values", values);
    }
    let line = |row: &Vec<f64>| row.iter().map(|x| format!("{x:?}")).collect::<Vec<_>>().join(" ") + "\n";
    print(&values.iter().map(line).collect::<String>())
}

/// The refusal of stdout, in the words of that of a file.
pub(crate) fn stdout_error(source: io::Error) -> anyhow::Error {
    IoError::Io { place: "stdout".to_owned(), source }.into()
}
