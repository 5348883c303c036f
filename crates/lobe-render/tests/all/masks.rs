//! Holes of alpha masks: baked transfer and the path tracer agree behind them, and the mask matters.

use lobe_env::{bundled, project_env};
use lobe_io::Job;
use lobe_prt::{BakeOptions, Mode, Receivers, bake};
use lobe_render::{DistantLight, LightStrategy, PathOptions, PathReceiver, PathTracer, SampleCount};
use lobe_scene::{Alpha, Bvh, Material, Scene, Texture, TextureUse, Wrap, built_in};
use lobe_sh::{Expansion as _, Rgb};

const ORDER: usize = 4;
const BOUNCES: usize = 2;

/// Independent sets of paths on both sides, which tell the noise.
const SETS: usize = 16;

/// The most standard errors between the two: at 48 numbers one in 10⁴ goes beyond by chance.
const STANDARD_ERRORS: f64 = 5.0;

/// The ball and the ground, the ball with stripes that are not there.
fn striped_ball(alpha: Alpha) -> Scene {
    let (meshes, materials, _) = built_in::ball_over_ground(24).into_parts();
    let stripes = Texture::new(1, 4, [[200, 90, 60, 255], [200, 90, 60, 0]].repeat(2), [Wrap::Repeat; 2]);
    let used = TextureUse { texture: 0, uv_set: 0, uv_map: TextureUse::UV_UNCHANGED };
    let mut meshes: Vec<_> = meshes.into_iter().map(lobe_scene::Mesh::into_parts).collect();
    meshes[1].uvs[0] = meshes[1].positions.iter().map(|p| [0.0, p[2]]).collect();
    let mut materials = materials;
    let ball = meshes[1].material.unwrap();
    materials[ball] = Material { alpha, base_color_texture: Some(used), double_sided: true, ..Material::WHITE };
    let meshes = meshes.into_iter().map(|parts| lobe_scene::Mesh::new(parts).unwrap());
    Scene::new(meshes.collect(), materials, vec![stripes]).unwrap()
}

/// Vertices of the ground below the ball and of the ball itself.
fn chosen(scene: &Scene) -> Receivers {
    let all = Receivers::at_vertices(scene).unwrap();
    let indices: Vec<usize> = (0..16).map(|k| (2 * k + 1) * all.len() / 32).collect();
    let of = |values: &[[f32; 3]]| indices.iter().map(|&i| values[i]).collect();
    Receivers::new(of(all.positions()), of(all.normals()), of(all.albedos())).unwrap()
}

#[test]
fn transfer_and_paths_agree_behind_stripes() {
    let scene = striped_ball(Alpha::Mask(0.5));
    let (bvh, receivers) = (Bvh::new(&scene), chosen(&scene));
    let sky = project_env(&bundled::sunset().map(), ORDER);
    let bake_of = |scene: &Scene, seed: usize| {
        let options = BakeOptions::default()
            .mode(Mode::Interreflected)
            .order(ORDER)
            .samples(1024)
            .bounces(BOUNCES)
            .energy_stop(0.0)
            .seed(seed as u64);
        bake(scene, &Bvh::new(scene), &receivers, &options, Job::default()).unwrap().0.exit_radiance(sky.coefficients())
    };
    let sets: Vec<Vec<Rgb<f32>>> = (0..SETS).map(|seed| bake_of(&scene, seed)).collect();
    let solid = bake_of(&striped_ball(Alpha::Opaque), 0);
    let light = DistantLight::from_expansion(sky.clone());
    let options = PathOptions::default().bounces(BOUNCES).strategy(LightStrategy::Bsdf);
    let tracer = PathTracer::new(&scene, &bvh, &light, options);
    let mut changed = 0;
    for v in 0..receivers.len() {
        let albedo = Rgb::from(receivers.albedos()[v]);
        let receiver = PathReceiver { position: receivers.positions()[v], normal: receivers.normals()[v], albedo };
        let truth = tracer.radiance_at(&receiver, v, &SampleCount { sets: SETS, per_set: 1024 });
        for c in 0..3 {
            let values: Vec<f64> = sets.iter().map(|set| f64::from(set[v].to_array()[c])).collect();
            let mean = values.iter().sum::<f64>() / SETS as f64;
            let variance = values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (SETS * (SETS - 1)) as f64;
            let (expected, its_variance) = (truth.mean.to_array()[c], truth.variance.to_array()[c]);
            let error = (variance + its_variance).sqrt();
            assert!(
                (mean - expected).abs() < STANDARD_ERRORS * error,
                "vertex {v}, channel {c}: {mean}, traced {expected}, standard error {error}"
            );
            changed += usize::from((f64::from(solid[v].to_array()[c]) - mean).abs() > 10.0 * error);
        }
    }
    assert!(changed > 12, "without its holes the ball changes only {changed} of 48 numbers");
}
