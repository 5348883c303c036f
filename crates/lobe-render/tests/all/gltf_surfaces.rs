//! The materials of glTF on baked scenes: against maps, against paths, and in closed form.

use lobe_env::{EnvMap, SceneLight, Sun};
use lobe_image::{HalvesReport, Picture};
use lobe_io::Job;
use lobe_prt::{BakeMode, BakeOptions};
use lobe_render::{
    BakedScene, Camera, DistantLight, Emitter, EnvironmentMapOptions, EnvironmentMaps, Reflections, RenderError,
    SampleCount, Surfaces, TruthOptions, View, ViewOptions, light_baked_surfaces, light_by_environment_maps,
    render_truth_with_emitters,
};
use lobe_scene::{
    Bvh, Material, Mesh, MeshParts, OcclusionMap, Scene, SceneReadOptions, Texture, TextureUse, Up, Wrap, built_in,
    read_scene_bytes,
};
use lobe_sh::{Coefficient as _, Dir, Rgb, Rotation, ShVec};

const ORDER: usize = 4;

const GLTF: Surfaces = Surfaces::MetallicRoughness;

/// A floor of side 2 that faces up.
const FLOOR: &str = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nvn 0 0 1\nf 1/1/1 2/1/1 3/1/1 4/1/1\n";

/// A wide roof above it, whose lower side is seen.
const ROOF: &str = "v -9 -9 0.3\nv 9 -9 0.3\nv 9 9 0.3\nv -9 9 0.3\nf 8 7 6 5\n";

fn read(text: &str) -> Scene {
    let mut options = SceneReadOptions::default();
    options.up = Up::Z;
    read_scene_bytes(text.as_bytes(), "scene.obj", &options).unwrap().0
}

/// The scene with this material everywhere.
fn of(scene: Scene, material: Material, textures: Vec<Texture>) -> Scene {
    let (meshes, _, _) = scene.into_parts();
    let made = |mesh: Mesh| Mesh::new(MeshParts { material: Some(0), ..mesh.into_parts() }).unwrap();
    let meshes = meshes.into_iter().map(made).collect();
    Scene::new(meshes, vec![material], textures).unwrap()
}

fn baked(scene: Scene, bounces: usize) -> BakedScene {
    let mode = if bounces == 0 { BakeMode::Shadowed } else { BakeMode::Interreflected };
    baked_by(scene, mode, bounces)
}

fn baked_by(scene: Scene, mode: BakeMode, bounces: usize) -> BakedScene {
    let options = BakeOptions::default().mode(mode).order(ORDER).samples(256).bounces(bounces);
    let mut baked = BakedScene::bake(scene, &options, None, Job::default()).unwrap();
    if baked.needs_direct() {
        baked.bake_direct(Job::default()).unwrap();
    }
    baked
}

fn reflections(light: EnvMap) -> Reflections {
    let options = EnvironmentMapOptions::default().surfaces(GLTF).size(64);
    Reflections::new(light, &options, Job::default()).unwrap()
}

fn even(radiance: f32) -> EnvMap {
    EnvMap::from_fn(32, 16, |_| Rgb::splat(radiance))
}

/// An expansion of a light that is the same from everywhere.
fn constant(radiance: f64) -> ShVec<Rgb<f64>> {
    let mut f = ShVec::zero(ORDER);
    f[0] = Rgb::splat(radiance * (4.0 * std::f64::consts::PI).sqrt());
    f
}

/// An eye above the floor that sees nothing else.
fn above() -> Camera {
    Camera::look_at([0.1, 0.1, 0.25], [0.0; 3], 0.5).unwrap()
}

fn shown(baked: &BakedScene, light: &SceneLight, reflections: &Reflections, camera: &Camera) -> Picture {
    shown_by_rays(1, baked, light, reflections, camera)
}

fn shown_by_rays(
    rays: usize,
    baked: &BakedScene,
    light: &SceneLight,
    reflections: &Reflections,
    camera: &Camera,
) -> Picture {
    let view = ViewOptions::default().width(24).height(18).rays(rays).edge_rays(0);
    let model = reflections.turned(&Rotation::IDENTITY);
    light_baked_surfaces(baked, (light, &model), camera, &view, |_| Rgb::ZERO, Job::default()).unwrap().picture
}

/// The mean of a picture of the floor from above.
fn of_floor(scene: Scene, bounces: usize, light: &SceneLight, map: EnvMap) -> f64 {
    shown(&baked(scene, bounces), light, &reflections(map), &above()).mean()[1]
}

fn metal(roughness: f32) -> Material {
    Material { metallic: 1.0, roughness, ..Material::matte("metal", [1.0; 3]) }
}

#[test]
fn a_roof_hides_the_sky_from_a_metal_and_a_floor_alone_shows_it() {
    let light = constant(1.0).into();
    for roughness in [0.1, 0.5] {
        let open = of_floor(of(read(FLOOR), metal(roughness), vec![]), 0, &light, even(1.0));
        // One scattering among microfacets loses a tenth of the light at this roughness.
        assert!((0.87..1.03).contains(&open), "roughness {roughness}: {open} of a sky of 1");
        let hidden = of_floor(of(read(&format!("{FLOOR}{ROOF}")), metal(roughness), vec![]), 0, &light, even(1.0));
        assert!(hidden < 0.05, "roughness {roughness}: {hidden} under a roof");
    }
}

#[test]
fn in_white_surroundings_under_an_even_sky_what_hides_the_sky_shines_as_it_does() {
    let hall = of(built_in::columns_hall(6), Material::matte("white", [1.0; 3]), vec![]);
    let baked = baked(hall, 16).with_finish(Some(0.4), Some(1.0)).unwrap();
    let camera = Camera::framing([-2.0, -2.0, 0.0], [2.0, 2.0, 2.0], View::three_quarter(), 0.35);
    let found = shown(&baked, &constant(1.0).into(), &reflections(even(1.0)), &camera);
    let seen: Vec<f32> = found.pixels().iter().map(|pixel| pixel[1]).filter(|&c| c > 0.0).collect();
    let mean = seen.iter().sum::<f32>() / seen.len() as f32;
    // Light that goes on after the last bounce, and that one scattering among microfacets loses, is missing.
    assert!(seen.len() > 200 && (0.9..1.02).contains(&mean), "{mean} of {} pixels", seen.len());
    // Without what hides the sky the hall is dark.
    let least = seen.iter().fold(f32::INFINITY, |least, c| least.min(*c));
    assert!(least > 0.7, "the darkest pixel: {least}");
}

#[test]
fn a_body_that_hides_nothing_is_as_by_environment_maps() {
    let (meshes, _, _) = built_in::ball_over_ground(48).part([1]).unwrap().into_parts();
    let ball = Scene::new(meshes, vec![Material::matte("ball", [0.7, 0.4, 0.1])], vec![]).unwrap();
    // Light of two bands, of which a matte surface needs no other.
    let radiance = |s: Dir| Rgb::new(1.0 + 0.5 * s.x() as f32, 1.0 + 0.4 * s.z() as f32, 1.0);
    let map = EnvMap::from_fn(128, 64, radiance);
    let (light, reflections) = (lobe_env::project_env(&map, ORDER).into(), reflections(map.clone()));
    let options = EnvironmentMapOptions::default().surfaces(GLTF).size(64);
    let maps = EnvironmentMaps::new(map, &options, Job::default()).unwrap();
    let camera = Camera::look_at([9.0, 4.0, 4.0], [0.0, 0.0, 1.5], 0.2).unwrap();
    let view = ViewOptions::default().width(24).height(18).rays(1).edge_rays(0);
    for (metallic, roughness) in [(0.0, 1.0), (0.0, 0.3), (1.0, 0.3), (0.5, 0.6)] {
        let ball = ball.clone().with_finish(Some(roughness), Some(metallic)).unwrap();
        let (bvh, turned) = (Bvh::new(&ball), maps.turned(&Rotation::IDENTITY));
        let expected =
            light_by_environment_maps(&ball, &bvh, turned, &camera, &view, |_| Rgb::ZERO, Job::default()).unwrap();
        // Without shadows there is no noise; bands of the cosine beyond the order are left out.
        let found = shown(&baked_by(ball, BakeMode::Unshadowed, 0), &light, &reflections, &camera);
        for (found, expected) in found.pixels().iter().zip(expected.picture.pixels()) {
            let error = (found[0] - expected[0]).abs();
            assert!(error < 0.005, "metallic {metallic}, roughness {roughness}: {found:?}, by maps {expected:?}");
        }
    }
}

fn sun(towards: [f64; 3], radius: f64) -> Sun {
    let (direction, irradiance) = (Dir::new(towards).unwrap(), Rgb::new(3.0, 2.0, 1.0));
    Sun { direction, irradiance, angular_diameter: 2.0 * radius, texels: 0 }
}

#[test]
fn a_mirror_shows_the_middle_of_a_sun_as_bright_as_it_is() {
    for towards in [[0.0, 0.0, 1.0], [0.6, 0.0, 0.8], [0.95, 0.0, 0.312]] {
        let sun = sun(towards, 0.02);
        let from = [-20.0 * towards[0], 0.0, 20.0 * towards[2]];
        // A pixel that is much smaller than the disc.
        let camera = Camera::look_at(from, [0.0; 3], 1e-4).unwrap();
        let light = SceneLight::new(ShVec::zero(ORDER), vec![sun]);
        for mode in [BakeMode::Unshadowed, BakeMode::Shadowed] {
            let floor = baked_by(of(read(FLOOR), metal(0.0), vec![]), mode, 0);
            let found = shown(&floor, &light, &reflections(even(0.0)), &camera);
            let [expected, seen] = [sun.radiance().r, f64::from(found.pixels()[24 * 9 + 12][0])];
            assert!((seen / expected - 1.0).abs() < 0.02, "{mode:?}, {towards:?}: {seen}, the sun {expected}");
        }
    }
}

#[test]
fn suns_on_plastic_and_on_metal_are_as_paths_see_them() {
    let sun = sun([0.5, 0.3, 0.8], 0.1);
    let light = SceneLight::new(ShVec::zero(ORDER), vec![sun]);
    let camera = Camera::framing([-1.5, -1.5, 0.0], [1.5, 1.5, 2.0], View::three_quarter(), 0.35);
    for (metallic, roughness) in [(0.0, 0.3), (1.0, 0.5)] {
        let scene = built_in::ball_over_ground(24).with_finish(Some(roughness), Some(metallic)).unwrap();
        let bvh = Bvh::new(&scene);
        let emitter = [Emitter::of_sun(&sun, scene.world_bounds())];
        let dark = DistantLight::from_expansion(ShVec::zero(1));
        let truths = [1, 2].map(|seed| {
            let mut options = TruthOptions::default().width(24).height(18).count(SampleCount::of(256));
            options.paths = options.paths.bounces(0).surfaces(GLTF).seed(seed);
            render_truth_with_emitters(&scene, &bvh, &camera, &dark, &emitter, &options, Job::default()).unwrap().mean
        });
        let found = shown_by_rays(8, &baked(scene, 0), &light, &reflections(even(0.0)), &camera);
        let error =
            HalvesReport::new(found.pixels(), [truths[0].pixels(), truths[1].pixels()], |_| true).unwrap().relative_rms;
        assert!(error < 0.02, "metallic {metallic}, roughness {roughness}: {error}");
    }
}

#[test]
fn what_a_material_emits_and_what_its_texture_hides_is_seen() {
    let light = constant(1.0).into();
    let dull = Material { roughness: 1.0, ..Material::matte("dull", [0.5; 3]) };
    let plain = of_floor(of(read(FLOOR), dull.clone(), vec![]), 0, &light, even(1.0));
    let glow = Material { emissive: [0.0, 2.5, 0.0], ..dull.clone() };
    let glowing = of_floor(of(read(FLOOR), glow, vec![]), 0, &light, even(1.0));
    assert!((glowing - plain - 2.5).abs() < 1e-5, "{glowing}, without emission {plain}");
    // A texture of 128 hides half of the sky.
    let used = TextureUse { texture: 0, uv_set: 0, uv_map: TextureUse::UV_UNCHANGED };
    let worn = Material { occlusion_map: Some(OcclusionMap { used, strength: 1.0 }), ..dull };
    let half = vec![Texture::new(1, 1, vec![[128, 0, 0, 255]], [Wrap::Repeat; 2])];
    let hidden = of_floor(of(read(FLOOR), worn, half), 0, &light, even(1.0));
    assert!((hidden / plain - 128.0 / 255.0).abs() < 0.02, "{hidden}, without the texture {plain}");
}

#[test]
fn reflections_of_matte_surfaces_are_refused() {
    let options = EnvironmentMapOptions::default().surfaces(Surfaces::Matte);
    let error = Reflections::new(even(1.0), &options, Job::default()).unwrap_err();
    assert!(matches!(error, RenderError::Options(_)), "{error}");
}
