//! Ringing of the expansions of photographs, and its removal by dering.

use lobe_env::{EnvMap, SunOptions, bundled, extract_sun, project_env};
use lobe_sh::light_extraction::{LightFitOptions, LightMetric, extract_lights};
use lobe_sh::ringing::{DeringMethod, DeringOptions, DeringOutcome, WindowFamily};
use lobe_sh::sphere::even_directions;
use lobe_sh::{Coefficient as _, Dir, Expansion as _, Rgb, ShVec, Window, Zonal};

/// Sampled directions: a degree and a half apart, far below the wavelength of order 6.
const SAMPLES: usize = 16_000;

/// The orders of the probes.
const ORDERS: std::ops::RangeInclusive<usize> = 3..=6;

/// The widest window that Filament's search tries, and its precision.
const FILAMENT_WIDEST: f64 = 13.0;

fn least_of_channels(f: &ShVec<Rgb<f64>>, basis: &[(Dir, Vec<f64>)]) -> [f64; 3] {
    let mut least = [f64::INFINITY; 3];
    for (_, y) in basis {
        let mut value = Rgb::<f64>::ZERO;
        for (y, c) in y.iter().zip(f.coefficients()) {
            value += c.scale(*y);
        }
        least = [0, 1, 2].map(|c| least[c].min(value.channel(c)));
    }
    least
}

#[test]
fn no_real_map_is_below_zero_anywhere_after_dering() {
    let basis: Vec<_> = even_directions(SAMPLES).map(|s| (s, lobe_sh::eval_basis(s, *ORDERS.end()))).collect();
    let mut rang = 0;
    for (name, map) in crate::common::real_maps() {
        let radiance = project_env(&map, *ORDERS.end());
        for order in ORDERS {
            let radiance = radiance.resized(order);
            let irradiance = radiance.convolved(&Zonal::clamped_cosine(order));
            for (quantity, f) in [("radiance", radiance), ("irradiance", irradiance)] {
                let (g, report) = f.deringed_with(&DeringOptions::default());
                let done = matches!(report.outcome, DeringOutcome::Windowed | DeringOutcome::Unchanged);
                assert!(done, "{name}, {quantity} of order {order}: {report:?}");
                rang += usize::from(report.outcome == DeringOutcome::Windowed);
                let least = least_of_channels(&g, &basis);
                for (c, least) in least.into_iter().enumerate() {
                    let dc = f.mean().channel(c);
                    assert!(g.mean().channel(c) == dc, "{name}: the mean stays");
                    assert!(least >= -1e-6 * dc, "{name}, {quantity} of order {order}, channel {c}: {least} of {dc}");
                    assert!(report.after[c].lo >= -1e-6 * dc, "{name}, order {order}: {:?}", report.after[c]);
                }
            }
        }
    }
    println!("{rang} expansions rang below zero");
    assert!(rang >= 8, "only {rang} expansions had anything to remove");
}

/// The fraction of the L2 norm that remains.
fn norm_kept(f: &ShVec<Rgb<f64>>, g: &ShVec<Rgb<f64>>) -> f64 {
    let square = |f: &ShVec<Rgb<f64>>| f.dot(f).to_array().iter().sum::<f64>();
    (square(g) / square(f)).sqrt()
}

/// Filament takes the fourth power of the sigma factors, of the largest width up to 13 that makes the function
/// non-negative. This is its best case: the width to rounding, not to a tenth.
fn best_of_filament(f: &ShVec<Rgb<f64>>) -> ShVec<Rgb<f64>> {
    let method = DeringMethod::Family(WindowFamily::Lanczos { power: 4.0 });
    let (_, report) = f.deringed_with(&DeringOptions::default().method(method));
    let width = match report.window {
        Some(Window::Lanczos { width, .. }) => width.min(FILAMENT_WIDEST),
        _ => FILAMENT_WIDEST,
    };
    f.windowed(&Window::Lanczos { width, power: 4.0 })
}

#[test]
fn the_least_change_keeps_more_of_a_sun_probe_than_filament() {
    for map in bundled::all() {
        let irradiance = project_env(&map.map(), 3).convolved(&Zonal::clamped_cosine(3));
        let (g, _) = irradiance.deringed_with(&DeringOptions::default());
        let (ours, theirs) = (norm_kept(&irradiance, &g), norm_kept(&irradiance, &best_of_filament(&irradiance)));
        println!("{}: {:.2} % of the norm kept, Filament {:.2} %", map.name, 100.0 * ours, 100.0 * theirs);
        assert!(ours > 0.85 && ours > theirs, "{}: {ours} of the norm kept, Filament {theirs}", map.name);
    }
    // A sun alone: the worst case.
    let sun = ShVec::impulse(3, Dir::from_angles(1.2, 0.7), Rgb::new(9.0, 8.0, 6.0));
    let irradiance = sun.convolved(&Zonal::clamped_cosine(3));
    let (g, _) = irradiance.deringed_with(&DeringOptions::default());
    let (ours, theirs) = (norm_kept(&irradiance, &g), norm_kept(&irradiance, &best_of_filament(&irradiance)));
    println!("a sun alone: {:.2} % of the norm kept, Filament {:.2} %", 100.0 * ours, 100.0 * theirs);
    assert!(ours > 0.85 && ours > theirs, "a sun alone: {ours} of the norm kept, Filament {theirs}");
}

/// The most bands from which the light is estimated.
const SUN_ORDER: usize = 10;

/// The maps with a known sun, with their names and its direction.
fn maps_with_a_sun() -> Vec<(String, EnvMap, Dir)> {
    let sun = |map: &EnvMap| extract_sun(map, &SunOptions::default()).map(|report| report.sun.direction);
    let maps = crate::common::real_maps().into_iter();
    maps.filter_map(|(name, map)| sun(&map).map(|dir| (name, map, dir))).collect()
}

/// The angle in degrees between the one light that explains most and the sun of the picture, for orders 2 to 10.
fn angles_to_the_sun(radiance: &ShVec<Rgb<f64>>, sun: Dir, metric: LightMetric, refine: bool) -> Vec<f64> {
    let angle = |order: usize| {
        let options = LightFitOptions::default().count(1).refine(refine).metric(metric);
        let fit = extract_lights(&radiance.resized(order), &options).unwrap();
        fit.lights[0].dir.angle_to(sun).to_degrees()
    };
    (2..=SUN_ORDER).map(angle).collect()
}

#[test]
fn the_light_found_in_a_picture_comes_nearer_to_its_sun_with_the_order() {
    let maps = maps_with_a_sun();
    assert!(maps.iter().any(|(name, ..)| name == "sunset"), "the sunset has a sun");
    for (name, map, sun) in maps {
        let radiance = project_env(&map, SUN_ORDER);
        let [maxima, refined] =
            [false, true].map(|refine| angles_to_the_sun(&radiance, sun, LightMetric::Radiance, refine));
        let [for_surfaces, surfaces_refined] =
            [false, true].map(|refine| angles_to_the_sun(&radiance, sun, LightMetric::Irradiance, refine));
        println!("{name}: degrees at orders 2 to {SUN_ORDER}");
        println!("  for radiance, at a maximum {maxima:.2?}, refined {refined:.2?}");
        println!("  for irradiance, at a maximum {for_surfaces:.2?}, refined {surfaces_refined:.2?}");
        // Indoors the brightest small lamp need not be the main light of the room: there the table only reports.
        if name == "sunset" {
            for (what, angles) in [("at a maximum", &maxima), ("refined", &refined)] {
                // The resolution is the wavelength of the last band, 40 degrees.
                assert!(angles[angles.len() - 1] < 12.0, "{name}, {what}: {angles:.2?} degrees");
                assert!(angles.is_sorted_by(|a, b| a > b), "{name}, {what}: {angles:.2?} degrees");
                assert!(angles[0] > 40.0, "{name}, {what}: {angles:.2?} degrees");
            }
            let is_nearer = refined[1..].iter().zip(&maxima[1..]).all(|(r, m)| r < m);
            assert!(is_nearer, "{name}: refined {refined:.2?} against {maxima:.2?} degrees");
            // Diffuse surfaces hardly see bands beyond 2: the light that is best for them stays in the middle of the
            // glow.
            let is_level = surfaces_refined[1..].iter().all(|a| (a - surfaces_refined[1]).abs() < 1.0);
            assert!(is_level, "{name}, refined for irradiance: {surfaces_refined:.2?} degrees");
        }
    }
}
