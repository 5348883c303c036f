//! Lines of OBJ and MTL files.

use std::borrow::Cow;
use std::str::FromStr;

/// A line of a file: its keyword, and what follows.
pub(crate) struct Line<'a> {
    /// The number of the line in the file, the first of those that are continued.
    pub(crate) number: usize,
    pub(crate) keyword: &'a str,
    pub(crate) rest: &'a str,
}

impl Line<'_> {
    /// The words that follow the keyword, up to a comment.
    pub(crate) fn words(&self) -> impl Iterator<Item = &str> {
        self.rest.split_whitespace().take_while(|word| !word.starts_with('#'))
    }

    /// The keyword for messages, of which a damaged file may make a long one.
    pub(crate) fn short_keyword(&self) -> String {
        const MOST: usize = 40;
        self.keyword.chars().take(MOST).collect()
    }

    /// The numbers that follow the keyword; `None` if anything else is among them.
    pub(crate) fn numbers<T: FromStr>(&self) -> Option<Vec<T>> {
        self.words().map(|word| word.parse().ok()).collect()
    }
}

/// Whether a file begins with the byte order mark of UTF-16.
pub(crate) fn is_utf16(bytes: &[u8]) -> bool {
    bytes.starts_with(b"\xFF\xFE") || bytes.starts_with(b"\xFE\xFF")
}

/// The text of a file: UTF-8, with or without a byte order mark, or else Latin-1, which older programs write.
pub(crate) fn text_of(bytes: &[u8]) -> Cow<'_, str> {
    let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    std::str::from_utf8(bytes).map_or_else(|_| bytes.iter().map(|&byte| char::from(byte)).collect(), Cow::Borrowed)
}

/// The bytes that [`text_of`] takes beside the file: none for UTF-8.
pub(crate) fn bytes_of_text(bytes: &[u8]) -> u64 {
    // It has up to two bytes for each, and room for as many as it grows.
    if std::str::from_utf8(bytes).is_ok() { 0 } else { (bytes.len() as u64).saturating_mul(4) }
}

/// Calls `each` for all lines that are neither empty nor a comment. A line that ends in a backslash goes on in the next.
pub(crate) fn for_each_line<E>(text: &str, mut each: impl FnMut(Line<'_>) -> Result<(), E>) -> Result<(), E> {
    let mut joined = String::new();
    let mut lines = text.lines().enumerate();
    while let Some((index, first)) = lines.next() {
        let mut line = first.trim();
        if line.starts_with('#') {
            continue;
        }
        if let Some(part) = line.strip_suffix('\\') {
            joined.clear();
            joined.push_str(part);
            for (_, next) in lines.by_ref() {
                joined.push(' ');
                let next = next.trim();
                joined.push_str(next.strip_suffix('\\').unwrap_or(next));
                if !next.ends_with('\\') {
                    break;
                }
            }
            line = joined.trim();
        }
        let (keyword, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        if !keyword.is_empty() {
            each(Line { number: index + 1, keyword, rest: rest.trim() })?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_numbered_continued_and_without_comments() {
        let text = "# c:\\\nv 1 2 \\\r\n  3\n\n\tf 1\\\n 2\\\n 3\r\nend";
        let mut found = Vec::new();
        let Ok(()) = for_each_line(text, |line| {
            found.push((
                line.number,
                line.keyword.to_owned(),
                line.rest.split_whitespace().collect::<Vec<_>>().join(" "),
            ));
            Ok::<(), std::convert::Infallible>(())
        });
        let found: Vec<_> = found.iter().map(|(number, keyword, rest)| (*number, &**keyword, &**rest)).collect();
        assert_eq!(found, [(2, "v", "1 2 3"), (5, "f", "1 2 3"), (8, "end", "")], "lines");
    }

    #[test]
    fn bytes_that_are_no_utf8_are_latin_1() {
        assert_eq!(text_of("µ".as_bytes()), "µ", "UTF-8");
        assert_eq!(text_of("\u{feff}v".as_bytes()), "v", "a byte order mark is no text");
        assert_eq!(text_of(b"usemtl Stra\xDFe"), "usemtl Straße", "Latin-1");
    }
}
