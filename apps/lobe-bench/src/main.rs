//! The kernels on one's own machine, each beside the time that its arithmetic or its bytes need at least.
//!
//! Read `floors` first, what the machine does at most, and `cost`, what a job needs of that; `measure` times a job by the
//! `clock`, `functions`, `pictures`, `lights`, `receivers` and `paths` are the jobs.

mod clock;
mod cost;
mod floors;
mod functions;
mod lights;
mod measure;
mod paths;
mod pictures;
mod receivers;

use std::io::{self, Write as _};
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

use anyhow::{Context as _, bail};
use clap::Parser;
use indicatif::{ProgressBar, ProgressStyle};
use lobe::io::{check_writable, choose_huge_pages};
use lobe::sh::simd::Machine;
use serde::Serialize;

use floors::Floors;
use measure::{Bench, Pace, Row};

/// As the command has it: where memory comes from decides about jobs that write much.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

/// Times its floor above which a job says why.
const NEAR: f64 = 2.0;

/// Measure the kernels on this machine, each beside the time that its arithmetic or its bytes need at least
#[expect(clippy::doc_markdown, reason = "the keys of the JSON are shown on a terminal")]
#[derive(Parser)]
#[command(version, max_term_width = 100)]
struct Arguments {
    /// Only jobs whose names contain one of these words, such as basis or product
    #[arg(value_name = "WORD")]
    words: Vec<String>,
    /// Only jobs of this order
    #[arg(long, value_name = "N")]
    order: Option<usize>,
    /// Do each job of exactly these names once, and print their names and orders: for programs that count instructions
    #[arg(long, hide = true, conflicts_with_all = ["seconds", "json", "rays"])]
    counted: bool,
    /// Seconds for each line of the table
    #[arg(long, value_name = "S", default_value = "0.5", value_parser = positive)]
    seconds: f64,
    /// Print {"machine": {"instructions", "gigahertz", "gflops", "each_cycle", "first_level", "store_first_level",
    /// "copy_first_level", "store_second_level", "copy_second_level", "store", "store_past_caches", "read"}, "jobs":
    /// [{"job", "order", "item", "nanoseconds", "floor", "bound", "ratio"}]} instead of text: rates in bytes per
    /// nanosecond, multiply-adds of a register in each cycle, first_level in bytes; floor, bound and ratio are null
    /// where none is known
    #[arg(long)]
    json: bool,
    /// Write the triangles of the job occlusion, its rays and which of them are hidden to a .safetensors file: corners, points,
    /// directions and hidden. Other tracers can answer the same rays
    #[arg(long, value_name = "FILE")]
    rays: Option<PathBuf>,
    /// Print no notes and no progress on stderr, only errors
    #[arg(long, short)]
    quiet: bool,
}

/// A finite number above 0.
fn positive(text: &str) -> Result<f64, String> {
    text.parse()
        .ok()
        .filter(|x: &f64| x.is_finite() && *x > 0.0)
        .ok_or(format!("expected a number above 0, found {text}"))
}

fn main() -> ExitCode {
    match Arguments::parse().run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("lobe-bench: {error}");
            ExitCode::from(2)
        }
    }
}

/// The JSON of `--json`.
#[derive(Serialize)]
struct Printed<'a> {
    machine: &'a Floors,
    jobs: &'a [Row],
}

impl Arguments {
    fn run(&self) -> anyhow::Result<()> {
        Machine::check_limit()?;
        choose_huge_pages()?;
        let time = Duration::try_from_secs_f64(self.seconds)
            .with_context(|| format!("--seconds: expected fewer seconds, found {}", self.seconds))?;
        if let Some(path) = &self.rays {
            check_writable(path).with_context(|| path.display().to_string())?;
        }
        // One thread, as the floors are of one.
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().context("the system gives no thread")?;
        let line = self.line()?;
        let pace = if self.counted {
            Pace::Counted
        } else {
            line.set_message("floors");
            line.tick();
            let floors = Floors::measure(time);
            if let Some(doubt) = floors.doubt().filter(|_| !self.quiet) {
                line.suspend(|| eprintln!("note: floors: {doubt}"));
            }
            Pace::Timed { floors, time }
        };
        let (words, order) = (&*self.words, self.order);
        let mut bench = Bench { pace, words, order, rows: Vec::new(), counted: Vec::new(), names: Vec::new(), line };
        pool.install(|| {
            functions::run(&mut bench);
            pictures::run(&mut bench)?;
            lights::run(&mut bench)?;
            receivers::run(&mut bench, self.rays.as_deref())?;
            paths::run(&mut bench)
        })?;
        bench.line.finish_and_clear();
        if bench.rows.is_empty() && bench.counted.is_empty() {
            let order = self.order.map(|order| format!(" of order {order}")).unwrap_or_default();
            let names = bench.names.join(", ");
            bail!("expected a word in the name of a job{order}, found {:?}; jobs: {names}", self.words);
        }
        let (rows, counted) = (bench.rows, bench.counted);
        let Pace::Timed { floors, .. } = bench.pace else {
            let order = |order: Option<usize>| order.map(|order| format!(" {order}")).unwrap_or_default();
            let lines: String = counted.iter().map(|(name, of)| format!("{name}{}\n", order(*of))).collect();
            return print(&lines);
        };
        if self.json {
            return print(&(serde_json::to_string(&Printed { machine: &floors, jobs: &rows })? + "\n"));
        }
        print(&(head(&floors) + &table(&rows) + &reasons(&rows)))
    }

    /// What is measured now, on a terminal.
    fn line(&self) -> anyhow::Result<ProgressBar> {
        let line = if self.quiet { ProgressBar::hidden() } else { ProgressBar::new_spinner() };
        Ok(line.with_style(ProgressStyle::with_template("measuring {msg}")?))
    }
}

fn print(text: &str) -> anyhow::Result<()> {
    let mut stdout = io::stdout();
    stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()).context("stdout")
}

/// What the machine does at most.
fn head(floors: &Floors) -> String {
    let Floors { instructions, gigahertz, gflops, each_cycle, store_first_level, copy_first_level, .. } = floors;
    let Floors { store_second_level, copy_second_level, store, store_past_caches, read, .. } = floors;
    format!(
        "one thread, {instructions}: {gflops:.0} GFLOP/s, {each_cycle:.2} multiply-adds of a register a cycle at \
         {gigahertz:.2} GHz; GB/s:\nfirst-level cache {store_first_level:.0} written, {copy_first_level:.0} copied, \
         second-level cache {store_second_level:.0} written, {copy_second_level:.0} copied,\nmemory {store:.1} \
         written, {store_past_caches:.1} past the caches, {read:.1} read. Floor: the larger of arithmetic and \
         bytes.\n\n"
    )
}

fn table(rows: &[Row]) -> String {
    let mut text = format!("{:<18} {:>5} {:>12} {:>12} {:>7}  per, bound by\n", "job", "order", "ns", "floor", "ratio");
    for Row { job, order, item, nanoseconds, floor, bound, ratio, .. } in rows {
        let order = order.map(|order| order.to_string()).unwrap_or_default();
        let floor = floor.map(short).unwrap_or_default();
        let ratio = ratio.map(|ratio| format!("{ratio:.2}")).unwrap_or_default();
        let bound = bound.map(|bound| format!(", {bound}")).unwrap_or_default();
        text += &format!("{job:<18} {order:>5} {:>12} {floor:>12} {ratio:>7}  {item}{bound}\n", short(*nanoseconds));
    }
    text
}

/// Three digits.
fn short(x: f64) -> String {
    let decimals = (2 - x.abs().max(1e-3).log10().floor() as i32).max(0) as usize;
    format!("{x:.decimals$}")
}

/// Why jobs are above twice their floor, each said once.
fn reasons(rows: &[Row]) -> String {
    let mut said: Vec<(&str, &str)> = Vec::new();
    for row in rows.iter().filter(|row| row.ratio.is_some_and(|ratio| ratio > NEAR)) {
        if !said.contains(&(row.job, row.above)) {
            said.push((row.job, row.above));
        }
    }
    let lines: String = said.iter().map(|(job, above)| format!("{job}: {above}\n")).collect();
    if lines.is_empty() { lines } else { format!("\nabove {NEAR} times the floor:\n{lines}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_three_digits() {
        let texts = [0.0123, 0.5, 1.0, 12.34, 123.4, 5_678.0].map(short);
        assert_eq!(texts, ["0.0123", "0.500", "1.00", "12.3", "123", "5678"]);
    }

    #[test]
    fn what_is_far_above_its_floor_says_why_once() {
        let row = |job, ratio| Row {
            job,
            order: None,
            item: "item",
            nanoseconds: 1.0,
            floor: None,
            bound: None,
            ratio,
            above: "spills",
        };
        let rows = [row("a", Some(3.0)), row("a", Some(4.0)), row("b", Some(1.5)), row("c", None)];
        assert_eq!(reasons(&rows), "\nabove 2 times the floor:\na: spills\n");
        assert_eq!(reasons(&rows[2..]), "", "nothing to explain");
    }
}
