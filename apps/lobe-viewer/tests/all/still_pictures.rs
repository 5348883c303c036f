//! Pictures of what stands still, of the program without a window against those by rays of the command `lobe render`.

use lobe::env::{EnvMap, SceneLight, SunChoice};
use lobe::image::Picture;
use lobe::io::Job;
use lobe::prt::BakeMode;
use lobe::render::{
    BakedScene, EnvironmentMapOptions, Reflections, ViewOptions, ViewPoint, light_baked_scene, light_baked_surfaces,
    light_by_irradiance,
};
use lobe::scene::{Bvh, built_in};
use lobe::sh::{Coefficient as _, Rotation};
use lobe_viewer::{ReadLimits, bake_options, open_sky};

use crate::command::{is_without_adapter, viewer};

const SIZE: [usize; 2] = [160, 120];
const ORDER: usize = 4;
const SAMPLES: u32 = 8;

/// The relative difference, of the brightest pixel, that pictures of the device keep but at the edges of shadows.
const TOLERANCE: f32 = 2e-3;

/// The part of the pixels that differ more: edges of surfaces, and of shadows in a map of what a sun sees.
const AT_EDGES: f64 = 4e-3;

/// The mean difference over the mean.
const MEAN: f64 = 1e-3;

fn compare(what: &str, found: &Picture, expected: &Picture) {
    let brightest = expected.pixels().iter().flatten().fold(0.0_f32, |most, c| most.max(c.abs()));
    let pairs = || found.pixels().iter().zip(expected.pixels());
    let worst = |(f, e): (&[f32; 3], &[f32; 3])| (0..3).map(|c| (f[c] - e[c]).abs()).fold(0.0, f32::max);
    let part = pairs().filter(|pair| worst(*pair) > TOLERANCE * brightest).count() as f64 / (SIZE[0] * SIZE[1]) as f64;
    let apart: f64 = pairs().map(|(f, e)| f64::from((f[1] - e[1]).abs())).sum();
    let mean = apart / pairs().map(|(_, e)| f64::from(e[1].abs())).sum::<f64>();
    assert!(part <= AT_EDGES && mean < MEAN, "{what}: {part} of the pixels differ, mean {mean}");
}

#[test]
fn a_sky_with_a_sun_lights_a_scene_as_rays_on_the_processor_do() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let [width, height] = SIZE;
    let scene = built_in::named("ball").unwrap();
    let camera = ViewPoint::Orbit { azimuth: 40.0, height: 25.0 };
    let camera = camera.camera(scene.world_bounds(), ViewPoint::FOV).unwrap();
    let view = ViewOptions::default().width(width).height(height).rays(1_usize).edge_rays(0);
    for (env, mode, suns) in [
        ("made:evening", "interreflected", "auto"),
        ("made:evening", "interreflected", "none"),
        ("made:noon", "shadowed", "auto"),
        ("made:noon", "irradiance", "1"),
        // A faint sun, which is as small as the texels of its picture.
        ("bundled:sunset", "interreflected", "1"),
    ] {
        let arguments = format!(
            "--headless built-in:ball --env {env} --mode {mode} --suns {suns} --order {ORDER} --samples {SAMPLES} \
             --size {width}x{height} --rays 1 --orbit 40,25 --software -o {mode}.exr"
        );
        let sky = open_sky(env.as_ref(), &ReadLimits::default()).unwrap().map;
        let behind = |s| sky.radiance(s).widen();
        let output = viewer(at, &arguments);
        if is_without_adapter(&output) {
            return;
        }
        assert!(output.status.success(), "{mode}: {}", String::from_utf8_lossy(&output.stderr));
        let found = lobe::image::read_picture(at.join(format!("{mode}.exr")), &Default::default()).unwrap().0;
        let light = SceneLight::of_map(&sky, ORDER, &suns.parse::<SunChoice>().unwrap()).unwrap();
        assert_eq!(light.suns().is_empty(), suns == "none", "suns {suns} of {env}");
        let expected = if mode == "irradiance" {
            light_by_irradiance(&scene, &Bvh::new(&scene), &light, &camera, &view, behind, Job::default())
        } else {
            let mode = if mode == "shadowed" { BakeMode::Shadowed } else { BakeMode::Interreflected };
            let options = bake_options(mode, ORDER, SAMPLES);
            let mut baked = BakedScene::bake(scene.clone(), &options, None, Job::default()).unwrap();
            if baked.needs_direct() && suns != "none" {
                baked.bake_direct(Job::default()).unwrap();
            }
            light_baked_scene(&baked, &light, &camera, &view, behind, Job::default())
        };
        compare(&format!("{env}, {mode}, suns {suns}"), &found, &expected.unwrap().picture);
    }
}

/// The mean difference over the mean where surfaces shine: the device has three bands of what hides reflections, and
/// edges of shadows from a map.
const MEAN_OF_MATERIALS: f64 = 1e-2;

#[test]
fn metals_and_plastics_shine_as_on_the_processor() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let [width, height] = SIZE;
    let scene = built_in::named("still-life").unwrap();
    let camera = ViewPoint::Orbit { azimuth: 40.0, height: 25.0 };
    let camera = camera.camera(scene.world_bounds(), ViewPoint::FOV).unwrap();
    let view = ViewOptions::default().width(width).height(height).rays(1_usize).edge_rays(0);
    for (mode, suns) in [("interreflected", "auto"), ("shadowed", "none")] {
        let arguments = format!(
            "--headless built-in:still-life --surfaces gltf --mode {mode} --suns {suns} --order {ORDER} \
             --samples {SAMPLES} --size {width}x{height} --rays 1 --orbit 40,25 --software -o {mode}.exr"
        );
        let output = viewer(at, &arguments);
        if is_without_adapter(&output) {
            return;
        }
        assert!(output.status.success(), "{mode}: {}", String::from_utf8_lossy(&output.stderr));
        let found = lobe::image::read_picture(at.join(format!("{mode}.exr")), &Default::default()).unwrap().0;
        let sky = open_sky("made:evening".as_ref(), &ReadLimits::default()).unwrap().map;
        let (light, rest) =
            SceneLight::of_map_with_rest((*sky).clone(), ORDER, &suns.parse::<SunChoice>().unwrap()).unwrap();
        let of = if mode == "shadowed" { BakeMode::Shadowed } else { BakeMode::Interreflected };
        let mut baked =
            BakedScene::bake(scene.clone(), &bake_options(of, ORDER, SAMPLES), None, Job::default()).unwrap();
        if baked.needs_direct() {
            baked.bake_direct(Job::default()).unwrap();
        }
        let options = EnvironmentMapOptions::default();
        let rest = EnvMap::new(rest.width(), rest.height(), rest.texels().to_vec()).unwrap();
        let reflections = Reflections::new(rest, &options, Job::default()).unwrap();
        let model = reflections.turned(&Rotation::IDENTITY);
        let behind = |s| sky.radiance(s).widen();
        let lit = light_baked_surfaces(&baked, (&light, &model), &camera, &view, behind, Job::default());
        let expected = lit.unwrap().picture;
        let pairs = || found.pixels().iter().zip(expected.pixels());
        let apart: f64 = pairs().map(|(f, e)| f64::from((f[1] - e[1]).abs())).sum();
        let mean = apart / pairs().map(|(_, e)| f64::from(e[1].abs())).sum::<f64>();
        println!("{mode}, suns {suns}: mean error {mean:.2e}");
        assert!(mean < MEAN_OF_MATERIALS, "{mode}, suns {suns}: mean {mean}");
    }
}
