//! Spheres that overlap hide what their union hides.

use std::f32::consts::PI;

use lobe_sh::{Rgb, ShL2};
use lobe_shadow::{LogTable, LogTableOptions, Occluder, ShadowOptions, ShadowReceivers, SkyLight, SphereShadows};
use lobe_testkit::fibonacci_sphere;

fn irradiance(spheres: &[Occluder], at: [f32; 3], share: bool) -> f32 {
    let table = LogTable::new(&LogTableOptions::default().tolerance(0.05)).unwrap();
    let options = ShadowOptions::default().share_overlaps(share);
    let shadows = SphereShadows::new(&table, spheres, &options).unwrap();
    let sky = SkyLight::new(&ShL2::constant(Rgb::new(1.0, 1.0, 1.0)), 4).unwrap();
    let (at, up) = ([at], [[0.0, 0.0, 1.0]]);
    shadows.irradiance(&ShadowReceivers::new(&at, &up).unwrap(), &sky).unwrap()[0].g / PI
}

/// A unit ball as spheres of radius 1/2 about points of a sphere of radius 1/2, and one in the middle: one counts for three.
fn ball_of_spheres(center: [f32; 3]) -> Vec<Occluder> {
    let about = |s: [f64; 3]| Occluder::new([0, 1, 2].map(|k| center[k] + 0.5 * s[k] as f32), 0.5);
    fibonacci_sphere(48).into_iter().map(about).chain([Occluder::new(center, 0.5)]).collect()
}

#[test]
fn a_ball_of_many_spheres_hides_what_the_ball_hides() {
    let mut worst = [0.0_f32; 2];
    for at in [[0.0; 3], [1.5, 0.0, 0.0], [0.0, 3.0, 0.0], [5.0, 5.0, 0.0]] {
        let center = [0.0, 0.0, 1.3];
        let expected = irradiance(&[Occluder::new(center, 1.0)], at, true);
        for (worst, share) in worst.iter_mut().zip([true, false]) {
            *worst = worst.max((irradiance(&ball_of_spheres(center), at, share) - expected).abs());
        }
    }
    println!("shared {:.4}, each by itself {:.4}", worst[0], worst[1]);
    // Straight below, where the ball hides most: what stands side by side adds up as if it were strewn at random.
    assert!(worst[0] < 0.2, "shared: {} of the open sky", worst[0]);
    assert!(worst[1] > 3.0 * worst[0], "each by itself: {}", worst[1]);
}

#[test]
fn a_sphere_within_another_hides_nothing_more() {
    let outer = Occluder::new([0.5, 0.0, 2.0], 1.0);
    let alone = irradiance(&[outer], [0.0; 3], true);
    let with = irradiance(&[outer, Occluder::new([0.5, 0.1, 2.1], 0.6)], [0.0; 3], true);
    assert!((with - alone).abs() < 1e-3, "{with} for {alone}");
}

#[test]
fn twins_hide_what_one_hides() {
    let one = Occluder::new([0.5, 0.0, 2.0], 1.0);
    let (alone, twins) = (irradiance(&[one], [0.0; 3], true), irradiance(&[one, one], [0.0; 3], true));
    assert!((twins - alone).abs() < 1e-3, "{twins} for {alone}");
}
