//! Parser of the code blocks of ARCHITECTURE.md that draw arrows: language `arrows` (crates) and `rooms CRATE`.

/// The document that holds the blocks.
pub(super) const DOCUMENT: &str = "ARCHITECTURE.md";

/// A code block of arrows.
#[derive(Debug)]
pub(super) struct Block {
    /// All that stands behind the fence: `arrows`, `rooms lobe-sh`.
    pub(super) language: String,
    pub(super) lines: Vec<Line>,
}

/// A line of a block: the user and what it uses.
#[derive(Debug, PartialEq)]
pub(super) struct Line {
    pub(super) name: String,
    pub(super) uses: Vec<String>,
}

/// Every block of arrows of the text, in its order.
pub(super) fn parse(text: &str) -> Result<Vec<Block>, String> {
    let mut blocks = Vec::new();
    let mut rows = text.lines();
    while let Some(row) = rows.next() {
        let Some(language) = row.trim().strip_prefix("```").map(str::trim).filter(|language| !language.is_empty())
        else {
            continue;
        };
        // To the closing fence in any case, so that it is not taken for an opening one.
        let inside: Vec<&str> = rows.by_ref().take_while(|row| row.trim() != "```").collect();
        if language == "arrows" || language.split_whitespace().next() == Some("rooms") {
            let filled = inside.into_iter().filter(|row| !row.trim().is_empty());
            blocks.push(Block { language: language.into(), lines: filled.map(parse_line).collect::<Result<_, _>>()? });
        }
    }
    Ok(blocks)
}

/// The block of this language, where there is one; an error where there are two.
pub(super) fn only<'a>(blocks: &'a [Block], language: &str) -> Result<Option<&'a Block>, String> {
    let mut found = blocks.iter().filter(|block| block.language == language);
    let first = found.next();
    if found.next().is_some() {
        return Err(format!("{DOCUMENT} has two code blocks of language `{language}`"));
    }
    Ok(first)
}

fn parse_line(row: &str) -> Result<Line, String> {
    let Some((name, uses)) = row.split_once("->") else {
        return Err(format!("{DOCUMENT}: expected `user -> used, used` or `user -> nothing`, found `{row}`"));
    };
    let uses = match uses.trim() {
        "nothing" => Vec::new(),
        list => list.split(',').map(|used| used.trim().to_string()).collect(),
    };
    Ok(Line { name: name.trim().into(), uses })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_of_arrows_are_found_between_others() {
        let text = "```rust\nlet a;\n```\n```arrows\na -> b, c\n\n```\n```\nx -> y\n```\n```rooms lobe-sh\nd  ->  nothing\n```\n";
        let blocks = parse(text).unwrap();
        let languages: Vec<_> = blocks.iter().map(|block| block.language.as_str()).collect();
        assert_eq!(languages, ["arrows", "rooms lobe-sh"], "by hand");
        let expected = Line { name: "a".into(), uses: vec!["b".into(), "c".into()] };
        assert_eq!(blocks[0].lines, [expected], "arrows");
        assert_eq!(blocks[1].lines, [Line { name: "d".into(), uses: vec![] }], "rooms");
    }

    #[test]
    fn a_line_without_an_arrow_is_refused() {
        let found = parse("```arrows\ncli lobe\n```\n").unwrap_err();
        assert!(found.contains("found `cli lobe`"), "{found}");
    }

    #[test]
    fn two_blocks_of_one_language_are_refused() {
        let blocks = parse("```rooms a\nx -> nothing\n```\n```rooms a\nx -> nothing\n```\n").unwrap();
        let found = only(&blocks, "rooms a").unwrap_err();
        assert_eq!(found, "ARCHITECTURE.md has two code blocks of language `rooms a`", "the fault");
        assert!(only(&blocks, "rooms b").unwrap().is_none(), "no block of this crate");
    }
}
