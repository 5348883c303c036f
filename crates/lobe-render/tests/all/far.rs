//! Scenes far from the origin of their world: as precise as near it, bit by bit.

use lobe_env::bundled;
use lobe_io::Job;
use lobe_prt::{
    AdaptiveOptions, BakeMode, BakeOptions, NeighborhoodGrid, Receivers, TexelReceivers, bake, bake_matrices,
    bake_neighborhood, split_adaptively,
};
use lobe_render::{Camera, DistantLight, PathOptions, SampleCount, Truth, TruthOptions, render_truth};
use lobe_scene::{
    Bvh, GltfDocument, Scene, SceneReadOptions, built_in, read_scene_bytes, y_up_from_z_up, z_up_from_y_up,
};
use serde_json::json;

/// A ball over a ground in a file whose nodes are turned and moved a little, and all of them by a node above.
fn ball_at(place: [f64; 3]) -> Scene {
    let mut document = GltfDocument::of_scene(&built_in::ball_over_ground(8));
    let nodes = document.json["nodes"].as_array_mut().unwrap();
    for node in nodes.iter_mut() {
        node["rotation"] = json!([0.0, 0.382_683_43, 0.0, 0.923_879_53]);
        node["translation"] = json!([0.1, 0.7, -0.3]);
    }
    let children: Vec<usize> = (0..nodes.len()).collect();
    nodes.push(json!({"children": children, "translation": y_up_from_z_up(place)}));
    document.json["scenes"] = json!([{"nodes": [children.len()]}]);
    let text = serde_json::to_vec(&document.json).unwrap();
    read_scene_bytes(&glb(text, document.bytes), "ball.glb", &SceneReadOptions::default()).unwrap().0
}

fn glb(mut json: Vec<u8>, mut bytes: Vec<u8>) -> Vec<u8> {
    json.resize(json.len().next_multiple_of(4), b' ');
    bytes.resize(bytes.len().next_multiple_of(4), 0);
    let chunk = |kind: &[u8; 4], data: &[u8]| [&(data.len() as u32).to_le_bytes()[..], kind, data].concat();
    let chunks = [chunk(b"JSON", &json), chunk(b"BIN\0", &bytes)].concat();
    [b"glTF".as_slice(), &2_u32.to_le_bytes(), &(chunks.len() as u32 + 12).to_le_bytes(), &chunks].concat()
}

fn truth(scene: &Scene, place: [f64; 3]) -> Truth {
    let at = |p: [f64; 3]| [0, 1, 2].map(|k| place[k] + p[k]);
    let camera = Camera::look_at(at([6.0, -4.0, 4.0]), at([0.0, 0.0, 1.0]), 0.5).unwrap();
    let options = TruthOptions::default()
        .width(16)
        .height(12)
        .count(SampleCount::of(16))
        .paths(PathOptions::default().bounces(1));
    let light = DistantLight::from_map(bundled::studio().map());
    render_truth(scene, &Bvh::new(scene), &camera, &light, &options, Job::default()).unwrap()
}

#[test]
fn a_scene_has_the_same_light_wherever_a_node_puts_it() {
    let options = BakeOptions::default().mode(BakeMode::Interreflected).order(2).samples(32);
    let here = ball_at([0.0; 3]);
    let transfer = |scene: &Scene, receivers: &Receivers| {
        bake(scene, &Bvh::new(scene), receivers, &options, Job::default()).unwrap().0
    };
    let expected = transfer(&here, &Receivers::at_vertices(&here).unwrap());
    let picture = truth(&here, [0.0; 3]);
    for distance in [1e5, 1e6, 1e7] {
        for place in [[distance, 0.0, 0.0], [-distance, distance, 3.0 * distance]] {
            let there = ball_at(place);
            assert_eq!(there.triangle_count(), here.triangle_count(), "triangles at {place:?}");
            assert_eq!(there.origin(), place, "the origin");
            assert_eq!(there.bounds(), here.bounds(), "bounds at {place:?}");
            let receivers = Receivers::at_vertices(&there).unwrap();
            assert!(transfer(&there, &receivers) == expected, "transfer at {place:?}");
            assert!(truth(&there, place) == picture, "truth at {place:?}");
        }
    }
}

#[test]
fn texels_matrices_grids_and_splits_do_not_depend_on_the_place_either() {
    let options = BakeOptions::default().mode(BakeMode::Interreflected).order(2).samples(16);
    let place = [1e6, -1e7, 1e5];
    let [here, there] = [[0.0; 3], place].map(ball_at);
    let matrices = |scene: &Scene| {
        let receivers = Receivers::at_vertices(scene).unwrap();
        bake_matrices(scene, &Bvh::new(scene), &receivers, &options, Job::default()).unwrap().0
    };
    assert!(matrices(&here) == matrices(&there), "matrices");
    let around = |scene: &Scene, place: [f64; 3]| {
        let at = |p: [f64; 3]| [0, 1, 2].map(|k| place[k] + p[k]);
        let grid = NeighborhoodGrid::between(at([-1.0, -1.0, 0.5]), at([1.0, 1.0, 2.5]), [2, 2, 2]).unwrap();
        bake_neighborhood(scene, &Bvh::new(scene), &grid, &options, Job::default()).unwrap().0.matrices().clone()
    };
    assert!(around(&here, [0.0; 3]) == around(&there, place), "a grid");
    let splitting = AdaptiveOptions::default().max_vertices(Some(400)).bake(options.clone());
    let split = |scene: &Scene| split_adaptively(scene, &Bvh::new(scene), &splitting, Job::default()).unwrap().0;
    let [near, far] = [split(&here), split(&there)];
    assert!(near.meshes() == far.meshes(), "splits");
    assert_eq!(far.origin(), place, "a split scene stays at its place");
    let boxes = [[0.0; 3], place].map(|by| built_in::cornell_box(8).moved(by));
    let texels = boxes.map(|scene| TexelReceivers::new(&scene, 32).unwrap());
    assert!(texels[0] == texels[1], "texels");
}

#[test]
fn a_scene_that_is_written_far_away_is_read_there() {
    let place = [1e7, 0.0, -1e6];
    let there = ball_at(place);
    let document = GltfDocument::of_scene(&there);
    let text = serde_json::to_vec(&document.json).unwrap();
    let again = read_scene_bytes(&glb(text, document.bytes), "again.glb", &SceneReadOptions::default()).unwrap().0;
    assert_eq!((again.origin(), again.bounds()), (place, there.bounds()), "origin and bounds");
    for (a, b) in there.meshes().iter().zip(again.meshes()) {
        assert!(a.positions() == b.positions(), "positions of {}", a.name());
    }
    assert_eq!(z_up_from_y_up(y_up_from_z_up(place)), place, "axes of f64 turn as those of f32");
}
