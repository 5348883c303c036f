//! The `extras` of a baked glTF file, which say what its attributes hold.

use base64::Engine as _;
use base64::prelude::BASE64_STANDARD;
use lobe_scene::{GltfReader, Scene};
use serde_json::{Value, json};

use crate::error::PrtError;

/// The member of `extras` that is Lobe's.
const MEMBER: &str = "lobe";

/// The version of the attributes that a bake writes into a glTF file and names in `asset.extras.lobe.version`. Baked
/// files with another one are refused.
pub const LOBE_EXTRAS_VERSION: u64 = 1;

/// Attributes that vertices with transfer have, either of them.
const MARKS: [&str; 2] = ["_TRANSFER_0", "_CLUSTER"];

/// Refuses the `extras.lobe` of a bake of another version, in the file called `name`.
pub(crate) fn check_version(lobe: &Value, name: &str) -> Result<(), PrtError> {
    let found = &lobe["version"];
    let expected = format!("expected version {LOBE_EXTRAS_VERSION} of its attributes, found {found}");
    match found.as_u64() {
        Some(LOBE_EXTRAS_VERSION) => Ok(()),
        Some(newer) if newer > LOBE_EXTRAS_VERSION => Err(PrtError::Unsupported {
            place: name.to_owned(),
            message: format!("baked by a newer Lobe: {expected}: update Lobe"),
        }),
        _ => Err(PrtError::invalid(name, format!("extras.lobe: {}", expected.replace("its", "Lobe's")))),
    }
}

/// What the file says of its transfer: `asset.extras.lobe`, or where a program has dropped that, the same of the scene
/// or of the first mesh that has it. Null of a file that is not baked.
pub(crate) fn lobe_of(gltf: &GltfReader) -> &Value {
    gltf.extras(MEMBER).find(|lobe| lobe.is_object()).unwrap_or(&Value::Null)
}

/// A member that not every place has; null if none has it.
pub(crate) fn said<'a>(gltf: &'a GltfReader, member: &str) -> &'a Value {
    gltf.extras(MEMBER).find_map(|lobe| lobe.get(member).filter(|found| !found.is_null())).unwrap_or(&Value::Null)
}

/// Whether each mesh of a scene of an open file carries transfer.
pub(crate) fn is_on_all(gltf: &GltfReader, scene: &Scene) -> bool {
    scene.meshes().iter().all(|mesh| MARKS.iter().any(|name| gltf.has(mesh, name)))
}

/// Refuses a file whose vertices carry transfer that nothing in it describes.
pub(crate) fn expect_described(gltf: &GltfReader, scene: &Scene) -> Result<(), PrtError> {
    let mark = MARKS.iter().find(|name| scene.meshes().iter().any(|mesh| gltf.has(mesh, name)));
    let (true, Some(mark)) = (lobe_of(gltf).is_null(), mark) else { return Ok(()) };
    Err(PrtError::invalid(
        gltf.name(),
        format!(
            "has {mark} of a bake, and no extras.lobe that describes it: another program dropped it; \
             export with extras (Blender: Custom Properties), or bake again"
        ),
    ))
}

/// The means and directions of compressed transfer, floats in base64; files of earlier bakes name a buffer view.
pub(crate) fn bases_of(gltf: &GltfReader) -> Result<Vec<f32>, PrtError> {
    let invalid = |message: String| PrtError::invalid(gltf.name(), message);
    let floats = |bytes: &[u8]| bytes.as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
    match said(gltf, "bases") {
        Value::String(text) => {
            let bytes = BASE64_STANDARD.decode(text).map_err(|error| {
                invalid(format!("expected the bases of compressed transfer in base64, found something else: {error}"))
            })?;
            if bytes.len() % size_of::<f32>() != 0 {
                return Err(invalid(format!("expected bases of whole floats, found {} bytes", bytes.len())));
            }
            Ok(floats(&bytes))
        }
        Value::Null => Err(invalid(
            "has compressed transfer, and no bases of it: another program dropped extras.lobe of its scene; bake again"
                .to_owned(),
        )),
        found => {
            let view = found.as_u64().and_then(|view| u32::try_from(view).ok());
            let view = view.ok_or_else(|| invalid(format!("expected bases in base64, found {found}")))?;
            Ok(floats(gltf.buffer_view(view)?))
        }
    }
}

/// Puts what is said of all transfer into the extras of the asset, and of the scene that the file shows, which alone
/// has the bases.
///
/// Blender keeps the extras of scenes and drops those of the asset; glTF-Transform keeps both, and drops buffer views
/// that no accessor uses.
pub(crate) fn put_description(json: &mut Value, about: &Value, bases: Option<&[f32]>) {
    let mut whole = about.clone();
    if let Some(bases) = bases {
        let bytes: Vec<u8> = bases.iter().flat_map(|c| c.to_le_bytes()).collect();
        whole["bases"] = json!(BASE64_STANDARD.encode(bytes));
    }
    let shown = json["scene"].as_u64().unwrap_or(0) as usize;
    match json.get_mut("scenes").and_then(|scenes| scenes.get_mut(shown)) {
        Some(scene) => {
            put_extras(scene, whole);
            put_extras(&mut json["asset"], about.clone());
        }
        None => put_extras(&mut json["asset"], whole),
    }
}

/// Puts `lobe` into the extras of an object, beside what others have put there.
pub(crate) fn put_extras(object: &mut Value, lobe: Value) {
    match &mut object["extras"] {
        Value::Object(extras) => drop(extras.insert(MEMBER.to_owned(), lobe)),
        Value::Null => object["extras"] = json!({MEMBER: lobe}),
        // Wrap extras that are no object, as any JSON may be, in one.
        other => *other = json!({MEMBER: lobe, "extras": other.take()}),
    }
}

/// Takes all that a bake says out of the extras.
pub(crate) fn remove_descriptions(json: &mut Value) {
    for array in ["meshes", "scenes"] {
        json[array].as_array_mut().into_iter().flatten().for_each(remove_extras);
    }
    json.get_mut("asset").into_iter().for_each(remove_extras);
}

/// Takes `lobe` out of the extras of an object.
fn remove_extras(object: &mut Value) {
    let Some(Value::Object(extras)) = object.get_mut("extras") else { return };
    extras.remove(MEMBER);
}
