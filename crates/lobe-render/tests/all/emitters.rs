//! Lamps near by, traced: against closed forms, and in the checkpoints of pictures.

use lobe_io::Job;
use lobe_render::{
    Camera, DistantLight, Emitter, LightStrategy, PathOptions, PathReceiver, PathTracer, SampleCount, TruthOptions,
    render_truth_with_emitters,
};
use lobe_scene::{Bvh, built_in};
use lobe_sh::{Rgb, Rotation, ShVec};
use lobe_shadow::{LampSurface, Placement};

/// A ball of radiance 1.
fn bulb(at: [f64; 3], radius: f64) -> Emitter {
    let surface = LampSurface::ball(radius, Rgb::new(1.0, 1.0, 1.0));
    Emitter::new(&surface, &Placement::new(at, Rotation::IDENTITY, 1.0))
}

fn dark() -> DistantLight {
    DistantLight::from_expansion(ShVec::zero(1))
}

/// A white receiver that faces up.
fn up(position: [f32; 3]) -> PathReceiver<'static> {
    let up = [0.0, 0.0, 1.0];
    PathReceiver { position, normal: up, lift: up, albedo: Rgb::new(1.0, 1.0, 1.0), planes: &[] }
}

#[test]
fn a_picture_does_not_go_on_once_the_lamp_has_moved_within_the_scene() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("picture");
    let picture = |by: [f64; 3], lamp: [f64; 3]| {
        let scene = built_in::ball_over_ground(8).moved(by);
        let at = |p: [f64; 3]| [0, 1, 2].map(|k| p[k] + by[k]);
        let camera = Camera::look_at(at([6.0, -4.0, 4.0]), at([0.0, 0.0, 1.0]), 0.5).unwrap();
        let paths = PathOptions::default().bounces(0);
        let options = TruthOptions::default().width(4).height(3).count(SampleCount::of(2)).paths(paths);
        let job = Job::default().kept_in(&path);
        render_truth_with_emitters(&scene, &Bvh::new(&scene), &camera, &dark(), &[bulb(lamp, 0.5)], &options, job)
    };
    let here = picture([0.0; 3], [0.0, 0.0, 5.0]).unwrap();
    let along = picture([8.0, -16.0, 4.0], [8.0, -16.0, 9.0]).unwrap();
    assert!(along == here, "lamp and camera have moved along with the scene: {along:?}, expected {here:?}");
    let refusal = picture([8.0, -16.0, 4.0], [0.0, 0.0, 5.0]).unwrap_err().to_string();
    assert!(refusal.contains("is of another picture"), "the lamp stays behind: {refusal}");
}

#[test]
fn within_a_lamp_things_cast_shadows() {
    // A ball of radius 1 straight above at distance 1.5 hides (1/1.5)² of the even light within a large lamp. Its inscribed facets
    // hide a little less, by 16 times what 192 around do (`under_a_ball_the_ground_sees_what_the_closed_form_says`).
    let scene = built_in::ball_over_ground(48);
    let (bvh, light) = (Bvh::new(&scene), dark());
    let options = PathOptions::default().bounces(0).strategy(LightStrategy::NextEvent);
    let tracer = PathTracer::new(&scene, &bvh, &light, options).with_emitters(&[bulb([0.0; 3], 10.0)]);
    let found = tracer.radiance_at(&up([0.0; 3]), 0, &SampleCount::of(4096));
    let (expected, error) = (1.0 - 1.0 / 2.25, found.variance.g.sqrt());
    assert!((found.mean.g - expected).abs() < 5.0 * error + 16.0 * 3e-4, "{found:?}, expected {expected}");
    assert!(error < 0.03, "{error}: too much noise to tell");
}

#[test]
fn light_that_arrives_is_not_that_of_lamps_by_way_of_surfaces_either() {
    let scene = built_in::ball_over_ground(8);
    let (bvh, light) = (Bvh::new(&scene), dark());
    let lamp = [bulb([4.0, 0.0, 1.5], 0.5)];
    let tracer = PathTracer::new(&scene, &bvh, &light, PathOptions::default().bounces(1)).with_emitters(&lamp);
    let (receiver, count) = (up([1.5, 0.0, 0.0]), SampleCount::of(64));
    let mut brightest = 0.0_f64;
    tracer.for_each_arrival(&receiver, 0, &count, |_, _, radiance| brightest = brightest.max(radiance.r));
    assert_eq!(brightest, 0.0, "what the ball reflects of the lamp");
    assert!(tracer.radiance_at(&receiver, 0, &count).mean.r > 0.0, "the lamp lights the receiver");
}

#[test]
fn within_a_ball_light_of_a_lamp_adds_up_as_in_an_integrating_sphere() {
    // All points of a sphere see all others alike: B = L (r/R)² Σ_k ρ^k for a white receiver, k up to the bounces.
    let scene = built_in::ball_over_ground(64).part([1]).unwrap();
    let (bvh, light) = (Bvh::new(&scene), dark());
    let (radius, albedo) = (0.2_f64, [0.7_f64, 0.25, 0.2]);
    for bounces in [0, 1, 4] {
        let options = PathOptions::default().bounces(bounces);
        let tracer = PathTracer::new(&scene, &bvh, &light, options).with_emitters(&[bulb([0.0, 0.0, 1.5], radius)]);
        let found = tracer.radiance_at(&up([0.0, 0.0, 0.5]), 0, &SampleCount::of(256)).mean.to_array();
        for (found, albedo) in found.into_iter().zip(albedo) {
            let expected = radius * radius * (0..=bounces).map(|k| albedo.powi(k as i32)).sum::<f64>();
            // The facets are up to 0.2 % nearer to the lamp than the sphere, and a little light is lost below their planes.
            assert!((found / expected - 1.0).abs() < 0.01, "{bounces} bounces: {found}, expected {expected}");
        }
    }
}
