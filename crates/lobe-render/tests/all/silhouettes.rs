//! Silhouettes: coverage of pixels in which surfaces end, and gaps in bodies that are open.

use lobe_image::Picture;
use lobe_io::Job;
use lobe_render::{Camera, LitPicture, View, ViewOptions, light_by_irradiance, scene_picture};
use lobe_scene::{Bvh, Material, Mesh, MeshParts, Scene};
use lobe_sh::{Coefficient as _, Dir, Rgb, ShVec};

/// Columns and rows.
const SIZE: usize = 32;

/// A mesh of flat polygons, each of four corners, with the front where they run counter-clockwise.
fn mesh(name: &str, polygons: &[[[f32; 3]; 4]]) -> Mesh {
    let parts = MeshParts {
        name: name.into(),
        positions: polygons.as_flattened().to_vec(),
        triangles: (0..polygons.len() as u32)
            .flat_map(|k| [[0, 1, 2], [0, 2, 3]].map(|t| t.map(|i| 4 * k + i)))
            .collect(),
        material: Some(0),
        ..MeshParts::default()
    };
    Mesh::new(parts).unwrap()
}

fn white(meshes: Vec<Mesh>, double_sided: bool) -> Scene {
    Scene::new(meshes, vec![Material { double_sided, ..Material::WHITE }], vec![]).unwrap()
}

/// From above: x to the right, y up, each from -1 to 1.
fn above() -> Camera {
    Camera::orthographic(View::from_eye(Dir::Z), 1.0)
}

fn lit(scene: &Scene, options: &ViewOptions) -> LitPicture {
    let light = ShVec::constant(1, Rgb::splat(1.0));
    let black = |_: Dir| Rgb::ZERO;
    light_by_irradiance(scene, &Bvh::new(scene), &light.into(), &above(), options, black, Job::default()).unwrap()
}

fn view() -> ViewOptions {
    ViewOptions::default().width(SIZE).height(SIZE)
}

/// The part of each pixel that lies right of a line `x = slope y`, by 64 by 64 points.
fn covered(towards: [f64; 2], slope: f64) -> Vec<f64> {
    let [right, up] = [above().view().point([1.0, 0.0, 0.0]), above().view().point([0.0, 1.0, 0.0])];
    let of = |pixel: usize| {
        let inside = (0..64 * 64).filter(|k| {
            let at = |pixel: usize, k: usize| (pixel as f64 + (k as f64 + 0.5) / 64.0) / (0.5 * SIZE as f64) - 1.0;
            let (u, v) = (at(pixel % SIZE, k % 64), -at(pixel / SIZE, k / 64));
            let [x, y] = [0, 1].map(|c| right[c] * u + up[c] * v);
            towards[0] * x + towards[1] * y > slope * (towards[0] * y - towards[1] * x)
        });
        inside.count() as f64 / 4096.0
    };
    (0..SIZE * SIZE).map(of).collect()
}

#[test]
fn the_coverage_of_an_edge_is_known_to_a_sixteenth_and_by_regular_rays_only_to_a_third() {
    // Edges at which a regular grid is worst: nearly along rows and columns.
    for (towards, slope) in [([1.0, 0.0], 0.04), ([0.0, 1.0], 0.04), ([1.0, 0.0], 0.6)] {
        let [a, b] = [-2.0_f64, 2.0].map(|y| {
            let x = slope * y;
            [towards[0] * x - towards[1] * y, towards[1] * x + towards[0] * y]
        });
        let far = |p: [f64; 2]| [0, 1].map(|k| p[k] + 4.0 * towards[k]);
        let corner = |p: [f64; 2]| [p[0] as f32, p[1] as f32, 0.0];
        let scene = white(vec![mesh("half", &[[corner(b), corner(a), corner(far(a)), corner(far(b))]])], true);
        let expected = covered(towards, slope);
        let error = |options: &ViewOptions| {
            let found = lit(&scene, options).coverage;
            found.iter().zip(&expected).fold(0.0_f64, |most, (a, b)| most.max((f64::from(*a) - b).abs()))
        };
        let (fine, coarse) = (error(&view()), error(&view().edge_rays(0)));
        assert!(fine <= 0.125 + 1e-6, "towards {towards:?}, slope {slope}: {fine}");
        assert!(coarse > 1.5 * fine, "towards {towards:?}, slope {slope}: {coarse} against {fine}");
    }
}

#[test]
fn what_is_inside_of_a_surface_is_left_to_the_regular_rays() {
    // A plane that fills the picture, with a color that changes from ray to ray.
    let plane = mesh("plane", &[[[-2.0, -2.0, 0.0], [2.0, -2.0, 0.0], [2.0, 2.0, 0.0], [-2.0, 2.0, 0.0]]]);
    let (scene, radiance) = (white(vec![plane], false), |hit: &lobe_render::SceneHit<'_>| {
        Rgb::splat(f64::from(hit.hit().u).mul_add(37.0, f64::from(hit.hit().v)).sin())
    });
    let picture = |options: &ViewOptions| {
        scene_picture(&scene, &Bvh::new(&scene), &above(), options, |_| Rgb::ZERO, radiance, Job::default()).unwrap()
    };
    assert_eq!(picture(&view()), picture(&view().edge_rays(0)), "no pixel is looked at again");
}

/// A lid with a gap of so many pixels over a floor that shows its back, as the inside of an open body does.
fn lid_with_gap(pixels: f32) -> Scene {
    let half = pixels / SIZE as f32;
    let y = 2.0;
    let lid = |left: f32, right: f32| [[left, -y, 0.0], [right, -y, 0.0], [right, y, 0.0], [left, y, 0.0]];
    let mut floor = lid(-2.0, 2.0).map(|[x, y, _]| [x, y, -1.0]);
    floor.reverse();
    white(vec![mesh("lid", &[lid(-2.0, -half), lid(half, 2.0)]), mesh("inside", &[floor])], false)
}

#[test]
fn a_narrow_gap_in_an_open_body_is_no_black_line_and_a_wide_one_is_black() {
    let darkest = |picture: &Picture| picture.pixels().iter().fold(f32::INFINITY, |least, p| least.min(p[1]));
    for pixels in [0.1, 0.5, 1.0, 1.7] {
        let (filled, plain) = (lit(&lid_with_gap(pixels), &view()), lit(&lid_with_gap(pixels), &view().edge_rays(0)));
        let found = darkest(&filled.picture);
        assert!((found - 1.0).abs() < 1e-5, "a gap of {pixels} pixels: {found}");
        assert!(pixels < 1.0 || darkest(&plain.picture) < 0.8, "a gap of {pixels} pixels is there");
    }
    let wide = lit(&lid_with_gap(6.0), &view()).picture;
    assert_eq!(darkest(&wide), 0.0, "a hole of six pixels");
    // The edge of the hole is as its coverage has it: half of the pixel at a whole number and a half.
    let edge = lit(&lid_with_gap(7.0), &view()).picture;
    let on_edge: Vec<f32> = edge.pixels().iter().map(|p| p[1]).filter(|p| *p > 0.0 && *p < 1.0 - 1e-5).collect();
    assert_eq!(on_edge.len(), 2 * SIZE, "pixels on the two edges");
    assert!(on_edge.iter().all(|half| (half - 0.5).abs() < 0.1), "pixels on the edges: {on_edge:?}");
}
