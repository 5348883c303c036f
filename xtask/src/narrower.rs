//! `test-plain`, `test-avx2`: the unit tests of crates with kernels once more, by narrower instructions than the machine has; with `--all` those of
//! folders `tests/all` too, which take twice as long.
//!
//! The programs are those that `cargo test --workspace` has compiled. With fewer packages the others would have other features, and be
//! compiled anew; so all are built, which takes no time after `cargo test --workspace`, and those of crates with kernels are run.

use std::path::PathBuf;
use std::process::{Command, Stdio};

use serde_json::Value;

use crate::outcome::{self, Outcome};
use crate::workspace;

/// The crates that choose their instructions by `lobe_sh::simd::Machine`.
const WITH_KERNELS: [&str; 5] = ["lobe-sh", "lobe-env", "lobe-scene", "lobe-prt", "lobe-shadow"];

/// Runs the tests by plain code, which is the specification of the others, or by AVX2, for machines without AVX-512.
pub(crate) fn run(instructions: &str, arguments: &[String]) -> Outcome {
    let kinds: &[&str] = match arguments {
        [] => &["lib"],
        [all] if all == "--all" => &["lib", "test"],
        other => return Err(vec![format!("expected --all or nothing, found {}", other.join(" "))]),
    };
    let tests = built(kinds).map_err(|fault| vec![fault])?;
    let mut faults = Vec::new();
    for krate in WITH_KERNELS {
        let of_crate: Vec<_> = tests.iter().filter(|tests| tests.package == krate).collect();
        if of_crate.len() != kinds.len() {
            let expected = format!("{} of kinds {}", kinds.len(), kinds.join(" and "));
            faults.push(format!("{krate}: expected programs of tests, {expected}, found {}", of_crate.len()));
        }
        for Tests { program, .. } in of_crate {
            println!("     {krate}: {}", program.display());
            let folder = workspace::root().join("crates").join(krate);
            let status =
                Command::new(program).current_dir(folder).arg("--quiet").env("LOBE_SIMD", instructions).status();
            if !status.as_ref().is_ok_and(std::process::ExitStatus::success) {
                faults.push(format!("LOBE_SIMD={instructions} {} failed: {status:?}", program.display()));
            }
        }
    }
    outcome::of(faults)
}

/// Whether AVX2 is narrower than what the tests without a limit run by.
///
/// # Errors
/// The reason why not.
pub(crate) fn is_avx2_narrower() -> Result<(), String> {
    #[cfg(target_arch = "x86_64")]
    let has_avx512 = std::is_x86_feature_detected!("avx512f");
    #[cfg(not(target_arch = "x86_64"))]
    let has_avx512 = false;
    let reason = || "this machine has no AVX-512: the step test runs by AVX2, or by what else it has".to_owned();
    has_avx512.then_some(()).ok_or_else(reason)
}

/// A program of tests, and the folder of its package.
struct Tests {
    package: String,
    program: PathBuf,
}

/// The tests of the whole workspace that are of these kinds of targets. All are built, as `cargo test --workspace` does:
/// by `--lib`, cargo would build those of libraries too that say that they have none.
fn built(kinds: &[&str]) -> Result<Vec<Tests>, String> {
    let arguments = ["test", "--workspace", "--no-run", "--message-format=json"];
    let output = Command::new(workspace::cargo())
        .current_dir(workspace::root())
        .args(arguments)
        .stderr(Stdio::inherit())
        .output();
    let output = output.map_err(|error| format!("cargo did not start: {error}"))?;
    if !output.status.success() {
        return Err(format!("cargo {} failed ({})", arguments.join(" "), output.status));
    }
    Ok(String::from_utf8_lossy(&output.stdout).lines().filter_map(|line| tests_of(line, kinds)).collect())
}

/// The program of tests of one of these kinds that a message of cargo tells of, if it does. Of integration tests that is `all`.
fn tests_of(message: &str, kinds: &[&str]) -> Option<Tests> {
    let message: Value = serde_json::from_str(message).ok()?;
    let target = &message["target"];
    let kind = kinds.iter().find(|kind| target["kind"][0] == **kind)?;
    if *kind == "test" && target["name"] != "all" {
        return None;
    }
    let program = message["executable"].as_str().filter(|_| message["profile"]["test"] == true)?;
    let package = PathBuf::from(message["manifest_path"].as_str()?);
    Some(Tests { package: package.parent()?.file_name()?.to_str()?.to_owned(), program: program.into() })
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn programs_of_tests_are_told_from_libraries_and_programs() {
        let message = |test: bool, kind: &str, name: &str, executable: &str| {
            format!(
                r#"{{"reason":"compiler-artifact","manifest_path":"/w/crates/lobe-sh/Cargo.toml","target":{{"kind":["{kind}"],"name":"{name}"}},"profile":{{"test":{test}}},"executable":{executable}}}"#
            )
        };
        let program = "\"/w/target/debug/deps/lobe_sh-1\"";
        let unit = message(true, "lib", "lobe_sh", program);
        let found = tests_of(&unit, &["lib"]).expect("tests");
        assert_eq!((found.package.as_str(), found.program), ("lobe-sh", "/w/target/debug/deps/lobe_sh-1".into()));
        let all = message(true, "test", "all", program);
        assert!(tests_of(&all, &["lib"]).is_none() && tests_of(&all, &["lib", "test"]).is_some(), "{all}");
        for other in [
            message(true, "test", "malformed", program),
            message(false, "bin", "lobe", "\"/w/target/debug/lobe\""),
            message(false, "lib", "lobe_sh", program),
            message(true, "lib", "lobe_sh", "null"),
            "no JSON".to_owned(),
        ] {
            assert!(tests_of(&other, &["lib", "test"]).is_none(), "{other}");
        }
    }

    #[test]
    fn the_crates_are_those_that_ask_for_the_instructions() {
        let asks = |path: &PathBuf| workspace::read(path).is_ok_and(|text| text.contains("Machine::detect()"));
        let of_crate = |path: &PathBuf| {
            let path = workspace::relative(path);
            let (krate, _) = path.strip_prefix("crates/")?.split_once("/src/")?;
            Some(krate.to_owned())
        };
        let found: BTreeSet<_> =
            workspace::files("rs").unwrap().iter().filter(|path| asks(path)).filter_map(of_crate).collect();
        assert_eq!(found, WITH_KERNELS.map(str::to_owned).into(), "crates with kernels");
    }
}
