//! Continuous integration: `ci` runs what every change has to pass, in three parts of which `.ci/run` runs two beside each other; `quick` the fast checks, `nightly` the long ones.

use crate::outcome::Outcome;
use crate::step::{Step, Work, run_all};
use crate::{arch, corpus, dependencies, documents, goldens, instructions, narrower, sizes, toolchain};

const DENY_DOC_WARNINGS: &[(&str, &str)] = &[("RUSTDOCFLAGS", "-D warnings")];

const FMT: Step = Step { name: "fmt", work: Work::Cargo("fmt --all --check", &[]) };
const ARCH: Step = Step { name: "arch", work: Work::Chore(arch::check) };
const DEPENDENCIES: Step = Step { name: "dependencies", work: Work::Chore(dependencies::check) };
const SIZES: Step = Step { name: "sizes", work: Work::Chore(sizes::check) };
const DOCUMENTS: Step = Step { name: "documents", work: Work::Chore(documents::check) };
const GOLDENS: Step = Step { name: "goldens", work: Work::Chore(goldens::check) };
const CLIPPY: Step =
    Step { name: "clippy", work: Work::Cargo("clippy --workspace --all-targets --all-features -- -D warnings", &[]) };
/// The mathematics alone, without files. At night: [`NO_STD`] and [`WASM`] check the same for other machines.
const FEATURES: Step = Step {
    name: "no-features",
    work: Work::Cargo("check --package lobe-sh --no-default-features --features libm", &[]),
};
/// The README's command, word for word: the command and its libraries as users build them. At night, because dependencies are compiled
/// again for it: other steps have the features that any crate of the workspace asks for.
const DEFAULTS: Step = Step { name: "default-members", work: Work::Cargo("test", &[]) };
/// The Python package as it is built for users: in the whole workspace a dependency may get features from another crate.
const PYTHON_ALONE: Step = Step { name: "python-alone", work: Work::Cargo("check --package lobe-python", &[]) };
/// The window likewise.
const VIEWER_ALONE: Step = Step { name: "viewer-alone", work: Work::Cargo("check --package lobe-viewer", &[]) };
/// The mathematics in a browser: nothing of the standard library is used.
const WASM: Step = Step {
    name: "wasm32",
    work: Work::Where(
        || toolchain::has_target("wasm32-unknown-unknown"),
        "cargo",
        "check --package lobe-sh --no-default-features --features libm --target wasm32-unknown-unknown",
    ),
};
/// The same on a microcontroller, where there is no standard library, with all that converts.
const NO_STD: Step = Step {
    name: "no-std",
    work: Work::Where(
        || toolchain::has_target("thumbv7em-none-eabihf"),
        "cargo",
        "check --package lobe-sh --no-default-features --features libm,batch,serde,bytemuck,glam,mint --target thumbv7em-none-eabihf",
    ),
};
/// The oldest Rust that the Cargo.toml files promise.
const OLDEST_RUST: Step = Step {
    name: "oldest-rust",
    work: Work::Where(
        toolchain::has_oldest_rust,
        "rustup",
        "run 1.95.0 cargo check --workspace --all-targets --target-dir target/oldest-rust",
    ),
};
/// Spelling.
const TYPOS: Step = Step { name: "typos", work: Work::Tool("typos", "--format brief", "pip install typos") };
/// Licenses, and crates that are there twice; see deny.toml.
const DENY: Step = Step {
    name: "deny",
    work: Work::Tool("cargo-deny", "--workspace check bans licenses sources", "cargo install --locked cargo-deny"),
};
/// The documentation for maintainers: every link is checked, those of private items too. At night: it takes as long as [`DOCS`].
const DOCS_PRIVATE: Step = Step {
    name: "docs-private",
    work: Work::Cargo("doc --workspace --no-deps --document-private-items", DENY_DOC_WARNINGS),
};
/// The documentation for users: a link from a public item to a private one is an error. With all features, as [`CLIPPY`], which has
/// checked the dependencies with them.
const DOCS: Step =
    Step { name: "docs", work: Work::Cargo("doc --workspace --all-features --no-deps", DENY_DOC_WARNINGS) };
/// The guide as a book, in target/guide.
const BOOK: Step = Step { name: "book", work: Work::Where(toolchain::has_mdbook, "mdbook", "build docs/guide") };
/// The README's command for the whole workspace: the tests of [`DEFAULTS`], and those of the window, Python and the tools.
const TEST: Step = Step { name: "test", work: Work::Cargo("test --workspace", &[]) };
/// The unit tests of crates with kernels once more for each narrower kind of instructions, for which every kernel has code of its own.
/// By this program and not by another `cargo run`, which changes PATH: the Python package would be compiled anew for it.
const TEST_PLAIN: Step = Step { name: "test-plain", work: Work::Chore(|| narrower::run("plain", &[])) };
const TEST_AVX2: Step =
    Step { name: "test-avx2", work: Work::ChoreWhere(narrower::is_avx2_narrower, || narrower::run("avx2", &[])) };
/// At night with all tests of those crates.
const TEST_PLAIN_ALL: Step =
    Step { name: "test-plain-all", work: Work::Chore(|| narrower::run("plain", &["--all".to_owned()])) };
const TEST_AVX2_ALL: Step = Step {
    name: "test-avx2-all",
    work: Work::ChoreWhere(narrower::is_avx2_narrower, || narrower::run("avx2", &["--all".to_owned()])),
};
/// The instructions that kernels execute: the times of a shared machine tell too little.
const INSTRUCTIONS: Step =
    Step { name: "instructions", work: Work::ChoreWhere(instructions::can_count, || instructions::run(&[])) };
/// The other encoder of BC6H, which links a C++ library, and JPEG XL, whose decoder takes long to compile: the tests of files.
const TEST_FEATURES: Step =
    Step { name: "test-features", work: Work::Cargo("test --package lobe-image --features bc6h,jxl", &[]) };

/// The fuzz targets, in a workspace of their own: libFuzzer is compiled C++, which takes a minute, so that they are checked at night. Not
/// linked: `cargo fuzz` builds them with what guides it.
const FMT_FUZZ: Step = Step { name: "fmt-fuzz", work: Work::Cargo("fmt --manifest-path fuzz/Cargo.toml --check", &[]) };
const FUZZ: Step =
    Step { name: "fuzz", work: Work::Cargo("check --locked --manifest-path fuzz/Cargo.toml --target-dir target", &[]) };

/// The comparisons with peers, in workspaces of their own: they link with what nothing else needs. Checked at night, not linked.
const FMT_PEERS: Step =
    Step { name: "fmt-peers", work: Work::Cargo("fmt --manifest-path peers/embree/Cargo.toml --check", &[]) };
const FMT_BEVY: Step =
    Step { name: "fmt-bevy", work: Work::Cargo("fmt --manifest-path peers/bevy/Cargo.toml --check", &[]) };
const PEERS: Step = Step {
    name: "peers",
    work: Work::Cargo("check --locked --manifest-path peers/embree/Cargo.toml --target-dir target", &[]),
};

/// A few public models and maps, where they can be fetched.
const CORPUS: Step =
    Step { name: "corpus", work: Work::ChoreWhere(corpus::has_small_part, || corpus::run(&["--small".to_owned()])) };

/// All of them.
const CORPUS_WHOLE: Step =
    Step { name: "corpus-whole", work: Work::ChoreWhere(corpus::has_small_part, || corpus::run(&[])) };
/// The program as users build it, for the peers of [`nightly`].
const RELEASE: Step = Step {
    name: "release",
    work: Work::Cargo(
        "build --release --package lobe-cli --package lobe-scene --example poses --bin lobe --features lobe-cli/compressed",
        &[],
    ),
};
/// Other programs read what Lobe writes: the glTF validator, engines of the web, `OpenEXR`.
const READERS: Step = Step {
    name: "readers",
    work: Work::Where(has_node_and_chromium, "node", "peers/readers/readers.mjs target/release/lobe"),
};
/// Engines of the web show what `lobe export` writes for them.
const ENGINES: Step = Step {
    name: "engines",
    work: Work::Where(
        has_node_and_chromium,
        "node",
        "peers/engines/engines.mjs target/release/lobe three babylon playcanvas filament bevy",
    ),
};
/// Baked scenes go through other programs that write glTF files.
const ROUNDTRIPS: Step = Step {
    name: "roundtrips",
    work: Work::Where(has_node, "node", "peers/roundtrips/roundtrips.mjs target/release/lobe"),
};
/// Compilers of other languages take the functions for shaders, and devices compute the numbers of the library with
/// them.
const SHADERS: Step = Step {
    name: "shaders",
    work: Work::Where(has_compilers_of_shaders, "python3", "peers/shaders/shaders.py target/release/lobe"),
};
/// Cube maps in bevy, which is compiled for it.
const BEVY: Step = Step {
    name: "bevy",
    work: Work::Cargo(
        "run --locked --manifest-path peers/bevy/Cargo.toml --target-dir target/bevy -- target/release/lobe",
        &[],
    ),
};
/// Another program poses what Lobe poses.
const MOTION: Step = Step {
    name: "motion",
    work: Work::Where(has_node, "node", "peers/motion/motion.mjs target/release/examples/poses"),
};
/// Characters of others are lit by spheres as by paths.
const LIT: Step = Step {
    name: "lit",
    work: Work::Where(has_node, "node", "peers/motion/lit.mjs target/release/lobe Fox dolphin spider_animated"),
};
/// Another renderer bakes what Lobe bakes.
const MITSUBA: Step =
    Step { name: "mitsuba", work: Work::Where(has_mitsuba, "python3", "peers/mitsuba/compare.py target/release/lobe") };
/// It tilts normals as Lobe does.
const NORMAL_MAPS: Step = Step {
    name: "normal-maps",
    work: Work::Where(has_mitsuba, "python3", "peers/mitsuba/normal_maps.py target/release/lobe"),
};
/// It sees animated characters as Lobe does.
const CHARACTERS: Step = Step {
    name: "characters",
    work: Work::Where(has_mitsuba_and_node, "python3", "peers/mitsuba/characters.py target/release/lobe"),
};
/// It shades by Lobe's rule as Lobe does where normals tilt off their triangles, and by its own rule otherwise.
const BENT_NORMALS: Step = Step {
    name: "bent-normals",
    work: Work::Where(has_mitsuba, "python3", "peers/mitsuba/bent_normals.py target/release/lobe"),
};
/// Another program looks through fisheye lenses.
const FISHEYE: Step =
    Step { name: "fisheye", work: Work::Where(has_ffmpeg, "python3", "peers/fisheye/compare.py target/release/lobe") };
/// Libraries of the sciences evaluate the coefficients that they are given, and give theirs.
const CONVENTIONS: Step = Step {
    name: "conventions",
    work: Work::Where(has_python, "python3", "peers/conventions/conventions.py target/release/lobe"),
};
/// The window in a browser.
const WEB: Step =
    Step { name: "web", work: Work::Where(has_node_and_chromium, "cargo", "run --package xtask -- web --check") };

fn has_node() -> Result<(), String> {
    toolchain::has_program("node", "https://nodejs.org")
}

fn has_node_and_chromium() -> Result<(), String> {
    has_node()?;
    toolchain::has_program("chromium", "apt-get install chromium")
}

fn has_python() -> Result<(), String> {
    toolchain::has_program("python3", "https://www.python.org")
}

fn has_compilers_of_shaders() -> Result<(), String> {
    has_node_and_chromium()?;
    toolchain::has_program("glslangValidator", "apt-get install glslang-tools")?;
    toolchain::has_program("spirv-val", "apt-get install spirv-tools")?;
    toolchain::has_program("clang++", "apt-get install clang")?;
    toolchain::has_module("wgpu")
}

fn has_ffmpeg() -> Result<(), String> {
    toolchain::has_program("ffmpeg", "apt-get install ffmpeg")?;
    toolchain::has_module("numpy")
}

fn has_mitsuba() -> Result<(), String> {
    toolchain::has_module("mitsuba")
}

fn has_mitsuba_and_node() -> Result<(), String> {
    has_mitsuba()?;
    has_node()
}

/// The tests that take longest, which no other group runs.
const TEST_LONG: Step = Step {
    name: "test-long",
    work: Work::Cargo("test --workspace --lib --test all --test bench --test cli --test python -- --ignored", &[]),
};
/// The same bytes from every command by any number of threads.
const OUTPUTS: Step =
    Step { name: "outputs", work: Work::Cargo("run --package xtask -- outputs target/release/lobe", &[]) };

/// Licenses, what is in other workspaces, and what takes long or needs other programs: the whole corpus, and every peer that judges files and pictures.
pub(crate) fn nightly() -> Outcome {
    run_all(&[
        DENY,
        DOCS_PRIVATE,
        FUZZ,
        PEERS,
        FEATURES,
        PYTHON_ALONE,
        VIEWER_ALONE,
        DEFAULTS,
        TEST_LONG,
        TEST_PLAIN_ALL,
        TEST_AVX2_ALL,
        TEST_FEATURES,
        RELEASE,
        OUTPUTS,
        READERS,
        ENGINES,
        ROUNDTRIPS,
        SHADERS,
        BEVY,
        MOTION,
        LIT,
        MITSUBA,
        NORMAL_MAPS,
        CHARACTERS,
        BENT_NORMALS,
        FISHEYE,
        CONVENTIONS,
        WEB,
        CORPUS_WHOLE,
    ])
}

/// What reads files and compiles nothing.
const CHECKS: &[Step] = &[FMT, FMT_FUZZ, FMT_PEERS, FMT_BEVY, ARCH, DEPENDENCIES, SIZES, DOCUMENTS, GOLDENS];

/// What is found without running anything of the project.
const LINTS: &[Step] = &[CLIPPY, WASM, NO_STD, OLDEST_RUST, DOCS, BOOK];

/// The tests, and what needs the tools that `.ci/run` installs.
const TESTS: &[Step] = &[TYPOS, TEST, TEST_PLAIN, TEST_AVX2, INSTRUCTIONS, CORPUS];

/// The first part of [`ci`].
pub(crate) fn checks() -> Outcome {
    run_all(CHECKS)
}

/// The second part, which may run beside the third in a target folder of its own.
pub(crate) fn lints() -> Outcome {
    run_all(LINTS)
}

/// The third part of [`ci`].
pub(crate) fn tests() -> Outcome {
    run_all(TESTS)
}

/// Everything.
pub(crate) fn ci() -> Outcome {
    run_all(&[CHECKS, LINTS, TESTS].concat())
}

/// The steps to run before each commit.
pub(crate) fn quick() -> Outcome {
    const CHECK: Step =
        Step { name: "clippy", work: Work::Cargo("clippy --workspace --all-targets -- -D warnings", &[]) };
    const UNIT: Step = Step { name: "unit", work: Work::Cargo("test --quiet --package lobe-sh --lib", &[]) };
    run_all(&[FMT, ARCH, SIZES, CHECK, UNIT])
}
