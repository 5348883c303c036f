//! Files whose transfer has no albedo.

use lobe::io::Job;
use lobe::prt::{AlbedoMode, BakeOptions, BakedGlb, Receivers, Recipe, Transfer, bake};
use lobe::scene::{Bvh, built_in};
use lobe_viewer::open_scene;

#[test]
fn a_file_without_albedo_is_shown_with_that_of_its_vertices() {
    let scene = built_in::cornell_box(8);
    let (bvh, receivers) = (Bvh::new(&scene), Receivers::at_vertices(&scene).unwrap());
    let folder = tempfile::tempdir().unwrap();
    let opened = |albedo| -> Transfer {
        let options = BakeOptions::default().order(3).samples(64).bounces(1).albedo(albedo);
        let (transfer, report) = bake(&scene, &bvh, &receivers, &options, Job::default()).unwrap();
        let path = folder.path().join("baked.glb");
        let recipe = Recipe::of_bake(&scene, &options, &report);
        BakedGlb::of_scene(&scene).write(&path, &transfer, &recipe, Job::default()).unwrap();
        open_scene(&path).unwrap().baked.expect("it is baked").transfer
    };
    let (with, without) = (opened(AlbedoMode::Vertex), opened(AlbedoMode::None));
    assert_eq!((with.receivers(), with.order()), (without.receivers(), without.order()), "vertices and bands");
    for vertex in 0..with.receivers() {
        for channel in 0..3 {
            let pairs = with.vector(vertex, channel).iter().zip(without.vector(vertex, channel));
            let off = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            // Colors are stored in single precision, and vertices come back in the order of the file.
            assert!(off < 1e-6, "vertex {vertex}, channel {channel}: {off}");
        }
    }
}
