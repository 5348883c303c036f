//! Generates the straight-line code of `lobe-sh`, products of one pair and of sixteen at once, the basis of sixteen
//! directions at once and the rotation of bands, and the basis and the products of `lobe-gpu`: `cargo xtask tables`. With
//! `--check` it only says which files differ from what it would write, and fails.
//!
//! It links the `lobe-sh` whose sources it writes, for the exact tensor of Gaunt coefficients, the constants of the
//! basis and the permutations of axes; what it generates it does not use, so that it can replace them whatever they contain, as long as they compile.

mod blocks;
mod cover;
mod graph;
#[cfg(test)]
mod greedy;
mod lane_basis;
mod plan;
mod product;
mod product_files;
mod rotation;
mod search;
mod text;
mod wgsl;
mod wgsl_expansion;
mod zonal;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use product::{of_one_order, products};
use text::HEADER;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let check = match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        [] => false,
        ["--check"] => true,
        _ => {
            eprintln!("expected --check or nothing, found {}", arguments.join(" "));
            return ExitCode::from(2);
        }
    };
    let faults = run(check);
    for fault in &faults {
        eprintln!("{fault}");
    }
    if faults.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// The folder of the workspace.
fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Writes the files, or with `check` only compares. The faults: files that differ, cannot be written, or are none of these.
fn run(check: bool) -> Vec<String> {
    let mut faults = Vec::new();
    for (folder, files) in generated() {
        let folder = root().join(folder);
        for (name, text) in &files {
            let path = folder.join(name);
            if check {
                let found = std::fs::read_to_string(&path).unwrap_or_default();
                if found != *text {
                    faults.push(format!("{} is not what `cargo xtask tables` writes", path.display()));
                }
            } else if let Err(error) = std::fs::write(&path, text) {
                faults.push(format!("{}: {error}", path.display()));
            }
        }
        faults.extend(strangers(&folder, &files));
    }
    faults
}

/// The folders of generated code, each with the names and texts of its files.
fn generated() -> Vec<(&'static str, Vec<(String, String)>)> {
    let products = products();
    let shaders = vec![
        ("basis.wgsl".into(), wgsl::basis(HEADER)),
        ("expansion.wgsl".into(), wgsl_expansion::expansion(HEADER)),
        ("product.wgsl".into(), wgsl::product(HEADER, of_one_order(&products))),
    ];
    vec![
        ("crates/lobe-sh/src/product/generated", product_files::of_pairs(&products)),
        ("crates/lobe-sh/src/product/fused", product_files::of_fused_pairs(&products)),
        ("crates/lobe-sh/src/product/lanes", product_files::of_lanes(&products)),
        ("crates/lobe-sh/src/basis/lanes", lane_basis::files(HEADER)),
        ("crates/lobe-sh/src/rotation/generated", rotation::files(HEADER)),
        ("crates/lobe-gpu/src/wgsl/generated", shaders),
    ]
}

/// Complaints about files in the folder that are not among those generated.
fn strangers(folder: &Path, files: &[(String, String)]) -> Vec<String> {
    let entries = match std::fs::read_dir(folder) {
        Ok(entries) => entries,
        Err(error) => return vec![format!("{}: {error}", folder.display())],
    };
    let names = entries.flatten().map(|entry| entry.file_name().to_string_lossy().into_owned());
    names
        .filter(|name| files.iter().all(|(known, _)| known != name))
        .map(|name| format!("{} is not a generated file", folder.join(name).display()))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn regenerating_changes_nothing() {
        assert_eq!(run(true), [""; 0], "run `cargo xtask tables`");
    }
}
