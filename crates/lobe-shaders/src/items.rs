//! The declarations of a shader text: cutting out some with what they need.
//!
//! It holds for WGSL and for what naga writes: declarations begin in the first column and end with `;` or `}` outside
//! of all brackets.

/// A declaration: a function, structure, type or constant.
#[derive(Debug, PartialEq)]
pub(crate) struct Item<'a> {
    pub(crate) name: &'a str,
    /// Its comment and its text.
    pub(crate) text: &'a str,
}

/// The declarations of a text, in order. Comments that a blank line follows belong to none, and neither do directives.
pub(crate) fn items(text: &str) -> Vec<Item<'_>> {
    let mut found = Vec::new();
    let (mut at, mut start, mut depth) = (0, None, 0_isize);
    for line in text.split_inclusive('\n') {
        let (from, code) = (at, line.split("//").next().unwrap_or_default().trim_end());
        at += line.len();
        if depth == 0 && (line.trim().is_empty() || line.starts_with('#')) {
            start = None;
            continue;
        }
        let first = *start.get_or_insert(from);
        depth += code.matches(['(', '{']).count() as isize - code.matches([')', '}']).count() as isize;
        if depth == 0 && code.ends_with([';', '}']) {
            let text = text[first..at].trim_end();
            found.push(Item { name: name_of(text), text });
            start = None;
        }
    }
    found
}

/// The lines of a declaration that are no comment.
pub(crate) fn code(text: &str) -> &str {
    let comment: usize = text.split_inclusive('\n').take_while(|line| line.starts_with("//")).map(str::len).sum();
    &text[comment..]
}

/// What a declaration declares: the name before the brackets of a function, after `struct`, or before the value of a
/// constant.
fn name_of(text: &str) -> &str {
    let code = code(text);
    if let Some(rest) = code.strip_prefix("struct ") {
        return words(rest).next().unwrap_or_default();
    }
    let end = code.find(['(', '=', '{', ';']).unwrap_or(code.len());
    let is_function = code[end..].starts_with('(');
    let head = if is_function { &code[..end] } else { code[..end].split(['[', ':']).next().unwrap_or_default() };
    words(head).last().unwrap_or_default()
}

/// The identifiers in a text.
pub(crate) fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| !c.is_alphanumeric() && c != '_').filter(|word| !word.is_empty())
}

/// The declarations of these names and all that they name, in the order of the text.
pub(crate) fn needed<'a>(items: &'a [Item<'a>], names: &[&str]) -> Vec<&'a Item<'a>> {
    let mut is_needed: Vec<bool> = items.iter().map(|item| names.contains(&item.name)).collect();
    let mut open: Vec<usize> = (0..items.len()).filter(|k| is_needed[*k]).collect();
    while let Some(k) = open.pop() {
        for word in words(code(items[k].text)) {
            for (other, item) in items.iter().enumerate() {
                if item.name == word && !is_needed[other] {
                    is_needed[other] = true;
                    open.push(other);
                }
            }
        }
    }
    items.iter().zip(is_needed).filter(|(_, is_needed)| *is_needed).map(|(item, _)| item).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "\
#include <some>
// Of the file.

typedef float ret_nine[9];
struct nine {
    float inner[9];
};
constant float HALF = 0.5;

// Of half.
float half_of(
    float x // (
) {
    return HALF * x;
}
a::ret_nine of_half(float x)
{
    return half_of(x);
}
float[9] other(float x) { return x; }
";

    #[test]
    fn declarations_have_their_names_and_comments() {
        let found = items(TEXT);
        let names: Vec<&str> = found.iter().map(|item| item.name).collect();
        assert_eq!(names, ["ret_nine", "nine", "HALF", "half_of", "of_half", "other"], "names");
        assert!(found[3].text.starts_with("// Of half.\nfloat half_of("), "{}", found[3].text);
        assert!(found[0].text.starts_with("typedef"), "{}", found[0].text);
    }

    #[test]
    fn what_is_needed_comes_along_and_nothing_else() {
        let all = items(TEXT);
        let names: Vec<&str> = needed(&all, &["of_half"]).iter().map(|item| item.name).collect();
        assert_eq!(names, ["ret_nine", "HALF", "half_of", "of_half"], "in the order of the text");
    }
}
