//! Occlusion, reflection and shared bakes of the parts of a moving scene: against bakes of the whole, and what the bakes themselves promise.

use std::ops::ControlFlow;

use lobe_env::{bundled, project_env};
use lobe_io::{Job, Progress};
use lobe_motion::{
    Motion, MovingBakeOptions, MovingMethod, MovingOptions, MovingPart, MovingScene, MovingShading, MovingSplitOptions,
    PartBakeKind, VisibilityGridOptions, light_moving_scene,
};
use lobe_prt::{AdaptiveOptions, AlbedoMode, BakeMode, BakeOptions, Receivers, bake, bake_vertices};
use lobe_render::{Camera, View, ViewOptions};
use lobe_scene::{Bvh, Mesh, MeshParts, Scene, SceneReadOptions, built_in};
use lobe_sh::{Expansion as _, Rgb, Rotation, ShVec};
use lobe_shadow::{FieldOptions, Key, LogTable, LogTableOptions, Placement, SphereFitOptions, SphereSet, Track};

const ORDER: usize = 4;

fn sky() -> ShVec<Rgb<f64>> {
    project_env(&bundled::sunset().map(), ORDER)
}

fn options() -> MovingBakeOptions {
    let transfer = BakeOptions::default().mode(BakeMode::Shadowed).order(ORDER).samples(256);
    let field = FieldOptions::default().order(ORDER).spheres(6).cells(6).rays(128);
    let spheres = SphereFitOptions::default().count(4).samples(400).rounds(3);
    let visibility = VisibilityGridOptions::default().order(ORDER).points(216).rays(256);
    MovingBakeOptions::default()
        .transfer(transfer)
        .field(field)
        .spheres(spheres)
        .deformed_spheres(None)
        .visibility(visibility)
}

fn shading(method: MovingMethod) -> MovingShading {
    MovingShading::new(MovingOptions::default().order(ORDER).method(method)).unwrap()
}

fn off(found: &[Rgb<f32>], expected: &[Rgb<f32>]) -> f64 {
    let numbers = |of: &[Rgb<f32>]| -> Vec<f64> { of.iter().flat_map(|c| c.to_array()).map(f64::from).collect() };
    let (found, expected) = (numbers(found), numbers(expected));
    let square: f64 = found.iter().zip(&expected).map(|(a, b)| (a - b).powi(2)).sum();
    (square / expected.iter().map(|b| b * b).sum::<f64>()).sqrt()
}

/// A ball of radius `scale` about the origin of its track, which begins at `from` and ends at `to`.
fn ball(from: [f64; 3], to: [f64; 3], scale: f64) -> MovingPart {
    let scene = built_in::ball_over_ground(16).part([1]).unwrap();
    let key = |time: f64, [x, y, z]: [f64; 3]| Key {
        time,
        placement: Placement::new([x, y, z - 1.5 * scale], Rotation::IDENTITY, scale),
    };
    MovingPart::new("ball", scene, Motion::Track(Track::new(vec![key(0.0, from), key(2.0, to)]).unwrap()))
}

/// The exit radiance of the last part at a time, by a bake of all triangles of the moment.
fn truth_of_last(moving: &MovingScene, time: f64) -> Vec<Rgb<f32>> {
    let moment = moving.at(time).unwrap();
    let receivers = Receivers::at_vertices(moment.scene()).unwrap();
    let last = moving.parts().last().unwrap().scene.vertex_count();
    let some: Vec<usize> = (receivers.len() - last..receivers.len()).collect();
    let receivers = receivers.subset(&some).unwrap();
    let options = options().transfer;
    let (transfer, _) = bake(moment.scene(), moment.bvh(), &receivers, &options, Job::default()).unwrap();
    transfer.exit_radiance(sky().coefficients())
}

#[test]
fn a_room_hides_the_sky_from_what_moves_in_it() {
    for (name, from, to, scale) in
        [("columns", [-1.0, 0.3, 0.8], [1.0, 0.3, 0.8], 0.3), ("cave", [-0.5, 0.0, 1.0], [0.5, 0.2, 1.2], 0.3)]
    {
        let room = built_in::named(name).unwrap();
        let mut moving =
            MovingScene::new(vec![MovingPart::new(name, room, Motion::Still), ball(from, to, scale)]).unwrap();
        moving.bake(MovingMethod::Fields, &options(), Job::default()).unwrap();
        let mut alone: Vec<MovingPart> = moving.parts().to_vec();
        alone[0].visibility = None;
        let alone = MovingScene::new(alone).unwrap();
        for time in [0.0, 1.1] {
            let expected = truth_of_last(&moving, time);
            let [with, without] = [&moving, &alone].map(|scene| {
                let lit = shading(MovingMethod::Fields).exit_radiance(&scene.at(time).unwrap(), &sky()).unwrap();
                off(&lit[lit.len() - expected.len()..], &expected)
            });
            println!("{name} at {time} s: {with:.3} of {without:.3} without the room");
            assert!(with < 0.35 * without, "{name} at {time} s: {with} with the room, {without} without");
        }
    }
}

#[test]
fn spheres_send_light_on_in_every_method() {
    for method in [MovingMethod::Fields, MovingMethod::Exponentials] {
        let mut moving = MovingScene::animated(built_in::walking_figure(8), Some(0)).unwrap();
        moving.bake(method, &options(), Job::default()).unwrap();
        let moment = moving.at(0.2).unwrap();
        let mean = |bounce: bool| {
            let options = MovingOptions::default().order(ORDER).method(method).bounce(bounce);
            let lit = MovingShading::new(options).unwrap().exit_radiance(&moment, &sky()).unwrap();
            // The figure alone: the ground is the first part.
            let figure = &lit[moving.parts()[0].scene.vertex_count()..];
            figure.iter().map(|c| f64::from(c.g)).sum::<f64>() / figure.len() as f64
        };
        let (with, without) = (mean(true), mean(false));
        assert!(with > 1.01 * without, "{method:?}: {with} with light from spheres, {without} without");
    }
}

/// A box without its lid, open towards +z, seen from inside and outside.
fn open_box() -> Scene {
    let positions = (0..8).map(|c| [c & 1, c >> 1 & 1, c >> 2].map(|up| f32::from(up as u8) - 0.5)).collect();
    let faces = [[0, 1, 5, 4], [1, 3, 7, 5], [3, 2, 6, 7], [2, 0, 4, 6], [0, 2, 3, 1]];
    let triangles = faces.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    let mesh = Mesh::new(MeshParts { positions, triangles, ..MeshParts::default() }).unwrap();
    Scene::new(vec![mesh], Vec::new(), Vec::new()).unwrap().split_edges(0.3).unwrap()
}

#[test]
fn backs_that_are_baked_are_lit_as_the_bake_of_backs() {
    let scene = open_box();
    let receivers = Receivers::back_of_vertices(&scene).unwrap();
    let transfer = options().transfer.albedo(AlbedoMode::Vertex);
    let (expected, _) = bake(&scene, &Bvh::new(&scene), &receivers, &transfer, Job::default()).unwrap();
    let expected = expected.exit_radiance(sky().coefficients());
    let count = scene.vertex_count();
    let mut moving = MovingScene::new(vec![MovingPart::new("box", scene, Motion::Still)]).unwrap();
    let backs = |moving: &MovingScene| {
        shading(MovingMethod::Fields).exit_radiance_of_backs(&moving.at(0.0).unwrap(), &sky()).unwrap()
    };
    moving.bake(MovingMethod::Fields, &options(), Job::default()).unwrap();
    let before = off(&backs(&moving), &expected);
    // In two portions, as two views would show them.
    for seen in [(0..count / 3).collect::<Vec<_>>(), (0..count).collect()] {
        moving.bake_backs(&seen, &options().transfer, Job::default()).unwrap();
    }
    let after = off(&backs(&moving), &expected);
    assert!(after < 1e-5 && before > 0.1, "{after} off, {before} before the box hid the sky from its inside");
}

#[test]
fn backs_that_were_baked_with_other_options_are_baked_anew() {
    let scene = open_box();
    let all: Vec<usize> = (0..scene.vertex_count()).collect();
    let mut moving = MovingScene::new(vec![MovingPart::new("box", scene, Motion::Still)]).unwrap();
    moving.bake(MovingMethod::Fields, &options(), Job::default()).unwrap();
    let before = options().transfer;
    for (name, now) in [
        ("order", before.clone().order(2)),
        ("mode", before.clone().mode(BakeMode::Unshadowed)),
        ("number of samples", before.clone().samples(64)),
        ("seed", before.clone().seed(7)),
    ] {
        let shading = MovingOptions::default().order(now.order).method(MovingMethod::Fields);
        let shading = MovingShading::new(shading).unwrap();
        let lit = |bakes: &[(&[usize], &BakeOptions)]| {
            let mut moving = moving.clone();
            for (seen, options) in bakes {
                moving.bake_backs(seen, options, Job::default()).unwrap();
            }
            shading.exit_radiance_of_backs(&moving.at(0.0).unwrap(), &sky()).unwrap()
        };
        let (third, rest) = all.split_at(all.len() / 3);
        // Vertices that the second view does not show are left without a bake.
        for seen in [&all[..], rest] {
            let (found, expected) = (lit(&[(third, &before), (seen, &now)]), lit(&[(seen, &now)]));
            assert_eq!(found, expected, "another {name}, {} are seen", seen.len());
        }
    }
}

#[test]
fn the_albedo_of_pixels_is_that_of_vertices_where_it_is_even() {
    let camera = Camera::framing([-3.0, -3.0, 0.0], [3.0, 3.0, 3.0], View::three_quarter(), 0.35);
    let view = ViewOptions::default().width(40).height(30).rays(2);
    let pictures = [AlbedoMode::Vertex, AlbedoMode::None].map(|albedo| {
        let ground = built_in::ball_over_ground(12).part([0]).unwrap();
        let ball = ball([-1.0, 0.0, 1.3], [1.0, 0.0, 1.3], 0.8);
        let mut moving = MovingScene::new(vec![MovingPart::new("ground", ground, Motion::Still), ball]).unwrap();
        let mut options = options();
        options.transfer.albedo = albedo;
        moving.bake(MovingMethod::Fields, &options, Job::default()).unwrap();
        let moment = moving.at(0.7).unwrap();
        let shading = shading(MovingMethod::Fields);
        light_moving_scene(
            &moment,
            &shading,
            &sky().into(),
            &camera,
            &view,
            |_| Rgb::new(0.0, 0.0, 0.0),
            Job::default(),
        )
        .unwrap()
    });
    let [vertex, pixel] = pictures.map(|lit| lit.picture);
    let compared = lobe_image::compare(pixel.pixels(), vertex.pixels());
    assert!(compared.relative_rmse < 1e-3, "{compared:?}");
}

#[test]
fn parts_get_what_they_lack_once_for_each_shape() {
    let place = |x: f64| ([x, 0.0, 1.0], [x, 1.0, 1.0]);
    let some = |x: f64| ball(place(x).0, place(x).1, 0.5);
    let mut with_spheres = some(6.0);
    with_spheres.spheres = Some(SphereSet::new(vec![[0.0, 0.0, 1.5]], vec![1.0]).unwrap().into());
    let sheet = built_in::ball_over_ground(4).part([0]).unwrap();
    let sheet = MovingPart::new("sheet", sheet, some(9.0).motion);
    let ground = MovingPart::new("ground", built_in::named("terrain").unwrap(), Motion::Still);
    let mut moving = MovingScene::new(vec![ground, some(0.0), some(3.0), with_spheres, sheet]).unwrap();
    let bakes = |moving: &MovingScene, method: MovingMethod| -> Vec<(PartBakeKind, Vec<usize>)> {
        moving.lacking(method, &options()).into_iter().map(|bake| (bake.kind, bake.parts)).collect()
    };
    use PartBakeKind::{Field, Spheres, Transfer, Visibility};
    let transfers = [(Transfer, vec![0]), (Visibility, vec![0]), (Transfer, vec![1, 2, 3])];
    let fields = [transfers.to_vec(), vec![(Field, vec![1, 2]), (Transfer, vec![4]), (Field, vec![4])]].concat();
    assert_eq!(bakes(&moving, MovingMethod::Fields), fields, "spheres that are there hide the sky by fields, too");
    let spheres = [transfers.to_vec(), vec![(Spheres, vec![1, 2]), (Transfer, vec![4]), (Field, vec![4])]].concat();
    assert_eq!(bakes(&moving, MovingMethod::Exponentials), spheres, "a sheet has no volume for spheres");
    moving.bake(MovingMethod::Fields, &options(), Job::default()).unwrap();
    assert_eq!(bakes(&moving, MovingMethod::Fields), [], "nothing is left");
    assert_eq!(moving.hides_nothing(MovingMethod::Fields).count(), 0, "all hide something");
    assert_eq!(moving.order(), Some(ORDER), "the bands of all");
    let refusal = moving.expect_order(ORDER + 1).unwrap_err().to_string();
    assert!(refusal.starts_with("`ground`: expected its transfer to have 5 bands at least, found 4"), "{refusal}");
}

/// A ground of two triangles, of side `2 half`.
fn sheet(half: f32) -> Scene {
    let positions =
        [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, y]| [half * x, half * y, 0.0]).to_vec();
    let parts = MeshParts { positions, triangles: vec![[0, 1, 2], [0, 2, 3]], ..MeshParts::default() };
    Scene::new(vec![Mesh::new(parts).unwrap()], Vec::new(), Vec::new()).unwrap()
}

/// What the ground sends back at vertices whose distance from a point is in a range.
fn ground_around(moving: &MovingScene, time: f64, middle: [f64; 2], range: std::ops::Range<f64>) -> Vec<f32> {
    let moment = moving.at(time).unwrap();
    let lit = shading(MovingMethod::Exponentials).exit_radiance(&moment, &sky()).unwrap();
    let positions = moment.scene().meshes()[0].positions();
    let distance = |p: &[f32; 3]| (f64::from(p[0]) - middle[0]).hypot(f64::from(p[1]) - middle[1]);
    positions.iter().zip(&lit).filter(|(p, _)| range.contains(&distance(p))).map(|(_, lit)| lit.g).collect()
}

#[test]
fn a_ground_of_two_triangles_gets_vertices_where_shadows_of_what_moves_fall() {
    let ground = || MovingPart::new("ground", sheet(4.0), Motion::Still);
    let ball = || ball([-1.0, 0.0, 0.3], [1.0, 0.0, 0.3], 0.3);
    let mut moving = MovingScene::new(vec![ground(), ball()]).unwrap();
    let adaptive = AdaptiveOptions::default().bake(options().transfer);
    let split = MovingSplitOptions::default().adaptive(adaptive.clone());
    let report = moving.split(&split, Job::default()).unwrap().still.unwrap();
    assert!(report.before == 4 && report.after <= AdaptiveOptions::LEAST_BUDGET, "{report:?}");
    let at = moving.at(0.0).unwrap().scene().vertex_count();
    assert_eq!(at, moving.parts().iter().map(|part| part.scene.vertex_count()).sum::<usize>(), "those of its parts");
    // On the path there is a vertex within a ball's radius of every place, and the corners are left coarse.
    let positions = moving.parts()[0].scene.meshes()[0].positions();
    let near = |x: f32, y: f32, by: f32| positions.iter().filter(|p| (p[0] - x).hypot(p[1] - y) < by).count();
    for x in [-1.0, -0.5, 0.0, 0.5, 1.0] {
        assert!(near(x, 0.0, 0.15) >= 4, "{} vertices around {x}", near(x, 0.0, 0.15));
    }
    assert!(near(3.8, 3.8, 0.15) <= 4, "{} vertices in a corner", near(3.8, 3.8, 0.15));
    // The shadow is under the ball, and moves with it.
    moving.bake(MovingMethod::Exponentials, &options(), Job::default()).unwrap();
    let mean = |of: Vec<f32>| of.iter().sum::<f32>() / of.len() as f32;
    for (time, x) in [(0.0, -1.0), (2.0, 1.0)] {
        let [under, far] = [0.0..0.1, 1.5..3.0].map(|range| mean(ground_around(&moving, time, [x, 0.0], range)));
        assert!(under < 0.5 * far, "at {time}: {under} under the ball, {far} around");
    }
    assert!(
        moving.split(&split, Job::default()).unwrap() == Default::default(),
        "what has its transfer stays as it is"
    );
    let mut few = MovingScene::new(vec![ground(), ball()]).unwrap();
    let all = few.parts().iter().map(|part| part.scene.vertex_count()).sum::<usize>();
    let split = MovingSplitOptions::default().adaptive(adaptive.max_vertices(Some(all + 100)));
    let report = few.split(&split, Job::default()).unwrap().still.unwrap();
    assert!(report.after <= 104 && report.edge > 1.0 / 16.0, "no more than are allowed: {report:?}");
}

#[test]
fn a_coarse_body_that_moves_is_split_to_a_quarter_of_its_size() {
    let motion = ball([0.0; 3], [1.0; 3], 1.0).motion;
    let mut moving = MovingScene::new(vec![MovingPart::new("box", built_in::closed_white_box(1), motion)]).unwrap();
    let before = moving.parts()[0].scene.clone();
    let report = moving.split(&MovingSplitOptions::default(), Job::default()).unwrap().moving.unwrap();
    let after = &moving.parts()[0].scene;
    assert_eq!((report.before, report.after), (before.vertex_count(), after.vertex_count()), "{report:?}");
    let [min, max] = before.world_bounds();
    let size = 0.5 * (0..3).map(|k| (max[k] - min[k]).powi(2)).sum::<f64>().sqrt();
    let side = |a: [f32; 3], b: [f32; 3]| (0..3).map(|k| f64::from(a[k] - b[k]).powi(2)).sum::<f64>().sqrt();
    let longest =
        |scene: &Scene| scene.corners().flat_map(|[a, b, c]| [side(a, b), side(b, c), side(c, a)]).fold(0.0, f64::max);
    let (long, short) = (longest(&before), longest(after));
    assert!(long > size && short <= 0.25 * size * 1.0001, "edges of {long} became {short}, of size {size}");
}

#[test]
fn parts_of_an_animated_scene_are_split_and_their_surface_stays_as_it_is_in_all_poses() {
    let scene = built_in::walking_figure(8);
    let mut moving = MovingScene::animated(scene.clone(), Some(0)).unwrap();
    let counts =
        |moving: &MovingScene| -> Vec<usize> { moving.parts().iter().map(|part| part.scene.vertex_count()).collect() };
    let before = counts(&moving);
    let adaptive = AdaptiveOptions::default().bake(options().transfer).max_vertices(Some(8000));
    let report = moving.split(&MovingSplitOptions::default().adaptive(adaptive), Job::default()).unwrap();
    let after = counts(&moving);
    assert!(
        after[0] > before[0] && after[1..] == before[1..],
        "{before:?} became {after:?}, the figure is fine enough"
    );
    assert!(after.iter().sum::<usize>() <= 8000, "no more than are allowed: {after:?}");
    let (still, figure) = (report.still.unwrap(), report.moving.unwrap());
    assert_eq!([still.after, figure.after], [after[0], after[1..].iter().sum()], "{report:?}");
    assert_eq!(figure.edge, 0.25, "{report:?}");
    for time in [0.0, 0.3] {
        let (moment, pose) = (moving.at(time).unwrap(), scene.pose(0, time).unwrap());
        let area = |scene: &Scene| -> f64 { scene.corners().map(|[a, b, c]| area_of(a, b, c)).sum() };
        let (found, expected) = (area(moment.scene()), area(pose.scene()));
        assert!((found / expected - 1.0).abs() < 1e-5, "at {time}: {found} and {expected}");
        assert_eq!(moment.scene().world_bounds(), pose.scene().world_bounds(), "at {time}");
        assert_eq!(moment.scene().vertex_count(), after.iter().sum::<usize>(), "at {time}");
    }
}

fn area_of(a: [f32; 3], b: [f32; 3], c: [f32; 3]) -> f64 {
    let side = |p: [f32; 3]| -> [f64; 3] { [0, 1, 2].map(|k| f64::from(p[k]) - f64::from(a[k])) };
    let n = lobe_sh::sphere::vector::cross(side(b), side(c));
    0.5 * n.iter().map(|x| x * x).sum::<f64>().sqrt()
}

#[test]
fn the_transfer_of_a_part_is_fitted_to_all_of_its_triangles() {
    let mut moving = MovingScene::new(vec![ball([0.0; 3], [1.0; 3], 1.0)]).unwrap();
    moving.bake(MovingMethod::Exponentials, &options(), Job::default()).unwrap();
    let part = &moving.parts()[0];
    let (fitted, _) = bake_vertices(&part.scene, &Bvh::new(&part.scene), &options().transfer, Job::default()).unwrap();
    assert_eq!(part.transfer.as_deref(), Some(&fitted));
}

#[test]
fn a_bake_that_was_stopped_goes_on_to_the_same_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let scene = || {
        let ground = MovingPart::new("ground", built_in::ball_over_ground(8).part([0]).unwrap(), Motion::Still);
        MovingScene::new(vec![ground, ball([-1.0, 0.0, 1.3], [1.0, 0.0, 1.3], 0.8)]).unwrap()
    };
    let lit =
        |moving: &MovingScene| shading(MovingMethod::Fields).exit_radiance(&moving.at(0.5).unwrap(), &sky()).unwrap();
    let mut whole = scene();
    whole.bake(MovingMethod::Fields, &options(), Job::default()).unwrap();
    let mut reports = 0;
    let mut stop = |_: &Progress| {
        reports += 1;
        if reports > 6 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let path = folder.path().join("bakes");
    let mut moving = scene();
    let stopped = moving.bake(MovingMethod::Fields, &options(), Job::default().watched_by(&mut stop).kept_in(&path));
    assert!(stopped.is_err(), "the watch said to stop");
    let mut resumed = 0;
    let mut watch = |progress: &Progress| {
        resumed = resumed.max(progress.resumed);
        ControlFlow::Continue(())
    };
    let mut moving = scene();
    moving.bake(MovingMethod::Fields, &options(), Job::default().watched_by(&mut watch).kept_in(&path)).unwrap();
    assert!(resumed > 0, "what was done was taken up");
    assert_eq!(lit(&moving), lit(&whole), "the same numbers as without a stop");
}

#[test]
fn a_scene_that_is_looped_begins_anew_at_its_end() {
    let moving = MovingScene::new(vec![ball([0.0, 0.0, 1.0], [4.0, 0.0, 1.0], 1.0)]).unwrap();
    let middle = |moving: &MovingScene, time: f64| {
        let [min, max] = moving.world_bounds(time).unwrap();
        let of_moment = moving.at(time).unwrap().scene().world_bounds();
        assert!((min[0] - of_moment[0][0]).abs() < 1e-5, "{min:?} against {of_moment:?} at {time} s");
        0.5 * (min[0] + max[0])
    };
    let at = [-0.5, 0.5, 1.9, 2.5, 4.5];
    let rests = at.map(|time| middle(&moving, time));
    let looped = moving.clone().looped(true);
    let begins = at.map(|time| middle(&looped, time));
    for (found, expected) in [(rests, [0.0, 1.0, 3.8, 4.0, 4.0]), (begins, [3.0, 1.0, 3.8, 1.0, 1.0])] {
        let off = found.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off < 1e-5, "{found:?}, expected {expected:?}");
    }
}

#[test]
fn a_table_of_another_order_is_refused() {
    let table = LogTable::new(&LogTableOptions::default().order(3)).unwrap();
    let error = MovingShading::with_table(MovingOptions::default().order(4), table).unwrap_err().to_string();
    assert_eq!(error, "expected a table of order 4, found 3", "said");
}

#[test]
fn an_animated_entity_is_carried_along_its_track_as_a_whole() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.json");
    let describe = |keys: &str| {
        let text = format!(
            r#"{{"format":"lobe-scene","version":1,"entities":[{{"name":"walker","mesh":"built-in:walking-figure","animation":"0",
                "keys":[{keys}]}}]}}"#
        );
        std::fs::write(&path, text).unwrap();
        MovingScene::read(&path, &SceneReadOptions::default()).unwrap().0
    };
    let whole = MovingScene::animated(built_in::moving("walking-figure").unwrap(), Some(0)).unwrap();
    let mut still = describe("{}");
    let mut carried =
        describe(r#"{"translation":[5,0,1],"rotation":[0,0,0.70710678118654752,0.70710678118654752],"scale":2}"#);
    assert_eq!(still.span(), whole.span(), "of the animation");
    let (vertices, time) = (whole.at(0.0).unwrap().scene().vertex_count(), 0.3);
    // What the place carries is where the map takes it, and turned against the sky.
    let place = |[x, y, z]: [f64; 3]| [5.0 - 2.0 * y, 2.0 * x, 1.0 + 2.0 * z];
    let positions = |moving: &MovingScene| -> Vec<[f64; 3]> {
        let moment = moving.at(time).unwrap();
        let origin = moment.scene().origin();
        let all = moment.scene().meshes().iter().flat_map(|mesh| mesh.positions().to_vec());
        all.map(|p| std::array::from_fn(|k| f64::from(p[k]) + origin[k])).collect()
    };
    assert_eq!(positions(&whole).len(), vertices, "all vertices");
    for (found, expected) in positions(&carried).iter().zip(positions(&still)) {
        let off = found.iter().zip(place(expected)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off < 1e-4, "{expected:?} went to {found:?}");
    }
    // A split leaves it where it is.
    let split = carried.clone().split(&MovingSplitOptions::default(), Job::default()).unwrap();
    assert!(split.still.is_none() && split.moving.unwrap().before > 0, "{split:?}");
    let turn = Rotation::from_axis_angle(lobe_sh::Dir::Z, 0.5 * std::f64::consts::PI);
    let lit = |moving: &mut MovingScene, light: &ShVec<Rgb<f64>>| {
        moving.bake(MovingMethod::Exponentials, &options(), Job::default()).unwrap();
        shading(MovingMethod::Exponentials).exit_radiance(&moving.at(time).unwrap(), light).unwrap()
    };
    let off = off(&lit(&mut carried, &sky().rotated(&turn)), &lit(&mut still, &sky()));
    assert!(off < 1e-3, "{off}");
}

/// Ground, vertices 0 to 3, and the front of a low wall behind it, vertices 4 to 7, which looks along +x.
fn ground_and_wall() -> Scene {
    let ground = [[0.0, -2.0, 0.0], [3.0, -2.0, 0.0], [3.0, 2.0, 0.0], [0.0, 2.0, 0.0]];
    let wall = [[0.0, -1.0, 0.0], [0.0, 1.0, 0.0], [0.0, 1.0, 0.4], [0.0, -1.0, 0.4]];
    let quad = |first: u32| [[first, first + 1, first + 2], [first, first + 2, first + 3]];
    let positions = [ground, wall].concat();
    let normals = [[[0.0, 0.0, 1.0]; 4], [[1.0, 0.0, 0.0]; 4]].concat();
    let triangles = [quad(0), quad(4)].concat();
    let mesh = Mesh::new(MeshParts { positions, triangles, normals, ..MeshParts::default() }).unwrap();
    Scene::new(vec![mesh], Vec::new(), Vec::new()).unwrap()
}

#[test]
fn what_is_behind_a_surface_hides_its_baked_reflections_by_fields_and_not_by_spheres() {
    // The ball is behind the wall, and hides from the ground before it some of the sky that the wall reflects.
    let bake_options = BakeOptions::default().mode(BakeMode::Interreflected).bounces(1).order(ORDER).samples(4096);
    let scene = || {
        MovingScene::new(vec![
            MovingPart::new("still", ground_and_wall(), Motion::Still),
            ball([-1.2, 0.0, 1.2], [-1.2, 0.0, 1.2], 1.0),
        ])
    };
    let light = sky();
    let of_wall = |radiance: &[Rgb<f32>]| f64::from(radiance[4..8].iter().map(|c| c.g).sum::<f32>() / 4.0);
    let shaded = |method: MovingMethod, hides: bool| {
        let mut moving = scene().unwrap();
        let options = options().transfer(bake_options.clone());
        moving.bake(method, &options, Job::default()).unwrap();
        let moving = if hides { moving } else { moving.without_occluders() };
        of_wall(&shading(method).exit_radiance(&moving.at(0.0).unwrap(), &light).unwrap())
    };
    let open = shaded(MovingMethod::Fields, false);
    let (fields, spheres) = (shaded(MovingMethod::Fields, true), shaded(MovingMethod::Exponentials, true));
    let moving = scene().unwrap();
    let moment = moving.at(0.0).unwrap();
    let (truth, _) = bake_vertices(moment.scene(), moment.bvh(), &bake_options, Job::default()).unwrap();
    let truth = of_wall(&truth.exit_radiance(light.coefficients()));
    println!("without the ball {open:.4}, fields {fields:.4}, spheres {spheres:.4}, a bake of all {truth:.4}");
    assert!((spheres - open).abs() < 1e-6 * open, "spheres: {spheres}, without the ball {open}");
    assert!(fields < truth && truth < open, "fields: {fields}, a bake of all {truth}, without the ball {open}");
    for (name, found) in [("fields", fields), ("spheres", spheres)] {
        // Paths of the truth pass other places than the receiver, at which both ask what is hidden: neither is right.
        assert!((found / truth - 1.0).abs() < 0.02, "{name}: {found}, a bake of all {truth}");
    }
}
