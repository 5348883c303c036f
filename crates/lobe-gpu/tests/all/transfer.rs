//! Matte receivers: every order, gray and colored, in clusters, in half precision, in number.

use lobe_env::project_env;
use lobe_gpu::{SceneView, Storage, SurfaceShading};
use lobe_io::Job;
use lobe_prt::{Channels, CompressOptions, CompressedTransfer, Lightmap, Transfer, WeightBits};
use lobe_scene::{Mesh, MeshParts, Scene, built_in};
use lobe_sh::{Coefficient as _, Expansion as _, Rgb, ShVec};
use lobe_testkit::Random;

use crate::scene_view::{RAYS, cameras, check, options, sky};
use crate::traced::by_texels;
use crate::traced::{Seen, traced};
use crate::without_storage::check_values;
use crate::{device, flat3, relative_difference};

/// Transfer alike at all vertices but for a little: devices interpolate between corners that they snap to a 256th of a
/// sample.
pub(crate) fn transfer(scene: &Scene, order: usize, channels: Channels) -> Transfer {
    let (mut random, n) = (Random::new(order as u64), order * order * channels.count());
    let (common, own) = (random.signed_vec(n), random.signed_vec(scene.vertex_count() * n));
    let coefficients = own.iter().enumerate().map(|(k, c)| (common[k % n] + 0.05 * c) as f32).collect();
    Transfer::new(order, channels, coefficients).unwrap()
}

pub(crate) fn light(coefficients: usize) -> Vec<Rgb<f64>> {
    let mut random = Random::new(99);
    (0..coefficients).map(|_| Rgb::new(random.signed(), random.signed(), random.signed())).collect()
}

#[test]
fn transfer_of_every_order_gives_the_radiance_of_the_processor() {
    let Some(context) = device("transfer_of_every_order_gives_the_radiance_of_the_processor") else { return };
    let scene = built_in::ball_over_ground(8);
    for order in 1..=8 {
        for channels in [Channels::Gray, Channels::Rgb] {
            let transfer = transfer(&scene, order, channels);
            let values = transfer.exit_radiance(project_env(&sky(), order).coefficients());
            let shading = SurfaceShading::Vertices(&transfer, &[], Storage::F32);
            check_values(&format!("transfer {order} {channels:?}"), &context, &scene, &shading, &values);
        }
    }
}

#[test]
fn bands_that_a_light_lacks_are_none_also_after_one_that_has_them() {
    let Some(context) = device("bands_that_a_light_lacks_are_none_also_after_one_that_has_them") else { return };
    let scene = built_in::ball_over_ground(8);
    let transfer = transfer(&scene, 4, Channels::Rgb);
    let shading = SurfaceShading::Vertices(&transfer, &[], Storage::F32);
    let view = SceneView::new(&context, &scene, &shading, None, &options()).unwrap();
    let (gpu, cpu) = cameras(&scene);
    view.set_camera(&gpu).unwrap();
    for order in [4, 2, 5] {
        let light: ShVec<Rgb<f64>> = project_env(&sky(), order);
        view.set_light(&light).unwrap();
        let values = transfer.exit_radiance(light.coefficients());
        let shade = |s: &Seen<'_>| if s.is_front { s.at_corners(&values) } else { Rgb::ZERO };
        check(&format!("light of order {order}"), &view, &traced(&scene, cpu, RAYS, |_| Rgb::ZERO, shade));
    }
}

#[test]
fn half_precision_costs_what_is_said() {
    let Some(context) = device("half_precision_costs_what_is_said") else { return };
    let scene = built_in::ball_over_ground(8);
    for channels in [Channels::Gray, Channels::Rgb] {
        // Nine coefficients: a word is left half empty.
        for order in [3, 4] {
            // Unlike at all vertices: both pictures are of one device.
            let numbers = Random::new(4).signed_vec(order * order * channels.count() * scene.vertex_count());
            let numbers = numbers.into_iter().map(|c| c as f32).collect();
            let transfer = Transfer::new(order, channels, numbers).unwrap();
            let picture = |storage| {
                let shading = SurfaceShading::Vertices(&transfer, &[], storage);
                let view = SceneView::new(&context, &scene, &shading, None, &options()).unwrap();
                view.set_camera(&cameras(&scene).0).unwrap();
                view.set_light(&project_env(&sky(), order)).unwrap();
                view.render().unwrap();
                flat3(view.picture().unwrap().pixels())
            };
            let worst = relative_difference(picture(Storage::F16), picture(Storage::F32));
            assert!(worst > 1e-6 && worst < 3e-4, "order {order}, {channels:?}: {worst:e}");
        }
    }
}

#[test]
fn clusters_give_the_radiance_of_the_processor_in_every_number_format() {
    let Some(context) = device("clusters_give_the_radiance_of_the_processor_in_every_number_format") else { return };
    let scene = built_in::ball_over_ground(8);
    for (channels, bits) in
        [(Channels::Gray, WeightBits::F32), (Channels::Rgb, WeightBits::U16), (Channels::Rgb, WeightBits::U8)]
    {
        let transfer = transfer(&scene, 3, channels);
        let options = CompressOptions::default().clusters(5).components(6).weights(bits);
        let (clustered, _) = CompressedTransfer::new(&transfer, &options, Job::default()).unwrap();
        let values = clustered.exit_radiance(project_env(&sky(), 3).coefficients());
        let shading = SurfaceShading::Clusters(&clustered);
        check_values(&format!("clusters {channels:?} {bits:?}"), &context, &scene, &shading, &values);
    }
}

#[test]
fn more_receivers_than_one_row_of_workgroups_are_all_shaded() {
    let Some(context) = device("more_receivers_than_one_row_of_workgroups_are_all_shaded") else { return };
    // A row has 65535 groups of 64; the last texels are those along the far edge.
    let width = 2064_usize;
    assert!(width.pow(2) > 65535 * 64 + width, "a row of texels is beyond");
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0_f32]];
    let mesh = Mesh::new(MeshParts {
        positions: corners.map(|[u, v]| [2.0 * u - 1.0, 2.0 * v - 1.0, 0.0]).into(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        uvs: [corners.into(), Vec::new()],
        ..MeshParts::default()
    });
    let scene = Scene::new(vec![mesh.unwrap()], Vec::new(), Vec::new()).unwrap();
    let lightmap = Lightmap::new(&scene, width).unwrap();
    // Dark but for the rows beyond, and smooth: the picture has fewer pixels than there are texels.
    let (first, end) = (65535 * 64, width.pow(2));
    let value = |k: usize| if k < first { 0.25 } else { 0.25 + 4.0 * (k - first) as f32 / (end - first) as f32 };
    let transfer = Transfer::new(1, Channels::Gray, (0..end).map(value).collect()).unwrap();
    let light = ShVec::from_vec(vec![Rgb::new(1.0, 2.0, 0.5)]).unwrap();
    let values = transfer.exit_radiance(light.coefficients());
    let shading = SurfaceShading::Lightmap(&transfer, &lightmap, Storage::F32);
    let view = SceneView::new(&context, &scene, &shading, None, &options()).unwrap();
    // Near the far edge, so that the rows beyond are many pixels.
    let eye = crate::traced::Eye { eye: [0.0, 0.98, 0.1], target: [0.0, 0.985, 0.0], half_angle: 0.2 };
    view.set_camera(&lobe_gpu::GpuCamera::look_at(eye.eye, eye.target, eye.half_angle).unwrap()).unwrap();
    view.set_light(&light).unwrap();
    let shade = by_texels((&scene, &lightmap), &values);
    let expected = traced(&scene, eye, RAYS, |_| Rgb::ZERO, shade);
    let bright = expected.pixels().iter().filter(|pixel| pixel[1] > 1.0).count();
    assert!(bright > 100, "{bright} pixels show the rows beyond");
    check("rows of workgroups", &view, &expected);
}
