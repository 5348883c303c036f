//! Jobs, those that are asked for measured one after the other.

use std::hint::black_box;
use std::time::Duration;

use indicatif::ProgressBar;
use serde::Serialize;

use crate::clock::nanoseconds;
use crate::cost::Cost;
use crate::floors::Floors;

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

/// How often a job is done.
pub(crate) enum Pace {
    /// For a time, which is measured.
    Timed { floors: Floors, time: Duration },
    /// Once, by [`counted`], for a program that counts instructions.
    Counted,
}

/// All jobs, one after the other: those that are asked for are measured.
pub(crate) struct Bench<'a> {
    pub(crate) pace: Pace,
    pub(crate) words: &'a [String],
    /// The only order, if one is asked for.
    pub(crate) order: Option<usize>,
    /// Of jobs that were timed.
    pub(crate) rows: Vec<Row>,
    /// Jobs that were counted, and their orders.
    pub(crate) counted: Vec<(&'static str, Option<usize>)>,
    /// Of all jobs.
    pub(crate) names: Vec<&'static str>,
    /// What is measured now, on a terminal.
    pub(crate) line: ProgressBar,
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

/// Does the work. `cargo xtask instructions` has valgrind collect within this function, which it knows by its name: it must not become
/// one with another that only calls.
#[inline(never)]
fn counted(work: &mut dyn FnMut()) {
    let is_own = black_box(true);
    work();
    black_box(is_own);
}

impl Bench<'_> {
    /// Whether a job is asked for; those that are not need no data.
    pub(crate) fn wants(&mut self, name: &'static str) -> bool {
        if !self.names.contains(&name) {
            self.names.push(name);
        }
        self.words.is_empty()
            || self.words.iter().any(|word| match self.pace {
                Pace::Timed { .. } => name.contains(word.as_str()),
                Pace::Counted => name == word,
            })
    }

    /// Whether a job without an order is asked for.
    pub(crate) fn wants_without_order(&mut self, name: &'static str) -> bool {
        self.wants(name) && self.order.is_none()
    }

    /// Of the orders of a job those that are asked for.
    pub(crate) fn orders(&self, all: &[usize]) -> Vec<usize> {
        all.iter().copied().filter(|order| self.order.is_none_or(|wanted| wanted == *order)).collect()
    }

    /// Measures a job.
    pub(crate) fn measure(&mut self, job: &BenchJob, mut work: impl FnMut()) {
        let BenchJob { name, order, item, items, cost, above } = *job;
        self.line.set_message(name);
        self.line.tick();
        let (floors, time) = match &self.pace {
            Pace::Timed { floors, time } => (floors, *time),
            Pace::Counted => {
                // Before that, what is made at the first call.
                work();
                counted(&mut work);
                return self.counted.push((name, order));
            }
        };
        let nanoseconds = nanoseconds(time, work) / items as f64;
        let (floor, bound) = cost.map(|cost| cost.floor(items, floors)).unzip();
        let ratio = floor.map(|floor| nanoseconds / floor);
        self.rows.push(Row { job: name, order, item, nanoseconds, floor, bound, ratio, above });
    }
}
