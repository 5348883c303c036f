//! `instructions`: what kernels execute, counted by valgrind, against the counts on record.
//!
//! A time tells little on a machine that is shared; a count is the same on every machine that executes the same instructions. `lobe-bench
//! --counted` does each job once within a function of a name of its own, within which valgrind collects, and after which it dumps.
//! Counts are of one compiler, which is on record too.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

use serde_json::{Value, json};

use crate::outcome::{self, Outcome};
use crate::toolchain;
use crate::workspace;

const RECORD: &str = "apps/lobe-bench/instructions.json";

/// Counts that are larger by more than this part are a fault. They are the same from run to run, but not from build to build: where crates
/// lie, and which features they have, changes what the compiler puts together, by which up to 11 % more were seen. A kernel that
/// is lost, or calls what it had in itself, takes several times as many.
const TOLERANCE: f64 = 0.25;

/// Jobs of `lobe-bench`: those of functions, whose work takes valgrind milliseconds.
const JOBS: [&str; 11] = [
    PROBE,
    "basis",
    "eval",
    "product",
    "square",
    "zonal-product",
    "product-one",
    "rotation",
    "rotation-one",
    "irradiance",
    "dering",
];

/// The probe of arithmetic, which every floor rests on.
const PROBE: &str = "multiply-adds";

/// The function of the program within which valgrind counts; patterns are not understood by all of its options.
const COUNTED: &str = "lobe_bench::measure::counted";

/// What valgrind knows; it has no AVX-512.
const INSTRUCTIONS: [&str; 2] = ["plain", "avx2"];

#[cfg(target_arch = "x86_64")]
fn has_avx2() -> bool {
    std::arch::is_x86_feature_detected!("avx2")
}

#[cfg(not(target_arch = "x86_64"))]
fn has_avx2() -> bool {
    false
}

/// Whether counts can be compared here.
///
/// # Errors
/// The reason why not.
pub(crate) fn can_count() -> Result<(), String> {
    if !has_avx2() {
        return Err("counts are of x86-64 with AVX2, which this machine is not".to_owned());
    }
    toolchain::has_program("valgrind", "apt-get install valgrind")?;
    let (here, recorded) = (toolchain::compiler()?, record()?["compiler"].clone());
    if recorded == here {
        Ok(())
    } else {
        Err(format!("counts are of {recorded}, this is {here}; `cargo xtask instructions --write` counts anew"))
    }
}

/// Counts, and compares or with `--write` records.
pub(crate) fn run(arguments: &[String]) -> Outcome {
    let writes = arguments.iter().any(|argument| argument == "--write");
    let counts = counts().map_err(|fault| vec![fault])?;
    if writes {
        let text = toolchain::compiler().and_then(|compiler| {
            serde_json::to_string_pretty(&json!({"compiler": compiler, "counts": counts})).map_err(|e| e.to_string())
        });
        let text = text.map_err(|fault| vec![fault])?;
        return std::fs::write(workspace::root().join(RECORD), text + "\n").map_err(|e| vec![format!("{RECORD}: {e}")]);
    }
    let record = record().map_err(|fault| vec![fault])?;
    let known: BTreeMap<String, u64> = serde_json::from_value(record["counts"].clone()).unwrap_or_default();
    outcome::of(faults(&counts, &known))
}

fn record() -> Result<Value, String> {
    let text = workspace::read(&workspace::root().join(RECORD))?;
    serde_json::from_str(&text).map_err(|error| format!("{RECORD}: {error}"))
}

/// What is wrong with counts beside those on record: more than there were, or others.
fn faults(counts: &BTreeMap<String, u64>, known: &BTreeMap<String, u64>) -> Vec<String> {
    let mut faults = Vec::new();
    for (name, &count) in counts {
        match known.get(name) {
            None => faults.push(format!("{name}: no count is on record; cargo xtask instructions --write")),
            Some(&before) => {
                let ratio = count as f64 / before as f64;
                println!("     {name:<24} {count:>12}  {ratio:.3} of what it was");
                if ratio > 1.0 + TOLERANCE {
                    faults.push(format!("{name}: {count} instructions, {ratio:.3} times the {before} on record"));
                }
            }
        }
    }
    faults.extend(known.keys().filter(|name| !counts.contains_key(*name)).map(|name| format!("{name}: not counted")));
    faults
}

/// The instructions of each job.
fn counts() -> Result<BTreeMap<String, u64>, String> {
    let bench = workspace::program_of_tests("bench", "lobe-bench")?;
    let folder = std::env::temp_dir().join(format!("lobe-instructions-{}", std::process::id()));
    std::fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let mut counts = BTreeMap::new();
    for instructions in INSTRUCTIONS {
        let of_jobs = count(&bench, instructions, &folder.join(instructions));
        let _ = std::fs::remove_dir_all(folder.join(instructions));
        counts.extend(of_jobs?.into_iter().map(|(job, count)| (format!("{job} {instructions}"), count)));
    }
    // Remove the folder; a failure to do so is no fault of the program.
    let _ = std::fs::remove_dir_all(&folder);
    Ok(counts)
}

/// The jobs in their order, with what each executed.
fn count(bench: &Path, instructions: &str, folder: &Path) -> Result<Vec<(String, u64)>, String> {
    std::fs::create_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let output = Command::new("valgrind")
        .arg("--tool=callgrind")
        .arg(format!("--callgrind-out-file={}", folder.join("part").display()))
        .args([format!("--toggle-collect={COUNTED}"), format!("--dump-after={COUNTED}")])
        .arg(bench)
        .args(["--quiet", "--counted"])
        .args(JOBS)
        .env("LOBE_SIMD", instructions)
        .output()
        .map_err(|error| format!("valgrind: {error}"))?;
    if !output.status.success() {
        return Err(format!("valgrind lobe-bench --counted: {}", String::from_utf8_lossy(&output.stderr)));
    }
    // Dumps are numbered from 1 on.
    let part = |k: usize| workspace::read(&folder.join(format!("part.{k}")));
    let jobs = String::from_utf8_lossy(&output.stdout).into_owned();
    jobs.lines().enumerate().map(|(k, job)| Ok((job.to_owned(), total(&part(k + 1)?)?))).collect()
}

/// The instructions of a dump.
fn total(dump: &str) -> Result<u64, String> {
    let total = dump.lines().find_map(|line| line.strip_prefix("totals:").or(line.strip_prefix("summary:")));
    let total = total.and_then(|total| total.trim().parse().ok()).filter(|total| *total > 0);
    total.ok_or_else(|| "valgrind: expected instructions in every dump, found none".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn counts(pairs: &[(&str, u64)]) -> BTreeMap<String, u64> {
        pairs.iter().map(|(name, count)| ((*name).to_owned(), *count)).collect()
    }

    #[test]
    fn more_instructions_are_a_fault_and_fewer_are_none() {
        let known = counts(&[("a", 1000), ("b", 1000), ("c", 1000)]);
        assert!(faults(&counts(&[("a", 1110), ("b", 500), ("c", 1000)]), &known).is_empty(), "within the tolerance");
        let found = faults(&counts(&[("a", 1300), ("b", 1000), ("d", 1)]), &known);
        let expected = [
            "a: 1300 instructions, 1.300 times the 1000 on record",
            "d: no count is on record; cargo xtask instructions --write",
            "c: not counted",
        ];
        assert_eq!(found, expected);
    }

    #[test]
    fn every_job_is_on_record() {
        let record = record().unwrap();
        let counts = record["counts"].as_object().unwrap();
        for instructions in INSTRUCTIONS {
            for job in JOBS {
                let is_one = |name: &&String| name.starts_with(&format!("{job} ")) && name.ends_with(instructions);
                assert!(counts.keys().any(|name| is_one(&name)), "{job} by {instructions}");
            }
        }
    }

    #[test]
    fn the_probe_of_arithmetic_executes_next_to_nothing_beside_its_multiply_adds() {
        // Twelve chains of 4096 steps. Sums that are kept in memory, or a call for each, take several times as many.
        const REGISTERS: u64 = 12 * 4096;
        // A register takes one instruction by AVX2, and a turn of the loop another two or three. Plain code is
        // another matter: the compiler finds its registers at the level of releases alone.
        const LOOP: f64 = 0.25;
        let count = record().unwrap()["counts"][format!("{PROBE} avx2")].as_u64().unwrap() as f64 / REGISTERS as f64;
        assert!((1.0..1.0 + LOOP).contains(&count), "{count} instructions for a register");
    }

    #[test]
    fn the_total_of_a_dump_is_read() {
        assert_eq!(total("version: 1\nevents: Ir\nfn=(1) a\n1 2\ntotals: 1234\n"), Ok(1234));
        assert!(total("version: 1\ntotals: 0\n").is_err(), "nothing was counted");
    }
}
