//! Lamps in moving scenes: the light of fields against direct light that is traced to the lamp, with something that moves between.

use std::sync::Arc;

use lobe_io::Job;
use lobe_motion::{
    Motion, MovingBakeOptions, MovingLamp, MovingMethod, MovingOptions, MovingPart, MovingScene, MovingShading,
    light_moving_scene,
};
use lobe_prt::{BakeMode, BakeOptions};
use lobe_render::{
    Camera, DistantLight, PathOptions, PathReceiver, PathTracer, SampleCount, TruthOptions, ViewOptions,
    render_truth_with_emitters,
};
use lobe_scene::{Mesh, MeshParts, Scene, built_in};
use lobe_sh::{Coefficient as _, Dir, Rgb, Rotation, ShVec};
use lobe_shadow::{
    FieldOptions, Key, Lamp, LampSequence, LampSurface, PatchField, PatchedRectangle, Placement, RadianceField,
    RadianceOptions, Rectangle, SphereFitOptions, SphereSet, Track,
};

const ORDER: usize = 6;

/// Cells along a side of the ground.
const CELLS: u32 = 16;

/// A square of side 6 in the plane z = 0.
fn ground() -> Scene {
    let at = |i: u32| 6.0 * (i as f32 / CELLS as f32 - 0.5);
    let side = CELLS + 1;
    let positions = (0..side * side).map(|k| [at(k % side), at(k / side), 0.0]).collect();
    let cell = |k: u32| {
        let a = k / CELLS * side + k % CELLS;
        [[a, a + 1, a + side + 1], [a, a + side + 1, a + side]]
    };
    let triangles = (0..CELLS * CELLS).flat_map(cell).collect();
    let mesh = Mesh::new(MeshParts { positions, triangles, ..MeshParts::default() }).unwrap();
    Scene::new(vec![mesh], Vec::new(), Vec::new()).unwrap()
}

/// A ball of radius 0.5 that moves over the ground from x = -1 to x = 1 within two seconds, 1.2 above it.
fn ball() -> MovingPart {
    let scene = built_in::ball_over_ground(12).part([1]).unwrap();
    let key = |time: f64, x: f64| Key {
        time,
        // The ball of that scene has its middle at 1.5.
        placement: Placement::new([x, 0.0, 1.2 - 0.75], Rotation::IDENTITY, 0.5),
    };
    MovingPart::new("ball", scene, Motion::Track(Track::new(vec![key(0.0, -1.0), key(2.0, 1.0)]).unwrap()))
}

/// Over the scene, turned so that it shines down.
fn overhead() -> Track {
    let down = Rotation::from_axis_angle(Dir::X, std::f64::consts::PI);
    Track::resting(Placement::new([0.4, 0.0, 3.0], down, 1.0))
}

const PANEL: [f64; 2] = [1.6, 1.2];

/// A panel over the scene that shines down, the same in four colors, or a ball.
fn lamps() -> [(&'static str, MovingLamp); 3] {
    let rectangle = Rectangle::upright(PANEL, false);
    let radiance = Rgb::new(2.0, 3.0, 4.0);
    let colors = PatchedRectangle { rectangle, patches: [2, 2], radiance: colors(0).to_vec() };
    let bulb_track = Track::resting(Placement::new([0.3, -0.4, 3.2], Rotation::IDENTITY, 2.0));
    [
        ("panel", MovingLamp::shaped("panel", LampSurface::rectangle(rectangle, radiance), overhead())),
        ("colors", MovingLamp::shaped("colors", LampSurface::Rectangle(colors), overhead())),
        ("bulb", MovingLamp::shaped("bulb", LampSurface::ball(0.3, radiance), bulb_track)),
    ]
}

/// Four colors, turned on by some places.
fn colors(turned: usize) -> [Rgb<f64>; 4] {
    let four = [Rgb::new(9.0, 0.1, 0.0), Rgb::new(0.0, 8.0, 0.3), Rgb::new(0.2, 0.0, 7.0), Rgb::new(1.0, 2.0, 1.0)];
    std::array::from_fn(|k| four[(k + turned) % 4])
}

fn options() -> MovingBakeOptions {
    let transfer = BakeOptions::default().mode(BakeMode::Shadowed).order(ORDER).samples(512);
    let field = FieldOptions::default().order(ORDER).spheres(8).cells(8).rays(256);
    let spheres = SphereFitOptions::default().count(1).samples(300).rounds(2);
    MovingBakeOptions::default().transfer(transfer).field(field).spheres(spheres).still_hides(false)
}

fn baked(lamp: MovingLamp, method: MovingMethod) -> MovingScene {
    let parts = vec![MovingPart::new("ground", ground(), Motion::Still), ball()];
    let mut moving = MovingScene::new(parts).unwrap().with_lamps(vec![lamp]);
    moving.bake(method, &options(), Job::default()).unwrap();
    moving
}

fn dark() -> ShVec<Rgb<f64>> {
    ShVec::zero(ORDER)
}

/// The exit radiance of all vertices by paths to the lamp.
fn traced(moving: &MovingScene, time: f64) -> Vec<Rgb<f64>> {
    let moment = moving.at(time).unwrap();
    let light = DistantLight::from_expansion(dark());
    let tracer = PathTracer::new(moment.scene(), moment.bvh(), &light, PathOptions::default().bounces(0))
        .with_emitters(&moment.emitters());
    let receivers = lobe_prt::Receivers::at_vertices(moment.scene()).unwrap();
    let of = |k| tracer.radiance_at(&PathReceiver::of(&receivers, k), k, &SampleCount::of(1024)).mean;
    (0..receivers.len()).map(of).collect()
}

fn off(found: &[Rgb<f32>], expected: &[Rgb<f64>]) -> f64 {
    assert_eq!(found.len(), expected.len(), "as many vertices");
    let pairs = || found.iter().map(|c| c.to_array()).zip(expected.iter().map(|c| c.to_array()));
    let square: f64 = pairs().map(|(a, b)| (0..3).map(|c| (f64::from(a[c]) - b[c]).powi(2)).sum::<f64>()).sum();
    (square / pairs().map(|(_, b)| b.iter().map(|c| c * c).sum::<f64>()).sum::<f64>()).sqrt()
}

#[test]
#[ignore = "long: of the nightly group"]
fn the_light_of_a_lamp_past_a_moving_ball_is_near_that_of_paths_to_the_lamp() {
    for (name, lamp) in lamps() {
        for method in [MovingMethod::Fields, MovingMethod::Exponentials] {
            let moving = baked(lamp.clone(), method);
            let alone = moving.without_occluders();
            let shading = MovingShading::new(MovingOptions::default().order(ORDER).method(method)).unwrap();
            for time in [0.0, 1.3] {
                let expected = traced(&moving, time);
                let [with, without] = [&moving, &alone]
                    .map(|scene| off(&shading.exit_radiance(&scene.at(time).unwrap(), &dark()).unwrap(), &expected));
                println!("{name}, {method:?} at {time} s: off by {with:.3}, by {without:.3} without shadows");
                assert!(with < 0.16, "{name}, {method:?} at {time} s: off by {with} of the traced light");
                assert!(without > 1.5 * with, "{name}, {method:?} at {time} s: {without} without shadows, {with} with");
            }
        }
    }
}

#[test]
fn a_film_on_a_panel_is_traced_picture_by_picture() {
    // Two pictures a second, the second with its colors in other places.
    let options = RadianceOptions::default().order(ORDER);
    let field = PatchField::bake(&Rectangle::upright(PANEL, false), [2, 2], &options, Job::default()).unwrap();
    let narrow = |c: Rgb<f64>| Rgb::from(c.to_array().map(|c| c as f32));
    let pictures = [0, 2].map(|turned| colors(turned).map(narrow).to_vec()).to_vec();
    let film = Lamp::Sequence(LampSequence::new(field, pictures, 2.0).unwrap());
    let moving = baked(MovingLamp::new("film", film, overhead()), MovingMethod::Fields);
    let shading = MovingShading::new(MovingOptions::default().order(ORDER)).unwrap();
    let [first, second] = [0.2, 0.7].map(|time| {
        let found = shading.exit_radiance(&moving.at(time).unwrap(), &dark()).unwrap();
        (found, traced(&moving, time))
    });
    for (name, (found, expected), other) in [("first", &first, &second.1), ("second", &second, &first.1)] {
        let (near, far) = (off(found, expected), off(found, other));
        println!(
            "{name} picture: off by {near:.3} of what is traced to it, by {far:.3} of what is traced to the other"
        );
        assert!(near < 0.16, "{name} picture: off by {near}");
        assert!(far > 2.0 * near, "{name} picture: {near} of its own, {far} of the other");
    }
}

#[test]
fn what_is_behind_a_lamp_does_not_hide_it() {
    // The ball is 1.2 above the ground, and the lamp 0.3 above it.
    let key = Placement::new([0.0, 0.0, 0.3], Rotation::IDENTITY, 1.0);
    let surface = LampSurface::ball(0.1, Rgb::new(1.0, 1.0, 1.0));
    let lamp = MovingLamp::shaped("low", surface, Track::resting(key));
    for method in [MovingMethod::Fields, MovingMethod::Exponentials] {
        let moving = baked(lamp.clone(), method);
        let shading = MovingShading::new(MovingOptions::default().order(ORDER).method(method)).unwrap();
        let [with, without] = [&moving, &moving.without_occluders()]
            .map(|scene| shading.exit_radiance(&scene.at(1.0).unwrap(), &dark()).unwrap());
        // The vertex of the ground below both.
        let middle = ((CELLS + 1) * CELLS / 2 + CELLS / 2) as usize;
        assert_eq!(with[middle], without[middle], "{method:?}: the ball is above the lamp");
        assert!(with[middle].g > 0.01, "{method:?}: {:?}", with[middle]);
    }
}

#[test]
fn lamps_move_along_their_tracks_and_begin_anew_with_the_scene() {
    let key = |time: f64, x: f64| Key { time, placement: Placement::new([x, 0.0, 2.0], Rotation::IDENTITY, 1.0) };
    let track = Track::new(vec![key(0.0, -2.0), key(4.0, 2.0)]).unwrap();
    let lamp = MovingLamp::shaped("bulb", LampSurface::ball(0.2, Rgb::new(1.0, 1.0, 1.0)), track);
    let moving = baked(lamp, MovingMethod::Fields);
    assert_eq!(moving.span(), [0.0, 4.0], "the lamp moves longer than the ball");
    let shading = MovingShading::new(MovingOptions::default().order(ORDER)).unwrap();
    let lit = |moving: &MovingScene, time: f64| shading.exit_radiance(&moving.at(time).unwrap(), &dark()).unwrap();
    let (first, last) = (lit(&moving, 0.0), lit(&moving, 4.0));
    assert!(first[0].g > 1.5 * last[0].g, "it moves away from the first corner: {:?}, {:?}", first[0], last[0]);
    let looped = moving.looped(true);
    assert_eq!(lit(&looped, 5.0), lit(&looped, 1.0), "a loop of 4 s");
}

#[test]
fn many_lamps_light_as_the_sum_of_each() {
    // More of them than are held at a time, and a ball between, for which one sphere stands.
    const FEW: usize = 3;
    let mut moving = MovingScene::new(vec![MovingPart::new("ground", ground(), Motion::Still), ball()]).unwrap();
    moving.set_spheres(1, Arc::new(SphereSet::new(vec![[0.0, 0.0, 1.5]], vec![1.0]).unwrap()));
    let lamp = |k: u32| {
        let (sin, cos) = f64::from(k).sin_cos();
        let place = Placement::new([2.0 * cos, 2.0 * sin, 3.0], Rotation::IDENTITY, 1.0);
        let light = RadianceField::ball(FEW, [0.0; 3], 0.2, Rgb::new(1.0, 2.0, 3.0)).unwrap();
        MovingLamp::new(format!("lamp {k}"), Lamp::Still(light), Track::resting(place))
    };
    let lamps: Vec<MovingLamp> = (0..18).map(lamp).collect();
    let options = MovingOptions::default().order(FEW).method(MovingMethod::Exponentials);
    let shading = MovingShading::new(options).unwrap();
    let lit = |scene: &MovingScene, lamps: &[MovingLamp]| {
        let scene = scene.clone().with_lamps(lamps.to_vec());
        shading.exit_radiance(&scene.at(1.0).unwrap(), &dark()).unwrap()
    };
    let together = lit(&moving, &lamps);
    let mut sum = vec![Rgb::<f64>::ZERO; together.len()];
    for lamp in &lamps {
        let alone = lit(&moving, std::slice::from_ref(lamp));
        sum.iter_mut().zip(alone).for_each(|(sum, alone)| *sum += alone.widen());
    }
    let (rounding, shadows) = (off(&together, &sum), off(&lit(&moving.without_occluders(), &lamps), &sum));
    assert!(rounding < 1e-5, "{rounding} off the sum of each");
    assert!(shadows > 1e-3, "{shadows}: the ball hides some light");
}

#[test]
fn pictures_with_lamps_are_near_their_truth() {
    let [(_, panel), ..] = lamps();
    let moving = baked(panel, MovingMethod::Fields);
    let moment = moving.at(1.3).unwrap();
    let camera = Camera::look_at([3.0, -6.0, 4.0], [0.0, 0.0, 0.4], 35_f64.to_radians()).unwrap();
    let view = ViewOptions::default().width(48).height(36).rays(2);
    let shading = MovingShading::new(MovingOptions::default().order(ORDER)).unwrap();
    let found = light_moving_scene(
        &moment,
        &shading,
        &dark().into(),
        &camera,
        &view,
        |_| Rgb::new(0.0, 0.0, 0.0),
        Job::default(),
    )
    .unwrap();
    let truth = TruthOptions::default().width(48).height(36).count(SampleCount::of(64));
    let truth = truth.paths(PathOptions::default().bounces(0));
    let light = DistantLight::from_expansion(dark());
    let emitters = moment.emitters();
    let traced =
        render_truth_with_emitters(moment.scene(), moment.bvh(), &camera, &light, &emitters, &truth, Job::default());
    let traced = traced.unwrap();
    let psnr = lobe_image::compare(found.picture.pixels(), traced.mean.pixels()).psnr;
    let mean = traced.mean.mean()[1];
    println!("{psnr:.1} dB, mean {mean:.4}");
    assert!(psnr > 24.0, "{psnr} dB");
    // A half of the flux π L A falls on a ground of area 36, which fills a tenth of the picture: 0.01 on average.
    assert!(mean > 0.003, "{mean}: the picture is dark");
}

#[test]
fn lamps_at_fault_are_one_line_each() {
    let shading = MovingShading::new(MovingOptions::default().order(ORDER)).unwrap();
    let part = || MovingPart::new("ground", ground(), Motion::Still);
    let [(_, panel), ..] = lamps();
    let bare = MovingScene::new(vec![part()]).unwrap().with_lamps(vec![panel]);
    let error = shading.exit_radiance(&bare.at(0.0).unwrap(), &dark()).unwrap_err().to_string();
    assert_eq!(error, "lamp `panel`: expected light that is baked, found none yet");
    let low = RadianceField::ball(3, [0.0; 3], 0.1, Rgb::new(1.0, 1.0, 1.0)).unwrap();
    let file = MovingLamp::new("file", Lamp::Still(low), Track::resting(Placement::IDENTITY));
    let moving = MovingScene::new(vec![part()]).unwrap().with_lamps(vec![file]);
    assert_eq!(moving.order(), Some(3), "that of the lamp");
    let error = moving.expect_order(ORDER).unwrap_err().to_string();
    assert!(error.starts_with("lamp `file`: expected light of 6 bands at least, found 3"), "{error}");
}
