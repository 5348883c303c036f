//! Numbers of the room of skies beside those of the library, as each control changes them.

use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;
use lobe::env::{Mapping, project_map};
use lobe::figures::{lat_long_picture, lat_long_picture_of};
use lobe::image::compare;
use lobe::sh::light_extraction::{LightFitOptions, extract_lights};
use lobe::sh::ringing::DeringOptions;
use lobe::sh::{Coefficient as _, Rgb, ShVec, Window, Zonal};
use lobe_viewer::{OpenedSky, ReadLimits, SkyEdits, open_sky};

use crate::press::{choose, slide};
use crate::sky::{Shown, minimum_of, open_in};

/// The room in a narrow window, whose pictures are small.
fn open(sky: &OpenedSky) -> Harness<'static, Shown> {
    let mut edits = SkyEdits::default();
    // Then no technique is prepared.
    edits.has_expansion = true;
    open_in([600.0, 1900.0], edits, Some(sky.clone()))
}

fn sunset() -> OpenedSky {
    open_sky("bundled:sunset".as_ref(), &ReadLimits::default()).unwrap()
}

#[test]
fn each_window_and_dering_that_is_chosen_tames_the_expansion_as_the_library_does() {
    let sky = sunset();
    let light = project_map(&sky.map, 8).resized(4);
    let mut harness = open(&sky);
    let by = |window: Window| light.windowed(&window);
    let by_irradiance = DeringOptions::default().kernel(Zonal::clamped_cosine(4));
    let all: [(&str, ShVec<Rgb<f64>>); 9] = [
        ("Hanning", by(Window::Hanning { width: 4.0 })),
        ("Lanczos", by(Window::Lanczos { width: 4.0, power: 1.0 })),
        ("Sinc4", by(Window::Lanczos { width: 4.0, power: 4.0 })),
        ("Gauss", by(Window::Gauss { sigma: 0.3 })),
        ("Squared Laplacian", by(Window::SquaredLaplacian { lambda: 0.005 })),
        ("Punctual lights", by(Window::PunctualLight)),
        ("Dering by radiance", light.deringed_with(&DeringOptions::default()).0),
        ("Dering by irradiance", light.deringed_with(&by_irradiance).0),
        ("None", light.clone()),
    ];
    for (name, tamed) in all {
        choose(&mut harness, "Window", name);
        assert!(harness.query_by_label(&minimum_of(&tamed)).is_some(), "{name}: {}", minimum_of(&tamed));
    }
    choose(&mut harness, "Window", "Hanning");
    slide(&mut harness, "Width in bands", 6.5);
    let wider = by(Window::Hanning { width: 6.5 });
    assert!(harness.query_by_label(&minimum_of(&wider)).is_some(), "wider: {}", minimum_of(&wider));
    choose(&mut harness, "Window", "Lanczos");
    slide(&mut harness, "Power", 2.5);
    let stronger = by(Window::Lanczos { width: 4.0, power: 2.5 });
    assert!(harness.query_by_label(&minimum_of(&stronger)).is_some(), "stronger: {}", minimum_of(&stronger));
    choose(&mut harness, "Window", "Squared Laplacian");
    slide(&mut harness, "Weight", 0.125);
    let fitted = by(Window::SquaredLaplacian { lambda: 0.125 });
    assert!(harness.query_by_label(&minimum_of(&fitted)).is_some(), "fitted: {}", minimum_of(&fitted));
    choose(&mut harness, "Window", "Gauss");
    slide(&mut harness, "Width in radians", 0.5);
    let blurred = by(Window::Gauss { sigma: 0.5 });
    assert!(harness.query_by_label(&minimum_of(&blurred)).is_some(), "blurred: {}", minimum_of(&blurred));
}

#[test]
fn the_error_of_every_order_is_that_of_the_two_pictures() {
    let sky = sunset();
    let truth = lat_long_picture(256, 128, |s| sky.map.radiance(s).widen());
    let mean = truth.mean().iter().sum::<f64>() / 3.0;
    let mut harness = open(&sky);
    let mut before = f64::INFINITY;
    for order in 1..=8_usize {
        slide(&mut harness, "Order", order as f64);
        let made = lat_long_picture_of(256, 128, &project_map(&sky.map, 8).resized(order));
        let error = compare(made.pixels(), truth.pixels()).rmse / mean;
        let text = format!("RMS error: {error:.2} times the mean");
        assert!(harness.query_by_label(&text).is_some(), "order {order}: {text}");
        // Pixels are not weighted by their solid angle, so that a band more need not be nearer.
        assert!(error < 1.1 * before, "order {order}: {error}, before {before}");
        before = error;
    }
}

#[test]
fn as_many_lights_are_listed_as_the_slider_says_with_the_numbers_of_the_library() {
    let sky = sunset();
    let light = project_map(&sky.map, 8).resized(4);
    let mut harness = open(&sky);
    for count in [0, 1, 3, 4] {
        slide(&mut harness, "Lights", count as f64);
        let listed = harness.query_all_by_label_contains(": azimuth ").count();
        if count == 0 {
            assert_eq!(
                (listed, harness.query_by_label_contains("Ambient: ").is_some()),
                (0, false),
                "none is looked for"
            );
            continue;
        }
        let fit = extract_lights(&light, &LightFitOptions::default().count(count)).unwrap();
        assert!(!fit.lights.is_empty() && fit.lights.len() == listed, "{count}: {} and {listed}", fit.lights.len());
        for (k, found) in fit.lights.iter().enumerate() {
            let (azimuth, height) = (found.dir.phi().to_degrees(), 90.0 - found.dir.theta().to_degrees());
            let [r, g, b] = <[f64; 3]>::from(found.intensity);
            let text = format!("Light {}: azimuth {azimuth:.0}°, height {height:.0}°, {r:.2} {g:.2} {b:.2}", k + 1);
            assert!(harness.query_by_label(&text).is_some(), "{count} lights: {text}");
        }
    }
}

#[test]
fn every_mapping_that_is_chosen_is_unfolded_in_its_own_shape() {
    let mut harness = open(&sunset());
    for mapping in Mapping::ALL {
        choose(&mut harness, "Mapping", mapping.name());
        assert_eq!(harness.state().room.edits().mapping, mapping.name(), "it is kept");
        let title = format!("Unfolded: {}", mapping.name());
        assert!(harness.query_by_label(&title).is_some(), "{title}");
        let rect = harness.get_by_label("The sky, unfolded").rect();
        let expected = 256.0 / mapping.height_for(256) as f32;
        let found = rect.width() / rect.height();
        assert!((found / expected - 1.0).abs() < 0.01, "{}: {found} wide, expected {expected}", mapping.name());
    }
}
