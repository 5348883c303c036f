//! Pictures of scenes against those by rays.

use lobe_env::{CubeMap, DfgTable, EnvMap, LobeTable, PrefilterOptions, RoughnessLevels, prefilter_ggx, project_env};
use lobe_gpu::{
    BenchReport, Environment, GlossyMesh, GpuCamera, GpuError, SceneView, SceneViewOptions, SplitSum, Storage,
    SurfaceShading, TurntableOptions, ViewOutput, render_turntable,
};
use lobe_image::{Curve, Exposure, Picture, Tone};
use lobe_io::Job;
use lobe_prt::{AlbedoMode, BakeOptions, GlossyLobe, Lightmap, Receivers, bake, bake_matrices};
use lobe_scene::{Bvh, Material, Mesh, MeshParts, Scene, Texture, TextureUse, Wrap, built_in};
use lobe_sh::{Coefficient as _, Dir, Expansion as _, Rgb, Rotation, ShVec, Zonal};

use crate::traced::by_texels;
use crate::traced::{Eye, Seen, traced};
use crate::{device, tolerance};

const SIZE: [u32; 2] = [96, 72];
const HALF_ANGLE: f64 = 0.3;

pub(crate) fn sky() -> EnvMap {
    // A bright spot over a gradient: smooth, so that no texel's edge decides.
    EnvMap::from_fn(64, 32, |s| {
        let spot = (8.0 * (s.dot(Dir::from_angles(0.8, 0.5)) - 1.0)).exp() as f32;
        Rgb::new(0.3 + 2.0 * spot, 0.4 + 1.8 * spot + 0.2 * s.y() as f32, 0.6 + 1.5 * spot + 0.3 * s.z() as f32)
    })
}

/// The same camera for the device and for rays: it frames the scene.
pub(crate) fn cameras(scene: &Scene) -> (GpuCamera, Eye) {
    let [min, max] = scene.world_bounds();
    let e = Dir::from_angles(1.1, -0.6);
    let half: [f64; 3] = std::array::from_fn(|k| 0.5 * (max[k] - min[k]));
    let distance = half.iter().map(|c| c * c).sum::<f64>().sqrt() / HALF_ANGLE.sin();
    let target: [f64; 3] = std::array::from_fn(|k| min[k] + half[k]);
    let eye = std::array::from_fn(|k| target[k] + distance * e.to_array()[k]);
    let framing = GpuCamera::framing([min, max], e, HALF_ANGLE).unwrap();
    (framing, Eye { eye, target, half_angle: HALF_ANGLE })
}

pub(crate) const RAYS: [usize; 3] = [SIZE[0] as usize, SIZE[1] as usize, 2];

pub(crate) fn options() -> SceneViewOptions {
    SceneViewOptions::default().width(SIZE[0]).height(SIZE[1])
}

/// Pixels that differ by more than this part of the brightest, as a part of all; these are cut by an edge.
fn differing(found: &Picture, expected: &Picture, tolerance: f32) -> f64 {
    let brightest = expected.pixels().iter().flatten().fold(0.0_f32, |most, c| most.max(c.abs()));
    let differs =
        |(f, e): (&[f32; 3], &[f32; 3])| (0..3).any(|c| f[c].is_nan() || (f[c] - e[c]).abs() > tolerance * brightest);
    let pixels = found.pixels().iter().zip(expected.pixels());
    pixels.filter(|pair| differs(*pair)).count() as f64 / expected.pixels().len() as f64
}

/// No more than this part of the pixels differs: those where an edge passes so near to a sample that the grid to which the
/// device snaps corners decides.
const AT_EDGES: f64 = 4e-3;

pub(crate) fn check(what: &str, view: &SceneView, expected: &Picture) {
    view.render().unwrap();
    let found = view.picture().unwrap();
    let part = differing(&found, expected, tolerance(view) as f32);
    if let Some(folder) = std::env::var_os("LOBE_GPU_PICTURES") {
        let folder = std::path::Path::new(&folder);
        for (name, picture) in [("gpu", &found), ("cpu", expected)] {
            picture.write_png(folder.join(format!("{what} {name}.png")), &Tone::PLAIN).unwrap();
        }
    }
    assert!(part <= AT_EDGES, "{what}: {part} of the pixels differ\n{}", view.renderer());
}

#[test]
fn a_picture_by_irradiance_is_that_of_the_processor() {
    let Some(context) = device("a_picture_by_irradiance_is_that_of_the_processor") else { return };
    let (scene, sky) = (painted(), sky());
    let (gpu, cpu) = cameras(&scene);
    let environment = Environment::from(&*sky);
    let turn = Rotation::from_axis_angle(Dir::Z, 0.7);
    for order in [3, 5] {
        let light = project_env(&sky, order);
        let view = SceneView::new(&context, &scene, &SurfaceShading::Irradiance(order), Some(&environment), &options())
            .unwrap();
        view.set_camera(&gpu).unwrap();
        for turn in [Rotation::IDENTITY, turn] {
            let light = light.rotated(&turn);
            view.set_light(&light).unwrap();
            view.turn_backdrop(&turn).unwrap();
            let back = turn.inverse();
            let background = |s| sky.radiance(back.rotate_dir(s)).widen();
            let irradiance = light.convolved(&Zonal::clamped_cosine(order));
            let shade = |s: &Seen<'_>| (s.albedo * irradiance.eval(s.normal)).scale(std::f64::consts::FRAC_1_PI);
            let expected = traced(&scene, cpu, RAYS, background, shade);
            check(&format!("irradiance {order} {}", back == turn), &view, &expected);
        }
    }
}

/// Boxes with a texture that is turned, vertex colors, holes and a side that is not double-sided.
pub(crate) fn painted() -> Scene {
    painted_by([[0.6, 0.2, 0.1], [-0.2, 0.6, -0.3]])
}

/// The same with the texture by this map.
pub(crate) fn painted_by(uv_map: [[f32; 3]; 2]) -> Scene {
    let quad = |name: &str, at: f32, material: usize, colors: Vec<[f32; 4]>| {
        Mesh::new(MeshParts {
            name: name.into(),
            positions: vec![[-1.0, -1.0, at], [1.0, -1.0, at], [1.0, 1.0, at], [-1.0, 1.0, at + 0.3]],
            normals: vec![[0.0, 0.0, 1.0], [0.1, 0.0, 0.995], [0.0, 0.3, 0.954], [0.0, 0.0, 1.0]],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            uvs: [vec![[0.0, 0.0], [2.5, 0.0], [2.5, 1.5], [0.0, 1.5]], Vec::new()],
            colors,
            material: Some(material),
            ..MeshParts::default()
        })
        .unwrap()
    };
    let texels = (0..64_u32).map(|i| [(i * 37 % 256) as u8, (i * 91 % 256) as u8, 128, (i * 53 % 256) as u8]).collect();
    let texture = Texture::new(8, 8, texels, [Wrap::Mirror, Wrap::Repeat]);
    let used = TextureUse { texture: 0, uv_set: 0, uv_map };
    let textured = Material { base_color_texture: Some(used), ..Material::WHITE };
    let one_sided = Material { double_sided: false, ..Material::matte("one-sided", [0.8, 0.5, 0.2]) };
    let colors = vec![[1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 1.0], [0.0, 0.0, 1.0, 1.0], [1.0; 4]];
    let meshes = vec![quad("textured", 0.0, 0, Vec::new()), quad("colors", 1.0, 1, colors)];
    Scene::new(meshes, vec![textured, one_sided], vec![texture]).unwrap()
}

#[test]
fn pictures_by_transfer_are_those_of_the_processor() {
    let Some(context) = device("pictures_by_transfer_are_those_of_the_processor") else { return };
    let (scene, sky) = (built_in::ball_over_ground(16), sky());
    let light: ShVec<Rgb<f64>> = project_env(&sky, 4);
    let (gpu, cpu) = cameras(&scene);
    let bake_options = BakeOptions::default().order(4).samples(64);
    let receivers = Receivers::at_vertices(&scene).unwrap();
    let bvh = Bvh::new(&scene);
    let (transfer, _) = bake(&scene, &bvh, &receivers, &bake_options, Job::default()).unwrap();
    let values = transfer.exit_radiance(light.coefficients());
    let shading = SurfaceShading::Vertices(&transfer, &[], Storage::F32);
    let environment = Environment::from(&*sky);
    let view = SceneView::new(&context, &scene, &shading, Some(&environment), &options()).unwrap();
    view.set_camera(&gpu).unwrap();
    view.set_light(&light).unwrap();
    let background = |s| sky.radiance(s).widen();
    let shade = |s: &Seen<'_>| if s.is_front { s.at_corners(&values) } else { Rgb::ZERO };
    let expected = traced(&scene, cpu, RAYS, background, shade);
    check("transfer", &view, &expected);
    // One sample a pixel, without the pass that takes means.
    let one = SceneView::new(&context, &scene, &shading, Some(&environment), &options().rays(1)).unwrap();
    one.set_camera(&gpu).unwrap();
    one.set_light(&light).unwrap();
    check("transfer one", &one, &traced(&scene, cpu, [RAYS[0], RAYS[1], 1], background, shade));
    assert!(crate::pass_names(one.renderer()).iter().all(|name| name != "resolve"), "{}", one.renderer());
    // The display of those pictures, also where nothing else is kept.
    for (mut view, rays) in [(view, 2), (one, 1)] {
        for curve in Curve::ALL.into_iter().chain([Curve::Reinhard { white: 2.0 }]) {
            let tone = Tone { exposure: Exposure::Fixed(0.8), curve };
            let mut shown = |output: ViewOutput| {
                view.resize(&options().rays(rays).output(output).multisample(false)).unwrap();
                view.set_tone(&tone).unwrap();
                view.render().unwrap();
                (view.display().unwrap(), view.picture())
            };
            let (found, picture) = shown(ViewOutput::LightAndDisplay);
            let expected = tone.to_bytes(&picture.unwrap());
            let (alone, refused) = shown(ViewOutput::Display);
            for bytes in [found, alone] {
                let worst = bytes.iter().zip(&expected).map(|(f, e)| f.abs_diff(*e)).max().unwrap();
                assert!(bytes.len() == expected.len() && worst <= 1, "{curve:?}, {rays} rays: bytes differ by {worst}");
            }
            assert!(matches!(refused, Err(GpuError::Options(_))), "no light is kept: {refused:?}");
        }
    }
}

#[test]
fn transfer_without_albedo_is_multiplied_by_the_base_color_of_each_pixel() {
    let Some(context) = device("transfer_without_albedo_is_multiplied_by_the_base_color_of_each_pixel") else { return };
    // Textures, colors of vertices, holes and a side that is not double-sided.
    let (scene, sky) = (painted(), sky());
    let light: ShVec<Rgb<f64>> = project_env(&sky, 3);
    let (gpu, cpu) = cameras(&scene);
    let bake_options = BakeOptions::default().order(3).samples(64).albedo(AlbedoMode::None);
    let receivers = Receivers::at_vertices(&scene).unwrap();
    let (transfer, _) = bake(&scene, &Bvh::new(&scene), &receivers, &bake_options, Job::default()).unwrap();
    let values = transfer.exit_radiance(light.coefficients());
    let shading = SurfaceShading::Demodulated(&transfer, Storage::F32);
    let environment = Environment::from(&*sky);
    let view = SceneView::new(&context, &scene, &shading, Some(&environment), &options()).unwrap();
    view.set_camera(&gpu).unwrap();
    view.set_light(&light).unwrap();
    let shade = |s: &Seen<'_>| if s.is_front { s.albedo * s.at_corners(&values) } else { Rgb::ZERO };
    let expected = traced(&scene, cpu, RAYS, |s| sky.radiance(s).widen(), shade);
    check("demodulated", &view, &expected);
}

#[test]
fn a_mesh_that_shines_stands_among_matte_ones() {
    let Some(context) = device("a_mesh_that_shines_stands_among_matte_ones") else { return };
    let (scene, sky, order) = (built_in::ball_over_ground(12), sky(), 3);
    let light: ShVec<Rgb<f64>> = project_env(&sky, order);
    let (gpu, cpu) = cameras(&scene);
    let (bvh, receivers) = (Bvh::new(&scene), Receivers::at_vertices(&scene).unwrap());
    let bake_options = BakeOptions::default().order(order).samples(32);
    let (transfer, _) = bake(&scene, &bvh, &receivers, &bake_options, Job::default()).unwrap();
    let values = transfer.exit_radiance(light.coefficients());
    let ground = scene.meshes()[0].positions().len();
    let of_ball = receivers.subset(&(ground..scene.vertex_count()).collect::<Vec<_>>()).unwrap();
    let (matrices, _) = bake_matrices(&scene, &bvh, &of_ball, &bake_options, Job::default()).unwrap();
    let (alpha, dfg) = (0.25, DfgTable::new(64));
    let ball = [GlossyMesh { mesh: 1, matrices: &matrices, lobe: GlossyLobe::Ggx(alpha) }];
    let shading = SurfaceShading::Vertices(&transfer, &ball, Storage::F32);
    let view = SceneView::new(&context, &scene, &shading, None, &options()).unwrap();
    view.set_camera(&gpu).unwrap();
    view.set_light(&light).unwrap();
    let zonal = Zonal::ggx(order, alpha);
    let blurred: Vec<ShVec<Rgb<f64>>> =
        (0..matrices.points()).map(|p| matrices.incident(p, light.coefficients()).convolved(&zonal)).collect();
    let shade = |s: &Seen<'_>| match (s.is_front, scene.locate(s.hit.triangle as usize).0) {
        (false, _) => Rgb::ZERO,
        (true, 0) => s.at_corners(&values),
        (true, _) => {
            let at = |corner: usize| blurred[corner - ground].eval(s.reflected());
            let sum = s.blended(at, |sum, value, w| *sum += value.scale(w));
            dfg.lookup(s.normal.dot(s.view).max(0.0), alpha.sqrt()).reflectance(s.albedo) * sum
        }
    };
    check("mixed", &view, &traced(&scene, cpu, RAYS, |_| Rgb::ZERO, shade));
    let of_mesh = |mesh: usize| GlossyMesh { mesh, matrices: &matrices, lobe: GlossyLobe::Phong(4.0) };
    for bad in [vec![of_mesh(0)], vec![of_mesh(2)], vec![of_mesh(1), of_mesh(1)]] {
        let shading = SurfaceShading::Vertices(&transfer, &bad, Storage::F32);
        let error = SceneView::new(&context, &scene, &shading, None, &options()).expect_err("another mesh");
        assert!(matches!(error, GpuError::Options(_)), "{error}");
    }
}

#[test]
fn glossy_pictures_are_those_of_the_processor() {
    let Some(context) = device("glossy_pictures_are_those_of_the_processor") else { return };
    let (scene, sky) = (built_in::ball_over_ground(12), sky());
    let (gpu, cpu) = cameras(&scene);
    let receivers = Receivers::at_vertices(&scene).unwrap();
    let bvh = Bvh::new(&scene);
    let baked = |order: usize| {
        let bake_options = BakeOptions::default().order(order).samples(32);
        bake_matrices(&scene, &bvh, &receivers, &bake_options, Job::default()).unwrap().0
    };
    let dfg = DfgTable::new(64);
    // Lobes narrow enough that all functions of the basis count.
    let narrow = (1..=8).map(|order| (order, GlossyLobe::Phong((order * order) as f64)));
    for (order, lobe) in narrow.chain([(3, GlossyLobe::Ggx(0.25))]) {
        let (zonal, matrices) = (lobe.zonal(order), baked(order));
        let light: ShVec<Rgb<f64>> = project_env(&sky, order);
        let shading = SurfaceShading::Glossy(&matrices, lobe, Storage::F32);
        let view = SceneView::new(&context, &scene, &shading, None, &options()).unwrap();
        view.set_camera(&gpu).unwrap();
        view.set_light(&light).unwrap();
        let blurred: Vec<ShVec<Rgb<f64>>> =
            (0..matrices.points()).map(|p| matrices.incident(p, light.coefficients()).convolved(&zonal)).collect();
        let shade = |s: &Seen<'_>| {
            if !s.is_front {
                return Rgb::ZERO;
            }
            let sum = s.blended(|corner| blurred[corner].eval(s.reflected()), |sum, value, w| *sum += value.scale(w));
            let cosine = s.normal.dot(s.view).max(0.0);
            let is_phong = matches!(lobe, GlossyLobe::Phong(_));
            let albedo = if is_phong { s.albedo } else { dfg.lookup(cosine, 0.5).reflectance(s.albedo) };
            albedo * sum
        };
        let expected = traced(&scene, cpu, RAYS, |_| Rgb::ZERO, shade);
        check(&format!("glossy {order} {lobe:?}"), &view, &expected);
    }
}

#[test]
fn reflections_of_the_environment_are_those_of_the_processor() {
    let Some(context) = device("reflections_of_the_environment_are_those_of_the_processor") else { return };
    let (scene, sky) = (built_in::ball_over_ground(16), sky());
    let (gpu, cpu) = cameras(&scene);
    let prefilter = PrefilterOptions::default().size(16).last_size(4);
    let cube = CubeMap::from_fn(16, |s| sky.radiance(s));
    let levels = prefilter_ggx(&cube, &prefilter, Job::default()).unwrap();
    let lobes = LobeTable::correlated();
    assert_eq!(levels.levels().len(), 3, "levels");
    let environment = Environment::from(&*sky);
    // On levels, between them, and at both ends.
    for (spacing, roughness, angle) in [
        (RoughnessLevels::Linear, 0.5, 0.0),
        (RoughnessLevels::Linear, 0.5, 0.7),
        (RoughnessLevels::Linear, 0.0, 0.0),
        (RoughnessLevels::Linear, 1.0, 0.0),
        (RoughnessLevels::Quadratic, 0.3, 0.0),
        (RoughnessLevels::Quadratic, 0.85, 0.0),
    ] {
        let split = SplitSum { environment: Environment::of_levels(&levels, spacing).unwrap(), lobes: lobes.clone() };
        let shading = SurfaceShading::Specular(&split, roughness);
        let view = SceneView::new(&context, &scene, &shading, Some(&environment), &options()).unwrap();
        view.set_camera(&gpu).unwrap();
        let turn = Rotation::from_axis_angle(Dir::Z, angle);
        view.turn_backdrop(&turn).unwrap();
        let back = turn.inverse();
        let level = spacing.level_for_roughness(roughness, 3);
        let low = (level as usize).min(1);
        let shade = |s: &Seen<'_>| {
            let r = back.rotate_dir(lobes.axis(s.reflected(), s.normal, roughness));
            let at = |k: usize| -> Rgb<f64> { levels.levels()[k].radiance(r).widen() };
            let g = at(low).scale(1.0 - (level - low as f64)) + at(low + 1).scale(level - low as f64);
            g * lobes.dfg(s.normal.dot(s.view), roughness).reflectance(s.albedo)
        };
        let background = |s| sky.radiance(back.rotate_dir(s)).widen();
        let expected = traced(&scene, cpu, RAYS, background, shade);
        check(&format!("specular, {spacing:?}, {roughness}, turned by {angle}"), &view, &expected);
    }
}

#[test]
fn what_cannot_be_drawn_is_an_error() {
    let Some(context) = device("what_cannot_be_drawn_is_an_error") else { return };
    let scene = built_in::ball_over_ground(8);
    let shading = SurfaceShading::Irradiance(3);
    for bad in [options().width(0), options().height(0), options().rays(0), options().width(1 << 20)] {
        assert!(SceneView::new(&context, &scene, &shading, None, &bad).is_err(), "{bad:?}");
    }
    let transfer = lobe_prt::Transfer::new(2, lobe_prt::Channels::Gray, vec![0.0; 8]).unwrap();
    let other = SurfaceShading::Vertices(&transfer, &[], Storage::F32);
    let error = SceneView::new(&context, &scene, &other, None, &options()).expect_err("two receivers");
    assert!(error.to_string().contains("found 2"), "{error}");
    assert!(GpuCamera::look_at([0.0; 3], [0.0; 3], 0.3).is_none(), "an eye where it looks");
}

#[test]
fn boxes_of_any_size_are_framed_wherever_they_are() {
    for at in [0.0, 1.0, 1e4, -1e12] {
        for size in [0.0, 1e-9, 1.0, 1e6] {
            let bounds = [[at, 0.0, at], [at + size, 0.0, at + size]];
            assert!(GpuCamera::framing(bounds, -Dir::X, HALF_ANGLE).is_some(), "{bounds:?}");
        }
    }
    for none in [f64::NAN, f64::INFINITY] {
        assert!(GpuCamera::framing([[0.0; 3], [none; 3]], -Dir::X, HALF_ANGLE).is_none(), "{none}");
    }
}

#[test]
fn a_lightmap_is_looked_up_as_on_the_processor() {
    let Some(context) = device("a_lightmap_is_looked_up_as_on_the_processor") else { return };
    let (scene, sky) = (unfolded(), sky());
    let width = 24;
    let lightmap = Lightmap::new(&scene, width).unwrap();
    let mut random = lobe_testkit::Random::new(4);
    let numbers = random.signed_vec(9 * width * width).into_iter().map(|x| x as f32).collect();
    let transfer = lobe_prt::Transfer::new(3, lobe_prt::Channels::Gray, numbers).unwrap();
    let light: ShVec<Rgb<f64>> = project_env(&sky, 3);
    let values = transfer.exit_radiance(light.coefficients());
    let (gpu, cpu) = cameras(&scene);
    let shading = SurfaceShading::Lightmap(&transfer, &lightmap, Storage::F32);
    let view = SceneView::new(&context, &scene, &shading, None, &options()).unwrap();
    view.set_camera(&gpu).unwrap();
    view.set_light(&light).unwrap();
    let shade = by_texels((&scene, &lightmap), &values);
    let expected = traced(&scene, cpu, RAYS, |_| Rgb::ZERO, shade);
    check("lightmap", &view, &expected);
}

/// Two squares, each with half of the lightmap: two charts.
pub(crate) fn unfolded() -> Scene {
    let quad = |name: &str, z: f32, u: f32| {
        Mesh::new(MeshParts {
            name: name.into(),
            positions: vec![[-1.0, -1.0, z], [1.0, -1.0, z], [1.0, 1.0, z + 0.4], [-1.0, 1.0, z]],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            uvs: [vec![[u, 0.0], [u + 0.45, 0.0], [u + 0.45, 0.9], [u, 0.9]], Vec::new()],
            ..MeshParts::default()
        })
        .unwrap()
    };
    Scene::new(vec![quad("below", 0.0, 0.02), quad("above", 1.0, 0.52)], Vec::new(), Vec::new()).unwrap()
}

#[test]
fn a_turntable_hands_out_its_frames_and_stops_when_told() {
    let Some(context) = device("a_turntable_hands_out_its_frames_and_stops_when_told") else { return };
    let (scene, sky) = (built_in::ball_over_ground(8), sky());
    let light: ShVec<Rgb<f64>> = project_env(&sky, 3);
    let view = SceneView::new(&context, &scene, &SurfaceShading::Irradiance(3), None, &options()).unwrap();
    view.set_camera(&cameras(&scene).0).unwrap();
    let turntable = TurntableOptions::default().frames(4).step(std::f64::consts::PI);
    let mut frames = Vec::new();
    let keep = |_, picture, _: &Tone| {
        frames.push(picture);
        Ok(())
    };
    render_turntable(&view, &light, &turntable, keep, Job::default()).unwrap();
    assert_eq!(frames.len(), 4, "frames");
    assert!(differing(&frames[2], &frames[0], 1e-3) < 1e-9, "a whole turn is none");
    assert!(differing(&frames[1], &frames[0], 1e-3) > 0.01, "half a turn shows on the ball");
    let mut seen = 0;
    let mut watch = |progress: &lobe_io::Progress| {
        if progress.done == 2 { std::ops::ControlFlow::Break(()) } else { std::ops::ControlFlow::Continue(()) }
    };
    let count = |_, _, _: &Tone| {
        seen += 1;
        Ok(())
    };
    let stopped = render_turntable(&view, &light, &turntable, count, Job::default().watched_by(&mut watch));
    assert!(matches!(stopped, Err(GpuError::Cancelled)) && seen == 2, "{stopped:?} after {seen}");
    let report = BenchReport::of_view(&view, 2).unwrap();
    let names: Vec<&str> = report.passes.iter().map(|pass| pass.name.as_str()).collect();
    assert_eq!(names, ["surfaces", "resolve", "tone"], "{report}");
    assert_eq!(report.to_string().lines().count(), 6, "{report}");
}

#[test]
fn a_picture_of_another_size_is_that_of_a_view_made_with_it() {
    let Some(context) = device("a_picture_of_another_size_is_that_of_a_view_made_with_it") else { return };
    let (scene, sky) = (built_in::ball_over_ground(16), sky());
    let (camera, _) = cameras(&scene);
    let environment = Environment::from(&*sky);
    let shading = SurfaceShading::Irradiance(3);
    let make =
        |options: &SceneViewOptions| SceneView::new(&context, &scene, &shading, Some(&environment), options).unwrap();
    let show = |view: &SceneView| {
        view.set_camera(&camera).unwrap();
        view.set_light(&project_env(&sky, 3)).unwrap();
        view.render().unwrap();
        view.picture().unwrap()
    };
    for (rays, other) in [(1, 1), (2, 2), (1, 2), (2, 1)] {
        let mut view = make(&options().rays(rays));
        let small = options().width(40).height(64).rays(other);
        view.resize(&small).unwrap();
        let made = make(&small);
        assert_eq!(show(&view).pixels(), show(&made).pixels(), "{rays} rays, then {other}");
        assert_eq!(view.renderer().to_string(), made.renderer().to_string(), "the same passes");
        assert_eq!(view.renderer().bytes(), made.renderer().bytes(), "the same memory");
        for (width, height) in [(0, 64), (40, 0), (1 << 20, 8)] {
            assert!(view.resize(&small.width(width).height(height)).is_err(), "{width} x {height}");
        }
        assert_eq!(show(&view).pixels(), show(&made).pixels(), "a size that is refused changes nothing");
    }
}

#[test]
fn radiance_from_elsewhere_is_shown_and_vertices_move() {
    let Some(context) = device("radiance_from_elsewhere_is_shown_and_vertices_move") else { return };
    let (scene, sky) = (built_in::ball_over_ground(16), sky());
    let (camera, _) = cameras(&scene);
    let receivers = Receivers::at_vertices(&scene).unwrap();
    let bake_options = BakeOptions::default().order(3).samples(16);
    let (transfer, _) = bake(&scene, &Bvh::new(&scene), &receivers, &bake_options, Job::default()).unwrap();
    let light = project_env(&sky, 3);
    let values = transfer.exit_radiance(light.coefficients());
    let make = |shading: &SurfaceShading<'_>| SceneView::new(&context, &scene, shading, None, &options()).unwrap();
    let show = |view: &SceneView| {
        view.set_camera(&camera).unwrap();
        view.set_light(&light).unwrap();
        view.render().unwrap();
        view.picture().unwrap()
    };
    let expected = show(&make(&SurfaceShading::Vertices(&transfer, &[], Storage::F32)));
    let black = vec![Rgb::new(0.0, 0.0, 0.0); values.len()];
    let view = make(&SurfaceShading::Radiance(&black));
    assert!(show(&view).pixels().iter().flatten().all(|c| *c == 0.0), "black before it is set");
    view.set_radiance(&values).unwrap();
    let part = differing(&show(&view), &expected, 1e-4);
    assert!(part <= AT_EDGES, "{part} of the pixels differ");
    // Raised, it is the same seen from as much lower.
    let parts = scene.clone().into_parts();
    let raised = |mesh: Mesh| {
        let mut parts = mesh.into_parts();
        parts.positions.iter_mut().for_each(|p| p[2] += 0.5);
        Mesh::new(parts).unwrap()
    };
    let meshes = parts.0.into_iter().map(raised).collect();
    let raised = Scene::new(meshes, parts.1, parts.2).unwrap();
    view.set_vertices(&raised).unwrap();
    assert!(differing(&show(&view), &expected, 1e-2) > 0.02, "the picture moved");
    // Its numbers count from half a unit lower: it is where it was.
    view.set_vertices(&raised.moved([0.0, 0.0, -0.5])).unwrap();
    assert!(differing(&show(&view), &expected, 1e-4) <= AT_EDGES, "another origin");
    assert!(view.set_radiance(&values[1..]).is_err(), "too few values");
    assert!(view.set_vertices(&built_in::cave(16)).is_err(), "another scene");
    let computed = make(&SurfaceShading::Irradiance(3));
    assert!(computed.set_radiance(&values).is_err(), "a view that computes its radiance");
}
