//! `documents`: checks that links between files have a target, that every work cited is in REFERENCES.bib, and that a file of
//! Rust opens with the name of a thing.
//!
//! A citation is a bracketed label of names and a year, `[Sloan 2008]` or `[Sloan, Kautz and Snyder 2002]`. Its key in
//! the bibliography is the same without spaces and small words: `Sloan2008`, `SloanKautzSnyder2002`.

use std::collections::BTreeSet;
use std::path::Path;

use crate::outcome::Outcome;
use crate::workspace;

const BIBLIOGRAPHY: &str = "REFERENCES.bib";

/// The chapters of the guide, and all that its book has: nothing outside of it can be linked.
const BOOK: &str = "docs/guide/src/";

/// What lists the chapters: the table of contents, by links, and the crate that tests their blocks, by paths.
const LISTS_OF_CHAPTERS: [(&str, &str, char); 2] =
    [("docs/guide/src/SUMMARY.md", "](", ')'), ("crates/lobe/src/lib.rs", "docs/guide/src/", '"')];

/// Checks every Markdown file, and the comments of every Rust file.
pub(crate) fn check() -> Outcome {
    let one = |fault| vec![fault];
    let keys = bibliography_keys(&workspace::read(&workspace::root().join(BIBLIOGRAPHY)).map_err(one)?);
    let mut faults = Vec::new();
    for path in workspace::files("md").map_err(one)? {
        let text = workspace::read(&path).map_err(one)?;
        let name = workspace::relative(&path);
        let folder = path.parent().unwrap_or(workspace::root());
        for link in broken_links(&text, folder) {
            faults.push(format!("{name}: nothing lies where the link `{link}` points"));
        }
        for link in if name.starts_with(BOOK) { links_that_leave(&text) } else { Vec::new() } {
            faults.push(format!("{name}: the link `{link}` leaves the book; name the file instead"));
        }
        faults.extend(unknown_citations(&text, &keys).map(|label| not_in_bibliography(&name, &label)));
    }
    faults.extend(unlisted_chapters().map_err(one)?);
    for path in workspace::files("rs").map_err(one)? {
        let text = workspace::read(&path).map_err(one)?;
        let comments: String =
            text.lines().filter(|row| row.trim_start().starts_with("//")).flat_map(|row| [row, "\n"]).collect();
        let name = workspace::relative(&path);
        faults.extend(unknown_citations(&comments, &keys).map(|label| not_in_bibliography(&name, &label)));
        faults.extend(riddle(&text).map(|word| format!("{name}: opens with `{word}`; begin with a name of the field")));
    }
    if faults.is_empty() { Ok(()) } else { Err(faults) }
}

/// Words that begin a description where a name should stand.
const RIDDLES: [&str; 9] = ["What", "How", "Where", "Ways", "Whether", "That", "Who", "When", "Which"];

/// The word with which the documentation of a file begins, if it is one of [`RIDDLES`].
fn riddle(text: &str) -> Option<&str> {
    let first = text.lines().next()?.strip_prefix("//!")?.split_whitespace().next()?;
    RIDDLES.contains(&first).then_some(first)
}

fn not_in_bibliography(name: &str, label: &str) -> String {
    format!("{name}: [{label}] is cited, but {BIBLIOGRAPHY} has no entry or alias {}", key_of(label))
}

/// The keys of all entries, and their aliases (`ids = {...}`).
fn bibliography_keys(text: &str) -> BTreeSet<String> {
    let mut keys = BTreeSet::new();
    for row in text.lines() {
        let row = row.trim();
        if row.starts_with('@') {
            keys.extend(row.split_once('{').map(|(_, key)| key.trim_end_matches(',').to_string()));
        } else if let Some(aliases) = row.strip_prefix("ids") {
            let aliases = aliases.trim_matches(|c: char| !c.is_alphanumeric());
            keys.extend(aliases.split(',').map(|alias| alias.trim().to_string()));
        }
    }
    keys
}

/// The labels of works cited in `text` that are not among `keys`, each once.
fn unknown_citations(text: &str, keys: &BTreeSet<String>) -> impl Iterator<Item = String> {
    let labels: BTreeSet<&str> = text.split('[').skip(1).filter_map(|rest| Some(rest.split_once(']')?.0)).collect();
    let unknown: Vec<String> = labels
        .into_iter()
        .filter(|label| is_citation(label) && !keys.contains(&key_of(label)))
        .map(Into::into)
        .collect();
    unknown.into_iter()
}

/// Whether a bracketed label is names and a year.
fn is_citation(label: &str) -> bool {
    let Some((names, year)) = label.rsplit_once(' ') else { return false };
    let is_year = year.len() == 4 && (year.starts_with("19") || year.starts_with("20"));
    let is_name = |c: char| c.is_alphabetic() || " ,.&-".contains(c);
    is_year
        && year.chars().all(|c| c.is_ascii_digit())
        && names.starts_with(char::is_uppercase)
        && names.chars().all(is_name)
}

/// The key a label stands for.
fn key_of(label: &str) -> String {
    let words = label.split_whitespace().filter(|word| !["and", "&", "et", "al."].contains(word));
    words.flat_map(str::chars).filter(|c| c.is_alphanumeric()).collect()
}

/// The targets of links and pictures in `text` that are files, relative to `folder`, and do not exist.
fn broken_links(text: &str, folder: &Path) -> Vec<String> {
    let mut in_code = false;
    let mut broken = Vec::new();
    for row in text.lines() {
        in_code ^= row.trim_start().starts_with("```");
        if in_code {
            continue;
        }
        let targets = targets(row, "](", ')').chain(targets(row, "src=\"", '"'));
        for target in targets.filter(|target| !target.contains("://") && !target.starts_with(['#', '<'])) {
            let file = target.split('#').next().unwrap_or(target);
            if !folder.join(file).exists() {
                broken.push(target.to_string());
            }
        }
    }
    broken
}

/// Links out of the folder of the book, where nothing is.
fn links_that_leave(text: &str) -> Vec<&str> {
    targets(text, "](", ')').filter(|link| link.starts_with("../")).collect()
}

/// The chapters that a list of them lacks, and what is listed and is none.
fn unlisted_chapters() -> Result<Vec<String>, String> {
    let is_chapter = |name: &String| name.starts_with(BOOK) && !name.ends_with("SUMMARY.md");
    let files: BTreeSet<String> =
        workspace::files("md")?.iter().map(|path| workspace::relative(path)).filter(is_chapter).collect();
    let mut faults = Vec::new();
    for (list, open, close) in LISTS_OF_CHAPTERS {
        let text = workspace::read(&workspace::root().join(list))?;
        let listed: BTreeSet<String> = targets(&text, open, close).map(|chapter| format!("{BOOK}{chapter}")).collect();
        faults
            .extend(files.symmetric_difference(&listed).map(|chapter| format!("{list} or the folder lacks {chapter}")));
    }
    Ok(faults)
}

/// The texts between `open` and `close` in a row.
fn targets<'a>(row: &'a str, open: &'static str, close: char) -> impl Iterator<Item = &'a str> {
    row.split(open).skip(1).filter_map(move |rest| Some(rest.split_once(close)?.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_opens_with_a_name() {
        assert_eq!(riddle("//! What moves.\n"), Some("What"), "a riddle");
        assert_eq!(riddle("//! Whatever moves.\n//! What else.\n"), None, "another word, and another line");
        assert_eq!(riddle("use std::fmt;\n"), None, "no documentation");
    }

    #[test]
    fn planted_broken_links_are_found_and_good_ones_are_not() {
        let text = "See [a](Cargo.toml#x), [b](https://example.org/x), [c](#here) and [d](no/such.md).\n\
                    <img src=\"no.png\">\n```text\n[e](neither.md)\n```\n";
        assert_eq!(broken_links(text, workspace::root()), ["no/such.md", "no.png"], "two planted faults");
    }

    #[test]
    fn planted_links_that_leave_the_book_are_found() {
        let text = "[a](formats.md#x), [b](../../../README.md), [c](read.py), [d](../x.rs)";
        assert_eq!(links_that_leave(text), ["../../../README.md", "../x.rs"], "two planted faults");
    }

    #[test]
    fn every_chapter_is_listed() {
        assert_eq!(
            unlisted_chapters().unwrap(),
            Vec::<String>::new(),
            "in SUMMARY.md and in the tests of the crate lobe"
        );
    }

    #[test]
    fn planted_unknown_citations_are_found_and_known_ones_are_not() {
        let keys = bibliography_keys(
            "@misc{Sloan2008,\n  title = {T},\n}\n@article{SloanKautzSnyder2002,\n  ids = {Sloan2002, SKS2002},\n}\n",
        );
        let text = "[Sloan 2008] A1, [Sloan, Kautz and Snyder 2002], [Sloan et al. 2002], `a[i 2008]`, [Nobody 1999] and \
                    [Nobody 1999] again, [Keep a Changelog], [0, 2000]";
        assert_eq!(unknown_citations(text, &keys).collect::<Vec<_>>(), ["Nobody 1999"], "one planted fault");
    }
}
