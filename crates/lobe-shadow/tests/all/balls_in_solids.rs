//! The volume of a solid in a ball: closed forms, another sum over all triangles, sampling.

use std::f64::consts::PI;

use lobe_testkit::Random;

use crate::solids::{Triangle, cube, solid, star, torus};

fn ball(radius: f64) -> f64 {
    4.0 / 3.0 * PI * radius.powi(3)
}

/// The cap of a ball beyond a plane at a distance from its center, from -R to R.
fn cap(radius: f64, distance: f64) -> f64 {
    let height = radius - distance;
    PI * height * height * (radius - height / 3.0)
}

#[test]
fn balls_at_faces_edges_and_corners_of_a_cube_are_cut_in_closed_form() {
    let solid = solid(&cube(1.0));
    // On a face, near its middle, on its diagonal and off it, inside and outside by a distance.
    for (y, z) in [(0.0, 0.0), (0.3, 0.3), (0.2, -0.1)] {
        for distance in [-0.4, -0.25, -1e-9, 0.0, 1e-9, 0.1, 0.45, 0.6] {
            for radius in [0.5_f64, 0.05] {
                let found = solid.volume_in_ball([1.0 + distance, y, z], radius);
                let expected = cap(radius, f64::clamp(distance, -radius, radius));
                assert!((found - expected).abs() < 1e-13, "{distance} from the face, {radius}: {found}, {expected}");
            }
        }
    }
    for (center, share) in
        [([1.0, 1.0, 0.2], 4.0), ([1.0, -1.0, 0.0], 4.0), ([1.0, 1.0, 1.0], 8.0), ([-1.0, 1.0, -1.0], 8.0)]
    {
        let (found, expected) = (solid.volume_in_ball(center, 0.6), ball(0.6) / share);
        assert!((found - expected).abs() < 1e-13, "at {center:?}: {found}, expected {expected}");
    }
    for (center, radius, expected) in [
        ([0.1, 0.0, 0.2], 0.8, ball(0.8)),
        ([0.0, 0.0, 0.0], 1.2, ball(1.2) - 6.0 * cap(1.2, 1.0)),
        ([0.3, -0.2, 0.1], 9.0, 8.0),
        ([5.0, 0.0, 0.0], 3.0, 0.0),
        ([5.0, 0.0, 0.0], f64::INFINITY, 8.0),
        ([0.0, 0.0, 0.0], 0.0, 0.0),
    ] {
        let found = solid.volume_in_ball(center, radius);
        assert!((found - expected).abs() < 1e-12 * (1.0 + expected), "{center:?}, {radius}: {found}, {expected}");
    }
}

#[test]
fn volumes_are_those_that_sampling_finds() {
    const SAMPLES: usize = 60_000;
    // A standard error is at most ½/√60000 = 0.2 % of the ball.
    const ALLOWED: f64 = 5.0 * 0.5 / 245.0;
    let mut random = Random::new(7);
    for (name, triangles) in [("star", star()), ("torus", torus(24, 12))] {
        let solid = solid(&triangles);
        for (center, radius) in
            [([0.8, 0.1, 0.05], 0.4), ([0.1, 0.2, 0.0], 0.5), ([1.3, 0.0, 0.3], 0.5), ([0.0, 0.0, 0.6], 0.9)]
        {
            let mut inside = 0.0;
            for _ in 0..SAMPLES {
                let (direction, distance) = (random.direction(), radius * random.unit().cbrt());
                let w = solid.winding_number([0, 1, 2].map(|k| center[k] + distance * direction[k]));
                assert!((w - w.round()).abs() < 1e-9, "{name} is closed, its winding number is {w}");
                inside += w / SAMPLES as f64;
            }
            let found = solid.volume_in_ball(center, radius) / ball(radius);
            assert!((found - inside).abs() < ALLOWED, "{name}, {center:?}: {found} of the ball, sampled {inside}");
        }
    }
}

/// The integral of the winding number over a ball by sampling, of a surface with a hole.
#[test]
fn volumes_of_open_meshes_are_integrals_of_the_winding_number() {
    const SAMPLES: usize = 60_000;
    let open = cube(1.0)[2..].to_vec();
    let solid = solid(&open);
    assert!(!solid.is_closed(), "a cube without a side");
    let mut random = Random::new(3);
    for (center, radius) in [([0.0, 0.0, 0.0], 0.9), ([-1.0, 0.1, 0.0], 0.7), ([-1.6, 0.0, 0.5], 1.5)] {
        let mut sampled = 0.0;
        for _ in 0..SAMPLES {
            let (direction, distance) = (random.direction(), radius * random.unit().cbrt());
            sampled += solid.winding_number([0, 1, 2].map(|k| center[k] + distance * direction[k])) / SAMPLES as f64;
        }
        let found = solid.volume_in_ball(center, radius) / ball(radius);
        assert!((found - sampled).abs() < 0.01, "{center:?}: {found} of the ball, sampled {sampled}");
    }
}

/// The sum over all triangles of the integral over solid angles, each triangle cut into small ones.
#[test]
fn the_tree_finds_what_a_plain_sum_over_solid_angles_does() {
    let triangles = torus(16, 8);
    let whole = solid(&triangles);
    let mut random = Random::new(5);
    for _ in 0..12 {
        let center: [f64; 3] = std::array::from_fn(|_| 1.4 * random.signed());
        let radius = 0.05 + random.unit();
        let tree = whole.volume_in_ball(center, radius);
        let relative = |t: &Triangle| t.map(|p| [0, 1, 2].map(|k| f64::from(p[k]) - center[k]));
        let plain: f64 = triangles.iter().map(|t| subdivided(relative(t), radius, 0)).sum();
        // Small triangles across the surface of the ball are wrong by their own width times area.
        assert!((tree - plain).abs() < 1e-4, "{center:?}, {radius}: {tree} by the tree, {plain} one by one");
    }
}

/// min(ρ, R)³/3 over the solid angle of a triangle, cut until it is all near or all far or tiny.
fn subdivided([a, b, c]: [[f64; 3]; 3], radius: f64, depth: u32) -> f64 {
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let cross =
        |a: [f64; 3], b: [f64; 3]| [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    let volume = dot(a, cross(b, c));
    let [la, lb, lc] = [a, b, c].map(|p| dot(p, p).sqrt());
    let angle = 2.0 * volume.atan2(la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
    if [la, lb, lc].iter().all(|&l| l <= radius) {
        return volume / 6.0;
    }
    let edge = |p: [f64; 3], q: [f64; 3]| dot([0, 1, 2].map(|k| p[k] - q[k]), [0, 1, 2].map(|k| p[k] - q[k])).sqrt();
    let longest = edge(a, b).max(edge(b, c)).max(edge(c, a));
    if la.min(lb).min(lc) > radius + longest || depth == 7 {
        return angle * radius.powi(3) / 3.0;
    }
    let middle = |p: [f64; 3], q: [f64; 3]| [0, 1, 2].map(|k| 0.5 * (p[k] + q[k]));
    let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
    [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]].into_iter().map(|t| subdivided(t, radius, depth + 1)).sum()
}

#[test]
fn winding_numbers_of_parts_add_up_to_that_of_the_whole() {
    let triangles = star();
    let (whole, mut random) = (solid(&triangles), Random::new(11));
    for _ in 0..200 {
        let p: [f64; 3] = std::array::from_fn(|_| 1.2 * random.signed());
        let w = whole.winding_number(p);
        assert!(w.abs().min((w - 1.0).abs()) < 1e-12, "at {p:?}: {w}");
    }
    assert!((whole.winding_number([0.0, 0.0, 0.0]) - 1.0).abs() < 1e-12, "inside");
    let face = solid(&cube(1.0)).winding_number([1.0, 0.2, 0.1]);
    assert!((face - 0.5).abs() < 1e-12, "on a face: {face}");
}

#[test]
fn derivatives_are_areas() {
    let solid = solid(&star());
    // Central differences of step h are right to h² and to the rounding over h.
    let h = 1e-5;
    for (center, radius) in [([0.3, 0.1, 0.02], 0.35), ([0.7, 0.0, 0.1], 0.2), ([0.1, 0.9, 0.2], 0.6)] {
        let at = |step: [f64; 3], r: f64| solid.volume_outside([0, 1, 2].map(|k| center[k] + step[k]), radius + r);
        let (by_center, by_radius) = solid.volume_outside_slope(center, radius);
        for k in 0..3 {
            let mut step = [0.0; 3];
            step[k] = h;
            let difference = (at(step, 0.0) - at(step.map(|x| -x), 0.0)) / (2.0 * h);
            assert!((difference - by_center[k]).abs() < 1e-8, "axis {k}: {difference}, {}", by_center[k]);
        }
        let difference = (at([0.0; 3], h) - at([0.0; 3], -h)) / (2.0 * h);
        assert!((difference - by_radius).abs() < 1e-8, "radius: {difference}, {by_radius}");
    }
}

#[test]
fn a_mesh_inside_out_is_turned_over_and_one_without_volume_refused() {
    let inside_out: Vec<Triangle> = cube(1.0).iter().map(|[a, b, c]| [*a, *c, *b]).collect();
    let found = solid(&inside_out).volume_in_ball([1.0, 0.0, 0.0], 0.5);
    assert!((found - ball(0.5) / 2.0).abs() < 1e-13, "half a ball: {found}");
    let message =
        |triangles: &[Triangle]| lobe_shadow::Solid::new(triangles.iter().copied()).err().unwrap().to_string();
    assert_eq!(message(&[]), "expected a mesh with triangles, found none", "empty");
    let flat = message(&cube(1.0)[..2]);
    assert!(flat.starts_with("expected a mesh around a volume, found one of volume 0"), "{flat}");
    let bad = message(&[[[0.0, 0.0, f32::NAN]; 3]]);
    assert!(bad.starts_with("expected finite corners, found ") && !bad.contains('\n'), "{bad}");
}
