//! Jobs, those that are asked for measured one after the other.

use std::time::Duration;

use serde::Serialize;

use crate::bench::clock::nanoseconds;
use crate::bench::cost::Cost;
use crate::bench::floors::Floors;
use crate::run::talk::ProgressLine;

/// A piece of work that is measured.
pub(crate) struct BenchJob {
    /// As `WORD` finds it.
    pub(crate) name: &'static str,
    /// Number of bands, if it has some.
    pub(crate) order: Option<usize>,
    /// What is counted.
    pub(crate) item: &'static str,
    /// How many of them the work does.
    pub(crate) items: usize,
    /// What one of them needs at least, where that is known.
    pub(crate) cost: Option<Cost>,
    /// Where the time above the floor goes.
    pub(crate) above: &'static str,
}

/// All jobs, one after the other: those that are asked for are measured.
pub(crate) struct Bench<'a> {
    pub(crate) floors: Floors,
    pub(crate) time: Duration,
    pub(crate) words: &'a [String],
    pub(crate) rows: Vec<Row>,
    /// Of all jobs.
    pub(crate) names: Vec<&'static str>,
    pub(crate) line: ProgressLine,
}

/// A line of the table.
#[derive(Serialize)]
pub(crate) struct Row {
    pub(crate) job: &'static str,
    pub(crate) order: Option<usize>,
    pub(crate) item: &'static str,
    /// The time of an item.
    pub(crate) nanoseconds: f64,
    /// The least that it can be.
    pub(crate) floor: Option<f64>,
    /// By what that is bound.
    pub(crate) bound: Option<&'static str>,
    /// The time over the floor.
    pub(crate) ratio: Option<f64>,
    #[serde(skip)]
    pub(crate) above: &'static str,
}

impl Bench<'_> {
    /// Whether a job is asked for; those that are not need no data.
    pub(crate) fn wants(&mut self, name: &'static str) -> bool {
        if !self.names.contains(&name) {
            self.names.push(name);
        }
        self.words.is_empty() || self.words.iter().any(|word| name.contains(word.as_str()))
    }

    /// Measures a job.
    pub(crate) fn measure(&mut self, job: &BenchJob, work: impl FnMut()) {
        let BenchJob { name, order, item, items, cost, above } = *job;
        self.line.say(name);
        let nanoseconds = nanoseconds(self.time, work) / items as f64;
        let (floor, bound) = cost.map(|cost| cost.floor(&self.floors)).unzip();
        let ratio = floor.map(|floor| nanoseconds / floor);
        self.rows.push(Row { job: name, order, item, nanoseconds, floor, bound, ratio, above });
    }
}
