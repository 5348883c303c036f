//! Suns apart from the expansion: shadows in closed form, and pictures against traced paths.

use std::f64::consts::PI;

use lobe_env::{EnvMap, SceneLight, Sun, SunChoice};
use lobe_image::HalvesReport;
use lobe_io::Job;
use lobe_prt::{BakeMode, BakeOptions};
use lobe_render::{
    BakedScene, Camera, DistantLight, Emitter, SampleCount, SunRays, SurfacePoint, TruthOptions, View, ViewOptions,
    light_baked_scene, light_by_irradiance, render_truth, render_truth_with_emitters,
};
use lobe_scene::{Bvh, Scene, SceneReadOptions, Up, built_in, read_scene_bytes};
use lobe_sh::{Coefficient as _, Dir, Rgb, ShVec};

const ORDER: usize = 4;

fn sun(towards: [f64; 3], radius: f64) -> Sun {
    let (direction, irradiance) = (Dir::new(towards).unwrap(), Rgb::new(3.0, 2.0, 1.0));
    Sun { direction, irradiance, angular_diameter: 2.0 * radius, texels: 0 }
}

fn only(sun: Sun) -> SceneLight {
    SceneLight::new(ShVec::zero(ORDER), vec![sun])
}

fn read(text: &str) -> Scene {
    let mut options = SceneReadOptions::default();
    options.up = Up::Z;
    read_scene_bytes(text.as_bytes(), "scene.obj", &options).unwrap().0
}

/// A roof over the half plane of negative x, at this height.
fn half_roof(height: f64) -> Scene {
    read(&format!(
        "v -50 -50 {height}\nv 0 -50 {height}\nv 0 50 {height}\nv -50 50 {height}\nvn 0 0 1\nf 1//1 2//1 3//1 4//1\n"
    ))
}

#[test]
fn the_penumbra_of_an_edge_is_the_part_of_the_disc_beside_it() {
    let radius = 0.03_f64;
    for height in [0.5, 2.0] {
        let (scene, light) = (half_roof(height), only(sun([0.0, 0.0, 1.0], radius)));
        let bvh = Bvh::new(&scene);
        let rays = SunRays::new(&scene, &bvh, &light);
        let mut last = 0.0;
        for k in -24..=24 {
            // The edge cuts the disc at this part of its radius.
            let d = f64::from(k) / 20.0;
            let at = SurfacePoint {
                position: [(d * height * radius.tan()) as f32, 0.0, 0.0],
                plane: [0.0, 0.0, 1.0],
                normal: Dir::Z,
            };
            let found = rays.irradiance(&at).r / 3.0;
            let x = d.clamp(-1.0, 1.0);
            let expected = 1.0 - (x.acos() - x * (1.0 - x * x).sqrt()) / PI;
            // Sixty-four directions, in rings of which one may be on the wrong side.
            assert!((found - expected).abs() < 0.03, "{height}, {d}: {found}, not {expected}");
            assert!(found >= last, "it grows");
            last = found;
        }
        // The rim of the disc stands lower than its center.
        assert!((last - 1.0).abs() < 3e-4, "all of it: {last}");
    }
}

/// The part of a unit disc at more than `x` from a line through its center, to one side.
fn beyond(x: f64) -> f64 {
    let x = x.clamp(-1.0, 1.0);
    (x.acos() - x * (1.0 - x * x).sqrt()) / PI
}

#[test]
fn a_bar_before_a_sun_hides_its_part_of_the_disc() {
    let radius = 0.1_f64;
    for (width, most) in [(0.2, 0.14), (0.3, 0.2), (0.5, 0.3), (0.7, 0.06), (1.0, 0.07), (1.6, 0.07)] {
        for angle in [0.0, 0.4, 1.1] {
            let (sin, cos) = f64::sin_cos(angle);
            let half = 0.5 * width * radius.tan();
            let corners = [[-half, -9.0], [half, -9.0], [half, 9.0], [-half, 9.0]]
                .map(|[x, y]| format!("v {} {} 1\n", x * cos - y * sin, x * sin + y * cos));
            let scene = read(&format!("{}f 1 2 3 4\n", corners.concat()));
            let (bvh, light) = (Bvh::new(&scene), only(sun([0.0, 0.0, 1.0], radius)));
            let rays = SunRays::new(&scene, &bvh, &light);
            for k in -30..=30 {
                let d = f64::from(k) / 20.0;
                let aside = d * radius.tan();
                let position = [(aside * cos) as f32, (aside * sin) as f32, 0.0];
                let at = SurfacePoint { position, plane: [0.0, 0.0, 1.0], normal: Dir::Z };
                let found = rays.irradiance(&at).r / 3.0;
                // The bar lies between these parts of the radius, as the point sees it.
                let expected = 1.0 - (beyond(-d - 0.5 * width) - beyond(-d + 0.5 * width));
                assert!((found - expected).abs() < most, "{width} at {d}, {angle}: {found}, not {expected}");
            }
        }
    }
}

#[test]
fn what_faces_a_sun_has_its_irradiance_and_what_a_roof_hides_has_none() {
    let floor = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvn 0 0 1\nf 1//1 2//1 3//1 4//1\n";
    let roof = "v -9 -9 1\nv 9 -9 1\nv 9 9 1\nv -9 9 1\nf 5//1 6//1 7//1 8//1\n";
    let eye = Camera::look_at([0.1, 0.2, 0.8], [0.0; 3], 0.17).unwrap();
    let view = ViewOptions::default().width(8).height(6).rays(1);
    let towards = [0.6, 0.0, 0.8];
    for (text, is_open) in [(floor.to_owned(), true), (format!("{floor}{roof}"), false)] {
        let scene = read(&text);
        for mode in [BakeMode::Unshadowed, BakeMode::Shadowed, BakeMode::Interreflected] {
            let options = BakeOptions::default().mode(mode).order(ORDER).samples(64).bounces(1);
            let mut baked = BakedScene::bake(scene.clone(), &options, None, Job::default()).unwrap();
            assert_eq!(baked.needs_direct(), mode == BakeMode::Interreflected, "{mode:?}");
            if baked.needs_direct() {
                baked.bake_direct(Job::default()).unwrap();
            }
            let light = only(sun(towards, 0.005));
            let lit = light_baked_scene(&baked, &light, &eye, &view, |_| Rgb::ZERO, Job::default()).unwrap();
            let shines = is_open || mode == BakeMode::Unshadowed;
            let expected = if shines { 0.8 * 3.0 / PI } else { 0.0 };
            // What comes in from the sides of the roof is of low order.
            let most = if mode == BakeMode::Interreflected && !is_open { 0.03 } else { 2e-4 };
            for pixel in lit.picture.pixels() {
                assert!((f64::from(pixel[0]) - expected).abs() < most, "{mode:?}, open {is_open}: {pixel:?}");
            }
        }
        let (bvh, light) = (Bvh::new(&scene), only(sun(towards, 0.005)));
        let lit = light_by_irradiance(&scene, &bvh, &light, &eye, &view, |_| Rgb::ZERO, Job::default()).unwrap();
        assert!((f64::from(lit.picture.pixels()[20][0]) - 0.8 * 3.0 / PI).abs() < 1e-4, "irradiance has no shadows");
    }
}

#[test]
fn paths_see_a_sun_as_rays_to_its_disc_do() {
    let text = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvn 0 0 1\nf 1//1 2//1 3//1 4//1\n\
                v -9 -9 1\nv 0 -9 1\nv 0 9 1\nv -9 9 1\nf 5//1 6//1 7//1 8//1\n";
    let scene = read(text);
    let (bvh, sun) = (Bvh::new(&scene), sun([0.1, 0.0, 1.0], 0.2));
    let eye = Camera::look_at([0.8, 0.2, 0.9], [0.1, 0.0, 0.0], 0.5).unwrap();
    let (width, height) = (16, 12);
    let emitter = Emitter::of_sun(&sun, scene.world_bounds());
    let mut options = TruthOptions::default().width(width).height(height).count(SampleCount::of(1024));
    options.paths = options.paths.bounces(0);
    let dark = DistantLight::from_expansion(ShVec::zero(1));
    let traced = render_truth_with_emitters(&scene, &bvh, &eye, &dark, &[emitter], &options, Job::default()).unwrap();
    let options = BakeOptions::default().mode(BakeMode::Shadowed).order(ORDER).samples(4);
    let baked = BakedScene::bake(scene, &options, None, Job::default()).unwrap();
    let view = ViewOptions::default().width(width).height(height).rays(4);
    let lit = light_baked_scene(&baked, &only(sun), &eye, &view, |_| Rgb::ZERO, Job::default()).unwrap();
    let mut penumbra = 0;
    for (i, (a, b)) in lit.picture.pixels().iter().zip(traced.mean.pixels()).enumerate() {
        let (a, b) = (f64::from(a[0]), f64::from(b[0]));
        penumbra += usize::from(b > 0.1 && b < 0.8);
        // Steps of the sun, and noise of a thousand paths.
        assert!((a - b).abs() < 0.05, "pixel {i}: {a} by rays, {b} by paths");
    }
    assert!(penumbra > 20, "{penumbra} pixels of penumbra");
}

/// A blue sky with a sun of a few texels over a dark ground.
fn sunny() -> EnvMap {
    let sun = Dir::new([0.5, 0.3, 0.6]).unwrap();
    EnvMap::from_fn(256, 128, |s| {
        let sky = if s.z() > 0.0 { Rgb::new(0.3, 0.4, 0.6) } else { Rgb::new(0.2, 0.2, 0.2) };
        if s.angle_to(sun) < 0.03 { Rgb::new(900.0, 850.0, 700.0) } else { sky }
    })
}

/// The relative error of a picture over surfaces, against paths whose noise is subtracted.
fn error(baked: &BakedScene, light: &SceneLight, map: &EnvMap) -> f64 {
    let camera = Camera::framing([-1.5, -1.5, 0.0], [1.5, 1.5, 2.0], View::three_quarter(), 0.35);
    let view = ViewOptions::default().width(48).height(36);
    let lit = light_baked_scene(baked, light, &camera, &view, |_| Rgb::ZERO, Job::default()).unwrap().picture;
    let truths = [1, 2].map(|seed| {
        let mut options = TruthOptions::default().width(48).height(36).count(SampleCount::of(256));
        options.paths = options.paths.bounces(2).seed(seed);
        render_truth(
            baked.scene(),
            baked.bvh(),
            &camera,
            &DistantLight::from_map(map.clone()),
            &options,
            Job::default(),
        )
        .unwrap()
    });
    let counts: Vec<bool> =
        truths[0].coverage.iter().zip(&truths[1].coverage).map(|(a, b)| *a >= 1.0 && *b >= 1.0).collect();
    let report = HalvesReport::new(lit.pixels(), [truths[0].mean.pixels(), truths[1].mean.pixels()], |i| counts[i]);
    report.unwrap().relative_rms
}

#[test]
fn suns_apart_bring_pictures_of_low_order_near_to_traced_paths() {
    let options = BakeOptions::default().order(ORDER).samples(512).bounces(2);
    let mut baked = BakedScene::bake(built_in::ball_over_ground(24), &options, None, Job::default()).unwrap();
    baked.bake_direct(Job::default()).unwrap();
    let map = sunny();
    let of = |choice| error(&baked, &SceneLight::of_map(&map, ORDER, &choice).unwrap(), &map);
    let (whole, apart) = (of(SunChoice::None), of(SunChoice::Auto));
    // What is left is the error of the sky at this order, and of vertices.
    assert!(whole > 0.05 && apart < 0.015, "{whole} as an expansion, {apart} apart");
}

#[test]
fn a_light_without_suns_gives_the_same_bits_whether_the_direct_part_is_known_or_not() {
    let options = BakeOptions::default().order(3).samples(32);
    let mut baked = BakedScene::bake(built_in::ball_over_ground(8), &options, None, Job::default()).unwrap();
    let camera = Camera::framing([-1.5, -1.5, 0.0], [1.5, 1.5, 2.0], View::three_quarter(), 0.35);
    let view = ViewOptions::default().width(16).height(12);
    let light = ShVec::constant(3, Rgb::new(1.0, 2.0, 3.0)).into();
    let picture = |baked: &BakedScene| {
        light_baked_scene(baked, &light, &camera, &view, |_| Rgb::ZERO, Job::default()).unwrap().picture
    };
    let before = picture(&baked);
    baked.bake_direct(Job::default()).unwrap();
    assert!(picture(&baked) == before, "other bits");
}
