//! Endings of file names, in sentences.

/// Endings as a sentence has them: `.exr, .hdr or .pfm`.
///
/// ```
/// assert_eq!(lobe_io::named_endings(["exr", "hdr", "pfm"]), ".exr, .hdr or .pfm");
/// assert_eq!(lobe_io::named_endings(["exr"]), ".exr");
/// ```
#[must_use]
pub fn named_endings<'a>(endings: impl IntoIterator<Item = &'a str>) -> String {
    either(&endings.into_iter().map(|ending| format!(".{ending}")).collect::<Vec<_>>())
}

/// A list whose last two are joined by `or`.
///
/// ```
/// assert_eq!(lobe_io::either(&["PNG", "JPEG", "TIFF"]), "PNG, JPEG or TIFF");
/// ```
#[must_use]
pub fn either(names: &[impl AsRef<str>]) -> String {
    let mut text = String::new();
    for (k, name) in names.iter().enumerate() {
        text += match k {
            0 => "",
            _ if k + 1 == names.len() => " or ",
            _ => ", ",
        };
        text += name.as_ref();
    }
    text
}
