//! Options of a job on the command line, by the crate clap: an argument for each field of its table, and what was given
//! of them.

use std::collections::{BTreeMap, BTreeSet};
use std::marker::PhantomData;
use std::path::PathBuf;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser as _, ValueParser};
use clap::{Arg, ArgAction, ArgMatches, Args, Command, FromArgMatches, ValueHint, value_parser};
use serde_json::{Map, Value};

use crate::options::field::{OptionError, OptionField, worded};
use crate::options::job_options::JobOptions;
use crate::options::kind::{NumberRange, OptionKind};

/// The argument without a dash.
const POSITIONAL: &str = "scene";

/// The argument with a letter of its own.
const OUTPUT: &str = "output";

/// The name of an option on the command line.
#[must_use]
pub fn flag(name: &str) -> String {
    match name {
        POSITIONAL => "SCENE".to_owned(),
        OUTPUT => "-o".to_owned(),
        name => format!("--{}", name.replace('_', "-")),
    }
}

/// The options that were given of a job's: a group of arguments of clap.
#[derive(Clone, Debug)]
pub struct JobArgs<T> {
    /// The values, by the names of options.
    pub values: Map<String, Value>,
    /// Paths as the system has them, which need not be text.
    paths: BTreeMap<&'static str, Vec<PathBuf>>,
    of: PhantomData<T>,
}

impl<T: JobOptions> JobArgs<T> {
    /// The job, with defaults for what was not given.
    ///
    /// # Errors
    /// Those of [`JobOptions::from_values`].
    pub fn job(&self) -> Result<T, OptionError> {
        self.job_over(Map::new())
    }

    /// The job with what was given over other values.
    ///
    /// # Errors
    /// Those of [`JobOptions::from_values`].
    pub fn job_over(&self, mut values: Map<String, Value>) -> Result<T, OptionError> {
        for contrary in self.values.keys().flat_map(|name| T::contraries(name)) {
            values.remove(*contrary);
        }
        values.extend(self.values.clone());
        let mut job = T::from_values(values)?;
        job.set_paths(&|name| self.paths.get(name).cloned());
        Ok(job)
    }
}

impl<T> JobArgs<T> {
    /// The path of an option, if it was given.
    #[must_use]
    pub fn path(&self, name: &str) -> Option<PathBuf> {
        self.paths.get(name)?.first().cloned()
    }

    /// Keeps the paths of an option, and gives them as text.
    fn given_paths(&mut self, matches: &ArgMatches, field: &OptionField) -> Option<Value> {
        let paths: Vec<PathBuf> = matches.get_many::<PathBuf>(field.name)?.cloned().collect();
        let texts: Vec<Value> = paths.iter().map(|path| path.to_string_lossy().into()).collect();
        self.paths.insert(field.name, paths);
        if field.kind == OptionKind::Files { Some(Value::Array(texts)) } else { texts.into_iter().next() }
    }
}

impl<T: JobOptions> FromArgMatches for JobArgs<T> {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let mut found = Self { values: Map::new(), paths: BTreeMap::new(), of: PhantomData };
        found.update_from_arg_matches(matches)?;
        Ok(found)
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        for field in T::fields() {
            let given = match field.kind {
                OptionKind::Flag => matches.get_flag(field.name).then_some(Value::Bool(true)),
                OptionKind::File | OptionKind::Files => self.given_paths(matches, field),
                _ => matches.get_one::<Value>(field.name).cloned(),
            };
            if let Some(value) = given {
                self.values.insert(field.name.to_owned(), value);
            }
        }
        Ok(())
    }
}

impl<T: JobOptions> Args for JobArgs<T> {
    fn augment_args(command: Command) -> Command {
        // -h has the first option of each heading, --help all of them.
        let mut begun = BTreeSet::new();
        T::fields().into_iter().fold(command, |command, field| {
            let is_further = T::heading_of(field.name).is_some_and(|heading| !begun.insert(heading));
            command.arg(argument::<T>(field).hide_short_help(is_further))
        })
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

/// The argument of one option of a table, for commands that have it without the others.
#[must_use]
pub fn option<T: JobOptions>(name: &str) -> Option<Arg> {
    T::fields().into_iter().find(|field| field.name == name).map(argument::<T>)
}

/// The argument of an option.
fn argument<T: JobOptions>(field: &'static OptionField) -> Arg {
    let arg = Arg::new(field.name).help(help::<T>(field)).value_name(field.value_name);
    let arg = if field.name == POSITIONAL { arg } else { arg.long(field.name.replace('_', "-")) };
    let arg = if field.name == OUTPUT { arg.short('o') } else { arg };
    let arg = match T::heading_of(field.name) {
        Some(heading) => arg.help_heading(heading),
        None => arg,
    };
    match field.kind {
        OptionKind::Flag => arg.action(ArgAction::SetTrue),
        OptionKind::Name(names) => {
            let possible = names.iter().map(|(name, what)| match what.is_empty() {
                true => PossibleValue::new(*name),
                false => PossibleValue::new(*name).help(*what),
            });
            arg.value_parser(PossibleValuesParser::new(possible).map(Value::from))
        }
        OptionKind::Files => arg.num_args(1..).value_hint(ValueHint::FilePath).value_parser(value_parser!(PathBuf)),
        OptionKind::File => arg.value_hint(ValueHint::FilePath).value_parser(value_parser!(PathBuf)),
        OptionKind::Number(NumberRange::Finite) | OptionKind::Numbers(_) => {
            arg.allow_hyphen_values(true).value_parser(parser(field))
        }
        _ => arg.value_parser(parser(field)),
    }
}

fn parser(field: &'static OptionField) -> ValueParser {
    ValueParser::new(move |text: &str| field.kind.parse(text))
}

/// A text of a table, with the names that options have on the command line.
fn in_flags(text: &str) -> String {
    worded(text, |name| Some(flag(name)))
}

/// What an option does, its range and its default.
fn help<T: JobOptions>(field: &OptionField) -> String {
    let mut about = Vec::new();
    if let OptionKind::Whole { least, most, .. } = field.kind
        && most < u64::from(u32::MAX)
    {
        about.push(format!("{least} to {most}"));
    }
    let own = T::default_of(field.name).filter(|_| field.kind != OptionKind::Flag && field.kind != OptionKind::Files);
    match own {
        Some(value) if value.as_str() != Some("") => about.push(format!("default: {}", field.kind.text_of(&value))),
        _ if !T::left_open_of(field).is_empty() => {
            about.push(format!("default: {}", in_flags(T::left_open_of(field))));
        }
        _ => {}
    }
    let text = in_flags(&field.marked_doc());
    if about.is_empty() { text } else { format!("{text} [{}]", about.join("; ")) }
}
