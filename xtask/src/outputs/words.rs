//! Splitting a command line into words, with double quotes.

/// The words of a line: parted by spaces, except within double quotes, which are left out.
pub(super) fn words(line: &str) -> Vec<String> {
    let mut words = Vec::new();
    // Every second piece between quotes is quoted.
    for (i, piece) in line.split('"').enumerate() {
        if i % 2 == 1 {
            words.push(piece.to_string());
        } else {
            words.extend(piece.split_whitespace().map(str::to_string));
        }
    }
    words
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quotes_hold_words_together() {
        assert_eq!(words("sh plot  p -o \"a b\" --size 3"), ["sh", "plot", "p", "-o", "a b", "--size", "3"], "words");
    }
}
