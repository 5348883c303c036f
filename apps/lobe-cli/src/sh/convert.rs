//! `lobe sh convert`: coefficients as the libraries of the sciences keep them.

use std::path::{Path, PathBuf};

use anyhow::{anyhow, bail};
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{ArgGroup, Args};
use lobe::io::{IoError, write_atomically};
use lobe::sh::convention::NamedConvention;
use lobe::sh::expansion::Quantity;
use lobe::sh::sh_json::{FileCoefficients, ShFile};

use crate::args::input::ShInput;
use crate::args::number_file::{Kind, array_of, bytes_of, text};
use crate::args::output::{ShOutput, prepare_file, print};

#[derive(Args)]
#[command(group = ArgGroup::new("way").required(true))]
pub(crate) struct ShConvert {
    /// With --to an expansion, a .sh.json file. With --from the numbers of a library: .npy (real or complex, of 4 or 8
    /// bytes); JSON, nested lists in the library's shape with [re, im] for complex numbers; or text, a number on each
    /// line, complex ones as "re im" or "re+imj". - reads stdin
    #[arg(value_name = "FILE")]
    input: PathBuf,
    /// The library that gets the numbers. For engines there is lobe sh encode --as
    #[arg(long, value_name = "NAME", value_parser = convention(), group = "way")]
    to: Option<&'static NamedConvention>,
    /// The library whose numbers they are. For engines there is lobe import
    #[arg(long, value_name = "NAME", value_parser = convention(), group = "way")]
    from: Option<&'static NamedConvention>,
    /// The quantity of numbers that are read: radiance, irradiance, transfer, visibility, log-visibility or function
    /// [default: radiance]
    #[arg(long, value_name = "QUANTITY", value_parser = str::parse::<Quantity>, conflicts_with = "to")]
    quantity: Option<Quantity>,
    /// With --to .npy, .json or .txt, in the library's own shape, where colors have a first axis of three [default:
    /// text on stdout]. With --from a .sh.json file; - writes to stdout
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

/// Reads a convention by its name; help pages list all of them.
fn convention() -> impl TypedValueParser<Value = &'static NamedConvention> {
    let known = NamedConvention::ALL.iter().map(|named| {
        PossibleValue::new(named.name()).help(format!("{}; tried with {}", named.description(), named.tried()))
    });
    PossibleValuesParser::new(known).try_map(|name| NamedConvention::find(&name))
}

impl ShConvert {
    pub(crate) fn run(&self) -> anyhow::Result<()> {
        match (self.to, self.from) {
            (Some(to), _) => self.write(to),
            (_, Some(from)) => self.read(from),
            (None, None) => bail!("expected --to or --from with the name of a library"),
        }
    }

    /// The expansion as numbers of the library.
    fn write(&self, to: &NamedConvention) -> anyhow::Result<()> {
        let output = self.output.as_deref().filter(|path| *path != Path::new("-"));
        let kind = output.map(Kind::of).transpose()?;
        if let Some(path) = output {
            prepare_file(path, &[&self.input])?;
        }
        let input = ShInput::from(self.input.clone().into_os_string());
        let array = match input.read()?.coefficients {
            FileCoefficients::Scalar(f) => to.convention().encode(&f),
            FileCoefficients::Rgb(f) => to.convention().encode(&f),
        };
        let array = array.map_err(|e| anyhow!("{input}: {to}: {e}"))?;
        match output.zip(kind) {
            Some((path, kind)) => {
                let place = path.display().to_string();
                let written = write_atomically(path, |file| file.write_all(&kind.bytes(&array, to)));
                Ok(written.map_err(|source| IoError::Io { place, source })?)
            }
            None => print(&text(&array, to)),
        }
    }

    /// Numbers of the library as an expansion.
    fn read(&self, from: &NamedConvention) -> anyhow::Result<()> {
        let Some(output) = &self.output else { bail!("-o: expected a .sh.json file, or - for stdout") };
        let output = ShOutput::from(output.clone().into_os_string());
        output.check()?;
        let name = if self.input == Path::new("-") { "stdin".to_owned() } else { self.input.display().to_string() };
        let array = array_of(&bytes_of(&self.input, &name)?, from).map_err(|e| anyhow!("{name}: {e}"))?;
        let convention = from.convention();
        let place = format!("{name}: {from}");
        let coefficients: FileCoefficients = match convention.channels_and_order(&array.shape, &place)? {
            (3, _) => convention.decode::<lobe::sh::Rgb<f64>>(&array, &place)?.into(),
            _ => convention.decode::<f64>(&array, &place)?.into(),
        };
        output.write(&ShFile::new(self.quantity.unwrap_or(Quantity::Radiance), coefficients))
    }
}
