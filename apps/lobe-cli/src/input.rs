//! Where expansions and pictures come from.

use std::ffi::OsString;
use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

use anyhow::bail;
use clap::Args;
use lobe::env::{EnvMap, Nonfinite, ReadOptions, ReadReport, bundled, read_env, read_env_bytes};
use lobe::sh::{ShFile, load_sh_json, read_sh_json};

use crate::talk::Talk;
use crate::values;

/// The pictures that are read as lat-long maps.
const PICTURES: &str = ".hdr, .exr, .pfm, .png or .jpg";

/// 256 K x 128 K: more than any picture has; asking for more is a slip of the finger.
const MOST_TEXELS: usize = 1 << 35;

/// What stands before the name of a map that is part of the program.
const BUNDLED: &str = "bundled:";

/// How many bytes at the beginning of a file show that it is an expansion.
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

impl ShInput {
    /// Reads the expansion.
    pub(crate) fn read(&self) -> anyhow::Result<ShFile> {
        Ok(match self {
            Self::Stdin => read_sh_json(io::stdin().lock(), "stdin")?,
            Self::File(path) => load_sh_json(path)?,
        })
    }

    /// Reads two expansions, of which one at most can be stdin.
    pub(crate) fn read_two(a: &Self, b: &Self) -> anyhow::Result<(ShFile, ShFile)> {
        if *a == Self::Stdin && *b == Self::Stdin {
            bail!("stdin: both inputs are -, but stdin can be read only once; name a file for one of them");
        }
        Ok((a.read()?, b.read()?))
    }
}

/// An environment map in a file or, for `bundled:NAME`, in the program; shared by all commands that read one.
#[derive(Args)]
pub(crate) struct MapInput {
    /// The environment map: a lat-long .hdr, .exr, .pfm, .png or .jpg file, twice as wide as high, or bundled:NAME
    #[arg(value_name = "IN")]
    path: PathBuf,
    /// The most pixels that a picture may have; one that says it has more is refused. Each takes 12 bytes of memory, and up
    /// to as much again while a .hdr, .png or .jpg is decoded: 3.2 GB for the most that is read without this option
    #[arg(long, value_name = "N", default_value_t = ReadOptions::default().max_texels, value_parser = max_texels)]
    max_texels: usize,
}

fn max_texels(text: &str) -> Result<usize, String> {
    values::whole(text, 1, MOST_TEXELS, "a number of pixels")
}

impl fmt::Display for MapInput {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.path.display().fmt(f)
    }
}

impl MapInput {
    /// Reads the map, and tells what was found remarkable.
    pub(crate) fn read(&self, nonfinite: Nonfinite, talk: Talk) -> anyhow::Result<(EnvMap, ReadReport)> {
        let options = ReadOptions { nonfinite, max_texels: self.max_texels };
        let name = self.to_string();
        let (map, report) = match name.strip_prefix(BUNDLED) {
            Some(bundled_name) => read_bundled(bundled_name, &options)?,
            None if name == "-" => bail!("-: pictures are read from files, not from stdin; name a {PICTURES} file"),
            None => read_env(&self.path, &options).map_err(|error| match holds_expansion(&self.path) {
                true => anyhow::anyhow!(
                    "{name}: expected a {PICTURES} picture, found an expansion; make a picture of it with \
                     lobe env reconstruct"
                ),
                false => error.into(),
            })?,
        };
        tell(&report, &name, talk);
        Ok((map, report))
    }
}

fn read_bundled(name: &str, options: &ReadOptions) -> anyhow::Result<(EnvMap, ReadReport)> {
    let Some(found) = bundled::all().into_iter().find(|map| map.name == name) else {
        let known = bundled::all().map(|map| format!("{BUNDLED}{}", map.name)).join(" or ");
        bail!("{BUNDLED}{name}: there is no such map in the program; there is {known}");
    };
    Ok(read_env_bytes(found.bytes, found.name, options)?)
}

/// Whether a file begins like a `.sh.json` file.
fn holds_expansion(path: &Path) -> bool {
    use std::io::Read as _;
    let mut head = Vec::new();
    let read = std::fs::File::open(path).and_then(|file| file.take(HEAD).read_to_end(&mut head));
    read.is_ok() && head.windows(9).any(|window| window == b"\"lobe-sh\"")
}

fn tell(report: &ReadReport, name: &str, talk: Talk) {
    for note in &report.notes {
        talk.note(name, note);
    }
    if let Some((x, y)) = report.first_nonfinite {
        let texels = texels_are(report.nonfinite);
        talk.note(name, &format!("{texels} NaN or infinite, first at column {x}, row {y}; read as black"));
    }
    if report.negative > 0 {
        talk.note(name, &format!("{} negative in some channel; kept as they are", texels_are(report.negative)));
    }
}

/// "1 texel is", "2 texels are".
pub(crate) fn texels_are(count: usize) -> String {
    if count == 1 { "1 texel is".to_owned() } else { format!("{count} texels are") }
}
