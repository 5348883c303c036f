//! Decoders that a build leaves out: what is said of files that need them.

use serde_json::Value;

use crate::SceneError;
use crate::files::source::Source;

/// Extensions of glTF whose decoders are those of the feature `compressed`, and the members whose objects have them.
const DECODED: [(&str, &str, &str); 3] = [
    ("bufferViews", "EXT_meshopt_compression", "a buffer view"),
    ("bufferViews", "KHR_meshopt_compression", "a buffer view"),
    ("meshes", "KHR_draco_mesh_compression", "a mesh"),
];

/// Refuses glTF files of compressed parts, by whatever they say that they require.
pub(crate) fn refuse(json: &Value, source: &Source<'_>) -> Result<(), SceneError> {
    for (member, extension, what) in DECODED {
        let objects = json[member].as_array().into_iter().flatten();
        let parts = objects
            .flat_map(|object| [object].into_iter().chain(object["primitives"].as_array().into_iter().flatten()));
        if parts.into_iter().any(|part| part["extensions"].get(extension).is_some()) {
            return Err(source.unsupported(message(&format!("{extension} of {what}"))));
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
    use crate::SceneReadOptions;

    #[test]
    fn compressed_parts_are_refused_with_the_command_that_builds_their_decoders_in() {
        let source = Source::new("a.glb", None, &SceneReadOptions::default());
        let view = json!({"bufferViews": [{}, {"extensions": {"EXT_meshopt_compression": {}}}]});
        let mesh = json!({"meshes": [{"primitives": [{"extensions": {"KHR_draco_mesh_compression": {}}}]}]});
        for (file, what) in
            [(view, "EXT_meshopt_compression of a buffer view"), (mesh, "KHR_draco_mesh_compression of a mesh")]
        {
            let found = refuse(&file, &source).unwrap_err().to_string();
            let expected = format!(
                "a.glb: {what}: this program was built without its decoder; \
                 build it by `cargo build --release --features compressed`"
            );
            assert_eq!(found, expected, "{file}");
        }
        let used = ["KHR_draco_mesh_compression"];
        let plain = json!({"bufferViews": [{}], "meshes": [{"primitives": [{}]}], "extensionsUsed": used});
        assert!(refuse(&plain, &source).is_ok(), "nothing of {plain} is compressed");
    }
}
