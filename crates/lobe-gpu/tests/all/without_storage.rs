//! Devices whose shaders read no buffers and compute nothing, as those of WebGL 2: transfer is in textures.

use lobe_env::project_env;
use lobe_gpu::{BenchReport, Context, ContextOptions, Environment, GpuError, SceneView, Storage, SurfaceShading};
use lobe_io::Job;
use lobe_prt::{BakeMode, BakeOptions, Channels, GlossyLobe, Receivers, Transfer, TransferMatrices, bake};
use lobe_scene::{Bvh, Scene, built_in};
use lobe_sh::{Coefficient as _, Dir, Expansion as _, Rgb, ShVec, Zonal};

use crate::scene_view::{RAYS, cameras, check, options, sky};
use crate::traced::{Seen, traced};
use crate::{device, with};

/// The device of all tests as one without storage buffers; `None` if there is none at all, which is said.
fn bare_device(test: &str) -> Option<Context> {
    Some(with(&device(test)?, &ContextOptions::default().without_storage(true)))
}

fn baked(scene: &Scene, order: usize, mode: BakeMode) -> Transfer {
    let options = BakeOptions::default().order(order).samples(32).mode(mode).bounces(1);
    let receivers = Receivers::at_vertices(scene).unwrap();
    bake(scene, &Bvh::new(scene), &receivers, &options, Job::default()).unwrap().0
}

/// Compares a picture with the values of vertices, interpolated.
pub(crate) fn check_values(
    what: &str,
    context: &Context,
    scene: &Scene,
    shading: &SurfaceShading<'_>,
    values: &[Rgb<f32>],
) {
    let (sky, (gpu, cpu)) = (sky(), cameras(scene));
    let environment = Environment::from(&*sky);
    let view = SceneView::new(context, scene, shading, Some(&environment), &options()).unwrap();
    view.set_camera(&gpu).unwrap();
    view.set_light(&project_env(&sky, 8)).unwrap();
    let shade = |s: &Seen<'_>| if s.is_front { s.at_corners(values) } else { Rgb::ZERO };
    check(what, &view, &traced(scene, cpu, RAYS, |s| sky.radiance(s).widen(), shade));
}

#[test]
fn transfer_in_textures_is_that_of_the_processor_at_every_order() {
    let Some(context) = bare_device("transfer_in_textures_is_that_of_the_processor_at_every_order") else { return };
    assert!(!context.has_storage(), "{context:?}");
    let scene = built_in::ball_over_ground(16);
    for (order, mode) in [(1, BakeMode::Shadowed), (4, BakeMode::Interreflected), (8, BakeMode::Shadowed)] {
        let transfer = baked(&scene, order, mode);
        let light: ShVec<Rgb<f64>> = project_env(&sky(), order);
        let values = transfer.exit_radiance(light.coefficients());
        let shading = SurfaceShading::Vertices(&transfer, &[], Storage::F32);
        check_values(&format!("texture {order}"), &context, &scene, &shading, &values);
    }
}

#[test]
fn one_vector_for_all_colors_is_lit_by_each_color() {
    let Some(context) = bare_device("one_vector_for_all_colors_is_lit_by_each_color") else { return };
    let scene = built_in::ball_over_ground(8);
    let gray = crate::transfer::transfer(&scene, 3, Channels::Gray);
    let values = gray.exit_radiance(project_env(&sky(), 3).coefficients());
    check_values("gray", &context, &scene, &SurfaceShading::Vertices(&gray, &[], Storage::F32), &values);
}

#[test]
fn light_without_shadows_is_that_of_normals_at_vertices() {
    let Some(context) = bare_device("light_without_shadows_is_that_of_normals_at_vertices") else { return };
    let scene = built_in::ball_over_ground(16);
    let light: ShVec<Rgb<f64>> = project_env(&sky(), 3);
    let irradiance = light.convolved(&Zonal::clamped_cosine(3));
    let receivers = Receivers::at_vertices(&scene).unwrap();
    let lit = |(normal, albedo): (&[f32; 3], &[f32; 3])| {
        let e = irradiance.eval(Dir::new(normal.map(f64::from)).unwrap());
        let [r, g, b] = [0, 1, 2].map(|c| (f64::from(albedo[c]) * e.channel(c) / std::f64::consts::PI) as f32);
        Rgb::new(r, g, b)
    };
    let values: Vec<Rgb<f32>> = receivers.normals().iter().zip(receivers.albedos()).map(lit).collect();
    check_values("normals", &context, &scene, &SurfaceShading::Irradiance(3), &values);
}

#[test]
fn half_precision_in_a_texture_is_half_precision_in_a_buffer() {
    let name = "half_precision_in_a_texture_is_half_precision_in_a_buffer";
    let (Some(bare), Some(whole)) = (bare_device(name), device(name)) else { return };
    let scene = built_in::ball_over_ground(8);
    let transfer = baked(&scene, 4, BakeMode::Interreflected);
    let (gpu, _) = cameras(&scene);
    let picture = |context: &Context| {
        let shading = SurfaceShading::Vertices(&transfer, &[], Storage::F16);
        let view = SceneView::new(context, &scene, &shading, None, &options()).unwrap();
        view.set_camera(&gpu).unwrap();
        view.set_light(&project_env(&sky(), 4)).unwrap();
        view.render().unwrap();
        crate::flat3(view.picture().unwrap().pixels())
    };
    let error = crate::relative_difference(picture(&bare), picture(&whole));
    assert!(error < crate::TOLERANCE, "{error:e}");
}

#[test]
fn the_speed_of_copies_is_measured_by_the_command_of_the_device_alone() {
    let Some(context) = bare_device("the_speed_of_copies_is_measured_by_the_command_of_the_device_alone") else {
        return;
    };
    // An emulated device moves more than a megabyte and less than a petabyte a second.
    let speed = BenchReport::copied_bytes_a_second(&context).unwrap();
    assert!((1e6..1e15).contains(&speed), "{speed} bytes a second");
}

#[test]
fn what_needs_buffers_is_refused_by_name() {
    let Some(context) = bare_device("what_needs_buffers_is_refused_by_name") else { return };
    let scene = built_in::ball_over_ground(8);
    let count = scene.vertex_count();
    let matrices = TransferMatrices::new(1, Channels::Gray, vec![0.5; count]).unwrap();
    let shading = SurfaceShading::Glossy(&matrices, GlossyLobe::Phong(8.0), Storage::F32);
    let refused = SceneView::new(&context, &scene, &shading, None, &options()).expect_err("matrices are in buffers");
    assert!(matches!(refused, GpuError::Unsupported { .. }), "{refused:?}");
    assert!(refused.to_string().contains("expected storage buffers and compute shaders"), "{refused}");
}
