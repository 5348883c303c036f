//! Corpus of malformed files, and the page that explains them.

use crate::{dds, exr, hdr, jpg, ktx2, pfm, png, sh_json};

/// A small valid file.
pub(crate) struct Good {
    pub(crate) name: String,
    /// Bytes of everything before the first texel or number.
    pub(crate) header: usize,
    pub(crate) bytes: Vec<u8>,
}

impl Good {
    pub(crate) fn new(name: &str, header: usize, bytes: Vec<u8>) -> Self {
        Self { name: name.into(), header, bytes }
    }
}

/// A malformed file.
pub(crate) struct Bad {
    pub(crate) name: String,
    /// Its defect.
    pub(crate) what: &'static str,
    pub(crate) bytes: Vec<u8>,
}

/// Files `EXTENSION-NAME.EXTENSION` from their names, defects and bytes.
pub(crate) fn bad(extension: &str, files: Vec<(&str, &'static str, Vec<u8>)>) -> Vec<Bad> {
    let first = extension.split('.').next().unwrap_or(extension);
    let name = |name| format!("{first}-{name}.{extension}");
    files.into_iter().map(|(stem, what, bytes)| Bad { name: name(stem), what, bytes }).collect()
}

pub(crate) fn good_files() -> Vec<Good> {
    [hdr::good(), exr::good(), pfm::good(), png::good(), jpg::good(), ktx2::good(), dds::good(), sh_json::good()]
        .into_iter()
        .flatten()
        .collect()
}

pub(crate) fn bad_files() -> Vec<Bad> {
    [hdr::bad(), exr::bad(), pfm::bad(), png::bad(), jpg::bad(), ktx2::bad(), dds::bad(), sh_json::bad()]
        .into_iter()
        .flatten()
        .collect()
}

const HEAD: &str = "\
# Malformed files

Every file in `bad/` is refused with the one line that the table shows; every file in `good/` is read, and those in
`bad/` are made from them. All are put together byte by byte in `tests/malformed/`, a module for each format, except
`good/small.jpg`, which the crate `image` wrote. No file holds anything of anybody else's.

The tests in `tests/malformed/main.rs` compare the folder with what its makers make, and read every file. After a change
of a maker or of a message, make the folder anew, this page with it:

    cargo test -p lobe-env --test malformed -- --ignored make_the_corpus

The fuzz targets in `fuzz/` begin with these files.

| file | bytes | what is wrong | what Lobe says |
|---|---|---|---|
";

/// The page; `message` gives the error of a file.
pub(crate) fn readme(message: impl Fn(&str, &[u8]) -> String) -> String {
    let mut page = HEAD.to_owned();
    for Bad { name, what, bytes } in bad_files() {
        let said = message(&name, &bytes);
        let said = said[name.len() + 2..].replace('|', "\\|");
        page += &format!("| {name} | {} | {what} | {said} |\n", bytes.len());
    }
    page
}
