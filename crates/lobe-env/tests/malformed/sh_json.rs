//! Malformed expansions in JSON.

use crate::bytes::{find, replaced};
use crate::corpus::{self, Bad, Good};

const SCALAR: &str =
    r#"{"format":"lobe-sh","version":1,"order":2,"quantity":"visibility","coefficients":[[1],[0.5],[0],[-0.25]]}"#;
const RGB: &str = r#"{"format":"lobe-sh","version":1,"order":1,"quantity":"radiance","coefficients":[[1,2,3]]}"#;

fn header(text: &str) -> usize {
    find(text.as_bytes(), b"[[")
}

pub(crate) fn good() -> Vec<Good> {
    [("scalar.sh.json", SCALAR), ("rgb.sh.json", RGB)]
        .map(|(name, text)| Good::new(name, header(text), text.into()))
        .into()
}

pub(crate) fn bad() -> Vec<Bad> {
    let with = |from: &str, to: &str| replaced(SCALAR.as_bytes(), from.as_bytes(), to.as_bytes());
    let files = vec![
        ("empty", "no bytes", Vec::new()),
        ("blank", "blanks", b"  \n ".to_vec()),
        ("text", "no JSON", b"order 3".to_vec()),
        ("binary", "bytes that are no text", vec![0xfe, 0, 0x80, 0xff]),
        ("utf-16", "text in UTF-16", b"\xff\xfe{\0}\0".to_vec()),
        (
            "not-utf-8",
            "a name that is no text",
            with("lobe-sh", "lobe\u{e9}").into_iter().filter(|b| *b != 0xc3).collect(),
        ),
        ("mark-only", "a byte order mark and nothing else", b"\xef\xbb\xbf".to_vec()),
        ("cut-key", "cut within the first key", SCALAR[..5].into()),
        ("cut-head", "cut before the coefficients", SCALAR[..header(SCALAR)].into()),
        ("cut-row", "cut within the last row", SCALAR[..SCALAR.len() - 4].into()),
        ("cut-last", "cut before the last brace", SCALAR[..SCALAR.len() - 1].into()),
        ("after-end", "something behind the end", with("]]}", "]]}}")),
        ("array", "an array in place of an object", b"[[1]]".to_vec()),
        ("format", "another format", with("lobe-sh", "lobe-hs")),
        ("format-missing", "no format", with(r#""format":"lobe-sh","#, "")),
        ("version", "version 2", with(r#""version":1"#, r#""version":2"#)),
        ("version-negative", "version -1", with(r#""version":1"#, r#""version":-1"#)),
        ("order-zero", "order 0", with(r#""order":2"#, r#""order":0"#)),
        ("order-absurd", "order 4000000000", with(r#""order":2"#, r#""order":4000000000"#)),
        ("order-fraction", "order 2.5", with(r#""order":2"#, r#""order":2.5"#)),
        ("order-twice", "two orders", with(r#""order":2"#, r#""order":2,"order":2"#)),
        ("quantity", "an unknown quantity", with("visibility", "light")),
        ("rows-few", "a row too few", with(",[0]", "")),
        ("rows-many", "a row too many", with(",[0]", ",[0],[0]")),
        ("row-length", "a row of two numbers", with("[0.5]", "[0.5,0.5]")),
        ("row-empty", "a row of no numbers", with("[0.5]", "[]")),
        ("row-text", "a word in place of a number", with("[0.5]", r#"["0.5"]"#)),
        ("row-null", "null in place of a row", with("[0.5]", "null")),
        ("nan", "NaN", with("0.5", "NaN")),
        ("infinite", "a number too large for any machine", with("0.5", "1e999")),
        ("deep", "200 arrays within each other", with("[0.5]", &("[".repeat(200) + &"]".repeat(200)))),
    ];
    corpus::bad("sh.json", files)
}
