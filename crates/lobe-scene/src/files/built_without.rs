//! Decoders that a build leaves out: what is said of files that need them.

use serde_json::Value;

use crate::error::SceneError;
use crate::files::source::Source;

/// Extensions of buffer views whose decoder is one of the feature `compressed`.
const DECODED: [&str; 2] = ["EXT_meshopt_compression", "KHR_meshopt_compression"];

/// Refuses glTF files of compressed parts, by whatever they say that they require.
pub(crate) fn refuse(json: &Value, source: &Source<'_>) -> Result<(), SceneError> {
    let views = || json["bufferViews"].as_array().into_iter().flatten();
    for extension in DECODED {
        if views().any(|view| view["extensions"].get(extension).is_some()) {
            return Err(source.unsupported(message(&format!("{extension} of a buffer view"))));
        }
    }
    Ok(())
}

/// The message for something that needs the feature `compressed`.
pub(crate) fn message(what: &str) -> String {
    format!(
        "{what}: this program was built without its decoder; build it by `cargo build --release --features compressed`"
    )
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;
    use crate::files::read_options::SceneReadOptions;

    #[test]
    fn compressed_parts_are_refused_with_the_command_that_builds_their_decoders_in() {
        let source = Source::new("a.glb", None, &SceneReadOptions::default());
        let view = json!({"bufferViews": [{}, {"extensions": {"EXT_meshopt_compression": {}}}]});
        let found = refuse(&view, &source).unwrap_err().to_string();
        let expected = "a.glb: EXT_meshopt_compression of a buffer view: this program was built without its decoder; \
                        build it by `cargo build --release --features compressed`";
        assert_eq!(found, expected, "{view}");
        let used = ["EXT_meshopt_compression"];
        let plain = json!({"bufferViews": [{}], "meshes": [{"primitives": [{}]}], "extensionsUsed": used});
        assert!(refuse(&plain, &source).is_ok(), "nothing of {plain} is compressed");
    }
}
