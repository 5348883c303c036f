//! Chores of the repository: `cargo xtask CHORE`. Without a chore it lists them.

mod arch;
mod bakes;
mod bench;
mod ci;
mod corpus;
mod dependencies;
mod documents;
mod goldens;
mod instructions;
mod narrower;
mod outcome;
mod outputs;
mod shaders;
mod sizes;
mod step;
mod suns;
mod tables;
mod toolchain;
mod web;
mod workspace;

use std::process::ExitCode;

use outcome::Outcome;

/// A chore: the arguments after its name in, an [`Outcome`] out.
type Chore = fn(&[String]) -> Outcome;

/// Every chore: its name, its help, its function.
const CHORES: &[(&str, &str, Chore)] = &[
    ("ci", "everything continuous integration checks, each step with its time", |_| ci::ci()),
    ("ci-checks", "its first part, which compiles nothing", |_| ci::checks()),
    ("ci-lints", "its second part: what is found without running anything", |_| ci::lints()),
    ("ci-tests", "its third part: the tests, and what needs other tools", |_| ci::tests()),
    ("nightly", "licenses, what takes long or needs other programs: the whole corpus and the peers", |_| ci::nightly()),
    ("quick", "what to run before each commit: under 30 s when warm", |_| ci::quick()),
    (
        "arch",
        "ARCHITECTURE.md's arrows against the code's, circles between files; --circles, --draw [CRATE]",
        arch::run,
    ),
    ("dependencies", "the crates that lobe-sh brings along by default, none", |_| dependencies::check()),
    ("sizes", "the length of every Rust file", |_| sizes::check()),
    ("bench", "the kernels beside their floors and other libraries, measured here in one run", bench::bench),
    ("documents", "links between documents, and citations against REFERENCES.bib", |_| documents::check()),
    ("tables", "writes the generated code of lobe-sh and lobe-gpu; with --check only compares", tables::run),
    (
        "shaders",
        "writes the functions for shaders in lobe-shaders from the WGSL of lobe-gpu; with --check only compares",
        shaders::run,
    ),
    ("outputs", "two builds of the command write the same bytes: PROGRAM-BEFORE PROGRAM-AFTER", outputs::run),
    (
        "corpus",
        "the command on public models and maps, fetched into a cache: [PROGRAM] [--small] [FOLDER ..]",
        corpus::run,
    ),
    (
        "bakes",
        "default bakes against path traced pictures: [PROGRAM] [--before PROGRAM] [--pictures] [--write] [SCENE ..]",
        bakes::run,
    ),
    (
        "suns",
        "pictures with suns in the expansion and apart against path traced ones: [PROGRAM] [--scene SCENE].. \
         [--surfaces MODEL] MAP..",
        suns::run,
    ),
    ("web", "the viewer as a page for any static host, in target/web; --check looks at it in Chromium", web::run),
    (
        "instructions",
        "what kernels execute, counted by valgrind, against the counts on record; --write records them",
        instructions::run,
    ),
    (
        "test-plain",
        "the unit tests of crates with kernels by plain code, after `cargo test --workspace`; with --all those of tests/all too",
        |arguments| narrower::run("plain", arguments),
    ),
    ("test-avx2", "the same by AVX2", |arguments| narrower::run("avx2", arguments)),
    ("goldens", "the golden values are there, and read by a test", |_| goldens::check()),
];

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let chore = arguments.first().and_then(|name| CHORES.iter().find(|(chore, ..)| chore == name));
    let Some((name, _, run)) = chore else {
        eprintln!("usage: cargo xtask CHORE");
        for (name, what, _) in CHORES {
            eprintln!("  {name:<10} {what}");
        }
        return ExitCode::from(2);
    };
    match run(&arguments[1..]) {
        Ok(()) => ExitCode::SUCCESS,
        Err(faults) => {
            for fault in faults {
                eprintln!("{name}: {fault}");
            }
            ExitCode::FAILURE
        }
    }
}
