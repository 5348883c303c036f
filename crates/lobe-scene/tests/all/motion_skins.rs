//! Scenes posed by skins and morph targets.

use lobe_scene::{AnimatedScene, EntityKind, Place, Scene, SceneReadOptions};
use serde_json::json;

use crate::common::Gltf;
use crate::motion::{animated, close, posed};

/// A turn about z by an angle, as keys are.
fn turn(angle: f32) -> [f32; 4] {
    [0.0, 0.0, (angle / 2.0).sin(), (angle / 2.0).cos()]
}

/// The leg bends at the knee, joint node 2, by a right angle in one second.
fn bending() -> Gltf {
    let keys = [turn(0.0), turn(std::f32::consts::FRAC_PI_2)].concat();
    Gltf::skinned().with_channel(0, (2, "rotation"), "LINEAR", (&[0.0, 1.0], "VEC4", &keys))
}

#[test]
fn vertices_follow_the_weighted_sum_of_their_joints() {
    let scene = animated(&bending());
    let bent = posed(&scene, 1.0);
    // Turned about (0, 1) by 90°: (1, 1) goes to (0, 2), (0, 1) stays; y is up in the world.
    let expected = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 0.0, 2.0], [0.0, 0.0, 1.0]];
    assert!(close(bent.meshes()[0].positions(), &expected, 1e-6), "{:?}", bent.meshes()[0].positions());
    assert!(close(bent.meshes()[0].normals(), &[[0.0, -1.0, 0.0]; 4], 1e-6), "all in one plane");
    let entity = &scene.entities()[0];
    assert_eq!((entity.kind(), entity.skin()), (EntityKind::Deformed, Some(0)), "a skin");
    assert_eq!(scene.skin_names(0), (Some("leg"), vec![Some("hip"), Some("knee")]), "names");
    assert_eq!(scene.influences(0, 3).collect::<Vec<_>>(), [(0, 0.25), (1, 0.75)], "weights");
}

#[test]
fn a_skin_whose_joints_move_alike_moves_as_a_whole_wherever_its_node_stands() {
    let keys: (&[f32], &str, &[f32]) = (&[0.0], "VEC4", &[0.48, 0.6, 0.0, 0.64]);
    let skinned = Gltf::skinned()
        .with("/nodes/0/translation", json!([7.0, 8.0, 9.0]))
        .with_channel(0, (1, "rotation"), "STEP", keys)
        .with_channel(0, (1, "scale"), "STEP", (&[0.0], "VEC3", &[1.0, 2.0, -0.5]));
    let rigid = Gltf::square()
        .with_attribute("NORMAL", "VEC3", &[0.0, 0.0, 1.0].repeat(4))
        .with_channel(0, (0, "rotation"), "STEP", keys)
        .with_channel(0, (0, "scale"), "STEP", (&[0.0], "VEC3", &[1.0, 2.0, -0.5]));
    let skinned = posed(&animated(&skinned), 0.0);
    assert_eq!(skinned.origin(), [7.0, -9.0, 8.0], "positions count from where the mesh stands at rest");
    let origin = skinned.origin().map(|c| c as f32);
    let (skinned, rigid) = (&skinned.meshes()[0], &posed(&animated(&rigid), 0.0).meshes()[0].clone());
    let in_world: Vec<_> = skinned.positions().iter().map(|p| [0, 1, 2].map(|k| p[k] + origin[k])).collect();
    assert!(close(&in_world, rigid.positions(), 2e-6), "{in_world:?}, expected {rigid:?}");
    assert!(
        close(skinned.normals(), rigid.normals(), 1e-6),
        "by the inverse transpose: {skinned:?}, expected {rigid:?}"
    );
    assert_eq!(skinned.triangles(), rigid.triangles(), "a mirror turns triangles around");
}

#[test]
fn joints_have_places_and_carry_what_is_bound_to_them() {
    let scene = animated(&bending());
    let own = scene.own_scene(&scene.entities()[0]).unwrap();
    for time in [0.0, 0.3, 1.0] {
        let pose = scene.pose(0, time).unwrap();
        let maps = pose.joint_maps(0);
        for (vertex, expected) in pose.scene().meshes()[0].positions().iter().enumerate() {
            let p = own.meshes()[0].positions()[vertex].map(f64::from);
            let mut found = [0.0; 3];
            for (joint, weight) in scene.influences(0, vertex) {
                let q = maps[joint].to_scene(p);
                (0..3).for_each(|k| found[k] += weight * q[k]);
            }
            let found = found.map(|c| c as f32);
            assert!(close(&[found], &[*expected], 1e-6), "vertex {vertex} at {time}: {found:?}, expected {expected:?}");
        }
        let places: Vec<_> = pose.joints(0).iter().map(Place::translation).collect();
        assert_eq!(places, [[0.0; 3], [0.0, 0.0, 1.0]], "where the joints are");
    }
}

#[test]
fn a_second_set_of_joints_counts_like_the_first() {
    // Half of the weight of the first set, the other half in the second, on the same joints.
    let mut file = bending();
    let attributes = &file.json["meshes"][0]["primitives"][0]["attributes"];
    let joints = attributes["JOINTS_0"].clone();
    let halves = [[0.5, 0.0], [0.5, 0.0], [0.0, 0.5], [0.125, 0.375]].map(|[a, b]| [a, b, 0.0, 0.0]);
    let halves = file.floats("VEC4", halves.as_flattened());
    let expected = posed(&animated(&bending()), 0.7);
    for (name, value) in [("JOINTS_1", joints), ("WEIGHTS_1", json!(halves)), ("WEIGHTS_0", json!(halves))] {
        file.json["meshes"][0]["primitives"][0]["attributes"][name] = value;
    }
    let found = posed(&animated(&file), 0.7);
    assert_eq!(found.meshes(), expected.meshes(), "two halves are a whole");
}

#[test]
fn weights_in_bytes_or_off_one_are_divided_by_their_sum() {
    let with_weights = |weights: [[u8; 4]; 4]| {
        let mut file = bending();
        let index = file.push("VEC4", 5121, 4, &weights.concat());
        file.json["accessors"][index]["normalized"] = json!(true);
        file.json["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"] = json!(index);
        AnimatedScene::read_bytes(&file.glb(), "a.glb", &SceneReadOptions::default()).unwrap()
    };
    let (scene, report) = with_weights([[255, 0, 0, 0], [255, 0, 0, 0], [0, 255, 0, 0], [51, 204, 0, 0]]);
    assert!(report.notes.is_empty(), "bytes that sum to 255 are one: {:?}", report.notes);
    let [(_, a), (_, b)] = scene.influences(0, 3).collect::<Vec<_>>()[..] else { panic!("two joints") };
    assert!((a - 0.2).abs() < 1e-7 && (a + b - 1.0).abs() < 1e-15, "{a} and {b}, expected 0.2 and 0.8");
    let (scene, report) = with_weights([[255, 0, 0, 0], [255, 0, 0, 0], [0, 255, 0, 0], [51, 51, 0, 0]]);
    let note = "mesh `square`, primitive 0 has 1 vertex whose weights do not sum to one, by up to 6.00e-1: they are divided \
                by their sum";
    assert_eq!(report.notes, [note], "noted");
    let found: Vec<_> = scene.influences(0, 3).collect();
    assert_eq!(found, [(0, 0.5), (1, 0.5)], "and divided");
}

/// A square with two morph targets: up by one, and the normals to +x.
fn morphing() -> Gltf {
    let mut file = Gltf::square().with_attribute("NORMAL", "VEC3", &[0.0, 0.0, 1.0].repeat(4));
    let up = file.floats("VEC3", &[0.0, 1.0, 0.0].repeat(4));
    let turned = file.floats("VEC3", &[1.0, 0.0, -1.0].repeat(4));
    file.with("/meshes/0/primitives/0/targets", json!([{"POSITION": up}, {"NORMAL": turned}]))
}

fn first(scene: &Scene) -> ([f32; 3], [f32; 3]) {
    let mesh = &scene.meshes()[0];
    (mesh.positions()[0], mesh.normals()[0])
}

#[test]
fn morph_targets_add_up_by_their_weights() {
    let weights = [0.0, 0.0, 3.0, 0.0, 3.0, 1.0];
    let file = morphing().with_channel(0, (0, "weights"), "LINEAR", (&[0.0, 1.0, 2.0], "SCALAR", &weights));
    let scene = animated(&file);
    let half = 0.5_f32.sqrt();
    for (time, height, normal) in [
        (0.0, 0.0, [0.0, -1.0, 0.0]),
        (0.5, 1.5, [0.0, -1.0, 0.0]),
        (1.5, 3.0, [half, -half, 0.0]),
        (2.0, 3.0, [1.0, 0.0, 0.0]),
    ] {
        let (position, found) = first(&posed(&scene, time));
        assert!(close(&[position, found], &[[0.0, 0.0, height], normal], 1e-6), "{position:?} {found:?} at {time}");
    }
    assert_eq!(scene.entities()[0].kind(), EntityKind::Deformed, "kind");
}

#[test]
fn a_node_has_weights_of_its_own_or_those_of_its_mesh() {
    let file = morphing()
        .with("/meshes/0/weights", json!([2.0, 0.0]))
        .with("/scenes/0/nodes", json!([0, 1]))
        .with("/nodes/1", json!({"mesh": 0, "weights": [0.5, 0.0]}));
    let scene = animated(&file);
    let pose = scene.rest_pose().unwrap().into_scene();
    let heights: Vec<f32> = pose.meshes().iter().map(|mesh| mesh.positions()[0][2]).collect();
    assert_eq!(heights, [2.0, 0.5], "of the mesh, and of the node");
    assert_eq!(scene.rest().meshes()[0].positions()[0], [0.0; 3], "at rest without");
}

#[test]
fn morph_targets_come_before_the_skin_and_may_be_sparse() {
    let mut file = bending();
    let place = file.push("SCALAR", 5121, 1, &[2]);
    let value = file.floats("VEC3", &[0.0, 1.0, 0.0]);
    let view = |file: &Gltf, accessor: usize| file.json["accessors"][accessor]["bufferView"].clone();
    let sparse = json!({
        "componentType": 5126, "count": 4, "type": "VEC3",
        "sparse": {
            "count": 1,
            "indices": {"bufferView": view(&file, place), "componentType": 5121},
            "values": {"bufferView": view(&file, value)},
        },
    });
    let index = file.json["accessors"].as_array().unwrap().len();
    let file = file
        .with(&format!("/accessors/{index}"), sparse)
        .with("/meshes/0/primitives/0/targets", json!([{"POSITION": index}]))
        .with("/nodes/0/weights", json!([0.5]));
    let found = posed(&animated(&file), 1.0);
    // (1, 1) is first moved to (1, 1.5), and then turned about (0, 1).
    assert!(close(&found.meshes()[0].positions()[2..3], &[[-0.5, 0.0, 2.0]], 1e-6), "{found:?}");
}

#[test]
fn a_pose_is_the_same_for_any_number_of_threads() {
    let scene = lobe_scene::built_in::walking_figure(24);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| posed(&scene, 0.4))
    };
    let (one, four) = (with(1), with(4));
    assert_eq!(one.meshes(), four.meshes(), "one thread and four");
}

#[test]
fn quantized_positions_and_targets_are_posed_as_floats_are() {
    // Normalized shorts, each vector padded to eight bytes: half the square, and a target that lifts it.
    let short = |c: f32| ((c * 32767.0).round() as i16).to_le_bytes();
    let positions = [0.0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.5, 0.5, 0.0, 0.0, 0.5, 0.0];
    let lift = [0.0, 0.25, 0.0].repeat(4);
    let quantized = |values: &[f32], file: &mut Gltf| {
        let padded: Vec<u8> =
            values.chunks(3).flat_map(|v| [short(v[0]), short(v[1]), short(v[2]), [0; 2]].concat()).collect();
        let index = file.push("VEC3", 5122, 4, &padded);
        file.json["accessors"][index]["normalized"] = json!(true);
        let view = file.json["accessors"][index]["bufferView"].as_u64().unwrap() as usize;
        file.json["bufferViews"][view]["byteStride"] = json!(8);
        index
    };
    let with = |is_quantized: bool| {
        let mut file = bending().with("/extensionsUsed", json!(["KHR_mesh_quantization"]));
        let mut add = |values: &[f32]| match is_quantized {
            true => quantized(values, &mut file),
            false => file.floats("VEC3", values),
        };
        let [positions, lift] = [&positions[..], &lift].map(&mut add);
        let file = file.with("/meshes/0/primitives/0/attributes/POSITION", json!(positions));
        let file = file.with("/meshes/0/primitives/0/targets", json!([{"POSITION": lift}]));
        posed(&animated(&file.with("/nodes/0/weights", json!([1.0]))), 0.6).meshes()[0].clone()
    };
    let (found, expected) = (with(true), with(false));
    assert!(close(found.positions(), expected.positions(), 1e-4), "{found:?}, expected {expected:?}");
}
