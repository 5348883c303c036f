//! Silhouettes in the window while things move: several samples of depth in each pixel.

use lobe_env::project_env;
use lobe_gpu::{GpuCamera, SceneView, SceneViewOptions, SurfaceShading, ViewOutput};
use lobe_scene::{Material, Mesh, MeshParts, Scene, built_in};
use lobe_sh::{Dir, Rgb, ShVec};

use crate::device;
use crate::scene_view::sky;

/// Columns and rows.
const SIZE: u32 = 48;

/// The distance of the eye, from which its rays are almost parallel.
const FAR: f64 = 1000.0;

/// Of four samples, each stands for a quarter; the place of each in the pixel is off by up to an eighth.
const QUARTER: f64 = 0.25;

/// A white square that is turned by a little, so that its edges cross rows and columns slowly.
fn turned_square() -> Scene {
    let (sin, cos) = 0.1_f32.sin_cos();
    let corner = |x: f32, y: f32| [cos * x - sin * y, sin * x + cos * y, 0.0];
    let parts = MeshParts {
        name: "square".into(),
        positions: vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        material: Some(0),
        ..MeshParts::default()
    };
    Scene::new(vec![Mesh::new(parts).unwrap()], vec![Material::WHITE], vec![]).unwrap()
}

/// The display of a scene that is white all over before black, in linear light of each pixel.
fn shown(context: &lobe_gpu::Context, options: &SceneViewOptions) -> Vec<f64> {
    let scene = turned_square();
    let white = vec![Rgb::new(1.0, 1.0, 1.0); scene.vertex_count()];
    let shading = SurfaceShading::Radiance(&white);
    let view = SceneView::new(context, &scene, &shading, None, options).unwrap();
    view.set_camera(&GpuCamera::look_at([0.0, 0.0, FAR], [0.0; 3], (1.6 / FAR).atan()).unwrap()).unwrap();
    view.render().unwrap();
    let bytes = view.display().unwrap();
    bytes.as_chunks::<3>().0.iter().map(|[r, _, _]| f64::from(*r) / 255.0).collect()
}

fn display() -> SceneViewOptions {
    SceneViewOptions::default().width(SIZE).height(SIZE).rays(1).output(ViewOutput::Display)
}

#[test]
fn the_edges_of_a_display_alone_are_covered_to_a_quarter() {
    let Some(context) = device("the_edges_of_a_display_alone_are_covered_to_a_quarter") else { return };
    // The part that is covered by samples on a fine grid: white or black, whatever the tone.
    let fine = SceneViewOptions::default().width(8 * SIZE).height(8 * SIZE).rays(1).multisample(false);
    let fine = shown(&context, &fine);
    let side = SIZE as usize;
    let covered = |i: usize| {
        let (x, y) = (i % side, i / side);
        let inside = (0..64).map(|k| fine[(8 * y + k / 8) * 8 * side + 8 * x + k % 8]);
        inside.sum::<f64>() / 64.0
    };
    let worst = |found: &[f64]| (0..found.len()).fold(0.0_f64, |most, i| most.max((found[i] - covered(i)).abs()));
    let (smooth, plain) = (shown(&context, &display()), shown(&context, &display().multisample(false)));
    assert!(worst(&smooth) < 1.5 * QUARTER, "four samples: {}", worst(&smooth));
    assert!(worst(&plain) > 1.5 * QUARTER, "one sample: {}", worst(&plain));
    let shades = |found: &[f64]| found.iter().filter(|c| **c > 0.1 && **c < 0.9).count();
    assert!(shades(&smooth) > 60 && shades(&plain) == 0, "{} and {} gray pixels", shades(&smooth), shades(&plain));
    let all: f64 = (0..smooth.len()).map(covered).sum();
    let found: f64 = smooth.iter().sum();
    assert!((found / all - 1.0).abs() < 5e-3, "the square keeps its area: {found} of {all}");
}

#[test]
fn samples_of_depth_are_of_the_display_alone_and_leave_the_inside_as_it_is() {
    let test = "samples_of_depth_are_of_the_display_alone_and_leave_the_inside_as_it_is";
    let Some(context) = device(test) else { return };
    let scene = built_in::ball_over_ground(24);
    let light: ShVec<Rgb<f64>> = project_env(&sky(), 3);
    let bytes = |options: &SceneViewOptions| {
        let view = SceneView::new(&context, &scene, &SurfaceShading::Irradiance(3), None, options).unwrap();
        view.set_camera(&GpuCamera::framing(scene.world_bounds(), Dir::from_angles(1.1, -0.6), 0.3).unwrap()).unwrap();
        view.set_light(&light).unwrap();
        view.render().unwrap();
        (view.display().unwrap(), view.renderer().bytes())
    };
    let ((smooth, more), (plain, less)) = (bytes(&display()), bytes(&display().multisample(false)));
    assert!(more > less, "{more} bytes with samples, {less} without");
    let differing = smooth.iter().zip(&plain).filter(|(a, b)| a.abs_diff(**b) > 2).count() as f64;
    let part = differing / plain.len() as f64;
    assert!(part > 0.0 && part < 0.15, "{part} of the bytes differ: those at edges");
    // Several rays, or light that is kept, are as they were.
    for options in [display().rays(2), display().output(ViewOutput::LightAndDisplay)] {
        assert_eq!(bytes(&options), bytes(&options.multisample(false)), "{options:?}");
    }
}
