//! Options of a job on the command line: an argument for each field of its table, and what was given of them.

use std::collections::{BTreeMap, BTreeSet};
use std::marker::PhantomData;
use std::path::PathBuf;

use anyhow::anyhow;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser as _, ValueParser};
use clap::{Arg, ArgAction, ArgMatches, Args, Command, FromArgMatches, ValueHint, value_parser};
use lobe::io::{JobOptions, NumberRange, OptionError, OptionField, OptionKind};
use serde_json::{Map, Value};

use crate::run::option_names::{OUTPUT, POSITIONAL, dashed, in_flags};

/// The options that were given of a job's.
#[derive(Clone, Debug)]
pub(crate) struct JobArgs<T> {
    pub(crate) values: Map<String, Value>,
    /// Paths as the system has them, which need not be text.
    paths: BTreeMap<&'static str, Vec<PathBuf>>,
    of: PhantomData<T>,
}

impl<T: JobOptions> JobArgs<T> {
    /// The job, with defaults for what was not given.
    pub(crate) fn job(&self) -> Result<T, OptionError> {
        T::from_values(self.values.clone())
    }

    /// The job with what was given over other values.
    pub(crate) fn job_over(&self, mut values: Map<String, Value>) -> Result<T, OptionError> {
        values.extend(self.values.clone());
        T::from_values(values)
    }
}

impl<T> JobArgs<T> {
    /// The path of an option, if it was given.
    pub(crate) fn path(&self, name: &str) -> Option<PathBuf> {
        self.paths.get(name)?.first().cloned()
    }

    /// All paths of an option, if it was given.
    pub(crate) fn paths(&self, name: &str) -> Option<Vec<PathBuf>> {
        self.paths.get(name).cloned()
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
pub(crate) fn option<T: JobOptions>(name: &str) -> Option<Arg> {
    T::fields().into_iter().find(|field| field.name == name).map(argument::<T>)
}

/// The argument of an option.
fn argument<T: JobOptions>(field: &'static OptionField) -> Arg {
    let arg = Arg::new(field.name).help(help::<T>(field)).value_name(field.value_name);
    let arg = if field.name == POSITIONAL { arg } else { arg.long(dashed(field.name)) };
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
        _ if !field.left_open.is_empty() => about.push(format!("default: {}", in_flags(field.left_open))),
        _ => {}
    }
    let text = in_flags(&field.marked_doc());
    if about.is_empty() { text } else { format!("{text} [{}]", about.join("; ")) }
}

/// A value of TOML as JSON, which has neither dates nor numbers that are none.
fn json_of(value: toml::Value) -> Value {
    match value {
        toml::Value::Float(x) if !x.is_finite() => Value::from(x.to_string().to_lowercase()),
        toml::Value::Float(x) => x.into(),
        toml::Value::Integer(n) => n.into(),
        toml::Value::Boolean(yes) => yes.into(),
        toml::Value::String(text) => text.into(),
        toml::Value::Array(all) => all.into_iter().map(json_of).collect(),
        other => other.to_string().into(),
    }
}

/// The options in a file of a job, which is TOML.
pub(crate) fn values_in(text: &str, place: &str) -> anyhow::Result<Map<String, Value>> {
    let one_line = |error: toml::de::Error| {
        let line = error.span().map_or(1, |span| 1 + text[..span.start.min(text.len())].matches('\n').count());
        anyhow!("{place}: line {line}: {}", error.message())
    };
    let table: toml::Table = toml::from_str(text).map_err(one_line)?;
    Ok(table.into_iter().map(|(name, value)| (name, json_of(value))).collect())
}

/// The options of a job as such a file.
pub(crate) fn text_of(job: &impl JobOptions) -> anyhow::Result<String> {
    toml::to_string(&job.values()).map_err(|error| anyhow!("this job cannot be written as TOML: {error}"))
}
