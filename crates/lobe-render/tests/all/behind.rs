//! Backgrounds of scenes: interpolated as the eye sees them, and alpha where there is nothing.

use std::sync::Arc;

use lobe_env::{EnvMap, bundled};
use lobe_image::{Picture, compare};
use lobe_io::Job;
use lobe_render::{
    Backdrop, Background, Camera, DistantLight, LitPicture, PathOptions, SampleCount, Truth, TruthOptions, View,
    ViewOptions, light_by_irradiance, render_truth,
};
use lobe_scene::{Bvh, Scene, built_in};
use lobe_sh::{Coefficient as _, Dir, Expansion as _, Rgb, ShVec};

/// Columns and rows.
const SIZE: [usize; 2] = [32, 24];

/// Numbers of `f32`, summed in another order.
const ROUNDING: f64 = 1e-6;

/// Largest difference between a mean over the square of a pixel and its value in the middle: the map changes by less
/// than this from pixel to pixel where it is interpolated, and by ten times as much from texel to texel.
const WITHIN_PIXEL: f64 = 0.02;

/// A map of 16 by 8 texels, whose colors change by 0.2 and more from one to the next.
fn coarse() -> EnvMap {
    EnvMap::from_fn(16, 8, |s| Rgb::new(1.0 + s.x() as f32, 1.0 + s.y() as f32, 1.0 + s.z() as f32))
}

/// A camera that looks past the ball into the sky.
fn upwards() -> Camera {
    Camera::look_at([0.0, 0.0, 5.0], [3.0, 4.0, 6.0], 0.25).unwrap()
}

/// A camera that sees a ball over the ground, and its edge.
fn ball() -> Camera {
    Camera::framing([-1.5, -1.5, 0.0], [1.5, 1.5, 2.0], View::three_quarter(), 0.35)
}

fn shaded(scene: &Scene, camera: &Camera, behind: &DistantLight, options: &ViewOptions) -> LitPicture {
    let (bvh, light) = (Bvh::new(scene), ShVec::constant(1, Rgb::splat(1.0)));
    let background = |s: Dir| behind.seen(s);
    light_by_irradiance(scene, &bvh, &light.into(), camera, options, background, Job::default()).unwrap()
}

fn traced(scene: &Scene, camera: &Camera, light: &DistantLight, paths: usize) -> Truth {
    let options = TruthOptions::default().width(SIZE[0]).height(SIZE[1]).count(SampleCount::of(paths));
    let options = options.paths(PathOptions::default().bounces(1));
    render_truth(scene, &Bvh::new(scene), camera, light, &options, Job::default()).unwrap()
}

fn view() -> ViewOptions {
    ViewOptions::default().width(SIZE[0]).height(SIZE[1])
}

fn farthest(a: &Picture, b: &Picture) -> f64 {
    compare(a.pixels(), b.pixels()).max_abs
}

#[test]
fn the_sky_is_interpolated_by_rays_as_by_paths_without_the_edges_of_texels() {
    let scene = built_in::ball_over_ground(8);
    let (map, camera) = (coarse(), upwards());
    let light = DistantLight::from_map(map.clone());
    let by_rays = shaded(&scene, &camera, &light, &view()).picture;
    let expected = Picture::from_fn(SIZE[0], SIZE[1], |x, y| {
        let (right, up) = ((x as f64 + 0.5 - 16.0) / 12.0, (12.0 - y as f64 - 0.5) / 12.0);
        <[f32; 3]>::from(map.radiance(camera.ray(right, up).1))
    });
    assert!(farthest(&by_rays, &expected) < WITHIN_PIXEL, "by rays: {}", farthest(&by_rays, &expected));
    let by_paths = traced(&scene, &camera, &light, 256).mean;
    assert!(farthest(&by_paths, &expected) < WITHIN_PIXEL, "by paths: {}", farthest(&by_paths, &expected));
    // The texels themselves are told apart by that.
    let squares = Picture::from_fn(SIZE[0], SIZE[1], |x, y| {
        let (right, up) = ((x as f64 + 0.5 - 16.0) / 12.0, (12.0 - y as f64 - 0.5) / 12.0);
        <[f32; 3]>::from(Rgb::<f32>::narrow(light.radiance(camera.ray(right, up).1)))
    });
    assert!(farthest(&squares, &expected) > 2.0 * WITHIN_PIXEL, "squares: {}", farthest(&squares, &expected));
}

#[test]
fn a_picture_with_alpha_over_a_color_is_the_picture_before_that_color() {
    let scene = built_in::ball_over_ground(24);
    let color = Rgb::new(0.3, 2.0, 0.7);
    let even = || DistantLight::from_map(bundled::sunset().map());
    let [nothing, before] = [Backdrop::None, Backdrop::Color(color)].map(|behind| even().before(behind));
    let over = |picture: &Picture| {
        let alpha = picture.alpha().expect("an alpha").to_vec();
        let pixels = picture.pixels().iter().zip(alpha).map(|(c, alpha)| {
            let rest = color.scale(f64::from(1.0 - alpha)).to_array();
            [0, 1, 2].map(|k| c[k] + rest[k] as f32)
        });
        Picture::new(picture.width(), picture.height(), pixels.collect::<Vec<[f32; 3]>>()).unwrap()
    };
    let clear = shaded(&scene, &ball(), &nothing, &view()).before_nothing().picture;
    let opaque = shaded(&scene, &ball(), &before, &view()).picture;
    assert!(farthest(&over(&clear), &opaque) < ROUNDING, "by rays: {}", farthest(&over(&clear), &opaque));
    assert!(opaque.alpha().is_none(), "before a color it is opaque");
    let alpha = clear.alpha().unwrap();
    for (what, count) in [
        ("covered", alpha.iter().filter(|a| **a == 1.0).count()),
        ("clear", alpha.iter().filter(|a| **a == 0.0).count()),
        ("edges", alpha.iter().filter(|a| **a > 0.0 && **a < 1.0).count()),
    ] {
        assert!(count > 20, "{what}: {count} pixels");
    }
    let [clear, opaque] = [&nothing, &before].map(|light| traced(&scene, &ball(), light, 16).mean);
    assert!(farthest(&over(&clear), &opaque) < ROUNDING, "by paths: {}", farthest(&over(&clear), &opaque));
    assert!(opaque.alpha().is_none(), "before a color it is opaque");
}

#[test]
fn a_background_is_that_of_the_given_light_or_of_the_one_that_lights() {
    let (map, given) = (Arc::new(coarse()), ShVec::constant(2, Rgb::splat(3.0)));
    let lights = ShVec::constant(1, Rgb::splat(1.0));
    let seen = |background: Background, map: Option<&Arc<EnvMap>>| {
        let light = DistantLight::from_expansion(lights.clone()).before(background.backdrop(map, Some(&given)));
        light.seen(Dir::X)
    };
    assert_eq!(seen(Background::Env, Some(&map)), map.radiance(Dir::X).widen(), "the map");
    assert_eq!(seen(Background::Env, None), given.eval(Dir::X), "the expansion as it was given");
    assert_eq!(seen(Background::Light, Some(&map)), lights.eval(Dir::X), "the light");
    assert_eq!(seen(Background::None, Some(&map)), Rgb::ZERO, "nothing");
    let color = Rgb::new(1.0, 0.5, 0.25);
    assert_eq!(seen(Background::Color(color), Some(&map)), color, "a color");
}
