//! Surfaces with normal maps against closed forms: by irradiance, by paths from the eye, and by paths from texels.

use std::f64::consts::PI;

use lobe_env::EnvMap;
use lobe_image::Picture;
use lobe_io::Job;
use lobe_prt::TexelReceivers;
use lobe_render::{
    Camera, DistantLight, PathOptions, PathReceiver, PathTracer, SampleCount, Truth, TruthOptions, ViewOptions,
    light_by_irradiance, render_truth,
};
use lobe_scene::{Bvh, Material, Mesh, MeshParts, NormalMap, Scene, Texture, TextureUse, Wrap};
use lobe_sh::sphere::vector::normalized;
use lobe_sh::{Dir, Rgb, ShVec};

/// Texels from upright to below the face.
const TEXELS: [[u8; 4]; 4] = [[128, 128, 255, 255], [200, 60, 220, 255], [40, 200, 128, 255], [255, 128, 64, 255]];

/// The most standard errors between a mean and its expectation.
const STANDARD_ERRORS: f64 = 5.0;

/// A white square of side 2 that faces up, x along u and y against v, all of it tilted as one texel says.
fn square(texel: [u8; 4], scale: f32) -> Scene {
    let uvs = vec![[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]];
    let parts = MeshParts {
        positions: vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        uvs: [uvs, vec![]],
        material: Some(0),
        ..MeshParts::default()
    };
    let used = TextureUse { texture: 0, uv_set: 0, uv_map: TextureUse::UV_UNCHANGED };
    let material = Material { normal_map: Some(NormalMap { used, scale }), ..Material::WHITE };
    let texture = Texture::new(1, 1, vec![texel], [Wrap::Repeat; 2]);
    Scene::new(vec![Mesh::new(parts).unwrap().with_tangents(0)], vec![material], vec![texture]).unwrap()
}

fn normal_of([x, y, z, _]: [u8; 4]) -> [f64; 3] {
    normalized([x, y, z].map(|c| 2.0 * f64::from(c) / 255.0 - 1.0))
}

/// Sees nothing but the square, from above or from below.
fn camera(z: f64) -> Camera {
    Camera::look_at([0.3, -0.5, z], [0.0, 0.0, 0.0], 0.1).unwrap()
}

/// The light 1 + a·s, and its picture of a square of the normal n: ρ/π (π + 2π/3 a·n).
fn by_irradiance(scene: &Scene, z: f64, a: [f64; 3]) -> Picture {
    let (mean, slope) = ((4.0 * PI).sqrt(), (4.0 * PI / 3.0).sqrt());
    let linear = [mean, -slope * a[1], slope * a[2], -slope * a[0]];
    let light = ShVec::from_vec(linear.iter().map(|&c| Rgb::new(c, c, c)).collect()).unwrap();
    let view = ViewOptions::default().width(4).height(3).rays(1);
    let black = |_: Dir| Rgb::new(0.0_f64, 0.0, 0.0);
    light_by_irradiance(scene, &Bvh::new(scene), &light.into(), &camera(z), &view, black, Job::default())
        .unwrap()
        .picture
}

#[test]
fn irradiance_of_a_linear_sky_is_that_of_the_tilted_normal_in_closed_form() {
    let a = [0.3, -0.2, 0.5];
    for texel in TEXELS {
        let scene = square(texel, 1.0);
        for (z, side) in [(6.0, 1.0), (-6.0, -1.0)] {
            let n = normal_of(texel).map(|c| side * c);
            let expected = 1.0 + 2.0 / 3.0 * (0..3).map(|k| a[k] * n[k]).sum::<f64>();
            for pixel in by_irradiance(&scene, z, a).pixels() {
                let found = f64::from(pixel[0]);
                assert!((found - expected).abs() < 1e-5, "{texel:?} from {z}: {found}, expected {expected}");
            }
        }
    }
}

#[test]
fn a_map_that_tilts_nothing_changes_no_picture() {
    let a = [0.3, -0.2, 0.5];
    let plain = square(TEXELS[1], 1.0).without_normal_maps();
    let [without, with] = [&plain, &square(TEXELS[1], 0.0)].map(|scene| by_irradiance(scene, 6.0, a));
    for (found, expected) in with.pixels().iter().zip(without.pixels()) {
        assert!((found[0] - expected[0]).abs() < 1e-6, "{found:?}, without a map {expected:?}");
    }
}

fn even() -> DistantLight {
    DistantLight::from_map(EnvMap::from_fn(16, 8, |_| Rgb::new(1.0, 1.0, 1.0)))
}

fn truth(scene: &Scene, z: f64, job: Job<'_>) -> Result<Truth, lobe_render::RenderError> {
    let paths = PathOptions::default().bounces(0);
    let options = TruthOptions::default().width(4).height(4).count(SampleCount::of(256)).paths(paths);
    render_truth(scene, &Bvh::new(scene), &camera(z), &even(), &options, job)
}

#[test]
fn paths_lose_what_is_below_the_face_from_the_eye_and_from_texels_alike() {
    let light = even();
    for texel in TEXELS {
        let scene = square(texel, 1.0);
        // What a plane leaves of the cosine lobe of a normal that is off it: half a disc and half an ellipse.
        let expected = 0.5 * (1.0 + normal_of(texel)[2]);
        for z in [6.0, -6.0] {
            let traced = truth(&scene, z, Job::default()).unwrap();
            let count = traced.mean.pixels().len() as f64;
            let sum = |picture: &Picture| picture.pixels().iter().map(|pixel| f64::from(pixel[0])).sum::<f64>();
            let (found, error) = (sum(&traced.mean) / count, sum(&traced.variance).sqrt() / count);
            let limit = STANDARD_ERRORS * error + 1e-5;
            assert!((found - expected).abs() < limit, "{texel:?} from {z}: {found} ± {error}, expected {expected}");
        }
        let bvh = Bvh::new(&scene);
        let tracer = PathTracer::new(&scene, &bvh, &light, PathOptions::default().bounces(0));
        let texels = TexelReceivers::new(&scene, 2).unwrap();
        for i in 0..texels.receivers().len() {
            let receiver = PathReceiver::of(texels.receivers(), i);
            let found = tracer.radiance_at(&receiver, i, &SampleCount { sets: 16, per_set: 256 });
            let (mean, limit) = (found.mean.r, STANDARD_ERRORS * found.variance.r.sqrt() + 1e-5);
            assert!((mean - expected).abs() < limit, "{texel:?}, texel {i}: {mean}, expected {expected}");
        }
    }
}

#[test]
fn the_checkpoint_of_a_truth_is_refused_for_another_normal_map() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.checkpoint");
    let trace = |scene: &Scene| truth(scene, 6.0, Job::default().kept_in(&path)).map(drop);
    trace(&square(TEXELS[1], 1.0)).unwrap();
    trace(&square(TEXELS[1], 1.0)).unwrap();
    for (what, scene) in [("scale", square(TEXELS[1], 0.5)), ("texel", square(TEXELS[2], 1.0))] {
        let refusal = trace(&scene).unwrap_err().to_string();
        assert!(refusal.contains("is of another picture"), "another {what}: {refusal}");
    }
}
