//! Commands in the guide: every one exists, with every option that it is given.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use crate::harness::Dir;

/// Commands that have commands of their own.
const GROUPS: [&str; 3] = ["sh", "env", "light"];

/// All commands of a text: the lines of its blocks of `sh`, and what stands between backticks and begins with `lobe`.
fn commands(text: &str) -> Vec<String> {
    let mut found = Vec::new();
    for (k, part) in text.split("```").enumerate() {
        if k % 2 == 0 {
            found.extend(part.split('`').skip(1).step_by(2).map(|code| code.replace('\n', " ")));
        } else if let Some(block) = part.strip_prefix("sh\n") {
            found.extend(block.lines().filter_map(|line| line.split(" #").next()).map(str::to_owned));
        }
    }
    let stages = found.iter().flat_map(|line| line.split('|')).map(|stage| stage.trim().to_owned());
    stages.filter(|stage| stage.starts_with("lobe ")).collect()
}

#[test]
fn every_command_of_the_guide_exists_with_its_options() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let chapters = fs::read_dir(root.join("docs/guide/src")).unwrap().map(|entry| entry.unwrap().path());
    let files = chapters.filter(|path| path.extension().is_some_and(|e| e == "md")).chain([root.join("README.md")]);
    let (dir, mut helps, mut seen) = (Dir::new(), BTreeMap::new(), 0);
    for path in files {
        for command in commands(&fs::read_to_string(&path).unwrap()) {
            let place = format!("{}: {command}", path.file_name().unwrap().display());
            let words: Vec<&str> = command.split_whitespace().skip(1).collect();
            let depth = match words[..] {
                ["env", "area-light", ..] => 3,
                ["export", "shader", ..] => 2,
                [group, ..] if GROUPS.contains(&group) => 2,
                _ => 1,
            };
            let name = words.iter().take(depth).filter(|word| word.starts_with(char::is_lowercase));
            let name = match words[..] {
                ["render", method @ ("trace" | "moving" | "maps" | "irradiance"), ..] => format!("render {method}"),
                ["render", ..] => "render baked".to_owned(),
                _ => name.copied().collect::<Vec<_>>().join(" "),
            };
            if name.is_empty() {
                // `lobe COMMAND --help` stands for all of them.
                continue;
            }
            let help = helps.entry(name.clone()).or_insert_with(|| dir.lobe(&format!("{name} --help")).stdout());
            for option in words.iter().filter(|word| word.starts_with("--") && word.len() > 2) {
                let option = option.trim_end_matches(',').split('=').next().unwrap();
                let is_known = help.split(|c: char| !c.is_alphanumeric() && c != '-').any(|word| word == option);
                assert!(is_known, "{place}: `lobe {name}` has no {option}");
            }
            seen += 1;
        }
    }
    assert!(seen > 40, "the guide shows {seen} commands");
}

#[test]
fn every_job_of_the_guide_is_the_same_from_its_file() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let chapters = fs::read_dir(root.join("docs/guide/src")).unwrap().map(|entry| entry.unwrap().path());
    let (dir, mut seen) = (Dir::new(), 0);
    for path in chapters.filter(|path| path.extension().is_some_and(|e| e == "md")) {
        for command in commands(&fs::read_to_string(&path).unwrap()) {
            let words: Vec<&str> = command.split_whitespace().skip(1).collect();
            let [verb @ ("bake" | "field" | "spheres"), _, ..] = words[..] else { continue };
            // Files that are not here, names that a shell makes, and what is no job.
            let is_whole = words.contains(&"-o") && !command.contains(['$', '*', '{', '>', '<']);
            let stands_for_another = |word: &&str| word.chars().all(char::is_uppercase);
            let is_no_job = |word: &&str| ["--like", "--job", "--json", "table"].contains(word);
            if !is_whole || words.iter().any(|word| stands_for_another(word) || is_no_job(word)) {
                continue;
            }
            let job = dir.lobe(&format!("{} --print-job", words.join(" "))).stdout();
            dir.file("job.toml", &job);
            let again = dir.lobe(&format!("{verb} --job job.toml --print-job")).stdout();
            assert_eq!(again, job, "{command}");
            seen += 1;
        }
    }
    assert!(seen > 5, "the guide shows {seen} jobs");
}
