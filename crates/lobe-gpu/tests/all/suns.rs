//! Suns beside an expansion, against rays to their discs.

use lobe_env::{EnvMap, SceneLight, Sun, project_env};
use lobe_gpu::{
    Context, ContextOptions, Environment, GpuError, SceneView, SceneViewOptions, Storage, SunsApart, SurfaceShading,
};
use lobe_image::{Picture, Tone};
use lobe_io::Job;
use lobe_prt::{AlbedoMode, BakeMode, BakeOptions, GlossyLobe, Lightmap, Receivers, Transfer, bake};
use lobe_scene::{Bvh, Ray, Scene, SurfaceRays, built_in};
use lobe_sh::sphere::vector::{dot, tangents_along_z};
use lobe_sh::{Coefficient as _, Dir, Expansion as _, Rgb, ShVec, Zonal};

use crate::scene_view::{cameras, check, options, painted, sky};
use crate::traced::{Seen, by_texels, traced};
use crate::{device, pass_names, with};

/// A picture in which the edge of a shadow is a few pixels wide.
const SIZE: [usize; 2] = [640, 480];

/// Rays to a disc.
const RAYS: usize = 64;

/// The difference of a picture to that by rays, over the mean of that: what the penumbra of several blockers at once,
/// and texels of a thousandth of the scene, leave.
const MEAN_ERROR: f64 = 0.0125;

/// Pixels from the edge of a shadow where it may lie too.
const BLUR: isize = 2;

/// The part of pixels at most that are like none of those so near, by more than a tenth of the brightest.
const AWAY: f64 = 2e-4;

/// A sun of this height and azimuth in degrees, half a degree wide unless said otherwise.
fn sun(height: f64, azimuth: f64, diameter: f64) -> Sun {
    let direction = Dir::from_angles((90.0 - height).to_radians(), azimuth.to_radians());
    Sun { direction, irradiance: Rgb::new(3.0, 2.5, 2.0), angular_diameter: diameter.to_radians(), texels: 0 }
}

fn of_size(rays: u32) -> SceneViewOptions {
    SceneViewOptions::default().width(SIZE[0] as u32).height(SIZE[1] as u32).rays(rays)
}

/// How much of a disc a hit sees, by rays.
fn seen_of(surfaces: &SurfaceRays<'_>, scene: &Scene, sun: &Sun, seen: &Seen<'_>) -> f64 {
    let surface = scene.surface(&seen.hit);
    let side = if seen.is_front { 1.0 } else { -1.0 };
    let plane = surface.geometric_normal.map(|c| side * c);
    let axis = sun.direction.to_array();
    let origin = surfaces.bvh().origin_above(surface.position, plane);
    let [u, v] = tangents_along_z(axis);
    let passes = (0..RAYS).filter(|k| {
        let radius = (0.5 * sun.angular_diameter).tan() * ((*k as f64 + 0.5) / RAYS as f64).sqrt();
        let (sin, cos) = (2.399963 * *k as f64).sin_cos();
        let s = Dir::new([0, 1, 2].map(|i| axis[i] + radius * (cos * u[i] + sin * v[i]))).unwrap().to_array();
        dot(s, plane.map(f64::from)) > 0.0 && !surfaces.is_occluded(&Ray::new(origin, s.map(|c| c as f32)))
    });
    passes.count() as f64 / RAYS as f64
}

/// What a hit sends back of suns: albedo / pi * E.
fn sent_back(scene: &Scene, surfaces: &SurfaceRays<'_>, suns: &[Sun], seen: &Seen<'_>) -> Rgb<f64> {
    let irradiance = suns.iter().fold(Rgb::ZERO, |all, sun| {
        let open = sun.irradiance_at(seen.normal);
        if open == Rgb::ZERO { all } else { all + open.scale(seen_of(surfaces, scene, sun, seen)) }
    });
    (seen.albedo * irradiance).scale(std::f64::consts::FRAC_1_PI)
}

/// The picture that is expected of suns and a shading of the rest.
fn expected(
    scene: &Scene,
    light: &SceneLight,
    [width, height, rays]: [usize; 3],
    rest: impl Fn(&Seen<'_>) -> Rgb<f64> + Sync,
) -> Picture {
    let bvh = Bvh::new(scene);
    let surfaces = SurfaceRays::new(scene, &bvh);
    let shade = |seen: &Seen<'_>| rest(seen) + sent_back(scene, &surfaces, light.suns(), seen);
    traced(scene, cameras(scene).1, [width, height, rays], |_| Rgb::ZERO, shade)
}

fn picture(
    context: &Context,
    scene: &Scene,
    shading: (&SurfaceShading<'_>, SunsApart<'_>),
    light: &SceneLight,
    options: &SceneViewOptions,
) -> Picture {
    let view = SceneView::with_suns(context, scene, shading, None, options).unwrap();
    view.set_camera(&cameras(scene).0).unwrap();
    view.set_scene_light(light).unwrap();
    view.render().unwrap();
    view.picture().unwrap()
}

/// Compares a picture with that by rays: the mean difference, and where the edges of shadows are.
fn compare(what: &str, found: &Picture, expected: &Picture) {
    let [width, height] = [found.width() as isize, found.height() as isize];
    if let Some(folder) = std::env::var_os("LOBE_GPU_PICTURES") {
        let folder = std::path::Path::new(&folder);
        for (name, picture) in [("gpu", found), ("cpu", expected)] {
            picture.write_png(folder.join(format!("suns {what} {name}.png")), &Tone::PLAIN).unwrap();
        }
    }
    let green = |picture: &Picture, x: isize, y: isize| f64::from(picture.pixels()[(y * width + x) as usize][1]);
    let pixels = || (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let mean = pixels().map(|(x, y)| green(expected, x, y)).sum::<f64>() / (width * height) as f64;
    let largest = pixels().map(|(x, y)| green(expected, x, y)).fold(0.0, f64::max);
    let error = pixels().map(|(x, y)| (green(found, x, y) - green(expected, x, y)).abs()).sum::<f64>();
    let error = error / (width * height) as f64 / mean;
    let is_away = |(x, y): &(isize, isize)| {
        let near = |c: isize, most: isize| (c - BLUR).max(0)..(c + BLUR + 1).min(most);
        let around = near(*y, height).flat_map(|j| near(*x, width).map(move |i| green(expected, i, j)));
        let [low, high] = around.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], c| [a.min(c), b.max(c)]);
        let value = green(found, *x, *y);
        !(low - 0.1 * largest..=high + 0.1 * largest).contains(&value)
    };
    let away = pixels().filter(is_away).count() as f64 / (width * height) as f64;
    assert!(error < MEAN_ERROR && away < AWAY, "{what}: mean error {error}, {away} of the pixels away");
}

fn zero() -> ShVec<Rgb<f64>> {
    ShVec::zero(3)
}

/// Compares pictures of suns alone.
fn check_shadows(test: &str, scene: &Scene, suns: &[(&str, Sun)]) {
    let Some(context) = device(test) else { return };
    for (what, sun) in suns {
        let light = SceneLight::new(zero(), vec![*sun]);
        let shading = (&SurfaceShading::Irradiance(3), SunsApart::Shadowed(1));
        let found = picture(&context, scene, shading, &light, &of_size(1));
        compare(what, &found, &expected(scene, &light, [SIZE[0], SIZE[1], 1], |_| Rgb::ZERO));
    }
}

#[test]
fn shadows_of_suns_lie_where_rays_find_them() {
    let suns = [("ball", sun(40.0, 20.0, 0.5)), ("ball wide", sun(55.0, -70.0, 4.0))];
    check_shadows("shadows_of_suns_lie_where_rays_find_them", &built_in::ball_over_ground(64), &suns);
}

#[test]
fn a_sun_low_over_a_terrain_leaves_its_slopes_in_light() {
    let suns = [("terrain", sun(12.0, 35.0, 0.5)), ("terrain behind", sun(25.0, 170.0, 0.5))];
    check_shadows("a_sun_low_over_a_terrain_leaves_its_slopes_in_light", &built_in::terrain(96), &suns);
}

#[test]
fn no_light_leaks_at_the_foot_of_a_wall() {
    // Tall beside the cone to the disc there.
    let suns = [("still life", sun(25.0, -36.0, 0.7)), ("still life wide", sun(25.0, -36.0, 3.0))];
    check_shadows("no_light_leaks_at_the_foot_of_a_wall", &built_in::still_life(48), &suns);
}

/// Transfer at vertices.
fn baked(scene: &Scene, mode: BakeMode, albedo: AlbedoMode) -> Transfer {
    let options = BakeOptions::default().order(3).samples(32).mode(mode).bounces(1).albedo(albedo);
    let receivers = Receivers::at_vertices(scene).unwrap();
    bake(scene, &Bvh::new(scene), &receivers, &options, Job::default()).unwrap().0
}

/// `T L - D S`, of receivers.
fn reflected(whole: &Transfer, direct: &Transfer, light: &SceneLight) -> Vec<Rgb<f32>> {
    let all = whole.exit_radiance(light.whole().coefficients());
    let suns = direct.exit_radiance(light.of_suns().coefficients());
    all.into_iter().zip(suns).map(|(all, sun)| all - sun).collect()
}

/// A sky with two suns of unlike colors.
fn two_suns() -> SceneLight {
    let other = Sun { irradiance: Rgb::new(0.2, 0.7, 1.5), ..sun(60.0, 140.0, 1.0) };
    SceneLight::new(project_env(&sky(), 3), vec![sun(40.0, 20.0, 0.5), other])
}

#[test]
fn what_surfaces_reflect_of_suns_is_in_transfer_and_their_direct_light_is_not() {
    let name = "what_surfaces_reflect_of_suns_is_in_transfer_and_their_direct_light_is_not";
    let Some(context) = device(name) else { return };
    let (scene, light) = (built_in::ball_over_ground(48), two_suns());
    let [whole, direct] = [BakeMode::Interreflected, BakeMode::Shadowed].map(|m| baked(&scene, m, AlbedoMode::Vertex));
    let values = reflected(&whole, &direct, &light);
    let size = [SIZE[0], SIZE[1], 1];
    let rest = |s: &Seen<'_>| if s.is_front { s.at_corners(&values) } else { Rgb::ZERO };
    let expected = expected(&scene, &light, size, rest);
    let shading = SurfaceShading::Vertices(&whole, &[], Storage::F32);
    let apart = SunsApart::Reflected(2, &direct);
    compare("reflected", &picture(&context, &scene, (&shading, apart), &light, &of_size(1)), &expected);
    // In pieces, and with transfer in a texture, as in WebGL 2.
    let narrow = with(&context, &ContextOptions::default().max_storage_binding(1 << 16));
    compare("pieces", &picture(&narrow, &scene, (&shading, apart), &light, &of_size(1)), &expected);
    let bare = with(&context, &ContextOptions::default().without_storage(true));
    compare("without storage", &picture(&bare, &scene, (&shading, apart), &light, &of_size(1)), &expected);
    // Where the radiance is computed elsewhere.
    let given = SurfaceShading::Radiance(&values);
    for (what, context) in [("given", &context), ("given without storage", &bare)] {
        let apart = SunsApart::Shadowed(2);
        compare(what, &picture(context, &scene, (&given, apart), &light, &of_size(1)), &expected);
    }
}

#[test]
fn triangles_in_pieces_have_the_same_shadows() {
    let Some(context) = device("triangles_in_pieces_have_the_same_shadows") else { return };
    let (scene, light) = (built_in::ball_over_ground(48), two_suns());
    let shading = (&SurfaceShading::Irradiance(3), SunsApart::Shadowed(2));
    let whole = picture(&context, &scene, shading, &light, &options());
    let narrow = with(&context, &ContextOptions::default().max_storage_binding(1 << 16));
    assert_eq!(picture(&narrow, &scene, shading, &light, &options()).pixels(), whole.pixels(), "in pieces");
}

#[test]
fn suns_shine_through_holes_and_on_the_color_of_each_pixel() {
    let Some(context) = device("suns_shine_through_holes_and_on_the_color_of_each_pixel") else { return };
    // Textures, colors of vertices, holes and a side that is not double-sided.
    let (scene, light) = (painted(), two_suns());
    let [whole, direct] = [BakeMode::Interreflected, BakeMode::Shadowed].map(|m| baked(&scene, m, AlbedoMode::None));
    let values = reflected(&whole, &direct, &light);
    let rest = |s: &Seen<'_>| if s.is_front { s.albedo * s.at_corners(&values) } else { Rgb::ZERO };
    let expected = expected(&scene, &light, [SIZE[0], SIZE[1], 1], rest);
    let shading = SurfaceShading::Demodulated(&whole, Storage::F32);
    let apart = SunsApart::Reflected(2, &direct);
    compare("holes", &picture(&context, &scene, (&shading, apart), &light, &of_size(1)), &expected);
}

#[test]
fn suns_lie_beside_what_a_lightmap_holds() {
    let Some(context) = device("suns_lie_beside_what_a_lightmap_holds") else { return };
    let (scene, light) = (crate::scene_view::unfolded(), two_suns());
    let width = 16;
    let lightmap = Lightmap::new(&scene, width).unwrap();
    let mut random = lobe_testkit::Random::new(5);
    let mut noise = || random.signed_vec(width * width * 27).into_iter().map(|x| 0.05 * x as f32).collect();
    let [whole, direct] = [0, 1].map(|_| Transfer::new(3, lobe_prt::Channels::Rgb, noise()).unwrap());
    let values = reflected(&whole, &direct, &light);
    let expected = expected(&scene, &light, [SIZE[0], SIZE[1], 1], by_texels((&scene, &lightmap), &values));
    let shading = SurfaceShading::Lightmap(&whole, &lightmap, Storage::F32);
    let apart = SunsApart::Reflected(2, &direct);
    compare("lightmap", &picture(&context, &scene, (&shading, apart), &light, &of_size(1)), &expected);
}

#[test]
fn suns_without_shadows_are_the_irradiance_of_normals() {
    let Some(context) = device("suns_without_shadows_are_the_irradiance_of_normals") else { return };
    let (scene, light) = (painted(), two_suns());
    let irradiance = light.rest().convolved(&Zonal::clamped_cosine(3));
    let shade = |s: &Seen<'_>| {
        let suns = light.suns().iter().fold(Rgb::ZERO, |all, sun| all + sun.irradiance_at(s.normal));
        (s.albedo * (irradiance.eval(s.normal) + suns)).scale(std::f64::consts::FRAC_1_PI)
    };
    let expected = traced(&scene, cameras(&scene).1, crate::scene_view::RAYS, |_| Rgb::ZERO, shade);
    let shading = SurfaceShading::Irradiance(3);
    let view = SceneView::with_suns(&context, &scene, (&shading, SunsApart::Unshadowed), None, &options()).unwrap();
    view.set_camera(&cameras(&scene).0).unwrap();
    view.set_scene_light(&light).unwrap();
    check("suns unshadowed", &view, &expected);
}

#[test]
fn a_view_without_suns_has_them_in_its_expansion() {
    let Some(context) = device("a_view_without_suns_has_them_in_its_expansion") else { return };
    let (scene, light) = (built_in::ball_over_ground(16), two_suns());
    let whole = baked(&scene, BakeMode::Interreflected, AlbedoMode::Vertex);
    let shading = SurfaceShading::Vertices(&whole, &[], Storage::F32);
    let of = |suns: SunsApart<'_>, light: &SceneLight| picture(&context, &scene, (&shading, suns), light, &options());
    let all = light.whole().into();
    assert_eq!(of(SunsApart::No, &light).pixels(), of(SunsApart::No, &all).pixels(), "all light in one expansion");
    // A view for suns under a light that has none: a constant white sky, and one that varies.
    let direct = baked(&scene, BakeMode::Shadowed, AlbedoMode::Vertex);
    let white = project_env(&EnvMap::from_fn(16, 8, |_| Rgb::new(1.0, 1.0, 1.0)), 3);
    for (what, light) in [("white", SceneLight::from(white)), ("varied", all)] {
        let before = crate::flat3(of(SunsApart::No, &light).pixels());
        for suns in [SunsApart::Shadowed(1), SunsApart::Reflected(4, &direct), SunsApart::Unshadowed] {
            let error = crate::relative_difference(crate::flat3(of(suns, &light).pixels()), before.clone());
            assert!(error < crate::TOLERANCE, "{what}, {suns:?}: {error:e}");
        }
    }
    // Of more suns than there may be the expansion holds the others.
    let one = SceneLight::new(
        SceneLight::new(light.rest().clone(), light.suns()[1..].to_vec()).whole(),
        light.suns()[..1].to_vec(),
    );
    let suns = SunsApart::Reflected(1, &direct);
    assert_eq!(of(suns, &light).pixels(), of(suns, &one).pixels(), "the second sun in the expansion");
}

#[test]
fn passes_of_suns_come_first_and_turn_with_them() {
    let Some(context) = device("passes_of_suns_come_first_and_turn_with_them") else { return };
    let scene = built_in::ball_over_ground(16);
    let environment = Environment::from(&*sky());
    let shading = (&SurfaceShading::Irradiance(3), SunsApart::Shadowed(3));
    let mut view = SceneView::with_suns(&context, &scene, shading, Some(&environment), &options()).unwrap();
    let names = ["shadows of sun 0", "shadows of sun 1", "shadows of sun 2", "surfaces", "backdrop", "resolve", "tone"];
    assert_eq!(pass_names(view.renderer()), names, "{}", view.renderer());
    view.resize(&options().shadow_side(512)).unwrap();
    assert_eq!(pass_names(view.renderer()), names, "{}", view.renderer());
    let refused = view.resize(&options().shadow_side(8)).expect_err("a map without room");
    assert!(matches!(refused, GpuError::Options(_)), "{refused:?}");
    view.set_camera(&cameras(&scene).0).unwrap();
    let shot = |azimuth: f64| {
        view.set_scene_light(&SceneLight::new(zero(), vec![sun(40.0, azimuth, 0.5)])).unwrap();
        view.render().unwrap();
        view.picture().unwrap()
    };
    let (first, second) = (shot(20.0), shot(60.0));
    assert_ne!(first.pixels(), second.pixels(), "the shadow has moved");
    assert_eq!(first.pixels(), shot(20.0).pixels(), "and comes back");
}

#[test]
fn suns_of_shadings_that_cannot_have_them_apart_are_refused() {
    let Some(context) = device("suns_of_shadings_that_cannot_have_them_apart_are_refused") else { return };
    let scene = built_in::ball_over_ground(8);
    let [whole, direct] = [BakeMode::Interreflected, BakeMode::Shadowed].map(|m| baked(&scene, m, AlbedoMode::Vertex));
    let matrices =
        lobe_prt::TransferMatrices::new(1, lobe_prt::Channels::Gray, vec![0.5; scene.vertex_count()]).unwrap();
    let other = Transfer::new(2, lobe_prt::Channels::Gray, vec![0.0; 4 * scene.vertex_count()]).unwrap();
    for (shading, suns) in [
        (SurfaceShading::Glossy(&matrices, GlossyLobe::Phong(8.0), Storage::F32), SunsApart::Shadowed(1)),
        (SurfaceShading::Irradiance(3), SunsApart::Reflected(1, &direct)),
        (SurfaceShading::Vertices(&whole, &[], Storage::F32), SunsApart::Reflected(1, &other)),
    ] {
        let refused = SceneView::with_suns(&context, &scene, (&shading, suns), None, &options()).expect_err("refused");
        assert!(matches!(refused, GpuError::Options(_)), "{shading:?}: {refused:?}");
    }
}
