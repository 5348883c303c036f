//! Scenes posed by animations of nodes: against the same files with nodes that stand there.

use lobe_scene::{AnimatedScene, EntityKind, Scene, SceneError, SceneReadOptions, read_scene_bytes};
use serde_json::json;

use crate::common::Gltf;

pub(crate) fn animated(file: &Gltf) -> AnimatedScene {
    AnimatedScene::read_bytes(&file.glb(), "a.glb", &SceneReadOptions::default()).unwrap().0
}

fn scene(file: &Gltf) -> Scene {
    read_scene_bytes(&file.glb(), "a.glb", &SceneReadOptions::default()).unwrap().0
}

pub(crate) fn posed(scene: &AnimatedScene, time: f64) -> Scene {
    scene.pose(0, time).unwrap().into_scene()
}

pub(crate) fn close(a: &[[f32; 3]], b: &[[f32; 3]], most: f32) -> bool {
    a.len() == b.len() && a.iter().flatten().zip(b.iter().flatten()).all(|(a, b)| (a - b).abs() <= most)
}

#[test]
fn an_entity_is_found_by_the_name_of_its_mesh_where_its_node_has_none() {
    let file = Gltf::square().with("/meshes/0/name", json!("Cesium_Man"));
    let scene = animated(&file);
    let name = scene.rest().meshes()[0].name();
    assert!(name.contains("Cesium_Man"), "the name in messages: {name}");
    assert_eq!(scene.entity(name).unwrap().node(), 0, "by the name of the mesh");
    assert_eq!(scene.entity("0").unwrap().node(), 0, "by the number of the node");
    let error = scene.entity("nobody").unwrap_err().to_string();
    assert_eq!(error, format!("found no entity `nobody` in the scene: expected one of `{name}`"), "message");
}

/// Keys of all three properties of node 0, at 1 s and 2 s, those at 2 s as a transform of the node.
fn moving_square() -> (Gltf, Gltf) {
    let file = Gltf::square().with_attribute("NORMAL", "VEC3", &[0.0, 0.0, 1.0].repeat(4));
    let still = Gltf { json: file.json.clone(), buffer: file.buffer.clone() }
        .with("/nodes/0/translation", json!([1.0_f32, -2.0, 0.1_f32]))
        .with("/nodes/0/rotation", json!([0.6_f32, 0.0, 0.0, 0.8_f32]))
        .with("/nodes/0/scale", json!([2.0, 0.5, -1.5]));
    let moving = file
        .with_channel(0, (0, "translation"), "LINEAR", (&[1.0, 2.0], "VEC3", &[0.0, 0.0, 0.0, 1.0, -2.0, 0.1]))
        .with_channel(0, (0, "rotation"), "STEP", (&[1.0, 2.0], "VEC4", &[0.0, 0.0, 0.0, 1.0, 0.6, 0.0, 0.0, 0.8]))
        .with_channel(
            0,
            (0, "scale"),
            "CUBICSPLINE",
            (
                &[1.0, 2.0],
                "VEC3",
                &[0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 5.0, 5.0, 5.0, 7.0, 7.0, 7.0, 2.0, 0.5, -1.5, 0.0, 0.0, 0.0],
            ),
        );
    (moving, still)
}

#[test]
fn a_pose_at_a_key_is_the_scene_whose_nodes_stand_there() {
    let (moving, still) = moving_square();
    let (moving, still) = (animated(&moving), scene(&still));
    let (found, expected) = (posed(&moving, 2.0), still.meshes()[0].clone());
    assert!(close(found.meshes()[0].positions(), expected.positions(), 1e-6), "{found:?}, expected {expected:?}");
    assert!(close(found.meshes()[0].normals(), expected.normals(), 1e-6), "{found:?}, expected {expected:?}");
    assert_eq!(found.meshes()[0].triangles(), expected.triangles(), "mirrored triangles run around the other way");
    // Half way, translation is linear, rotation still that of the first key, and the spline has swung out.
    let half = posed(&moving, 1.5);
    let scale = 0.5 + 0.5 * 2.0 + 5.0 / 8.0 - 7.0 / 8.0;
    let expected = [0.5 + scale, 0.0 - 0.05, -1.0];
    assert!(close(&half.meshes()[0].positions()[1..2], &[expected], 1e-6), "{half:?}, expected {expected:?}");
}

#[test]
fn what_nothing_moves_is_the_scene_at_rest_bit_by_bit() {
    let file = Gltf::square()
        .with("/scenes/0/nodes", json!([0, 1]))
        .with("/nodes/0/rotation", json!([0.1, 0.2, 0.3, 0.9]))
        .with("/nodes/1", json!({"mesh": 0, "translation": [0.5, 0.25, 2.0]}))
        .with_channel(0, (1, "translation"), "LINEAR", (&[0.0, 1.0], "VEC3", &[0.5, 0.25, 2.0, 4.0, 0.0, 0.0]));
    let (moving, still) = (animated(&file), scene(&file));
    assert_eq!(moving.rest().meshes(), still.meshes(), "at rest");
    assert_eq!(posed(&moving, 0.0).meshes(), still.meshes(), "where the animation begins as the nodes stand");
    let later = posed(&moving, 1.0);
    assert_eq!(later.meshes()[0], still.meshes()[0], "a node without animation");
    assert!(later.meshes()[1] != still.meshes()[1], "a node with");
    let kinds: Vec<_> =
        moving.entities().iter().map(|entity| (entity.node(), entity.kind(), entity.vertices())).collect();
    assert_eq!(kinds, [(0, EntityKind::Static, 0..4), (1, EntityKind::Rigid, 4..8)], "entities");
}

#[test]
fn what_is_below_a_moving_node_moves_and_idle_channels_move_nothing() {
    let file = Gltf::square()
        .with("/scenes/0/nodes", json!([2, 0]))
        .with("/nodes/0/translation", json!([0.1, 0.0, 0.0]))
        .with("/nodes/1", json!({"mesh": 0}))
        .with("/nodes/2", json!({"children": [1]}))
        .with_channel(0, (2, "scale"), "LINEAR", (&[0.0, 1.0], "VEC3", &[1.0, 1.0, 1.0, 2.0, 2.0, 2.0]))
        .with_channel(1, (0, "translation"), "LINEAR", (&[0.0, 1.0], "VEC3", &[0.1, 0.0, 0.0, 0.1, 0.0, 0.0]));
    let scene = animated(&file);
    let kinds: Vec<_> = scene.entities().iter().map(|entity| (entity.node(), entity.kind())).collect();
    assert_eq!(kinds, [(1, EntityKind::Rigid), (0, EntityKind::Static)], "all animations");
    let in_second: Vec<_> = scene.entities().iter().map(|entity| scene.kind_in(1, entity)).collect();
    assert_eq!(in_second, [EntityKind::Static; 2], "the second animation");
    let place = scene.pose(0, 1.0).unwrap().place(&scene.entities()[0]).similarity();
    assert!(place.is_some_and(|place| (place.scale - 2.0).abs() < 1e-12), "{place:?}");
}

#[test]
fn times_outside_are_clamped_and_can_be_looped() {
    let scene = animated(&moving_square().0);
    let at = |time| posed(&scene, time).meshes().to_vec();
    assert_eq!(at(-3.0), at(1.0), "before the first key");
    assert_eq!(at(99.0), at(2.0), "after the last one");
    let animation = &scene.animations()[0];
    assert_eq!(animation.duration(), 2.0, "duration");
    for (time, expected) in [(0.0, 0.0), (1.5, 1.5), (2.0, 0.0), (7.5, 1.5), (-0.5, 1.5), (-1e-30, 0.0)] {
        assert_eq!(animation.looped(time), expected, "{time} looped");
    }
    let error = scene.pose(0, f64::NAN).unwrap_err();
    assert!(
        matches!(&error, SceneError::Options(message) if message == "expected a finite time, found NaN"),
        "{error}"
    );
}

#[test]
fn entities_are_found_by_name_or_by_the_number_of_their_node() {
    let scene = lobe_scene::built_in::walking_figure(8);
    let figure = scene.entity("figure").unwrap();
    assert!(figure.skin().is_some(), "the one with a skin");
    assert_eq!(scene.entity(&figure.node().to_string()).unwrap(), figure, "by number");
    let error = scene.entity("no\none").unwrap_err().to_string();
    assert_eq!(error, "found no entity `no one` in the scene: expected one of `ground`, `figure`", "message");
}

#[test]
fn animations_are_found_by_name_or_by_number() {
    let keys: (&[f32], &str, &[f32]) = (&[0.5], "VEC3", &[3.0, 0.0, 0.0]);
    let file = Gltf::square()
        .with_channel(0, (0, "translation"), "LINEAR", keys)
        .with_channel(1, (0, "scale"), "LINEAR", keys)
        .with("/animations/1/name", json!("0"));
    let scene = animated(&file);
    assert_eq!(scene.animations()[1].name(), Some("0"), "a name");
    let found = [scene.animation("0").unwrap(), scene.animation("1").unwrap()];
    assert_eq!(found, [1, 1], "names come before numbers");
    assert_eq!(scene.animation_of_number(0).unwrap(), 0, "a number is no name");
    let error = scene.animation_of_number(2).unwrap_err().to_string();
    assert_eq!(error, "found no animation `2` in the scene: expected one of 0 (without a name), `0`", "message");
    let error = scene.animation("walk").unwrap_err().to_string();
    assert_eq!(error, "found no animation `walk` in the scene: expected one of 0 (without a name), `0`", "message");
    let error = scene.pose(2, 0.0).unwrap_err().to_string();
    assert_eq!(error, "found no animation 2: the scene has 2", "message");
    let both = scene.pose_together(&[(0, 0.0), (1, 0.0)]).unwrap().into_scene();
    assert_eq!(both.meshes()[0].positions()[1], [6.0, 0.0, 0.0], "moved by the one and scaled by the other");
}

#[test]
fn animations_of_whole_numbers_are_those_of_floats() {
    let mut file = Gltf::square();
    let half = 0.5_f32.sqrt();
    let shorts = [0.0, half, 0.0, half].map(|c| (c * 32767.0).round() as i16);
    let output = file.push("VEC4", 5122, 1, &shorts.map(i16::to_le_bytes).concat());
    file.json["accessors"][output]["normalized"] = json!(true);
    let input = file.floats("SCALAR", &[0.0]);
    let file = file.with(
        "/animations",
        json!([{"channels": [{"sampler": 0, "target": {"node": 0, "path": "rotation"}}],
                "samplers": [{"input": input, "output": output}]}]),
    );
    let found = posed(&animated(&file), 0.0);
    let still = scene(&Gltf::square().with("/nodes/0/rotation", json!([0.0, half, 0.0, half])));
    let (found, expected) = (found.meshes()[0].positions(), still.meshes()[0].positions());
    assert!(close(found, expected, 1e-4), "{found:?}, expected {expected:?}");
}

#[test]
fn triangles_keep_their_order_whatever_area_they_lose_or_gain() {
    let indices: [u16; 6] = [0, 1, 1, 0, 2, 3];
    let mut file = Gltf::square();
    file.buffer.splice(48..60, indices.iter().flat_map(|i| i.to_le_bytes()));
    let scales = [1.0, 1.0, 1.0, 0.0, 0.0, 0.0, -1.0, 1.0, 1.0];
    let file = file.with_channel(0, (0, "scale"), "LINEAR", (&[0.0, 1.0, 2.0], "VEC3", &scales));
    let scene = animated(&file);
    assert_eq!(scene.rest().meshes()[0].dropped_triangles(), 1, "one has no area at rest");
    for (time, expected) in [(0.0, [0, 2, 3]), (1.0, [0, 2, 3]), (2.0, [0, 3, 2])] {
        let mesh = posed(&scene, time).meshes()[0].clone();
        assert_eq!(mesh.triangles(), [expected], "at {time}: it stays without area, and turns in a mirror");
        assert!(mesh.normals().iter().all(|n| n.iter().map(|c| c * c).sum::<f32>() > 0.99), "unit normals at {time}");
    }
    // The outside stays outside.
    assert_eq!(posed(&scene, 2.0).meshes()[0].normals()[0], [0.0, -1.0, 0.0], "in the mirror");
}

#[test]
fn a_scene_far_from_the_origin_is_posed_as_precisely_as_near_it() {
    let at = |place: f64| {
        let (file, _) = moving_square();
        animated(
            &file
                .with("/scenes/0/nodes", json!([1]))
                .with("/nodes/1", json!({"children": [0], "translation": [place, 0.0, -place]})),
        )
    };
    let (near, far) = (at(0.0), at(1e7 + 0.1));
    for time in [1.0, 1.3, 2.0] {
        let (near, far) = (posed(&near, time), posed(&far, time));
        assert_eq!(far.origin()[0], 1e7 + 0.1, "its origin");
        let (a, b) = (near.meshes()[0].positions(), far.meshes()[0].positions());
        assert!(close(a, b, 1e-6), "{b:?} at {time}, expected {a:?}");
    }
}

#[test]
fn flat_triangles_and_instances_are_posed_as_they_are_read() {
    let mut file = Gltf::square();
    // Folded along its diagonal, and shown twice by one node.
    file.buffer[44..48].copy_from_slice(&1_f32.to_le_bytes());
    let places = file.floats("VEC3", &[0.0, 0.0, 0.0, 3.0, 0.0, 0.0]);
    let attributes = json!({"attributes": {"TRANSLATION": places}});
    let file = file.with("/nodes/0/extensions", json!({"EXT_mesh_gpu_instancing": attributes})).with_channel(
        0,
        (0, "translation"),
        "LINEAR",
        (&[0.0], "VEC3", &[0.0, 5.0, 0.0]),
    );
    let scene = animated(&file);
    assert_eq!((scene.rest().meshes().len(), scene.rest().vertex_count()), (2, 12), "two instances of six vertices");
    let posed = posed(&scene, 0.0);
    for (mesh, still) in posed.meshes().iter().zip(scene.rest().meshes()) {
        let up: Vec<_> = still.positions().iter().map(|&[x, y, z]| [x, y, z + 5.0]).collect();
        assert!(close(mesh.positions(), &up, 1e-6), "{:?}, expected {up:?}", mesh.positions());
        assert!(close(mesh.normals(), still.normals(), 1e-6), "normals of flat triangles");
    }
    let entities: Vec<_> = scene.entities().iter().map(|entity| (entity.kind(), entity.meshes())).collect();
    assert_eq!(entities, [(EntityKind::Rigid, 0..1), (EntityKind::Rigid, 1..2)], "each moves with the node");
}

#[test]
fn an_entity_in_its_own_frame_and_its_place_are_the_entity_in_the_scene() {
    let (file, _) = moving_square();
    let file = file.with("/nodes/0/scale", json!([-1.0, 1.0, 1.0]));
    let scene = animated(&file);
    let entity = &scene.entities()[0];
    let own = scene.own_scene(entity).unwrap();
    assert_eq!(own.meshes()[0].triangles()[0], [0, 1, 2], "in its own frame nothing is mirrored");
    for time in [1.0, 1.7, 2.0] {
        let posed = scene.pose(0, time).unwrap();
        let place = posed.place(entity);
        for (p, q) in own.meshes()[0].positions().iter().zip(posed.scene().meshes()[0].positions()) {
            let found = place.to_scene(p.map(f64::from)).map(|c| c as f32);
            assert!(close(&[found], &[*q], 1e-6), "{p:?} at {time} is at {found:?}, expected {q:?}");
        }
    }
}

#[test]
fn other_files_stand_still() {
    let triangle = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let (scene, _) = AnimatedScene::read_bytes(triangle, "a.obj", &SceneReadOptions::default()).unwrap();
    assert!(scene.animations().is_empty() && scene.entities().len() == 1, "one entity");
    assert_eq!(scene.entities()[0].kind(), EntityKind::Static, "it stands");
    assert_eq!(scene.rest_pose().unwrap().scene().meshes(), scene.rest().meshes(), "as it was read");
    let error = scene.animation("walk").unwrap_err().to_string();
    assert_eq!(error, "found no animation `walk` in the scene: it has none", "message");
}
