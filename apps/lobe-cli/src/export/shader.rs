//! `lobe export shader`: functions for shaders as text, or as SPIR-V.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{anyhow, bail};
use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use lobe::io::write_atomically;
use lobe::shaders::{ShaderError, ShaderFunction, ShaderLanguage, shader_text};

use crate::args::output;

/// The name that stands for all functions.
const ALL: &str = "all";

/// The name of a file of several functions, without its ending.
const FILE: &str = "lobe";

const EXAMPLES: &str = "\
Examples:
  lobe export shader                                      the functions, and what they compute
  lobe export shader packed_irradiance_eval --lang glsl   irradiance from seven vectors
  lobe export shader all --lang hlsl -o lobe.hlsl         all of them, to include
  lobe export shader zh3_eval --lang wgsl,glsl -o .       ./lobe.wgsl and ./lobe.glsl
  lobe export shader ahd_eval --lang spirv -o ahd.spv     a compute program for Vulkan

Functions take coefficients as .sh.json has them, and the numbers of lobe sh encode. Vectors
are unit vectors in Lobe's frame, +z up; those of h_basis and hl2 in the frame of the surface.
The text has no entry point, binding or #version. A .spv reads rows of numbers from storage
buffer 0, all arguments of a call one after the other. It writes rows of results to storage
buffer 1. Its entry point is main, and a workgroup has 64 rows.";

#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct ExportShader {
    /// The functions, or all; what they need comes along. Without one the command lists them
    #[arg(value_name = "FUNCTION", value_parser = function(), requires = "lang", hide_possible_values = true)]
    functions: Vec<Functions>,
    /// The languages, with commas between them
    #[arg(long, value_name = "LANG[,LANG..]", requires = "functions", value_delimiter = ',', value_parser = language())]
    lang: Vec<ShaderLanguage>,
    /// The file; a folder for several languages, or for SPIR-V of several functions, which are a file each [default:
    /// stdout]
    #[arg(short, long, value_name = "OUT", requires = "functions")]
    output: Option<PathBuf>,
}

/// A function, or all.
#[derive(Clone, Copy, Debug)]
enum Functions {
    One(&'static ShaderFunction),
    All,
}

fn function() -> impl TypedValueParser<Value = Functions> {
    let known = ShaderFunction::ALL.iter().map(|function| PossibleValue::new(function.name).help(function.summary));
    PossibleValuesParser::new(known.chain([PossibleValue::new(ALL).help("All of them")]))
        .try_map(|name| if name == ALL { Ok(Functions::All) } else { ShaderFunction::find(&name).map(Functions::One) })
}

fn language() -> impl TypedValueParser<Value = ShaderLanguage> {
    let known = ShaderLanguage::ALL.map(|language| PossibleValue::new(language.name()).help(language.description()));
    PossibleValuesParser::new(known).try_map(|name| name.parse())
}

impl ExportShader {
    pub(crate) fn run(&self) -> anyhow::Result<()> {
        let functions = self.functions();
        if functions.is_empty() {
            return output::print(&list());
        }
        let files = self.files(&functions)?;
        let Some(path) = &self.output else {
            let is_text = !self.lang.contains(&ShaderLanguage::Spirv);
            return match &files[..] {
                [(_, bytes)] if is_text => output::print(std::str::from_utf8(bytes)?),
                _ => bail!("expected one language with text for stdout; name a file or a folder with -o"),
            };
        };
        match &files[..] {
            [(_, bytes)] if !is_folder(path) => write(path, bytes),
            _ if path.is_file() => {
                bail!("-o: {} is a file, and there are {} to write; name a folder", path.display(), files.len())
            }
            _ => {
                fs::create_dir_all(path).map_err(|error| anyhow!("{}: cannot be made: {error}", path.display()))?;
                files.iter().try_for_each(|(name, bytes)| write(&path.join(name), bytes))
            }
        }
    }

    /// The functions, each once, in the order of the command line.
    fn functions(&self) -> Vec<&'static ShaderFunction> {
        let mut seen = BTreeSet::new();
        let all = self.functions.iter().flat_map(|function| match function {
            Functions::One(function) => std::slice::from_ref(*function),
            Functions::All => ShaderFunction::ALL,
        });
        all.filter(|function| seen.insert(function.name)).collect()
    }

    /// The names of the files in a folder, and what they hold.
    fn files(&self, functions: &[&'static ShaderFunction]) -> Result<Vec<(String, Vec<u8>)>, ShaderError> {
        let mut files = Vec::new();
        let mut seen = BTreeSet::new();
        for language in self.lang.iter().filter(|language| seen.insert(language.name())) {
            let ending = language.extension();
            if *language == ShaderLanguage::Spirv {
                files.extend(functions.iter().map(|one| (format!("{}.{ending}", one.name), one.spirv().to_vec())));
            } else {
                files.push((format!("{FILE}.{ending}"), shader_text(*language, functions)?.into_bytes()));
            }
        }
        Ok(files)
    }
}

/// The functions, one a line.
fn list() -> String {
    let width = ShaderFunction::ALL.iter().map(|function| function.name.len()).max().unwrap_or(0);
    ShaderFunction::ALL.iter().map(|function| format!("{:width$}  {}\n", function.name, function.summary)).collect()
}

fn is_folder(path: &Path) -> bool {
    path.is_dir() || path.to_string_lossy().ends_with(std::path::is_separator)
}

fn write(path: &Path, bytes: &[u8]) -> anyhow::Result<()> {
    output::prepare_file(path, output::NO_INPUTS)?;
    write_atomically(path, |file| file.write_all(bytes))
        .map_err(|error| anyhow!("{}: cannot be written: {error}", path.display()))
}
