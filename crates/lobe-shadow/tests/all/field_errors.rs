//! Occlusion fields against rays. The example `field_errors` prints the same for more shapes, orders and samplings.

use lobe_io::Job;
use lobe_scene::Scene;
use lobe_sh::{Dir, Expansion as _, Zonal};
use lobe_shadow::{FieldOptions, OcclusionField, RadialInterpolation, bake_field};

use crate::shapes::{ball, points_between, rabbit, relative_error, torus, traced};

const RAYS: usize = 1 << 11;

fn baked(scene: &Scene, options: &FieldOptions) -> OcclusionField {
    bake_field(scene, options, Job::default()).unwrap().0
}

fn error(scene: &Scene, field: &OcclusionField, range: [f64; 2], interpolation: RadialInterpolation) -> f64 {
    let points = points_between(scene, range, 60, 3);
    let order = field.order();
    let truth = traced(scene, &points, order, RAYS);
    let at = |p: &[f32; 3]| field.visibility_at(p.map(f64::from), interpolation).into_vec();
    relative_error(&points.iter().flat_map(at).collect::<Vec<f32>>(), &truth, order)
}

#[test]
fn the_error_falls_with_the_sampling_at_every_distance() {
    let scene = rabbit();
    // Within the bounding sphere, around it, and beyond.
    for (range, bound) in [([0.3, 1.0], 0.17), ([1.0, 2.5], 0.06), ([2.5, 7.0], 0.05)] {
        let errors: Vec<f64> = [(4, 4), (8, 8), (16, 16)]
            .map(|(spheres, cells)| {
                let field = baked(&scene, &FieldOptions::default().spheres(spheres).cells(cells).rays(512));
                error(&scene, &field, range, RadialInterpolation::Linear)
            })
            .to_vec();
        assert!(errors.is_sorted_by(|a, b| a > b), "{range:?}: {errors:?} with 4, 8, 16 spheres and cells");
        assert!(errors[2] < bound, "{range:?}: {errors:?}, expected below {bound}");
    }
}

#[test]
fn cubic_interpolation_between_few_spheres_is_the_better_one() {
    let scene = ball();
    let field = baked(&scene, &FieldOptions::default().spheres(8).cells(16));
    let [linear, cubic] = [RadialInterpolation::Linear, RadialInterpolation::Cubic]
        .map(|interpolation| error(&scene, &field, [1.6, 6.0], interpolation));
    assert!(cubic < 0.8 * linear, "cubic {cubic}, linear {linear}");
}

#[test]
fn the_field_of_a_ball_is_its_closed_form() {
    let field = baked(&ball(), &FieldOptions::default().order(6));
    // The closed form rises with a square root from the surface on, where the interpolation of it is worst. Beyond 8 R band 5
    // is that of the disc at 8 R, 5 · 6/8 (1/8)² = 6 % of itself too small.
    for (distance, bound) in
        [(1.05_f64, 0.3), (1.2, 0.25), (1.5, 0.05), (3.0, 0.03), (7.0, 0.03), (20.0, 0.15), (200.0, 0.15)]
    {
        for s in [[0.0, 0.0, 1.0], [0.6, 0.64, 0.48], [-0.48, 0.6, -0.64]] {
            let towards = -Dir::from_unit(s);
            let cone = Zonal::cone(6, (1.0 / distance).asin());
            let expected = cone.towards(towards, 1.0_f64);
            let found = field.occlusion_at(s.map(|c| distance * c), RadialInterpolation::Linear);
            let largest = (0..36).map(|i| (f64::from(found[i]) - expected[i]).abs()).fold(0.0, f64::max);
            let relative = largest / cone.coefficients()[0];
            // The ball of 64 sides is 0.5 % smaller.
            assert!(relative < bound, "at {distance}, {s:?}: off by {relative} of the solid angle");
        }
    }
}

#[test]
fn beyond_the_last_sphere_occlusion_falls_with_the_solid_angle() {
    let scene = rabbit();
    let field = baked(&scene, &FieldOptions::default().outer(8.0));
    let near = error(&scene, &field, [6.0, 8.0], RadialInterpolation::Linear);
    let far = error(&scene, &field, [8.0, 24.0], RadialInterpolation::Linear);
    // Directions there are off by at most 1/8; and rays over the whole sphere hit little.
    assert!(near < 0.1 && far < 0.2, "{near} before, {far} beyond");
    let grid = *field.grid();
    for k in 0..50 {
        let s = lobe_testkit::fibonacci_sphere(50)[k];
        let at = |r: f64| {
            field.occlusion_at(std::array::from_fn(|c| grid.center()[c] + r * s[c]), RadialInterpolation::Cubic)
        };
        let last = grid.sphere_radius(grid.spheres() - 1);
        let [inside, outside] = [at(last * 0.9999), at(last * 1.0001)];
        let step = (0..16).map(|i| (inside[i] - outside[i]).abs()).fold(0.0, f32::max);
        assert!(step < 1e-3 * inside[0], "continuous at the last sphere towards {s:?}: {step} of {}", inside[0]);
        let ratio = f64::from(at(10.0 * last)[0] / outside[0]);
        let expected = grid.scale_at(last) / grid.scale_at(10.0 * last);
        assert!((ratio / expected - 1.0).abs() < 1e-3, "{ratio}, expected {expected}");
    }
}

#[test]
fn receivers_near_a_surface_are_not_darkened_by_its_inside() {
    for (name, scene, range) in [("rabbit", rabbit(), [0.4, 0.7]), ("torus", torus(), [0.1, 0.6])] {
        let options = FieldOptions::default();
        let [filled, not] = [true, false].map(|fill| {
            error(&scene, &baked(&scene, &options.clone().fill_inside(fill)), range, RadialInterpolation::Linear)
        });
        assert!(filled < not, "{name}: {filled} filled, {not} not");
    }
}

#[test]
fn the_center_and_the_inside_are_defined() {
    for scene in [ball(), torus()] {
        let (field, report) = bake_field(&scene, &FieldOptions::default().cells(4).rays(256), Job::default()).unwrap();
        assert!(report.inside < report.points, "{report:?}");
        let center = field.grid().center();
        for interpolation in [RadialInterpolation::Linear, RadialInterpolation::Cubic] {
            let at_center = field.visibility_at(center, interpolation);
            let beside = field.visibility_at([center[0] + 1e-4, center[1], center[2]], interpolation);
            for (a, b) in at_center.coefficients().iter().zip(beside.coefficients()) {
                assert!((a - b).abs() < 1e-2 && a.is_finite(), "{a} at the center, {b} beside it");
            }
        }
    }
    // A torus does not hide its axis: what is seen from its center is a band around it.
    let field = baked(&torus(), &FieldOptions::default());
    let truth = traced(&torus(), &[[0.0; 3]], 4, RAYS);
    let found = field.visibility_at([0.0; 3], RadialInterpolation::Linear).into_vec();
    let off = relative_error(&found, &truth, 4);
    assert!(off < 0.03, "the center of the torus: off by {off}");
}
