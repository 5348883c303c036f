//! Baked .glb files with more than the transfer of fronts: the backs of double-sided surfaces, the direct part.

use std::fs;

use lobe_io::Job;
use lobe_prt::{
    BakedGlb, Channels, MoreTransfer, PrtError, Recipe, Transfer, TransferRows, double_sided_vertices, read_baked,
    read_baked_bytes,
};
use lobe_scene::{Material, Scene, SceneReadOptions, built_in};
use lobe_testkit::glb_faults;

/// A ground that is seen from both sides, and a ball that is not.
fn scene() -> Scene {
    let (meshes, materials, textures) = built_in::ball_over_ground(6).into_parts();
    let material = |(i, material): (usize, Material)| Material { double_sided: i == 0, ..material };
    Scene::new(meshes, materials.into_iter().enumerate().map(material).collect(), textures).unwrap()
}

/// Numbers that differ at every place, from `first` on.
fn numbered(receivers: usize, order: usize, channels: Channels, first: usize) -> Transfer {
    let count = receivers * order * order * channels.count();
    Transfer::new(order, channels, (first..first + count).map(|i| i as f32).collect()).unwrap()
}

#[test]
fn backs_are_read_as_they_were_written_at_the_vertices_that_are_double_sided() {
    let (folder, scene) = (tempfile::tempdir().unwrap(), scene());
    let path = folder.path().join("backs.glb");
    let ground = scene.meshes()[0].positions().len();
    assert_eq!(double_sided_vertices(&scene), (0..ground).collect::<Vec<_>>(), "those of the ground");
    for (order, channels) in [(1, Channels::Gray), (3, Channels::Rgb), (8, Channels::Rgb)] {
        let fronts = numbered(scene.vertex_count(), order, channels, 0);
        let backs = numbered(ground, order, channels, 1_000_000);
        let glb = BakedGlb::of_scene(&scene).with_backs(&scene);
        glb.write_with(
            &path,
            &fronts,
            MoreTransfer { backs: Some(&backs), ..MoreTransfer::default() },
            &Recipe::default(),
            Job::default(),
        )
        .unwrap();
        assert_eq!(glb_faults(&fs::read(&path).unwrap()), Vec::<String>::new(), "order {order}");
        let read = read_baked(&path, &SceneReadOptions::default()).unwrap();
        assert_eq!(read.transfer, fronts, "order {order}: fronts");
        let found = read.backs.unwrap();
        assert_eq!((found.vertices.len(), &found.transfer), (ground, &backs), "order {order}: backs");
        let length = fs::metadata(&path).unwrap().len();
        assert!(length > glb.size(order, channels), "order {order}: {length} bytes, of which backs are counted");
    }
}

#[test]
fn a_file_without_backs_has_none_and_other_numbers_of_them_are_refused() {
    let (folder, scene) = (tempfile::tempdir().unwrap(), scene());
    let path = folder.path().join("fronts.glb");
    let fronts = numbered(scene.vertex_count(), 2, Channels::Gray, 0);
    let glb = BakedGlb::of_scene(&scene);
    glb.write(&path, &fronts, &Recipe::default(), Job::default()).unwrap();
    let read = read_baked_bytes(&fs::read(&path).unwrap(), "f.glb", &SceneReadOptions::default()).unwrap();
    assert!(read.backs.is_none(), "no backs");
    let ground = scene.meshes()[0].positions().len();
    let glb = glb.with_backs(&scene);
    for (backs, part) in [
        (numbered(ground + 1, 2, Channels::Gray, 0), "backs, found that of"),
        (numbered(ground, 3, Channels::Gray, 0), "as many bands, and backs of as many channels"),
    ] {
        let error = glb
            .write_with(
                &path,
                &fronts,
                MoreTransfer { backs: Some(&backs), ..MoreTransfer::default() },
                &Recipe::default(),
                Job::default(),
            )
            .unwrap_err();
        assert!(matches!(&error, PrtError::Options(text) if text.contains(part)), "{error}");
    }
}

#[test]
fn the_direct_part_is_read_as_it_was_written_whatever_its_channels() {
    let (folder, scene) = (tempfile::tempdir().unwrap(), scene());
    let path = folder.path().join("parts.glb");
    let (count, ground) = (scene.vertex_count(), scene.meshes()[0].positions().len());
    for (channels, of_direct) in [(Channels::Rgb, Channels::Gray), (Channels::Rgb, Channels::Rgb)] {
        let whole = numbered(count, 3, channels, 0);
        let (backs, direct) = (numbered(ground, 3, channels, 100_000), numbered(count, 3, of_direct, 200_000));
        for has_backs in [false, true] {
            let glb = BakedGlb::of_scene(&scene).with_direct(of_direct);
            let glb = if has_backs { glb.with_backs(&scene) } else { glb };
            let more = MoreTransfer { backs: has_backs.then_some(&backs as &dyn TransferRows), direct: Some(&direct) };
            glb.write_with(&path, &whole, more, &Recipe::default(), Job::default()).unwrap();
            assert_eq!(glb_faults(&fs::read(&path).unwrap()), Vec::<String>::new(), "{of_direct:?}");
            let read = read_baked(&path, &SceneReadOptions::default()).unwrap();
            assert_eq!((read.transfer, read.direct), (whole.clone(), Some(direct.clone())), "{of_direct:?}");
            assert_eq!(read.backs.map(|backs| backs.transfer), has_backs.then(|| backs.clone()), "backs");
            assert!(fs::metadata(&path).unwrap().len() > glb.size(3, channels), "the direct part is counted");
        }
    }
}
