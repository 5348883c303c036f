//! `lobe export MAP` and `lobe export shader`.

use clap::{ArgMatches, Args, Command, FromArgMatches};

use crate::export::engines::ExportLight;
use crate::export::shader::ExportShader;
use crate::run::talk::Talk;

/// `lobe export MAP`, or `lobe export shader`. The options that the first requires are not asked of the second. A map
/// of the name `shader` is `./shader`.
#[expect(clippy::large_enum_variant, reason = "there is one, as long as the command runs")]
pub(crate) enum Export {
    Light(ExportLight),
    Shader(ExportShader),
}

/// The name of the second.
const SHADER: &str = "shader";

impl FromArgMatches for Export {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        match matches.subcommand_matches(SHADER) {
            Some(matches) => ExportShader::from_arg_matches(matches).map(Self::Shader),
            None => ExportLight::from_arg_matches(matches).map(Self::Light),
        }
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

impl Args for Export {
    fn augment_args(command: Command) -> Command {
        let about =
            "Write functions for shaders: the basis, irradiance in every form, transfer; without a function list them";
        let shader = ExportShader::augment_args(Command::new(SHADER)).about(about);
        ExportLight::augment_args(command)
            .args_conflicts_with_subcommands(true)
            .subcommand_negates_reqs(true)
            .subcommand(shader)
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl Export {
    pub(crate) fn run(&self, talk: Talk) -> anyhow::Result<()> {
        match self {
            Self::Light(light) => light.run(talk),
            Self::Shader(shader) => shader.run(),
        }
    }
}
