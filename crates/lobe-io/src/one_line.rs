//! Text from files and command lines in messages.

use std::fmt::Write as _;

/// The text in one line that shows as it is written: control characters become spaces, and characters that turn text around or break
/// lines are escaped, so that a name cannot pass for another.
///
/// ```
/// assert_eq!(lobe_io::one_line("two\nlines, exe.\u{202e}gpj"), "two lines, exe.\\u{202e}gpj");
/// ```
#[must_use]
pub fn one_line(text: &str) -> String {
    let mut line = String::with_capacity(text.len());
    for c in text.chars() {
        if c.is_control() {
            line.push(' ');
        } else if turns_text(c) {
            // A string takes whatever is written to it.
            let _ = write!(line, "{}", c.escape_unicode());
        } else {
            line.push(c);
        }
    }
    line
}

/// The marks, embeddings, overrides and isolates of bidirectional text, and the separators of lines and paragraphs.
fn turns_text(c: char) -> bool {
    matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn characters_that_turn_text_around_are_escaped_and_letters_are_not() {
        for code in [0x061c, 0x200e, 0x200f, 0x202a, 0x202b, 0x202c, 0x202d, 0x202e, 0x2066, 0x2067, 0x2068, 0x2069] {
            let c = char::from_u32(code).unwrap();
            assert_eq!(one_line(&format!("a{c}b")), format!("a\\u{{{code:x}}}b"));
        }
        let letters = "sky-ß-世界-עברית-عربي \u{200d}";
        assert_eq!(one_line(letters), letters, "other scripts");
        assert_eq!(one_line("a\tb\u{1b}[1m\u{85}"), "a b [1m ", "control characters");
    }
}
