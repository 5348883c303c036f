//! `bench`: runs the benchmarks and prints each beside its peer and its floor.

use std::path::Path;
use std::process::Command;

use serde_json::Value;

use crate::outcome::Outcome;
use crate::workspace;

/// The reference times of a benchmark: nanoseconds an item on the reference machine, two AVX-512 Xeon cores at 3.8 GHz,
/// one thread, every peer in its own best build and checked to give the same numbers.
struct Reference {
    /// The name that Criterion gives the benchmark.
    id: &'static str,
    /// The best peer that does the same work.
    peer: &'static str,
    /// The peer's time.
    peer_ns: f64,
    /// The larger of the time for the arithmetic at the rate of fused multiply-adds and that for the bytes at the
    /// rate of the memory level they live in. NaN where no floor was worked out.
    floor_ns: f64,
}

const fn reference(id: &'static str, peer: &'static str, peer_ns: f64, floor_ns: f64) -> Reference {
    Reference { id, peer, peer_ns, floor_ns }
}

/// Measured for this project side by side in one session; see the README of the benchmarks.
#[expect(clippy::approx_constant, reason = "one peer's time happens to be 6.28 ns")]
const REFERENCES: &[Reference] = &[
    reference("basis-cached-f32/2", "sphericart", 0.77, 0.40),
    reference("basis-cached-f32/3", "DirectXMath", 2.61, 0.40),
    reference("basis-cached-f32/4", "DirectXMath", 4.50, 0.40),
    reference("basis-cached-f32/5", "DirectXMath", 6.20, 0.41),
    reference("basis-cached-f32/6", "DirectXMath", 9.92, 0.60),
    reference("basis-cached-f32/10", "sphericart", 53.8, 1.66),
    reference("basis-cached-f32/20", "sphericart (2.5e-2 off)", 226.0, 6.6),
    reference("basis-streamed-f32/2", "Dr.Jit", 0.87, 0.94),
    reference("basis-streamed-f32/3", "Dr.Jit", 1.62, 1.62),
    reference("basis-streamed-f32/4", "Dr.Jit", 3.36, 2.57),
    reference("basis-streamed-f32/5", "Dr.Jit", 6.28, 4.27),
    reference("basis-streamed-f32/6", "Dr.Jit", 10.2, 5.97),
    reference("basis-streamed-f32/10", "Dr.Jit", 30.6, 17.2),
    reference("basis-streamed-f32/20", "sphericart (2.5e-2 off)", 240.0, 67.0),
    reference("rotation-build-f64/3", "google", 350.0, f64::NAN),
    reference("rotation-build-f64/4", "google", 970.0, f64::NAN),
    reference("rotation-build-f64/5", "google", 2050.0, f64::NAN),
    reference("rotation-build-f64/6", "google", 3790.0, f64::NAN),
    reference("rotation-build-f64/10", "google", 19800.0, f64::NAN),
    reference("rotation-one-f32/3", "DirectXMath", 11.9, f64::NAN),
    reference("rotation-one-f32/4", "DirectXMath", 21.2, f64::NAN),
    reference("rotation-one-f32/5", "DirectXMath", 34.0, f64::NAN),
    reference("rotation-one-f32/6", "DirectXMath", 51.8, f64::NAN),
    reference("rotation-one-f32/10", "ducc0", 5560.0, f64::NAN),
    reference("rotation-one-f32/64", "SHTns", 101_000.0, f64::NAN),
    reference("rotation-many-f32/3", "BLAS", 5.7, 2.46),
    reference("rotation-many-f32/4", "BLAS", 11.0, 4.38),
    reference("rotation-many-f32/5", "BLAS", 21.8, 7.15),
    reference("rotation-many-f32/6", "BLAS", 42.8, 10.3),
    reference("rotation-many-f32/10", "BLAS", 175.0, 33.0),
    reference("product-f32/2", "DirectXMath", 2.99, 0.48),
    reference("product-f32/3", "DirectXMath", 15.8, 1.07),
    reference("product-f32/4", "DirectXMath", 52.5, 3.0),
    reference("product-f32/5", "DirectXMath", 149.0, 8.8),
    reference("product-f32/6", "DirectXMath", 335.0, 20.0),
    reference("dering-one-rgb-f32/3", "Filament auto", 1380.0, f64::NAN),
    reference("dering-batch-rgb-f32/3", "Filament auto", 1380.0, f64::NAN),
    reference("window-rgb-f32/3", "sh-lib", 7.9, f64::NAN),
    reference("project-1-threads/3", "SHTns", 6.39, 0.41),
    reference("project-1-threads/6", "SHTns", 6.19, 0.41),
    reference("project-2-threads/3", "SHTns", 3.08, 0.21),
    reference("project-2-threads/6", "SHTns", 3.05, 0.21),
    reference("ggx-chain-256-to-16-1-threads/gather", "Filament, 1024 samples", 2.46e9, 0.13e9),
    reference("ggx-chain-256-to-16-1-threads/importance-1024", "Filament, 1024 samples", 2.46e9, 0.13e9),
    reference("ggx-chain-256-to-16-2-threads/gather", "Filament, 1024 samples", 1.23e9, 0.07e9),
    reference("ggx-chain-256-to-16-2-threads/importance-1024", "Filament, 1024 samples", 1.23e9, 0.07e9),
    // A normal and a sample of Filament's, which takes 1024 of them instead of all texels.
    reference("irradiance-brute-force/1", "Filament, sampled", 27.8, 0.037),
    reference("irradiance-brute-force/2", "Filament, sampled", 14.0, 0.019),
    // No peer was measured.
    reference("convert-4096-to-cube-1024/2", "the wish, 2 s", 238.0, f64::NAN),
];

/// Runs `cargo bench` with the given arguments, then prints the table of all that has been measured so far.
///
/// With `--table` alone nothing is run.
pub(crate) fn bench(arguments: &[String]) -> Outcome {
    if arguments != ["--table"] {
        let status = Command::new(workspace::cargo())
            .args(["bench", "--package", "lobe-sh", "--package", "lobe-env"])
            .args(arguments)
            .status()
            .map_err(|error| vec![format!("cargo cannot be started: {error}")])?;
        if !status.success() {
            return Err(vec![format!("cargo bench failed: {status}")]);
        }
    }
    let folder = workspace::root().join("target/criterion");
    let mut measured = Vec::new();
    collect(&folder, &mut measured);
    if measured.is_empty() {
        return Err(vec![format!("nothing measured in {}: run cargo xtask bench", folder.display())]);
    }
    measured.sort_by_cached_key(|result| natural(&result.id));
    print!("{}", table(&measured));
    Ok(())
}

/// One result of Criterion: the median, an item.
struct Measured {
    id: String,
    ns: f64,
}

/// Gathers every `new/estimates.json` below `folder`.
fn collect(folder: &Path, measured: &mut Vec<Measured>) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    for path in entries.flatten().map(|entry| entry.path()).filter(|path| path.is_dir()) {
        if path.ends_with("new") {
            measured.extend(read(&path));
        } else {
            collect(&path, measured);
        }
    }
}

fn read(folder: &Path) -> Option<Measured> {
    let json = |name: &str| -> Option<Value> { serde_json::from_str(&workspace::read(&folder.join(name)).ok()?).ok() };
    let (estimates, benchmark) = (json("estimates.json")?, json("benchmark.json")?);
    let ns = estimates.pointer("/median/point_estimate")?.as_f64()?;
    let items = benchmark.pointer("/throughput/Elements").and_then(Value::as_f64).unwrap_or(1.0);
    Some(Measured { id: benchmark["full_id"].as_str()?.to_owned(), ns: ns / items })
}

/// Sorts numbers inside names by value.
fn natural(id: &str) -> Vec<(String, u64)> {
    id.split('/')
        .map(|part| (part.trim_matches(|c: char| c.is_ascii_digit()).to_owned(), part.parse().unwrap_or(0)))
        .collect()
}

fn table(measured: &[Measured]) -> String {
    let mut table = format!(
        "{:<34}{:>12}  {:<34}{:>9}  {:>9}{:>9}\n",
        "benchmark", "ns an item", "peer", "x peer", "floor", "x floor"
    );
    for Measured { id, ns } in measured {
        let live = id.replace("/lobe/", "/sphrs/");
        let live = measured.iter().find(|other| live != *id && other.id == live);
        let (peer, peer_ns, floor_ns) = match (live, REFERENCES.iter().find(|r| r.id == *id)) {
            (Some(other), _) => ("sphrs, here".to_owned(), other.ns, f64::NAN),
            (None, Some(r)) => (format!("{} {}", r.peer, number(r.peer_ns)), r.peer_ns, r.floor_ns),
            (None, None) => (String::new(), f64::NAN, f64::NAN),
        };
        table += &format!(
            "{id:<34}{:>12}  {peer:<34}{:>9}  {:>9}{:>9}\n",
            number(*ns),
            number(ns / peer_ns),
            number(floor_ns),
            number(ns / floor_ns)
        );
    }
    table
        + "\nPeers and floors are those of the reference machine (crates/lobe-sh/benches/README.md); sphrs ran here.\n"
}

/// Three significant digits; nothing for NaN.
fn number(x: f64) -> String {
    if x.is_nan() {
        return String::new();
    }
    let digits = (2 - x.abs().log10().floor() as i32).max(0) as usize;
    format!("{x:.digits$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_sets_results_beside_peers_and_floors() {
        let measured = |id: &str, ns| Measured { id: id.to_owned(), ns };
        let table = table(&[
            measured("basis-cached-f32/6", 4.96),
            measured("basis-one-f64/lobe/6", 10.0),
            measured("basis-one-f64/sphrs/6", 40.0),
            measured("ggx-chain-256-to-16-1-threads/gather", 0.492e9),
        ]);
        let rows: Vec<Vec<&str>> = table.lines().map(|line| line.split_whitespace().collect()).collect();
        assert_eq!(rows[1], ["basis-cached-f32/6", "4.96", "DirectXMath", "9.92", "0.500", "0.600", "8.27"], "{table}");
        assert_eq!(rows[4][..2], ["ggx-chain-256-to-16-1-threads/gather", "492000000"], "{table}");
        assert!(rows[4].contains(&"Filament,") && rows[4].contains(&"0.200"), "{table}");
        assert_eq!(rows[2], ["basis-one-f64/lobe/6", "10.0", "sphrs,", "here", "0.250"], "{table}");
    }

    #[test]
    fn orders_sort_by_value() {
        assert!(natural("basis/6") < natural("basis/10"), "6 before 10");
    }
}
