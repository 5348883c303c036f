//! Transfer matrices and neighborhood transfer against closed forms and against vectors.

use std::f64::consts::PI;

use crate::common::{baked, options, receiver, scene_of};
use lobe_io::Job;
use lobe_prt::{
    BakeMode, BakeOptions, Channels, Neighborhood, NeighborhoodGrid, Receivers, TransferMatrices, bake_matrices,
    bake_neighborhood,
};
use lobe_scene::{Bounds, Bvh, Scene, built_in};
use lobe_sh::sphere::SphereQuadrature;
use lobe_sh::{Dir, Expansion as _, Rgb, ShVec, Zonal};
use lobe_testkit::{Random, directions};

fn matrices(scene: &Scene, receivers: &Receivers, options: &BakeOptions) -> TransferMatrices {
    bake_matrices(scene, &Bvh::new(scene), receivers, options, Job::default()).unwrap().0
}

fn sky(order: usize, seed: u64) -> ShVec<Rgb<f64>> {
    let mut random = Random::new(seed);
    let mut light = ShVec::zero(order);
    for i in 0..order * order {
        light[i] = Rgb::new(random.signed(), random.signed(), random.signed());
    }
    light[0] = Rgb::new(4.0, 5.0, 6.0);
    light
}

#[test]
fn with_nothing_in_the_way_a_matrix_cuts_the_light_off_at_the_horizon() {
    let scene = built_in::closed_white_box(1);
    let rule = SphereQuadrature::of_degree(200);
    for n in directions().into_iter().step_by(40) {
        let receivers = receiver([0.0; 3], n.map(|c| c as f32));
        let found = matrices(&scene, &receivers, &options(BakeMode::Unshadowed, 3, 4096));
        let light = sky(3, 1);
        let incident = found.incident(0, light.coefficients());
        for i in 0..9 {
            let y = ShVec::from_vec((0..9).map(|k| f64::from(u8::from(k == i))).collect()).unwrap();
            let above = |s: Dir| if s.dot(Dir::from_unit(n)) > 0.0 { y.eval(s) * light.eval(s).g } else { 0.0 };
            let expected = rule.integrate(above);
            // The rule is coarse at the horizon: 1 % of the light.
            assert!((incident[i].g - expected).abs() < 0.03, "{n:?}, {i}: {}, expected {expected}", incident[i].g);
        }
    }
}

#[test]
fn a_constant_sky_is_sent_on_unchanged_by_a_lobe_that_is_the_cosine() {
    // The hemisphere above is 1/2 + 3/4 cos θ + odd bands, and the clamped cosine's factors α are 1, 2/3, then those of
    // even bands: what both have are the bands 0 and 1, and along the normal 1/2 · 1 + 3/4 · 2/3 = 1 at any order from
    // 2 on.
    let scene = built_in::closed_white_box(1);
    let constant = ShVec::constant(4, Rgb::new(1.0, 2.0, 0.0));
    for n in directions().into_iter().step_by(30) {
        let found = matrices(&scene, &receiver([0.0; 3], n.map(|c| c as f32)), &options(BakeMode::Unshadowed, 4, 4096));
        let normal = Dir::from_unit(n);
        let sent = |lobe: &Zonal, v| found.exit_radiance(0, constant.coefficients(), lobe, normal, v);
        let sum = sent(&Zonal::phong(4, 1.0), normal);
        assert!((sum.r - 1.0).abs() < 1e-3 && (sum.g - 2.0).abs() < 2e-3 && sum.b == 0.0, "{n:?}: {sum:?}");
        assert_eq!(sent(&Zonal::phong(4, 9.0), -normal), Rgb::new(0.0, 0.0, 0.0), "from below");
    }
}

#[test]
fn a_mirror_lobe_shows_the_light_along_the_reflected_view() {
    // Over a white plane without end a receiver that looks up sees the sky; a sharp lobe of high order finds its bright
    // side.
    let scene = built_in::closed_white_box(1);
    let found = matrices(&scene, &receiver([0.0; 3], [0.0, 0.0, 1.0]), &options(BakeMode::Unshadowed, 6, 4096));
    let light = ShVec::impulse(6, Dir::new([1.0, 0.0, 1.0]).unwrap(), Rgb::new(1.0, 1.0, 1.0));
    let eye = |x: f64| Dir::new([x, 0.0, 1.0]).unwrap();
    let sent = |x| found.exit_radiance(0, light.coefficients(), &Zonal::ggx(6, 0.1), Dir::Z, eye(x)).g;
    assert!(sent(-1.0) > 3.0 * sent(1.0).abs(), "against the light {}, along it {}", sent(-1.0), sent(1.0));
}

#[test]
fn a_cosine_lobe_seen_from_above_sends_what_transfer_vectors_send() {
    // Both are 1/π ∫ L_in max(n·s, 0) ds, here with the cosine cut off at band 8.
    let scene = built_in::cornell_box(8);
    let receivers = receiver([-0.7, -0.5, 0.0], [0.0, 0.0, 1.0]);
    for mode in [BakeMode::Shadowed, BakeMode::Interreflected] {
        let vectors = baked(&scene, &receivers, &options(mode, 8, 4096)).0;
        let matrices = matrices(&scene, &receivers, &options(mode, 8, 4096));
        let expected_channels = if mode == BakeMode::Shadowed { Channels::Gray } else { Channels::Rgb };
        assert_eq!(matrices.channels(), expected_channels, "{mode:?}");
        for seed in 0..4 {
            let light = sky(3, seed).resized(8);
            let expected = vectors.exit_radiance(light.coefficients())[0];
            let found = matrices.exit_radiance(0, light.coefficients(), &Zonal::phong(8, 1.0), Dir::Z, Dir::Z);
            let error = (found.r - f64::from(expected.r)).abs() + (found.b - f64::from(expected.b)).abs();
            assert!(error < 0.03, "{mode:?}, sky {seed}: {found:?}, expected {expected:?}");
        }
    }
}

#[test]
fn around_nothing_the_neighborhood_changes_no_light() {
    let triangle = vec![[0.0, 0.0, -1e6], [1e-3, 0.0, -1e6], [0.0, 1e-3, -1e6]];
    let scene = scene_of(triangle, vec![[0, 1, 2]], 0.5, true);
    let grid = NeighborhoodGrid::new(Bounds { min: [-1.0; 3], max: [1.0; 3] }, [2, 3, 2]).unwrap();
    let options = options(BakeMode::Interreflected, 4, 4096);
    let (around, report) = bake_neighborhood(&scene, &Bvh::new(&scene), &grid, &options, Job::default()).unwrap();
    assert!((report.energy_per_bounce[0] - 1.0).abs() < 1e-9, "{report:?}");
    let light = sky(4, 3);
    let found = around.incident([0.3, 0.1, -7.0], light.coefficients());
    let difference = &found - &light;
    let error = difference.dot(&difference).g.sqrt();
    assert!(error < 0.02, "root of the energy of the difference {error}");
}

#[test]
fn what_moves_is_lit_as_a_receiver_of_the_scene_at_its_place() {
    // Below the ball, where it hides a quarter of the sky or more, at a point of the grid.
    let scene = built_in::ball_over_ground(32);
    let bvh = Bvh::new(&scene);
    let grid = NeighborhoodGrid::new(Bounds { min: [1.0, -0.5, 0.2], max: [2.0, 0.5, 1.2] }, [2, 3, 2]).unwrap();
    let options = options(BakeMode::Interreflected, 6, 4096).bounces(1);
    let (around, _) = bake_neighborhood(&scene, &bvh, &grid, &options, Job::default()).unwrap();
    for n in [[-0.6_f32, 0.0, 0.8], [0.0, 0.6, 0.8], [0.0, 0.0, -1.0]] {
        let place = [1.0, 0.0, 0.2];
        let own = &Zonal::clamped_cosine(6) * (1.0 / PI);
        let own = own.towards(Dir::from_f32(n).unwrap(), 1.0);
        let static_one = baked(&scene, &receiver(place, n), &options).0;
        let light = sky(3, 5).resized(6);
        let expected = static_one.exit_radiance(light.coefficients())[0].g;
        let incident = around.incident(place.map(f64::from), light.coefficients());
        let found: f64 = (0..36).map(|i| own[i] * incident[i].g).sum();
        assert!((found - f64::from(expected)).abs() < 0.05, "{n:?}: {found}, expected {expected}");
    }
}

#[test]
fn a_grid_mixes_linear_functions_exactly_and_ends_at_its_border() {
    let grid = NeighborhoodGrid::new(Bounds { min: [-1.0, 0.0, 2.0], max: [1.0, 3.0, 4.0] }, [3, 4, 2]).unwrap();
    let points = grid.points([0.0; 3]);
    assert_eq!((points.len(), points[0], points[1]), (24, [-1.0, 0.0, 2.0], [0.0, 0.0, 2.0]), "points");
    assert_eq!(points[23], [1.0, 3.0, 4.0], "the last corner");
    let f = |p: [f32; 3]| 1.0 + 2.0 * f64::from(p[0]) - f64::from(p[1]) + 0.5 * f64::from(p[2]);
    for (place, nearest) in
        [([0.3, 1.7, 3.1], [0.3, 1.7, 3.1]), ([1.0, 3.0, 4.0], [1.0, 3.0, 4.0]), ([9.0, -9.0, 3.0], [1.0, 0.0, 3.0])]
    {
        let around = grid.around(place);
        let found: f64 = around.iter().map(|&(i, weight)| weight * f(points[i])).sum();
        let weights: f64 = around.iter().map(|a| a.1).sum();
        assert!((found - f(nearest)).abs() < 1e-6 && (weights - 1.0).abs() < 1e-12, "{place:?}: {found}");
    }
    let refusal = |max, counts| NeighborhoodGrid::new(Bounds { min: [0.0; 3], max }, counts).unwrap_err().to_string();
    let few = "expected at least 2 points along each axis and at most 2^24, found [1, 2, 2]";
    assert_eq!(refusal([1.0; 3], [1, 2, 2]), few, "too few");
    assert!(refusal([1.0; 3], [usize::MAX, 2, 2]).contains("at most 2^24"), "too many");
    assert!(refusal([1.0, 0.0, 1.0], [2; 3]).starts_with("expected a box with a volume"), "flat");
    let none = TransferMatrices::new(1, Channels::Gray, vec![1.0; 7]).unwrap();
    let found = Neighborhood::new(grid, none).unwrap_err().to_string();
    assert_eq!(found, "neighborhood: expected matrices of 24 points, found 7", "another number");
}

#[test]
fn matrices_resume_from_their_checkpoint_and_from_no_other() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("m.lobe-partial");
    let scene = built_in::ball_over_ground(8);
    let (bvh, receivers) = (Bvh::new(&scene), Receivers::at_vertices(&scene).unwrap());
    let options = options(BakeMode::Interreflected, 2, 64).bounces(1);
    let expected = bake_matrices(&scene, &bvh, &receivers, &options, Job::default()).unwrap().0;
    let bake = || bake_matrices(&scene, &bvh, &receivers, &options, Job::default().kept_in(&path)).unwrap().0;
    assert!(bake() == expected, "the first time");
    let complete = std::fs::read(&path).unwrap();
    std::fs::write(&path, &complete[..complete.len() / 2]).unwrap();
    assert!(bake() == expected, "from half");
    let vectors = lobe_prt::bake_on_disk(&scene, &bvh, &receivers, &options, Job::default().kept_in(&path));
    let found = vectors.unwrap_err().to_string();
    assert!(found.contains("this checkpoint is of another bake"), "{found}");
}
