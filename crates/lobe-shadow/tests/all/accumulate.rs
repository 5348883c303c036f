//! Receivers under a sky that spheres hide.

use std::f32::consts::PI;

use lobe_sh::basis::coefficient_count;
use lobe_sh::exponential::Exponential;
use lobe_sh::sphere::SphereQuadrature;
use lobe_sh::{Coefficient as _, Dir, Expansion as _, Rgb, ShL2, ShVec, Zonal, eval_basis};
use lobe_shadow::{
    LogTable, LogTableOptions, Occluder, ShadowOptions, ShadowReceivers, SkyLight, SphereShadows, SphereTree,
};
use lobe_testkit::Random;

const UP: [f32; 3] = [0.0, 0.0, 1.0];

/// As the test of the same name in `lobe-sh`.
const BRIGHTENS: f32 = 4e-3;

fn table(order: usize) -> LogTable {
    LogTable::new(&LogTableOptions::default().order(order).tolerance(0.05)).unwrap()
}

/// Every sphere by itself, as published.
fn one_by_one() -> ShadowOptions {
    ShadowOptions::default().cut(0.0).share_overlaps(false)
}

fn white(order: usize) -> SkyLight {
    SkyLight::new(&ShL2::constant(Rgb::new(1.0, 1.0, 1.0)), order).unwrap()
}

/// Spheres in a box above the ground.
fn above_ground(count: usize, random: &mut Random) -> Vec<Occluder> {
    let sphere = |random: &mut Random| {
        let [x, y, z] = [0, 1, 2].map(|_| random.unit() as f32);
        Occluder::new([8.0 * x - 4.0, 8.0 * y - 4.0, 1.0 + 3.0 * z], 0.1 + 0.4 * random.unit() as f32)
    };
    (0..count).map(|_| sphere(random)).collect()
}

fn on_ground(count: usize, random: &mut Random) -> Vec<[f32; 3]> {
    (0..count).map(|_| [0, 1].map(|_| 6.0 * random.unit() as f32 - 3.0)).map(|[x, y]| [x, y, 0.0]).collect()
}

fn irradiance(table: &LogTable, spheres: &[Occluder], at: [f32; 3], normal: [f32; 3]) -> f32 {
    let shadows = SphereShadows::new(table, spheres, &one_by_one()).unwrap();
    let (at, normal) = ([at], [normal]);
    shadows.irradiance(&ShadowReceivers::new(&at, &normal).unwrap(), &white(table.order())).unwrap()[0].g / PI
}

#[test]
fn sums_in_lanes_are_those_of_the_scalar_path() {
    let mut random = Random::new(1);
    for order in 1..=8 {
        let table = table(order);
        let (spheres, positions) = (above_ground(20, &mut random), on_ground(19, &mut random));
        let normals = vec![UP; positions.len()];
        let shadows = SphereShadows::new(&table, &spheres, &one_by_one()).unwrap();
        let found = shadows.visibility(&ShadowReceivers::new(&positions, &normals).unwrap());
        let exponential = Exponential::new(order, shadows_method());
        for (p, found) in positions.iter().zip(found.chunks_exact(coefficient_count(order))) {
            let mut f = ShVec::zero(order);
            for sphere in &spheres {
                let to = [0, 1, 2].map(|k| f64::from(sphere.center[k] - p[k]));
                let d = to.iter().map(|c| c * c).sum::<f64>().sqrt();
                f += &table.at((f64::from(sphere.radius) / d).asin()).towards(Dir::new(to).unwrap(), 1.0);
            }
            for (found, expected) in found.iter().zip(exponential.of(&f).coefficients()) {
                assert!((f64::from(*found) - expected).abs() < 3e-5, "order {order}, at {p:?}: {found}, {expected}");
            }
        }
    }
}

fn shadows_method() -> lobe_sh::exponential::ExpMethod {
    ShadowOptions::default().method
}

#[test]
fn nothing_hides_nothing() {
    let table = table(4);
    let mut random = Random::new(2);
    let positions = on_ground(5, &mut random);
    let normals = vec![UP; 5];
    let receivers = ShadowReceivers::new(&positions, &normals).unwrap();
    let points: Vec<Occluder> = positions.iter().map(|p| Occluder::new([p[0], p[1], 1.0], 0.0)).collect();
    let below = [Occluder::new([0.0, 0.0, -2.0], 1.5)];
    for spheres in [&[][..], &points, &below] {
        let shadows = SphereShadows::new(&table, spheres, &ShadowOptions::default()).unwrap();
        for row in shadows.visibility(&receivers).chunks_exact(16) {
            let open = (4.0 * PI).sqrt();
            assert!((row[0] - open).abs() < 1e-5 && row[1..].iter().all(|c| c.abs() < 1e-5), "open sky: {row:?}");
        }
    }
    let none = ShadowReceivers::new(&[], &[]).unwrap();
    assert!(SphereShadows::new(&table, &below, &one_by_one()).unwrap().visibility(&none).is_empty(), "no receivers");
}

#[test]
fn a_sphere_overhead_hides_the_square_of_its_sine() {
    // The cut to the order and the clamp of the logarithm; the largest is found at order 3 just above the surface.
    for (order, bound) in [(3, 0.072), (4, 0.06), (6, 0.04)] {
        let table = table(order);
        let mut worst = 0.0_f32;
        for d in [1.1_f32, 1.5, 2.0, 4.0, 20.0] {
            let found = irradiance(&table, &[Occluder::new([0.0, 0.0, d], 1.0)], [0.0; 3], UP);
            worst = worst.max((found - (1.0 - 1.0 / (d * d))).abs());
        }
        println!("order {order}: {worst:.4} of the open sky");
        assert!(worst < bound, "order {order}: {worst}");
    }
}

#[test]
fn what_hides_is_continuous_through_the_surface_and_the_center() {
    let table = table(4);
    let sphere = [Occluder::new([0.0, 0.0, 0.0], 1.0)];
    let steps = 400;
    let oblique = [0.6, 0.0, 0.8];
    for (name, start, end, normal) in [
        ("in from above, looking up", [0.0, 0.0, 1.5], [0.0, 0.0, -1.5], UP),
        ("past the center", [0.2, 0.1, 1.5], [0.2, 0.1, -1.5], UP),
        ("along the ground", [-2.0, 0.0, -0.3], [2.0, 0.0, -0.3], UP),
        ("oblique", [-1.6, 0.3, 0.2], [1.5, -0.2, 0.1], oblique),
    ] {
        let at = |k: usize| {
            let t = k as f32 / steps as f32;
            let p = [0, 1, 2].map(|axis| start[axis] + t * (end[axis] - start[axis]));
            irradiance(&table, &sphere, p, normal)
        };
        let values: Vec<f32> = (0..=steps).map(at).collect();
        // A square root is steep where a receiver enters the sphere: t^1/2 of a step of 1/130 is 0.09, of which a cone hides
        // the square; the direction turns with it.
        let worst = values.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f32::max);
        assert!(worst < 0.06 && values.iter().all(|v| v.is_finite()), "{name}: {worst}");
    }
    // Outside and looking outward nothing is hidden, at the center three quarters of the cosine.
    let (outside, center) =
        (irradiance(&table, &sphere, [0.0, 0.0, 1.0], UP), irradiance(&table, &sphere, [0.0; 3], UP));
    assert!((outside - 1.0).abs() < 1e-5, "on the surface: {outside}");
    assert!((center - 0.25).abs() < 0.08, "at the center: {center}");
    let inward = irradiance(&table, &sphere, [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]);
    assert!(inward < 0.1, "on the surface and looking in: {inward}");
}

/// Irradiance where the whole sphere counts, whatever is below the plane.
fn unclipped(table: &LogTable, sphere: Occluder) -> f32 {
    let to = sphere.center.map(f64::from);
    let d = to.iter().map(|c| c * c).sum::<f64>().sqrt();
    let f = table.at((f64::from(sphere.radius) / d).min(1.0).asin()).towards(Dir::new(to).unwrap(), 1.0);
    let visibility = Exponential::new(table.order(), shadows_method()).of(&f);
    let visibility: Vec<f32> = visibility.coefficients().iter().map(|v| *v as f32).collect();
    white(table.order()).irradiance(UP, &visibility).g / PI
}

#[test]
fn a_sphere_that_crosses_the_plane_hides_about_what_is_above() {
    let table = table(4);
    let rule = SphereQuadrature::of_degree(160);
    let (mut worst, mut squares) = ([0.0_f64; 2], [0.0_f64; 2]);
    for height in [-0.8, -0.4, 0.0, 0.4, 0.8] {
        for distance in [1.2_f32, 2.0, 3.0] {
            let sphere = Occluder::new([distance, 0.0, height], 1.0);
            let to = sphere.center.map(f64::from);
            let squared: f64 = to.iter().map(|c| c * c).sum();
            let edge = (squared - 1.0).sqrt();
            let hidden = |s: Dir| (0..3).map(|k| to[k] * s.to_array()[k]).sum::<f64>() > edge;
            let open = rule.integrate(|s: Dir| if hidden(s) { 0.0 } else { s.z().max(0.0) }) / std::f64::consts::PI;
            let found = [irradiance(&table, &[sphere], [0.0; 3], UP), unclipped(&table, sphere)];
            for k in 0..2 {
                let error = f64::from(found[k]) - open;
                worst[k] = worst[k].max(error.abs());
                squares[k] += error * error / 15.0;
            }
        }
    }
    println!("by the rule and unclipped: worst {worst:.4?}, mean square {squares:.6?}");
    assert!(worst[0] < 0.045 && squares[0] < 0.6 * squares[1], "{worst:?}, {squares:?}");
}

#[test]
fn one_more_sphere_never_brightens_the_mean_beyond_its_ringing() {
    let table = table(4);
    let mut random = Random::new(3);
    let positions = on_ground(40, &mut random);
    let normals = vec![UP; positions.len()];
    let receivers = ShadowReceivers::new(&positions, &normals).unwrap();
    let spheres = above_ground(30, &mut random);
    let mut before = vec![f32::INFINITY; positions.len()];
    for count in 0..=spheres.len() {
        let shadows = SphereShadows::new(&table, &spheres[..count], &one_by_one()).unwrap();
        let rows = shadows.visibility(&receivers);
        for (before, row) in before.iter_mut().zip(rows.chunks_exact(16)) {
            assert!(row[0] <= *before * (1.0 + BRIGHTENS), "sphere {count}: {} after {before}", row[0]);
            *before = row[0];
        }
    }
}

/// The root mean square difference of two lists, and the mean of the second.
fn difference(a: &[Rgb<f32>], b: &[Rgb<f32>]) -> f32 {
    (a.iter().zip(b).map(|(a, b)| (a.g - b.g).powi(2)).sum::<f32>() / a.len() as f32).sqrt()
}

#[test]
fn the_error_of_cuts_and_groups_falls_with_their_limits() {
    let table = table(4);
    let mut random = Random::new(4);
    // Dense balls of small spheres, as sets that stand for solids.
    let mut spheres = Vec::new();
    for _ in 0..12 {
        let [x, y, z] = [0, 1, 2].map(|_| random.unit() as f32);
        let middle = [8.0 * x - 4.0, 8.0 * y - 4.0, 1.0 + 2.0 * z];
        for _ in 0..32 {
            let s = random.direction();
            let distance = 0.5 * random.unit() as f32;
            spheres.push(Occluder::new([0, 1, 2].map(|k| middle[k] + distance * s[k] as f32), 0.08));
        }
    }
    let positions: Vec<[f32; 3]> = on_ground(2048, &mut random).iter().map(|p| p.map(|c| 0.3 * c)).collect();
    let normals = vec![UP; positions.len()];
    let receivers = ShadowReceivers::new(&positions, &normals).unwrap();
    let sky = white(4);
    let found = |options: ShadowOptions| {
        SphereShadows::new(&table, &spheres, &options).unwrap().irradiance(&receivers, &sky).unwrap()
    };
    let exact = found(one_by_one());
    let cuts = [0.5, 0.2, 0.1].map(|cut| difference(&found(one_by_one().cut(cut)), &exact));
    println!("cut 0.5, 0.2, 0.1: {cuts:?}");
    assert!(cuts.windows(2).all(|pair| pair[1] < pair[0]), "cuts: {cuts:?}");
    assert!(cuts[1] < 0.01 * PI, "the default: {cuts:?}");
    let groups = [0.3, 0.1, 0.05].map(|far| difference(&found(one_by_one().group(64).far(far)), &exact));
    println!("groups of 64, far 0.3, 0.1, 0.05: {groups:?}");
    assert!(groups[0] > groups[1] && groups[1] > groups[2], "groups: {groups:?}");
    assert!(groups[0] < 0.05 * PI && groups[2] < 0.01 * PI, "groups: {groups:?}");
}

#[test]
fn results_do_not_depend_on_threads() {
    let table = table(3);
    let mut random = Random::new(5);
    let (spheres, positions) = (above_ground(50, &mut random), on_ground(333, &mut random));
    let normals = vec![UP; positions.len()];
    let receivers = ShadowReceivers::new(&positions, &normals).unwrap();
    let shadows = SphereShadows::new(&table, &spheres, &ShadowOptions::default().group(32)).unwrap();
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| shadows.visibility(&receivers))
    };
    assert!(with(1) == with(3), "1 and 3 threads");
}

#[test]
fn the_light_operator_is_the_integral() {
    let order = 4;
    let mut random = Random::new(6);
    let light = ShVec::from_vec(
        (0..coefficient_count(3))
            .map(|_| Rgb::new(random.unit() as f32, random.signed() as f32, random.unit() as f32))
            .collect(),
    )
    .unwrap();
    let visibility: Vec<f32> = (0..coefficient_count(order)).map(|_| random.signed() as f32).collect();
    let expansion = ShVec::from_vec(visibility.iter().map(|v| f64::from(*v)).collect()).unwrap();
    let sky = SkyLight::new(&light, order).unwrap();
    let rule = SphereQuadrature::of_degree(300);
    for _ in 0..4 {
        let n = random.direction();
        let found = sky.irradiance(n.map(|c| c as f32), &visibility);
        let light = light.map(|c| Rgb::new(f64::from(c.r), f64::from(c.g), f64::from(c.b)));
        let expected = rule.integrate(|s: Dir| {
            let cosine = (0..3).map(|k| n[k] * s.to_array()[k]).sum::<f64>().max(0.0);
            cosine * light.eval(s).g * expansion.eval(s)
        });
        assert!((f64::from(found.g) - expected).abs() < 1e-3, "{found:?} against {expected}");
    }
}

#[test]
fn the_light_operator_takes_all_bands_of_the_light_that_have_a_part() {
    // Nine bands of the cosine times those of the visibility: all below the sum of both have one.
    let none = SkyLight::new(&ShVec::<Rgb<f32>>::zero(0), 3).unwrap();
    let open: Vec<f32> = eval_basis(Dir::Z, 3).iter().map(|y| *y as f32).collect();
    assert_eq!(none.irradiance(UP, &open), Rgb::new(0.0, 0.0, 0.0), "light of no bands is none");
    for (order, bands) in [(1, 12), (3, 4), (3, 11), (4, 12), (8, 10), (8, 16)] {
        let mut random = Random::new(order as u64);
        let visibility: Vec<f32> = (0..coefficient_count(order)).map(|_| random.signed() as f32).collect();
        let mut light = ShVec::zero(bands);
        light.coefficients_mut().copy_from_slice(&eval_basis(Dir::try_from(random.direction()).unwrap(), bands));
        let sky = SkyLight::new(&light.map(|c: f64| Rgb::splat(c as f32)), order).unwrap();
        let seen = ShVec::from_vec(visibility.iter().map(|v| f64::from(*v)).collect()).unwrap();
        let n = random.direction();
        let cosine = Zonal::clamped_cosine(9).towards(Dir::try_from(n).unwrap(), 1.0);
        let rule = SphereQuadrature::of_degree(8 + order + bands);
        let expected = rule.integrate(|s: Dir| cosine.eval(s) * light.eval(s) * seen.eval(s));
        let found = f64::from(sky.irradiance(n.map(|c| c as f32), &visibility).g);
        let size = (light.dot(&light) * seen.dot(&seen)).sqrt();
        assert!((found - expected).abs() < 1e-6 * size, "order {order}: {found} against {expected}, of {size}");
    }
}

#[test]
fn a_tree_follows_spheres_that_move() {
    let table = table(3);
    let spheres = above_ground(3, &mut Random::new(7));
    let tree = SphereTree::over(&spheres).unwrap();
    let (at, normal) = ([[0.1, 0.2, 0.0]], [UP]);
    let receivers = ShadowReceivers::new(&at, &normal).unwrap();
    let by_tree = SphereShadows::with_tree(&table, tree.clone(), &one_by_one()).unwrap().visibility(&receivers);
    let by_own = SphereShadows::new(&table, &spheres, &one_by_one()).unwrap().visibility(&receivers);
    assert!(by_tree.iter().zip(&by_own).all(|(a, b)| (a - b).abs() < 1e-5), "{by_tree:?} {by_own:?}");
    let moved: Vec<Occluder> = spheres.iter().map(|s| Occluder::new(s.center.map(|c| c + 0.5), s.radius)).collect();
    let mut refit = tree;
    refit.refit(&moved).unwrap();
    let by_tree = SphereShadows::with_tree(&table, refit.clone(), &one_by_one()).unwrap().visibility(&receivers);
    let by_own = SphereShadows::new(&table, &moved, &one_by_one()).unwrap().visibility(&receivers);
    assert!(by_tree.iter().zip(&by_own).all(|(a, b)| (a - b).abs() < 1e-5), "moved: {by_tree:?} {by_own:?}");
    assert!(refit.refit(&spheres[..1]).is_err(), "spheres are missing");
}

#[test]
fn a_tree_follows_spheres_that_come_to_overlap_that_appear_and_that_vanish() {
    let table = table(3);
    let before =
        [Occluder::new([0.0, 0.0, 1.0], 0.3), Occluder::new([2.0, 0.0, 1.0], 0.3), Occluder::new([0.0; 3], 0.0)];
    let tree = SphereTree::over(&before).unwrap();
    let near = Occluder::new([0.2, 0.0, 1.0], 0.3);
    let receivers = ShadowReceivers::new(&[[0.1, 0.2, 0.0]], &[UP]).unwrap();
    for (what, after) in [
        ("moved into another", vec![before[0], near, before[2]]),
        ("grown from nothing", vec![before[0], before[1], near]),
        ("one more", vec![before[0], before[1], before[2], near]),
        ("shrunk to nothing", vec![Occluder::new(before[0].center, 0.0), near, before[2]]),
    ] {
        let mut refit = tree.clone();
        refit.refit(&after).unwrap();
        let options = ShadowOptions::default().cut(0.0);
        let by_tree = SphereShadows::with_tree(&table, refit, &options).unwrap().visibility(&receivers);
        let by_own = SphereShadows::new(&table, &after, &options).unwrap().visibility(&receivers);
        assert!(by_tree.iter().zip(&by_own).all(|(a, b)| (a - b).abs() < 1e-5), "{what}: {by_tree:?} {by_own:?}");
    }
}

#[test]
fn bad_input_is_refused_in_one_line() {
    let table = table(3);
    let light = ShL2::constant(Rgb::new(1.0, f32::NAN, 1.0));
    let nan = Occluder::new([0.0, f32::NAN, 0.0], 1.0);
    let shadows = |spheres: &[Occluder], options: &ShadowOptions| {
        SphereShadows::new(&table, spheres, options).map(drop).unwrap_err().to_string()
    };
    let fine = SphereShadows::new(&table, &[], &one_by_one()).unwrap();
    let receivers = ShadowReceivers::new(&[[0.0; 3]], &[UP]).unwrap();
    for (message, said) in [
        (shadows(&[nan], &one_by_one()), "sphere 0: expected finite centers and radii"),
        (shadows(&[Occluder::new([0.0; 3], -1.0)], &one_by_one()), "radii of 0 or more"),
        (shadows(&[Occluder::new([0.0; 3], f32::INFINITY)], &one_by_one()), "finite centers and radii"),
        (shadows(&[], &one_by_one().group(20)), "a multiple of 16"),
        (shadows(&[], &one_by_one().cut(-1.0)), "cut from 0 to 1"),
        (ShadowReceivers::new(&[[0.0; 3]], &[]).unwrap_err().to_string(), "one normal for each of 1"),
        (ShadowReceivers::new(&[[0.0; 3]], &[[0.0; 3]]).unwrap_err().to_string(), "of length 1"),
        (ShadowReceivers::new(&[[f32::INFINITY; 3]], &[UP]).unwrap_err().to_string(), "no finite number"),
        (SkyLight::new(&light, 3).unwrap_err().to_string(), "expected finite light"),
        (fine.irradiance(&receivers, &white(4)).unwrap_err().to_string(), "expected light for order 3"),
    ] {
        assert!(message.contains(said) && !message.contains('\n'), "{message}");
    }
}
