//! Lights out of expansions: planted lights, closed forms, dense least squares.

use std::f64::consts::PI;

use lobe_sh::expansion::optimal_linear_direction;
use lobe_sh::light::{Normalization, directional_normalization};
use lobe_sh::light_extraction::{
    LightChoice, LightFit, LightFitOptions, LightMetric, PeakSearch, extract_light, extract_light_per_channel,
    extract_lights, fit_lights,
};
use lobe_sh::{Coefficient as _, Dir, Expansion as _, Light, Rgb, ShVec, Zonal};
use lobe_testkit::{Random, directions};
use nalgebra::{DMatrix, DVector};

type Planted = Vec<(Dir, Rgb<f64>)>;

fn random(order: usize, seed: u64) -> ShVec<f64> {
    ShVec::from_vec(Random::new(seed).signed_vec(order * order)).unwrap()
}

fn normalized(order: usize, dir: Dir) -> ShVec<f64> {
    ShVec::impulse(order, dir, directional_normalization(order))
}

/// The reflected radiance: irradiance over π.
fn reflected(f: &ShVec<f64>) -> ShVec<f64> {
    &f.convolved(&Zonal::clamped_cosine(f.order())) * (1.0 / PI)
}

fn probe(order: usize, lights: &Planted, ambient: Rgb<f64>) -> ShVec<Rgb<f64>> {
    let mut f = ShVec::constant(order, ambient);
    for (dir, color) in lights {
        let light = Light::Directional { dir: *dir, color: *color };
        f += &light.project(order, Normalization::Projected).unwrap();
    }
    f
}

fn largest(c: Rgb<f64>) -> f64 {
    c.to_array().into_iter().fold(0.0, |m, c| m.max(c.abs()))
}

/// The same fit by a dense least-squares system in reflected radiance, one column a light and one for ambient.
fn dense(f: &ShVec<f64>, dirs: &[Dir]) -> Vec<f64> {
    let order = f.order();
    let mut columns: Vec<ShVec<f64>> = dirs.iter().map(|d| reflected(&normalized(order, *d))).collect();
    columns.push(reflected(&ShVec::constant(order, 1.0)));
    let matrix = DMatrix::from_fn(order * order, columns.len(), |i, j| columns[j][i]);
    let right = DVector::from_vec(reflected(f).into_vec());
    matrix.svd(true, true).solve(&right, 1e-14).unwrap().as_slice().to_vec()
}

#[test]
fn one_light_equals_dense_least_squares_at_every_order() {
    for order in 2..=10 {
        for seed in 0..20 {
            let f = random(order, 100 * order as u64 + seed);
            let fit = extract_light(&f).unwrap();
            let dir = optimal_linear_direction(&f).unwrap();
            let expected = dense(&f, &[dir]);
            let found = [fit.lights[0].intensity, fit.ambient];
            for (a, b) in found.iter().zip(&expected) {
                assert!((a - b).abs() < 1e-10, "order {order}, seed {seed}: {found:?} against {expected:?}");
            }
            let left = reflected(&(&f - &fit.to_sh()));
            let (energy, all) = (left.dot(&left), reflected(&f).dot(&reflected(&f)));
            assert!((fit.residual - energy).abs() < 1e-12, "order {order}: {} against {energy}", fit.residual);
            assert!((fit.energy - all).abs() < 1e-12, "order {order}: {} against {all}", fit.energy);
        }
    }
}

#[test]
fn one_light_has_the_published_factors() {
    let dc_of_light = [
        (2, 2.0 * PI.sqrt() / 3.0),
        (3, 8.0 * PI.sqrt() / 17.0),
        (4, 8.0 * PI.sqrt() / 17.0),
        (5, 16.0 * PI.sqrt() / 31.0),
    ];
    let factors =
        [(2, 27.0 / (16.0 * PI)), (3, 867.0 / (316.0 * PI)), (4, 867.0 / (316.0 * PI)), (5, 0.719190753814944)];
    for ((order, factor), (_, dc)) in factors.into_iter().zip(dc_of_light) {
        for seed in 0..10 {
            let f = random(order, seed);
            let light = normalized(order, optimal_linear_direction(&f).unwrap());
            let (mut a, mut b) = (reflected(&light), reflected(&f));
            (a[0], b[0]) = (0.0, 0.0);
            let c = factor * a.dot(&b);
            let ambient = (f[0] - c * dc) / (2.0 * PI.sqrt());
            let fit = extract_light(&f).unwrap();
            assert!((fit.lights[0].intensity - c).abs() < 1e-13, "order {order}: {fit:?} against {c}");
            assert!((fit.ambient - ambient).abs() < 1e-13, "order {order}: {fit:?} against {ambient}");
        }
    }
}

#[test]
fn two_and_three_lights_have_their_closed_forms() {
    let mut random_dirs = Random::new(8);
    // Close lights leave no digits to compare: others are drawn.
    let mut apart = || loop {
        let dirs: Vec<Dir> = (0..3).map(|_| Dir::from_unit(random_dirs.direction())).collect();
        if dirs[0].dot(dirs[1]).max(dirs[0].dot(dirs[2])).max(dirs[1].dot(dirs[2])) <= 0.8 {
            return dirs;
        }
    };
    let mut compared = [0, 0];
    for order in [2, 3, 4, 6] {
        for seed in 0..40 {
            let f = random(order, 50 + seed);
            let dirs = apart();
            let without_dc = |f: &ShVec<f64>| {
                let mut f = reflected(f);
                f[0] = 0.0;
                f
            };
            let lights: Vec<ShVec<f64>> = dirs.iter().map(|d| without_dc(&normalized(order, *d))).collect();
            let r: Vec<f64> = lights.iter().map(|l| l.dot(&without_dc(&f))).collect();
            let a = lights[0].dot(&lights[0]);
            let (b, c, d) = (lights[0].dot(&lights[1]), lights[0].dot(&lights[2]), lights[1].dot(&lights[2]));
            let two = [a * r[0] - b * r[1], a * r[1] - b * r[0]].map(|x| x / (a * a - b * b));
            let e = 2.0 * b * c * d + a * (a * a - b * b - c * c - d * d);
            let rows = [
                [a * a - d * d, c * d - a * b, b * d - a * c],
                [c * d - a * b, a * a - c * c, b * c - a * d],
                [b * d - a * c, b * c - a * d, a * a - b * b],
            ];
            let three = rows.map(|row| (row[0] * r[0] + row[1] * r[1] + row[2] * r[2]) / e);
            let options = LightFitOptions::default().non_negative(false);
            for (count, expected) in [(2, &two[..]), (3, &three[..])] {
                // Three lights in a plane, and three in the three numbers of band 1 with its dc, determine nothing.
                if count == 3 && (order == 2 || e.abs() < 1e-2) {
                    continue;
                }
                compared[count - 2] += 1;
                let fit = fit_lights(&f, &dirs[..count], &options).unwrap();
                let dc: f64 = expected.iter().sum::<f64>() * directional_normalization(order) / (4.0 * PI).sqrt();
                let ambient = (f[0] - dc) / (2.0 * PI.sqrt());
                for (light, expected) in fit.lights.iter().zip(expected) {
                    assert!((light.intensity - expected).abs() < 1e-10, "order {order}: {fit:?} against {expected}");
                }
                assert!((fit.ambient - ambient).abs() < 1e-10, "order {order}: {fit:?} against {ambient}");
                for (x, y) in fit.lights.iter().map(|l| l.intensity).chain([fit.ambient]).zip(dense(&f, &dirs[..count]))
                {
                    assert!((x - y).abs() < 1e-10, "order {order}, {count} lights: {x} against dense {y}");
                }
            }
        }
    }
    println!("{compared:?} fits compared with two and with three lights");
    assert!(compared[0] == 160 && compared[1] >= 110, "{compared:?} fits compared");
}

#[test]
fn the_product_of_two_order_three_lights_is_its_polynomial() {
    for g in [-1.0, -0.3, 0.2, 0.9, 1.0_f64] {
        let (a, b) = (normalized(3, Dir::Z), normalized(3, Dir::from_angles(g.acos(), 0.7)));
        let (mut a, mut b) = (reflected(&a), reflected(&b));
        (a[0], b[0]) = (0.0, 0.0);
        let expected = 30.0 * PI / 289.0 * g * g + 256.0 * PI / 867.0 * g - 10.0 * PI / 289.0;
        assert!((a.dot(&b) - expected).abs() < 1e-14, "cosine {g}: {} against {expected}", a.dot(&b));
    }
}

#[test]
fn a_single_light_comes_back_from_anywhere_at_any_order() {
    for v in directions().into_iter().step_by(3) {
        let (dir, color, ambient) = (Dir::from_unit(v), Rgb::new(3.0, 2.0, 0.5), Rgb::new(0.1, 0.2, 0.4));
        for order in [2, 3, 4, 5, 6] {
            let f = probe(order, &vec![(dir, color)], ambient);
            let several = LightFitOptions::default().count(3);
            for fit in [extract_light(&f).unwrap(), extract_lights(&f, &several).unwrap()] {
                let light = fit.lights[0];
                assert!(light.dir.angle_to(dir) < 1e-7, "order {order}, {v:?}: {fit:?}");
                assert!(largest(light.intensity - color) < 1e-7, "order {order}, {v:?}: {fit:?}");
                assert!(largest(fit.ambient - ambient) < 1e-7, "order {order}, {v:?}: {fit:?}");
                assert!(fit.lights.iter().skip(1).all(|l| largest(l.intensity) < 1e-6), "order {order}: {fit:?}");
            }
        }
    }
}

/// Lights at least 70° apart, of unequal colors.
fn planted(count: usize, random: &mut Random) -> Planted {
    let mut lights: Planted = Vec::new();
    while lights.len() < count {
        let dir = Dir::from_unit(random.direction());
        if lights.iter().all(|(other, _)| other.angle_to(dir) > 70.0_f64.to_radians()) {
            let brightness = 1.0 + random.unit();
            lights.push((dir, Rgb::new(1.0, 0.5 + 0.5 * random.unit(), 0.5 + 0.5 * random.unit()).scale(brightness)));
        }
    }
    lights
}

/// The largest errors of directions, in radians, and colors, lights matched by direction.
fn errors(fit: &LightFit<Rgb<f64>>, lights: &Planted, ambient: Rgb<f64>) -> (f64, f64) {
    let mut worst = (0.0_f64, largest(fit.ambient - ambient));
    for (dir, color) in lights {
        let nearest = fit.lights.iter().min_by(|a, b| a.dir.angle_to(*dir).total_cmp(&b.dir.angle_to(*dir)));
        let Some(light) = nearest else { return (PI, f64::INFINITY) };
        worst = (worst.0.max(light.dir.angle_to(*dir)), worst.1.max(largest(light.intensity - *color)));
    }
    worst
}

#[test]
fn a_probe_made_of_known_lights_gives_them_back_when_refined() {
    let mut random = Random::new(3);
    for (order, count) in [(3, 2), (4, 2), (5, 3), (6, 1), (6, 2), (6, 3), (6, 4), (8, 4)] {
        for _ in 0..4 {
            let (lights, ambient) = (planted(count, &mut random), Rgb::new(0.3, 0.2, 0.1));
            let f = probe(order, &lights, ambient);
            for metric in [LightMetric::Irradiance, LightMetric::Radiance] {
                let options = LightFitOptions::default().count(count).refine(true).metric(metric);
                let fit = extract_lights(&f, &options).unwrap();
                let (angle, color) = errors(&fit, &lights, ambient);
                assert_eq!(fit.lights.len(), count, "order {order}, {metric:?}: {fit:?}");
                assert!(angle < 1e-6 && color < 1e-6, "order {order}, {count}, {metric:?}: {angle} and {color}");
                assert!(largest(fit.residual) < 1e-12, "order {order}, {count}: {:?}", fit.residual);
            }
        }
    }
}

#[test]
fn refinement_and_more_lights_only_lower_the_residual() {
    for order in [3, 4, 6] {
        for seed in 0..6 {
            let f = random(order, seed);
            let mut before = f64::INFINITY;
            for count in 0..=4 {
                let plain = LightFitOptions::default().count(count);
                let refined = plain.refine(true);
                let (plain, refined) = (extract_lights(&f, &plain).unwrap(), extract_lights(&f, &refined).unwrap());
                assert!(refined.residual <= plain.residual * (1.0 + 1e-12), "{refined:?} against {plain:?}");
                assert!(plain.residual <= before * (1.0 + 1e-12), "order {order}, {count} lights: {plain:?}");
                assert!(plain.lights.len() <= count && refined.lights.len() <= count, "{plain:?}, {refined:?}");
                for fit in [&plain, &refined] {
                    assert!(fit.ambient >= 0.0 && fit.lights.iter().all(|l| l.intensity > 0.0), "{fit:?}");
                    let left = reflected(&(&f - &fit.to_sh()));
                    assert!((fit.residual - left.dot(&left)).abs() < 1e-12, "order {order}: {fit:?}");
                }
                before = plain.residual;
            }
        }
    }
}

#[test]
fn least_residual_chooses_no_worse_than_height_on_the_whole() {
    let (mut by_height, mut by_residual) = (0.0, 0.0);
    for seed in 0..30 {
        let f = random(6, seed);
        let residual = |choice| {
            let options = LightFitOptions::default().count(3).choice(choice);
            extract_lights(&f, &options).unwrap().residual
        };
        by_height += residual(LightChoice::Height);
        by_residual += residual(LightChoice::Residual);
    }
    println!("residuals: {by_height} by height, {by_residual} one by one");
    assert!(by_residual < by_height, "{by_residual} against {by_height}");
}

#[test]
fn channels_may_have_directions_of_their_own() {
    let (red, blue) = (Dir::from_angles(0.4, 1.0), Dir::from_angles(2.0, -2.0));
    let f = probe(3, &vec![(red, Rgb::new(2.0, 0.0, 0.0)), (blue, Rgb::new(0.0, 0.0, 3.0))], Rgb::new(0.0, 0.5, 0.0));
    let channels = extract_light_per_channel(&f).unwrap();
    for (channel, dir, intensity) in [(0, red, 2.0), (2, blue, 3.0)] {
        let light = channels[channel].lights[0];
        assert!(light.dir.angle_to(dir) < 1e-12, "channel {channel}: {light:?}");
        assert!((light.intensity - intensity).abs() < 1e-12, "channel {channel}: {light:?}");
    }
    assert!((channels[1].ambient - 0.5).abs() < 1e-14, "{:?}", channels[1]);
}

#[test]
fn coefficients_in_f32_are_read_as_they_are() {
    let dir = Dir::from_angles(1.0, 2.0);
    let f = ShVec::<Rgb<f32>>::impulse(4, dir, Rgb::new(1.0, 0.5, 0.25));
    let fit = extract_light(&f).unwrap();
    let expected = 1.0 / directional_normalization(4);
    assert!(fit.lights[0].dir.angle_to(dir) < 1e-6, "{fit:?}");
    assert!((fit.lights[0].intensity.r - expected).abs() < 1e-6, "{fit:?} against {expected}");
}

#[test]
fn bad_and_empty_expansions_have_defined_answers() {
    let options = LightFitOptions::default().count(5).refine(true);
    for f in [ShVec::<f64>::zero(3), ShVec::constant(3, 2.0), ShVec::constant(3, -2.0)] {
        for fit in [extract_light(&f).unwrap(), extract_lights(&f, &options).unwrap()] {
            assert!(fit.lights.is_empty(), "{fit:?}");
        }
        let ambient = extract_lights(&f, &options).unwrap().ambient;
        assert!((ambient - f.mean().max(0.0)).abs() < 1e-14, "{ambient} for {f:?}");
        assert!((extract_light(&f).unwrap().ambient - f.mean()).abs() < 1e-14, "the closed form may be negative");
    }
    for order in [0, 1] {
        let error = extract_lights(&ShVec::<f64>::zero(order), &options).unwrap_err().to_string();
        assert!(error.contains("from order 2 on") && !error.contains('\n'), "{error}");
        assert!(optimal_linear_direction(&ShVec::<f64>::zero(order)).is_none(), "order {order}");
    }
    for bad in [f64::NAN, f64::INFINITY] {
        let mut f = random(3, 1);
        f[5] = bad;
        let error = extract_light(&f).unwrap_err().to_string();
        assert!(error.contains("coefficient 5") && !error.contains('\n'), "{error}");
    }
    // One maximum, five lights wanted; two equal directions.
    let one = normalized(2, Dir::Y);
    for refine in [false, true] {
        let fit = extract_lights(&one, &options.refine(refine)).unwrap();
        assert!(fit.lights.len() == 1 && (fit.lights[0].intensity - 1.0).abs() < 1e-9, "{fit:?}");
    }
    let unlimited = LightFitOptions::default().non_negative(false);
    let fit = fit_lights(&one, &[Dir::Y, Dir::Y], &unlimited).unwrap();
    assert!((fit.lights[0].intensity - 0.5).abs() < 1e-12 && fit.residual < 1e-24, "{fit:?}");
    let none = extract_lights(&one, &options.count(0).search(PeakSearch::Paper)).unwrap();
    assert!(none.lights.is_empty() && none.ambient >= 0.0, "{none:?}");
}
