//! The path tracer against closed forms, against itself by other strategies, and against its own variance.

use std::f64::consts::PI;
use std::ops::ControlFlow;

use lobe_env::{Brdf as _, EnvMap, Ggx, bundled, lat_long, project_env};
use lobe_image::{Measured, Pixel, ZTest};
use lobe_io::{Job, Progress};
use lobe_render::{
    Camera, DistantLight, LightStrategy, PathEstimate, PathOptions, PathReceiver, PathTracer, SampleCount, SceneHit,
    Surfaces, Truth, TruthOptions, View, ViewOptions, render_truth, scene_picture,
};
use lobe_scene::{Bvh, Material, Mesh, MeshParts, Scene, built_in};
use lobe_sh::{Coefficient as _, Dir, Rgb, Rotation};

/// The significance level: the probability that two pictures of one light are told apart by mistake. The seeds are
/// fixed, so a test that passes goes on passing.
const SIGNIFICANCE: f64 = 0.01;

fn white(scene: Scene) -> Scene {
    let (meshes, materials, textures) = scene.into_parts();
    let materials = materials.into_iter().map(|m| Material { base_color: [1.0; 4], ..m }).collect();
    Scene::new(meshes, materials, textures).unwrap()
}

/// A square of side 2 in the plane z = 0 that faces up.
fn square(material: Material) -> Scene {
    let parts = MeshParts {
        name: "square".into(),
        positions: vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        material: Some(0),
        ..MeshParts::default()
    };
    Scene::new(vec![Mesh::new(parts).unwrap()], vec![material], vec![]).unwrap()
}

fn constant(radiance: f32) -> DistantLight {
    DistantLight::from_map(EnvMap::from_fn(16, 8, |_| Rgb::splat(radiance)))
}

fn up(position: [f32; 3], albedo: f32) -> PathReceiver<'static> {
    PathReceiver { position, normal: [0.0, 0.0, 1.0], lift: [0.0, 0.0, 1.0], albedo: Rgb::splat(albedo), planes: &[] }
}

fn trace(scene: &Scene, camera: &Camera, light: &DistantLight, options: &TruthOptions) -> Truth {
    render_truth(scene, &Bvh::new(scene), camera, light, options, Job::default()).unwrap()
}

fn ball_camera() -> Camera {
    Camera::look_at([6.0, -4.0, 4.0], [0.0, 0.0, 1.2], 0.3).unwrap()
}

#[test]
fn in_a_white_furnace_light_that_has_come_back_is_all_there_is() {
    // A room of flat white walls, open on one side: B = 1 - the part of paths still inside, which shrinks by each
    // bounce.
    let scene = white(built_in::cornell_box(8));
    let (bvh, light) = (Bvh::new(&scene), constant(1.0));
    let receiver = up([0.1, 0.2, 0.0], 1.0);
    let mut before = 0.0;
    for bounces in [0, 1, 2, 4, 8, 16, 64] {
        let options = PathOptions::default().bounces(bounces).strategy(LightStrategy::Bsdf);
        let tracer = PathTracer::new(&scene, &bvh, &light, options);
        let found = tracer.radiance_at(&receiver, 0, &SampleCount::of(2048)).mean.g;
        assert!(found > before && found <= 1.0, "{bounces} bounces: {found} after {before}");
        before = found;
    }
    assert!(before > 0.9999, "64 bounces: {before}");
}

/// A square ceiling of side 2 at a height of 1 whose lower side emits light of radiance 3.
fn glowing_ceiling() -> Scene {
    let glow =
        Material { emissive: [3.0; 3], base_color: [0.0, 0.0, 0.0, 1.0], double_sided: false, ..Material::WHITE };
    let parts = MeshParts {
        positions: vec![[-1.0, -1.0, 1.0], [1.0, -1.0, 1.0], [1.0, 1.0, 1.0], [-1.0, 1.0, 1.0]],
        triangles: vec![[0, 2, 1], [0, 3, 2]],
        material: Some(0),
        ..MeshParts::default()
    };
    Scene::new(vec![Mesh::new(parts).unwrap()], vec![glow], vec![]).unwrap()
}

#[test]
fn a_surface_that_emits_light_shines_on_others_as_a_square_lamp_does() {
    // The part of the hemisphere that a square shows over its center, by the cosine: four corners of
    // F = 1/2π · 2 · a/√(1 + a²) atan(a/√(1 + a²)), a = 1 (Howell's catalog, C-11).
    let a = 0.5_f64.sqrt();
    let expected = 3.0 * 4.0 / PI * a * a.atan();
    let (scene, light) = (glowing_ceiling(), constant(0.0));
    let bvh = Bvh::new(&scene);
    for strategy in [LightStrategy::MultipleImportance, LightStrategy::Bsdf, LightStrategy::NextEvent] {
        for bounces in [0, 2] {
            let options =
                PathOptions::default().bounces(bounces).strategy(strategy).surfaces(Surfaces::MetallicRoughness);
            let tracer = PathTracer::new(&scene, &bvh, &light, options);
            let found = tracer.radiance_at(&up([0.0; 3], 1.0), 0, &SampleCount::of(4096));
            let error = 4.0 * found.variance.g.sqrt();
            assert!((found.mean.g - expected).abs() < error, "{strategy:?}, {bounces}: {found:?}, expected {expected}");
        }
    }
}

#[test]
fn light_that_a_surface_emits_is_seen_from_its_front_and_not_of_matte_surfaces() {
    let scene = glowing_ceiling();
    let options = TruthOptions::default().width(4).height(4).count(SampleCount::of(16));
    let seen = |from: [f64; 3], surfaces: Surfaces| {
        let camera = Camera::look_at(from, [0.0, 0.0, 1.0], 0.1).unwrap();
        let options = options.paths(PathOptions::default().bounces(0).surfaces(surfaces));
        trace(&scene, &camera, &constant(0.0), &options).mean.pixels()[5][1]
    };
    let (below, above) = ([0.3, 0.0, -2.0], [0.3, 0.0, 4.0]);
    assert_eq!(seen(below, Surfaces::MetallicRoughness), 3.0, "the front");
    assert_eq!(seen(above, Surfaces::MetallicRoughness), 0.0, "the back");
    assert_eq!(seen(below, Surfaces::Matte), 0.0, "matte surfaces");
}

#[test]
fn a_convex_white_body_vanishes_in_even_light() {
    let scene = white(square(Material::WHITE));
    let camera = Camera::orthographic(View::three_quarter(), 1.5);
    let count = SampleCount::independent(256);
    let even = vec![Rgb::splat(0.5); 24 * 24];
    let known = vec![Rgb::ZERO; 24 * 24];
    for strategy in [LightStrategy::MultipleImportance, LightStrategy::Bsdf, LightStrategy::NextEvent] {
        let paths = PathOptions::default().bounces(0).strategy(strategy);
        let truth = trace(
            &scene,
            &camera,
            &constant(0.5),
            &TruthOptions::default().width(24).height(24).count(count).paths(paths),
        );
        assert!(
            truth.coverage.contains(&1.0) && truth.coverage.contains(&0.0),
            "the square is seen, and what is behind"
        );
        if strategy == LightStrategy::Bsdf {
            // Every path brings the same light.
            assert!(truth.mean.pixels().iter().all(|p| (p[1] - 0.5).abs() < 1e-6), "{:?}", truth.mean);
            continue;
        }
        // The heuristic's weights sum to one in the mean only, as does the cosine.
        let test = ZTest::new(
            &Measured {
                means: truth.mean.pixels(),
                variances: truth.variance.pixels(),
                degrees_of_freedom: truth.degrees_of_freedom as f64,
            },
            &Measured { means: &even, variances: &known, degrees_of_freedom: f64::INFINITY },
        );
        let test = test.unwrap();
        assert!(test.passes(SIGNIFICANCE), "{strategy:?}: {test:?}");
        // Without noise it would pass, too: it has some, and is no farther off than that.
        let noisy = truth.variance.pixels().iter().filter(|v| v[1] > 0.0).count();
        assert!(noisy > 100, "{strategy:?}: {noisy} pixels with noise");
    }
}

#[test]
fn a_white_rough_metal_loses_what_single_scattering_loses() {
    let view = Dir::from_angles(0.9, 0.3);
    for roughness in [0.2_f32, 0.5, 1.0] {
        let metal = Material { metallic: 1.0, roughness, ..Material::WHITE };
        let alpha = f64::from(roughness * roughness);
        let expected = Ggx { alpha, f0: 1.0 }.directional_albedo(view.z());
        let camera = Camera::orthographic(View::from_eye(view), 0.3);
        for strategy in [LightStrategy::MultipleImportance, LightStrategy::Bsdf, LightStrategy::NextEvent] {
            let paths = PathOptions::default().bounces(0).strategy(strategy).surfaces(Surfaces::MetallicRoughness);
            let options = TruthOptions::default().width(12).height(12).count(SampleCount::of(256)).paths(paths);
            let truth = trace(&square(metal.clone()), &camera, &constant(1.0), &options);
            let error = (truth.variance.mean()[1] / 144.0).sqrt();
            let found = truth.mean.mean()[1];
            assert!((found - expected).abs() < 5.0 * error + 1e-3, "{roughness}, {strategy:?}: {found}, {expected}");
        }
    }
}

#[test]
fn under_a_ball_the_ground_sees_what_the_closed_form_says() {
    // A ball of radius 1 straight above at distance 1.5 takes (1/1.5)² of even light; its facets, inscribed, a little
    // less.
    let scene = built_in::ball_over_ground(192);
    let (bvh, light) = (Bvh::new(&scene), constant(1.0));
    let expected = 1.0 - 1.0 / 2.25;
    for strategy in [LightStrategy::MultipleImportance, LightStrategy::Bsdf, LightStrategy::NextEvent] {
        let options = PathOptions::default().bounces(0).strategy(strategy);
        let tracer = PathTracer::new(&scene, &bvh, &light, options);
        let found = tracer.radiance_at(&up([0.0; 3], 1.0), 0, &SampleCount::of(16384));
        let error = found.variance.g.sqrt();
        assert!((found.mean.g - expected).abs() < 5.0 * error + 3e-4, "{strategy:?}: {found:?}, expected {expected}");
        assert!(error < 5e-3, "{strategy:?}: {error}");
    }
}

#[test]
fn a_sun_of_one_texel_is_found() {
    let (w, h, x, y) = (64, 32, 40, 9);
    let sun = 1000.0;
    let map = EnvMap::from_fn(w, h, |_| Rgb::splat(0.0));
    let mut texels = map.into_texels();
    texels[y * w + x] = Rgb::new(sun, 0.0, 0.5 * sun);
    let map = EnvMap::new(w, h, texels).unwrap();
    // The cosine at the middle of the texel; within it the cosine is linear in the vertical, its mean of second order
    // off.
    let expected = f64::from(sun) * lat_long::solid_angle(w, h, y) * map.dir(x, y).z() / PI;
    let scene = square(Material::WHITE);
    let bvh = Bvh::new(&scene);
    let turn = Rotation::from_axis_angle(Dir::Z, 1.0);
    let light = DistantLight::from_map(map).turned(&turn);
    for strategy in [LightStrategy::MultipleImportance, LightStrategy::NextEvent] {
        let options = PathOptions::default().bounces(0).strategy(strategy);
        let tracer = PathTracer::new(&scene, &bvh, &light, options);
        let found = tracer.radiance_at(&up([0.0; 3], 1.0), 0, &SampleCount::of(64)).mean;
        assert!((found.r / expected - 1.0).abs() < 5e-3, "{strategy:?}: {found:?}, expected {expected}");
        assert!(found.g == 0.0 && (found.b / expected - 0.5).abs() < 5e-3, "{strategy:?}: {found:?}");
    }
}

/// The same picture by another strategy with other paths, compared by what chance allows.
fn agree(scene: &Scene, light: &DistantLight, paths: [PathOptions; 2], count: SampleCount) {
    let options = |paths| TruthOptions::default().width(30).height(20).count(count).paths(paths);
    let [a, b] = paths.map(|paths| trace(scene, &ball_camera(), light, &options(paths)));
    // The covered part of a pixel on the rim is random: such pixels are left out.
    let covered = |truth: &Truth| -> (Vec<Pixel>, Vec<Pixel>) {
        let inside = |(i, _): &(usize, _)| a.coverage[*i] == 1.0 && b.coverage[*i] == 1.0;
        let pixels = truth.mean.pixels().iter().zip(truth.variance.pixels());
        pixels.enumerate().filter(inside).map(|(_, (m, v))| (*m, *v)).unzip()
    };
    let ((am, av), (bm, bv)) = (covered(&a), covered(&b));
    assert!(am.len() > 300, "{} pixels", am.len());
    let freedom = a.degrees_of_freedom as f64;
    let test = ZTest::new(
        &Measured { means: &am, variances: &av, degrees_of_freedom: freedom },
        &Measured { means: &bm, variances: &bv, degrees_of_freedom: freedom },
    );
    let test = test.unwrap();
    assert!(test.passes(SIGNIFICANCE), "{paths:?}: {test:?}");
}

#[test]
fn strategies_agree_under_smooth_light() {
    let scene = built_in::ball_over_ground(24);
    let light = DistantLight::from_expansion(project_env(&bundled::sunset().map(), 4));
    let light = light.turned(&Rotation::from_euler_zyz(0.3, 0.7, 0.1));
    let of = |strategy, seed| PathOptions::default().bounces(2).strategy(strategy).seed(seed);
    let count = SampleCount::independent(400);
    let (both, surface, from_light) =
        (of(LightStrategy::MultipleImportance, 1), of(LightStrategy::Bsdf, 2), of(LightStrategy::NextEvent, 3));
    agree(&scene, &light, [both, surface], count);
    agree(&scene, &light, [both, from_light], count);
    agree(&scene, &light, [surface, from_light], count);
}

#[test]
fn strategies_agree_on_glossy_surfaces_under_a_sun() {
    let scene = built_in::ball_over_ground(24);
    let (meshes, materials, textures) = scene.into_parts();
    let glossy = |m: Material| Material { roughness: 0.5, metallic: if m.name == "ball" { 0.7 } else { 0.0 }, ..m };
    let scene = Scene::new(meshes, materials.into_iter().map(glossy).collect(), textures).unwrap();
    let light = DistantLight::from_map(bundled::sunset().map());
    let of = |strategy, seed| {
        PathOptions::default().bounces(1).strategy(strategy).surfaces(Surfaces::MetallicRoughness).seed(seed)
    };
    agree(
        &scene,
        &light,
        [of(LightStrategy::MultipleImportance, 1), of(LightStrategy::NextEvent, 2)],
        SampleCount { sets: 48, per_set: 4 },
    );
}

#[test]
fn escapes_sum_to_what_the_tracer_finds() {
    let scene = built_in::ball_over_ground(24);
    let bvh = Bvh::new(&scene);
    let light = DistantLight::from_expansion(project_env(&bundled::sunset().map(), 3));
    let options = PathOptions::default().bounces(2).strategy(LightStrategy::Bsdf);
    let tracer = PathTracer::new(&scene, &bvh, &light, options);
    let (receiver, count) = (up([0.7, 0.2, 0.0], 0.6), SampleCount::of(512));
    let mut sum = [0.0; 3];
    let mut latest = 0;
    tracer.for_each_escape(&receiver, 5, &count, |_, bounce, s, weight| {
        latest = latest.max(bounce);
        let value = (light.radiance(s) * weight).to_array();
        (0..3).for_each(|c| sum[c] += value[c] / count.total() as f64);
    });
    let found = tracer.radiance_at(&receiver, 5, &count).mean.to_array();
    assert_eq!(latest, 2, "bounces");
    for c in 0..3 {
        assert!((sum[c] / found[c] - 1.0).abs() < 1e-12, "channel {c}: {} against {}", sum[c], found[c]);
    }
}

#[test]
fn the_variance_is_that_of_repetitions() {
    // Means of receivers at one place by different paths scatter as each of them says: Pearson's statistic over them.
    let scene = built_in::ball_over_ground(24);
    let bvh = Bvh::new(&scene);
    let light = DistantLight::from_map(bundled::studio().map());
    let tracer = PathTracer::new(&scene, &bvh, &light, PathOptions::default().bounces(1));
    for count in [SampleCount::independent(64), SampleCount { sets: 16, per_set: 8 }] {
        let repeats = 600;
        let found: Vec<PathEstimate> =
            (0..repeats).map(|place| tracer.radiance_at(&up([0.5, 0.0, 0.0], 0.6), place, &count)).collect();
        let n = repeats as f64;
        let mean = found.iter().map(|e| e.mean.g).sum::<f64>() / n;
        let scatter = found.iter().map(|e| (e.mean.g - mean).powi(2)).sum::<f64>() / (n - 1.0);
        let stated = found.iter().map(|e| e.variance.g).sum::<f64>() / n;
        // The scatter of 600 normal numbers is known to √(2/600) = 6 %; of skewed ones somewhat worse.
        assert!((scatter / stated - 1.0).abs() < 0.25, "{count:?}: scatter {scatter}, stated {stated}");
        let even = SampleCount::independent(count.total());
        let plain = tracer.radiance_at(&up([0.5, 0.0, 0.0], 0.6), 0, &even).variance.g;
        assert!(stated < 1.3 * plain, "{count:?}: {stated} is no better than {plain}");
    }
}

#[test]
fn pictures_are_the_same_for_any_number_of_threads_and_know_what_they_show() {
    let scene = built_in::ball_over_ground(24);
    let light = DistantLight::from_map(bundled::sunset().map());
    let count = SampleCount::of(8);
    let options = TruthOptions::default().width(61).height(47).count(count).paths(PathOptions::default());
    let camera = ball_camera();
    let of_threads = |n| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
        pool.install(|| trace(&scene, &camera, &light, &options))
    };
    let one = of_threads(1);
    assert!(one == of_threads(3), "1 and 3 threads");

    let middle = 23 * 61 + 30;
    assert_eq!(one.coverage[middle], 1.0, "the ball is in the middle");
    let [r, g, b] = one.albedo.pixels()[middle];
    assert!((r - 0.7).abs() + (g - 0.25).abs() + (b - 0.2).abs() < 1e-6, "its color");
    let eye = (36.0_f32 + 16.0 + 2.8 * 2.8).sqrt();
    assert!((one.depth[middle] - (eye - 1.0)).abs() < 0.1, "its distance: {}", one.depth[middle]);
    let sky = one.coverage.iter().position(|&c| c == 0.0).unwrap();
    assert_eq!((one.depth[sky], one.mean.pixels()[sky][1] > 0.0), (f32::INFINITY, true), "the sky behind");
}

#[test]
fn parallel_rays_start_outside_of_the_scene() {
    // The picture is 0.008 high: rays that started 100 times half of that above the ground would pass below the ball, which is red.
    let scene = built_in::ball_over_ground(24);
    let camera = Camera::orthographic(View::from_eye(Dir::Z), 0.004);
    let options = TruthOptions::default().width(2).height(2).count(SampleCount::of(2));
    let traced = trace(&scene, &camera, &constant(1.0), &options.paths(PathOptions::default().bounces(0)));
    let (view, albedo) = (ViewOptions::default().width(2).height(2).rays(1), |hit: &SceneHit<'_>| hit.albedo);
    let cast = scene_picture(&scene, &Bvh::new(&scene), &camera, &view, |_| Rgb::ZERO, albedo, Job::default());
    for (name, picture) in [("traced", traced.albedo), ("cast", cast.unwrap())] {
        let [r, g, b] = picture.pixels()[0];
        let off = (r - 0.7).abs() + (g - 0.25).abs() + (b - 0.2).abs();
        assert!(off < 1e-6, "{name}: {r}, {g}, {b} is seen from above");
    }
}

#[test]
fn pictures_beyond_all_numbers_take_the_largest_number_of_bytes() {
    let side = usize::MAX;
    let truth = TruthOptions::default().width(side).height(side).bytes();
    let view = ViewOptions::default().width(side).height(side).bytes();
    assert_eq!([truth, view], [u64::MAX; 2], "bytes of {side} x {side} pixels");
}

#[test]
fn a_back_side_is_black_and_stops_light() {
    let one_sided = Material { double_sided: false, ..Material::WHITE };
    let scene = square(one_sided);
    let bvh = Bvh::new(&scene);
    let light = constant(1.0);
    let tracer = PathTracer::new(&scene, &bvh, &light, PathOptions::default().bounces(5));
    let below = up([0.0, 0.0, -1e-3], 1.0);
    let found = tracer.radiance_at(&below, 0, &SampleCount::of(256)).mean.g;
    assert!(found < 1e-3, "close below a black roof: {found}");
    let camera = Camera::look_at([0.1, 0.0, -5.0], [0.0; 3], 0.1).unwrap();
    let paths = PathOptions::default();
    let options = TruthOptions::default().width(4).height(4).count(SampleCount::of(2)).paths(paths);
    let truth = trace(&scene, &camera, &light, &options);
    assert!(truth.mean.pixels().iter().all(|p| p[1] == 0.0), "seen from behind");
}

#[test]
fn what_cannot_be_rendered_is_refused_and_what_is_stopped_stops() {
    let scene = square(Material::WHITE);
    let (bvh, light, camera) = (Bvh::new(&scene), constant(1.0), ball_camera());
    let options = |width, sets| {
        TruthOptions::default()
            .width(width)
            .height(100)
            .count(SampleCount { sets, per_set: 1 })
            .paths(PathOptions::default())
    };
    let refusal = |options: TruthOptions| {
        render_truth(&scene, &bvh, &camera, &light, &options, Job::default()).unwrap_err().to_string()
    };
    assert_eq!(refusal(options(0, 2)), "expected a picture with pixels, found 0 x 100", "no pixels");
    assert!(refusal(options(1, 1)).starts_with("expected at least 2 sets of 1 path, found 1 of 1"), "no variance");
    let mut calls = 0;
    let mut watch = |progress: &Progress| {
        calls += 1;
        if progress.done > 0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let job = Job::default().watched_by(&mut watch);
    let stopped = render_truth(&scene, &bvh, &camera, &light, &options(100, 2), job);
    assert_eq!((stopped.unwrap_err().to_string(), calls), ("stopped before the end".to_owned(), 2), "stopped");
}
