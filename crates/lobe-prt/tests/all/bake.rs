//! Baked transfer against closed forms.

use std::f64::consts::PI;
use std::ops::ControlFlow;

use crate::common::{baked, cone_transfer, is_gray, largest_difference, options, receiver, revolved, scene_of};
use lobe_io::Job;
use lobe_prt::{BakeMode, BakeOptions, Channels, PrtError, Receivers, bake, bake_vertices};
use lobe_scene::{Bounds, Bvh, Material, Mesh, MeshParts, Ray, Scene, built_in};
use lobe_sh::{Dir, Expansion as _, Zonal};
use lobe_testkit::{directions, fibonacci_sphere};

/// y₀, the constant coefficient of a receiver that sends back all light.
fn y_0() -> f64 {
    0.5 / PI.sqrt()
}

/// A scene so far away and small that it shadows nothing, on both sides of its origin.
fn nothing_in_the_way() -> Scene {
    let triangles = [-1000.0, 1000.0].map(|z| [[0.0, 0.0, z], [1e-3, 0.0, z], [0.0, 1e-3, z]]).concat();
    scene_of(triangles, vec![[0, 1, 2], [3, 4, 5]], 0.5, true)
}

/// Receivers towards all directions, in three albedos.
fn receivers_everywhere() -> Receivers {
    let normals: Vec<_> = directions().into_iter().step_by(5).map(|n| n.map(|c| c as f32)).collect();
    let count = normals.len();
    Receivers::new(vec![[0.0; 3]; count], normals, vec![[1.0, 0.5, 0.25]; count]).unwrap()
}

/// The clamped cosine about the normal of every receiver, for an albedo of 1.
fn closed_form(receivers: &Receivers, order: usize) -> Vec<Vec<f64>> {
    let turned = |n: &[f32; 3]| {
        let axis = Dir::from_f32(*n).unwrap();
        Zonal::clamped_cosine(order).towards(axis, 1.0 / PI).coefficients().to_vec()
    };
    receivers.normals().iter().map(turned).collect()
}

#[test]
fn unshadowed_transfer_is_the_clamped_cosine_about_the_normal() {
    let receivers = receivers_everywhere();
    let scene = built_in::closed_white_box(1);
    let (transfer, report) = baked(&scene, &receivers, &options(BakeMode::Unshadowed, 8, 1));
    for (r, expected) in closed_form(&receivers, 8).iter().enumerate() {
        for (c, albedo) in [1.0, 0.5, 0.25].into_iter().enumerate() {
            let expected: Vec<f64> = expected.iter().map(|t| albedo * t).collect();
            let difference = largest_difference(transfer.vector(r, c), &expected);
            assert!(difference < 1e-7, "receiver {r}, channel {c}: {difference}");
        }
    }
    assert_eq!((report.rays, report.bounces, report.stderr_dc), (0, 0, 0.0), "nothing is traced");
}

#[test]
fn sampling_with_nothing_in_the_way_agrees_with_the_closed_form_to_1e_3_at_4096_samples() {
    let (receivers, scene) = (receivers_everywhere(), nothing_in_the_way());
    for mode in [BakeMode::Shadowed, BakeMode::Interreflected] {
        let (transfer, report) = baked(&scene, &receivers, &options(mode, 8, 4096));
        let mut worst = 0.0_f64;
        for (r, expected) in closed_form(&receivers, 8).iter().enumerate() {
            worst = worst.max(largest_difference(transfer.vector(r, 0), expected));
        }
        assert!(worst < 1e-3, "{mode:?}: largest difference {worst}");
        assert!(report.stderr_dc < 1e-6, "{mode:?}: every path escapes, standard error {}", report.stderr_dc);
        assert_eq!(report.energy_left, 0.0, "{mode:?}: energy left");
    }
}

#[test]
fn the_middle_of_a_plane_under_a_sphere_has_its_closed_form() {
    // sin a = r/d: the sphere hides the cone of half angle a, and its 256 cells around stay 1.5e-4 inside of it.
    let scene = built_in::ball_over_ground(256);
    let (transfer, report) =
        baked(&scene, &receiver([0.0; 3], [0.0, 0.0, 1.0]), &options(BakeMode::Shadowed, 6, 1 << 14));
    let cosine = (1.0 - (1.0_f64 / 1.5).powi(2)).sqrt();
    let open = &Zonal::clamped_cosine(6) * (1.0 / PI);
    let expected = (&open - &cone_transfer(6, cosine)).towards(Dir::Z, 1.0);
    let difference = largest_difference(transfer.vector(0, 0), expected.coefficients());
    assert!(difference < 1e-3, "largest difference {difference}");
    let visible = f64::from(transfer.vector(0, 0)[0]) / y_0();
    assert!((visible - 5.0 / 9.0).abs() < 1e-3, "visibility {visible}, expected 5/9");
    assert!((report.energy_per_bounce[0] - visible).abs() < 1e-6, "energy {:?}", report.energy_per_bounce);
}

/// The form factor of a regular polygon from the point below its center, by Lambert's formula,
/// `1/2π Σ γ_e n·(p × q)/|p × q|`.
fn regular_polygon(sides: u32, radius: f64, height: f64) -> f64 {
    let half = PI / f64::from(sides);
    let length = radius.hypot(height);
    let gamma = 2.0 * (radius * half.sin() / length).asin();
    // n·(p × q) = r² sin 2h, |p × q| = length² sin γ
    f64::from(sides) / (2.0 * PI) * gamma * radius * radius * (2.0 * half).sin() / (length * length * gamma.sin())
}

#[test]
fn the_bottom_of_a_pit_sees_its_mouth_whatever_its_walls() {
    const SIDES: u32 = 512;
    for (name, radius, depth, profile) in [
        ("cylinder", 1.0, 2.0, vec![(1.0, 0.0), (1.0, 2.0)]),
        ("cone open upwards", 2.0, 1.5, vec![(1e-3, 0.0), (2.0, 1.5)]),
        ("cone that narrows", 0.5, 1.0, vec![(2.0, 0.0), (0.5, 1.0)]),
    ] {
        let pit = revolved(&profile, SIDES, 0.5);
        let (transfer, _) = baked(&pit, &receiver([0.0; 3], [0.0, 0.0, 1.0]), &options(BakeMode::Shadowed, 6, 1 << 14));
        let visible = f64::from(transfer.vector(0, 0)[0]) / y_0();
        let polygon = regular_polygon(SIDES, radius, depth);
        let circle = radius * radius / (radius * radius + depth * depth);
        assert!((polygon / circle - 1.0).abs() < 1e-4, "{name}: polygon {polygon}, circle {circle}");
        assert!((visible - polygon).abs() < 5e-4, "{name}: {visible}, expected {polygon}");
        let cosine = depth / radius.hypot(depth);
        let expected = cone_transfer(6, cosine).towards(Dir::Z, 1.0);
        let difference = largest_difference(transfer.vector(0, 0), expected.coefficients());
        assert!(difference < 1e-3, "{name}: largest difference of a coefficient {difference}");
    }
}

/// The part of an even sky that a matte surface of this normal sees from a place, by a quadrature over all directions.
fn sky_seen(bvh: &Bvh, place: [f32; 3], normal: [f32; 3]) -> f64 {
    let (mut seen, mut all) = (0.0, 0.0);
    for direction in fibonacci_sphere(20_000) {
        let cosine = (0..3).map(|k| direction[k] * f64::from(normal[k])).sum::<f64>().max(0.0);
        all += cosine;
        if !bvh.is_occluded(&Ray::new(place, direction.map(|c| c as f32))) {
            seen += cosine;
        }
    }
    seen / all
}

#[test]
fn backs_at_a_bent_border_see_the_sky_from_inside() {
    const HEIGHT: f32 = 0.1;
    for sides in [4, 5, 6] {
        // A band that faces outwards. Along the plane of a front's normal its border bends away by more than rays are
        // lifted: a back that went along it would be outside.
        let band = revolved(&[(1.0, f64::from(HEIGHT)), (1.0, 0.0)], sides, 1.0);
        let (bvh, backs) = (Bvh::new(&band), Receivers::back_of_vertices(&band).unwrap());
        let (transfer, _) = baked(&band, &backs, &options(BakeMode::Shadowed, 1, 1024));
        // The two sides that meet at a vertex hide what is π/2 - π/n and more about the axis from its normal, a part of
        // 1 - cos π/n. How much of the half beyond the border is seen all the same depends on the place in the corner.
        let allowed = (1.0 - (PI / f64::from(sides)).cos()) / 2.0 + 0.02;
        for (r, (&[x, y, z], &normal)) in backs.positions().iter().zip(backs.normals()).enumerate() {
            // A place that is inside beyond doubt.
            let inside = [0.999 * x, 0.999 * y, z + 0.01 * (HEIGHT / 2.0 - z)];
            let expected = sky_seen(&bvh, inside, normal);
            let visible = f64::from(transfer.vector(r, 0)[0]) / y_0();
            assert!((visible - expected).abs() < allowed, "{sides} sides, vertex {r}: {visible}, not {expected}");
        }
    }
}

#[test]
fn a_closed_white_box_loses_no_light_at_any_bounce_count() {
    let scene = built_in::closed_white_box(3);
    let receivers = Receivers::at_vertices(&scene).unwrap();
    for bounces in [0, 1, 2, 7] {
        let options = options(BakeMode::Interreflected, 2, 64).bounces(bounces);
        let (transfer, report) = baked(&scene, &receivers, &options);
        // No path escapes and none is absorbed: whatever the walls gave off would come back in full.
        assert_eq!(report.energy_left, 1.0, "{bounces} bounces: the part that still travels");
        assert!(transfer.coefficients().iter().all(|&t| t == 0.0), "{bounces} bounces: no light gets in");
        assert!(is_gray(&transfer), "white is gray");
    }
}

#[test]
fn a_white_scene_returns_a_constant_sky_but_for_what_still_travels() {
    let ground = built_in::terrain(24);
    let (mut meshes, mut materials, _) = ground.into_parts();
    materials.iter_mut().for_each(|m| m.base_color = [1.0; 4]);
    let scene = Scene::new(std::mem::take(&mut meshes), materials, vec![]).unwrap();
    let receivers = Receivers::at_vertices(&scene).unwrap();
    let mut before = 0.0;
    for bounces in [0, 1, 4, 12] {
        let options = options(BakeMode::Interreflected, 1, 64).bounces(bounces);
        let (transfer, report) = baked(&scene, &receivers, &options);
        let count = receivers.len() as f64;
        let mean = transfer.coefficients().iter().map(|&t| f64::from(t)).sum::<f64>() / y_0() / count;
        let energy: f64 = report.energy_per_bounce.iter().sum();
        assert!((mean - energy).abs() < 1e-6, "{bounces} bounces: mean {mean}, energy {energy}");
        // Directions below the surface but above the interpolated normal bring nothing: all that is lost.
        let rest = 1.0 - energy - report.energy_left;
        assert!((-1e-9..0.02).contains(&rest), "{bounces} bounces: {energy} + {} is not 1", report.energy_left);
        assert!(energy >= before, "{bounces} bounces: {energy} after {before}");
        before = energy;
    }
    assert!(before > 0.97, "after 12 bounces {before} of a constant sky comes back");
}

#[test]
fn a_sphere_with_a_hole_has_the_closed_form_of_every_bounce() {
    // From each point of a sphere the same part f of a cosine-weighted hemisphere is seen of a cap: its part of the
    // area. T_0 = y_0 ρ f Σ_b (ρ (1-f))^b.
    const RINGS: u32 = 128;
    let (f, rho) = (0.25, 0.8);
    let cap = (1.0_f64 - 2.0 * f).acos();
    let circle = |k: u32| {
        let theta = PI - (PI - cap) * f64::from(k) / f64::from(RINGS);
        (theta.sin().max(1e-6), theta.cos())
    };
    let profile: Vec<_> = (0..=RINGS).map(circle).collect();
    let scene = revolved(&profile, 2 * RINGS, rho as f32);
    let down = receiver([0.0, 0.0, -1.0], [0.0, 0.0, 1.0]);
    let side = receiver([1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]);
    for bounces in [0, 1, 4] {
        let expected: f64 = f * (0..=bounces).map(|b| (rho * (1.0 - f)).powi(b)).sum::<f64>();
        for (name, receivers) in [("bottom", &down), ("side", &side)] {
            let options = options(BakeMode::Interreflected, 2, 1 << 15).bounces(bounces as usize);
            let (transfer, report) = baked(&scene, receivers, &options);
            let found = f64::from(transfer.vector(0, 0)[0]) / y_0();
            let allowed = 1e-3 + 4.0 * report.stderr_dc * found;
            assert!((found - expected).abs() < allowed, "{name}, {bounces} bounces: {found}, expected {expected}");
            for (b, energy) in report.energy_per_bounce.iter().enumerate() {
                let expected = f * (rho * (1.0 - f)).powi(b as i32);
                assert!((energy - expected).abs() < 5e-3, "{name}, bounce {b}: {energy}, expected {expected}");
            }
        }
    }
}

#[test]
fn the_standard_error_is_that_of_independent_bakes() {
    let scene = built_in::cornell_box(8);
    let receivers = Receivers::at_vertices(&scene).unwrap();
    for mode in [BakeMode::Shadowed, BakeMode::Interreflected] {
        let bake = |seed| baked(&scene, &receivers, &options(mode, 1, 64).seed(seed));
        let ((a, report), (b, _)) = (bake(1), bake(2));
        // Half the square of a difference is an estimate of the variance of one.
        let (mut square, mut mean) = (0.0, 0.0);
        let count = a.receivers() as f64;
        for r in 0..a.receivers() {
            let dc = |t: &lobe_prt::Transfer| (0..3).map(|c| f64::from(t.vector(r, c)[0])).sum::<f64>() / 3.0;
            square += (dc(&a) - dc(&b)).powi(2) / 2.0;
            mean += dc(&a);
        }
        let (found, expected) = (report.stderr_dc, (square / count).sqrt() / (mean / count));
        assert!((0.6..1.6).contains(&(found / expected)), "{mode:?}: {found}, measured {expected}");
    }
}

/// A box of which one triangle is missing: the light of little sky comes in.
fn leaking_box() -> Scene {
    let (meshes, materials, textures) = built_in::closed_white_box(3).into_parts();
    let open = meshes.iter().map(|mesh| {
        let parts = MeshParts {
            positions: mesh.positions().to_vec(),
            normals: mesh.normals().to_vec(),
            triangles: mesh.triangles()[1..].to_vec(),
            ..MeshParts::default()
        };
        Mesh::new(parts).unwrap()
    });
    Scene::new(open.collect(), materials, textures).unwrap()
}

#[test]
fn where_noise_asks_for_more_paths_the_bake_is_that_of_so_many() {
    let left_open = || BakeOptions::default().mode(BakeMode::Shadowed).order(2);
    for (scene, expected) in [(leaking_box(), 4096), (built_in::ball_over_ground(6), 1024)] {
        let receivers = Receivers::at_vertices(&scene).unwrap();
        let (found, report) = baked(&scene, &receivers, &left_open());
        assert_eq!(report.samples, expected, "paths");
        let (asked, _) = baked(&scene, &receivers, &left_open().samples(expected));
        assert!(found == asked, "{expected} paths that were asked for give another transfer");
        let fit = |options: &BakeOptions| bake_vertices(&scene, &Bvh::new(&scene), options, Job::default()).unwrap();
        let (found, report) = fit(&left_open());
        assert_eq!(report.samples, expected, "paths of a fit");
        assert!(found == fit(&left_open().samples(expected)).0, "a fit of {expected} paths that were asked for");
    }
}

#[test]
fn shadows_only_take_and_bounces_only_give() {
    let scene = built_in::ball_over_ground(16);
    let receivers = Receivers::at_vertices(&scene).unwrap();
    let dc = |mode| {
        let transfer = baked(&scene, &receivers, &options(mode, 1, 256)).0;
        (0..receivers.len()).map(|r| transfer.vector(r, 0)[0]).collect::<Vec<_>>()
    };
    let (open, shadowed, bounced) = (dc(BakeMode::Unshadowed), dc(BakeMode::Shadowed), dc(BakeMode::Interreflected));
    for r in 0..receivers.len() {
        let (u, s, i) = (open[r], shadowed[r], bounced[r]);
        assert!(s <= u * (1.0 + 1e-6) && s <= i * (1.0 + 1e-6), "receiver {r}: {u}, shadowed {s}, with bounces {i}");
    }
}

#[test]
fn no_bounce_is_shadowed_transfer_by_another_route() {
    let scene = built_in::ball_over_ground(16);
    let receivers = Receivers::at_vertices(&scene).unwrap();
    let shadowed = baked(&scene, &receivers, &options(BakeMode::Shadowed, 4, 128)).0;
    let none = options(BakeMode::Interreflected, 4, 128).bounces(0);
    let (followed, report) = baked(&scene, &receivers, &none);
    let expected: Vec<f64> = shadowed.coefficients().iter().map(|&t| f64::from(t)).collect();
    let difference = largest_difference(followed.coefficients(), &expected);
    assert!(difference < 1e-6, "largest difference {difference}");
    assert_eq!(report.bounces, 0, "bounces");
}

#[test]
fn back_sides_reflect_only_where_the_material_is_double_sided() {
    // A receiver looks up at the back of a large square 1 above, lit from above only at its front; light from the side
    // reaches the back over a white ground below both.
    let quad = |z: f32, r: f32| [[-r, -r, z], [r, -r, z], [r, r, z], [-r, r, z]];
    let scene = |double_sided| {
        let positions = [quad(1.0, 2.0), quad(0.0, 50.0)].concat();
        scene_of(positions, vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]], 0.8, double_sided)
    };
    let receiver = receiver([0.0; 3], [0.0, 0.0, 1.0]);
    let energy = |double_sided| {
        let options = options(BakeMode::Interreflected, 1, 4096).bounces(2);
        baked(&scene(double_sided), &receiver, &options).1.energy_per_bounce
    };
    let (one, two) = (energy(false), energy(true));
    assert_eq!(one[0], two[0], "direct light");
    assert_eq!(one[1..], [0.0, 0.0], "the black back sends nothing on");
    assert!(two[2] > 0.02, "ground, back of the square, receiver: {two:?}");
}

#[test]
fn light_takes_the_color_of_what_it_met() {
    let scene = built_in::cornell_box(8);
    let white = receiver([-0.9, 0.0, 0.0], [0.0, 0.0, 1.0]);
    let (transfer, _) = baked(&scene, &white, &options(BakeMode::Interreflected, 2, 4096));
    assert_eq!(transfer.channels(), Channels::Rgb, "a scene with hues");
    let dc = |c| transfer.vector(0, c)[0];
    assert!(dc(0) > 1.05 * dc(1), "beside the red wall: {} red, {} green", dc(0), dc(1));
    let (shadowed, _) = baked(&scene, &white, &options(BakeMode::Shadowed, 2, 64));
    assert!(is_gray(&shadowed), "a white receiver without bounces");
    let rgb = options(BakeMode::Shadowed, 2, 64).channels(Some(Channels::Rgb));
    let (all, _) = baked(&scene, &white, &rgb);
    (0..3).for_each(|c| assert_eq!(all.vector(0, c), shadowed.vector(0, 0), "channel {c}"));
}

#[test]
fn coefficients_do_not_depend_on_the_number_of_threads() {
    let scene = built_in::cornell_box(8);
    let receivers = Receivers::at_vertices(&scene).unwrap();
    let bake = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| baked(&scene, &receivers, &options(BakeMode::Interreflected, 3, 16)))
    };
    let (one, two, five) = (bake(1), bake(2), bake(5));
    assert!(one.0 == two.0 && one.0 == five.0, "transfer of 1, 2 and 5 threads");
    let timeless = |report: &lobe_prt::BakeReport| {
        let mut report = report.clone();
        report.seconds = 0.0;
        report
    };
    assert_eq!(timeless(&one.1), timeless(&two.1), "reports of 1 and 2 threads");
    assert_eq!(timeless(&one.1), timeless(&five.1), "reports of 1 and 5 threads");
}

#[test]
fn bounces_are_kept_where_the_receivers_looked_at_see_no_light() {
    // Light reaches the last 6 of some 500 receivers alone: two walls outside of a closed box.
    let mut meshes = built_in::closed_white_box(8).meshes().to_vec();
    let walls = MeshParts {
        positions: vec![
            [5.0, -1.0, 0.0],
            [5.0, 1.0, 0.0],
            [5.0, -1.0, 2.0],
            [5.0, 1.0, 2.0],
            [7.0, -1.0, 0.0],
            [7.0, 1.0, 0.0],
        ],
        triangles: vec![[0, 1, 2], [1, 3, 2], [0, 4, 1], [1, 4, 5]],
        ..MeshParts::default()
    };
    meshes.push(Mesh::new(walls).unwrap());
    let scene = Scene::new(meshes, vec![Material::WHITE], vec![]).unwrap();
    let options = options(BakeMode::Interreflected, 1, 64).energy_stop(1e-3);
    let (_, report) = baked(&scene, &Receivers::at_vertices(&scene).unwrap(), &options);
    assert!(report.receivers > 64 * 6, "few enough see light: {report:?}");
    assert_eq!(report.bounces, 3, "{report:?}");
    assert!(report.energy_per_bounce[1] > 0.01 * report.energy_per_bounce[0], "{report:?}");
}

#[test]
fn bounces_without_energy_are_left_out() {
    let scene = built_in::ball_over_ground(16);
    let receivers = Receivers::at_vertices(&scene).unwrap();
    let bounces = |energy_stop| {
        let options = options(BakeMode::Interreflected, 1, 64).energy_stop(energy_stop).bounces(6);
        baked(&scene, &receivers, &options).1
    };
    let (all, some) = (bounces(0.0), bounces(0.02));
    assert_eq!((all.bounces, all.energy_per_bounce.len()), (6, 7), "all");
    let sum: f64 = all.energy_per_bounce.iter().sum();
    let expected = all.energy_per_bounce.iter().rposition(|e| *e >= 0.02 * sum).unwrap();
    assert_eq!(some.bounces, expected, "of {:?}", all.energy_per_bounce);
    assert!(some.bounces < 6 && some.energy_per_bounce.len() == some.bounces + 1, "{some:?}");
}

#[test]
fn a_bake_can_be_watched_and_stopped() {
    let scene = built_in::ball_over_ground(16);
    let (receivers, bvh) = (Receivers::at_vertices(&scene).unwrap(), Bvh::new(&scene));
    let options = options(BakeMode::Shadowed, 1, 1 << 14);
    let mut seen = Vec::new();
    let mut watch = |p: &lobe_io::Progress| {
        seen.push(*p);
        ControlFlow::Continue(())
    };
    bake(&scene, &bvh, &receivers, &options, Job::default().watched_by(&mut watch)).unwrap();
    let (first, last) = (seen[0], seen[seen.len() - 1]);
    assert_eq!((first.done, first.rays, first.seconds_left()), (0, 0, None), "at first");
    assert_eq!((last.done, last.seconds_left()), (receivers.len(), Some(0.0)), "at last");
    assert_eq!(last.rays, (1 << 14) * receivers.len() as u64, "rays");
    assert!(seen.len() > 2 && last.rays_per_second() > 0.0, "{} reports", seen.len());
    let stopped = bake(&scene, &bvh, &receivers, &options, Job::default().watched_by(&mut |_| ControlFlow::Break(())));
    assert!(matches!(stopped, Err(PrtError::Cancelled)), "stopped: {stopped:?}");
}

#[test]
fn light_from_a_ceiling_of_bent_normals_is_what_its_tilt_leaves() {
    // The part that the ceiling covers of what a point sees 1 below the middle of a square of side 4, weighted by the
    // cosine.
    let side = 2.0 / 5.0_f64.sqrt();
    let covered = 4.0 / PI * side * side.atan();
    for degrees in [0.0_f64, 30.0, 60.0] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let parts = MeshParts {
            positions: vec![[-2.0, -2.0, 1.0], [2.0, -2.0, 1.0], [2.0, 2.0, 1.0], [-2.0, 2.0, 1.0]],
            triangles: vec![[0, 2, 1], [0, 3, 2]],
            normals: vec![[sin as f32, 0.0, -cos as f32]; 4],
            material: Some(0),
            ..MeshParts::default()
        };
        let ceiling = Scene::new(vec![Mesh::new(parts).unwrap()], vec![Material::matte("gray", [0.5; 3])], vec![]);
        let (scene, receiver) = (ceiling.unwrap(), receiver([0.0; 3], [0.0, 0.0, 1.0]));
        for (order, bounces) in [(1, 0), (1, 1), (2, 1), (3, 3)] {
            let options = options(BakeMode::Interreflected, order, 1 << 14).bounces(bounces);
            let (transfer, _) = baked(&scene, &receiver, &options);
            // A cosine lobe that is cut by a plane tilted by δ keeps (1 + cos δ)/2.
            let reflected = if bounces > 0 { 0.5 * (1.0 + cos) / 2.0 } else { 0.0 };
            let expected = 1.0 - covered + covered * reflected;
            let found = f64::from(transfer.vector(0, 0)[0]) * (4.0 * PI).sqrt();
            // Five standard deviations of 2^14 paths that are lost by chance, of a Sobol sequence still fewer.
            let text = format!("{degrees}°, order {order}, {bounces} bounces: {found}, not {expected}");
            assert!((found - expected).abs() < 0.015, "{text}");
        }
    }
}

#[test]
fn options_out_of_range_are_refused_in_one_line() {
    let scene = built_in::closed_white_box(1);
    let (receivers, bvh) = (Receivers::at_vertices(&scene).unwrap(), Bvh::new(&scene));
    let good = options(BakeMode::Shadowed, 1, 1);
    let refusal =
        |options: BakeOptions| bake(&scene, &bvh, &receivers, &options, Job::default()).unwrap_err().to_string();
    let cases = [
        (refusal(good.clone().order(9)), "expected an order of 1 to 8, found 9"),
        (refusal(good.clone().samples(0)), "expected 1 to 2^24 samples, found 0"),
        (refusal(good.clone().bounces(256)), "expected at most 255 bounces, found 256"),
        (refusal(good.clone().energy_stop(f64::NAN)), "expected an energy to stop at in [0, 1), found NaN"),
    ];
    for (found, expected) in cases {
        assert_eq!(found, expected, "refusal");
    }
    let other = Bvh::from_corners(&[]);
    let found = bake(&scene, &other, &receivers, &good, Job::default()).unwrap_err().to_string();
    assert_eq!(found, "expected the tree of the scene's 12 triangles, found one of 0", "tree");
}

#[test]
fn transfer_does_not_depend_on_where_a_scene_is() {
    // On a grid that `f32` still has at the far place, about the middle of the scene.
    let grid = |x: f32, middle: f32| (x * 32.0).round() / 32.0 - middle;
    let scene = built_in::columns_hall(1);
    let at = |place: [f32; 3], middle: [f32; 3]| {
        let (meshes, materials, textures) = scene.clone().into_parts();
        let moved = |mesh: Mesh| {
            let mut parts = mesh.into_parts();
            parts.positions.iter_mut().for_each(|p| *p = [0, 1, 2].map(|k| place[k] + grid(p[k], middle[k])));
            Mesh::new(parts).unwrap()
        };
        Scene::new(meshes.into_iter().map(moved).collect(), materials, textures).unwrap()
    };
    let Bounds { min, max } = at([0.0; 3], [0.0; 3]).bounds();
    let middle = [0, 1, 2].map(|k| 0.5 * (min[k] + max[k]));
    let transfer = |scene: &Scene| {
        let receivers = Receivers::at_vertices(scene).unwrap();
        baked(scene, &receivers, &options(BakeMode::Interreflected, 2, 16)).0
    };
    let here = transfer(&at([0.0; 3], middle));
    let far = at([1e5, -1e5, 1e5], middle);
    assert!(far.origin() == [1e5, -1e5, 1e5], "its place: {:?}", far.origin());
    assert!(transfer(&far) == here, "1e5 units away");
}
