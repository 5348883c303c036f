//! Scenes by environment mapping: against the path tracer, closed forms and the light itself.

use std::f64::consts::FRAC_PI_2;
use std::ops::ControlFlow;
use std::sync::LazyLock;

use lobe_env::{EnvMap, Mapping, dfg, dfg_separable};
use lobe_image::{Picture, compare};
use lobe_io::{Job, Progress};
use lobe_render::{
    Camera, DistantLight, EnvironmentMapOptions, EnvironmentMaps, LightStrategy, PathOptions, RenderError, SampleCount,
    SceneHit, Surfaces, TruthOptions, View, ViewOptions, light_by_environment_maps, render_truth, scene_picture,
};
use lobe_scene::{Bvh, Material, Mesh, MeshParts, Scene, built_in};
use lobe_sh::{Coefficient as _, Dir, Rgb, Rotation};

/// Columns of the maps of these tests, whose texels are 2.8° wide.
const COLUMNS: usize = 128;

/// Light without any symmetry, of the first three bands.
fn smooth(s: Dir) -> Rgb<f32> {
    Rgb::narrow(filtered(s, [1.0; 3]))
}

/// The same where these parts of its bands are left.
fn filtered(s: Dir, kept: [f64; 3]) -> Rgb<f64> {
    let [x, y, z] = s.to_array();
    let f = |k: f64| kept[0] + kept[1] * (0.5 * z + 0.4 * x) + kept[2] * (k * (x * x - y * y) + 0.3 * y * z);
    Rgb::new(f(0.3), f(0.0), f(-0.2))
}

fn map_of(radiance: impl Fn(Dir) -> Rgb<f32> + Sync) -> EnvMap {
    EnvMap::from_fn(COLUMNS, COLUMNS / 2, radiance)
}

/// Small maps.
fn options(surfaces: Surfaces) -> EnvironmentMapOptions {
    EnvironmentMapOptions::default().surfaces(surfaces).size(128)
}

fn maps(light: &EnvMap, options: &EnvironmentMapOptions) -> EnvironmentMaps {
    EnvironmentMaps::new(light.clone(), options, Job::default()).unwrap()
}

/// Those of the smooth light for glTF's model.
static SMOOTH: LazyLock<EnvironmentMaps> =
    LazyLock::new(|| maps(&map_of(smooth), &options(Surfaces::MetallicRoughness)));

/// A ball alone, of this color and finish.
fn ball(color: [f32; 3], metallic: f32, roughness: f32) -> Scene {
    let (meshes, _, _) = built_in::ball_over_ground(64).part([1]).unwrap().into_parts();
    let material = Material { metallic, roughness, ..Material::matte("ball", color) };
    Scene::new(meshes, vec![material], vec![]).unwrap()
}

/// The middle of the ball, whose radius is 1.
const MIDDLE: [f64; 3] = [0.0, 0.0, 1.5];

/// An eye far away, for which the ball fills the height but for a twentieth.
fn camera() -> Camera {
    let towards = Dir::new([1.0, -0.6, 0.5]).unwrap().to_array();
    let eye = [0, 1, 2].map(|k| MIDDLE[k] + 30.0 * towards[k]);
    Camera::look_at(eye, MIDDLE, (1.05_f64 / 30.0).atan()).unwrap()
}

/// A square picture of the ball by maps that are turned, before a light.
fn by_maps(scene: &Scene, maps: &EnvironmentMaps, rotation: &Rotation, light: &DistantLight, side: usize) -> Picture {
    let view = ViewOptions::default().width(side).height(side).rays(3);
    let (bvh, behind) = (Bvh::new(scene), |s: Dir| light.radiance(s));
    let turned = maps.turned(rotation);
    light_by_environment_maps(scene, &bvh, turned, &camera(), &view, behind, Job::default()).unwrap().picture
}

/// How far a picture of a ball is from the truth without bounces (RMS over the pixels that it covers, relative to theirs), the
/// noise taken out.
fn error_of(scene: &Scene, maps: &EnvironmentMaps, surfaces: Surfaces) -> f64 {
    let light = DistantLight::from_map(map_of(smooth));
    let found = by_maps(scene, maps, &Rotation::IDENTITY, &light, 12);
    let paths = PathOptions::default().bounces(0).strategy(LightStrategy::Bsdf).surfaces(surfaces);
    let options = TruthOptions::default().width(12).height(12).count(SampleCount::of(512)).paths(paths);
    let truth = render_truth(scene, &Bvh::new(scene), &camera(), &light, &options, Job::default()).unwrap();
    let (mut square, mut noise, mut whole, mut count) = (0.0, 0.0, 0.0, 0);
    for i in (0..144).filter(|&i| truth.coverage[i] == 1.0) {
        count += 1;
        for c in 0..3 {
            let of = |picture: &Picture| f64::from(picture.pixels()[i][c]);
            square += (of(&found) - of(&truth.mean)).powi(2);
            noise += of(&truth.variance);
            whole += of(&truth.mean).powi(2);
        }
    }
    assert!(count > 60, "{count} pixels show the ball alone");
    ((square - noise).max(0.0) / whole).sqrt()
}

#[test]
fn a_ball_is_as_the_truth_but_for_the_split_sum() {
    // Looked up about the mirrored direction, in place of the mean of the lobe, metals are 0, 0.016, 0.071 and 0.245
    // off.
    for (roughness, allowed) in [(0.0, 0.005), (0.292_893, 0.006), (0.5, 0.015), (1.0, 0.02)] {
        let error = error_of(&ball([1.0; 3], 1.0, roughness), &SMOOTH, Surfaces::MetallicRoughness);
        println!("white metal of roughness {roughness}: {error:.4}");
        assert!(error < allowed, "white metal of roughness {roughness}: {error}, allowed {allowed}");
    }
    for (metallic, roughness, allowed) in [(0.0, 0.0, 0.005), (0.0, 0.5, 0.01), (0.0, 1.0, 0.01), (0.5, 0.5, 0.02)] {
        let error = error_of(&ball([0.7, 0.4, 0.1], metallic, roughness), &SMOOTH, Surfaces::MetallicRoughness);
        println!("metallic {metallic}, roughness {roughness}: {error:.4}");
        assert!(error < allowed, "metallic {metallic}, roughness {roughness}: {error}, allowed {allowed}");
    }
    let matte = maps(&map_of(smooth), &options(Surfaces::Matte));
    let error = error_of(&ball([0.7, 0.4, 0.1], 1.0, 0.0), &matte, Surfaces::Matte);
    println!("matte: {error:.4}");
    assert!(error < 5e-3, "matte, whatever metallic and roughness are: {error}");
}

/// The ball in black by maps, a ray for each pixel.
fn by_maps_alone(scene: &Scene, maps: &EnvironmentMaps) -> Picture {
    by_maps_turned(scene, maps, &Rotation::IDENTITY)
}

fn by_maps_turned(scene: &Scene, maps: &EnvironmentMaps, turn: &Rotation) -> Picture {
    let (bvh, turned) = (Bvh::new(scene), maps.turned(turn));
    light_by_environment_maps(scene, &bvh, turned, &camera(), &one_ray(), |_| Rgb::ZERO, Job::default())
        .unwrap()
        .picture
}

/// The same by a function.
fn by_function(scene: &Scene, radiance: impl Fn(&SceneHit<'_>) -> Rgb<f64> + Sync) -> Picture {
    let bvh = Bvh::new(scene);
    scene_picture(scene, &bvh, &camera(), &one_ray(), |_| Rgb::ZERO, radiance, Job::default()).unwrap()
}

fn one_ray() -> ViewOptions {
    ViewOptions::default().width(SIDE).height(SIDE).rays(1).edge_rays(0)
}

#[test]
fn matte_surfaces_show_the_irradiance_of_the_light_in_closed_form() {
    let scene = ball([1.0; 3], 0.0, 1.0);
    let matte = maps(&map_of(smooth), &options(Surfaces::Matte));
    // E/π has 1, 2/3 and 1/4 of the bands of the light.
    let expected = by_function(&scene, |hit| filtered(hit.normal, [1.0, 2.0 / 3.0, 0.25]));
    let report = compare(by_maps_alone(&scene, &matte).pixels(), expected.pixels());
    println!("{report:?}");
    assert!(report.max_abs < 1e-3, "{report:?}");
}

/// The roughness of the levels after that of the mirror, where no two of them are mixed.
const ROUGH: [f32; 4] = [0.133_974_6, 0.292_893_2, 0.5, 1.0];

/// The parts of the bands 0, 1 and 2 that the lobe of GGX keeps about its axis, by the rule of midpoints in u.
///
/// ```text
///   w_l = ∫ k(c) P_l(c) dc / ∫ k(c) dc       k = c/(1 + (1/α² - 1)(1 - c)/2)²       1 - c = u³, which opens the peak
/// ```
fn kept(roughness: f64) -> [f64; 3] {
    const STEPS: usize = 4000;
    let narrowness = 0.5 * (roughness.powi(-4) - 1.0);
    let mut sums = [0.0; 3];
    for i in 0..STEPS {
        let u = (i as f64 + 0.5) / STEPS as f64;
        let (t, c) = (u.powi(3), 1.0 - u.powi(3));
        let weight = u * u * c / (1.0 + narrowness * t).powi(2);
        for (sum, legendre) in sums.iter_mut().zip([1.0, c, 1.5 * c * c - 0.5]) {
            *sum += weight * legendre;
        }
    }
    sums.map(|sum| sum / sums[0])
}

#[test]
fn each_level_keeps_of_each_band_what_its_lobe_keeps() {
    // Under even light a white metal shows its reflectance alone. That of roughness 1 has a closed form: 2/3 and 1/4.
    let even = maps(&map_of(|_| Rgb::splat(1.0)), &options(Surfaces::MetallicRoughness).size(16));
    // The middle of the ball is seen along its normal, where lobes do not lean; the light is turned before it.
    let turns =
        [Dir::X, Dir::Y, Dir::Z].map(|axis| [0.8, 2.5, 4.4].map(|angle| Rotation::from_axis_angle(axis, angle)));
    for roughness in ROUGH {
        let scene = ball([1.0; 3], 1.0, roughness);
        let kept = kept(roughness.into());
        let reflectance = by_maps_alone(&scene, &even);
        let middle = by_function(&scene, |hit| Rgb::splat(f64::from(hit.normal.dot(hit.view) > 0.985)));
        let (mut found, mut expected) = (Vec::new(), Vec::new());
        for turn in turns.iter().flatten() {
            let light = by_maps_turned(&scene, &SMOOTH, turn);
            let turned = by_function(&scene, |hit| filtered(turn.inverse().rotate_dir(hit.reflected()), kept));
            for (i, _) in middle.pixels().iter().enumerate().filter(|(_, pixel)| pixel[0] > 0.0) {
                found.push([0, 1, 2].map(|c| light.pixels()[i][c] / reflectance.pixels()[i][c]));
                expected.push(turned.pixels()[i]);
            }
        }
        let error = compare(&found, &expected).relative_rmse;
        println!("roughness {roughness}: {kept:.4?} of the bands, {error:.5} off in {} pixels", found.len());
        // Ten degrees off the normal the roughest lobe leans by a third of the way.
        let allowed = 0.005 + 0.03 * f64::from(roughness).powi(4);
        assert!(found.len() > 60 && error < allowed, "roughness {roughness}: {error} in {} pixels", found.len());
    }
    let [_, first, second] = kept(1.0);
    assert!((first - 2.0 / 3.0).abs() < 1e-6 && (second - 0.25).abs() < 1e-6, "{first}, {second}");
}

/// A square of side 2 that faces up, before an eye at this angle.
fn square(metallic: f32, roughness: f32, color: [f32; 3], angle: f64) -> (Scene, Camera) {
    let parts = MeshParts {
        positions: vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        material: Some(0),
        ..MeshParts::default()
    };
    let material = Material { metallic, roughness, ..Material::matte("square", color) };
    let scene = Scene::new(vec![Mesh::new(parts).unwrap()], vec![material], vec![]).unwrap();
    (scene, Camera::orthographic(View::from_eye(Dir::from_angles(angle, 0.4)), 0.1))
}

fn seen((scene, camera): &(Scene, Camera), maps: &EnvironmentMaps) -> Rgb<f64> {
    let view = ViewOptions::default().width(2).height(2).rays(1);
    let (bvh, turned) = (Bvh::new(scene), maps.turned(&Rotation::IDENTITY));
    let black = |_: Dir| Rgb::<f64>::ZERO;
    let found = light_by_environment_maps(scene, &bvh, turned, camera, &view, black, Job::default()).unwrap();
    Rgb::from(found.picture.mean())
}

fn near(found: Rgb<f64>, expected: Rgb<f64>, allowed: f64, what: &str) {
    let off = (found - expected).to_array().into_iter().fold(0.0_f64, |most, c| most.max(c.abs()));
    assert!(off < allowed, "{what}: {found:?} instead of {expected:?}");
}

#[test]
fn in_the_furnace_matte_surfaces_show_their_albedo_and_shiny_ones_the_sum_of_dfg() {
    let even = map_of(|_| Rgb::splat(1.0));
    let color = [0.8, 0.5, 0.25_f32];
    let albedo = Rgb::from(color.map(f64::from));
    let matte = maps(&even, &options(Surfaces::Matte));
    near(seen(&square(1.0, 0.2, color, 0.9), &matte), albedo, 1e-3, "matte");
    for surfaces in [Surfaces::MetallicRoughness, Surfaces::MetallicRoughnessSeparable] {
        let dfg = if surfaces == Surfaces::MetallicRoughness { dfg } else { dfg_separable };
        let maps = maps(&even, &options(surfaces));
        for (roughness, angle) in [(0.0_f32, 0.0), (0.0, 1.4), (0.3, 0.9), (0.5, 0.5), (0.9, 0.9), (1.0, 1.1)] {
            let split = dfg(f64::cos(angle), f64::from(roughness).powi(2));
            let what = format!("{surfaces:?}, roughness {roughness}, {angle} rad");
            let metal = seen(&square(1.0, roughness, color, angle), &maps);
            near(metal, split.reflectance(albedo), 2e-3, &format!("metal, {what}"));
            let plastic = seen(&square(0.0, roughness, color, angle), &maps);
            let expected = albedo.scale(0.96) + split.reflectance(Rgb::splat(0.04));
            near(plastic, expected, 2e-3, &format!("plastic, {what}"));
        }
    }
}

/// Pixels along a side of pictures without noise.
const SIDE: usize = 24;

/// A ball of metal by the formula of a mirror: the light towards the mirrored view, times Schlick's Fresnel factor.
fn mirrored(scene: &Scene, color: Rgb<f64>, light: &DistantLight) -> Picture {
    let view = ViewOptions::default().width(SIDE).height(SIDE).rays(3);
    let radiance = |hit: &SceneHit<'_>| {
        let rest = (1.0 - hit.normal.dot(hit.view)).powi(5);
        let fresnel = color.scale(1.0 - rest) + Rgb::splat(rest);
        if hit.normal.dot(hit.view) > 0.0 { fresnel * light.radiance(hit.reflected()) } else { Rgb::ZERO }
    };
    let bvh = Bvh::new(scene);
    scene_picture(scene, &bvh, &camera(), &view, |s| light.radiance(s), radiance, Job::default()).unwrap()
}

#[test]
fn a_mirror_shows_the_texels_of_the_light_times_fresnel() {
    let color = [0.9, 0.6, 0.2_f32];
    let scene = ball(color, 1.0, 0.0);
    let rotation = Rotation::from_euler_zyz(0.4, 1.1, -2.0);
    let light = DistantLight::from_map(map_of(smooth)).turned(&rotation);
    let expected = mirrored(&scene, Rgb::from(color.map(f64::from)), &light);
    let found = by_maps(&scene, &SMOOTH, &rotation, &light, SIDE);
    let report = compare(found.pixels(), expected.pixels());
    assert!(report.max_abs < 1e-5, "{report:?}");
}

#[test]
fn turned_maps_are_the_maps_of_the_turned_light() {
    // A quarter turn takes texels to texels, of every map.
    let rotation = Rotation::from_axis_angle(Dir::Z, FRAC_PI_2);
    let back = rotation.inverse();
    let turned = map_of(|s| smooth(back.rotate_dir(s)));
    let light = DistantLight::from_map(turned.clone());
    let of_turned = maps(&turned, &options(Surfaces::MetallicRoughness));
    for (metallic, roughness) in [(0.0, 1.0), (1.0, 0.7), (0.5, 0.2)] {
        let scene = ball([0.7, 0.4, 0.1], metallic, roughness);
        let (a, b) = (
            by_maps(&scene, &SMOOTH, &rotation, &light, SIDE),
            by_maps(&scene, &of_turned, &Rotation::IDENTITY, &light, SIDE),
        );
        let report = compare(a.pixels(), b.pixels());
        assert!(report.relative_rmse < 2e-3, "metallic {metallic}, roughness {roughness}: {report:?}");
        let still = by_maps(&scene, &SMOOTH, &Rotation::IDENTITY, &light, SIDE);
        let report = compare(still.pixels(), b.pixels());
        assert!(report.relative_rmse > 0.02, "the turn shows: metallic {metallic}, roughness {roughness}: {report:?}");
    }
}

#[test]
fn stored_pictures_blur_reflections_the_less_the_more_rows_they_have() {
    let light = map_of(smooth);
    let (scene, behind) = (ball([1.0; 3], 1.0, 0.0), DistantLight::from_map(light.clone()));
    let expected = mirrored(&scene, Rgb::splat(1.0), &behind);
    // No level of roughness is looked at.
    let small = options(Surfaces::MetallicRoughness).size(16);
    for mapping in [Mapping::LatLong, Mapping::Cube, Mapping::DualParaboloid, Mapping::Sphere] {
        let error = |rows: Option<usize>| {
            let stored = maps(&light, &small.mapping(mapping).rows(rows));
            let found = by_maps(&scene, &stored, &Rotation::IDENTITY, &behind, SIDE);
            compare(found.pixels(), expected.pixels()).relative_rmse
        };
        let [coarse, fine, own] = [Some(4), Some(32), None].map(error);
        println!("{mapping}: 4 rows {coarse:.4}, 32 rows {fine:.4}, as many texels as the light {own:.4}");
        assert!(fine < 0.6 * coarse && own < 0.03, "{mapping}: {coarse}, {fine}, {own}");
    }
}

#[test]
fn maps_can_be_stopped_and_are_kept_in_no_file() {
    let light = map_of(smooth);
    let mut stop = |_: &Progress| ControlFlow::Break(());
    let stopped = EnvironmentMaps::new(light.clone(), &options(Surfaces::Matte), Job::default().watched_by(&mut stop));
    assert!(matches!(stopped, Err(RenderError::Cancelled)), "stopped");
    let kept = EnvironmentMaps::new(light.clone(), &options(Surfaces::Matte), Job::default().kept_in("maps"));
    assert!(matches!(kept, Err(RenderError::Options(_))), "no file");
    let small = EnvironmentMaps::new(light, &options(Surfaces::Matte).size(8), Job::default());
    assert!(matches!(small, Err(RenderError::Options(_))), "faces too small for the levels");
}
