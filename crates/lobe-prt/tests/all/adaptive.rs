//! Adaptive subdivision where transfer changes.

use std::ops::ControlFlow;

use lobe_io::{Job, Progress};
use lobe_prt::{
    AdaptiveOptions, BakeMode, BakeOptions, PrtError, Receivers, Transfer, bake, split_adaptively, split_checkpoints,
};
use lobe_scene::{Bvh, Scene, built_in};

fn options(mode: BakeMode, threshold: f64, min_edge: f32) -> AdaptiveOptions {
    let bake = BakeOptions::default().mode(mode).order(3).samples(64);
    AdaptiveOptions::default().threshold(threshold).min_edge(Some(min_edge)).bake(bake)
}

fn transfer(scene: &Scene, options: &AdaptiveOptions) -> Transfer {
    let receivers = Receivers::at_vertices(scene).unwrap();
    bake(scene, &Bvh::new(scene), &receivers, &options.bake, Job::default()).unwrap().0
}

/// The root mean square of transfer over all receivers.
fn root_mean_square(transfer: &Transfer) -> f64 {
    let squares: f64 = transfer.coefficients().iter().map(|&c| f64::from(c).powi(2)).sum();
    (squares / transfer.receivers() as f64).sqrt()
}

/// Length and error of interpolation of all edges of a mesh: the distance of the transfer in its middle from the mean of
/// that at its ends.
fn errors(scene: &Scene, options: &AdaptiveOptions, mesh: usize) -> Vec<(f64, f64)> {
    let (finer, halved) = scene.halve_edges(|_, _| true).unwrap();
    let transfer = transfer(&finer, options);
    let first: usize = finer.meshes()[..mesh].iter().map(|mesh| mesh.positions().len()).sum();
    let of = |v: usize| -> Vec<f64> {
        (0..3).flat_map(|c| transfer.vector(first + v, c)).map(|&coefficient| f64::from(coefficient)).collect()
    };
    let (positions, old) = (scene.meshes()[mesh].positions(), scene.meshes()[mesh].positions().len());
    let edges = halved[mesh].iter().enumerate().map(|(k, ends)| {
        let [a, b] = ends.map(|i| i as usize);
        let length = (0..3).map(|i| f64::from(positions[a][i] - positions[b][i]).powi(2)).sum::<f64>().sqrt();
        let ends = of(a).into_iter().zip(of(b)).map(|(a, b)| 0.5 * (a + b));
        let error = ends.zip(of(old + k)).map(|(mean, m)| (mean - m).powi(2)).sum::<f64>().sqrt();
        (length, error)
    });
    edges.collect()
}

#[test]
fn no_long_edge_is_left_in_whose_middle_interpolation_is_off_and_nothing_else_is_split() {
    let scene = built_in::ball_over_ground(8);
    // The closed form has no noise: on the ground transfer is the same everywhere, on the ball it turns with the
    // normal.
    let options = options(BakeMode::Unshadowed, 0.01, 0.01);
    let limit = 0.01 * root_mean_square(&transfer(&scene, &options));
    let (fine, report) = split_adaptively(&scene, &options, Job::default()).unwrap();
    assert_eq!(fine.meshes()[0], scene.meshes()[0], "the ground stays as it was");
    let (few, many) = (scene.meshes()[1].positions(), fine.meshes()[1].positions());
    assert_eq!(&many[..few.len()], few, "the first vertices are the old ones");
    // Rounding of f32 is far below a thousandth of the limit.
    let off = |scene: &Scene| errors(scene, &options, 1).into_iter().filter(|(_, e)| *e > 1.001 * limit).count();
    let (before, after) = (off(&scene), off(&fine));
    assert!(before > 20, "{before} edges are off by too much to begin with");
    assert_eq!((after, report.too_short, report.left_out), (0, 0, 0), "edges that are off by too much; {report:?}");
    assert!(report.largest_error > 0.0 && report.largest_error <= 0.01, "the goal is reached; {report:?}");
    assert_eq!((report.vertices_before, report.vertices), (scene.vertex_count(), fine.vertex_count()), "vertices");
    assert!(report.rounds >= 1 && report.vertices < 20 * report.vertices_before, "{report:?}");
}

#[test]
fn nothing_is_split_where_transfer_changes_evenly() {
    // A fine ball bends so little that transfer turns by nearly the same along each half of an edge, by much more than the
    // threshold.
    let (scene, bent) = (built_in::closed_white_box(1), built_in::ball_over_ground(64));
    for scene in [scene, bent] {
        let options = options(BakeMode::Unshadowed, 0.02, 0.001);
        let change = 0.02 * root_mean_square(&transfer(&scene, &options));
        let (fine, report) = split_adaptively(&scene, &options, Job::default()).unwrap();
        assert_eq!(fine.vertex_count(), scene.vertex_count(), "nothing is off by {change}; {report:?}");
    }
}

#[test]
fn a_limit_of_vertices_is_kept_and_spent_where_most_is_gained() {
    let scene = built_in::ball_over_ground(8);
    let options = options(BakeMode::Unshadowed, 0.005, 0.05);
    let whole = split_adaptively(&scene, &options, Job::default()).unwrap().1;
    let most = (whole.vertices_before + whole.vertices) / 2;
    let (fine, report) = split_adaptively(&scene, &options.clone().max_vertices(Some(most)), Job::default()).unwrap();
    assert!(fine.vertex_count() <= most && report.vertices > report.vertices_before, "{most} allowed; {report:?}");
    assert!(report.left_out > 0 && report.largest_error > options.threshold, "the goal is not reached; {report:?}");
    let largest = |scene| errors(scene, &options, 1).into_iter().map(|(_, error)| error).fold(0.0, f64::max);
    let (before, after) = (largest(&scene), largest(&fine));
    assert!(after < 0.7 * before, "the largest error falls from {before} to {after} with half of the vertices");
}

#[test]
fn edges_that_are_short_are_left_and_counted() {
    let scene = built_in::ball_over_ground(8);
    let options = options(BakeMode::Unshadowed, 0.005, 0.5);
    let (fine, report) = split_adaptively(&scene, &options, Job::default()).unwrap();
    let limit = 0.005 * root_mean_square(&transfer(&scene, &options));
    let off = errors(&fine, &options, 1).into_iter().filter(|(_, error)| *error > 1.001 * limit);
    let longest = off.map(|(length, _)| length).fold(0.0, f64::max);
    assert!(longest > 0.0 && longest < 0.5, "the longest edge that is off is {longest}; {report:?}");
    assert!(report.too_short > 100 && report.left_out == 0, "{report:?}");
    assert!(report.largest_error > 0.005, "the goal is not reached; {report:?}");
}

#[test]
fn each_round_tells_how_far_it_is_from_its_goal() {
    let scene = built_in::ball_over_ground(8);
    let options = options(BakeMode::Shadowed, 0.1, 0.01);
    let mut told = Vec::new();
    let mut watch = |progress: &Progress| {
        told.push((progress.round, progress.error));
        ControlFlow::Continue(())
    };
    let (_, report) = split_adaptively(&scene, &options, Job::default().watched_by(&mut watch)).unwrap();
    told.dedup();
    let rounds: Vec<_> = told.iter().map(|(round, _)| *round).collect();
    assert_eq!(rounds, (0..=report.rounds).collect::<Vec<_>>(), "one error for each round: {told:?}");
    assert!(told[1..].iter().all(|(_, error)| *error > 0.1), "rounds go on while the goal is not reached: {told:?}");
    assert!(report.largest_error <= 0.1, "{report:?}");
}

#[test]
fn rounds_that_split_gray_surfaces_alone_keep_the_colors_of_the_others() {
    // The red ball is finer than the shortest edge; the gray ground below is split in its shadow, round after round.
    let [coarse, fine_ball] = [8, 64].map(built_in::ball_over_ground);
    let (mut meshes, materials, _) = coarse.into_parts();
    meshes[1] = fine_ball.meshes()[1].clone();
    let scene = Scene::new(meshes, materials, vec![]).unwrap();
    let options = options(BakeMode::Shadowed, 0.02, 0.15);
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
    let scene = built_in::ball_over_ground(8);
    let options = options(BakeMode::Shadowed, 0.03, 0.15);
    let (expected, expected_report) = split_adaptively(&scene, &options, Job::default()).unwrap();
    // Each time it is stopped a few calls later, so that some calls find new work done before.
    let mut stops = 0;
    let (found, report) = loop {
        let mut calls = 0;
        let mut stop = |_: &Progress| {
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
    let files = (0..=report.rounds).map(|round| folder.path().join(format!("checkpoint.split-{round}")));
    assert_eq!(split_checkpoints(&path), files.collect::<Vec<_>>(), "each round has a file");
    // Options that lead elsewhere do not take these files for theirs.
    let other = options.clone().bake(options.bake.clone().seed(9));
    let error = split_adaptively(&scene, &other, Job::default().kept_in(&path)).unwrap_err();
    assert!(error.to_string().contains("this checkpoint is of another bake"), "{error}");
}
