//! glTF versions and extensions: what Lobe reads, and what to do about what it does not.

use std::collections::BTreeSet;

use serde_json::Value;

use crate::error::SceneError;
use crate::files::source::Source;

/// Extensions that Lobe reads. Those of materials and lights are accepted and ignored with a note: shapes and base
/// colors are the same without them, except for [`OTHER_COLORS`].
const READ_EXTENSIONS: [&str; 9] = [
    "KHR_node_visibility",
    "KHR_texture_transform",
    "KHR_mesh_quantization",
    "KHR_draco_mesh_compression",
    "EXT_meshopt_compression",
    "KHR_meshopt_compression",
    "EXT_mesh_gpu_instancing",
    "EXT_texture_webp",
    "KHR_texture_basisu",
];

/// The extension of lamps.
const LIGHTS: &str = "KHR_lights_punctual";

/// Extensions of which nothing is seen in a picture, or that are named by notes of their own where something is.
const WITHOUT_NOTE: [&str; 16] = [
    // Notes of their own.
    "KHR_animation_pointer",
    "KHR_materials_emissive_strength",
    "KHR_materials_transmission",
    "KHR_materials_volume",
    "EXT_texture_avif",
    OTHER_COLORS,
    // What programs do with the scene, and what they know of it.
    "EXT_instance_features",
    "EXT_mesh_features",
    "EXT_structural_metadata",
    "KHR_interactivity",
    "KHR_node_hoverability",
    "KHR_node_selectability",
    "KHR_physics_rigid_bodies",
    "KHR_xmp",
    "KHR_xmp_json_ld",
    "VRMC_node_constraint",
];

/// The arrays of a file whose objects may have extensions that change what is seen.
const EXTENDED: [&str; 4] = ["materials", "meshes", "nodes", "textures"];

/// The extension whose materials store their colors elsewhere.
const OTHER_COLORS: &str = "KHR_materials_pbrSpecularGlossiness";

/// Refuses files of another version, and those that require what Lobe does not read.
pub(crate) fn check(json: &Value, source: &mut Source<'_>) -> Result<(), SceneError> {
    check_version(&json["asset"], source)?;
    let names = |member: &str| {
        let names = json[member].as_array().into_iter().flatten();
        names.filter_map(Value::as_str).collect::<Vec<_>>()
    };
    let used = used_by(json);
    if used.contains(OTHER_COLORS) {
        source.note(format!("{OTHER_COLORS} is not used, colors may be missing: convert to metallic-roughness"));
    }
    for name in names("extensionsRequired") {
        let is_ignored = (name.starts_with("KHR_materials_") && name != OTHER_COLORS) || name == LIGHTS;
        if !is_ignored && !READ_EXTENSIONS.contains(&name) {
            return Err(source.unsupported(refusal(name)));
        }
    }
    for name in used {
        if name == LIGHTS {
            source.note(format!("{LIGHTS} is not used: light comes from the environment"));
        } else if !READ_EXTENSIONS.contains(&name) && !WITHOUT_NOTE.contains(&name) {
            source.note(format!("{name} is not used"));
        }
    }
    Ok(())
}

/// The extensions that a file lists, and those that it uses without, in alphabetical order.
fn used_by(json: &Value) -> BTreeSet<&str> {
    let lists = ["extensionsUsed", "extensionsRequired"];
    let listed = lists.iter().flat_map(|list| json[*list].as_array().into_iter().flatten()).filter_map(Value::as_str);
    let objects = EXTENDED.iter().flat_map(|array| json[*array].as_array().into_iter().flatten());
    let found = objects.chain([json]).filter_map(|object| object["extensions"].as_object());
    listed.chain(found.flat_map(|extensions| extensions.keys().map(String::as_str))).collect()
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
