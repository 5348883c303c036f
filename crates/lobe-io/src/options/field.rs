//! An option in the table of a job: its name, what it may be, and words.

use std::fmt;

use super::kind::{OptionKind, Refusal};

/// An option of a job.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct OptionField {
    /// The name, as in files and in Python; a command line has `-` for `_`.
    pub name: &'static str,
    /// The values.
    pub kind: OptionKind,
    /// What stands for a value in help.
    pub value_name: &'static str,
    /// The default of an option that is left open, in words, if something in the scene decides it; else empty.
    pub left_open: &'static str,
    /// What it does, without a full stop at the end. Other options are in backquotes, as in every doc comment.
    pub doc: &'static str,
}

impl OptionField {
    /// What it does, with other options marked as in messages.
    #[must_use]
    pub fn marked_doc(&self) -> String {
        let mut parts = self.doc.trim().split('`');
        let mut out = parts.next().unwrap_or_default().to_owned();
        for (k, part) in parts.enumerate() {
            out += if k % 2 == 0 { "@" } else { "" };
            out += part;
        }
        out
    }

    /// An option in a table. For [`options!`](crate::options!).
    #[must_use]
    pub const fn new(
        name: &'static str,
        (kind, value_name, left_open): (OptionKind, &'static str, &'static str),
        doc: &'static str,
    ) -> Self {
        Self { name, kind, value_name, left_open, doc }
    }
}

/// Why an option of a job is refused.
///
/// As text it is one line, `order: expected ..., found 9`, in which options have the names of files. A front that
/// has other names for them [words](worded) it anew.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct OptionError {
    /// The option, or several with commas between them; empty if the message says what is meant.
    pub option: String,
    /// What is wrong, and what to do. Other options have `@` before their names.
    pub message: String,
    /// Whether the value is of another type.
    pub is_type: bool,
}

impl OptionError {
    /// What cannot be had, or not together.
    #[must_use]
    pub fn new(option: impl Into<String>, message: impl Into<String>) -> Self {
        Self { option: option.into(), message: message.into(), is_type: false }
    }

    pub(crate) fn of(option: &str, refusal: &Refusal) -> Self {
        let is_type = matches!(refusal, Refusal::Type(_));
        Self { option: option.to_owned(), message: refusal.message().to_owned(), is_type }
    }
}

impl fmt::Display for OptionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.option.is_empty() {
            write!(f, "{}: ", self.option)?;
        }
        f.write_str(&worded(&self.message, |name| Some(name.to_owned())))
    }
}

impl std::error::Error for OptionError {}

/// A text in which every option, marked by `@` before its name, is `named` anew. What is marked so and has no other name
/// stays as it is.
///
/// ```
/// use lobe_io::worded;
///
/// let flag = |name: &str| (name == "max_edge").then(|| "--max-edge".to_owned());
/// assert_eq!(worded("not with @max_edge; `@top` is a mesh", flag), "not with --max-edge; `@top` is a mesh");
/// ```
#[must_use]
pub fn worded(text: &str, named: impl Fn(&str) -> Option<String>) -> String {
    let mut parts = text.split('@');
    let mut out = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let is_of_name = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_';
        let (name, rest) = part.split_at(part.find(|c| !is_of_name(c)).unwrap_or(part.len()));
        match named(name) {
            Some(found) => out += &found,
            None => out += &format!("@{name}"),
        }
        out += rest;
    }
    out
}
