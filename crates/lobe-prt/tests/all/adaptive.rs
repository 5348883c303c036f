//! Adaptive subdivision where transfer changes.

use std::ops::ControlFlow;

use lobe_io::Job;
use lobe_prt::{AdaptiveOptions, BakeMode, BakeOptions, PrtError, Receivers, Transfer, bake, split_adaptively};
use lobe_scene::{Bvh, Scene, built_in};

fn options(mode: BakeMode, threshold: f64, min_edge: f32) -> AdaptiveOptions {
    let bake = BakeOptions::default().mode(mode).order(3).samples(64);
    AdaptiveOptions::default().threshold(threshold).min_edge(Some(min_edge)).bake(bake)
}

fn transfer(scene: &Scene, options: &AdaptiveOptions) -> Transfer {
    let receivers = Receivers::at_vertices(scene).unwrap();
    bake(scene, &Bvh::new(scene), &receivers, &options.bake, Job::default()).unwrap().0
}

/// Length and difference of transfer, of all edges of a mesh whose first vertex is receiver `first`.
fn edges(scene: &Scene, transfer: &Transfer, mesh: usize, first: usize) -> Vec<(f64, f64)> {
    let mesh = &scene.meshes()[mesh];
    let mut found = Vec::new();
    for t in mesh.triangles() {
        for k in 0..3 {
            let [a, b] = [t[k] as usize, t[(k + 1) % 3] as usize];
            let (p, q) = (mesh.positions()[a], mesh.positions()[b]);
            let length = (0..3).map(|i| f64::from(p[i] - q[i]).powi(2)).sum::<f64>().sqrt();
            let of = |v: usize| (0..3).flat_map(move |c| transfer.vector(first + v, c)).copied();
            let difference = of(a).zip(of(b)).map(|(a, b)| f64::from(a - b).powi(2)).sum::<f64>().sqrt();
            found.push((length, difference));
        }
    }
    found
}

#[test]
fn no_long_edge_is_left_along_which_transfer_changes_and_nothing_else_is_split() {
    let scene = built_in::ball_over_ground(8);
    // The closed form has no noise: on the ground transfer is the same everywhere, on the ball it turns with the
    // normal.
    let options = options(BakeMode::Unshadowed, 0.15, 0.05);
    let before = transfer(&scene, &options);
    let squares: f64 = before.coefficients().iter().map(|&c| f64::from(c).powi(2)).sum();
    let limit = 0.15 * (squares / before.receivers() as f64).sqrt();
    let (fine, report) = split_adaptively(&scene, &options, Job::default()).unwrap();
    assert_eq!(fine.meshes()[0], scene.meshes()[0], "the ground stays as it was");
    let (few, many) = (scene.meshes()[1].positions(), fine.meshes()[1].positions());
    assert_eq!(&many[..few.len()], few, "the first vertices are the old ones");
    let ground = scene.meshes()[0].positions().len();
    let count = |scene: &Scene, transfer: &Transfer| {
        let changing = edges(scene, transfer, 1, ground).into_iter().filter(|(_, difference)| *difference > limit);
        changing.count()
    };
    let (worst_before, worst_after) = (count(&scene, &before), count(&fine, &transfer(&fine, &options)));
    assert!(worst_before > 100, "{worst_before} edges change too much to begin with");
    assert_eq!((worst_after, report.unresolved), (0, 0), "edges that change too much; {report:?}");
    assert!(report.largest_change > 0.1 && report.largest_change <= 0.15, "the goal is reached; {report:?}");
    assert_eq!((report.vertices_before, report.vertices), (scene.vertex_count(), fine.vertex_count()), "vertices");
    assert!(report.rounds >= 2 && report.vertices < 20 * report.vertices_before, "{report:?}");
}

#[test]
fn edges_that_are_short_are_left_and_counted() {
    let scene = built_in::ball_over_ground(8);
    let options = options(BakeMode::Unshadowed, 0.01, 0.5);
    let (fine, report) = split_adaptively(&scene, &options, Job::default()).unwrap();
    let ground = scene.meshes()[0].positions().len();
    let longest =
        edges(&fine, &transfer(&fine, &options), 1, ground).into_iter().map(|(length, _)| length).fold(0.0, f64::max);
    assert!(longest < 0.5 && report.unresolved > 100, "longest edge {longest}; {report:?}");
    assert!(report.largest_change > 0.01, "the goal is not reached; {report:?}");
}

#[test]
fn rounds_that_split_gray_surfaces_alone_keep_the_colors_of_the_others() {
    // The red ball is finer than the shortest edge; the gray ground below is split in its shadow, round after round.
    let [coarse, fine_ball] = [8, 64].map(built_in::ball_over_ground);
    let (mut meshes, materials, _) = coarse.into_parts();
    meshes[1] = fine_ball.meshes()[1].clone();
    let scene = Scene::new(meshes, materials, vec![]).unwrap();
    let options = options(BakeMode::Shadowed, 0.2, 0.15);
    let (fine, report) = split_adaptively(&scene, &options, Job::default()).unwrap();
    assert!(fine.meshes()[1] == scene.meshes()[1], "the ball stays as it was");
    assert!(report.rounds >= 2 && report.vertices > report.vertices_before, "{report:?}");
}

#[test]
fn options_that_cannot_be_are_refused_and_progress_may_stop() {
    let scene = built_in::closed_white_box(1);
    let refusal = |threshold, min_edge| {
        let options = options(BakeMode::Shadowed, threshold, min_edge);
        split_adaptively(&scene, &options, Job::default()).unwrap_err().to_string()
    };
    assert_eq!(refusal(0.0, 1.0), "expected a threshold above zero, found 0", "threshold");
    assert_eq!(refusal(0.1, -1.0), "expected a shortest edge above zero, found -1", "edge");
    let options = options(BakeMode::Shadowed, 0.1, 0.1);
    let stopped =
        split_adaptively(&scene, &options, Job::default().watched_by(&mut |_| ControlFlow::Break(()))).unwrap_err();
    assert!(matches!(stopped, PrtError::Cancelled), "{stopped:?}");
}

#[test]
fn a_split_that_is_stopped_everywhere_ends_with_the_same_scene() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("checkpoint");
    let path_of = |round: usize| folder.path().join(format!("checkpoint.split-{round}"));
    let scene = built_in::ball_over_ground(8);
    let options = options(BakeMode::Shadowed, 0.2, 0.15);
    let (expected, expected_report) = split_adaptively(&scene, &options, Job::default()).unwrap();
    // Each time it is stopped a few calls later, so that some calls find new work done before.
    let mut stops = 0;
    let (found, report) = loop {
        let mut calls = 0;
        let mut stop = |_: &lobe_io::Progress| {
            calls += 1;
            if calls > 1 + stops { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        match split_adaptively(&scene, &options, Job::default().watched_by(&mut stop).kept_in(&path)) {
            Err(PrtError::Cancelled) => stops += 1,
            other => break other.unwrap(),
        }
    };
    assert!(stops > 3, "stopped {stops} times");
    assert_eq!(report, expected_report, "report");
    assert!(found.meshes() == expected.meshes(), "the same meshes");
    for round in 0..=report.rounds {
        assert!(path_of(round).exists(), "round {round} has a file");
    }
    assert!(!path_of(report.rounds + 1).exists(), "and no other has");
    // Options that lead elsewhere do not take these files for theirs.
    let other = options.clone().bake(options.bake.clone().seed(9));
    let error = split_adaptively(&scene, &other, Job::default().kept_in(&path)).unwrap_err();
    assert!(error.to_string().contains("this checkpoint is of another bake"), "{error}");
}
