//! Shapes under animation: what keeps its shape, what is scaled to nothing, and what opens only in a pose.

use lobe_scene::{
    AnimatedScene, Bvh, EntityKind, Mesh, MeshParts, Ray, Scene, SceneReadOptions, built_in, read_scene_bytes,
};
use serde_json::{Value, json};

use crate::common::Gltf;
use crate::motion::{animated, close, posed};

fn scaled(interpolation: &str, scales: &[f32]) -> Gltf {
    let keys = scales.len() / if interpolation == "CUBICSPLINE" { 9 } else { 3 };
    let times: Vec<f32> = (0..keys).map(|k| k as f32).collect();
    Gltf::square().with_channel(0, (0, "scale"), interpolation, (&times, "VEC3", scales))
}

const POP: [f32; 9] = [1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0];

#[test]
fn even_scales_keep_a_shape_and_uneven_ones_do_not() {
    let similar = |file: &Gltf| animated(file).similar_in(0)[0];
    let turned = |file: Gltf| file.with_channel(0, (0, "translation"), "STEP", (&[0.0], "VEC3", &[1.0, 2.0, 3.0]));
    assert!(similar(&scaled("LINEAR", &POP)), "to nothing and back");
    assert!(!similar(&scaled("LINEAR", &[1.0, 1.0, 1.0, 1.0, 2.0, 1.0])), "stretched");
    assert!(!similar(&scaled("STEP", &[-1.0, -1.0, -1.0])), "in a mirror");
    assert!(similar(&turned(Gltf::square())), "moved");
    let below = |scale: Value, of_mesh: Value| {
        let file = turned(Gltf::square()).with("/scenes/0/nodes", json!([1]));
        file.with("/nodes/1", json!({"children": [2], "scale": scale}))
            .with("/nodes/2", json!({"children": [0], "scale": of_mesh}))
    };
    assert!(!similar(&below(json!([1.0, 1.0, 2.0]), json!([1.0, 1.0, 1.0]))), "below what is stretched");
    assert!(similar(&below(json!([1.0, 1.0, 2.0]), json!([2.0, 2.0, 1.0]))), "stretched and stretched back");
    assert!(!similar(&below(json!([-1.0, 1.0, 1.0]), json!([1.0, 1.0, 1.0]))), "below a mirror");
    assert!(similar(&below(json!([-1.0, 1.0, 1.0]), json!([1.0, -1.0, 1.0]))), "below two mirrors");
}

#[test]
fn what_is_scaled_to_nothing_stays_in_the_scene_and_is_not_hit() {
    let scene = animated(&scaled("LINEAR", &POP));
    let entity = &scene.entities()[0];
    for (time, is_hit) in [(0.5, true), (1.0, false), (1.5, true)] {
        let pose = scene.pose(0, time).unwrap();
        assert_eq!(pose.scene().triangle_count(), 2, "triangles at {time}");
        assert_eq!(pose.place(entity).nearest_similarity().is_some(), is_hit, "a place at {time}");
        let ray = Ray::new([0.1, -1.0, 0.1], [0.0, 1.0, 0.0]);
        assert_eq!(Bvh::new(pose.scene()).is_occluded(&ray), is_hit, "at {time}");
        let nowhere = Ray::new([0.0, -1.0, 0.0], [0.0, 1.0, 0.0]);
        assert!(is_hit || !pose.bvh().is_occluded(&nowhere), "a point is nothing");
    }
}

#[test]
fn what_is_scaled_to_nothing_at_rest_appears_in_a_pose() {
    let file = scaled("LINEAR", &[0.0, 0.0, 0.0, 2.0, 2.0, 2.0]).with("/nodes/0/scale", json!([0.0, 0.0, 0.0]));
    let expected = posed(&animated(&scaled("LINEAR", &[2.0, 2.0, 2.0])), 0.0);
    let scene = animated(&file);
    assert_eq!(posed(&scene, 1.0).meshes()[0].triangles(), expected.meshes()[0].triangles(), "all triangles");
    let found = posed(&scene, 1.0);
    assert!(close(found.meshes()[0].positions(), expected.meshes()[0].positions(), 1e-6), "{found:?}");
    assert_eq!(scene.rest_pose().unwrap().scene().triangle_count(), 2, "at rest too, as a point");
    assert_eq!(scene.own_scene(&scene.entities()[0]).unwrap().triangle_count(), 2, "and in its own frame");
    // Without its animation it is left out, as ever.
    let still = read_scene_bytes(&file.glb(), "a.glb", &SceneReadOptions::default()).unwrap_err().to_string();
    assert_eq!(still, "a.glb: expected triangles with an area, found 2 without", "the reader of scenes that stand");
}

#[test]
fn what_only_a_morph_target_opens_appears_with_it() {
    // All vertices on one line; the target moves two of them off it.
    let mut file = Gltf::square().with_attribute("NORMAL", "VEC3", &[0.0, 0.0, 1.0].repeat(4));
    let line = file.floats("VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let open = file.floats("VEC3", &[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0]);
    let file = file
        .with("/meshes/0/primitives/0/attributes/POSITION", json!(line))
        .with("/meshes/0/primitives/0/targets", json!([{"POSITION": open}]))
        .with_channel(0, (0, "weights"), "LINEAR", (&[0.0, 1.0], "SCALAR", &[0.0, 1.0]));
    let scene = animated(&file);
    let ray = Ray::new([0.6, -1.0, 0.25], [0.0, 1.0, 0.0]);
    let hit = |time| scene.pose(0, time).unwrap().bvh().is_occluded(&ray);
    assert!(!hit(0.0) && hit(0.5) && hit(1.0), "closed, half open, open");
    assert_eq!(scene.entities()[0].kind(), EntityKind::Deformed, "kind");
}

#[test]
fn triangles_without_normals_are_flat_in_poses_that_fold_them() {
    // The two corners beside the diagonal are lifted.
    let mut file = Gltf::square();
    let lift = file.floats("VEC3", &[0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
    let file = file.with("/meshes/0/primitives/0/targets", json!([{"POSITION": lift}])).with_channel(
        0,
        (0, "weights"),
        "LINEAR",
        (&[0.0, 1.0], "SCALAR", &[0.0, 1.0]),
    );
    let scene = animated(&file);
    for time in [0.0, 0.5, 1.0] {
        let pose = posed(&scene, time);
        let mesh = &pose.meshes()[0];
        assert_eq!(mesh.positions().len(), 6, "each triangle has its vertices");
        let [first, second] = [0, 1].map(|t| mesh.triangles()[t].map(|i| mesh.normals()[i as usize]));
        assert!(first == [first[0]; 3] && second == [second[0]; 3], "{first:?} and {second:?} at {time}");
        assert_eq!(first[0] == second[0], time == 0.0, "one plane at rest only: {first:?} and {second:?} at {time}");
    }
    let mut skinned = Gltf::skinned();
    skinned.json["meshes"][0]["primitives"][0]["attributes"].as_object_mut().unwrap().remove("NORMAL");
    assert_eq!(animated(&skinned).rest().vertex_count(), 6, "joints may fold it too");
}

#[test]
fn an_own_scene_has_the_morph_targets_that_stand() {
    let mut file = Gltf::square().with_attribute("NORMAL", "VEC3", &[0.0, 0.0, 1.0].repeat(4));
    let up = file.floats("VEC3", &[0.0, 1.0, 0.0].repeat(4));
    let file = file
        .with("/meshes/0/primitives/0/targets", json!([{"POSITION": up}]))
        .with("/nodes/0/weights", json!([0.5]))
        .with_channel(0, (0, "translation"), "LINEAR", (&[0.0, 1.0], "VEC3", &[0.0, 0.0, 0.0, 3.0, 0.0, 0.0]));
    let scene = animated(&file);
    let entity = &scene.entities()[0];
    assert_eq!(entity.kind(), EntityKind::Rigid, "weights that stand deform nothing");
    let (own, pose) = (scene.own_scene(entity).unwrap(), scene.pose(0, 0.7).unwrap());
    for (p, q) in own.meshes()[0].positions().iter().zip(pose.scene().meshes()[0].positions()) {
        let found = pose.place(entity).to_scene(p.map(f64::from)).map(|c| c as f32);
        assert!(close(&[found], &[*q], 1e-6), "{p:?} is at {found:?}, expected {q:?}");
    }
    assert_eq!(own.meshes()[0].positions()[0], [0.0, 0.0, 0.5], "half a target");
}

/// A node whose mesh has a primitive with joints and one without, which moves with the node.
fn mixed(joint_moves: bool) -> Gltf {
    let mut file = Gltf::skinned();
    let plain = json!({"attributes": {"POSITION": 0}, "indices": 1});
    file.json["meshes"][0]["primitives"].as_array_mut().unwrap().push(plain);
    let keys: (&[f32], &str, &[f32]) = (&[0.0, 1.0], "VEC3", &[0.0, 0.0, 0.0, 0.0, 0.0, 4.0]);
    file.with_channel(0, (0, "translation"), "LINEAR", keys).with_channel(
        1,
        (usize::from(joint_moves), "translation"),
        "LINEAR",
        keys,
    )
}

#[test]
fn an_entity_parts_where_joints_carry_some_of_its_meshes_and_the_node_others() {
    for joint_moves in [false, true] {
        let scene = animated(&mixed(joint_moves));
        let entity = &scene.entities()[0];
        assert_eq!((entity.kind(), entity.meshes()), (EntityKind::Deformed, 0..2), "both meshes");
        for animation in 0..2 {
            assert_eq!(scene.kind_in(animation, entity), EntityKind::Deformed, "one of the meshes moves");
            assert_eq!(scene.kinds_in(animation), [EntityKind::Deformed], "the same of all at once");
        }
        // Joints and the node take each vertex to where it is.
        let (own, pose) = (scene.own_scene(entity).unwrap(), scene.pose(0, 0.5).unwrap());
        let mut maps = pose.joint_maps(0);
        maps.push(pose.place(entity));
        for mesh in 0..2 {
            for (vertex, p) in own.meshes()[mesh].positions().iter().enumerate() {
                let mut found = [0.0; 3];
                for (joint, weight) in scene.influences(mesh, vertex) {
                    let q = maps[joint].to_scene(p.map(f64::from));
                    (0..3).for_each(|k| found[k] += weight * q[k]);
                }
                let (found, expected) = (found.map(|c| c as f32), pose.scene().meshes()[mesh].positions()[vertex]);
                assert!(close(&[found], &[expected], 1e-6), "vertex {vertex} of {mesh}: {found:?}, not {expected:?}");
            }
        }
    }
}

#[test]
fn instances_have_the_morph_targets_of_their_node_and_skins_are_noted() {
    let mut file = Gltf::skinned();
    let up = file.floats("VEC3", &[0.0, 1.0, 0.0].repeat(4));
    let places = file.floats("VEC3", &[0.0, 0.0, 0.0, 3.0, 0.0, 0.0]);
    let file = file
        .with("/meshes/0/primitives/0/targets", json!([{"POSITION": up}]))
        .with("/nodes/0/weights", json!([0.5]))
        .with("/nodes/0/extensions", json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": places}}}));
    let (scene, report) = AnimatedScene::read_bytes(&file.glb(), "a.glb", &SceneReadOptions::default()).unwrap();
    let pose = scene.rest_pose().unwrap();
    let first: Vec<_> = pose.scene().meshes().iter().map(|mesh| mesh.positions()[0]).collect();
    assert_eq!(first, [[0.0, 0.0, 0.5], [3.0, 0.0, 0.5]], "half a target each");
    let note = "node 0 has a skin, but instances of its mesh, which stand as it was bound";
    assert_eq!(report.notes, [note], "notes");
}

/// A column of two triangles at each time of the animation, flat without its morph target, which makes it 8 high.
fn growing_column() -> Gltf {
    let mut file = Gltf::square();
    let flat = file.floats("VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let grown = file.floats("VEC3", &[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 8.0, 0.0, 0.0, 8.0, 0.0]);
    file.with("/meshes/0/primitives/0/attributes/POSITION", json!(flat))
        .with("/meshes/0/primitives/0/targets", json!([{"POSITION": grown}]))
        .with_channel(0, (0, "weights"), "LINEAR", (&[0.0, 1.0, 2.0], "SCALAR", &[0.0, 1.0, 0.0]))
}

#[test]
fn edges_that_morph_targets_make_long_are_split_and_new_vertices_stay_on_them_in_every_pose() {
    let (coarse, longest) = (animated(&growing_column()), 1.0);
    let finer = coarse.split_edges(Some(0), longest).unwrap();
    for time in [0.0, 0.3, 1.0, 1.7] {
        let [before, after] = [&coarse, &finer].map(|scene| posed(scene, time));
        let (before, after) = (&before.meshes()[0], &after.meshes()[0]);
        let count = before.positions().len();
        assert_eq!(&after.positions()[..count], before.positions(), "old vertices at {time}");
        let height = before.positions().iter().map(|p| p[2]).fold(0.0_f32, f32::max);
        let sum = |mesh: &Mesh| (0..mesh.triangles().len()).map(|t| area(mesh.corners(t))).sum::<f32>();
        assert!((sum(after) - sum(before)).abs() < 1e-4 * (1.0 + height), "area at {time}: {}", sum(after));
        for (t, corners) in (0..after.triangles().len()).map(|t| (t, after.corners(t))) {
            let long = (0..3).map(|k| length(corners[k], corners[(k + 1) % 3])).fold(0.0, f32::max);
            assert!(long <= longest * 1.0001, "edge of {long} in triangle {t} at {time}");
        }
    }
    let (found, at_rest) = (finer.entities()[0].vertices().len(), coarse.entities()[0].vertices().len());
    assert!(found > 4 * at_rest, "{found} vertices of {at_rest}");
    let alone = coarse.split_edges(None, longest).unwrap();
    assert_eq!(alone.rest().vertex_count(), at_rest, "without its animation no edge is longer");
}

#[test]
fn meshes_with_vertices_at_the_same_places_have_the_shorter_edges_and_those_without_a_length_stay() {
    let square = |x: f32| {
        let positions = [[x, 0.0, 0.0], [x + 1.0, 0.0, 0.0], [x + 1.0, 1.0, 0.0], [x, 1.0, 0.0]].into();
        Mesh::new(MeshParts { positions, triangles: vec![[0, 1, 2], [0, 2, 3]], ..MeshParts::default() }).unwrap()
    };
    // The first two have an edge in common, the third is alone.
    let scene = Scene::new([0.0, 1.0, 5.0].map(square).into(), Vec::new(), Vec::new()).unwrap();
    let coarse = AnimatedScene::still(scene);
    let counts = |longest: [f32; 3]| {
        let finer = coarse.split_edges_of(None, &longest, "edges").unwrap();
        finer.rest().meshes().iter().map(|mesh| mesh.positions().len()).collect::<Vec<_>>()
    };
    let [short, long] = [0.3, 0.8].map(|length| counts([length; 3])[0]);
    assert!(4 < long && long < short, "{long} and {short} vertices");
    assert_eq!(counts([0.3, 0.8, 0.8]), [short, short, long], "of neighbors the shorter length");
    assert_eq!(counts([0.3, f32::INFINITY, 0.8]), [short, 4, long], "without a length it stays");
}

#[test]
fn a_figure_whose_edges_are_split_has_the_same_surface_in_every_pose() {
    let coarse = built_in::walking_figure(8);
    let finer = coarse.split_edges(Some(0), 0.1).unwrap();
    assert!(finer.rest().vertex_count() > 2 * coarse.rest().vertex_count(), "{} vertices", finer.rest().vertex_count());
    for time in [0.0, 0.3, 0.7] {
        let [before, after] = [&coarse, &finer].map(|scene| posed(scene, time));
        for (before, after) in before.meshes().iter().zip(after.meshes()) {
            let sum = |mesh: &Mesh| (0..mesh.triangles().len()).map(|t| area(mesh.corners(t))).sum::<f32>();
            let (found, expected) = (sum(after), sum(before));
            assert!((found / expected - 1.0).abs() < 1e-4, "area at {time}: {found}, expected {expected}");
        }
    }
}

#[test]
fn a_longest_edge_that_is_none_or_takes_too_many_triangles_is_refused() {
    let scene = animated(&growing_column());
    for (edge, part) in [(0.0, "above zero"), (f32::NAN, "above zero"), (1e-6, "allow longer ones")] {
        let refusal = scene.split_edges(Some(0), edge).unwrap_err().to_string();
        assert!(refusal.contains(part), "{edge}: {refusal}");
    }
}

fn length(p: [f32; 3], q: [f32; 3]) -> f32 {
    (0..3).map(|k| (p[k] - q[k]).powi(2)).sum::<f32>().sqrt()
}

fn area([a, b, c]: [[f32; 3]; 3]) -> f32 {
    let [x, y, z] = [length(a, b), length(b, c), length(c, a)].map(f64::from);
    let s = 0.5 * (x + y + z);
    ((s * (s - x) * (s - y) * (s - z)).max(0.0)).sqrt() as f32
}
