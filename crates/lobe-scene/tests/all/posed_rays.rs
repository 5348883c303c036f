//! Rays in posed scenes: a tree that was refit finds what one built anew finds.

use lobe_scene::{AnimatedScene, Bvh, Mesh, MeshParts, Ray, Scene, built_in};
use lobe_testkit::Random;

fn rays(scene: &AnimatedScene) -> Vec<Ray> {
    let mut random = Random::new(31);
    let [min, max] = scene.rest().world_bounds();
    let count = 4000;
    let mut point = || [0, 1, 2].map(|k| (min[k] + random.unit() * (max[k] - min[k] + 0.5)) as f32);
    let points: Vec<_> = (0..count).map(|_| point()).collect();
    points.into_iter().map(|p| Ray::new(p, random.direction().map(|c| c as f32))).collect()
}

#[test]
fn a_refit_tree_has_the_hits_of_a_tree_built_anew_bit_by_bit() {
    for scene in [built_in::walking_figure(16), built_in::three_objects(24)] {
        let mut refit = scene.pose(0, 0.0).unwrap().bvh();
        let rays = rays(&scene);
        let mut hits = 0;
        for time in [0.3, 0.6, 1.0, 0.0] {
            let pose = scene.pose(0, time).unwrap();
            refit.refit(pose.scene());
            let built = Bvh::new(pose.scene());
            assert_eq!(refit.bounds(), built.bounds(), "bounds at {time}");
            for ray in &rays {
                let (found, expected) = (refit.closest(ray), built.closest(ray));
                assert_eq!(found, expected, "{ray:?} at {time}");
                assert_eq!(refit.is_occluded(ray), expected.is_some(), "{ray:?} at {time}");
                hits += usize::from(expected.is_some());
            }
        }
        assert!(hits > 2000, "{hits} hits: enough to tell");
    }
}

#[test]
fn a_tree_refit_to_the_scene_it_was_built_for_is_the_same() {
    let pose = built_in::walking_figure(16).pose(0, 0.2).unwrap();
    let built = pose.bvh();
    let mut refit = built.clone();
    refit.refit(pose.scene());
    let (cost, expected) = (refit.expected_cost(), built.expected_cost());
    assert!((cost - expected).abs() <= 1e-5 * expected, "{cost}, expected {expected}");
}

/// 64 x 64 triangles of a plane, each at the place that `order` has for its number.
fn plane(order: impl Fn(u32) -> u32) -> Scene {
    let corners = |i: u32| {
        let (x, y) = ((order(i) % 64) as f32, (order(i) / 64) as f32);
        [[x, y, 0.0], [x + 1.0, y, 0.0], [x, y + 1.0, 0.0]]
    };
    let parts = MeshParts {
        positions: (0..4096).flat_map(corners).collect(),
        triangles: (0..4096).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
        ..MeshParts::default()
    };
    Scene::new(vec![Mesh::new(parts).unwrap()], Vec::new(), Vec::new()).unwrap()
}

#[test]
fn a_tree_is_refit_until_it_is_worn_and_then_built_anew() {
    // Triangles of a plane change places: with their neighbors, and all of them.
    let (ordered, mixed) = (plane(|i| i), plane(|i| i * 1031 % 4096));
    let mut bvh = Bvh::new(&ordered);
    let cost = bvh.expected_cost();
    bvh.update(&plane(|i| i ^ 1));
    assert!(
        bvh.expected_cost() < 1.4 * cost,
        "{} of {cost}: neighbors have changed places",
        bvh.expected_cost() / cost
    );
    let mut worn = bvh.clone();
    worn.refit(&mixed);
    assert!(worn.expected_cost() > 3.0 * cost, "{} of {cost}: nothing is where it was", worn.expected_cost() / cost);
    bvh.update(&mixed);
    let built = Bvh::new(&mixed).expected_cost();
    assert_eq!(bvh.expected_cost(), built, "built anew");
}

#[test]
fn a_tree_that_was_worn_by_a_refit_is_built_anew_too() {
    let (ordered, mixed) = (plane(|i| i), plane(|i| i * 1031 % 4096));
    let mut bvh = Bvh::new(&ordered);
    bvh.refit(&mixed);
    bvh.update(&mixed);
    assert_eq!(bvh.expected_cost(), Bvh::new(&mixed).expected_cost(), "not measured by the cost after the refit");
}

#[test]
#[should_panic(expected = "triangles of the scene and of the tree")]
fn a_scene_with_other_triangles_is_no_pose() {
    let mut bvh = Bvh::new(&built_in::cornell_box(8));
    bvh.refit(&built_in::closed_white_box(3));
}
