//! Ringing is gone after dering, with no more change than needed, whatever the light.

use std::f64::consts::PI;

use lobe_sh::extrema::certified_minimum;
use lobe_sh::filter::scale_bands_in_place;
use lobe_sh::ringing::{
    DeringMethod, DeringOptions, DeringOutcome, WindowFamily, conservative_minimum, dering_in_place,
};
use lobe_sh::{Dir, Expansion, Rgb, Rotation, ShL2, ShVec, Window, Zonal};
use lobe_testkit::{Random, directions, fibonacci_sphere};

const METHODS: [DeringMethod; 6] = [
    DeringMethod::LeastChange,
    DeringMethod::Table,
    DeringMethod::Family(WindowFamily::Hanning),
    DeringMethod::Family(WindowFamily::Lanczos { power: 4.0 }),
    DeringMethod::Family(WindowFamily::Gauss),
    DeringMethod::Family(WindowFamily::SquaredLaplacian),
];

/// The 26 axes and diagonals of the cube come first among the test directions, the poles among them.
pub(crate) const SUNS: usize = 26;

fn quick() -> DeringOptions {
    DeringOptions::default().evidence(false)
}

pub(crate) fn with(method: DeringMethod) -> DeringOptions {
    DeringOptions::default().method(method)
}

/// The least value over the test directions and a Fibonacci sphere.
fn least_sampled(f: &impl Expansion<f64>) -> f64 {
    let all = directions().into_iter().chain(fibonacci_sphere(800));
    all.map(|v| f.eval(Dir::from_unit(v))).fold(f64::INFINITY, f64::min)
}

/// A few lights of random color and size on a random ambient light.
fn random_probe(random: &mut Random, order: usize) -> ShVec<Rgb> {
    let mut f = ShVec::<Rgb<f64>>::zero(order);
    for _ in 0..1 + (4.0 * random.unit()) as usize {
        let color = Rgb::new(random.unit(), random.unit(), random.unit());
        f += &ShVec::impulse(order, Dir::from_unit(random.direction()), color);
    }
    let ambient = 0.2 * random.unit();
    f[0] += Rgb::new(ambient, ambient, 2.0 * ambient);
    f.map(|c| Rgb::new(c.r as f32, c.g as f32, c.b as f32))
}

fn channels(f: &impl Expansion<Rgb>) -> [ShVec<f64>; 3] {
    [0, 1, 2].map(|c| ShVec::from_vec(f.coefficients().iter().map(|f| f64::from(f.to_array()[c])).collect()).unwrap())
}

/// A sun on a dim sky over dark ground, as radiance.
fn sun_and_sky(order: usize, sun: Dir) -> ShVec<f64> {
    let sky = Zonal::project(order, &[0.0], 20, |t| if t > 0.0 { 1.0 + 0.5 * t } else { 0.1 });
    &sky.towards(Dir::Z, 1.0) + &ShVec::impulse(order, sun, 8.0)
}

#[test]
fn random_probes_of_order_3_have_no_point_below_zero() {
    let mut random = Random::new(1);
    let cosine = Zonal::clamped_cosine(3);
    let samples = fibonacci_sphere(60);
    let mut changed = 0;
    for case in 0..7000 {
        let mut f = ShL2::from_slice(random_probe(&mut random, 3).coefficients());
        if case % 2 == 0 {
            f = f.convolved(&cosine);
        }
        let before = f;
        let report = dering_in_place(f.coefficients_mut(), &quick());
        match report.outcome {
            DeringOutcome::Unchanged => assert_eq!(f, before, "case {case} is untouched"),
            DeringOutcome::Windowed => changed += 1,
            other => panic!("case {case}: {other:?}"),
        }
        for channel in channels(&f) {
            let dc = channel.mean();
            let min = certified_minimum(channel.coefficients(), 1e-7);
            assert!(min.lo >= -1e-6 * dc, "case {case}: {min:?} of the mean {dc}");
            for v in &samples {
                let value = channel.eval(Dir::from_unit(*v));
                assert!(value >= -1e-6 * dc, "case {case}: {value} towards {v:?}");
            }
        }
    }
    assert!(changed > 3500, "only {changed} probes had anything to remove");
}

/// Dering `count` probes of an order by the least change, as radiance.
fn check_random_probes(order: usize, count: usize) {
    let mut random = Random::new(order as u64);
    let samples = fibonacci_sphere(8 * order * order);
    let mut changed = 0;
    for case in 0..count {
        let f = random_probe(&mut random, order);
        let (g, report) = f.deringed_with(&DeringOptions::default());
        match report.outcome {
            DeringOutcome::Unchanged => assert_eq!(g, f, "order {order}, case {case} is untouched"),
            DeringOutcome::Windowed => changed += 1,
            other => panic!("order {order}, case {case}: {other:?}"),
        }
        for (c, channel) in channels(&g).iter().enumerate() {
            let dc = channel.mean();
            let least = samples.iter().map(|v| channel.eval(Dir::from_unit(*v))).fold(f64::INFINITY, f64::min);
            assert!(least >= -1e-6 * dc, "order {order}, case {case}, channel {c}: {least} of {dc}");
            assert!(report.after[c].lo >= -1e-6 * dc, "order {order}, case {case}: {:?}", report.after[c]);
        }
        let inside = report.factors.iter().all(|w| (0.0..=1.0).contains(w));
        assert!(inside && report.factors[0] == 1.0, "order {order}: {:?}", report.factors);
        if let Some(excess) = report.excess {
            let energies: Vec<f64> =
                (0..order).map(|l| channels(&f).iter().map(|c| c.band_energies()[l]).sum()).collect();
            let change: f64 = energies.iter().zip(&report.factors).map(|(e, w)| e * (1.0 - w).powi(2)).sum();
            let beyond = excess * (change / energies.iter().sum::<f64>()).sqrt();
            assert!(
                beyond < BEYOND_LEAST,
                "order {order}, case {case}: {beyond} of the norm more than the least change"
            );
        }
    }
    assert!(2 * changed > count, "order {order}: only {changed} of {count} probes had anything to remove");
}

/// What a change may exceed the least by, relative to the norm of the function: minima that end 1e-6 of the mean below
/// zero, a proof to half of that, and rounding to `f32`.
const BEYOND_LEAST: f64 = 1e-5;

macro_rules! random_probes {
    ($($name:ident $order:literal $count:literal),*) => {$(
        #[test]
        fn $name() {
            check_random_probes($order, $count);
        }
    )*};
}

// With those of order 3, more than 10000.
random_probes!(
    random_probes_of_order_2_have_no_point_below_zero 2 2200, random_probes_of_order_4_have_no_point_below_zero 4 500,
    random_probes_of_order_5_have_no_point_below_zero 5 200, random_probes_of_order_6_have_no_point_below_zero 6 120,
    random_probes_of_order_8_have_no_point_below_zero 8 40
);

#[test]
fn every_method_works_for_suns_in_all_directions() {
    let suns = directions();
    let cosine = Zonal::clamped_cosine(3);
    for method in METHODS {
        let mut kept = Vec::new();
        // The families search, so fewer for them.
        let count = if matches!(method, DeringMethod::Family(_)) { SUNS } else { suns.len() };
        for v in &suns[..count] {
            let f = ShVec::<f64>::impulse(3, Dir::from_unit(*v), 1.0).convolved(&cosine);
            let (g, report) = f.deringed_with(&with(method));
            let (dc, least) = (g.mean(), least_sampled(&g));
            assert_eq!(report.outcome, DeringOutcome::Windowed, "{method} towards {v:?}");
            assert!(least >= -1e-6 * dc && report.after[0].lo >= -1e-6 * dc, "{method} towards {v:?}: {least}");
            assert!((report.before[0].hi / dc + 0.158333).abs() < 2e-6, "{method}: {:?}", report.before);
            kept.push(1.0 - report.energy_removed);
        }
        let (low, high) = kept.iter().fold((1.0_f64, 0.0_f64), |(a, b), k| (a.min(*k), b.max(*k)));
        assert!(high - low < 1e-5, "{method} keeps {low} to {high} depending on the direction");
    }
}

/// Suns in the 26 directions, as radiance and as irradiance, at orders that no quadratic form serves.
#[test]
fn suns_of_higher_orders_are_deringed_in_all_directions() {
    let color = Rgb::new(2.0, 1.5, 0.5);
    for order in [5, 6] {
        let samples: Vec<Dir> = fibonacci_sphere(20 * order * order).into_iter().map(Dir::from_unit).collect();
        for (quantity, kernel) in [("radiance", Zonal::impulse(order)), ("irradiance", Zonal::clamped_cosine(order))] {
            for method in [DeringMethod::LeastChange, DeringMethod::Family(WindowFamily::SquaredLaplacian)] {
                for v in &directions()[..SUNS] {
                    let what = format!("{method} of {quantity}, order {order}, towards {v:?}");
                    let sun = kernel.towards(Dir::from_unit(*v), color);
                    let f: ShVec<Rgb> = sun.map(|c| Rgb::new(c.r as f32, c.g as f32, c.b as f32));
                    let (g, report) = f.deringed_with(&with(method));
                    assert_eq!(report.outcome, DeringOutcome::Windowed, "{what}");
                    for (c, channel) in channels(&g).iter().enumerate() {
                        let dc = channel.mean();
                        let least = samples.iter().map(|s| channel.eval(*s)).fold(f64::INFINITY, f64::min);
                        assert!(least >= -1e-6 * dc, "{what}, channel {c}: {least} of the mean {dc}");
                        assert!(report.after[c].lo >= -1e-6 * dc, "{what}, channel {c}: {:?}", report.after[c]);
                        assert!(report.before[c].hi < -1e-3 * dc, "{what}: it rang, {:?}", report.before[c]);
                    }
                }
            }
        }
    }
}

#[test]
fn the_irradiance_of_an_impulse_has_its_known_factors() {
    let f = ShVec::<f64>::impulse(3, Dir::from_angles(0.4, 2.0), 1.0).convolved(&Zonal::clamped_cosine(3));
    let (_, report) = f.deringed_with(&DeringOptions::default());
    for (l, known) in [(1, 0.857890), (2, 0.909395)] {
        let found = report.factors[l];
        assert!((found - known).abs() < 3e-4, "band {l}: {found} against {known}");
    }
    // sinc⁴ reaches zero at the width 3.3144634591.
    let family = WindowFamily::Lanczos { power: 4.0 };
    let (_, report) = f.deringed_with(&with(DeringMethod::Family(family)));
    for (l, known) in [(1, 0.539036481), (2, 0.062458370)] {
        let found = report.factors[l];
        assert!((found - known).abs() < 1e-5, "sinc⁴, band {l}: {found} against {known}");
    }
}

/// The least change among all pairs of factors, from a fine grid.
#[test]
fn no_pair_of_factors_changes_an_order_3_probe_less() {
    let mut random = Random::new(3);
    for case in 0..6 {
        let f = random_probe(&mut random, 3);
        let (_, report) = f.deringed_with(&DeringOptions::default());
        let energies: Vec<f64> = (0..3).map(|l| channels(&f).iter().map(|c| c.band_energies()[l]).sum()).collect();
        let cost = |w: [f64; 2]| energies[1] * (1.0 - w[0]).powi(2) + energies[2] * (1.0 - w[1]).powi(2);
        let found = cost([report.factors[1], report.factors[2]]);
        let steps = 40;
        for i in 0..=steps {
            for j in 0..=steps {
                let w = [f64::from(i) / f64::from(steps), f64::from(j) / f64::from(steps)];
                if cost(w) >= found * 0.9999 {
                    continue;
                }
                let negative = channels(&f).into_iter().any(|mut c| {
                    scale_bands_in_place(c.coefficients_mut(), &[1.0, w[0], w[1]]);
                    certified_minimum(c.coefficients(), 1e-9).hi < 0.0
                });
                assert!(negative, "case {case}: {w:?} suffices, {:?} costs more", report.factors);
            }
        }
    }
}

/// The two solvers share nothing but the idea: one has a line search in a plane, the other active sets.
#[test]
fn three_bands_written_as_four_have_the_same_solution() {
    let mut random = Random::new(4);
    for case in 0..40 {
        let f = random_probe(&mut random, 3);
        let (_, short) = f.deringed_with(&DeringOptions::default());
        // A fourth band too small to matter, so that the general search is used.
        let mut long = f.resized(4);
        long[12] = Rgb::new(1e-12, 1e-12, 1e-12);
        let (_, long) = long.deringed_with(&DeringOptions::default());
        for l in 0..3 {
            let (a, b) = (short.factors[l], long.factors[l]);
            // The general search stops at 1e-6 of the mean; the factors are good to about the root of that.
            assert!((a - b).abs() < 2e-3, "case {case}, band {l}: {a} against {b}");
        }
        let change = |w: &[f64]| -> f64 {
            let energies = channels(&f).map(|c| c.band_energies());
            (1..3).map(|l| energies.iter().map(|e| e[l]).sum::<f64>() * (1.0 - w[l]).powi(2)).sum()
        };
        let (a, b) = (change(&short.factors), change(&long.factors));
        assert!((a / b - 1.0).abs() < 2e-5, "case {case}: the squared changes are {a} and {b}");
    }
}

#[test]
fn least_change_keeps_more_than_every_window_and_than_filament() {
    for order in [3, 5] {
        for (sun, brightness) in [(Dir::from_angles(0.7, 1.0), 0.0), (Dir::Z, 30.0), (Dir::Y, 60.0)] {
            // The probe itself does not ring, a brighter sun does.
            let probe = &sun_and_sky(order, sun) + &ShVec::impulse(order, sun, brightness);
            let e = probe.convolved(&Zonal::clamped_cosine(order));
            let norm = |f: &ShVec<f64>| f.dot(f).sqrt();
            let change = |method| {
                let (g, report) = e.deringed_with(&with(method));
                assert!(report.after[0].lo >= -1e-6 * e.mean(), "{method}: {:?}", report.after);
                let is_changed = report.outcome == DeringOutcome::Windowed;
                assert_eq!(is_changed, brightness > 0.0, "order {order}, {brightness} brighter: {report:?}");
                (norm(&(&g - &e)), norm(&g) / norm(&e))
            };
            let (least, kept) = change(DeringMethod::LeastChange);
            for method in METHODS {
                if order == 3 || method != DeringMethod::Table {
                    let (other, _) = change(method);
                    assert!(least <= other * (1.0 + 1e-4), "order {order}, {method}: {other} against {least}");
                }
            }
            // Filament's search, at its best: sinc⁴ of the widest width up to 13 that makes the probe non-negative.
            let (_, report) = e.deringed_with(&with(DeringMethod::Family(WindowFamily::Lanczos { power: 4.0 })));
            let width = match report.window {
                Some(Window::Lanczos { width, .. }) => width.min(13.0),
                _ => 13.0,
            };
            let theirs = norm(&e.windowed(&Window::Lanczos { width, power: 4.0 })) / norm(&e);
            println!("order {order}, {brightness} brighter: {kept} of the norm kept, Filament {theirs}");
            assert!(kept > 0.9 && kept > theirs, "order {order}: {kept} of the norm is left, Filament {theirs}");
        }
    }
}

#[test]
fn non_negative_functions_come_back_bit_for_bit() {
    let cosine = Zonal::clamped_cosine(4);
    for order in [1, 2, 3, 4, 6] {
        let ambient = ShVec::constant(order, Rgb::new(0.1_f32, 1.0, 3.0));
        // 1 + z is zero at one point.
        let touching = Zonal::project(order, &[], 8, |t| if order > 1 { 1.0 + t } else { 1.0 })
            .towards(Dir::X, Rgb::new(1.0, 1.0, 1.0));
        for f in [ambient, touching, ShVec::zero(order)] {
            for method in METHODS {
                for kernel in [None, Some(cosine.clone())] {
                    let (g, report) = f.deringed_with(&DeringOptions::default().method(method).kernel(kernel));
                    assert_eq!(report.outcome, DeringOutcome::Unchanged, "order {order}, {method}");
                    assert_eq!(g, f, "order {order}, {method}");
                    assert_eq!(report.energy_removed, 0.0, "order {order}, {method}");
                }
            }
        }
    }
}

#[test]
fn what_was_deringed_needs_it_no_more() {
    let mut random = Random::new(5);
    for order in [2, 3, 5] {
        for method in METHODS {
            if order > 3 && method == DeringMethod::Table {
                continue;
            }
            // Irradiance: the table suffices for no more.
            let probe = random_probe(&mut random, order).convolved(&Zonal::clamped_cosine(order));
            let (once, _) = probe.deringed_with(&with(method));
            let (twice, report) = once.deringed_with(&with(method));
            assert_eq!((report.outcome, twice), (DeringOutcome::Unchanged, once), "order {order}, {method}");
        }
    }
}

#[test]
fn colors_share_one_window_and_the_worst_decides() {
    let sun = ShL2::<Rgb<f64>>::impulse(Dir::Y, Rgb::new(1.0, 0.0, 0.0));
    let f = sun + ShL2::constant(Rgb::new(0.01, 5.0, 5.0));
    let (g, report) = f.deringed_with(&DeringOptions::default());
    let red = ShL2::from_slice(&f.coefficients().iter().map(|c| c.r).collect::<Vec<f64>>());
    let (_, alone) = red.deringed_with(&DeringOptions::default());
    assert_eq!(report.factors, alone.factors, "red decides");
    assert_eq!((report.before.len(), report.after.len()), (3, 3), "each channel is reported");
    assert!((g[2].g - report.factors[1] * f[2].g).abs() < 1e-15, "green has the same window");
    assert!(report.before[0].hi < 0.0 && report.before[1].lo > 0.0, "{:?}", report.before);
}

#[test]
fn rotation_turns_the_result_along() {
    let mut random = Random::new(6);
    for order in [3, 5] {
        let f = sun_and_sky(order, Dir::from_angles(1.0, -2.0));
        let (g, report) = f.deringed_with(&DeringOptions::default());
        for _ in 0..5 {
            let rotation = Rotation::from_quaternion(random.quaternion()).unwrap();
            let (turned, other) = f.rotated(&rotation).deringed_with(&DeringOptions::default());
            let difference = &turned - &g.rotated(&rotation);
            let part = (difference.dot(&difference) / g.dot(&g)).sqrt();
            assert!(part < 2e-3, "order {order}: {part} apart, {:?} {:?}", report.factors, other.factors);
        }
    }
}

#[test]
fn radiance_may_ring_where_its_irradiance_does_not() {
    let cosine = Zonal::clamped_cosine(5);
    let f = &ShVec::impulse(5, Dir::from_angles(0.5, 0.5), 1.0) + &ShVec::constant(5, 0.002);
    let for_irradiance = DeringOptions::default().method(DeringMethod::LeastChange).kernel(cosine.clone());
    let (g, report) = f.deringed_with(&for_irradiance);
    let (_, direct) = f.deringed_with(&DeringOptions::default());
    assert_eq!(report.outcome, DeringOutcome::Windowed, "the irradiance was negative");
    assert!(report.factors[1] > direct.factors[1] + 0.05, "{report:?} {direct:?}");
    let least = least_sampled(&g.convolved(&cosine));
    assert!(least >= -1e-6 * g.convolved(&cosine).mean(), "irradiance {least}");
    // Band 3 is not in irradiance: nothing is taken from it.
    assert_eq!(report.factors[3], 1.0, "{:?}", report.factors);
}

#[test]
fn what_has_no_positive_mean_is_left_and_named() {
    for order in [1, 3, 5] {
        for mean in [-1.0, 0.0] {
            let mut f = ShVec::<Rgb<f64>>::constant(order, Rgb::new(1.0, mean, 1.0));
            f[order * order - 1].g += if mean == 0.0 { 0.5 } else { 0.0 };
            if order == 1 && mean == 0.0 {
                f[0].g = -1e-9;
            }
            for method in METHODS {
                let (g, report) = f.deringed_with(&with(method));
                assert_eq!(report.outcome, DeringOutcome::MeanNotPositive { channel: 1 }, "order {order}, {mean}");
                assert_eq!(g, f, "order {order}, {method}");
            }
            if order <= 3 {
                let outcome = dering_in_place(f.coefficients_mut(), &quick()).outcome;
                assert_eq!(outcome, DeringOutcome::MeanNotPositive { channel: 1 }, "order {order}, fast path");
            }
        }
    }
}

#[test]
fn numbers_that_are_not_finite_are_left_and_named() {
    for bad in [f64::NAN, f64::INFINITY] {
        for order in [2, 3, 5] {
            let mut f = ShVec::<f64>::constant(order, 1.0);
            f[3] = bad;
            for method in METHODS {
                let (_, report) = f.deringed_with(&with(method));
                assert_eq!(report.outcome, DeringOutcome::NotFinite, "{bad} at order {order}, {method}");
            }
            if order <= 3 {
                assert_eq!(dering_in_place(f.coefficients_mut(), &quick()).outcome, DeringOutcome::NotFinite, "{bad}");
            }
        }
    }
}

#[test]
fn the_factors_do_not_depend_on_the_unit() {
    let mut random = Random::new(11);
    for order in [2, 3, 4, 6] {
        let sun = ShVec::<f64>::impulse(order, Dir::try_from(random.direction()).unwrap(), 1.0);
        let other = ShVec::<f64>::impulse(order, Dir::try_from(random.direction()).unwrap(), 0.4);
        let f = &sun + &other;
        let mut methods = vec![DeringMethod::LeastChange, DeringMethod::Family(WindowFamily::Hanning)];
        if order == 3 {
            methods.push(DeringMethod::Table);
        }
        let kernel = Zonal::clamped_cosine(order);
        for dering in methods.into_iter().map(|method| with(method).kernel(kernel.clone())) {
            let (_, expected) = f.deringed_with(&dering);
            assert_eq!(expected.outcome, DeringOutcome::Windowed, "order {order}, {dering:?}");
            for exponent in [-300, -165, -100, -80, -12, -6, 3, 6, 12, 80, 165, 290] {
                let mut g = f.clone();
                g *= 10.0_f64.powi(exponent);
                let (after, report) = g.deringed_with(&dering);
                assert_eq!(report.outcome, expected.outcome, "order {order}, 1e{exponent}, {dering:?}");
                let what = format!("order {order}, 1e{exponent}, {dering:?}: {report:?}");
                for (found, expected) in report.factors.iter().zip(&expected.factors) {
                    assert!((found - expected).abs() < 1e-9, "{what}");
                }
                let (found, gap) = (report.energy_removed, report.excess.unwrap_or(0.0));
                assert!((found - expected.energy_removed).abs() < 1e-9 && gap < 1e-3, "{what}");
                let irradiance_mean = PI * after.mean();
                assert!(report.after.iter().all(|min| min.lo >= -1e-6 * irradiance_mean), "{what}");
            }
        }
    }
}

#[test]
fn small_and_large_three_bands_are_deringed_as_others_are() {
    let f = ShVec::<f64>::impulse(3, Dir::X, 1.0).convolved(&Zonal::clamped_cosine(3));
    let mut expected = f.clone();
    let expected = dering_in_place(expected.coefficients_mut(), &quick());
    assert_eq!(expected.outcome, DeringOutcome::Windowed, "it rings");
    for exponent in [-300, -170, -100, -82, -80, 77, 100, 300] {
        let mut g = f.clone();
        g *= 10.0_f64.powi(exponent);
        let (bound, of_f) = (conservative_minimum(g.coefficients()), conservative_minimum(f.coefficients()));
        assert!((bound / 10.0_f64.powi(exponent) - of_f).abs() < 1e-9 * of_f.abs(), "1e{exponent}: {bound}");
        let found = dering_in_place(g.coefficients_mut(), &quick());
        assert_eq!(found.outcome, expected.outcome, "1e{exponent}");
        for (found, expected) in found.factors.iter().zip(&expected.factors) {
            assert!((found - expected).abs() < 1e-9, "1e{exponent}: {found} against {expected}");
        }
    }
}
