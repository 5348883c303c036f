//! Runs the tests of the package `lobe`, which are Python's, on the library that cargo has just built.
//!
//! They need Python 3.10 or later with numpy, scipy, pytest, hypothesis and mypy: `python3`, or the interpreter that the environment
//! variable `LOBE_PYTHON` names. Where something is missing the test says that it is skipped, and what is missing.

use std::env;
use std::env::consts::{DLL_PREFIX, DLL_SUFFIX};
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// What the tests import, beside the standard library.
const PACKAGES: &str = "numpy, scipy.special, pytest, hypothesis, mypy";

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The interpreter, if it has all that the tests need.
fn interpreter() -> Option<OsString> {
    let python = env::var_os("LOBE_PYTHON").unwrap_or_else(|| "python3".into());
    let check = format!("import sys; assert sys.version_info >= (3, 10), 'Python 3.10'\nimport {PACKAGES}");
    let missing = match Command::new(&python).args(["-c", &check]).output() {
        Ok(output) if output.status.success() => return Some(python),
        Ok(output) => String::from_utf8_lossy(&output.stderr).lines().last().unwrap_or_default().to_owned(),
        Err(error) => error.to_string(),
    };
    lobe_testkit::skipped(&format!("the tests of the Python package: {}: {missing}", python.display()));
    None
}

/// The package as a folder: its sources, and the library under the name that Python looks for.
fn package() -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("package");
    let package = folder.join("lobe");
    fs::create_dir_all(&package).expect("a folder for the package");
    for entry in fs::read_dir(root().join("python/lobe")).expect("the sources of the package") {
        let path = entry.expect("an entry of the package").path();
        if path.is_file() {
            fs::copy(&path, package.join(path.file_name().expect("a name"))).expect("a copy of the sources");
        }
    }
    let program = env::current_exe().expect("the path of the test");
    let built = program.with_file_name(format!("{DLL_PREFIX}lobe_python{DLL_SUFFIX}"));
    let name = if cfg!(windows) { "_lobe.pyd" } else { "_lobe.abi3.so" };
    fs::copy(&built, package.join(name)).unwrap_or_else(|error| panic!("{}: {error}", built.display()));
    folder
}

/// Runs a module of Python on the package, in a folder of its sources.
fn passes(python: &OsString, package: &Path, module: &str, arguments: &[&str]) {
    let mut command = Command::new(python);
    command.args(["-m", module]).args(arguments).current_dir(root());
    command.env("PYTHONPATH", package).env("MYPYPATH", package).env("PYTHONDONTWRITEBYTECODE", "1");
    // The command that lies beside the tests, to compare with.
    let lobe = env::current_exe().ok().and_then(|program| Some(program.parent()?.parent()?.join("lobe")));
    if let Some(lobe) = lobe.filter(|lobe| lobe.exists()) {
        command.env("LOBE", lobe);
    }
    let output = command.output().expect("a Python that starts");
    let text = [output.stdout, output.stderr].map(|bytes| String::from_utf8_lossy(&bytes).into_owned()).concat();
    println!("{text}");
    for line in text.lines().filter(|line| line.starts_with("SKIPPED")) {
        lobe_testkit::skipped(&format!("of the Python package, {}", line.trim_start_matches("SKIPPED ")));
    }
    assert!(output.status.success(), "{module}: {text}");
}

/// Runs the tests of the package that a marker of pytest chooses, by `processes` where pytest can share them out.
fn tests_pass(python: &OsString, package: &Path, marker: &str, processes: &str) {
    let mut arguments = vec!["-p", "no:cacheprovider", "-m", marker, "tests"];
    if Command::new(python).args(["-c", "import xdist"]).output().is_ok_and(|output| output.status.success()) {
        arguments.extend(["--numprocesses", processes, "--dist", "loadfile"]);
    }
    passes(python, package, "pytest", &arguments);
}

#[test]
fn the_tests_of_the_package_pass_and_its_types_are_strict() {
    let Some(python) = interpreter() else { return };
    let package = package();
    // More than there are processors, mostly: much of the time of these tests is waiting for clusters.
    tests_pass(&python, &package, "not nightly", "3");
    passes(&python, &package, "mypy", &["--cache-dir=/dev/null", "python/lobe"]);
}

#[test]
#[ignore = "long: of the nightly group"]
fn the_long_tests_of_the_package_pass() {
    let Some(python) = interpreter() else { return };
    tests_pass(&python, &package(), "nightly", "1");
}
