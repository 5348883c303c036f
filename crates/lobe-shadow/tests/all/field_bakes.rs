//! Bakes: the same for any number of threads, stopped and resumed, refused in one line.

use std::ops::ControlFlow;

use lobe_io::{Job, Progress};
use lobe_sh::{Dir, Zonal};
use lobe_shadow::{
    FieldOptions, RadialInterpolation, ShadowError, VisibilityOptions, bake_field, bake_vertex_visibility,
    bake_visibility,
};
use lobe_testkit::Random;

use crate::shapes::{ball, rabbit, scene, torus};

fn options() -> FieldOptions {
    FieldOptions::default().order(3).spheres(5).cells(6).rays(128)
}

#[test]
fn a_bake_does_not_depend_on_the_number_of_threads() {
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| bake_field(&rabbit(), &options(), Job::default()).unwrap())
    };
    let one = on(1);
    for threads in [2, 5] {
        assert!(on(threads) == one, "{threads} threads");
    }
    let other = bake_field(&rabbit(), &options().seed(1), Job::default()).unwrap();
    assert!(other.0 != one.0, "another seed");
}

#[test]
fn a_stopped_bake_continues_where_it_was_and_ends_with_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("f.checkpoint");
    let whole = bake_field(&rabbit(), &options(), Job::default()).unwrap();
    let mut first = 0;
    let mut stop = |progress: &Progress| {
        first = progress.done;
        if progress.done > 0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let stopped = bake_field(&rabbit(), &options(), Job::default().kept_in(&path).watched_by(&mut stop));
    assert!(matches!(stopped, Err(ShadowError::Cancelled)), "{stopped:?}");
    let mut seen = Vec::new();
    let mut watch = |progress: &Progress| {
        seen.push((progress.done, progress.resumed, progress.total));
        ControlFlow::Continue(())
    };
    let resumed = bake_field(&rabbit(), &options(), Job::default().kept_in(&path).watched_by(&mut watch)).unwrap();
    assert!(resumed == whole, "the same field");
    // Of 6 cells 38 vertices differ.
    let samples = 5 * 38 + 1;
    assert_eq!(seen[0], (first, first, samples), "it goes on where it was");
    assert_eq!(seen[seen.len() - 1].0, samples, "and tells the end");
    let other = bake_field(&ball(), &options(), Job::default().kept_in(&path)).unwrap_err().to_string();
    assert!(other.contains("of another bake of an occlusion field: the scene or the options differ"), "{other}");
}

#[test]
fn the_field_of_a_scene_far_away_is_the_same_field_far_away() {
    let (here, _) = bake_field(&rabbit(), &options(), Job::default()).unwrap();
    let (there, _) = bake_field(&rabbit().moved([1e7, 0.0, -3e6]), &options(), Job::default()).unwrap();
    assert!(there.rows() == here.rows(), "the same numbers");
    let [a, b] = [here, there].map(|field| field.grid().center());
    let moved: Vec<f64> = (0..3).map(|k| b[k] - a[k]).collect();
    assert!((moved[0] - 1e7).abs() < 1e-6 && moved[1] == 0.0 && (moved[2] + 3e6).abs() < 1e-6, "{moved:?}");
}

#[test]
fn a_baked_field_has_no_seams() {
    for scene in [rabbit(), torus()] {
        let (field, report) = bake_field(&scene, &options(), Job::default()).unwrap();
        assert!(report.inside > 0, "samples were filled");
        let (grid, width) = (field.grid(), 3 + 9);
        let places: Vec<[f64; 3]> = (0..grid.points()).map(|point| grid.offset(point)).collect();
        for (point, place) in places.iter().enumerate() {
            let first = places.iter().position(|other| other == place).unwrap();
            let [a, b] = [first, point].map(|point| &field.rows()[point * width..][..width]);
            assert!(a == b, "samples {first} and {point} are one place: {a:?} and {b:?}");
        }
        // Across the planes x = 0 and y = 0 of the lower half, where the octahedron is cut open.
        let mut random = Random::new(5);
        for k in 0..200 {
            let (a, r) = (random.unit() * std::f64::consts::FRAC_PI_2, grid.radius() * (0.3 + 3.0 * random.unit()));
            let side = |x: f64| {
                let along = [x, r * a.cos(), -r * a.sin()];
                let along = if k % 2 == 0 { along } else { [along[1], along[0], along[2]] };
                let point = std::array::from_fn(|c| grid.center()[c] + along[c]);
                field.occlusion_at(point, RadialInterpolation::Linear)
            };
            let [left, right] = [side(-1e-6 * r), side(1e-6 * r)];
            let step = (0..9).map(|i| (left[i] - right[i]).abs()).fold(0.0, f32::max);
            assert!(step < 1e-4, "{r}, {a}: a step of {step}");
        }
    }
}

#[test]
fn a_flat_scene_has_a_field_and_what_cannot_be_is_refused_in_one_line() {
    let flat = scene(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]]);
    let (field, report) = bake_field(&flat, &options(), Job::default()).unwrap();
    assert_eq!(report.inside, 0, "a sheet has no inside");
    assert!(field.rows().iter().all(|x| x.is_finite()), "finite");
    for (options, expected) in [
        (options().order(0), "an order of 1 to 8, found 0"),
        (options().order(9), "an order of 1 to 8, found 9"),
        (options().rays(0), "1 to 2^20 rays, found 0"),
        (options().cells(5), "an even number of cells"),
        (options().inner(0.0), "expected spheres that rise"),
        (options().outer(f64::INFINITY), "expected spheres that rise"),
        (options().spheres(usize::MAX), "sample points"),
    ] {
        let message = bake_field(&flat, &options, Job::default()).unwrap_err().to_string();
        assert!(message.contains(expected) && !message.contains('\n'), "{message}");
    }
}

#[test]
fn a_convex_surface_hides_the_half_below_it_and_a_cosine_takes_the_rest() {
    let scene = ball();
    let mesh = &scene.meshes()[0];
    let which = [10, 500, 1200];
    let [positions, normals] = [mesh.positions(), mesh.normals()].map(|all| which.map(|k: usize| all[k]));
    let options = VisibilityOptions::default().order(5).rays(4096);
    let visible = bake_visibility(&scene, &positions, &normals, &options, Job::default()).unwrap();
    let (fitted, rays) = bake_vertex_visibility(&scene, &options, Job::default()).unwrap();
    let of_vertices = which.map(|k| &fitted[25 * k..][..25]).concat();
    // Four points or more in each triangle, however small.
    let rays = rays as f64 / (4096 * scene.vertex_count()) as f64;
    assert!((0.9..1.2).contains(&rays), "{rays} of the rays");
    let half = Zonal::cone(5, std::f64::consts::FRAC_PI_2);
    let all = normals.iter().zip(visible.chunks_exact(25)).chain(normals.iter().zip(of_vertices.chunks_exact(25)));
    for (normal, visible) in all {
        let expected = half.towards(Dir::from_f32(*normal).unwrap(), 1.0_f64);
        for i in 0..25 {
            let off = (f64::from(visible[i]) - expected[i]).abs();
            // Around a vertex of 64 sides the horizon lies up to 3 degrees lower.
            assert!(off < 0.12, "{normal:?}, {i}: {} against {}", visible[i], expected[i]);
        }
    }
    let refuse = |positions: &[[f32; 3]], normals: &[[f32; 3]]| {
        bake_visibility(&scene, positions, normals, &options, Job::default()).unwrap_err().to_string()
    };
    assert!(refuse(&positions, &normals[1..]).contains("a normal for each of 3 positions, found 2"), "one is missing");
    assert!(refuse(&[[f32::NAN; 3]], &normals[..1]).contains("receiver 0 is not finite"), "no number");
    let none = bake_visibility(&scene, &[], &[], &options, Job::default()).unwrap();
    assert!(none.is_empty(), "no receivers, no visibility");
}
