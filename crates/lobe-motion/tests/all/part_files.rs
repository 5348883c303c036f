//! Fields and spheres in files that name no part.

use std::path::Path;

use lobe_io::Job;
use lobe_motion::{Motion, MovingPart, MovingScene};
use lobe_render::RenderError;
use lobe_scene::{AnimatedScene, Entity, Scene, built_in};
use lobe_sh::Rotation;
use lobe_shadow::{
    FieldOptions, FieldStorage, Key, Placement, SphereFitOptions, SphereSet, Track, bake_field, fit_spheres,
    write_field, write_spheres,
};

fn field_of(scene: &Scene, path: &Path) {
    let options = FieldOptions::default().order(2).spheres(4).cells(4).rays(16);
    write_field(path, &bake_field(scene, &options, Job::default()).unwrap().0, &FieldStorage::F32).unwrap();
}

fn spheres_of(scene: &Scene) -> SphereSet {
    fit_spheres(scene, &SphereFitOptions::default().count(6).samples(300).rounds(2), Job::default()).unwrap().0
}

fn three_objects() -> MovingScene {
    MovingScene::animated(built_in::three_objects(8), Some(0)).unwrap()
}

/// A part that stands at the origin of its track.
fn part(name: &str, scene: Scene) -> MovingPart {
    let track =
        Track::new(vec![Key { time: 0.0, placement: Placement::new([0.0; 3], Rotation::IDENTITY, 1.0) }]).unwrap();
    MovingPart::new(name, scene, Motion::Track(track))
}

fn refused(result: Result<usize, RenderError>) -> String {
    let error = result.unwrap_err();
    assert!(matches!(error, RenderError::Invalid { .. }), "{error:?}");
    assert_eq!(error.to_string().lines().count(), 1, "one line: {error}");
    error.to_string()
}

#[test]
fn a_file_goes_to_the_part_that_it_was_made_of() {
    let folder = tempfile::tempdir().unwrap();
    let mut moving = three_objects();
    for number in 0..moving.parts().len() {
        let part = moving.parts()[number].clone();
        let [field, spheres] = ["field", "spheres"].map(|kind| folder.path().join(format!("{number}.{kind}")));
        field_of(&part.scene, &field);
        assert_eq!(moving.set_field_from(&field).unwrap(), number, "the field of {}", part.name);
        assert!(moving.parts()[number].field.is_some(), "{} has it", part.name);
        // Few spheres of the cube are as large as the ball, and about the same middle.
        if part.name != "ring" {
            continue;
        }
        write_spheres(&spheres, &spheres_of(&part.scene)).unwrap();
        assert_eq!(moving.set_spheres_from(&spheres).unwrap(), number, "the spheres of {}", part.name);
        assert!(moving.parts()[number].spheres.is_some(), "{} has them", part.name);
    }
}

#[test]
fn a_file_of_nothing_here_or_of_twins_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let [field, spheres] = ["a.field", "a.spheres"].map(|name| folder.path().join(name));
    // The ball over the ground stands higher than everything about the origin of its own.
    let ball = built_in::ball_over_ground(12).part([1]).unwrap();
    field_of(&ball, &field);
    write_spheres(&spheres, &SphereSet::new(vec![[90.0, 0.0, 0.0]], vec![1.0]).unwrap()).unwrap();
    let mut moving = three_objects();
    for (line, file) in
        [(refused(moving.set_field_from(&field)), &field), (refused(moving.set_spheres_from(&spheres)), &spheres)]
    {
        assert!(line.starts_with(&file.display().to_string()) && line.contains("open the scene"), "{line}");
    }
    write_spheres(&spheres, &spheres_of(&ball)).unwrap();
    let mut twins = MovingScene::new(vec![part("left", ball.clone()), part("right", ball.clone())]).unwrap();
    for line in [refused(twins.set_field_from(&field)), refused(twins.set_spheres_from(&spheres))] {
        assert!(line.contains("`left`") && line.contains("`right`"), "{line}");
    }
    let mut one = MovingScene::new(vec![part("left", ball.clone()), part("small", ball_of(&ball, 0.5))]).unwrap();
    assert_eq!(one.set_field_from(&field).unwrap(), 0, "the other has another size");
    assert_eq!(one.set_spheres_from(&spheres).unwrap(), 0, "the other has another size");
}

/// The same triangles about the same middle at another size.
fn ball_of(scene: &Scene, size: f32) -> Scene {
    let [min, max] = scene.world_bounds();
    let middle = [0, 1, 2].map(|k| (0.5 * (min[k] + max[k])) as f32);
    let meshes = scene.meshes().iter().map(|mesh| {
        let positions = mesh.positions().iter().map(|p| [0, 1, 2].map(|k| middle[k] + size * (p[k] - middle[k])));
        lobe_scene::Mesh::new(lobe_scene::MeshParts {
            positions: positions.collect(),
            triangles: mesh.triangles().to_vec(),
            ..Default::default()
        })
        .unwrap()
    });
    Scene::new(meshes.collect(), Vec::new(), Vec::new()).unwrap()
}

#[test]
fn spheres_with_joints_go_to_the_entity_that_they_name_and_to_no_rigid_part() {
    let (folder, figure) = (tempfile::tempdir().unwrap(), built_in::walking_figure(8));
    let path = folder.path().join("a.spheres");
    let skinned =
        |scene: &AnimatedScene| -> Entity { scene.entities().iter().find(|e| e.skin().is_some()).unwrap().clone() };
    let entity = skinned(&figure);
    let own = figure.own_scene(&entity).unwrap();
    let bound = spheres_of(&own).bind_to(&figure, &entity, &mut Job::default()).unwrap();
    write_spheres(&path, &bound).unwrap();
    let mut moving = MovingScene::animated(figure, Some(0)).unwrap();
    let number = moving.set_spheres_from(&path).unwrap();
    assert!(matches!(moving.parts()[number].motion, Motion::Deformed(_)), "the figure");
    let line = refused(three_objects().set_spheres_from(&path));
    assert!(line.contains("does not move here") && line.contains("expected one of"), "{line}");
    let mut rigid = MovingScene::new(vec![part("figure", own)]).unwrap();
    let line = refused(rigid.set_spheres_from(&path));
    assert!(line.contains("does not move here"), "{line}");
}
