//! Holes of alpha masks: baked transfer and the path tracer agree behind them, and the mask matters.

use lobe_env::{bundled, project_env};
use lobe_io::Job;
use lobe_prt::{BakeMode, BakeOptions, Receivers, bake};
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
    all.subset(&indices).unwrap()
}

#[test]
fn transfer_and_paths_agree_behind_stripes() {
    let scene = striped_ball(Alpha::Mask(0.5));
    let (bvh, receivers) = (Bvh::new(&scene), chosen(&scene));
    let sky = project_env(&bundled::sunset().map(), ORDER);
    let bake_of = |scene: &Scene, seed: usize| {
        let options = BakeOptions::default()
            .mode(BakeMode::Interreflected)
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
        let receiver = PathReceiver::of(&receivers, v);
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

#[test]
fn in_a_box_of_white_film_transfer_and_paths_have_the_closed_form_of_every_bounce() {
    // A part α of the light is stopped at each wall and all of that is reflected: after b bounces Σ (1 - α) αᵏ gets in,
    // k from 0 to b.
    for (alpha, transmission, stopped) in [(Alpha::Blend, 0.0, 0.25), (Alpha::Opaque, 0.4, 0.6)] {
        let (meshes, _, _) = built_in::closed_white_box(2).into_parts();
        let base_color = [1.0, 1.0, 1.0, 0.25];
        let film = Material { base_color, alpha, transmission, straight_through: true, ..Material::WHITE };
        let mesh = |mesh: lobe_scene::Mesh| {
            lobe_scene::Mesh::new(lobe_scene::MeshParts { material: Some(0), ..mesh.into_parts() }).unwrap()
        };
        let scene = Scene::new(meshes.into_iter().map(mesh).collect(), vec![film], vec![]).unwrap();
        let bvh = Bvh::new(&scene);
        let receivers = Receivers::new(vec![[0.1, 0.2, 0.0]], vec![[0.0, 0.0, 1.0]], vec![[1.0; 3]]).unwrap();
        let light = DistantLight::from_expansion(lobe_sh::ShVec::constant(1, Rgb::new(1.0, 1.0, 1.0)));
        for bounces in [0, 1, 3] {
            let expected = 1.0 - f64::powi(stopped, bounces as i32 + 1);
            let options = BakeOptions::default().order(1).samples(1 << 14).bounces(bounces).energy_stop(0.0);
            let (transfer, _) = bake(&scene, &bvh, &receivers, &options, Job::default()).unwrap();
            let found = f64::from(transfer.coefficients()[0]) * (4.0 * std::f64::consts::PI).sqrt();
            let paths = PathOptions::default().bounces(bounces).strategy(LightStrategy::Bsdf);
            let tracer = PathTracer::new(&scene, &bvh, &light, paths);
            let truth = tracer.radiance_at(&PathReceiver::of(&receivers, 0), 0, &SampleCount::of(1 << 14)).mean.g;
            // Five standard deviations of a coin.
            for (name, found) in [("transfer", found), ("truth", truth)] {
                assert!((found - expected).abs() < 0.02, "{name}, {bounces} bounces: {found}, expected {expected}");
            }
        }
    }
}
