//! A glTF file with animations, skins and morph targets, posed at times of all of its animations.
#![no_main]

use libfuzzer_sys::fuzz_target;
use lobe_scene::{AnimatedScene, PosedScene, SceneError, SceneReadOptions};

/// Small enough that no input takes long, large enough that every path is reached.
const LIMIT: usize = 1 << 12;

/// Of many animations the first are posed.
const MOST: usize = 4;

fuzz_target!(|bytes: &[u8]| {
    let name = if bytes.starts_with(b"glTF") { "fuzz.glb" } else { "fuzz.gltf" };
    let options = SceneReadOptions::default().max_triangles(LIMIT).max_texels(LIMIT);
    let scene = match AnimatedScene::read_bytes(bytes, name, &options) {
        Ok((scene, _)) => scene,
        Err(error) => {
            let line = error.to_string();
            assert!(line.starts_with(name) && !line.contains('\n'), "{line:?}");
            return;
        }
    };
    check_own(&scene);
    check(&scene, scene.rest_pose());
    for animation in 0..scene.animations().len().min(MOST) {
        let duration = scene.animations()[animation].duration();
        for time in [0.0, 0.3 * duration, duration, scene.animations()[animation].looped(1.3 * duration)] {
            check(&scene, scene.pose(animation, time));
        }
        let (kinds, similar) = (scene.kinds_in(animation), scene.similar_in(animation));
        assert_eq!((kinds.len(), similar.len()), (scene.entities().len(), scene.entities().len()), "for each entity");
    }
});

/// What holds of the entities in their own frames.
fn check_own(scene: &AnimatedScene) {
    let mut first = 0;
    for entity in scene.entities() {
        assert_eq!(entity.vertices().start, first, "entities side by side");
        first = entity.vertices().end;
        for mesh in entity.meshes() {
            for vertex in 0..scene.rest().meshes()[mesh].positions().len() {
                let sum: f64 = scene.influences(mesh, vertex).map(|(_, weight)| weight).sum();
                assert!(entity.skin().is_none() && sum == 0.0 || (sum - 1.0).abs() < 1e-6, "weights sum to {sum}");
            }
        }
        if let Err(error) = scene.own_scene(entity) {
            assert!(!error.to_string().contains('\n'), "{error}");
        }
    }
    assert_eq!(first, scene.rest().vertex_count(), "all vertices");
}

/// What holds of all poses: the same meshes of finite numbers, and places of entities and joints.
fn check(scene: &AnimatedScene, pose: Result<PosedScene, SceneError>) {
    let pose = match pose {
        Ok(pose) => pose,
        Err(error) => return assert!(!error.to_string().contains('\n'), "{error}"),
    };
    assert_eq!(pose.scene().triangle_count(), scene.rest().triangle_count(), "triangles");
    for (mesh, rest) in pose.scene().meshes().iter().zip(scene.rest().meshes()) {
        assert_eq!(mesh.positions().len(), rest.positions().len(), "vertices");
        let is_finite = |points: &[[f32; 3]]| points.as_flattened().iter().all(|c| c.is_finite());
        assert!(is_finite(mesh.positions()) && is_finite(mesh.normals()), "a position or a normal is not finite");
    }
    for entity in scene.entities() {
        if let Some(found) = pose.place(entity).nearest_similarity() {
            assert!(found.scale > 0.0 && found.rotation.iter().all(|c| c.is_finite()), "{found:?}");
        }
        if let Some(skin) = entity.skin() {
            assert_eq!(pose.joints(skin).len(), pose.joint_maps(skin).len(), "joints");
        }
    }
    assert_eq!(pose.bvh().triangle_count(), pose.scene().triangle_count(), "a tree");
}
