//! Zonal lobes fitted to transfer.

use crate::cloth::{cloth, with_threads};
use lobe_io::Job;
use lobe_prt::{Channels, Transfer, ZonalFitOptions, ZonalTransfer, fit_zonal};
use lobe_sh::{Dir, Expansion as _, Rgb, Rotation, ShVec, Zonal};
use lobe_testkit::{Random, directions};
use proptest::prelude::*;

fn options(lobes: usize) -> ZonalFitOptions {
    ZonalFitOptions::default().lobes(lobes)
}

fn light(order: usize, seed: u64) -> Vec<Rgb<f64>> {
    let mut random = Random::new(seed);
    (0..order * order).map(|_| Rgb::new(random.signed(), random.signed(), random.signed())).collect()
}

fn distance(a: Rgb<f32>, b: Rgb<f32>) -> f32 {
    (a.r - b.r).abs().max((a.g - b.g).abs()).max((a.b - b.b).abs())
}

#[test]
fn one_lobe_is_exact_for_unshadowed_transfer_in_closed_form() {
    let closed_form = options(1).optimize(false);
    for order in 2..=6 {
        let cosine = Zonal::clamped_cosine(order);
        let vectors = directions().into_iter().map(|n| cosine.towards(Dir::from_unit(n), 1.0));
        let coefficients: Vec<f32> = vectors.flat_map(|t| t.map(|c| c as f32).into_vec()).collect();
        let transfer = Transfer::new(order, Channels::Gray, coefficients).unwrap();
        for options in [closed_form, options(1)] {
            let (found, report) = fit_zonal(&transfer, &options, Job::default()).unwrap();
            assert!(report.worst_relative_error < 1e-6, "order {order}: {}", report.worst_relative_error);
            for (n, axis) in directions().into_iter().zip(found.axes()) {
                let angle = Dir::from_f32(*axis).unwrap().angle_to(Dir::from_unit(n));
                assert!(angle < 1e-5, "order {order}: {axis:?} for {n:?}");
            }
        }
    }
}

#[test]
fn planted_lobes_are_found_back() {
    let mut random = Random::new(7);
    let (mut worst, mut failed) = (0.0_f64, 0);
    for (order, lobes, channels) in [(4, 2, Channels::Gray), (5, 2, Channels::Rgb), (6, 3, Channels::Gray)] {
        let count = 40;
        let axes: Vec<[f32; 3]> = (0..count).flat_map(|_| apart(&mut random, lobes)).collect();
        let numbers = random.signed_vec(count * lobes * channels.count() * order);
        let coefficients: Vec<f32> = numbers.iter().map(|z| *z as f32).collect();
        let planted = ZonalTransfer::new(order, channels, lobes, axes, coefficients).unwrap();
        let transfer = planted.to_transfer();
        let (_, report) = fit_zonal(&transfer, &options(lobes), Job::default()).unwrap();
        for (r, error) in report.squared_errors.iter().enumerate() {
            let energy: f64 = planted.decode(r).iter().map(|x| f64::from(*x).powi(2)).sum();
            let relative = (error / energy).sqrt();
            worst = worst.max(relative);
            failed += usize::from(relative > 1e-3);
        }
        println!("order {order}, {lobes} lobes: {failed} so far not found, worst {worst}");
    }
    // A search from a few starts may end in another valley.
    assert!(failed <= 3, "{failed} of 120 not found, worst {worst}");
}

/// Directions at least 40° from each other and from each other's opposites.
fn apart(random: &mut Random, count: usize) -> Vec<[f32; 3]> {
    let mut found: Vec<[f64; 3]> = Vec::new();
    while found.len() < count {
        let d = random.direction();
        if found.iter().all(|e| (d[0] * e[0] + d[1] * e[1] + d[2] * e[2]).abs() < 0.766) {
            found.push(d);
        }
    }
    found.into_iter().map(|d| d.map(|x| x as f32)).collect()
}

#[test]
fn the_error_falls_with_every_lobe() {
    for (transfer, name) in [(cloth(12, 4, Channels::Gray), "gray"), (cloth(8, 3, Channels::Rgb), "color")] {
        for optimize in [false, true] {
            let mut before: Option<Vec<f64>> = None;
            for lobes in 1..=5 {
                let (_, report) = fit_zonal(&transfer, &options(lobes).optimize(optimize), Job::default()).unwrap();
                println!(
                    "{name}, {lobes} lobes, optimized {optimize}: {}, worst {}",
                    report.relative_error, report.worst_relative_error
                );
                if let Some(before) = &before {
                    for (r, (fewer, more)) in before.iter().zip(&report.squared_errors).enumerate() {
                        assert!(*more <= fewer + 1e-8, "{name}, receiver {r}, lobe {lobes}: {fewer} then {more}");
                    }
                }
                before = Some(report.squared_errors);
            }
        }
    }
}

#[test]
fn optimizing_is_never_worse_than_the_closed_form() {
    let transfer = cloth(12, 5, Channels::Gray);
    let closed_form = fit_zonal(&transfer, &options(1).optimize(false), Job::default()).unwrap().1;
    let optimized = fit_zonal(&transfer, &options(1), Job::default()).unwrap().1;
    for (r, (a, b)) in closed_form.squared_errors.iter().zip(&optimized.squared_errors).enumerate() {
        assert!(*b <= a + 1e-10, "receiver {r}: {a} in closed form, {b} optimized");
    }
    println!("closed form {}, optimized {}", closed_form.relative_error, optimized.relative_error);
    assert!(optimized.squared_error < closed_form.squared_error, "something is gained");
}

#[test]
fn turning_the_lobes_turns_the_expansion() {
    let mut random = Random::new(11);
    for (order, channels) in [(3, Channels::Rgb), (5, Channels::Gray)] {
        let (found, _) = fit_zonal(&cloth(6, order, channels), &options(2), Job::default()).unwrap();
        let rotations: Vec<Rotation> =
            (0..found.receivers()).map(|_| Rotation::from_quaternion(random.quaternion()).unwrap()).collect();
        let turned = found.rotated(|r| rotations[r]);
        let n = order * order;
        for r in 0..found.receivers() {
            for (c, (before, after)) in found.decode(r).chunks(n).zip(turned.decode(r).chunks(n)).enumerate() {
                let before = ShVec::from_vec(before.iter().map(|x| f64::from(*x)).collect()).unwrap();
                let expected = before.rotated(&rotations[r]);
                for (i, (a, b)) in expected.coefficients().iter().zip(after).enumerate() {
                    assert!((a - f64::from(*b)).abs() < 2e-6, "receiver {r}, channel {c}, {i}: {b} against {a}");
                }
            }
        }
        let light = light(order, 3);
        let mut moved = vec![Rgb::new(0.0, 0.0, 0.0); found.receivers()];
        found.exit_radiance_towards_into(turned.axes(), &light, &mut moved);
        assert_eq!(moved, turned.exit_radiance(&light), "axes handed in");
    }
}

#[test]
fn lobes_shade_as_their_expansion_does() {
    for (order, channels, lobes) in [(1, Channels::Gray, 1), (4, Channels::Gray, 3), (6, Channels::Rgb, 2)] {
        let (found, _) = fit_zonal(&cloth(13, order, channels), &options(lobes), Job::default()).unwrap();
        for light in [light(order, 1), light(2, 2)] {
            let shaded = found.exit_radiance(&light);
            for (r, (a, b)) in shaded.iter().zip(found.to_transfer().exit_radiance(&light)).enumerate() {
                assert!(distance(*a, b) < 1e-5, "order {order}, receiver {r}: {a:?} against {b:?}");
            }
        }
    }
}

#[test]
fn zero_constant_and_even_transfer_have_lobes() {
    let zero = Transfer::new(3, Channels::Gray, vec![0.0; 9]).unwrap();
    let mut constant = vec![0.0; 27];
    (constant[0], constant[9], constant[18]) = (1.0, 2.0, 3.0);
    let constant = Transfer::new(3, Channels::Rgb, constant).unwrap();
    // No linear part: x² - 1/3 has its lobe along x.
    let even = lobe_sh::project(3, 2, |s| s.x() * s.x() - 1.0 / 3.0).map(|c| c as f32);
    let even = Transfer::new(3, Channels::Gray, even.into_vec()).unwrap();
    for (transfer, name) in [(&zero, "zero"), (&constant, "constant"), (&even, "even")] {
        for lobes in [1, 2, 8] {
            let (found, report) = fit_zonal(transfer, &options(lobes), Job::default()).unwrap();
            assert!(report.squared_error < 1e-11, "{name}, {lobes} lobes: {report:?}");
            assert!(found.coefficients().iter().all(|z| z.abs() < 4.0), "{name}: {:?}", found.coefficients());
            if name != "even" {
                assert_eq!(found.axes()[0], [0.0, 0.0, 1.0], "{name}");
            }
        }
    }
    let nobody = Transfer::new(3, Channels::Gray, Vec::new()).unwrap();
    let (found, report) = fit_zonal(&nobody, &options(2), Job::default()).unwrap();
    assert_eq!((found.receivers(), report.squared_error), (0, 0.0), "no receivers");
}

#[test]
fn the_bytes_do_not_depend_on_the_number_of_threads() {
    let transfer = cloth(10, 4, Channels::Rgb);
    let fitted = |threads| with_threads(threads, || fit_zonal(&transfer, &options(2), Job::default()).unwrap());
    assert_eq!(fitted(1), fitted(3), "one and three threads");
}

#[test]
fn what_is_no_zonal_transfer_is_refused_in_one_line() {
    let transfer = Transfer::new(2, Channels::Gray, vec![1.0; 4]).unwrap();
    for lobes in [0, 9] {
        let refused = fit_zonal(&transfer, &options(lobes), Job::default()).unwrap_err().to_string();
        assert_eq!(refused, format!("expected 1 to 8 lobes, found {lobes}"), "lobes");
    }
    let made =
        |axes: Vec<[f32; 3]>, z: Vec<f32>| ZonalTransfer::new(2, Channels::Gray, 2, axes, z).unwrap_err().to_string();
    let axis = [0.0, 0.0, 1.0];
    assert_eq!(made(vec![axis], vec![]), "zonal transfer: expected 2 axes for each receiver, found 1 in all", "axes");
    let count = "zonal transfer: expected 2 coefficients for each of 2 axes, found 3 in all";
    assert_eq!(made(vec![axis; 2], vec![0.0; 3]), count, "coefficients");
    assert_eq!(
        made(vec![[0.0; 3]; 2], vec![0.0; 4]),
        "zonal transfer: expected unit axes, found [0.0, 0.0, 0.0]",
        "zero"
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn any_transfer_keeps_the_promises(
        values in prop::collection::vec(-1.0_f32..1.0, 32),
        lobes in 1_usize..5,
    ) {
        let transfer = Transfer::new(4, Channels::Gray, values.clone()).unwrap();
        let (fewer, more) = (fit_zonal(&transfer, &options(lobes), Job::default()).unwrap().1, fit_zonal(&transfer, &options(lobes + 1), Job::default()).unwrap().1);
        for r in 0..2 {
            prop_assert!(more.squared_errors[r] <= fewer.squared_errors[r] + 1e-6, "{fewer:?} then {more:?}");
            let energy: f64 = values[16 * r..16 * (r + 1)].iter().map(|x| f64::from(*x).powi(2)).sum();
            prop_assert!(fewer.squared_errors[r] <= energy + 1e-6, "{fewer:?} above all of it, {energy}");
        }
    }
}
