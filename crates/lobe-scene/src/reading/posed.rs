//! The scene of a glTF file at one time: as its nodes stand, or posed by an animation, skins and morph targets.

use serde_json::Value;

use crate::error::SceneError;
use crate::files::gltf::files::GltfFile;
use crate::files::gltf::normal_maps::with_tangents;
use crate::files::read_gltf::{Flattened, standing_scene_of};
use crate::files::read_options::ScenePose;
use crate::files::source::Source;
use crate::motion::read::animated_scene_of;
use crate::motion::read_animations::Wanted;
use crate::scene::scene::Scene;

/// Whether a pose may differ from how the nodes stand: there are animations, skins, or weights of morph targets.
pub(crate) fn has_poses(json: &Value) -> bool {
    let items = |member: &str| json[member].as_array().map_or(&[][..], Vec::as_slice);
    let mut weights = items("meshes").iter().chain(items("nodes")).filter_map(|of| of["weights"].as_array());
    !items("animations").is_empty()
        || !items("skins").is_empty()
        || weights.any(|weights| weights.iter().any(|weight| weight.as_f64().is_some_and(|w| w != 0.0)))
}

/// The scene of a file in a pose.
pub(crate) fn scene_of(file: &GltfFile, pose: &ScenePose, source: &mut Source<'_>) -> Result<Scene, SceneError> {
    let reads_normal_maps = source.options.normal_maps;
    match pose {
        ScenePose::Unposed => {
            let scene = standing_scene_of(file, Flattened::Dropped, reads_normal_maps, source)?;
            note_unused(file, source);
            Ok(scene)
        }
        ScenePose::At { animation: None, time } if !has_poses(&file.json) => {
            if *time != 0.0 {
                source.note("has no animation; it stands still at all times");
            }
            standing_scene_of(file, Flattened::Dropped, reads_normal_maps, source)
        }
        ScenePose::Start if !has_poses(&file.json) => {
            standing_scene_of(file, Flattened::Dropped, reads_normal_maps, source)
        }
        ScenePose::At { .. } => posed(file, pose, source),
        ScenePose::Start => {
            let mut trial = source.clone();
            match posed(file, pose, &mut trial) {
                Ok(scene) => {
                    *source = trial;
                    Ok(scene)
                }
                // A fault of the scene itself is found again.
                Err(SceneError::Invalid { message, .. } | SceneError::Unsupported { message, .. }) => {
                    let scene = scene_of(file, &ScenePose::Unposed, source)?;
                    source.note(format!("is not posed: {message}"));
                    Ok(scene)
                }
                Err(error) => Err(error),
            }
        }
    }
}

fn posed(file: &GltfFile, pose: &ScenePose, source: &mut Source<'_>) -> Result<Scene, SceneError> {
    let reads_normal_maps = source.options.normal_maps;
    let animated = animated_scene_of(file, &Wanted::Of(pose), reads_normal_maps, source)?;
    // The scene at rest stands beside its pose for a moment.
    source.check_vertices(animated.rest().vertex_count())?;
    if let (ScenePose::Start, Some(first)) = (pose, animated.animations().first())
        && !first.channels.is_empty()
    {
        let name = first.name().map_or_else(|| "0".to_owned(), |name| format!("`{name}`"));
        source.assume_animation(&name);
    }
    with_areas(animated.posed_as(pose)?, source)
}

/// A posed scene without the triangles that have no area in the pose, and with the tangents that normal maps need.
fn with_areas(posed: Scene, source: &mut Source<'_>) -> Result<Scene, SceneError> {
    let origin = posed.origin();
    let (meshes, materials, textures) = posed.into_parts();
    let mut all = Vec::with_capacity(meshes.len());
    for mesh in meshes {
        let normal_map = mesh.material().and_then(|index| materials.get(index)?.normal_map);
        all.extend(match (source.with_area(mesh), normal_map) {
            (Some(mesh), Some(map)) => Some(with_tangents(mesh, map, source)?),
            (mesh, _) => mesh,
        });
    }
    if all.is_empty() {
        return Err(source.no_triangles());
    }
    let scene = Scene::new(all, materials, textures).map_err(|error| error.within(source.name))?;
    Ok(scene.moved(origin))
}

fn note_unused(file: &GltfFile, source: &mut Source<'_>) {
    let has = |member: &str| file.json[member].as_array().is_some_and(|items| !items.is_empty());
    let has_targets =
        file.root.meshes.iter().flat_map(|mesh| &mesh.primitives).any(|primitive| primitive.targets.is_some());
    for (is_there, what) in [
        (has("animations"), "animations are not used: the scene stands as its nodes say"),
        (has("skins"), "skins are not used: meshes stand as they were bound"),
        (has_targets, "morph targets are not used: meshes stand as they are without"),
    ] {
        if is_there {
            source.note(what);
        }
    }
}
