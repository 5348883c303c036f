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
fn a_skin_that_carries_nothing_in_the_scene_need_not_be_right() {
    let file = Gltf::skinned()
        .with("/nodes/3", json!({"name": "elsewhere"}))
        .with("/nodes/4", json!({"mesh": 0, "skin": 2}))
        .with("/skins/1", json!({"name": "left over", "joints": [3, 99]}))
        .with("/skins/2", json!({"joints": []}));
    let (scene, report) = AnimatedScene::read_bytes(&file.glb(), "a.glb", &SceneReadOptions::default()).unwrap();
    assert!(report.notes.is_empty(), "{:?}", report.notes);
    assert_eq!((scene.skins(), scene.skin_names(1)), (3, (Some("left over"), Vec::new())), "without joints");
    assert_eq!(scene.skin_names(0).1, [Some("hip"), Some("knee")], "that which is used");
    let shown = refusal(&file.with("/scenes/0/nodes", json!([0, 1, 4])));
    assert_eq!(shown, "a.glb: skin 2: expected joints, found none", "once it carries something, it is checked");
}

#[test]
fn vertices_without_weight_follow_the_first_joint_that_they_name() {
    let mut file = Gltf::skinned().with_channel(0, (2, "translation"), "STEP", (&[0.0], "VEC3", &[0.0, 3.0, 0.0]));
    let mut weights = [[1.0, 0.0, 0.0, 0.0]; 4];
    weights[2] = [0.0; 4];
    let weights = file.floats("VEC4", weights.as_flattened());
    let joints = file.push("VEC4", 5121, 4, &[[0, 1, 0, 0], [0, 1, 0, 0], [1, 0, 0, 0], [0, 1, 0, 0]].concat());
    let primitive = "/meshes/0/primitives/0/attributes";
    let file = file.with(&format!("{primitive}/WEIGHTS_0"), json!(weights));
    let file = file.with(&format!("{primitive}/JOINTS_0"), json!(joints));
    let (scene, report) = AnimatedScene::read_bytes(&file.glb(), "a.glb", &SceneReadOptions::default()).unwrap();
    let note = "mesh `square`, primitive 0 has 1 vertex whose weights are all zero, which follow the first joint named";
    assert_eq!(report.notes, [note], "note");
    assert_eq!(scene.influences(0, 2).collect::<Vec<_>>(), [(1, 1.0)], "the knee");
    let pose = scene.pose(0, 0.0).unwrap();
    let heights: Vec<f32> = pose.scene().meshes()[0].positions().iter().map(|p| p[2]).collect();
    assert_eq!(heights, [0.0, 0.0, 3.0, 1.0], "only that vertex follows");
}

#[test]
fn an_animation_of_one_key_is_a_constant_before_and_after_it() {
    for (interpolation, values) in
        [("LINEAR", &PAIR[3..]), ("STEP", &PAIR[3..]), ("CUBICSPLINE", &[9.0, 9.0, 9.0, 1.0, 0.0, 0.0, 9.0, 9.0, 9.0])]
    {
        let file = Gltf::square().with_channel(0, (0, "translation"), interpolation, (&[0.5], "VEC3", values));
        let scene = AnimatedScene::read_bytes(&file.glb(), "a.glb", &SceneReadOptions::default()).unwrap().0;
        assert_eq!(scene.animations()[0].duration(), 0.5, "until its key");
        for time in [-3.0, 0.0, 0.5, 99.0] {
            let pose = scene.pose(0, time).unwrap();
            let place = pose.place(&scene.entities()[0]).translation();
            assert_eq!(place, [1.0, 0.0, 0.0], "{interpolation} at {time}");
        }
        let error = scene.pose(0, f64::INFINITY).map(|_| ()).unwrap_err().to_string();
        assert_eq!(error, "expected a finite time, found inf", "no time");
    }
}

#[test]
fn whole_numbers_are_taken_where_the_format_allows_them() {
    let keyed = |path: &str, kind: &str, component: u32, bytes: &[u8], is_normalized: bool| {
        let mut file = Gltf::square().with("/extensionsUsed", json!(["KHR_mesh_quantization"]));
        let values = file.push(kind, component, 1, bytes);
        file.json["accessors"][values]["normalized"] = json!(is_normalized);
        let file =
            file.with_channel(0, (0, path), "LINEAR", (&[0.0], kind, &[0.0; 4][..if kind == "VEC3" { 3 } else { 4 }]));
        file.with("/animations/0/samplers/0/output", json!(values))
    };
    let half_turn = [0, 127, 0, 0];
    let file = keyed("rotation", "VEC4", 5120, &half_turn, true);
    assert!(AnimatedScene::read_bytes(&file.glb(), "a.glb", &SceneReadOptions::default()).is_ok(), "a fraction of 127");
    let sampler = "a.glb: animation 0, sampler 0: expected vectors of";
    for (file, expected) in [
        (
            keyed("rotation", "VEC4", 5120, &half_turn, false),
            "4 floats as ROTATION, found 4 x I8 that is not normalized",
        ),
        (keyed("translation", "VEC3", 5120, &[1, 2, 3, 0], true), "3 floats as TRANSLATION, found 3 x I8"),
        (keyed("scale", "VEC3", 5120, &[1, 2, 3, 0], false), "3 floats as SCALE, found 3 x I8"),
    ] {
        assert_eq!(refusal(&file), format!("{sampler} {expected}"), "though positions may be whole");
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
    let last = accessors.len() - 1;
    let error = refused(&matrices.with("/skins/0/inverseBindMatrices", json!(last)), &few).to_string();
    let expected = "a.glb: expected at most 16000 numbers of animations and skins, found 16132 or more: raise \
                    SceneReadOptions::max_triangles";
    assert_eq!(error, expected, "matrices");
    let joints = Gltf::skinned().with("/skins/0", json!({"joints": vec![1; 1000]}));
    let error = refused(&joints, &few);
    assert!(matches!(error, SceneError::Refused { .. }), "matrices that are left out: {error}");
    // Weights of one mesh count for each node that shows it.
    let mut weights = Gltf::square();
    weights.json["meshes"][0]["primitives"][0]["targets"] = json!(vec![json!({}); 100]);
    weights.json["nodes"] = json!(vec![json!({"mesh": 0}); 100]);
    weights.json["scenes"][0]["nodes"] = json!((0..100).collect::<Vec<_>>());
    let error = refused(&weights, &few);
    assert!(matches!(error, SceneError::Refused { .. }), "weights: {error}");
    weights.json["scenes"][0]["nodes"] = json!([0]);
    let scene = AnimatedScene::read_bytes(&weights.glb(), "a.glb", &few).map(|(scene, _)| scene.entities().len());
    assert!(matches!(scene, Ok(1)), "of nodes in the scene: {scene:?}");
    let error = refused(&Gltf::skinned(), &SceneReadOptions::default().max_bytes(1500));
    assert!(matches!(error, SceneError::Refused { .. }), "memory: {error}");
    // What is named a thousand times is read once.
    let mut shared = Gltf::square().with_attribute("NORMAL", "VEC3", &[0.0, 0.0, 1.0].repeat(4));
    shared.json["meshes"][0]["primitives"][0]["targets"] = json!(vec![json!({"POSITION": 0}); 3000]);
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
