//! Animated files that contradict themselves or ask for too much: refused in one line.

use lobe_scene::{AnimatedScene, SceneError, SceneReadOptions};
use serde_json::{Value, json};

use crate::common::Gltf;
use crate::hostile_files::pointers;

fn refusal(file: &Gltf) -> String {
    let found = AnimatedScene::read_bytes(&file.glb(), "a.glb", &SceneReadOptions::default());
    found.map(|_| ()).unwrap_err().to_string()
}

const PAIR: [f32; 6] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0];

fn moving(times: &[f32], values: &[f32]) -> Gltf {
    Gltf::square().with_channel(0, (0, "translation"), "LINEAR", (times, "VEC3", values))
}

#[test]
fn animations_that_cannot_be_are_refused_in_one_line() {
    let twice = moving(&[0.0, 1.0], &PAIR).with_channel(0, (0, "translation"), "STEP", (&[0.0], "VEC3", &[0.0; 3]));
    let good = || moving(&[0.0, 1.0], &PAIR);
    let sampler = "animation 0, sampler 0";
    for (file, expected) in [
        (
            moving(&[1.0, 0.5], &PAIR),
            format!("{sampler}: expected keys in the order of time, found 0.5 after 1 at key 1"),
        ),
        (moving(&[1.0, f32::NAN], &PAIR), format!("{sampler}: expected times from 0 on, found NaN at key 1")),
        (moving(&[0.0], &[f32::NAN; 3]), format!("{sampler}: expected finite values, found NaN at key 0")),
        (moving(&[0.0], &PAIR), format!("{sampler}: expected 3 numbers for each of 1 keys, found 6")),
        (
            good().with("/animations/0/samplers/0/interpolation", json!("CUBICSPLINE")),
            format!("{sampler}: expected 9 numbers for each of 2 keys, found 6"),
        ),
        (
            good().with("/animations/0/samplers/0/interpolation", json!("SMOOTH")),
            format!("{sampler}: expected LINEAR, STEP or CUBICSPLINE as interpolation, found `SMOOTH`"),
        ),
        (
            good().with("/animations/0/samplers/0/output", json!(99)),
            format!("{sampler}: uses accessor 99, but there are 4"),
        ),
        (
            good().with("/animations/0/samplers/0/output", json!(2)),
            format!("{sampler}: expected vectors of 3 floats as TRANSLATION, found 1 x F32"),
        ),
        (
            good().with("/animations/0/channels/0/sampler", json!(4)),
            "animation 0: uses sampler 4, but there are 1".into(),
        ),
        (
            good().with("/animations/0/channels/0/target/node", json!(9)).with("/animations/0/name", json!("walk")),
            "animation `walk`: animates node 9, but there are 1".into(),
        ),
        (
            good().with("/nodes/0/matrix", json!([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1])),
            "animation 0: animates the translation of node 0, which has a matrix instead".into(),
        ),
        (twice, "animation 0: two channels animate the translation of node 0".into()),
        (good().with("/nodes/0/children", json!([0])), "node 0 is its own ancestor or has two parents".into()),
        (
            good().with("/animations/0", json!([])),
            "expected glTF, found an error at animations[0]: expected an object".into(),
        ),
        (
            good().with("/animations/0/channels/0/target", json!({"node": 0})),
            "expected glTF, found an error at animations[0].channels[0].target: missing field `path`".into(),
        ),
    ] {
        assert_eq!(refusal(&file), format!("a.glb: {expected}"), "message");
    }
}

#[test]
fn animations_of_what_is_not_shown_are_noted_and_move_nothing() {
    let file = moving(&[0.0, 1.0], &PAIR)
        .with_channel(0, (0, "weights"), "LINEAR", (&[0.0], "SCALAR", &[1.0]))
        .with_channel(0, (0, "pointer"), "LINEAR", (&[0.0], "SCALAR", &[1.0]))
        .with("/animations/0/channels/0/target", json!({"path": "translation"}));
    let (scene, report) = AnimatedScene::read_bytes(&file.glb(), "a.glb", &SceneReadOptions::default()).unwrap();
    let notes = [
        "animation 0 animates a translation of no node, which is not used",
        "animation 0 animates weights of node 0, which has no morph targets",
        "animation 0 animates a pointer, which is not used",
    ];
    assert_eq!(report.notes, notes, "notes");
    assert_eq!(scene.pose(0, 1.0).unwrap().scene().meshes(), scene.rest().meshes(), "nothing moves");
}

#[test]
fn skins_that_cannot_be_are_refused_in_one_line() {
    let good = Gltf::skinned;
    let attribute = |name: &str, value: Value| good().with(&format!("/meshes/0/primitives/0/attributes/{name}"), value);
    let weights = |values: [f32; 16]| {
        let mut file = good();
        let index = file.floats("VEC4", &values);
        file.with("/meshes/0/primitives/0/attributes/WEIGHTS_0", json!(index))
    };
    let mut without = [0.25; 16];
    without[4..8].fill(0.0);
    let mut negative = [0.25; 16];
    negative[0] = -0.25;
    let mut without_weights = good();
    without_weights.json["meshes"][0]["primitives"][0]["attributes"].as_object_mut().unwrap().remove("WEIGHTS_0");
    let mesh = "mesh `square`, primitive 0";
    for (file, expected) in [
        (good().with("/skins/0/joints", json!([])), "skin `leg`: expected joints, found none".into()),
        (good().with("/skins/0/joints", json!([1, 7])), "skin `leg`: names joint node 7, but there are 3 nodes".into()),
        (good().with("/scenes/0/nodes", json!([0])), "skin `leg`: its joint node 1 is not in the scene".into()),
        (
            good().with("/skins/0/joints", json!([1, 2, 1])),
            "skin `leg`: expected 3 inverse bind matrices, found 2".into(),
        ),
        (
            good().with("/skins/0/joints", json!([1])),
            "node 0: a vertex of its mesh is bound to joint 1, but skin 0 has 1".into(),
        ),
        (good().with("/nodes/0/skin", json!(3)), "node 0 has skin 3, but there are 1".into()),
        (without_weights, format!("{mesh}: has JOINTS_0, but no WEIGHTS_0")),
        (weights(without), format!("{mesh}: vertex 1 has no weight: bind it to a joint")),
        (weights(negative), format!("{mesh}: expected weights from 0 on, found -0.25 at vertex 0")),
        (weights([f32::NAN; 16]), format!("{mesh}: expected weights from 0 on, found NaN at vertex 0")),
        (attribute("JOINTS_1", json!(3)), format!("{mesh}: has JOINTS_1, but no WEIGHTS_1")),
        (attribute("JOINTS_0", json!(1)), format!("{mesh}: expected 4 elements of JOINTS_0, found 6")),
        (
            attribute("JOINTS_0", json!(3)),
            format!("{mesh}: expected four bytes or shorts, unsigned, as JOINTS_0, found 4 x F32"),
        ),
    ] {
        assert_eq!(refusal(&file), format!("a.glb: {expected}"), "message");
    }
}

#[test]
fn a_mesh_without_joints_moves_with_its_node_though_that_has_a_skin() {
    let mut file = Gltf::skinned();
    let attributes = file.json["meshes"][0]["primitives"][0]["attributes"].as_object_mut().unwrap();
    attributes.remove("JOINTS_0");
    attributes.remove("WEIGHTS_0");
    let (scene, report) = AnimatedScene::read_bytes(&file.glb(), "a.glb", &SceneReadOptions::default()).unwrap();
    assert_eq!(report.notes, ["node 0 has a skin, but a mesh without joints, which moves with the node"], "note");
    assert_eq!(scene.rest_pose().unwrap().scene().meshes(), scene.rest().meshes(), "it stands");
}

#[test]
fn morph_targets_that_cannot_be_are_refused_in_one_line() {
    let with_targets = |values: &[f32]| {
        let mut file = Gltf::square();
        let index = file.floats("VEC3", values);
        file.with("/meshes/0/primitives/0/targets", json!([{"POSITION": 0}, {"POSITION": index}]))
    };
    let mesh = "a.glb: mesh `square`";
    let primitive = |targets: Value| json!({"attributes": {"POSITION": 0}, "indices": 1, "targets": targets});
    let other = json!([primitive(json!([{"POSITION": 0}, {}])), primitive(json!([]))]);
    for (file, expected) in [
        (
            with_targets(&[0.0; 9]).with_attribute("NORMAL", "VEC3", &[0.0, 0.0, 1.0].repeat(4)),
            format!("{mesh}, primitive 0: expected 4 positions in morph target 1, found 3"),
        ),
        (with_targets(&[f32::INFINITY; 12]), format!("{mesh}, primitive 0: expected finite morph targets, found inf")),
        (
            with_targets(&[0.0; 12]).with("/nodes/0/weights", json!([1.0])),
            "a.glb: node 0: expected 2 weights, one for each morph target of its mesh, found 1".into(),
        ),
        (
            with_targets(&[0.0; 12]).with_channel(0, (0, "weights"), "LINEAR", (&[0.0], "SCALAR", &[1.0])),
            "a.glb: animation 0, sampler 0: expected 2 numbers for each of 1 keys, found 1".into(),
        ),
        (
            with_targets(&[0.0; 12]).with("/meshes/0/primitives", other),
            format!("{mesh}: expected 2 morph targets in each primitive, found 0"),
        ),
    ] {
        assert_eq!(refusal(&file), expected, "message");
    }
}

#[test]
fn small_files_cannot_ask_for_many_numbers() {
    let few = SceneReadOptions::default().max_triangles(1000);
    let refused = |file: &Gltf, options: &SceneReadOptions| {
        let found = AnimatedScene::read_bytes(&file.glb(), "a.glb", options);
        found.map(|_| ()).unwrap_err()
    };
    // Accessors without bytes: many keys, many matrices, many targets of their own.
    let hollow = |count: u64, kind: &str| json!({"componentType": 5126, "count": count, "type": kind});
    let keys = moving(&[0.0], &[0.0; 3]).with("/accessors/3", hollow(1 << 40, "VEC3"));
    let error = refused(&keys, &few);
    assert!(matches!(error, SceneError::Refused { .. }), "keys: {error}");
    let mut matrices = Gltf::skinned();
    let accessors = matrices.json["accessors"].as_array_mut().unwrap();
    accessors.push(hollow(999, "MAT4"));
    accessors.push(hollow(999, "MAT4"));
    let last = accessors.len() - 1;
    let matrices = matrices
        .with("/skins/0/inverseBindMatrices", json!(last))
        .with("/skins/1", json!({"joints": [1], "inverseBindMatrices": last - 1}));
    let error = refused(&matrices, &few).to_string();
    let expected = "a.glb: expected at most 16000 numbers of animations and skins, found 31968 or more: raise \
                    SceneReadOptions::max_triangles";
    assert_eq!(error, expected, "matrices");
    let error = refused(&Gltf::skinned(), &SceneReadOptions::default().max_bytes(1500));
    assert!(matches!(error, SceneError::Refused { .. }), "memory: {error}");
    // What is named a thousand times is read once.
    let mut shared = Gltf::square().with_attribute("NORMAL", "VEC3", &[0.0, 0.0, 1.0].repeat(4));
    shared.json["meshes"][0]["primitives"][0]["targets"] = json!(vec![json!({"POSITION": 0}); 5000]);
    let scene = AnimatedScene::read_bytes(&shared.glb(), "a.glb", &few).map(|(scene, _)| scene.entities().len());
    assert!(matches!(scene, Ok(1)), "shared: {scene:?}");
}

#[test]
fn coordinates_out_of_range_in_a_pose_are_refused() {
    let file = moving(&[0.0, 1.0], &[0.0, 0.0, 0.0, 2e15, 0.0, 0.0]);
    let scene = AnimatedScene::read_bytes(&file.glb(), "a.glb", &SceneReadOptions::default()).unwrap().0;
    let error = scene.pose(0, 1.0).map(|_| ()).unwrap_err().to_string();
    let expected =
        "mesh `square`: expected coordinates of at most 1e15, found [2000000000000000.0, -0.0, 0.0] at vertex 0";
    assert_eq!(error, expected, "message");
    assert!(scene.pose(0, 0.25).is_ok(), "before that it can be posed");
}

#[test]
fn json_of_a_wrong_kind_is_posed_or_refused_in_one_line() {
    let mut file = Gltf::skinned().with_channel(0, (2, "translation"), "LINEAR", (&[0.0, 1.0], "VEC3", &PAIR));
    let lift = file.floats("VEC3", &[0.0, 1.0, 0.0].repeat(4));
    let file = file
        .with("/meshes/0/primitives/0/targets", json!([{"POSITION": lift}]))
        .with("/meshes/0/weights", json!([0.5]))
        .with_channel(0, (0, "weights"), "CUBICSPLINE", (&[0.5], "SCALAR", &[0.0, 1.0, 0.0]));
    let mut all = Vec::new();
    pointers(&file.json, "", &mut all);
    let options = SceneReadOptions::default().max_triangles(1 << 12);
    let mut posed = 0;
    for pointer in &all {
        for value in [json!([]), json!({}), json!(null), json!("a"), json!(-1), json!(2), json!(u64::MAX), json!([[0]])]
        {
            let changed = Gltf { json: file.json.clone(), buffer: file.buffer.clone() }.with(pointer, value.clone());
            let found = AnimatedScene::read_bytes(&changed.glb(), "a.glb", &options);
            let found = found.and_then(|(scene, _)| match scene.animations().len() {
                0 => scene.rest_pose(),
                _ => scene.pose(0, 0.3),
            });
            match found {
                Ok(_) => posed += 1,
                Err(error) => {
                    let message = error.to_string();
                    assert!(!message.contains('\n'), "{pointer} as {value}: {message:?}");
                }
            }
        }
    }
    assert!(posed > 50, "{posed} of {} files could be posed", 8 * all.len());
}
