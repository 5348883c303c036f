//! Shading normals that are bent off their triangles, and colored glass: paths against closed forms under a white sky.

use lobe_env::EnvMap;
use lobe_render::{DistantLight, LightStrategy, PathOptions, PathReceiver, PathTracer, SampleCount};
use lobe_scene::{Bvh, Material, Mesh, MeshParts, Scene};
use lobe_sh::{Coefficient as _, Rgb};

const STRATEGIES: [LightStrategy; 3] =
    [LightStrategy::MultipleImportance, LightStrategy::Bsdf, LightStrategy::NextEvent];

fn sky() -> DistantLight {
    DistantLight::from_map(EnvMap::from_fn(16, 8, |_| Rgb::splat(1.0)))
}

/// A square of this half side at a height, which faces down, with this normal at all vertices.
fn ceiling(half: f32, height: f32, normal: [f32; 3], material: Material) -> Scene {
    let corners = [[-half, -half], [half, -half], [half, half], [-half, half]];
    let parts = MeshParts {
        positions: corners.iter().map(|&[x, y]| [x, y, height]).collect(),
        triangles: vec![[0, 2, 1], [0, 3, 2]],
        normals: vec![normal; 4],
        material: Some(0),
        ..MeshParts::default()
    };
    Scene::new(vec![Mesh::new(parts).unwrap()], vec![material], vec![]).unwrap()
}

/// What leaves a point at the origin that faces up, with its standard error.
fn exit_radiance(scene: &Scene, options: PathOptions, albedo: f32, paths: usize) -> [(f64, f64); 3] {
    let (bvh, light, up) = (Bvh::new(scene), sky(), [0.0, 0.0, 1.0]);
    let tracer = PathTracer::new(scene, &bvh, &light, options);
    let receiver = PathReceiver { position: [0.0; 3], normal: up, lift: up, albedo: Rgb::splat(albedo), planes: &[] };
    let found = tracer.radiance_at(&receiver, 0, &SampleCount::of(paths));
    let (mean, variance) = (found.mean.to_array(), found.variance.to_array());
    [0, 1, 2].map(|c| (mean[c], variance[c].sqrt()))
}

/// The part of what a point that faces up sees that is a square of half side `x` above it, at height 1, weighted by the cosine.
fn form_factor(x: f64) -> f64 {
    let side = x / (1.0 + x * x).sqrt();
    4.0 / std::f64::consts::PI * side * side.atan()
}

#[test]
fn light_from_a_ceiling_of_bent_normals_is_what_its_tilt_leaves_whoever_sees_it() {
    let seen = form_factor(2.0);
    for degrees in [0.0_f64, 30.0, 60.0] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let scene = ceiling(2.0, 1.0, [sin as f32, 0.0, -cos as f32], Material::matte("gray", [0.5; 3]));
        for (bounces, strategy) in [0, 1, 3].into_iter().flat_map(|bounces| STRATEGIES.map(|s| (bounces, s))) {
            // A cosine lobe that is cut by a plane tilted by δ keeps (1 + cos δ)/2.
            let reflected = if bounces > 0 { 0.5 * (1.0 + cos) / 2.0 } else { 0.0 };
            let expected = 0.8 * (1.0 - seen) + 0.8 * seen * reflected;
            let options = PathOptions::default().bounces(bounces).strategy(strategy);
            let [(found, error), ..] = exit_radiance(&scene, options, 0.8, 1 << 14);
            // Five standard errors, and the rounding where there is nothing by chance.
            let most = 5.0 * error + 1e-6;
            let text = format!("{degrees}°, {bounces} bounces, {strategy:?}: {found} ± {error}, not {expected}");
            assert!((found - expected).abs() < most && error < 0.01, "{text}");
        }
    }
}

#[test]
fn light_through_colored_glass_has_its_color_by_every_strategy() {
    let color = [0.5, 0.25, 0.75];
    let glass = Material { transmission: 1.0, straight_through: true, ..Material::matte("glass", color) };
    let scene = ceiling(2.0, 1.0, [0.0, 0.0, -1.0], glass);
    let covered = form_factor(2.0);
    for (bounces, strategy) in [0, 2].into_iter().flat_map(|bounces| STRATEGIES.map(|s| (bounces, s))) {
        let options = PathOptions::default().bounces(bounces).strategy(strategy);
        let found = exit_radiance(&scene, options, 1.0, 1 << 14);
        for (c, (found, error)) in found.into_iter().enumerate() {
            let expected = 1.0 - covered * (1.0 - f64::from(color[c]));
            let text = format!("{bounces} bounces, {strategy:?}, channel {c}: {found} ± {error}, not {expected}");
            assert!((found - expected).abs() < 5.0 * error + 1e-6 && error < 0.02, "{text}");
        }
    }
}
