//! Scenes of files that pose them, as every reader of scenes sees them: where an animation, joints and morph weights
//! put things.

use std::f32::consts::FRAC_PI_2;

use lobe_scene::{
    AnimatedScene, GltfReader, Hit, Scene, SceneError, ScenePose, SceneReadOptions, SceneReadReport, Texture, Wrap,
    read_scene_bytes,
};
use serde_json::{Value, json};

use crate::common::{Gltf, base64};
use crate::motion::{animated, close, posed};

fn read_in(file: &Gltf, pose: ScenePose) -> Result<(Scene, SceneReadReport), SceneError> {
    read_scene_bytes(&file.glb(), "a.glb", &SceneReadOptions::default().pose(pose))
}

fn read(file: &Gltf) -> (Scene, SceneReadReport) {
    read_in(file, ScenePose::default()).unwrap()
}

fn at(time: f64) -> ScenePose {
    ScenePose::At { animation: None, time }
}

/// The leg, whose knee has turned by a right angle after a second.
fn bending() -> Gltf {
    let keys = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, (FRAC_PI_2 / 2.0).sin(), (FRAC_PI_2 / 2.0).cos()];
    Gltf::skinned().with_channel(0, (2, "rotation"), "LINEAR", (&[0.0, 1.0], "VEC4", &keys))
}

/// The square, whose morph target lifts it by one.
fn lifted() -> Gltf {
    let mut file = Gltf::square();
    let up = file.floats("VEC3", &[0.0, 1.0, 0.0].repeat(4));
    file.with("/meshes/0/primitives/0/targets", json!([{"POSITION": up}]))
}

#[test]
fn a_skinned_mesh_is_read_where_its_joints_carry_it_and_not_where_its_node_stands() {
    // The node of the mesh stands above the joints, which are half as large.
    let file = Gltf::skinned()
        .with("/nodes/0/translation", json!([0.0, 1.0, 0.0]))
        .with("/nodes/1/translation", json!([0.0, 0.25, 0.0]))
        .with("/nodes/1/scale", json!([0.5, 0.5, 0.5]));
    let (scene, report) = read(&file);
    let expected = [[0.0, 0.0, 0.25], [0.5, 0.0, 0.25], [0.5, 0.0, 0.75], [0.0, 0.0, 0.75]];
    assert!(close(scene.meshes()[0].positions(), &expected, 1e-6), "{:?}", scene.meshes()[0].positions());
    assert_eq!(report.notes, Vec::<String>::new(), "all that the file says is honored");
    let (unposed, report) = read_in(&file, ScenePose::Unposed).unwrap();
    assert_eq!(unposed.meshes()[0].positions()[0], [0.0, 0.0, 1.0], "as the node stands, if that is asked for");
    assert_eq!(report.notes, ["skins are not used: meshes stand as they were bound"], "which is noted");
}

#[test]
fn a_scene_is_read_in_the_pose_of_its_animation_at_any_time() {
    let scene = animated(&bending());
    for time in [0.0, 0.4, 1.0, 7.0] {
        let (found, _) = read_in(&bending(), at(time)).unwrap();
        assert_eq!(found.meshes(), posed(&scene, time).meshes(), "at {time}");
    }
    let (found, report) = read(&bending());
    assert_eq!(found.meshes(), posed(&scene, 0.0).meshes(), "the beginning unless another time is asked for");
    assert_eq!(report.remarks(), ["moves; it is taken at 0 s of its animation 0"], "which is noted");
    let (_, report) = read_in(&bending(), ScenePose::asked(None, Some(0.0))).unwrap();
    assert_eq!(report.remarks(), Vec::<String>::new(), "unless the beginning is what was asked for");
}

#[test]
fn a_fault_in_what_moves_keeps_no_scene_from_being_read_unless_a_time_is_asked_for() {
    let two = || bending().with_channel(1, (2, "rotation"), "STEP", (&[0.0], "VEC4", &[0.0, 0.0, 0.0, 1.0]));
    let twice = json!([{"sampler": 0, "target": {"node": 2, "path": "rotation"}}, {"sampler": 0, "target": {"node": 2, "path": "rotation"}}]);
    // In the first animation: two channels for one property, no such sampler, a channel of a node with a matrix.
    let faults = [
        (two().with("/animations/0/channels", twice.clone()), "two channels animate the rotation of node 2"),
        (two().with("/animations/0/channels/0/sampler", json!(9)), "uses sampler 9, but there are 1"),
        (
            two().with("/animations/0/samplers/0/interpolation", json!(7)),
            "expected glTF, found an error at animations[0]",
        ),
    ];
    let (standing, _) = read(&Gltf::skinned());
    for (file, fault) in faults {
        let (scene, report) = read(&file);
        assert_eq!(scene.meshes(), standing.meshes(), "at rest: {fault}");
        let notes = report.remarks();
        assert!(notes.len() == 1 && notes[0].contains(fault), "{notes:?} say {fault}");
        let error = read_in(&file, at(0.0)).unwrap_err().to_string();
        assert!(error.contains(fault), "{error}: asked for, {fault} is refused");
        let other = ScenePose::asked(Some("1".to_owned()), None);
        assert!(read_in(&file, other).is_ok(), "another animation is not asked for {fault}");
    }
    // In another one it is not looked at.
    let (scene, report) = read(&two().with("/animations/1/channels", twice));
    assert_eq!(scene.meshes(), read(&two()).0.meshes(), "the first animation");
    assert_eq!(report.notes, Vec::<String>::new(), "nothing to say of it");
    // In a skin.
    let file = Gltf::skinned().with("/skins/0/joints", json!([1]));
    let (scene, report) = read(&file);
    assert_eq!(scene.meshes(), read_in(&file, ScenePose::Unposed).unwrap().0.meshes(), "as it was bound");
    assert!(report.notes.iter().any(|note| note.starts_with("is not posed: ")), "{:?}", report.notes);
    assert!(read_in(&file, at(0.0)).is_err(), "asked for, a skin without its joints is refused");
}

#[test]
fn the_animation_is_chosen_by_name_or_number_and_one_that_is_not_there_is_refused() {
    let keys: [&[f32]; 2] = [&[0.0, 3.0, 0.0], &[0.0, 0.0, 5.0]];
    let file = keys.into_iter().enumerate().fold(Gltf::square(), |file, (index, place)| {
        file.with_channel(index, (0, "translation"), "STEP", (&[0.0], "VEC3", place))
    });
    let file = file.with("/animations/1/name", json!("Away"));
    let chosen = |name: Option<&str>| ScenePose::At { animation: name.map(str::to_owned), time: 0.0 };
    let corner = |name| {
        let (scene, _) = read_in(&file, chosen(name)).unwrap();
        [0, 1, 2].map(|k| f64::from(scene.meshes()[0].positions()[0][k]) + scene.origin()[k])
    };
    assert_eq!(corner(None), [0.0, 0.0, 3.0], "the first");
    for name in ["Away", "1"] {
        assert_eq!(corner(Some(name)), [0.0, -5.0, 0.0], "{name}");
    }
    let error = read_in(&file, chosen(Some("Run"))).unwrap_err().to_string();
    assert!(error.contains("found no animation `Run`") && error.contains("`Away`"), "{error}");
    let error = read_in(&Gltf::square(), chosen(Some("Run"))).unwrap_err().to_string();
    assert!(error.contains("it has none"), "{error}");
    let (_, report) = read_in(&Gltf::square(), at(2.0)).unwrap();
    assert_eq!(report.notes, ["has no animation; it stands still at all times"], "a time of nothing");
}

#[test]
fn morph_targets_have_the_weights_of_their_mesh_or_else_of_their_node() {
    let heights = |file: &Gltf| read(file).0.meshes()[0].positions()[0][2];
    assert_eq!(heights(&lifted()), 0.0, "no weight");
    let of_mesh = lifted().with("/meshes/0/weights", json!([0.5]));
    assert_eq!(heights(&of_mesh), 0.5, "that of the mesh");
    assert_eq!(heights(&of_mesh.with("/nodes/0/weights", json!([-1.0]))), -1.0, "that of the node comes first");
}

#[test]
fn triangles_that_a_pose_flattens_are_left_out_and_counted() {
    let shrunk = |scale: [f32; 3]| {
        Gltf::square().with_channel(0, (0, "scale"), "STEP", (&[0.0], "VEC3", &scale)).with_second_square()
    };
    let (scene, report) = read(&shrunk([0.0; 3]));
    assert_eq!((scene.meshes().len(), report.dropped_triangles), (1, 2), "one of two squares: {report:?}");
    assert!(report.notes.iter().any(|note| note.ends_with("has only triangles without area and was left out")));
    let (scene, report) = read(&shrunk([1.0; 3]));
    assert_eq!((scene.meshes().len(), report.dropped_triangles), (2, 0), "both: {report:?}");
}

#[test]
fn a_node_that_is_not_visible_hides_itself_and_all_below_it() {
    let hidden = |visible: Value| {
        Gltf::square().with_second_square().with("/nodes/0/extensions", json!({"KHR_node_visibility": visible}))
    };
    let count = |file: &Gltf| read(file).0.meshes().len();
    assert_eq!(count(&hidden(json!({"visible": false}))), 1, "hidden");
    assert_eq!(count(&hidden(json!({"visible": true}))), 2, "shown");
    assert_eq!(count(&hidden(json!({}))), 2, "shown where nothing is said");
    let below =
        hidden(json!({"visible": false})).with("/nodes/0/children", json!([2])).with("/nodes/2", json!({"mesh": 0}));
    assert_eq!(count(&below), 1, "its children too");
    let required = hidden(json!({"visible": false}))
        .with("/extensionsUsed", json!(["KHR_node_visibility"]))
        .with("/extensionsRequired", json!(["KHR_node_visibility"]));
    let (scene, report) = read(&required);
    assert_eq!((scene.meshes().len(), report.notes.len()), (1, 0), "required: {report:?}");
    let (still, _) = AnimatedScene::read_bytes(&required.glb(), "a.glb", &SceneReadOptions::default()).unwrap();
    assert_eq!(still.entities().len(), 1, "in scenes that move as well");
}

#[test]
fn what_is_used_and_would_change_the_picture_is_named_once() {
    let lamp = json!({"lights": [{"type": "point"}]});
    let file = Gltf::square()
        .with("/extensionsUsed", json!(["KHR_materials_sheen", "KHR_xmp_json_ld", "EXT_new_shape"]))
        .with("/extensions", json!({"KHR_lights_punctual": lamp}))
        .with(
            "/materials",
            json!([{"extensions": {"KHR_materials_unlit": {}}}, {"extensions": {"KHR_materials_unlit": {}}}]),
        );
    let expected = [
        "EXT_new_shape is not used",
        "KHR_lights_punctual is not used: light comes from the environment",
        "KHR_materials_sheen is not used",
        "KHR_materials_unlit is not used",
    ];
    assert_eq!(read(&file).1.notes, expected, "notes, listed or not");
}

#[test]
fn a_byte_order_mark_in_front_of_the_json_says_nothing() {
    let marked = [&b"\xEF\xBB\xBF"[..], &Gltf::square().gltf()].concat();
    let (scene, _) = read_scene_bytes(&marked, "a.gltf", &SceneReadOptions::default()).unwrap();
    assert_eq!(scene.meshes(), read(&Gltf::square()).0.meshes(), "the same scene");
}

#[test]
fn the_document_of_a_posed_file_belongs_to_its_scene() {
    let options = SceneReadOptions::default().pose(at(1.0));
    let open = || GltfReader::open_bytes(&bending().glb(), "a.glb", &options).unwrap();
    let (scene, _, document) = open().into_scene_and_document().unwrap();
    assert_eq!(scene.meshes(), open().scene().unwrap().0.meshes(), "the same pose");
    assert_eq!(open().scene_in(&at(0.0)).unwrap().0.meshes(), read(&bending()).0.meshes(), "or another");
    assert!(document.json["animations"].is_array(), "the file still moves");
}

#[test]
fn normal_maps_turn_with_what_a_pose_turns() {
    let texel = vec![[220, 160, 200, 255]];
    let png = Texture::new(1, 1, texel, [Wrap::Repeat; 2]).to_png();
    let uri = format!("data:image/png;base64,{}", base64(&png));
    let turn = [0.0, 0.0, (FRAC_PI_2 / 2.0).sin(), (FRAC_PI_2 / 2.0).cos()];
    let base = Gltf::skinned()
        .with_attribute("TEXCOORD_0", "VEC2", &[0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
        .with("/meshes/0/primitives/0/material", json!(0))
        .with("/materials", json!([{"normalTexture": {"index": 0}}]))
        .with("/textures", json!([{"source": 0}]))
        .with("/images", json!([{"uri": uri}]));
    let given = || base_with_tangents(&base);
    let normal = |file: Gltf| {
        let (scene, _) = read(&file);
        scene.surface(&Hit { t: 1.0, triangle: 0, u: 0.25, v: 0.25 }).shading_normal
    };
    for (name, file) in [("made", Gltf { json: base.json.clone(), buffer: base.buffer.clone() }), ("given", given())] {
        let flat = Gltf { json: file.json.clone(), buffer: file.buffer.clone() };
        let [x, y, z] = normal(flat);
        // The hip turns all about y of the world, which is -z of the file: x goes to z, z to -x.
        let turned = normal(file.with("/nodes/1/rotation", json!(turn)));
        assert!(x.abs() > 0.1 && z.abs() > 0.1, "{name}: tilted, {:?}", [x, y, z]);
        let off = (0..3).map(|k| (turned[k] - [-z, y, x][k]).abs()).fold(0.0, f32::max);
        assert!(off < 1e-5, "{name}: {turned:?} of {:?}", [x, y, z]);
    }
}

fn base_with_tangents(base: &Gltf) -> Gltf {
    let base = Gltf { json: base.json.clone(), buffer: base.buffer.clone() };
    base.with_attribute("TANGENT", "VEC4", &[1.0, 0.0, 0.0, 1.0].repeat(4))
}
