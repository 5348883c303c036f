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

/// Points between two distances, and what rays see there.
struct Truth {
    order: usize,
    points: Vec<[f32; 3]>,
    visibility: Vec<f32>,
}

impl Truth {
    fn new(scene: &Scene, range: [f64; 2], order: usize) -> Self {
        let points = points_between(scene, range, 60, 3);
        let visibility = traced(scene, &points, order, RAYS);
        Self { order, points, visibility }
    }

    fn error(&self, field: &OcclusionField, interpolation: RadialInterpolation) -> f64 {
        let at = |p: &[f32; 3]| field.visibility_at(p.map(f64::from), interpolation).into_vec();
        let found: Vec<f32> = self.points.iter().flat_map(at).collect();
        relative_error(&found, &self.visibility, self.order)
    }
}

fn error(scene: &Scene, field: &OcclusionField, range: [f64; 2], interpolation: RadialInterpolation) -> f64 {
    Truth::new(scene, range, field.order()).error(field, interpolation)
}

#[test]
fn the_error_falls_with_the_sampling_at_every_distance() {
    let scene = rabbit();
    let fields = [(4, 4), (8, 8), (14, 14)]
        .map(|(spheres, cells)| baked(&scene, &FieldOptions::default().spheres(spheres).cells(cells).rays(256)));
    // Within the bounding sphere, around it, and beyond.
    for (range, bound) in [([0.3, 1.0], 0.2), ([1.0, 2.5], 0.04), ([2.5, 7.0], 0.015)] {
        let truth = Truth::new(&scene, range, 4);
        let errors = fields.each_ref().map(|field| truth.error(field, RadialInterpolation::Linear));
        assert!(errors.is_sorted_by(|a, b| a > b), "{range:?}: {errors:?} with 4, 8, 14 spheres and cells");
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
    // Beyond 8 R band 5 is that of the disc at 8 R, 5 · 6/8 (1/8)² = 6 % of itself too small.
    for (distance, bound) in
        [(1.05_f64, 0.1), (1.2, 0.1), (1.5, 0.05), (3.0, 0.04), (7.0, 0.03), (20.0, 0.15), (200.0, 0.15)]
    {
        let mut worst = 0.0_f64;
        for s in [[0.0, 0.0, 1.0], [0.6, 0.64, 0.48], [-0.48, 0.6, -0.64]] {
            let cone = Zonal::cone(6, (1.0 / distance).asin());
            let expected = cone.towards(-Dir::from_unit(s), 1.0_f64);
            let found = field.occlusion_at(s.map(|c| distance * c), RadialInterpolation::Linear);
            let largest = (0..36).map(|i| (f64::from(found[i]) - expected[i]).abs()).fold(0.0, f64::max);
            worst = worst.max(largest / cone.coefficients()[0]);
        }
        println!("at {distance}: off by {worst} of the solid angle");
        // The ball of 64 sides is 0.5 % smaller.
        assert!(worst < bound, "at {distance}: off by {worst} of the solid angle");
    }
}

#[test]
fn beyond_the_last_sphere_occlusion_falls_with_the_solid_angle() {
    let scene = rabbit();
    let field = baked(&scene, &FieldOptions::default().rays(512));
    let near = error(&scene, &field, [6.0, 8.0], RadialInterpolation::Linear);
    let far = error(&scene, &field, [8.0, 24.0], RadialInterpolation::Linear);
    println!("{near} before the last sphere, {far} beyond");
    // Directions there are off by at most 1/8.
    assert!(near < 0.02 && far < 0.03, "{near} before, {far} beyond");
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
        let options = FieldOptions::default().rays(256);
        let [filled, not] = [true, false].map(|fill| {
            error(&scene, &baked(&scene, &options.clone().fill_inside(fill)), range, RadialInterpolation::Linear)
        });
        println!("{name}: {filled} filled, {not} not");
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
    let field = baked(&torus(), &FieldOptions::default().spheres(8).rays(512));
    let truth = traced(&torus(), &[[0.0; 3]], 4, RAYS);
    let found = field.visibility_at([0.0; 3], RadialInterpolation::Linear).into_vec();
    let off = relative_error(&found, &truth, 4);
    assert!(off < 0.03, "the center of the torus: off by {off}");
}
