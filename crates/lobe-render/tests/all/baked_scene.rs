//! Scenes lit by transfer: against irradiance in closed form, from files, from behind.

use std::fs;
use std::ops::ControlFlow;

use lobe_image::Picture;
use lobe_io::{Job, Progress};
use lobe_prt::{
    AlbedoMode, AnyTransfer, BakeMode, BakeOptions, BakedGlb, FittedVertices, GlossyLobe, Receivers, Recipe,
    TexelReceivers, bake, bake_vertices, scene_hash, write_lightmap, write_matrices, write_transfer,
};
use lobe_render::{BakedScene, Camera, LitPicture, RenderError, ViewOptions, light_baked_scene, light_by_irradiance};
use lobe_scene::{Bvh, Material, Mesh, MeshParts, Scene, SceneReadOptions, Up, read_scene_bytes};
use lobe_sh::{Coefficient as _, Dir, Rgb, ShVec};

const ORDER: usize = 3;

fn view() -> ViewOptions {
    ViewOptions::default().width(16).height(12).rays(1)
}

/// The rounding of f32 coefficients and weights of vertices.
const ROUNDING: f64 = 1e-5;

/// A double-sided square that faces up, unfolded once.
fn square() -> Scene {
    let text =
        "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvn 0 0 1\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1/1 2/2/1 3/3/1 4/4/1\n";
    let mut options = SceneReadOptions::default();
    options.up = Up::Z;
    read_scene_bytes(text.as_bytes(), "square.obj", &options).unwrap().0
}

/// The same of half the albedo.
fn gray_square() -> Scene {
    let (meshes, _, _) = square().into_parts();
    let gray = |mesh: Mesh| Mesh::new(MeshParts { material: Some(0), ..mesh.into_parts() }).unwrap();
    Scene::new(meshes.into_iter().map(gray).collect(), vec![Material::matte("gray", [0.5; 3])], vec![]).unwrap()
}

/// An eye so near above the square, or below, that it fills the picture.
fn camera(height: f64) -> Camera {
    Camera::look_at([0.1, 0.2, height], [0.0; 3], 0.17).unwrap()
}

fn options(mode: BakeMode) -> BakeOptions {
    BakeOptions::default().mode(mode).order(ORDER).samples(64)
}

/// Light from above that is not that from below, of another color.
fn light() -> ShVec<Rgb<f64>> {
    let mut f = ShVec::impulse(ORDER, Dir::new([0.3, 0.2, 1.0]).unwrap(), Rgb::new(1.0, 0.5, 0.2));
    f += &ShVec::impulse(ORDER, Dir::new([0.3, 0.2, -1.0]).unwrap(), Rgb::new(0.2, 0.3, 0.9));
    f
}

fn lit(baked: &BakedScene, light: &ShVec<Rgb<f64>>, height: f64) -> LitPicture {
    light_baked_scene(baked, &light.clone().into(), &camera(height), &view(), |_| Rgb::ZERO, Job::default()).unwrap()
}

fn assert_close(found: &Picture, expected: &Picture, what: &str) {
    for (i, (a, b)) in found.pixels().iter().zip(expected.pixels()).enumerate() {
        let [a, b]: [[f32; 3]; 2] = [*a, *b];
        let off = |c: usize| f64::from((a[c] - b[c]).abs());
        assert!(
            (0..3).all(|c| off(c) <= ROUNDING * f64::from(b[c].abs().max(1.0))),
            "{what}, pixel {i}: {a:?}, not {b:?}"
        );
    }
}

#[test]
fn transfer_without_shadows_shows_the_irradiance_of_a_flat_surface() {
    let baked = BakedScene::bake(square(), &options(BakeMode::Unshadowed), None, Job::default()).unwrap();
    let (scene, light) = (square(), light());
    let bvh = Bvh::new(&scene);
    let by_normal =
        light_by_irradiance(&scene, &bvh, &light.clone().into(), &camera(3.0), &view(), |_| Rgb::ZERO, Job::default())
            .unwrap();
    assert_close(&lit(&baked, &light, 3.0).picture, &by_normal.picture, "by transfer");
    assert_eq!(by_normal.below_zero, 0.0, "light from above");
}

#[test]
fn backs_are_black_until_they_are_baked_and_then_show_their_own_light() {
    for lobe in [None, Some(GlossyLobe::Phong(5.0))] {
        let mut baked = BakedScene::bake(square(), &options(BakeMode::Shadowed), lobe, Job::default()).unwrap();
        let light = light();
        assert!(lit(&baked, &light, -3.0).picture.pixels().iter().all(|p| *p == [0.0; 3]), "{lobe:?}: black");
        assert_eq!(
            baked.backs_in_view(&camera(3.0), &view(), Job::default()).unwrap(),
            Vec::<usize>::new(),
            "{lobe:?}: seen from above"
        );
        let seen = baked.backs_in_view(&camera(-3.0), &view(), Job::default()).unwrap();
        assert_eq!(seen, [0, 1, 2, 3], "{lobe:?}: seen from below");
        baked.bake_backs(&seen, Job::default()).unwrap();
        let [above, below] = [3.0, -3.0].map(|height| lit(&baked, &light, height).picture.pixels()[90]);
        assert!(above[0] > above[2] && below[2] > below[0], "{lobe:?}: {above:?} above, {below:?} below");
    }
}

#[test]
fn every_kind_of_file_is_lit_as_what_was_baked() {
    let (folder, scene, light) = (tempfile::tempdir().unwrap(), square(), light());
    let (bvh, options) = (Bvh::new(&scene), options(BakeMode::Shadowed));
    let recipe = Recipe::default().mode(BakeMode::Shadowed).samples(64);
    let path = |name: &str| folder.path().join(name);
    let transfer = bake_vertices(&scene, &bvh, &options, Job::default()).unwrap().0;
    BakedGlb::of_scene(&scene).write(path("a.glb"), &transfer, &recipe, Job::default()).unwrap();
    write_transfer(path("a.safetensors"), &transfer, &recipe, Job::default()).unwrap();
    let lobe = GlossyLobe::Ggx(0.4);
    let matrices = FittedVertices::all(&scene).unwrap().bake_matrices(&bvh, &options, Job::default()).unwrap().0;
    write_matrices(path("m.safetensors"), &matrices, &recipe, Job::default()).unwrap();

    let matte = BakedScene::bake(square(), &options, None, Job::default()).unwrap();
    let glossy = BakedScene::bake(square(), &options, Some(lobe), Job::default()).unwrap();
    let beside = |name: &str, lobe| BakedScene::read_transfer(square(), path(name), lobe).unwrap();
    for (what, found, expected) in [
        ("a.glb", BakedScene::read(path("a.glb"), &SceneReadOptions::default()).unwrap(), &matte),
        ("a.safetensors", beside("a.safetensors", None), &matte),
        ("m.safetensors", beside("m.safetensors", Some(lobe)), &glossy),
    ] {
        let picture = lit(&found, &light, 3.0).picture;
        assert_close(&picture, &lit(expected, &light, 3.0).picture, what);
        assert!(picture.pixels().iter().any(|p| p[0] > 0.01), "{what} is lit");
        assert_eq!(
            (found.options().mode, found.options().samples),
            (BakeMode::Shadowed, Some(64)),
            "{what}: its recipe"
        );
    }
    let bytes = |name: &str| fs::read(path(name)).unwrap();
    let from_bytes = BakedScene::read_bytes(&bytes("a.glb"), "a.glb", &SceneReadOptions::default()).unwrap();
    assert_close(&lit(&from_bytes, &light, 3.0).picture, &lit(&matte, &light, 3.0).picture, "bytes of a.glb");
    // Contents decide, not the name.
    let from_bytes = BakedScene::read_transfer_bytes(square(), &bytes("a.safetensors"), "t", None).unwrap();
    assert_close(&lit(&from_bytes, &light, 3.0).picture, &lit(&matte, &light, 3.0).picture, "bytes of a.safetensors");
    for (what, baked, mode) in [("matte", &matte, BakeMode::Shadowed), ("glossy", &glossy, BakeMode::Glossy)] {
        let recipe = baked.recipe();
        assert_eq!((recipe.mode, recipe.samples), (Some(mode), Some(64)), "the recipe of a {what} bake on the spot");
        assert_eq!(recipe.scene_hash, Some(scene_hash(&scene)), "the scene of a {what} bake on the spot");
    }

    // Texels of a flat square under even shadows have the transfer of its corners.
    let texels = TexelReceivers::new(&scene, 4).unwrap();
    let flat = options.mode(BakeMode::Unshadowed);
    let transfer = bake(&scene, &bvh, texels.receivers(), &flat, Job::default()).unwrap().0;
    let picture: AnyTransfer = texels.picture(&transfer).unwrap().into();
    let AnyTransfer::Plain(picture) = &picture else { unreachable!("plain") };
    write_lightmap(path("l.exr"), picture, &Recipe::default().mode(BakeMode::Unshadowed), Job::default()).unwrap();
    let lightmap = beside("l.exr", None);
    assert!(lightmap.is_lightmap() && !matte.is_lightmap(), "texels");
    let vertices = BakedScene::bake(square(), &flat, None, Job::default()).unwrap();
    assert_close(&lit(&lightmap, &light, 3.0).picture, &lit(&vertices, &light, 3.0).picture, "l.exr");
}

#[test]
fn transfer_of_another_scene_is_refused_and_whoever_stops_gets_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("t.safetensors");
    let ball = lobe_scene::built_in::ball_over_ground(4);
    let receivers = Receivers::at_vertices(&ball).unwrap();
    let transfer = bake(&ball, &Bvh::new(&ball), &receivers, &options(BakeMode::Unshadowed), Job::default()).unwrap().0;
    write_transfer(&path, &transfer, &Recipe::default(), Job::default()).unwrap();
    let error = BakedScene::read_transfer(square(), &path, None).err().unwrap().to_string();
    assert!(error.contains("t.safetensors: expected transfer of 4 vertices as the scene has, found"), "{error}");
    assert!(!error.contains("split"), "{error}");
    write_transfer(&path, &transfer, &Recipe::default().max_edge(0.5), Job::default()).unwrap();
    let error = BakedScene::read_transfer(square(), &path, None).err().unwrap().to_string();
    assert!(error.ends_with("it belongs to the split mesh, which a bake to .glb holds"), "{error}");
    let stop = &mut |_: &Progress| ControlFlow::Break(());
    let job = Job::default().watched_by(stop);
    let stopped = BakedScene::bake(ball, &options(BakeMode::Shadowed), None, job);
    assert!(matches!(stopped, Err(RenderError::Cancelled)), "stopped");
}

#[test]
fn light_that_rings_is_reported() {
    // The cosine of three bands is 3/8 + 2x + 15/8 x², but for a factor: least at x = -8/15.
    let z = -8.0 / 15.0_f64;
    let below = Dir::new([(1.0 - z * z).sqrt(), 0.0, z]).unwrap();
    let scene = square();
    let bvh = Bvh::new(&scene);
    for (from, expected) in [(below, 1.0), (Dir::Z, 0.0)] {
        let light = ShVec::impulse(ORDER, from, Rgb::splat(1.0_f64));
        let lit = light_by_irradiance(
            &scene,
            &bvh,
            &light.clone().into(),
            &camera(3.0),
            &view(),
            |_| Rgb::ZERO,
            Job::default(),
        );
        let lit = lit.unwrap();
        assert_eq!(lit.below_zero, expected, "light from {from:?}: {:?}", lit.picture.pixels()[90]);
    }
}

#[test]
fn other_options_for_backs_leave_the_fronts_as_they_are() {
    for albedo in [AlbedoMode::Vertex, AlbedoMode::None] {
        let options = options(BakeMode::Unshadowed).albedo(albedo);
        let baked = || BakedScene::bake(gray_square(), &options, None, Job::default()).unwrap();
        let expected = lit(&baked(), &light(), 3.0).picture;
        for other in [AlbedoMode::Vertex, AlbedoMode::None] {
            let other = baked().with_options(options.clone().albedo(other));
            assert_eq!(other.options().albedo, albedo, "the albedo of backs");
            assert!(lit(&other, &light(), 3.0).picture == expected, "fronts of {albedo:?}");
        }
    }
}

#[test]
fn light_goes_through_glass_as_it_did_in_the_bake_whatever_reading_says() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("t.safetensors");
    let (meshes, mut materials, textures) = gray_square().into_parts();
    materials.iter_mut().for_each(|material| material.transmission = 0.5);
    let glass = Scene::new(meshes, materials, textures).unwrap();
    for went in [false, true] {
        let scene = glass.clone().with_straight_through(went);
        let (receivers, options) = (Receivers::at_vertices(&scene).unwrap(), options(BakeMode::Shadowed));
        let (transfer, report) = bake(&scene, &Bvh::new(&scene), &receivers, &options, Job::default()).unwrap();
        write_transfer(&path, &transfer, &Recipe::of_bake(&scene, &options, &report), Job::default()).unwrap();
        for asked in [false, true] {
            let read = glass.clone().with_straight_through(asked);
            let shown = BakedScene::read_transfer(read, &path, None).unwrap();
            assert_eq!(shown.scene().has_holes(), went, "baked {went}, read {asked}");
        }
    }
}
