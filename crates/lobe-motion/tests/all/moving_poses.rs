//! Moving scenes against the poses of the animated scenes that they are made of.

use lobe_env::{bundled, project_env};
use lobe_io::Job;
use lobe_motion::{Motion, MovingBakeOptions, MovingMethod, MovingOptions, MovingScene, MovingShading, PartBakeKind};
use lobe_prt::{BakeMode, BakeOptions, bake_vertices};
use lobe_scene::{AnimatedScene, Bvh, EntityKind, Scene, ScenePose, SceneReadOptions, built_in};
use lobe_sh::Rgb;
use lobe_shadow::{FieldOptions, SphereFitOptions, SphereSet, read_spheres, write_spheres};
use serde_json::{Value, json};

/// A glTF file in memory: a box of side 1 about the origin, in several nodes.
struct File {
    json: Value,
    buffer: Vec<u8>,
}

const CORNERS: [[f32; 3]; 8] = {
    let mut all = [[0.0; 3]; 8];
    let mut k = 0;
    while k < 8 {
        all[k] = [(k & 1) as f32 - 0.5, (k >> 1 & 1) as f32 - 0.5, (k >> 2) as f32 - 0.5];
        k += 1;
    }
    all
};

impl File {
    /// Nodes of a file whose mesh 0 is a box, its vertices moved; it has a morph target that lifts its upper half.
    fn new(nodes: Value, by: [f32; 3]) -> Self {
        let mut file = Self { json: json!({}), buffer: Vec::new() };
        file.json =
            json!({"asset": {"version": "2.0"}, "accessors": [], "bufferViews": [], "buffers": [{"byteLength": 0}]});
        let count = nodes.as_array().unwrap().len();
        let positions: Vec<f32> = CORNERS.iter().flat_map(|p| [0, 1, 2].map(|k| p[k] + by[k])).collect();
        let positions = file.floats("VEC3", &positions);
        let sides: [[u16; 4]; 6] = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles: Vec<u8> =
            sides.iter().flat_map(|[a, b, c, d]| [*a, *b, *c, *a, *c, *d]).flat_map(u16::to_le_bytes).collect();
        let triangles = file.push("SCALAR", 5123, 36, &triangles);
        let lift: Vec<f32> = CORNERS.iter().flat_map(|p| [0.0, if p[1] > 0.0 { 0.8 } else { 0.0 }, 0.0]).collect();
        let lift = file.floats("VEC3", &lift);
        let normals = file.floats("VEC3", &CORNERS.map(|p| p.map(|c| c * 2.0 / 3_f32.sqrt())).concat());
        file.json["meshes"] = json!([{"primitives": [{
            "attributes": {"POSITION": positions, "NORMAL": normals}, "indices": triangles, "targets": [{"POSITION": lift}],
        }]}]);
        file.json["nodes"] = nodes;
        file.json["scenes"] = json!([{"nodes": (0..count).collect::<Vec<_>>()}]);
        file.json["animations"] = json!([{"channels": [], "samplers": []}]);
        file
    }

    fn push(&mut self, kind: &str, component: u32, count: usize, bytes: &[u8]) -> usize {
        self.buffer.resize(self.buffer.len().next_multiple_of(4), 0);
        let (offset, length) = (self.buffer.len(), bytes.len());
        self.buffer.extend_from_slice(bytes);
        self.json["buffers"][0]["byteLength"] = json!(self.buffer.len());
        let views = self.json["bufferViews"].as_array_mut().unwrap();
        views.push(json!({"buffer": 0, "byteOffset": offset, "byteLength": length}));
        let view = views.len() - 1;
        let accessors = self.json["accessors"].as_array_mut().unwrap();
        accessors.push(json!({"bufferView": view, "componentType": component, "count": count, "type": kind}));
        accessors.len() - 1
    }

    fn floats(&mut self, kind: &str, values: &[f32]) -> usize {
        let size = match kind {
            "SCALAR" => 1,
            "VEC3" => 3,
            "VEC4" => 4,
            _ => 16,
        };
        self.push(kind, 5126, values.len() / size, &values.iter().flat_map(|c| c.to_le_bytes()).collect::<Vec<_>>())
    }

    /// Keys of a node's property at 0, 1, 2 and so on.
    fn moved(mut self, node: usize, path: &str, kind: &str, values: &[f32]) -> Self {
        let size = if path == "weights" {
            1
        } else if path == "rotation" {
            4
        } else {
            3
        };
        let times: Vec<f32> = (0..values.len() / size).map(|k| k as f32).collect();
        let (input, output) = (self.floats("SCALAR", &times), self.floats(kind, values));
        let animation = &mut self.json["animations"][0];
        let samplers = animation["samplers"].as_array_mut().unwrap();
        samplers.push(json!({"input": input, "output": output}));
        let sampler = samplers.len() - 1;
        let target = json!({"sampler": sampler, "target": {"node": node, "path": path}});
        animation["channels"].as_array_mut().unwrap().push(target);
        self
    }

    fn translated(self, node: usize) -> Self {
        self.moved(node, "translation", "VEC3", &[0.0, 0.0, 0.0, 1.0, 2.0, 0.5, 3.0, 0.0, -1.0])
    }

    fn read(&self) -> AnimatedScene {
        AnimatedScene::read_bytes(&self.bytes(), "a.glb", &SceneReadOptions::default()).unwrap().0
    }

    fn bytes(&self) -> Vec<u8> {
        let (mut json, mut bin) = (self.json.to_string().into_bytes(), self.buffer.clone());
        json.resize(json.len().next_multiple_of(4), b' ');
        bin.resize(bin.len().next_multiple_of(4), 0);
        let mut bytes = b"glTF".to_vec();
        bytes.extend([2, (28 + json.len() + bin.len()) as u32].iter().flat_map(|w| w.to_le_bytes()));
        for (chunk, kind) in [(&json, b"JSON"), (&bin, b"BIN\0")] {
            bytes.extend((chunk.len() as u32).to_le_bytes());
            bytes.extend(kind);
            bytes.extend(chunk);
        }
        bytes
    }
}

/// A box bound to two joints, nodes 1 and 2: its lower and its upper half, moved to where it was bound.
fn bending(by: [f32; 3]) -> File {
    let joint = |at: [f32; 3]| json!({"translation": at});
    let mut file = File::new(json!([{"mesh": 0, "skin": 0}, joint(by), joint([by[0], by[1] + 0.5, by[2]])]), by);
    let joints: Vec<u8> = CORNERS.iter().flat_map(|p| [u8::from(p[1] > 0.0), 0, 0, 0]).collect();
    let (joints, weights) = (file.push("VEC4", 5121, 8, &joints), file.floats("VEC4", &[1.0, 0.0, 0.0, 0.0].repeat(8)));
    let mut binds = [[0.0_f32; 16]; 2];
    for (joint, matrix) in binds.iter_mut().enumerate() {
        [0, 5, 10, 15].into_iter().for_each(|k| matrix[k] = 1.0);
        (0..3).for_each(|k| matrix[12 + k] = -by[k]);
        matrix[13] -= 0.5 * joint as f32;
    }
    let binds = file.floats("MAT4", binds.as_flattened());
    let attributes = &mut file.json["meshes"][0]["primitives"][0]["attributes"];
    (attributes["JOINTS_0"], attributes["WEIGHTS_0"]) = (json!(joints), json!(weights));
    file.json["skins"] = json!([{"joints": [1, 2], "inverseBindMatrices": binds}]);
    file.moved(2, "rotation", "VEC4", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.6, 0.8])
}

fn files() -> Vec<(&'static str, AnimatedScene)> {
    let shown = |more: Value| {
        let mut node = json!({"mesh": 0});
        node.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        File::new(json!([node, {"mesh": 0, "translation": [0.0, -3.0, 0.0]}]), [0.0; 3])
    };
    let plain = || shown(json!({}));
    let pop = [1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 2.0, 2.0, 2.0];
    vec![
        ("three objects", built_in::three_objects(8)),
        ("a walking figure", built_in::walking_figure(8)),
        ("moved", plain().translated(0).read()),
        ("below uneven scales", shown(json!({"scale": [1.0, 2.0, -1.0]})).translated(0).read()),
        ("stretched", plain().moved(0, "scale", "VEC3", &[1.0, 1.0, 1.0, 1.0, 2.0, 0.5]).read()),
        ("scaled to nothing", plain().translated(0).moved(0, "scale", "VEC3", &pop).read()),
        ("nothing at rest", shown(json!({"scale": [0.0, 0.0, 0.0]})).moved(0, "scale", "VEC3", &pop).read()),
        ("with a weight that stands", shown(json!({"weights": [0.3]})).translated(0).read()),
        ("morphed", plain().translated(0).moved(0, "weights", "SCALAR", &[0.0, 1.0, 0.5]).read()),
        ("with a skin", bending([0.0; 3]).read()),
        ("with a skin far away", bending([50.0, 0.0, 8.0]).read()),
        ("far away", File::new(json!([{"mesh": 0}, {"mesh": 0}]), [9e4, 0.0, 3e5]).translated(0).read()),
        ("a part far away", File::new(json!([{"mesh": 0}]), [9e4, 0.0, 3e5]).translated(0).read()),
    ]
}

/// The positions of meshes of a scene in the world.
fn positions(scene: &Scene, meshes: impl Iterator<Item = usize>) -> Vec<[f64; 3]> {
    let origin = scene.origin();
    let all = meshes.flat_map(|mesh| scene.meshes()[mesh].positions());
    all.map(|p| [0, 1, 2].map(|k| origin[k] + f64::from(p[k]))).collect()
}

#[test]
fn a_moving_scene_is_at_all_times_the_pose_of_its_animated_scene() {
    for (name, scene) in files() {
        let moving = MovingScene::animated(scene.clone(), Some(0)).unwrap();
        let mut moments = moving.moments();
        for time in [0.0, 0.4, 1.0, 1.0, 1.7, 2.0] {
            let (pose, moment) = (scene.pose(0, time).unwrap(), moving.at(time).unwrap());
            let kinds = scene.kinds_in(0);
            let is_still = |kind: &EntityKind| *kind == EntityKind::Static;
            let order = |still: bool| {
                let of = scene.entities().iter().zip(&kinds).filter(move |(_, kind)| is_still(kind) == still);
                of.flat_map(|(entity, _)| entity.meshes())
            };
            let expected = positions(pose.scene(), order(true).chain(order(false)));
            let found = positions(moment.scene(), 0..moment.scene().meshes().len());
            // They may count from different origins, whose sums are rounded.
            let same = |a: &[[f64; 3]], b: &[[f64; 3]]| {
                let near = |(a, b): (&f64, &f64)| (a - b).abs() <= 4.0 * f64::EPSILON * b.abs();
                a.len() == b.len() && a.as_flattened().iter().zip(b.as_flattened()).all(near)
            };
            assert!(same(&found, &expected), "{name} at {time}: {found:?}, expected {expected:?}");
            assert_eq!(moment.scene().triangle_count(), pose.scene().triangle_count(), "{name} at {time}: triangles");
            let vertices: usize = moving.parts().iter().map(|part| part.scene.vertex_count()).sum();
            assert_eq!(found.len(), vertices, "{name}: those of the parts");
            assert_eq!(moving.world_bounds(time).unwrap(), moment.scene().world_bounds(), "{name} at {time}: bounds");
            let again = moments.at(time).unwrap();
            assert_eq!(
                positions(again.scene(), 0..found.len().min(again.scene().meshes().len())),
                found,
                "{name}: again"
            );
            assert_eq!(again.bvh().bounds(), moment.bvh().bounds(), "{name} at {time}: the tree that was refit");
        }
    }
}

#[test]
fn parts_keep_their_shape_where_scales_are_even_though_they_vanish() {
    for (name, is_rigid) in [
        ("moved", true),
        ("below uneven scales", false),
        ("stretched", false),
        ("scaled to nothing", true),
        ("nothing at rest", true),
        ("with a weight that stands", true),
        ("morphed", false),
        ("a part far away", true),
    ] {
        let (_, scene) = files().into_iter().find(|(found, _)| *found == name).unwrap();
        let moving = MovingScene::animated(scene, Some(0)).unwrap();
        let part = moving.parts().iter().find(|part| !matches!(part.motion, Motion::Still)).unwrap();
        assert_eq!(matches!(part.motion, Motion::Node(_)), is_rigid, "{name}");
    }
}

/// Far away in a file, positions are rounded to `f32` before they are posed.
const ROUNDING: f64 = 1e-4;

#[test]
fn spheres_that_a_description_names_go_where_the_vertices_at_their_centers_go() {
    let node = json!([{"mesh": 0}]);
    let pop = [1.0, 1.0, 1.0, 1.0, 2.0, 0.5];
    for (name, file) in [
        ("with a skin", bending([0.0; 3])),
        ("with a skin far away", bending([50.0, 0.0, 8.0])),
        ("moved", File::new(node.clone(), [0.0; 3]).translated(0)),
        ("stretched", File::new(node.clone(), [0.0; 3]).moved(0, "scale", "VEC3", &pop)),
        ("morphed", File::new(node.clone(), [0.0; 3]).moved(0, "weights", "SCALAR", &[0.0, 1.0])),
        ("far away", File::new(node, [9e4, 0.0, 3e5]).translated(0)),
    ] {
        let (scene, folder) = (file.read(), tempfile::tempdir().unwrap());
        let entity = &scene.entities()[0];
        let own = scene.morphed_scene(entity, &scene.widest_weights(entity).unwrap()).unwrap();
        let corners: Vec<[f32; 3]> = own.meshes().iter().flat_map(|mesh| mesh.positions().to_vec()).collect();
        let set =
            SphereSet::new(corners.clone(), vec![1e-5; corners.len()]).unwrap().with_origin(own.origin()).unwrap();
        let set = set.bind_to(&scene, entity, &mut Job::default()).unwrap();
        write_spheres(folder.path().join("a.spheres.safetensors"), &set).unwrap();
        std::fs::write(folder.path().join("a.glb"), file.bytes()).unwrap();
        let keys = json!([{"translation": [1.0, 2.0, 3.0]}]);
        let moved =
            json!({"name": "a", "mesh": "a.glb", "animation": 0, "spheres": "a.spheres.safetensors", "keys": keys});
        let description = json!({"format": "lobe-scene", "version": 1, "entities": [moved]}).to_string();
        std::fs::write(folder.path().join("s.json"), description).unwrap();
        let (moving, _) = MovingScene::read(folder.path().join("s.json"), &SceneReadOptions::default()).unwrap();
        for time in [0.0, 0.3, 1.0] {
            let (moment, pose) = (moving.at(time).unwrap(), scene.pose(0, time).unwrap());
            let expected = positions(pose.scene(), entity.meshes());
            let found = moment.spheres(0);
            assert_eq!(found.len(), expected.len(), "{name}: a sphere for each corner");
            for (k, (found, expected)) in found.iter().zip(expected).enumerate() {
                let off = [0, 1, 2].map(|axis| (found.center[axis] - expected[axis] - (axis + 1) as f64).abs());
                assert!(off.iter().all(|off| *off < ROUNDING), "{name} at {time}: corner {k} is {off:?} off");
            }
        }
        let lacking = moving.lacking(MovingMethod::Exponentials, &MovingBakeOptions::default());
        assert!(lacking.iter().all(|bake| bake.kind != PartBakeKind::Spheres), "{name}: spheres are there");
    }
}

#[test]
fn spheres_follow_a_morph_target_that_stretches_their_part() {
    let file = File::new(json!([{"mesh": 0}]), [0.0; 3]).moved(0, "weights", "SCALAR", &[0.0, 1.0, 0.5]);
    let mut moving = MovingScene::animated(file.read(), Some(0)).unwrap();
    let options = MovingBakeOptions::default()
        .spheres(SphereFitOptions::default().samples(600).rounds(6))
        .deformed_spheres(Some(12));
    moving.bake(MovingMethod::Exponentials, &options, Job::default()).unwrap();
    let set = moving.parts()[0].spheres.clone().unwrap();
    let (folder, entity) = (tempfile::tempdir().unwrap(), moving.parts()[0].name.clone());
    let path = folder.path().join("s.safetensors");
    write_spheres(&path, &set).unwrap();
    assert_eq!(read_spheres(&path).unwrap(), *set, "files keep how spheres of {entity} follow");
    for time in [0.0, 0.25, 0.5, 1.0, 1.5] {
        let moment = moving.at(time).unwrap();
        let [low, high] = moment.scene().world_bounds();
        let bound = |sign: f64| {
            let ends = moment.spheres(0).iter().map(|s| sign * s.center[2] + s.radius);
            sign * ends.fold(f64::NEG_INFINITY, f64::max)
        };
        let off = [bound(-1.0) - low[2], bound(1.0) - high[2]];
        // A sphere that is flattened keeps its volume's share, not its height.
        assert!(off.iter().all(|off| off.abs() < 0.2), "at {time}: from {low:?} to {high:?}, spheres are {off:?} off");
        let (centers, radii) = moment.spheres(0).iter().map(|s| (s.center.map(|c| c as f32), s.radius as f32)).unzip();
        let (volume, expected) = (SphereSet::new(centers, radii).unwrap().union_volume(), high[2] - low[2]);
        assert!((volume / expected - 1.0).abs() < 0.3, "at {time}: spheres fill {volume} of {expected}");
    }
}

const ORDER: usize = 3;

fn lit(moving: &mut MovingScene, method: MovingMethod, time: f64) -> Vec<Rgb<f32>> {
    let transfer = BakeOptions::default().mode(BakeMode::Shadowed).order(ORDER).samples(64);
    let field = FieldOptions::default().order(ORDER).spheres(6).cells(6).rays(128);
    let spheres = SphereFitOptions::default().count(6).samples(400).rounds(2);
    let options = MovingBakeOptions::default().transfer(transfer).field(field).spheres(spheres).deformed_spheres(None);
    moving.bake(method, &options, Job::default()).unwrap();
    let shading = MovingShading::new(MovingOptions::default().order(ORDER).method(method)).unwrap();
    let light = project_env(&bundled::sunset().map(), ORDER);
    shading.exit_radiance(&moving.at(time).unwrap(), &light).unwrap()
}

fn largest_difference(a: &[Rgb<f32>], b: &[Rgb<f32>]) -> f32 {
    assert_eq!(a.len(), b.len(), "as many vertices");
    let numbers = |of: &[Rgb<f32>]| of.iter().flat_map(|c| c.to_array()).collect::<Vec<_>>();
    numbers(a).iter().zip(numbers(b)).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

#[test]
fn spheres_of_a_skin_bound_far_from_its_origin_hide_what_they_hide_near_it() {
    for method in [MovingMethod::Fields, MovingMethod::Exponentials] {
        let [near, far] = [[0.0; 3], [50.0, 0.0, 8.0]].map(|by| {
            let mut moving = MovingScene::animated(bending(by).read(), Some(0)).unwrap();
            lit(&mut moving, method, 0.6)
        });
        let (mean, off) = (near.iter().map(|c| c.g).sum::<f32>() / near.len() as f32, largest_difference(&near, &far));
        // Positions are rounded to f32 at 50.
        assert!(mean > 0.01 && off < 0.02 * mean, "{method:?}: {off} of {mean}");
    }
}

#[test]
fn what_is_scaled_to_nothing_hides_nothing() {
    // The second box stands still below; the first one is gone at 1 s, and on it, or above it, before.
    let falling = || {
        let nodes = json!([{"mesh": 0}, {"mesh": 0, "translation": [0.0, -1.2, 0.0]}]);
        File::new(nodes, [0.0; 3]).moved(0, "scale", "VEC3", &[1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0]).read()
    };
    for method in [MovingMethod::Fields, MovingMethod::Exponentials] {
        let mut moving = MovingScene::animated(falling(), Some(0)).unwrap();
        let below = moving.parts()[0].scene.vertex_count();
        let [there, gone] = [0.0, 1.0].map(|time| lit(&mut moving, method, time)[..below].to_vec());
        let alone = falling();
        let still = alone.rest_pose().unwrap().scene().part([1]).unwrap();
        let mut alone = MovingScene::new(vec![lobe_motion::MovingPart::new("still", still, Motion::Still)]).unwrap();
        let alone = lit(&mut alone, method, 0.0);
        let mean = alone.iter().map(|c| c.g).sum::<f32>() / alone.len() as f32;
        assert!(largest_difference(&gone, &alone) < 1e-4 * mean, "{method:?}: gone, {gone:?}, alone {alone:?}");
        assert!(largest_difference(&there, &alone) > 0.05 * mean, "{method:?}: it hides the sky before");
    }
}

#[test]
fn what_is_scaled_to_nothing_is_lit_past_spheres_far_away() {
    // In the frame of the first box at 1 s, which has the scale 1e-12, the second one is farther than 1e15.
    let nodes = json!([{"mesh": 0}, {"mesh": 0, "translation": [3000.0, 0.0, 0.0]}]);
    let file = File::new(nodes, [0.0; 3])
        .moved(0, "scale", "VEC3", &[1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0])
        .moved(1, "translation", "VEC3", &[3000.0, 0.0, 0.0, 3000.0, 1.0, 0.0]);
    let mut moving = MovingScene::animated(file.read(), Some(0)).unwrap();
    let [there, gone] = [0.0, 1.0].map(|time| lit(&mut moving, MovingMethod::Exponentials, time));
    let mean = there.iter().map(|c| c.g).sum::<f32>() / there.len() as f32;
    assert!(gone.iter().all(|c| c.g.is_finite()), "{gone:?}");
    assert!(largest_difference(&there, &gone) < 1e-2 * mean, "it turns nowhere: {there:?} and {gone:?}");
}

/// Two boxes that stand, `apart` from each other, the first one the node `first`, and one that moves far away.
fn standing_boxes(first: &Value, apart: f32) -> AnimatedScene {
    let second = json!({"mesh": 0, "translation": [apart, 0.0, 0.0]});
    File::new(json!([first, second, {"mesh": 0, "translation": [900.0, 0.0, 0.0]}]), [0.0; 3])
        .moved(2, "translation", "VEC3", &[900.0, 0.0, 0.0, 900.0, 1.0, 0.0])
        .read()
}

#[test]
fn transfer_is_kept_where_the_shape_is_the_one_that_was_baked() {
    let options = BakeOptions::default().mode(BakeMode::Shadowed).order(ORDER).samples(256);
    let baked = |scene: &Scene| bake_vertices(scene, &Bvh::new(scene), &options, Job::default()).unwrap().0;
    let plain = json!({"mesh": 0});
    let lifted = json!({"mesh": 0, "weights": [1.0]});
    // The vertices that keep it, and those that have another shape. Of a box beside the lifted one those keep it that look away.
    for (name, first, apart, kept, reshaped) in [
        ("as it was baked", &plain, 1.3, 16, 0),
        ("lifted", &lifted, 300.0, 8, 8),
        ("lifted near the other", &lifted, 1.3, 4, 8),
    ] {
        let animated = standing_boxes(first, apart);
        let transfer = baked(animated.rest());
        let mut moving = MovingScene::animated(animated, Some(0)).unwrap();
        let found = moving.keep_transfer(&transfer, &options, &ScenePose::Unposed).unwrap();
        assert_eq!((found.kept, found.still, found.reshaped), (kept, 16, reshaped), "{name}");
        // Whatever is kept, the part is lit as one that was baked in the shape it stands in.
        let expected = baked(&moving.parts()[0].scene);
        let lacking = MovingBakeOptions::default().transfer(options.clone());
        moving.bake(MovingMethod::Fields, &lacking, Job::default()).unwrap();
        let transfer = moving.parts()[0].transfer.clone().unwrap();
        let off =
            transfer.coefficients().iter().zip(expected.coefficients()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        // Rays of one vertex in several scenes differ: 256 of them are right to a few percent.
        assert!(off < 0.03, "{name}: off by {off}");
    }
}
