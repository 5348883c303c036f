//! Adaptive subdivision where transfer at vertices is off.

use std::ops::ControlFlow;

use lobe_io::{Job, JobFiles, Progress};
use lobe_prt::{AdaptiveOptions, AdaptiveReport, BakeMode, BakeOptions, PrtError, split_adaptively};
use lobe_scene::{Bvh, Mesh, MeshParts, Scene, built_in};

fn options(mode: BakeMode, error: f64, max_vertices: usize) -> AdaptiveOptions {
    let bake = BakeOptions::default().mode(mode).order(3).samples(64);
    AdaptiveOptions::default().error(error).max_vertices(Some(max_vertices)).bake(bake)
}

fn split(scene: &Scene, options: &AdaptiveOptions) -> (Scene, AdaptiveReport) {
    split_adaptively(scene, &Bvh::new(scene), options, Job::default()).unwrap()
}

/// A square floor of two triangles below a plate, which hangs low over its middle.
fn plate_over_floor() -> Scene {
    let square = |half: f32, z: f32| {
        let parts = MeshParts {
            positions: [[-half, -half], [half, -half], [half, half], [-half, half]].map(|[x, y]| [x, y, z]).to_vec(),
            normals: vec![[0.0, 0.0, 1.0]; 4],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..MeshParts::default()
        };
        Mesh::new(parts).unwrap()
    };
    Scene::new(vec![square(4.0, 0.0), square(1.0, 0.2)], vec![], vec![]).unwrap()
}

#[test]
fn nothing_is_split_where_transfer_is_linear() {
    // On a flat floor transfer without shadows is the same everywhere.
    let scene = plate_over_floor();
    let (found, report) = split(&scene, &options(BakeMode::Unshadowed, 0.001, 10_000));
    assert_eq!(found.vertex_count(), scene.vertex_count(), "{report:?}");
    assert!(report.error_bound <= 0.001 && report.rounds == 0, "{report:?}");
}

#[test]
fn nothing_is_split_where_nothing_is_in_the_way() {
    // Paths that leave at once are those of the closed form: estimates have no noise.
    let (meshes, ..) = plate_over_floor().into_parts();
    let scene = Scene::new(vec![meshes[0].clone()], vec![], vec![]).unwrap();
    for mode in [BakeMode::Shadowed, BakeMode::Interreflected] {
        let (found, report) = split(&scene, &options(mode, 0.001, 10_000));
        assert_eq!(found.vertex_count(), scene.vertex_count(), "{mode:?}: {report:?}");
    }
}

#[test]
fn the_estimate_is_the_error_of_linear_functions_in_closed_form() {
    // Only normals bend: along an edge of angle φ they, and with them bands 1, are off chords by about φ²/8.
    let coarse = built_in::ball_over_ground(8);
    let errors = [8, 16, 32].map(|cells| {
        let scene = built_in::ball_over_ground(cells);
        // All vertices are used up, so that the estimate is of the scene as it is.
        split(&scene, &options(BakeMode::Unshadowed, 1e-6, scene.vertex_count())).1.error
    });
    for pair in errors.windows(2) {
        // Half the edges, a quarter of the error.
        assert!((pair[0] / pair[1] - 4.0).abs() < 0.8, "{errors:?}");
    }
    let (fine, report) = split(&coarse, &options(BakeMode::Unshadowed, 0.01, 10_000));
    assert_eq!(fine.meshes()[0], coarse.meshes()[0], "the ground stays as it was");
    let [few, many] = [&coarse, &fine].map(|scene| scene.meshes()[1].positions());
    assert_eq!(&many[..few.len()], few, "the first vertices are the old ones");
    assert!(report.error_bound <= 0.01 && report.vertices < 2000, "{report:?}");
}

#[test]
fn vertices_are_spent_along_the_edge_of_a_shadow() {
    let scene = plate_over_floor();
    let (found, report) = split(&scene, &options(BakeMode::Shadowed, 1e-4, 600));
    assert!(report.vertices <= 600 && report.vertices > 400, "{report:?}");
    // The shadow ends near the square of side 2 in the middle of one of side 8.
    let floor = found.meshes()[0].positions();
    let near = floor.iter().filter(|p| (p[0].abs().max(p[1].abs()) - 1.0).abs() < 0.6).count() as f64;
    let area = (3.2_f64.powi(2) - 0.8_f64.powi(2)) / 64.0;
    let [near, far] = [near / area, (floor.len() as f64 - near) / (1.0 - area)];
    assert!(near > 2.0 * far, "{near} vertices near the edge for {far} elsewhere");
    let coarser = split(&scene, &options(BakeMode::Shadowed, 1e-4, 50)).1;
    assert!(matches!(coarser.worst, Some((0, part)) if part > 0.9), "the floor is off; {coarser:?}");
    assert!(report.error < 0.7 * coarser.error, "{} with 600 vertices, {} with 50", report.error, coarser.error);
}

#[test]
fn what_nobody_sees_is_not_split() {
    // A floor that goes on below a closed box: its edge is that of the shadow, and within it is dark.
    let (meshes, materials, _) = built_in::closed_white_box(1).into_parts();
    let outwards = |mesh: &Mesh| {
        let mut parts = mesh.clone().into_parts();
        parts.triangles.iter_mut().for_each(|t| t.swap(0, 1));
        parts.normals.iter_mut().for_each(|n| *n = n.map(|c| -c));
        Mesh::new(parts).unwrap()
    };
    let (floor, ..) = plate_over_floor().into_parts();
    let all: Vec<Mesh> = [floor[0].clone()].into_iter().chain(meshes.iter().map(outwards)).collect();
    let scene = Scene::new(all, materials, vec![]).unwrap();
    let bounds = scene.meshes()[1..].iter().flat_map(Mesh::positions);
    let [least, most] = [f32::min, f32::max]
        .map(|of: fn(f32, f32) -> f32| bounds.clone().fold([0.0_f32; 2], |b, p| [of(b[0], p[0]), of(b[1], p[1])]));
    let (found, report) = split(&scene, &options(BakeMode::Shadowed, 1e-4, 800));
    let is_inside = |p: &&[f32; 3]| (0..2).all(|k| p[k] > 0.8 * least[k] && p[k] < 0.8 * most[k]);
    let inside = found.meshes()[0].positions().iter().filter(is_inside).count();
    assert!(inside < report.vertices / 10, "{inside} of {} vertices are below the box", report.vertices);
}

#[test]
fn short_edges_are_left_and_their_part_of_the_error_is_told() {
    let scene = built_in::ball_over_ground(8);
    let options = options(BakeMode::Unshadowed, 1e-3, 100_000).min_edge(Some(0.4));
    let (fine, report) = split(&scene, &options);
    assert!(report.error > 1e-3 && report.too_short > 0.999, "the goal is not reached; {report:?}");
    let before = scene.meshes()[1].positions().len();
    assert!(fine.meshes()[1].positions().len() > before, "longer ones are split; {report:?}");
}

#[test]
fn each_round_tells_how_far_it_is_from_its_goal() {
    let scene = built_in::ball_over_ground(8);
    let options = options(BakeMode::Shadowed, 0.05, 2000);
    let mut told = Vec::new();
    let mut watch = |progress: &Progress| {
        told.push((progress.round, progress.error));
        ControlFlow::Continue(())
    };
    let job = Job::default().watched_by(&mut watch);
    let (_, report) = split_adaptively(&scene, &Bvh::new(&scene), &options, job).unwrap();
    told.dedup();
    let rounds: Vec<_> = told.iter().map(|(round, _)| *round).collect();
    assert_eq!(rounds, (0..=report.rounds).collect::<Vec<_>>(), "one error for each round: {told:?}");
    assert!(told[1..].iter().all(|(_, error)| *error > 0.05), "rounds go on while the goal is not reached: {told:?}");
}

#[test]
fn options_that_cannot_be_are_refused_and_progress_may_stop() {
    let scene = built_in::closed_white_box(1);
    let refusal = |options: &AdaptiveOptions| {
        split_adaptively(&scene, &Bvh::new(&scene), options, Job::default()).unwrap_err().to_string()
    };
    let options = options(BakeMode::Shadowed, 0.1, 1000);
    assert_eq!(refusal(&options.clone().error(0.0)), "expected an error above zero, found 0", "error");
    let negative = options.clone().min_edge(Some(-1.0));
    assert_eq!(refusal(&negative), "expected a shortest edge above zero, found -1", "edge");
    let other = Bvh::new(&built_in::ball_over_ground(4));
    let refused = split_adaptively(&scene, &other, &options, Job::default()).unwrap_err().to_string();
    assert!(refused.contains("expected the tree of the scene's"), "{refused}");
    let job = Job::default();
    let mut stop = |_: &Progress| ControlFlow::Break(());
    let stopped = split_adaptively(&scene, &Bvh::new(&scene), &options, job.watched_by(&mut stop)).unwrap_err();
    assert!(matches!(stopped, PrtError::Cancelled), "{stopped:?}");
}

#[test]
fn a_split_that_is_stopped_everywhere_ends_with_the_same_scene() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("checkpoint");
    let scene = built_in::ball_over_ground(8);
    let bvh = Bvh::new(&scene);
    let options = options(BakeMode::Shadowed, 1e-4, 3000);
    let (expected, expected_report) = split(&scene, &options);
    // Each time it is stopped a few calls later, so that some calls find new work done before.
    let mut stops = 0;
    let (found, report) = loop {
        let mut calls = 0;
        let mut stop = |_: &Progress| {
            calls += 1;
            if calls > 1 + stops { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        match split_adaptively(&scene, &bvh, &options, Job::default().watched_by(&mut stop).kept_in(&path)) {
            Err(PrtError::Cancelled) => stops += 1,
            other => break other.unwrap(),
        }
    };
    assert!(stops > 3, "stopped {stops} times");
    assert_eq!(report, expected_report, "report");
    assert!(found.meshes() == expected.meshes(), "the same meshes");
    let files = (0..=report.rounds).map(|round| folder.path().join(format!("checkpoint.split-{round}")));
    assert_eq!(
        JobFiles::kept_in(path.clone(), path.clone()).rounds(),
        files.collect::<Vec<_>>(),
        "each round has a file"
    );
    // Options that lead elsewhere do not take these files for theirs.
    let other = options.clone().bake(options.bake.clone().seed(9));
    let error = split_adaptively(&scene, &bvh, &other, Job::default().kept_in(&path)).unwrap_err();
    assert!(error.to_string().contains("this checkpoint is of another bake"), "{error}");
}
