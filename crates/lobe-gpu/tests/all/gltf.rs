//! Metals and plastics on the device, against `lobe-render`.

use lobe_env::{EnvMap, SceneLight, Sun, project_env};
use lobe_gpu::{
    Context, ContextOptions, GltfShading, SceneView, SceneViewOptions, SplitSum, Storage, SunsApart, SurfaceShading,
};
use lobe_image::{Picture, Tone};
use lobe_io::Job;
use lobe_prt::{AlbedoMode, BakeMode, BakeOptions, Transfer, bake_vertices};
use lobe_render::{
    BakedScene, Camera, EnvironmentMapOptions, Reflections, Surfaces, ViewOptions, light_baked_surfaces,
};
use lobe_scene::{Bvh, Material, Mesh, MeshParts, OcclusionMap, Scene, Texture, TextureUse, Wrap, built_in};
use lobe_sh::{Coefficient as _, Dir, Rgb, Rotation};

use crate::scene_view::{cameras, sky};
use crate::{device, with};

/// Bands of transfer: those of the visibility in shaders.
const ORDER: usize = 3;

/// Faces of the sharpest cube.
const CUBE: usize = 32;

/// Pixels, one sample each: the device and the processor shade the same points.
const SIZE: [usize; 2] = [160, 120];

/// The mean difference of a picture to that of the processor, over its mean. Pixels at edges, which the device snaps to
/// a grid, are most of it.
const MEAN_ERROR: f64 = 2e-3;

/// The same by transfer of five bands, of whose visibility the device has three.
const MEAN_ERROR_OF_BANDS: f64 = 1e-2;

/// The same with suns, whose shadows the device takes from a map.
const MEAN_ERROR_OF_SUNS: f64 = 1e-2;

/// Materials of all meshes.
fn painted(scene: Scene, materials: Vec<Material>, textures: Vec<Texture>) -> Scene {
    let (meshes, _, _) = scene.into_parts();
    let count = materials.len();
    let made = |(number, mesh): (usize, Mesh)| {
        Mesh::new(MeshParts { material: Some(number.min(count - 1)), ..mesh.into_parts() }).unwrap()
    };
    Scene::new(meshes.into_iter().enumerate().map(made).collect(), materials, textures).unwrap()
}

fn material(name: &str, color: [f32; 3], metallic: f32, roughness: f32) -> Material {
    Material { metallic, roughness, ..Material::matte(name, color) }
}

/// A ball of metal over a ground of plastic.
fn metal_over_plastic() -> Scene {
    let materials = vec![material("plastic", [0.3, 0.5, 0.2], 0.0, 0.3), material("metal", [0.9, 0.6, 0.3], 1.0, 0.4)];
    painted(built_in::ball_over_ground(24), materials, Vec::new())
}

/// A floor and a wall with textures of two by two texels.
fn textured() -> Scene {
    let quad = |positions: Vec<[f32; 3]>| {
        Mesh::new(MeshParts {
            positions,
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            uvs: [
                vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]],
                vec![[0.5, 0.5], [0.0, 2.0], [2.5, 0.0], [1.0; 2]],
            ],
            material: Some(0),
            ..MeshParts::default()
        })
        .unwrap()
    };
    let floor = vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
    let wall = vec![[-1.0, 1.0, 0.0], [1.0, 1.0, 0.0], [1.0, 1.0, 1.0], [-1.0, 1.0, 1.0]];
    let texel = |k: u8, seed: u8| [k.wrapping_mul(97).wrapping_add(seed), 70 + 60 * (k % 4), 255 - 80 * (k % 3), 255];
    let texture = |seed: u8, wrap: Wrap| Texture::new(2, 2, (0..4).map(|k| texel(k, seed)).collect(), [wrap; 2]);
    let used =
        |texture: usize, uv_set: usize| TextureUse { texture, uv_set, uv_map: [[1.5, 0.2, 0.1], [-0.3, 2.0, 0.4]] };
    let material = Material {
        base_color: [0.8, 0.7, 0.6, 1.0],
        metallic: 0.9,
        roughness: 0.8,
        metallic_texture: Some(used(0, 0)),
        roughness_texture: Some(used(0, 1)),
        occlusion_map: Some(OcclusionMap { used: used(1, 0), strength: 0.8 }),
        emissive: [0.05, 0.1, 0.2],
        emissive_texture: Some(used(2, 1)),
        ..Material::WHITE
    };
    let textures = vec![texture(13, Wrap::Repeat), texture(101, Wrap::Mirror), texture(45, Wrap::Clamp)];
    Scene::new(vec![quad(floor), quad(wall)], vec![material], textures).unwrap()
}

/// A scene, as both sides light it.
struct Lit {
    scene: Scene,
    options: BakeOptions,
    map: EnvMap,
    light: SceneLight,
}

impl Lit {
    fn new(scene: Scene, mode: BakeMode, albedo: AlbedoMode, suns: Vec<Sun>) -> Self {
        Self::of_order(ORDER, scene, (mode, albedo), suns)
    }

    fn of_order(order: usize, scene: Scene, (mode, albedo): (BakeMode, AlbedoMode), suns: Vec<Sun>) -> Self {
        let options = BakeOptions::default().mode(mode).order(order).samples(64).bounces(2).albedo(albedo);
        let map = sky();
        let light = SceneLight::new(project_env(&map, order), suns);
        Self { scene, options, map, light }
    }

    fn transfer(&self, options: &BakeOptions) -> Transfer {
        bake_vertices(&self.scene, &Bvh::new(&self.scene), options, Job::default()).unwrap().0
    }

    /// The picture of the processor.
    fn expected(&self) -> Picture {
        let mut baked = BakedScene::bake(self.scene.clone(), &self.options, None, Job::default()).unwrap();
        if baked.needs_direct() {
            baked.bake_direct(Job::default()).unwrap();
        }
        let options = EnvironmentMapOptions::default().surfaces(Surfaces::MetallicRoughness).size(CUBE);
        let reflections = Reflections::new(self.map.clone(), &options, Job::default()).unwrap();
        let eye = cameras(&self.scene).1;
        let camera = Camera::look_at(eye.eye, eye.target, eye.half_angle).unwrap();
        let view = ViewOptions::default().width(SIZE[0]).height(SIZE[1]).rays(1).edge_rays(0);
        let model = reflections.turned(&Rotation::IDENTITY);
        let lit = light_baked_surfaces(&baked, (&self.light, &model), &camera, &view, |_| Rgb::ZERO, Job::default());
        lit.unwrap().picture
    }

    /// That of a device.
    fn found(&self, context: &Context) -> Picture {
        self.found_under(context, (1.0, Rotation::IDENTITY))
    }

    /// The same where the map is turned and its radiance has a factor.
    fn found_under(&self, context: &Context, (strength, turn): (f64, Rotation)) -> Picture {
        let whole = self.transfer(&self.options);
        let is_reflecting = self.options.mode == BakeMode::Interreflected;
        let direct = is_reflecting.then(|| self.transfer(&self.options.clone().of_direct_part(None)));
        let reflections = SplitSum::of_light(&self.map, CUBE, Job::default()).unwrap();
        let shading = SurfaceShading::Gltf(GltfShading {
            transfer: &whole,
            albedo: self.options.albedo,
            direct: Some(direct.as_ref().unwrap_or(&whole)),
            reflections: &reflections,
            storage: Storage::F32,
        });
        let suns = match (self.light.suns().len(), &direct) {
            (0, _) => SunsApart::No,
            (count, None) => SunsApart::Shadowed(count),
            (count, Some(direct)) => SunsApart::Reflected(count, direct),
        };
        let options = SceneViewOptions::default().width(SIZE[0] as u32).height(SIZE[1] as u32).rays(1);
        let mut view = SceneView::with_suns(context, &self.scene, (&shading, suns), None, &options).unwrap();
        view.set_reflection_strength(strength);
        view.turn_backdrop(&turn).unwrap();
        view.set_camera(&cameras(&self.scene).0).unwrap();
        view.set_scene_light(&self.light).unwrap();
        view.render().unwrap();
        view.picture().unwrap()
    }

    /// Compares both.
    fn check(&self, what: &str, context: &Context, most: f64) {
        self.compare(what, &self.found(context), &self.expected(), most);
    }

    fn compare(&self, what: &str, found: &Picture, expected: &Picture, most: f64) {
        if let Some(folder) = std::env::var_os("LOBE_GPU_PICTURES") {
            let folder = std::path::Path::new(&folder);
            for (name, picture) in [("gpu", found), ("cpu", expected)] {
                picture.write_png(folder.join(format!("gltf {what} {name}.png")), &Tone::PLAIN).unwrap();
            }
        }
        let [found, expected] = [found, expected].map(|picture| crate::flat3(picture.pixels()));
        let mean = expected.iter().sum::<f64>() / expected.len() as f64;
        let error = found.iter().zip(&expected).map(|(f, e)| (f - e).abs()).sum::<f64>() / expected.len() as f64;
        println!("{what}: mean error {:.2e} of a mean of {mean:.3}", error / mean);
        assert!(mean > 0.01 && error / mean < most, "{what}: mean error {} of a mean of {mean}", error / mean);
    }
}

/// A sun of this height and azimuth in degrees.
fn sun(height: f64, azimuth: f64) -> Sun {
    let direction = Dir::from_angles((90.0 - height).to_radians(), azimuth.to_radians());
    Sun { direction, irradiance: Rgb::new(3.0, 2.5, 2.0), angular_diameter: 2.0_f64.to_radians(), texels: 0 }
}

#[test]
fn metal_and_plastic_reflect_as_on_the_processor() {
    let Some(context) = device("metal_and_plastic_reflect_as_on_the_processor") else { return };
    for (what, mode, albedo) in [
        ("reflected", BakeMode::Interreflected, AlbedoMode::Vertex),
        ("shadowed", BakeMode::Shadowed, AlbedoMode::Vertex),
        ("without albedo", BakeMode::Interreflected, AlbedoMode::None),
    ] {
        let lit = Lit::new(metal_over_plastic(), mode, albedo, Vec::new());
        lit.check(what, &context, MEAN_ERROR);
        if mode == BakeMode::Interreflected {
            let narrow = with(&context, &ContextOptions::default().max_storage_binding(1 << 15));
            lit.check(&format!("{what} in pieces"), &narrow, MEAN_ERROR);
        }
    }
}

#[test]
fn bands_beyond_the_third_hide_little_more() {
    let Some(context) = device("bands_beyond_the_third_hide_little_more") else { return };
    for order in [2, 5] {
        let of = (BakeMode::Interreflected, AlbedoMode::Vertex);
        let lit = Lit::of_order(order, metal_over_plastic(), of, Vec::new());
        lit.check(&format!("order {order}"), &context, if order > ORDER { MEAN_ERROR_OF_BANDS } else { MEAN_ERROR });
    }
}

#[test]
fn what_is_reflected_is_as_strong_and_turned_as_the_light() {
    let Some(context) = device("what_is_reflected_is_as_strong_and_turned_as_the_light") else { return };
    let mut lit = Lit::new(metal_over_plastic(), BakeMode::Interreflected, AlbedoMode::Vertex, Vec::new());
    let turn = Rotation::from_axis_angle(Dir::Z, 0.7);
    let back = turn.inverse();
    let map = lit.map.clone();
    // The light stays as the map is, and the device is told of both.
    let strong = EnvMap::from_fn(64, 32, |s| map.radiance(s).scale(2.0));
    lit.light = SceneLight::new(project_env(&strong, ORDER).rotated(&turn), Vec::new());
    let found = lit.found_under(&context, (2.0, turn));
    lit.map = EnvMap::from_fn(256, 128, |s| map.radiance(back.rotate_dir(s)).scale(2.0));
    lit.compare("turned and strong", &found, &lit.expected(), MEAN_ERROR_OF_SUNS);
}

#[test]
fn suns_shine_on_metal_and_plastic() {
    let Some(context) = device("suns_shine_on_metal_and_plastic") else { return };
    for (what, mode) in [("suns", BakeMode::Interreflected), ("suns shadowed", BakeMode::Shadowed)] {
        let suns = vec![sun(40.0, 20.0), sun(60.0, -100.0)];
        Lit::new(metal_over_plastic(), mode, AlbedoMode::Vertex, suns).check(what, &context, MEAN_ERROR_OF_SUNS);
    }
}

#[test]
fn without_storage_vertices_say_the_same() {
    let Some(context) = device("without_storage_vertices_say_the_same") else { return };
    let bare = with(&context, &ContextOptions::default().without_storage(true));
    let suns = vec![sun(40.0, 20.0)];
    for (what, mode, albedo, suns, most) in [
        ("bare", BakeMode::Interreflected, AlbedoMode::Vertex, Vec::new(), MEAN_ERROR),
        ("bare without albedo", BakeMode::Interreflected, AlbedoMode::None, Vec::new(), MEAN_ERROR),
        ("bare shadowed", BakeMode::Shadowed, AlbedoMode::Vertex, suns.clone(), MEAN_ERROR_OF_SUNS),
        ("bare suns", BakeMode::Interreflected, AlbedoMode::Vertex, suns, MEAN_ERROR_OF_SUNS),
    ] {
        Lit::new(metal_over_plastic(), mode, albedo, suns).check(what, &bare, most);
    }
}

#[test]
fn textures_say_the_finish_of_each_pixel() {
    let Some(context) = device("textures_say_the_finish_of_each_pixel") else { return };
    let lit = Lit::new(textured(), BakeMode::Interreflected, AlbedoMode::Vertex, vec![sun(50.0, -70.0)]);
    lit.check("textured", &context, MEAN_ERROR_OF_SUNS);
}
