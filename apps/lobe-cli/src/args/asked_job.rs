//! A job on the command line: its options, or the file that has them.

use std::fs;
use std::path::PathBuf;

use anyhow::anyhow;
use clap::Args;
use lobe::io::{IoError, JobArgs, JobOptions};
use serde_json::{Map, Value};

use crate::args::output;

#[derive(Args)]
pub(crate) struct AskedJob<T: JobOptions + Clone + Send + Sync + 'static> {
    #[command(flatten)]
    pub(crate) options: JobArgs<T>,
    /// Take options from this file, TOML with the names of options and _ for -; those given beside it count more
    #[arg(long, value_name = "FILE", help_heading = "Jobs in files")]
    job: Option<PathBuf>,
    /// Print the job on stdout, as --job reads it, and do nothing else
    #[arg(long, help_heading = "Jobs in files")]
    print_job: bool,
}

impl<T: JobOptions + Clone + Send + Sync + 'static> AskedJob<T> {
    /// The job: what a file says, with the options that are given over it. None if it is to be printed alone, which is
    /// done.
    pub(crate) fn job(&self) -> anyhow::Result<Option<T>> {
        self.job_over(&Map::new(), "")
    }

    /// The same over options that were found in some other place.
    pub(crate) fn job_over(&self, begun: &Map<String, Value>, place: &str) -> anyhow::Result<Option<T>> {
        let (values, place) = match &self.job {
            Some(path) => {
                let text = fs::read_to_string(path).map_err(|source| IoError::io(path, source))?;
                let place = path.display().to_string();
                (values_in(&text, &place)?, place)
            }
            None => (begun.clone(), place.to_owned()),
        };
        let job = self.options.job_over(values).map_err(|error| {
            let is_given = place.is_empty() || self.options.values.contains_key(&error.option);
            if is_given { error.into() } else { anyhow!("{place}: {error}") }
        })?;
        if self.print_job {
            output::print(&text_of(&job)?)?;
            return Ok(None);
        }
        Ok(Some(job))
    }
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
fn values_in(text: &str, place: &str) -> anyhow::Result<Map<String, Value>> {
    let one_line = |error: toml::de::Error| {
        let line = error.span().map_or(1, |span| 1 + text[..span.start.min(text.len())].matches('\n').count());
        anyhow!("{place}: line {line}: {}", error.message())
    };
    let table: toml::Table = toml::from_str(text).map_err(one_line)?;
    Ok(table.into_iter().map(|(name, value)| (name, json_of(value))).collect())
}

/// The options of a job as such a file.
fn text_of(job: &impl JobOptions) -> anyhow::Result<String> {
    let text = toml::to_string(&job.values());
    let text = text.map_err(|error| anyhow!("this job cannot be written as TOML: {error}"))?;
    Ok(text.trim_end().to_owned() + "\n")
}
