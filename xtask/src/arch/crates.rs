//! The arrows between crates: the block `arrows` of ARCHITECTURE.md against the Cargo.toml files.
//!
//! ```text
//! lobe-env  ->  lobe-sh
//! lobe-sh   ->  nothing
//! ```

use super::blocks::{self, Block, DOCUMENT, Line};
use crate::workspace::Package;

/// The language of the block.
const LANGUAGE: &str = "arrows";

/// Compares the document with the packages.
pub(super) fn faults(blocks: &[Block], packages: &[Package]) -> Vec<String> {
    match blocks::only(blocks, LANGUAGE) {
        Ok(Some(block)) => compare(&block.lines, packages),
        Ok(None) => vec![format!("{DOCUMENT} has no code block of language `{LANGUAGE}`")],
        Err(fault) => vec![fault],
    }
}

/// One fault for each crate and each arrow that is missing on either side, or points up.
fn compare(lines: &[Line], packages: &[Package]) -> Vec<String> {
    let mut faults = Vec::new();
    for (position, line) in lines.iter().enumerate() {
        let name = &line.name;
        let Some(package) = packages.iter().find(|package| &package.name == name) else {
            faults.push(format!("{DOCUMENT} lists {name}, which is no crate of the workspace"));
            continue;
        };
        for used in &line.uses {
            if !package.uses.contains(used) {
                faults.push(format!("{name} -> {used} stands in {DOCUMENT}, but {name} does not depend on {used}"));
            }
            if !lines[position + 1..].iter().any(|below| &below.name == used) {
                faults.push(format!("{name} -> {used} does not point down: {used} needs a line below {name}'s"));
            }
        }
    }
    for package in packages {
        compare_package(package, lines, packages, &mut faults);
    }
    faults
}

fn compare_package(package: &Package, lines: &[Line], packages: &[Package], faults: &mut Vec<String>) {
    let name = &package.name;
    let Some(line) = lines.iter().find(|line| &line.name == name) else {
        faults.push(format!("{name} is a crate of the workspace, but {DOCUMENT} has no line for it"));
        return;
    };
    let is_member = |used: &&String| packages.iter().any(|other| &other.name == *used);
    for used in package.uses.iter().filter(is_member) {
        if !line.uses.contains(used) {
            faults.push(format!("{name} -> {used} is missing in {DOCUMENT}: {name} depends on {used}"));
        }
    }
    let place = |name: &str| lines.iter().position(|line| line.name == name);
    for used in package.tests_with.iter().filter(is_member) {
        if !line.uses.contains(used) && used != name && place(used) < place(name) {
            faults.push(format!("{name} is below {used}, so the tests of {name} may not use {used} either"));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: &str = "# A\n\n```arrows\ncli -> lobe\nlobe -> env, sh\nenv -> sh\nsh -> nothing\n\nlobe-testkit -> nothing\n```\ntext -> text\n";

    fn package(name: &str, uses: &[&str], tests_with: &[&str]) -> Package {
        let owned = |names: &[&str]| names.iter().map(ToString::to_string).collect();
        Package { name: name.into(), folder: name.into(), uses: owned(uses), tests_with: owned(tests_with) }
    }

    fn good_packages() -> Vec<Package> {
        vec![
            package("cli", &["clap", "lobe"], &["lobe-testkit", "tempfile"]),
            package("env", &["exr", "sh"], &["lobe-testkit", "sh"]),
            package("lobe", &["env", "sh"], &[]),
            package("lobe-testkit", &["serde_json"], &[]),
            package("sh", &[], &["lobe-testkit"]),
        ]
    }

    fn faults(text: &str, packages: &[Package]) -> Vec<String> {
        super::faults(&blocks::parse(text).unwrap(), packages)
    }

    #[test]
    fn arrows_that_agree_have_no_faults() {
        let found = faults(GOOD, &good_packages());
        assert!(found.is_empty(), "{found:?}");
    }

    #[test]
    fn an_arrow_only_in_the_document_is_named() {
        let found = faults(&GOOD.replace("cli -> lobe", "cli -> lobe, sh"), &good_packages());
        assert_eq!(found, ["cli -> sh stands in ARCHITECTURE.md, but cli does not depend on sh"], "one fault");
    }

    #[test]
    fn an_arrow_only_in_cargo_is_named() {
        let found = faults(&GOOD.replace("lobe -> env, sh", "lobe -> env"), &good_packages());
        assert_eq!(found, ["lobe -> sh is missing in ARCHITECTURE.md: lobe depends on sh"], "one fault");
    }

    #[test]
    fn an_arrow_that_points_up_is_named() {
        let found = faults(&GOOD.replace("env -> sh\nsh -> nothing", "sh -> nothing\nenv -> sh"), &good_packages());
        assert_eq!(found, ["env -> sh does not point down: sh needs a line below env's"], "one fault");
    }

    #[test]
    fn crates_on_one_side_only_are_named() {
        let mut packages = good_packages();
        packages.push(package("prt", &[], &[]));
        let found = faults(&GOOD.replace("cli ->", "viewer ->"), &packages);
        let expected = [
            "ARCHITECTURE.md lists viewer, which is no crate of the workspace",
            "cli is a crate of the workspace, but ARCHITECTURE.md has no line for it",
            "prt is a crate of the workspace, but ARCHITECTURE.md has no line for it",
        ];
        assert_eq!(found, expected, "three faults");
    }

    #[test]
    fn tests_may_use_what_is_below_their_crate_only() {
        let mut packages = good_packages();
        packages[4].tests_with.push("env".into());
        let found = faults(GOOD, &packages);
        assert_eq!(found, ["sh is below env, so the tests of sh may not use env either"], "one fault");
    }

    #[test]
    fn a_document_without_arrows_is_refused() {
        let found = faults("# A\n```text\na -> b\n```\n", &good_packages());
        assert_eq!(found, ["ARCHITECTURE.md has no code block of language `arrows`"], "one fault");
    }
}
