//! One bounce of light from spheres, against rays.

use std::f64::consts::PI;

use lobe_sh::sphere::SphereQuadrature;
use lobe_sh::{Coefficient as _, Dir, Expansion as _, Rgb, ShL1, ShVec, eval_basis};
use lobe_shadow::{LogTable, LogTableOptions, Occluder, ShadowOptions, ShadowReceivers, SkyLight, SphereShadows};
use lobe_testkit::Random;

const ALBEDO: f64 = 0.7;

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| a[k] * b[k]).sum()
}

/// The nearest sphere along a ray, and how far.
fn hit(spheres: &[Occluder], p: [f64; 3], s: [f64; 3]) -> Option<(usize, f64)> {
    let distance = |sphere: &Occluder| {
        let to = [0, 1, 2].map(|k| f64::from(sphere.center[k]) - p[k]);
        let (along, r) = (dot(to, s), f64::from(sphere.radius));
        let root = along * along - dot(to, to) + r * r;
        let t = along - root.max(0.0).sqrt();
        (root > 0.0 && t > 1e-6).then_some(t)
    };
    let hits = spheres.iter().enumerate().filter_map(|(k, sphere)| distance(sphere).map(|t| (k, t)));
    hits.min_by(|a, b| a.1.total_cmp(&b.1))
}

/// Irradiance past the spheres, and that with one bounce, by rays in all directions of a rule.
fn traced(spheres: &[Occluder], sky: &ShVec<f64>, p: [f64; 3], n: [f64; 3], rule: &SphereQuadrature) -> [f64; 2] {
    let mut out = [0.0; 2];
    for (s, weight) in rule.points() {
        let cosine = weight * dot(n, s.to_array());
        if cosine <= 0.0 {
            continue;
        }
        match hit(spheres, p, s.to_array()) {
            None => out.iter_mut().for_each(|out| *out += cosine * sky.eval(s)),
            Some((k, t)) => {
                let there = [0, 1, 2].map(|c| p[c] + t * s.to_array()[c]);
                let normal =
                    [0, 1, 2].map(|c| (there[c] - f64::from(spheres[k].center[c])) / f64::from(spheres[k].radius));
                let coarse = SphereQuadrature::of_degree(24);
                let arriving: f64 = coarse
                    .points()
                    .filter(|(s, _)| dot(normal, s.to_array()) > 0.0 && hit(spheres, there, s.to_array()).is_none())
                    .map(|(s, weight)| weight * dot(normal, s.to_array()) * sky.eval(s))
                    .sum();
                out[1] += cosine * ALBEDO / PI * arriving;
            }
        }
    }
    out
}

#[test]
fn a_bounce_brings_irradiance_nearer_to_the_traced_truth() {
    let mut random = Random::new(1);
    let sky = ShL1::constant(1.0) + ShL1::impulse(Dir::Z, 0.6);
    let sky = ShVec::from_vec(sky.coefficients().to_vec()).unwrap();
    let light = sky.map(|c: f64| Rgb::splat(c as f32));
    let table = LogTable::new(&LogTableOptions::default().order(4).tolerance(0.05)).unwrap();
    let light = SkyLight::new(&light, 4).unwrap();
    let rule = SphereQuadrature::of_degree(60);
    let (mut without, mut with, mut exact) = (0.0, 0.0, 0.0);
    for _ in 0..4 {
        let sphere = |random: &mut Random| {
            let [x, y, z] = [0, 1, 2].map(|_| random.signed() as f32);
            Occluder::new([1.5 * x, 1.5 * y, 1.3 + 0.4 * z], 0.3 + 0.4 * random.unit() as f32)
        };
        let spheres: Vec<Occluder> = (0..4).map(|_| sphere(&mut random)).collect();
        let shadows = SphereShadows::new(&table, &spheres, &ShadowOptions::default().cut(0.0)).unwrap();
        let bounce = shadows.bounce(&light, &[Rgb::splat(ALBEDO as f32); 4]).unwrap();
        let positions: Vec<[f32; 3]> =
            (0..6).map(|_| [1.5 * random.signed() as f32, 1.5 * random.signed() as f32, 0.0]).collect();
        let normals = vec![[0.0, 0.0, 1.0]; 6];
        let receivers = ShadowReceivers::new(&positions, &normals).unwrap();
        let dark = shadows.irradiance(&receivers, &light).unwrap();
        let sent_on = shadows.reflected_irradiance(&receivers, &light, &bounce).unwrap();
        for k in 0..6 {
            let [direct, truth] = traced(&spheres, &sky, positions[k].map(f64::from), [0.0, 0.0, 1.0], &rule);
            without += (f64::from(dark[k].g) - truth).powi(2);
            with += (f64::from(dark[k].g + sent_on[k].g) - truth).powi(2);
            exact += (direct - truth).powi(2);
        }
    }
    println!("sums of squares over 24 receivers: {without:.3} {with:.3}, exact direct light {exact:.3}");
    assert!(with < 0.5 * without, "with a bounce {with}, without {without}");
}

#[test]
fn a_white_sphere_under_a_white_sky_is_not_seen() {
    // Of albedo 1, and with nothing else there, it sends on what it hides.
    let table = LogTable::new(&LogTableOptions::default().order(3).tolerance(0.05)).unwrap();
    let sky = SkyLight::new(&ShL1::constant(Rgb::splat(1.0)), 3).unwrap();
    let spheres = [Occluder::new([0.5, 0.0, 2.0], 0.8)];
    let shadows = SphereShadows::new(&table, &spheres, &ShadowOptions::default()).unwrap();
    let bounce = shadows.bounce(&sky, &[Rgb::splat(1.0)]).unwrap();
    let (at, normal) = ([[0.0; 3]], [[0.0, 0.0, 1.0]]);
    let receivers = ShadowReceivers::new(&at, &normal).unwrap();
    let found = shadows.irradiance(&receivers, &sky).unwrap()[0].g
        + shadows.reflected_irradiance(&receivers, &sky, &bounce).unwrap()[0].g;
    assert!((f64::from(found) / PI - 1.0).abs() < 0.05, "{found} against pi");
    let message = shadows.bounce(&sky, &[]).unwrap_err().to_string();
    assert!(message.contains("expected one for every sphere, found 0"), "{message}");
    let message = shadows.bounce(&sky, &[Rgb::splat(1.5)]).unwrap_err().to_string();
    assert!(message.contains("from 0 to 1"), "{message}");
}

/// The mean radiance over the disc of a sphere of albedo 1, as seen from the direction `v`, under light `sky` of three bands: `E(n)/π` of the
/// half of it that is seen, by quadrature.
fn seen_from(v: Dir, sky: &ShVec<f64>, rule: &SphereQuadrature) -> f64 {
    let cosine = |n: Dir, s: Dir| dot(n.to_array(), s.to_array()).max(0.0);
    // A hundredth of the directions of the sky is enough for three bands and the cosine between.
    let coarse = SphereQuadrature::of_degree(40);
    let radiance = |n: Dir| coarse.integrate(|s| cosine(n, s) * sky.eval(s)) / PI;
    rule.integrate(|n| if cosine(n, v) > 0.0 { cosine(n, v) * radiance(n) } else { 0.0 }) / PI
}

#[test]
fn a_sphere_sends_on_the_light_of_the_side_that_the_receiver_sees() {
    let table = LogTable::new(&LogTableOptions::default().order(3).tolerance(0.05)).unwrap();
    let spheres = [Occluder::new([0.6, -0.4, 1.5], 0.3)];
    let shadows = SphereShadows::new(&table, &spheres, &ShadowOptions::default()).unwrap();
    let (at, normal) = ([[0.0; 3]], [[0.0, 0.0, 1.0]]);
    let receivers = ShadowReceivers::new(&at, &normal).unwrap();
    let sent_on = |sky: &ShVec<f64>| {
        let sky = SkyLight::new(&sky.map(|c| Rgb::splat(c as f32)), 3).unwrap();
        let bounce = shadows.bounce(&sky, &[Rgb::splat(1.0)]).unwrap();
        f64::from(shadows.reflected_irradiance(&receivers, &sky, &bounce).unwrap()[0].g)
    };
    let to_receiver = Dir::new([-0.6, 0.4, -1.5]).unwrap();
    let rule = SphereQuadrature::of_degree(40);
    // What it hides is sent on where all is white, so that this is the solid angle by the cosine.
    let white = sent_on(&ShVec::constant(3, 1.0));
    for d in [Dir::X, -Dir::X, Dir::Y, -Dir::Y, Dir::Z, -Dir::Z, to_receiver, -to_receiver] {
        let mut sky = ShVec::zero(3);
        sky.coefficients_mut().copy_from_slice(&eval_basis(d, 3));
        let expected = seen_from(to_receiver, &sky, &rule);
        let found = sent_on(&sky) / white;
        // The rule is not exact where the cosine ends.
        assert!((found - expected).abs() < 1e-3, "light from {d:?}: {found}, expected {expected}");
    }
}

#[test]
fn a_bounce_of_other_spheres_is_refused() {
    let table = LogTable::new(&LogTableOptions::default().order(3).tolerance(0.05)).unwrap();
    let sky = SkyLight::new(&ShL1::constant(Rgb::splat(1.0)), 3).unwrap();
    let spheres = [Occluder::new([0.5, 0.0, 2.0], 0.8), Occluder::new([-0.5, 0.0, 2.0], 0.2)];
    let of = |spheres: &[Occluder]| SphereShadows::new(&table, spheres, &ShadowOptions::default()).unwrap();
    let bounce = of(&spheres[..1]).bounce(&sky, &[Rgb::splat(1.0)]).unwrap();
    let (at, normal) = ([[0.0; 3]], [[0.0, 0.0, 1.0]]);
    let receivers = ShadowReceivers::new(&at, &normal).unwrap();
    let message = of(&spheres).reflected_irradiance(&receivers, &sky, &bounce).unwrap_err().to_string();
    assert!(message.contains("expected a bounce of these spheres"), "{message}");
}
