//! `lobe import`: nine colors of an engine as an expansion.

use std::io::Read as _;
use std::path::{Path, PathBuf};

use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use lobe::env::import_coefficients;
use lobe::io::{IoError, read_file};
use lobe::sh::ShVec;
use lobe::sh::encoding::EngineForm;
use lobe::sh::expansion::Quantity;
use lobe::sh::sh_json::ShFile;

use crate::args::output::ShOutput;

#[derive(Args)]
pub(crate) struct Import {
    /// Nine colors: text with 27 numbers, such as cmgen's sh.txt or what lobe sh encode prints; JSON with such a list
    /// in it, such as LightProbe.toJSON of three.js; a .ktx with the key sh; a .env of Babylon.js; - reads stdin
    #[arg(value_name = "FILE")]
    input: PathBuf,
    /// The engine whose numbers they are. A .ktx is filament's, a .env babylon's. Numbers of pyshtools, healpy, e3nn or
    /// Ambisonics are read by lobe sh convert --from
    #[arg(long, value_name = "NAME", value_parser = form())]
    from: EngineForm,
    /// The radiance of the light in three bands, a .sh.json file; - writes to stdout
    #[arg(short, long, value_name = "P")]
    output: ShOutput,
}

fn form() -> impl TypedValueParser<Value = EngineForm> {
    PossibleValuesParser::new(EngineForm::ALL.map(EngineForm::name)).try_map(|name| name.parse::<EngineForm>())
}

impl Import {
    pub(crate) fn run(&self) -> anyhow::Result<()> {
        self.output.check()?;
        let bytes = if self.input == Path::new("-") {
            let mut bytes = Vec::new();
            let read = std::io::stdin().lock().read_to_end(&mut bytes);
            read.map_err(|source| IoError::Io { place: "stdin".to_owned(), source })?;
            bytes
        } else {
            read_file(&self.input)?
        };
        let light = import_coefficients(&bytes, self.from, &self.input.display().to_string())?;
        self.output.write(&ShFile::new(Quantity::Radiance, ShVec::from(light)))
    }
}
