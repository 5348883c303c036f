//! Moving scenes against bakes, and against traced paths.

use std::fs;

use lobe_env::{SceneLight, Sun, bundled, project_env};
use lobe_io::Job;
use lobe_motion::{
    Motion, MovingBakeOptions, MovingMethod, MovingOptions, MovingPart, MovingScene, MovingShading,
    VisibilityGridOptions, light_moving_scene, light_moving_surfaces,
};
use lobe_prt::{BakeMode, BakeOptions, bake_vertices};
use lobe_render::{
    Backdrop, BakedScene, Camera, DistantLight, EnvironmentMapOptions, GltfSurfaces, PathOptions, Reflections,
    SampleCount, SceneHit, SurfaceLight, SurfaceModel, Surfaces, TruthOptions, View, ViewOptions, light_baked_scene,
    render_truth,
};
use lobe_scene::{Bvh, Scene, SceneReadOptions, built_in};
use lobe_sh::{Dir, Expansion as _, Rgb, Rotation, ShVec};
use lobe_shadow::{FieldOptions, Key, Placement, SphereFitOptions, Track};

const ORDER: usize = 4;

fn sky() -> ShVec<Rgb<f64>> {
    project_env(&bundled::sunset().map(), ORDER)
}

fn options() -> MovingBakeOptions {
    let transfer = BakeOptions::default().mode(BakeMode::Shadowed).order(ORDER).samples(256);
    let field = FieldOptions::default().order(ORDER).spheres(8).cells(8).rays(256);
    let spheres = SphereFitOptions::default().count(8).samples(800).rounds(4);
    let visibility = VisibilityGridOptions::default().order(ORDER).points(64).rays(64);
    MovingBakeOptions::default()
        .transfer(transfer)
        .field(field)
        .spheres(spheres)
        .deformed_spheres(None)
        .visibility(visibility)
}

fn shading(method: MovingMethod) -> MovingShading {
    MovingShading::new(MovingOptions::default().order(ORDER).method(method)).unwrap()
}

fn relative_difference(found: &[Rgb<f32>], expected: &[Rgb<f32>]) -> f64 {
    let square = |c: f32| f64::from(c).powi(2);
    let sum = |f: &dyn Fn(usize, usize) -> f64| -> f64 {
        (0..found.len()).map(|k| (0..3).map(|c| f(k, c)).sum::<f64>()).sum()
    };
    let off = sum(&|k, c| square(found[k].to_array()[c] - expected[k].to_array()[c]));
    (off / sum(&|k, c| square(expected[k].to_array()[c]))).sqrt()
}

#[test]
fn a_scene_of_one_part_is_lit_as_its_bake() {
    let scene = built_in::ball_over_ground(8);
    let (transfer, _) = bake_vertices(&scene, &Bvh::new(&scene), &options().transfer, Job::default()).unwrap();
    let expected = transfer.exit_radiance(sky().coefficients());
    let mut moving = MovingScene::new(vec![MovingPart::new("all", scene, Motion::Still)]).unwrap();
    for method in [MovingMethod::Fields, MovingMethod::Exponentials] {
        moving.bake(method, &options(), Job::default()).unwrap();
        let lit = shading(method).exit_radiance(&moving.at(0.0).unwrap(), &sky()).unwrap();
        let off = relative_difference(&lit, &expected);
        assert!(off < 1e-4, "{method:?}: {off}, which is more than the products' rounding");
    }
}

#[test]
fn a_moment_knows_where_each_part_is() {
    let key = |time: f64, x: f64, angle: f64| Key {
        time,
        placement: Placement::new([x, 2.0, 0.0], Rotation::from_axis_angle(Dir::Z, angle), 0.5),
    };
    let track = Track::new(vec![key(0.0, -1.0, 0.0), key(2.0, 1.0, 1.0)]).unwrap();
    let ball = built_in::ball_over_ground(8);
    let still = MovingPart::new("still", ball.clone(), Motion::Still);
    let moving = MovingScene::new(vec![still, MovingPart::new("moved", ball, Motion::Track(track.clone()))]).unwrap();
    for time in [0.0, 0.7, 2.0] {
        let moment = moving.at(time).unwrap();
        let found = [0, 1].map(|part| moment.placement_of(part));
        assert_eq!(found, [Placement::IDENTITY, track.at(time)], "at {time} s");
    }
}

#[test]
fn a_turned_part_alone_is_lit_as_if_the_sky_were_turned_back() {
    let turn = Rotation::from_axis_angle(Dir::from_unit([0.6, 0.0, 0.8]), 1.1);
    let placement = Placement::new([3.0, -1.0, 2.0], turn, 0.5);
    let part = || MovingPart::new("ball", built_in::ball_over_ground(8), Motion::Track(Track::resting(placement)));
    let mut moving = MovingScene::new(vec![part()]).unwrap();
    moving.bake(MovingMethod::Fields, &options(), Job::default()).unwrap();
    let found = shading(MovingMethod::Fields).exit_radiance(&moving.at(0.0).unwrap(), &sky()).unwrap();
    let mut still = moving.parts()[0].clone();
    still.motion = Motion::Still;
    let still = MovingScene::new(vec![still]).unwrap();
    let turned_back = sky().rotated(&turn.inverse());
    let expected = shading(MovingMethod::Fields).exit_radiance(&still.at(0.0).unwrap(), &turned_back).unwrap();
    let off = relative_difference(&found, &expected);
    assert!(off < 1e-5, "{off}");
}

/// The relative error of a picture of direct light against traced paths.
fn error_against_paths(moving: &MovingScene, method: Option<MovingMethod>, time: f64) -> f64 {
    let moment = moving.at(time).unwrap();
    let camera = Camera::framing([-3.0, -3.0, 0.0], [3.0, 3.0, 3.0], View::three_quarter(), 0.35);
    let light = sky();
    let distant = DistantLight::from_expansion(light.clone());
    let view = ViewOptions::default().width(48).height(36).rays(3);
    let paths = PathOptions::default().bounces(0);
    let truth = TruthOptions::default().width(48).height(36).count(SampleCount::of(256)).paths(paths);
    let truth = render_truth(moment.scene(), moment.bvh(), &camera, &distant, &truth, Job::default()).unwrap();
    let background = |s: Dir| distant.radiance(s);
    let unshadowed;
    let (moment, shading) = match method {
        Some(method) => (&moment, shading(method)),
        None => {
            unshadowed = moving.without_occluders();
            (&unshadowed.at(time).unwrap(), shading(MovingMethod::Fields))
        }
    };
    let lit = light_moving_scene(moment, &shading, &light.clone().into(), &camera, &view, background, Job::default())
        .unwrap();
    lobe_image::compare(lit.picture.pixels(), truth.mean.pixels()).relative_rmse
}

fn balls_over_ground() -> MovingScene {
    moving_ball(&built_in::ball_over_ground(24))
}

fn moving_ball(both: &Scene) -> MovingScene {
    let (ground, ball) = (both.part([0]).unwrap(), both.part([1]).unwrap());
    let key = |time: f64, x: f64| Key { time, placement: Placement::new([x, 0.0, -0.3], Rotation::IDENTITY, 1.0) };
    let track = Track::new(vec![key(0.0, -1.5), key(2.0, 1.5)]).unwrap();
    let parts =
        vec![MovingPart::new("ground", ground, Motion::Still), MovingPart::new("ball", ball, Motion::Track(track))];
    MovingScene::new(parts).unwrap()
}

#[test]
fn shadows_of_what_moves_are_nearer_to_traced_paths_than_bakes_without_them() {
    for method in [MovingMethod::Fields, MovingMethod::Exponentials] {
        let mut moving = balls_over_ground();
        moving.bake(method, &options(), Job::default()).unwrap();
        for time in [0.0, 0.9] {
            let (with, without) =
                (error_against_paths(&moving, Some(method), time), error_against_paths(&moving, None, time));
            println!("{method:?} at {time} s: {with:.4} of {without:.4} without shadows");
            assert!(with < 0.5 * without, "{method:?} at {time} s: {with} with shadows, {without} without");
        }
    }
}

/// A model whose reflections nothing hides.
struct Unhidden<'a>(GltfSurfaces<'a>);

impl SurfaceModel for Unhidden<'_> {
    fn looks_around(&self) -> bool {
        false
    }

    fn radiance(&self, hit: &SceneHit<'_>, light: &SurfaceLight<'_>) -> Rgb<f64> {
        let matte = |hit: &SceneHit<'_>| light.lit.matte(hit);
        self.0.radiance(hit, &SurfaceLight { lit: &matte, suns: light.suns })
    }
}

#[test]
fn what_moves_hides_the_sky_from_what_metals_reflect() {
    let metal = built_in::ball_over_ground(24).with_finish(Some(0.5), Some(1.0)).unwrap();
    let mut moving = moving_ball(&metal);
    moving.bake(MovingMethod::Fields, &options(), Job::default()).unwrap();
    let moment = moving.at(0.9).unwrap();
    let camera = Camera::framing([-2.0, -2.0, 0.0], [2.0, 2.0, 2.0], View::three_quarter(), 0.35);
    let (width, height, sky) = (32, 24, sky());
    let view = ViewOptions::default().width(width).height(height).rays(3);
    let (distant, black) = (DistantLight::from_expansion(sky.clone()), |_: Dir| Rgb::new(0.0, 0.0, 0.0));
    let paths = PathOptions::default().bounces(0).surfaces(Surfaces::MetallicRoughness);
    let truth = TruthOptions::default().width(width).height(height).count(SampleCount::of(256)).paths(paths);
    let distant = distant.before(Backdrop::None);
    let truth = render_truth(moment.scene(), moment.bvh(), &camera, &distant, &truth, Job::default()).unwrap();
    let options = EnvironmentMapOptions::default().size(32);
    let reflections = Reflections::of_expansion(&sky, &options, Job::default()).unwrap();
    let (model, shading) = (reflections.turned(&Rotation::IDENTITY), shading(MovingMethod::Fields));
    let error = |model: &dyn SurfaceModel| {
        let light = sky.clone().into();
        let lit =
            light_moving_surfaces(&moment, &shading, (&light, model), &camera, &view, black, Job::default()).unwrap();
        lobe_image::compare(lit.picture.pixels(), truth.mean.pixels()).relative_rmse
    };
    let (with, without) = (error(&model), error(&Unhidden(model)));
    println!("{with:.4} of {without:.4} without what hides the sky");
    // The ground beside the ball is hidden in three bands alone.
    assert!(with < 0.6 * without, "{with}, without what hides the sky {without}");
}

/// A dim sky with a sun.
fn sunny() -> SceneLight {
    let (direction, irradiance) = (Dir::new([0.5, 0.3, 0.8]).unwrap(), Rgb::new(3.0, 2.5, 2.0));
    let sun = Sun { direction, irradiance, angular_diameter: 0.02, texels: 0 };
    SceneLight::new(ShVec::constant(ORDER, Rgb::new(0.2, 0.3, 0.5)), vec![sun])
}

#[test]
fn suns_light_a_moving_scene_as_they_light_the_baked_scene_in_its_place() {
    let mut moving = balls_over_ground();
    let transfer = options().transfer.mode(BakeMode::Interreflected).bounces(1);
    moving.bake(MovingMethod::Fields, &options().transfer(transfer).direct(true), Job::default()).unwrap();
    let moment = moving.at(0.6).unwrap();
    let camera = Camera::framing([-3.0, -3.0, 0.0], [3.0, 3.0, 3.0], View::three_quarter(), 0.35);
    let view = ViewOptions::default().width(48).height(36);
    let black = |_: Dir| Rgb::new(0.0, 0.0, 0.0);
    let shading = shading(MovingMethod::Fields);
    let picture = |light: &SceneLight| {
        light_moving_scene(&moment, &shading, light, &camera, &view, black, Job::default()).unwrap().picture
    };
    // What the sun adds, of what the sun alone adds to a scene baked as it stands, without reflections.
    let (light, bake) = (sunny(), options().transfer.mode(BakeMode::Shadowed));
    let baked = BakedScene::bake(moment.scene().clone(), &bake, None, Job::default()).unwrap();
    let alone = SceneLight::new(ShVec::zero(ORDER), light.suns().to_vec());
    let expected = light_baked_scene(&baked, &alone, &camera, &view, black, Job::default()).unwrap().picture;
    let (with, without) = (picture(&light), picture(&light.rest().clone().into()));
    for (i, expected) in expected.pixels().iter().enumerate() {
        let added = f64::from(with.pixels()[i][1] - without.pixels()[i][1]);
        // Ball and ground send little to themselves, which comes on top.
        let more = added - f64::from(expected[1]);
        assert!((-0.02..0.06).contains(&more), "pixel {i}: {added}, not {}", expected[1]);
    }
}

#[test]
fn a_skinned_figure_is_lit_by_the_spheres_of_its_joints() {
    let mut moving = MovingScene::animated(built_in::walking_figure(8), Some(0)).unwrap();
    moving.bake(MovingMethod::Exponentials, &options(), Job::default()).unwrap();
    let shading = shading(MovingMethod::Exponentials);
    let [_, end] = moving.span();
    for time in [0.0, 0.4 * end, end] {
        let moment = moving.at(time).unwrap();
        let lit = shading.exit_radiance(&moment, &sky()).unwrap();
        assert_eq!(lit.len(), moment.scene().vertex_count(), "one for each vertex");
        let mean = lit.iter().map(|c| f64::from(c.g)).sum::<f64>() / lit.len() as f64;
        assert!(mean.is_finite() && mean > 0.01, "{mean} at {time} s");
    }
}

#[test]
#[ignore = "long: of the nightly group"]
fn the_shadows_of_a_walking_figure_are_near_traced_paths_at_all_times_of_its_walk() {
    // Fewer spheres are thicker than the limbs that they stand for (example `skins`).
    let spheres = SphereFitOptions::default().count(64).samples(2000).rounds(4);
    let mut moving = MovingScene::animated(built_in::walking_figure(16), Some(0)).unwrap();
    moving.bake(MovingMethod::Exponentials, &options().spheres(spheres), Job::default()).unwrap();
    let alone = moving.without_occluders();
    let light = sky();
    let distant = DistantLight::from_expansion(light.clone());
    let camera = Camera::look_at([2.6, -3.2, 1.9], [0.0, 0.0, 0.8], 38_f64.to_radians()).unwrap();
    let view = ViewOptions::default().width(64).height(48).rays(2);
    let paths = PathOptions::default().bounces(0);
    let truth = TruthOptions::default().width(64).height(48).count(SampleCount::of(64)).paths(paths);
    for time in [0.1, 0.4, 0.8] {
        let moment = moving.at(time).unwrap();
        let truth = render_truth(moment.scene(), moment.bvh(), &camera, &distant, &truth, Job::default()).unwrap();
        let background = |s: Dir| distant.radiance(s);
        let [with, without] = [&moving, &alone].map(|scene| {
            let (moment, shading) = (scene.at(time).unwrap(), shading(MovingMethod::Exponentials));
            let lit = light_moving_scene(
                &moment,
                &shading,
                &light.clone().into(),
                &camera,
                &view,
                background,
                Job::default(),
            );
            lobe_image::compare(lit.unwrap().picture.pixels(), truth.mean.pixels()).psnr
        });
        println!("at {time} s: {with:.1} dB by spheres, {without:.1} dB without");
        assert!(with > 37.5 && with > without + 1.0, "at {time} s: {with} dB by spheres, {without} dB without");
    }
}

#[test]
fn a_description_is_read_with_its_files_and_their_faults_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.json");
    let write = |text: &str| fs::write(&path, text).unwrap();
    write(
        r#"{"format":"lobe-scene","version":1,"still":"built-in:terrain",
            "entities":[{"name":"ball","mesh":"built-in:ball","keys":[{"time":1,"scale":0.5},{"time":3}]}]}"#,
    );
    let (moving, reports) = MovingScene::read(&path, &SceneReadOptions::default()).unwrap();
    assert_eq!((moving.parts().len(), moving.span(), reports.len()), (2, [1.0, 3.0], 0), "parts, span and reports");
    let vertices: usize = moving.parts().iter().map(|part| part.scene.vertex_count()).sum();
    assert_eq!(moving.at(2.0).unwrap().scene().vertex_count(), vertices, "all parts");
    assert!(moving.at(f64::NAN).is_err(), "a time that is none");

    write(r#"{"format":"lobe-scene","version":1,"still":"built-in:nothing"}"#);
    let error = MovingScene::read(&path, &SceneReadOptions::default()).unwrap_err().to_string();
    assert!(error.contains("there is no such scene"), "{error}");
    fs::write(folder.path().join("f.safetensors"), b"no field").unwrap();
    write(
        r#"{"format":"lobe-scene","version":1,
            "entities":[{"name":"a","mesh":"built-in:ball","field":"f.safetensors"}]}"#,
    );
    let error = MovingScene::read(&path, &SceneReadOptions::default()).unwrap_err().to_string();
    assert!(error.contains("f.safetensors") && !error.contains('\n'), "{error}");
}

#[test]
fn a_field_of_fewer_bands_than_asked_for_is_refused() {
    let mut moving = balls_over_ground();
    moving.bake(MovingMethod::Fields, &options(), Job::default()).unwrap();
    let higher = MovingShading::new(MovingOptions::default().order(ORDER + 1)).unwrap();
    let error = higher.exit_radiance(&moving.at(0.0).unwrap(), &sky()).unwrap_err().to_string();
    assert!(error.contains("bands"), "{error}");
}
