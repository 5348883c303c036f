//! Textures whose coordinates are large, against those of the processor.

use lobe_env::project_env;
use lobe_gpu::{Context, Environment, SceneView, SurfaceShading};
use lobe_scene::{Material, Mesh, MeshParts, Scene, Texture, TextureUse, Wrap};
use lobe_sh::{Coefficient as _, Expansion as _, Zonal};

use crate::device;
use crate::scene_view::{RAYS, cameras, check, options, painted_by, sky};
use crate::traced::{Seen, traced};

/// A picture by irradiance against that of the processor.
fn check_irradiance(what: &str, context: &Context, scene: &Scene) {
    let sky = sky();
    let light = project_env(&sky, 3);
    let (gpu, cpu) = cameras(scene);
    let environment = Environment::from(&*sky);
    let shading = SurfaceShading::Irradiance(3);
    let view = SceneView::new(context, scene, &shading, Some(&environment), &options()).unwrap();
    view.set_camera(&gpu).unwrap();
    view.set_light(&light).unwrap();
    let irradiance = light.convolved(&Zonal::clamped_cosine(3));
    let shade = |s: &Seen<'_>| (s.albedo * irradiance.eval(s.normal)).scale(std::f64::consts::FRAC_1_PI);
    check(what, &view, &traced(scene, cpu, RAYS, |s| sky.radiance(s).widen(), shade));
}

#[test]
fn textures_far_from_their_first_period_are_those_of_the_processor() {
    let Some(context) = device("textures_far_from_their_first_period_are_those_of_the_processor") else { return };
    // Steps of single precision are a quarter of the picture there.
    check_irradiance("far", &context, &painted_by([[0.6, 0.2, 4e6], [-0.2, 0.6, -3e6]]));
}

#[test]
fn coordinates_that_overflow_single_precision_leave_a_texture_of_one_color_as_it_is() {
    let test = "coordinates_that_overflow_single_precision_leave_a_texture_of_one_color_as_it_is";
    let Some(context) = device(test) else { return };
    for wrap in [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp] {
        let quad = Mesh::new(MeshParts {
            positions: vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.3]],
            normals: vec![[0.0, 0.0, 1.0]; 4],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            uvs: [vec![[0.0, 3e38], [3e38, -3e38], [-1e20, 2.0], [1.0, 1e30]], Vec::new()],
            material: Some(0),
            ..MeshParts::default()
        });
        let used = TextureUse { texture: 0, uv_set: 0, uv_map: [[3e38, 3e38, -1.0], [1e10, -3e38, 3e38]] };
        let material = Material { base_color_texture: Some(used), ..Material::WHITE };
        let texture = Texture::new(8, 8, vec![[200, 90, 40, 255]; 64], [wrap; 2]);
        let scene = Scene::new(vec![quad.unwrap()], vec![material], vec![texture]).unwrap();
        check_irradiance(&format!("overflow {wrap:?}"), &context, &scene);
    }
}
