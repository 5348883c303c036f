//! glTF versions and extensions: what Lobe reads, and what to do about what it does not.

use serde_json::Value;

use crate::SceneError;
use crate::files::source::Source;

/// Required extensions that Lobe reads. Those of materials and lights are accepted and ignored: shapes and base colors
/// are the same without them, except for [`OTHER_COLORS`].
const READ_EXTENSIONS: [&str; 8] = [
    "KHR_texture_transform",
    "KHR_mesh_quantization",
    "KHR_draco_mesh_compression",
    "EXT_meshopt_compression",
    "KHR_meshopt_compression",
    "EXT_mesh_gpu_instancing",
    "EXT_texture_webp",
    "KHR_texture_basisu",
];

/// The extension whose materials store their colors elsewhere.
const OTHER_COLORS: &str = "KHR_materials_pbrSpecularGlossiness";

/// Refuses files of another version, and those that require what Lobe does not read.
pub(crate) fn check(json: &Value, source: &mut Source<'_>) -> Result<(), SceneError> {
    check_version(&json["asset"], source)?;
    let names = |member: &str| {
        let names = json[member].as_array().into_iter().flatten();
        names.filter_map(Value::as_str).collect::<Vec<_>>()
    };
    if names("extensionsUsed").contains(&OTHER_COLORS) {
        source.note(format!("{OTHER_COLORS} is not used, colors may be missing: convert to metallic-roughness"));
    }
    for name in names("extensionsRequired") {
        if (name.starts_with("KHR_materials_") && name != OTHER_COLORS) || name == "KHR_lights_punctual" {
            source.note(format!("{name} is not used"));
        } else if !READ_EXTENSIONS.contains(&name) {
            return Err(source.unsupported(refusal(name)));
        }
    }
    Ok(())
}

fn check_version(asset: &Value, source: &Source<'_>) -> Result<(), SceneError> {
    let (version, least) = (&asset["version"], &asset["minVersion"]);
    let Some(found) = (if least.is_null() { version } else { least }).as_str() else {
        return Err(source.invalid("expected glTF, found an error: asset.version is missing"));
    };
    let minor = found.strip_prefix("2.");
    if minor.is_none() || (!least.is_null() && minor != Some("0")) {
        return Err(source.unsupported(format!("expected version 2.0 of glTF, found {found}")));
    }
    Ok(())
}

/// The message for a file that requires an extension.
fn refusal(extension: &str) -> String {
    let advice = match extension {
        "EXT_texture_avif" => "convert its textures with `gltf-transform png IN OUT`",
        OTHER_COLORS => "convert its materials with `gltf-transform metalrough IN OUT`",
        _ => "export it without",
    };
    format!("the file requires {extension}, which Lobe does not read: {advice}")
}
