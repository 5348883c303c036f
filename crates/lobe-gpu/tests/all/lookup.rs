//! Environments in every mapping, behind a scene, towards the whole sphere.

use lobe_env::{MappedMap, Mapping};
use lobe_gpu::{Environment, GpuCamera, SceneView, SceneViewOptions, SurfaceShading};
use lobe_scene::{Mesh, MeshParts, Scene};
use lobe_sh::{Coefficient as _, Dir, Rgb, Rotation};
use lobe_testkit::Random;

use crate::traced::{Eye, traced};
use crate::{device, flat3, relative_difference, tolerance};

/// Pixels along each side of one of six pictures, and half its angle: a cone as wide as a face of a cube has corners.
const SIDE: u32 = 40;
const HALF_ANGLE: f64 = 0.96;

/// Every texel another color, so that a wrong neighbor shows.
fn noise(mapping: Mapping, width: usize, height: usize) -> MappedMap {
    let mut random = Random::new(11);
    let texels = (0..width * height)
        .map(|_| Rgb::new(random.unit() as f32, random.unit() as f32, 0.5 + 0.5 * random.unit() as f32))
        .collect();
    MappedMap::new(mapping, width, height, texels).unwrap()
}

/// A triangle at the origin, which is behind all eyes.
fn hidden() -> Scene {
    let parts = MeshParts {
        positions: vec![[0.0; 3], [1e-3, 0.0, 0.0], [0.0, 1e-3, 0.0]],
        triangles: vec![[0, 1, 2]],
        ..MeshParts::default()
    };
    Scene::new(vec![Mesh::new(parts).unwrap()], Vec::new(), Vec::new()).unwrap()
}

#[test]
fn lookups_in_every_mapping_are_those_of_the_processor() {
    let Some(context) = device("lookups_in_every_mapping_are_those_of_the_processor") else { return };
    let scene = hidden();
    let options = SceneViewOptions::default().width(SIDE).height(SIDE).rays(1);
    for mapping in Mapping::ALL {
        for width in [1, 2, 16, 63] {
            let map = noise(mapping, width, mapping.height_for(width));
            let environment = Environment::from(&map);
            let view = SceneView::new(&context, &scene, &SurfaceShading::Irradiance(1), Some(&environment), &options);
            let view = view.unwrap();
            for axis in [Dir::X, Dir::Y, Dir::Z, -Dir::X, -Dir::Y, -Dir::Z] {
                // No eye looks straight up or down, where up in the picture would be no direction.
                let towards = Rotation::from_euler_zyz(0.3, 0.5, -0.4).rotate_dir(axis).to_array();
                let eye = Eye { eye: towards, target: towards.map(|c| 2.0 * c), half_angle: HALF_ANGLE };
                view.set_camera(&GpuCamera::look_at(eye.eye, eye.target, HALF_ANGLE).unwrap()).unwrap();
                view.render().unwrap();
                let found = view.picture().unwrap();
                let size = [SIDE as usize, SIDE as usize, 1];
                let expected = traced(&scene, eye, size, |s| map.radiance(s).widen(), |_| Rgb::ZERO);
                let worst = relative_difference(flat3(found.pixels()), flat3(expected.pixels()));
                assert!(worst < tolerance(&view), "{mapping}, {width}, {axis:?}: {worst:e}");
            }
        }
    }
}
