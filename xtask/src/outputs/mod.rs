//! `outputs BEFORE AFTER`: checks that two builds of the command write the same bytes.
//!
//! Each of the two programs runs every line of `commands.txt` in a folder of its own. What they print on stdout, their
//! exit codes and every file that they leave are compared, byte by byte. So a change of structure can be shown to
//! change nothing, and a change of behavior to change what it is meant to.
//!
//! One program is run again with as many threads, and with one, two and three: the same arguments give the same bytes.
//! Uses no other room.

mod words;

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use words::words;

use crate::outcome::Outcome;

const COMMANDS: &str = include_str!("commands.txt");

/// An input that no command makes: visibility of order 2, of the upper half of the sky more than of the lower.
const VISIBILITY: &str = "{\"format\":\"lobe-sh\",\"version\":1,\"order\":2,\"quantity\":\"visibility\",\
                          \"coefficients\":[[1.7],[0.0],[0.6],[0.1]]}";

/// The results of a run: the files by their names, and each command's output and exit code by its line.
#[derive(Debug, Default, PartialEq)]
struct Left {
    files: BTreeMap<String, Vec<u8>>,
    printed: BTreeMap<&'static str, (Option<i32>, Vec<u8>)>,
}

/// Runs one program or two and compares what they leave.
pub(crate) fn run(arguments: &[String]) -> Outcome {
    let (before, after, threads): (_, _, &[_]) = match arguments {
        [before, after] => (before, after, &[None]),
        [program] => (program, program, &[None, Some("1"), Some("2"), Some("3")]),
        _ => return Err(vec!["usage: cargo xtask outputs PROGRAM-BEFORE [PROGRAM-AFTER]".into()]),
    };
    let folder = std::env::temp_dir().join(format!("lobe-outputs-{}", std::process::id()));
    let compared = compare(&folder, before, after, threads);
    // Remove the files; a failure to do so is no fault of the programs.
    let _ = fs::remove_dir_all(&folder);
    let faults = compared.map_err(|fault| vec![fault])?;
    if faults.is_empty() { Ok(()) } else { Err(faults) }
}

/// The differences between a run of one program and those of the other, one for each number of threads.
fn compare(folder: &Path, before: &str, after: &str, threads: &[Option<&str>]) -> Result<Vec<String>, String> {
    let first = run_in(&folder.join("before"), before, None)?;
    let mut faults = Vec::new();
    for count in threads {
        let name = count.unwrap_or("all");
        let found = differences(&first, &run_in(&folder.join(name), after, *count)?);
        let (commands, files) = (first.printed.len(), first.files.len());
        println!("{name} threads: {commands} commands, {files} files, {} differences", found.len());
        faults.extend(found.into_iter().map(|fault| format!("{name} threads: {fault}")));
    }
    Ok(faults)
}

/// The command lines, without comments.
fn lines() -> impl Iterator<Item = &'static str> {
    COMMANDS.lines().filter(|line| !line.is_empty() && !line.starts_with('#'))
}

fn run_in(folder: &Path, program: &str, threads: Option<&str>) -> Result<Left, String> {
    let fail = |what: &Path, error: std::io::Error| format!("{}: {error}", what.display());
    fs::create_dir_all(folder).map_err(|e| fail(folder, e))?;
    let input = folder.join("visibility.sh.json");
    fs::write(&input, VISIBILITY).map_err(|e| fail(&input, e))?;
    let program = PathBuf::from(program).canonicalize().map_err(|e| fail(Path::new(program), e))?;
    let mut left = Left::default();
    for line in lines() {
        let mut command = Command::new(&program);
        command.arg("--quiet").args(words(line)).current_dir(folder);
        if let Some(threads) = threads.filter(|_| !line.contains("--threads")) {
            command.args(["--threads", threads]);
        }
        let output = command.output().map_err(|e| fail(&program, e))?;
        if !output.status.success() {
            return Err(format!("lobe {line}: {}", String::from_utf8_lossy(&output.stderr).trim()));
        }
        left.printed.insert(line, (output.status.code(), output.stdout));
    }
    collect(folder, "", &mut left.files).map_err(|e| fail(folder, e))?;
    Ok(left)
}

/// Adds every file below `folder`, by its path from where the commands ran.
fn collect(folder: &Path, above: &str, files: &mut BTreeMap<String, Vec<u8>>) -> std::io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        let name = format!("{above}{}", path.file_name().unwrap_or_default().to_string_lossy());
        if path.is_dir() {
            collect(&path, &format!("{name}/"), files)?;
        } else {
            files.insert(name, fs::read(&path)?);
        }
    }
    Ok(())
}

/// One line for each file and each command's output that is not the same on both sides.
fn differences(before: &Left, after: &Left) -> Vec<String> {
    let mut faults = Vec::new();
    let names: BTreeSet<_> = before.files.keys().chain(after.files.keys()).collect();
    for name in names {
        match (before.files.get(name), after.files.get(name)) {
            (Some(a), Some(b)) if a == b => {}
            (Some(a), Some(b)) => faults.push(format!("{name}: {}", first_difference(a, b))),
            (Some(_), None) => faults.push(format!("{name}: only the first program writes it")),
            _ => faults.push(format!("{name}: only the second program writes it")),
        }
    }
    for (line, (code, stdout)) in &before.printed {
        let Some((code_after, stdout_after)) = after.printed.get(line) else { continue };
        if code != code_after {
            faults.push(format!("lobe {line}: exit code {code:?}, then {code_after:?}"));
        }
        if stdout != stdout_after {
            faults.push(format!("lobe {line}: on stdout, {}", first_difference(stdout, stdout_after)));
        }
    }
    faults
}

fn first_difference(a: &[u8], b: &[u8]) -> String {
    let place = a.iter().zip(b).position(|(a, b)| a != b).unwrap_or(a.len().min(b.len()));
    format!("{} and {} bytes, the first difference at {place}", a.len(), b.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn left(files: &[(&str, &[u8])], printed: &[(&'static str, &str)]) -> Left {
        Left {
            files: files.iter().map(|(name, bytes)| (name.to_string(), bytes.to_vec())).collect(),
            printed: printed.iter().map(|(line, text)| (*line, (Some(0), text.as_bytes().to_vec()))).collect(),
        }
    }

    #[test]
    fn equal_outputs_have_no_differences() {
        let run = left(&[("a.exr", b"12")], &[("project a", "{}")]);
        let found = differences(&run, &left(&[("a.exr", b"12")], &[("project a", "{}")]));
        assert!(found.is_empty(), "{found:?}");
    }

    #[test]
    fn a_byte_a_missing_file_and_another_answer_are_named() {
        let before = left(&[("a.exr", b"123"), ("b.exr", b"")], &[("sh info", "one")]);
        let after = left(&[("a.exr", b"124"), ("c.exr", b"")], &[("sh info", "two")]);
        let expected = [
            "a.exr: 3 and 3 bytes, the first difference at 2",
            "b.exr: only the first program writes it",
            "c.exr: only the second program writes it",
            "lobe sh info: on stdout, 3 and 3 bytes, the first difference at 0",
        ];
        assert_eq!(differences(&before, &after), expected, "four differences");
    }

    /// The sub-commands that the program has are the variants of its `Command`, and of groups the files that hold one each.
    #[test]
    fn every_sub_command_is_run() {
        let source = crate::workspace::root().join("apps/lobe-cli/src");
        let text = fs::read_to_string(source.join("cli.rs")).unwrap();
        let variants = text.lines().skip_while(|line| !line.contains("enum Command")).take_while(|line| *line != "}");
        let commands: Vec<String> = variants.filter_map(command_of).collect();
        assert!(commands.len() > 12 && commands.contains(&"fit-lobes".to_owned()), "{commands:?}");
        for command in commands {
            assert!(lines().any(|line| line.split(' ').next() == Some(&command)), "`{command}` is run by no line");
        }
        for group in ["sh", "env"] {
            for entry in fs::read_dir(source.join(group)).unwrap() {
                let path = entry.unwrap().path();
                let name = path.file_stem().unwrap().to_string_lossy().replace('_', "-");
                let start = format!("{group} {name} ");
                assert!(name == "mod" || lines().any(|line| line.starts_with(&start)), "`{start}` is run by no line");
            }
        }
    }

    /// The command of a variant such as `    FitLobes(FitLobes),`: `fit-lobes`.
    fn command_of(line: &str) -> Option<String> {
        let (name, _) = line.trim_start().split_once(['(', ' ', '{'])?;
        let is_variant = line.starts_with("    ") && !line.starts_with("     ") && name.starts_with(char::is_uppercase);
        let words = name.chars().flat_map(|c| c.is_uppercase().then_some('-').into_iter().chain(c.to_lowercase()));
        is_variant.then(|| words.skip(1).collect())
    }

    #[test]
    fn programs_that_are_missing_are_refused() {
        let faults = run(&["/nowhere/lobe".into()]).unwrap_err();
        assert!(faults[0].starts_with("/nowhere/lobe"), "{faults:?}");
        assert!(run(&[]).unwrap_err()[0].starts_with("usage"), "no program");
    }
}
