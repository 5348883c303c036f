//! Sphere sets bound to entities of animated scenes, and their files.

use std::ops::ControlFlow;

use lobe_io::Job;
use lobe_scene::{AnimatedScene, Entity, built_in};
use lobe_shadow::{ShadowError, Skeleton, Skin, SphereSet, WorldSphere, read_spheres, write_spheres};
use lobe_testkit::Random;

/// Times of the walk, before its first key and after its last too.
const TIMES: [f64; 5] = [-1.0, 0.0, 0.137, 0.7, 5.0];

fn figure(scene: &AnimatedScene) -> &Entity {
    scene.entity("figure").unwrap()
}

/// Some spheres about where the figure is bound.
fn spheres(random: &mut Random) -> SphereSet {
    let count = (24.0 * random.unit()) as usize;
    let center =
        |random: &mut Random| [0.3 * random.signed(), 0.3 * random.signed(), 1.7 * random.unit()].map(|c| c as f32);
    let centers = (0..count).map(|_| center(random)).collect();
    SphereSet::new(centers, (0..count).map(|_| 0.2 * random.unit() as f32).collect()).unwrap()
}

fn through_a_file(set: &SphereSet) -> SphereSet {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("s.spheres.safetensors");
    write_spheres(&path, set).unwrap();
    read_spheres(&path).unwrap()
}

fn posed(set: &SphereSet, scene: &AnimatedScene) -> Vec<Vec<WorldSphere>> {
    TIMES.map(|time| set.posed_with(&scene.pose(0, time).unwrap(), figure(scene)).unwrap()).to_vec()
}

fn bound(set: SphereSet, scene: &AnimatedScene) -> SphereSet {
    set.bind_to(scene, figure(scene), &mut Job::default()).unwrap()
}

#[test]
fn spheres_of_a_file_are_posed_bit_for_bit_as_those_that_were_bound() {
    let (scene, mut random) = (built_in::walking_figure(8), Random::new(15));
    for case in 0..24 {
        let set = bound(spheres(&mut random), &scene);
        let read = through_a_file(&set);
        assert_eq!(read, set, "case {case}: what was written is read");
        let followed = read.for_entity(&scene, figure(&scene)).unwrap();
        assert_eq!(posed(&followed, &scene), posed(&set, &scene), "case {case}");
    }
}

#[test]
fn spheres_stay_on_the_surface_that_moves() {
    let scene = built_in::walking_figure(8);
    let own = scene.own_scene(figure(&scene)).unwrap();
    // A point for each vertex, which then has the joints of that vertex.
    let positions: Vec<[f32; 3]> = own.meshes().iter().flat_map(|mesh| mesh.positions().to_vec()).collect();
    let points = SphereSet::new(positions.clone(), vec![0.0; positions.len()]).unwrap();
    let points = bound(points.with_origin(own.origin()).unwrap(), &scene);
    for time in TIMES {
        let pose = scene.pose(0, time).unwrap();
        let part = pose.scene().part(figure(&scene).meshes()).unwrap();
        let vertices = part.meshes().iter().flat_map(|mesh| mesh.positions().to_vec());
        for (k, (found, expected)) in points.posed_with(&pose, figure(&scene)).unwrap().iter().zip(vertices).enumerate()
        {
            let off = (0..3).map(|i| (found.center[i] - f64::from(expected[i])).powi(2)).sum::<f64>().sqrt();
            assert!(off < 1e-5, "{time} s: vertex {k} is {off} from its point");
        }
    }
}

#[test]
fn joints_are_found_by_name_in_whatever_order_they_are() {
    let (scene, mut random) = (built_in::walking_figure(8), Random::new(16));
    let set = bound(spheres(&mut random), &scene);
    let (skin, skeleton) = (set.skin().unwrap(), set.skeleton().unwrap());
    let names = skeleton.joints().to_vec();
    let last = names.len() as u16 - 1;
    let backwards: Vec<[u16; 4]> = skin.joints().iter().map(|four| four.map(|j| last - j)).collect();
    let other = Skeleton::new(Some("another name".to_owned()), 77, names.into_iter().rev().collect());
    let turned = SphereSet::new(set.centers().to_vec(), set.radii().to_vec()).unwrap();
    let turned = turned.with_skin(Skin::new(backwards, skin.weights().to_vec()).unwrap()).unwrap();
    let turned = through_a_file(&turned.with_skeleton(other).unwrap()).for_entity(&scene, figure(&scene)).unwrap();
    let joints = turned.skin().map(Skin::joints);
    // Joints of no weight may be any.
    let weighed = |joints: &[[u16; 4]]| -> Vec<u16> {
        let all = joints.as_flattened().iter().zip(skin.weights().as_flattened());
        all.filter(|(_, weight)| **weight > 0.0).map(|(joint, _)| *joint).collect()
    };
    assert_eq!(joints.map(weighed), Some(weighed(skin.joints())), "numbered as in the scene");
    assert_eq!(turned.skeleton(), set.skeleton(), "of the entity of the scene");
}

/// One sphere at the head, with these names of joints.
fn head(names: impl IntoIterator<Item = Option<String>>, joint: u16) -> SphereSet {
    let skin = Skin::new(vec![[joint, 0, 0, 0]], vec![[1.0, 0.0, 0.0, 0.0]]).unwrap();
    let set = SphereSet::new(vec![[0.0, 0.0, 1.6]], vec![0.1]).unwrap().with_skin(skin).unwrap();
    set.with_skeleton(Skeleton::new(Some("figure".to_owned()), 0, names.into_iter().collect())).unwrap()
}

#[test]
fn spheres_of_other_joints_are_refused_in_one_line() {
    let scene = built_in::walking_figure(8);
    let names = Skeleton::of(&scene, figure(&scene)).joints().to_vec();
    let refused = |set: SphereSet, entity: &str| match set.for_entity(&scene, scene.entity(entity).unwrap()) {
        Err(ShadowError::Options(message)) => message,
        other => panic!("expected a refusal, found {other:?}"),
    };
    let with = |name: Option<&str>| {
        let mut names = names.clone();
        names[3] = name.map(str::to_owned);
        names
    };
    let plain = SphereSet::new(vec![[0.0, 0.0, 1.6]], vec![0.1]).unwrap();
    for (set, expected) in [
        (
            plain,
            "expected spheres bound to the joints of `figure`, found spheres without joints; `lobe spheres --entity` binds them",
        ),
        (
            head(names[1..].to_vec(), 3),
            "expected spheres bound to the 16 joints of `figure`, found some bound to 15; fit them to this entity",
        ),
        (
            head(with(Some("no\nse")), 3),
            "found no joint `no se` in `figure`, which spheres are bound to; fit them to this entity",
        ),
        (
            head(with(Some("chest")), 3),
            "expected `head` as joint 3 of `figure`, found `chest`; fit spheres to this entity",
        ),
        (
            head(with(None), 3),
            "expected `head` as joint 3 of `figure`, found one without a name; fit spheres to this entity",
        ),
    ] {
        assert_eq!(refused(set, "figure"), expected, "");
    }
    let message = refused(head(names.clone(), 3), "ground");
    assert_eq!(message, "expected spheres without joints of `ground`, which has no skin, found some with joints", "");
    assert!(head(names.clone(), 3).for_entity(&scene, figure(&scene)).is_ok(), "what is as it should be");
    assert!(SphereSet::default().for_entity(&scene, figure(&scene)).is_ok(), "no spheres need no joints");
    let skin = Skin::new(vec![[17, 0, 0, 0]], vec![[1.0, 0.0, 0.0, 0.0]]).unwrap();
    let beyond = SphereSet::new(vec![[0.0; 3]], vec![0.1]).unwrap().with_skin(skin).unwrap();
    let message = beyond.with_skeleton(Skeleton::of(&scene, figure(&scene))).unwrap_err().to_string();
    assert_eq!(message, "expected joints of `figure`, which has 16, found number 17 at sphere 0", "");
}

#[test]
fn binding_can_be_stopped() {
    let scene = built_in::walking_figure(8);
    let set = SphereSet::new(vec![[0.0, 0.0, 1.6]], vec![0.1]).unwrap();
    let mut watch = |_: &lobe_io::Progress| ControlFlow::Break(());
    let stopped = set.bind_to(&scene, figure(&scene), &mut Job::default().watched_by(&mut watch));
    assert!(matches!(stopped, Err(ShadowError::Cancelled)), "{stopped:?}");
}
