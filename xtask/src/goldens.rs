//! `goldens`: checks that the store of reference values is there and every entry is read by a test.

use serde_json::Value;

use crate::outcome::Outcome;
use crate::workspace;

const STORE: &str = "crates/lobe-testkit/golden/goldens.json";

/// Fails if the store is missing or empty; names the entries that no test reads yet.
pub(crate) fn check() -> Outcome {
    let text = workspace::read(&workspace::root().join(STORE)).map_err(|fault| vec![fault])?;
    let store: Value = serde_json::from_str(&text).map_err(|error| vec![format!("{STORE} is not JSON: {error}")])?;
    let Some(entries) = store.as_object().filter(|entries| !entries.is_empty()) else {
        return Err(vec![format!("{STORE} is expected to be an object with entries")]);
    };
    let mut sources = String::new();
    for path in workspace::files("rs").map_err(|fault| vec![fault])? {
        sources += &workspace::read(&path).map_err(|fault| vec![fault])?;
    }
    let unread: Vec<&str> = entries.keys().map(String::as_str).filter(|key| !is_read(&sources, key)).collect();
    if !unread.is_empty() {
        println!("note: no test reads these golden values yet: {}", unread.join(", "));
    }
    Ok(())
}

/// Whether a JSON pointer into `key` stands in the sources.
fn is_read(sources: &str, key: &str) -> bool {
    sources.match_indices(&format!("\"/{key}")).any(|(at, found)| sources[at + found.len()..].starts_with(['"', '/']))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_entry_is_read_by_its_whole_name_only() {
        let sources = "golden(\"/planted\"); golden_f64s(&format!(\"/other/{order}/c\"))";
        assert!(is_read(sources, "planted") && is_read(sources, "other"), "{sources}");
        assert!(!is_read(sources, "plant") && !is_read(sources, "order"), "{sources}");
    }
}
